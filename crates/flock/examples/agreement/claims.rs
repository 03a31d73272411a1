//! Shares against walks: the flocks, the walks and the judgement.
//!
//! Owns what is claimed of 100 random flocks for walks of any length. Included by the whole run (`main.rs`, 10,000,000
//! steps each) and by the short one of the tests (`tests/claims.rs`), so that both try the same.
//!
//! What the shares have to agree with. Shares are those of any walk that takes each transition with its chance in the long
//! run. A *memoryless* walk does so by throwing dice: it knows nothing of shares, so it is the independent witness. Its
//! error is the textbook's: normal, growing with the square root of the steps, with a variance that follows from the
//! chances (Kemeny & Snell, *Finite Markov Chains*, 1960). The unit's own *steered* walk is what is shipped. It does look
//! at the shares, but only to choose among exits whose credit allows them; the ledger binds it to the chances whatever the
//! shares say, so wrong shares would show as visits that drift off. Its error does not grow, so its bound, taken from the
//! walk itself (`flock::Tally`), is hundreds of times narrower. Both bounds are four standard deviations.
//!
//! Of 5,000 sheep one lies outside four standard deviations by chance in every third run, and often takes its neighbours
//! along: the sheep of one half of a flock come and go together. So the claim is on flocks: no more than two of a hundred
//! have a sheep outside, and none has one far outside; and the errors of the memoryless walks have the size that the
//! bounds say, since bounds that are too wide would prove nothing.

use std::ops::Range;
use std::sync::Arc;

use flock::{Clip, ClipPath, Flock, Manifest, Sheep, SheepId, SheepIx, Tally, Transition, Walk};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use timing::{FrameCount, Rate};

/// How many flocks.
pub(crate) const FLOCKS: u64 = 100;
/// How large the errors of each walk are, in standard deviations. What a steered walk is ahead counts in its bound too.
pub(crate) const MEMORYLESS: Range<f64> = 0.8..1.2;
pub(crate) const STEERED: Range<f64> = 0.5..2.5;

/// Errors of all sheep of several flocks, each as a part of its bound.
#[derive(Debug, Default)]
pub(crate) struct Errors {
    parts: Vec<f64>,
    flocks: usize,
    /// Flocks with a sheep further off than its bound.
    pub(crate) outside: usize,
    /// Sheep of which the walk was too short to tell.
    untold: usize,
    /// The most visits that a sheep was off its due, and its bound then.
    pub(crate) most: (f64, f64),
}

/// A flock of 20 to 80 sheep, drawn from `seed`. Every fourth has a beat of 2 to 4, every fourth falls into two halves
/// that a chance of about a hundredth joins.
pub(crate) fn flock(seed: u64) -> Arc<Flock> {
    let mut random = ChaCha12Rng::seed_from_u64(seed);
    let mut below = |n: usize| (random.next_u64() % n as u64) as usize;
    let beat = if seed % 4 == 1 { 2 + below(3) } else { 1 };
    let is_split = seed % 4 == 2;
    let n = (20 + below(61)) / (2 * beat) * 2 * beat;
    let mut arcs: Vec<(usize, usize)> = Vec::new();
    for from in 0..n {
        let half = if is_split { n / 2 } else { n };
        let first = from / half * half;
        arcs.push((from, first + (from + 1) % half));
        for _ in 0..=below(4) {
            let to = first + (from - first + 1 + beat * below(half / beat)) % half;
            arcs.push((from, to));
        }
    }
    arcs.sort_unstable();
    arcs.dedup();
    let mut transitions: Vec<_> =
        arcs.into_iter().map(|(from, to)| (from, to, 0.1 + below(1000) as f64 / 100.0)).collect();
    if is_split {
        transitions.extend([(0, n / 2, 0.2), (n / 2 + 1, 1, 0.2)]);
    }
    made(n, &transitions)
}

fn made(n: usize, transitions: &[(usize, usize, f64)]) -> Arc<Flock> {
    let id = |at: usize| SheepId::new(&format!("{at:02}")).expect("digits are fine");
    let clip = Clip { path: ClipPath::new("clip").expect("a plain path is fine"), frames: FrameCount(750), hash: None };
    let sheep = |at| Sheep { id: id(at), clip: Some(clip.clone()), genome: None, want: 1.0, repeat: 1 };
    let transition = |&(from, to, weight): &(usize, usize, f64)| Transition {
        from: id(from),
        to: id(to),
        clip: clip.clone(),
        weight,
    };
    Arc::new(Flock::new(Manifest {
        name: "agreement".into(),
        size: (64, 64),
        fps: Rate::new(30, 1).expect("30 is a rate"),
        sheep: (0..n).map(sheep).collect(),
        transitions: transitions.iter().map(transition).collect(),
    }))
}

/// Visits of a walk that only throws dice.
pub(crate) fn memoryless(flock: &Flock, seed: u64, steps: u64) -> Tally {
    let graph = flock.graph();
    let mut random = ChaCha12Rng::seed_from_u64(!seed);
    let sums = |sheep: SheepIx| {
        let mut sum = 0.0;
        let exits = graph.exits(sheep).map(|exit| {
            sum += graph.chance(exit);
            (sum, graph.target(exit))
        });
        exits.collect::<Vec<_>>()
    };
    let exits: Vec<_> = graph.sheep().map(sums).collect();
    let mut tally = Tally::new(graph.len(), steps);
    let mut place = graph.sheep().next().expect("a flock has sheep");
    for _ in 0..steps {
        let fell = (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        let exits = &exits[place.index()];
        let exit = exits.iter().find(|&&(sum, _)| fell < sum).or(exits.last());
        place = exit.expect("every sheep has exits").1;
        tally.visit(place);
    }
    tally
}

/// Visits of the unit's own walk.
pub(crate) fn steered(flock: &Arc<Flock>, seed: u64, steps: u64) -> Tally {
    let mut walk = Walk::start(Arc::clone(flock), seed).expect("a flock has sheep");
    let mut tally = Tally::new(flock.graph().len(), steps);
    for _ in 0..steps {
        tally.visit(walk.step().expect("a walk has no end").to);
    }
    tally
}

/// How far a memoryless walk of `steps` steps may be from the due of each sheep: four standard deviations, in visits.
pub(crate) fn memoryless_bounds(flock: &Flock, steps: u64) -> Vec<f64> {
    let graph = flock.graph();
    let n = graph.len();
    // The fundamental matrix, the inverse of I - P + 1 pi, by elimination beside the unit matrix.
    let mut rows: Vec<Vec<f64>> = vec![vec![0.0; 2 * n]; n];
    for from in graph.sheep() {
        let row = &mut rows[from.index()];
        graph.sheep().for_each(|to| row[to.index()] = flock.share(to));
        row[from.index()] += 1.0;
        row[n + from.index()] = 1.0;
        graph.exits(from).for_each(|exit| row[graph.target(exit).index()] -= graph.chance(exit));
    }
    for column in 0..n {
        let largest = |&a: &usize, &b: &usize| rows[a][column].abs().total_cmp(&rows[b][column].abs());
        let pivot = (column..n).max_by(largest).expect("there are rows left");
        rows.swap(column, pivot);
        let pivot = rows[column].clone();
        for (at, row) in rows.iter_mut().enumerate() {
            let factor = if at == column { 1.0 - 1.0 / pivot[column] } else { row[column] / pivot[column] };
            row.iter_mut().zip(&pivot).for_each(|(entry, pivot)| *entry -= factor * pivot);
        }
    }
    let bound = |sheep: SheepIx| {
        let share = flock.share(sheep);
        let variance = share * (2.0 * rows[sheep.index()][n + sheep.index()] - 1.0 - share);
        4.0 * (variance.max(0.0) * steps as f64).sqrt() + 1.0
    };
    graph.sheep().map(bound).collect()
}

/// The bounds of a steered walk, in visits; infinite where it is too short to tell.
pub(crate) fn steered_bounds(flock: &Flock, tally: &Tally) -> Vec<f64> {
    tally.bounds(|sheep| flock.share(sheep))
}

impl Errors {
    /// Adds those of a walk on `flock`, against the bounds of its sheep.
    pub(crate) fn add(&mut self, flock: &Flock, tally: &Tally, bounds: &[f64]) {
        let mut is_outside = false;
        let told = |(_, bound): &(SheepIx, &f64)| bound.is_finite();
        for (sheep, &bound) in flock.graph().sheep().zip(bounds).filter(told) {
            let off = tally.visits(sheep) as f64 - tally.steps() as f64 * flock.share(sheep);
            if off.abs() > self.most.0 {
                self.most = (off.abs(), bound);
            }
            is_outside |= off.abs() > bound;
            self.parts.push(off / bound);
        }
        self.flocks += 1;
        self.outside += usize::from(is_outside);
        self.untold += bounds.iter().filter(|bound| bound.is_infinite()).count();
    }

    /// How many sheep there are.
    pub(crate) fn sheep(&self) -> usize {
        self.parts.len()
    }

    /// The worst, in bounds.
    pub(crate) fn worst(&self) -> f64 {
        self.parts.iter().map(|part| part.abs()).fold(0.0, f64::max)
    }

    /// The size of the errors, in standard deviations: their root mean square, four to a bound.
    pub(crate) fn sigmas(&self) -> f64 {
        4.0 * (self.parts.iter().map(|part| part * part).sum::<f64>() / self.parts.len() as f64).sqrt()
    }

    /// The claims that they break, of walks whose errors are of the given size, in standard deviations.
    pub(crate) fn broken(&self, sizes: Range<f64>) -> Vec<String> {
        let mut broken = Vec::new();
        if self.untold > 2 {
            broken.push(format!("the walks are too short to tell of {} sheep, at most 2", self.untold));
        }
        if self.outside > 2 {
            broken.push(format!(
                "{} of {} flocks, {} sheep, have one outside, at most 2",
                self.outside,
                self.flocks,
                self.sheep()
            ));
        }
        if self.worst() > 1.5 {
            broken.push(format!("a sheep is {:.2} bounds off, at most 1.5", self.worst()));
        }
        if !sizes.contains(&self.sigmas()) {
            broken.push(format!("errors are {:.2} standard deviations, should be in {sizes:?}", self.sigmas()));
        }
        broken
    }
}
