//! Flocks that grew as flocks do, and the rules of thumb by which transitions are chosen for them.
//!
//! Owns the making and the rules. Never balances.
//!
//! # Source
//! Few sheep are entered often and many hardly ever: in-degrees by Zipf's law, a quarter of the transitions by chance.

use std::collections::BTreeSet;

use flock::{Clip, ClipPath, Flock, FlockShares, Manifest, Sheep, SheepId, Structure, Transition};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use timing::{FrameCount, Rate};

/// Sheep of a flock, and transitions among them.
pub(crate) const SHEEP: usize = 200;
pub(crate) const TRANSITIONS: usize = 800;
/// By how much a sheep's rank makes it less likely to be entered.
const ZIPF: f64 = 0.9;
/// The part of the transitions that lead anywhere.
const ANYWHERE: f64 = 0.25;

/// Chance, from a seed.
pub(crate) struct Chance(ChaCha12Rng);

impl Chance {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha12Rng::seed_from_u64(seed))
    }

    fn part(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn below(&mut self, end: usize) -> usize {
        (self.part() * end as f64) as usize
    }
}

/// Pairs of sheep, by their numbers.
pub(crate) type Pairs = BTreeSet<(usize, usize)>;

/// A flock of [`SHEEP`] and [`TRANSITIONS`], all of it played. Those of an even `seed` are wished equally, others up to
/// nine times as often as others.
pub(crate) fn flock(seed: u64) -> (Pairs, Vec<f64>) {
    let mut chance = Chance::new(seed);
    let rank: Vec<f64> = (0..SHEEP)
        .scan(0.0, |all, at| {
            Some({
                *all += (at as f64 + 1.0).powf(-ZIPF);
                *all
            })
        })
        .collect();
    let popular = |chance: &mut Chance| {
        let at = chance.part() * rank[SHEEP - 1];
        rank.partition_point(|&below| below < at).min(SHEEP - 1)
    };
    let mut pairs = Pairs::new();
    let wants: Vec<f64> =
        (0..SHEEP).map(|_| if seed.is_multiple_of(2) { 1.0 } else { 9f64.powf(chance.part() - 0.5) }).collect();
    // A quarter is left to join what has not grown together.
    let mut grown = TRANSITIONS * 3 / 4;
    loop {
        while pairs.len() < grown {
            let from = if pairs.len() < SHEEP { pairs.len() } else { chance.below(SHEEP) };
            let to = if chance.part() < ANYWHERE { chance.below(SHEEP) } else { popular(&mut chance) };
            if from != to {
                pairs.insert((from, to));
            }
        }
        join(&mut pairs, &wants);
        if pairs.len() >= TRANSITIONS {
            assert_eq!(pairs.len(), TRANSITIONS, "flock {seed} has grown together with fewer");
            return (pairs, wants);
        }
        grown = TRANSITIONS;
    }
}

/// Joins the ends of what does not lead on to the starts of what nothing leads to, until all is one part.
fn join(pairs: &mut Pairs, wants: &[f64]) {
    loop {
        let flock = made(pairs, wants);
        let whole = flock.whole();
        let structure = Structure::of(whole);
        if structure.class_count() == 1 {
            return;
        }
        let (mut leads, mut led) = (vec![false; structure.class_count()], vec![false; structure.class_count()]);
        for &(from, to) in pairs.iter() {
            let class = |at: usize| structure.class_of(whole.find(&id(at)).expect("a sheep of the flock"));
            if class(from) != class(to) {
                (leads[class(from)], led[class(to)]) = (true, true);
            }
        }
        let class = |at: usize| structure.class_of(whole.find(&id(at)).expect("a sheep of the flock"));
        let last = (0..SHEEP).find(|&at| !leads[class(at)]).expect("some part leads nowhere");
        let first = (0..SHEEP)
            .find(|&at| !led[class(at)] && class(at) != class(last))
            .or_else(|| (0..SHEEP).find(|&at| class(at) != class(last)));
        pairs.insert((last, first.expect("there are two parts")));
    }
}

/// The flock of `pairs` in which sheep are wished as `wants` say.
pub(crate) fn made(pairs: &Pairs, wants: &[f64]) -> Flock {
    let clip = |path: String| {
        let path = ClipPath::new(&path).expect("a plain path is fine");
        Clip { path, frames: FrameCount(750), hash: None }
    };
    let sheep = |(at, want): (usize, &f64)| Sheep {
        id: id(at),
        clip: Some(clip(format!("{at}"))),
        genome: None,
        want: *want,
        repeat: 1,
    };
    let transition = |&(from, to): &(usize, usize)| Transition {
        from: id(from),
        to: id(to),
        clip: clip(format!("{from}={to}")),
        weight: 1.0,
    };
    Flock::new(Manifest {
        name: "grown".into(),
        size: (64, 64),
        fps: Rate::new(30, 1).expect("30 is a rate"),
        sheep: wants.iter().enumerate().map(sheep).collect(),
        transitions: pairs.iter().map(transition).collect(),
    })
}

/// Ids whose order is that of their numbers.
pub(crate) fn id(at: usize) -> SheepId {
    SheepId::new(&format!("{at:03}")).expect("digits are fine")
}

/// Draves's pairing: from the most sink-like sheep (entered more than left) to the most source-like one.
pub(crate) fn pairing(pairs: &Pairs, _: &[f64]) -> (usize, usize) {
    by(pairs, |into, out| into - out, |into, out| out - into)
}

/// His other pairing: the sheep with the fewest transitions, two by two.
pub(crate) fn loneliest(pairs: &Pairs, _: &[f64]) -> (usize, usize) {
    by(pairs, |into, out| -into - out, |into, out| -into - out)
}

/// From the sheep that is entered by most transitions to that which is entered by fewest.
pub(crate) fn degree(pairs: &Pairs, _: &[f64]) -> (usize, usize) {
    by(pairs, |into, _| into, |into, _| -into)
}

/// From the sheep that is shown most for its want to that which is shown least.
pub(crate) fn shown(pairs: &Pairs, wants: &[f64]) -> (usize, usize) {
    let flock = made(pairs, wants);
    let shares = FlockShares::of(&flock).expect("the flock can be walked");
    let ratio = |at: usize| shares.sheep[at].visits / shares.sheep[at].want;
    best(pairs, ratio, |at| -ratio(at))
}

/// Any pair.
pub(crate) fn random(pairs: &Pairs, chance: &mut Chance) -> (usize, usize) {
    loop {
        let pair = (chance.below(SHEEP), chance.below(SHEEP));
        if pair.0 != pair.1 && !pairs.contains(&pair) {
            return pair;
        }
    }
}

/// The new pair with the highest figures by transitions in and out: that of the start first.
fn by(pairs: &Pairs, start: impl Fn(i32, i32) -> i32, end: impl Fn(i32, i32) -> i32) -> (usize, usize) {
    let (mut into, mut out) = (vec![0; SHEEP], vec![0; SHEEP]);
    for &(from, to) in pairs {
        out[from] += 1;
        into[to] += 1;
    }
    best(pairs, |at| f64::from(start(into[at], out[at])), |at| f64::from(end(into[at], out[at])))
}

/// The new pair with the highest sum of its start's figure and its end's; of equal ones the first.
fn best(pairs: &Pairs, start: impl Fn(usize) -> f64, end: impl Fn(usize) -> f64) -> (usize, usize) {
    let all = (0..SHEEP).flat_map(|from| (0..SHEEP).map(move |to| (from, to)));
    let new = all.filter(|pair| pair.0 != pair.1 && !pairs.contains(pair));
    let sum = |pair: &(usize, usize)| start(pair.0) + end(pair.1);
    new.reduce(|a, b| if sum(&b) > sum(&a) { b } else { a }).expect("some pair is not linked")
}
