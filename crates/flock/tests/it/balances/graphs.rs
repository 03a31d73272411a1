//! Flocks of every shape that `dreams check` passes, by chance.
//!
//! Owns the making: shapes, weights, wants and repeats are drawn independently, so that every kind of each meets every
//! kind of the others. Never balances.
//!
//! Start at [`flock`].

use std::collections::BTreeMap;

use flock::{Clip, ClipPath, Flock, Manifest, Sheep, SheepId, Transition};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use timing::{FrameCount, Rate};

/// How many kinds of shapes there are.
const SHAPES: usize = 8;

/// Chance, from a seed.
pub(crate) struct Chance(ChaCha12Rng);

impl Chance {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha12Rng::seed_from_u64(seed))
    }

    /// In `0.0..1.0`.
    pub(crate) fn part(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// In `0..end`.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        (self.part() * end as f64) as usize
    }

    /// Ten to the power of something within `decades` around 0.
    fn magnitude(&mut self, decades: f64) -> f64 {
        10f64.powf(decades * (self.part() - 0.5))
    }

    pub(crate) fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }
}

/// The flock number `number`: without faults, of 1 to 16 sheep. Half of all can be balanced for certain.
pub(crate) fn flock(number: u64) -> Flock {
    let mut chance = Chance::new(number);
    let (n, mut arcs) = shape(&mut chance);
    weigh(&mut chance, &mut arcs);
    let mut manifest = manifest(n, &arcs);
    for sheep in &mut manifest.sheep {
        sheep.repeat = chance.of(&[1, 1, 1, 2, 7]);
        sheep.clip = sheep.clip.take().filter(|_| chance.below(5) > 0);
    }
    let wants = wants(&mut chance, n, &manifest);
    for (sheep, want) in manifest.sheep.iter_mut().zip(wants) {
        sheep.want = want;
    }
    let flock = Flock::new(manifest);
    assert!(flock.faults().is_empty(), "flock {number} passes `dreams check`");
    flock
}

type Arcs = BTreeMap<(usize, usize), f64>;

/// So many sheep, and transitions that make one part of them: a shape, and often some more.
fn shape(chance: &mut Chance) -> (usize, Arcs) {
    let kind = chance.below(SHAPES);
    let n = if kind == 0 { 1 } else { 2 + chance.below(15) };
    let mut arcs = Arcs::new();
    let mut link = |from: usize, to: usize| {
        arcs.insert((from % n, to % n), 1.0);
    };
    match kind {
        // A single sheep, a ring, a necklace both ways.
        0 | 1 => (0..n).for_each(|at| link(at, at + 1)),
        2 => (0..n).for_each(|at| {
            link(at, (at + 1).min(n - 1));
            link(at, at.saturating_sub(1));
        }),
        // A hub with leaves.
        3 => (1..n).for_each(|at| {
            link(0, at);
            link(at, 0);
        }),
        // All to all.
        4 => (0..n * n).for_each(|at| link(at / n, at % n)),
        // Groups that are visited in turn: periodic.
        5 => {
            let beat = 2 + chance.below(n.min(4));
            for from in 0..n {
                (0..n).filter(|to| (from + 1) % beat == to % beat).for_each(|to| link(from, to));
            }
        }
        // A ring with chords.
        _ => {
            (0..n).for_each(|at| link(at, at + 1));
            (0..chance.below(3 * n)).for_each(|_| link(chance.below(n), chance.below(n)));
        }
    }
    // Groups of which some are empty are joined by a ring; some sheep get transitions to themselves.
    if kind == 5 && Flock::new(manifest(n, &arcs)).graph().len() < n {
        arcs.extend((0..n).map(|at| ((at, (at + 1) % n), 1.0)));
    }
    for _ in 0..chance.of(&[0, 0, 1, 3]) {
        let at = chance.below(n);
        arcs.insert((at, at), 1.0);
    }
    (n, arcs)
}

/// Weights: equal, mixed, over nine orders of magnitude, nearly splitting the flock, or as far apart as numbers are.
fn weigh(chance: &mut Chance, arcs: &mut Arcs) {
    let kind = chance.below(6);
    for ((from, to), weight) in arcs {
        *weight = match kind {
            2 => chance.magnitude(1.0),
            3 => chance.magnitude(9.0),
            4 if (from % 2) != (to % 2) => 1e-12 * chance.magnitude(1.0),
            5 => chance.magnitude(400.0),
            _ => 1.0,
        };
    }
}

/// Wants: equal, mixed, over nine orders of magnitude, all but nothing for some, or what some weights reach.
fn wants(chance: &mut Chance, n: usize, manifest: &Manifest) -> Vec<f64> {
    match chance.below(10) {
        0 | 1 => vec![1.0; n],
        2 => (0..n).map(|_| chance.magnitude(1.0)).collect(),
        3 => (0..n).map(|_| chance.magnitude(9.0)).collect(),
        4 => (0..n).map(|_| chance.of(&[1.0, 1.0, 1e-300, 1e300])).collect(),
        kind => {
            let mut reached = manifest.clone();
            let decades = if kind == 5 { 9.0 } else { 2.0 };
            reached.transitions.iter_mut().for_each(|transition| transition.weight = chance.magnitude(decades));
            let flock = Flock::new(reached);
            flock.graph().sheep().map(|sheep| flock.share(sheep)).collect()
        }
    }
}

/// Sheep are called so that their ids are in the order of their numbers.
fn manifest(n: usize, arcs: &Arcs) -> Manifest {
    let id = |at: usize| SheepId::new(&format!("s{at:02}")).unwrap();
    let clip = |path: String| Clip { path: ClipPath::new(&path).unwrap(), frames: FrameCount(750), hash: None };
    let sheep = |at: usize| Sheep { id: id(at), clip: Some(clip(format!("{at}"))), genome: None, want: 1.0, repeat: 1 };
    let transition = |(&(from, to), &weight): (&(usize, usize), &f64)| Transition {
        from: id(from),
        to: id(to),
        clip: clip(format!("{from}={to}")),
        weight,
    };
    Manifest {
        name: "chance".into(),
        size: (64, 64),
        fps: Rate::new(30, 1).unwrap(),
        sheep: (0..n).map(sheep).collect(),
        transitions: arcs.iter().map(transition).collect(),
    }
}
