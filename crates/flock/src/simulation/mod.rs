//! Statistics of a long walk: actual and predicted shares, return times, repeats.
//!
//! Owns the figures of `dreams simulate` and of the walk's claims. Never walks itself but in [`Simulation::run`]; any
//! list of exits can be evaluated, also one of a memoryless walk. The bounds on random deviation are in `tally.rs`.

mod tally;

use std::collections::HashMap;
use std::sync::Arc;

use crate::flock::Flock;
use crate::graph::{Exit, SheepIx};
use crate::manifest::{Sheep, SheepId};
use crate::walk::Walk;
pub use tally::Tally;

/// Seconds in a minute.
const MINUTE_S: f64 = 60.0;

/// The figures of one walk.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Simulation {
    /// Visits of every sheep of the manifest, in the order of their ids.
    pub sheep: Vec<Visits>,
    /// How many sheep deviate from the prediction by more than their bounds: none, if the prediction is right.
    pub outside: usize,
    /// The worst of visits/want and want/visits, as fractions of all; `None` if a sheep was never visited.
    pub worst_ratio: Option<f64>,
    /// The shortest time from one visit's start to the next of the same sheep; `None` if none came back.
    pub min_return_minutes: Option<f64>,
    /// The 5th percentile of return times.
    pub p05_return_minutes: Option<f64>,
    /// The mean of all returns.
    pub mean_return_minutes: Option<f64>,
    /// The largest difference, at any moment, between a sheep's actual and expected visits.
    pub most_off: f64,
    /// When runs of steps were first repeated.
    pub first_repeat: FirstRepeat,
    /// The length of the longest repeated run, in steps.
    pub longest_repeat: usize,
    /// How long it all takes to show.
    pub minutes: f64,
}

/// How often a sheep was visited.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Visits {
    /// Which.
    pub id: SheepId,
    /// The fraction of all visits; those of all sheep sum to 1.
    pub visits: f64,
    /// The visits themselves, the walk's first one included.
    pub count: u64,
    /// The fraction that the shares predict; 0 if it is not played.
    pub predicted: f64,
    /// The bound on random deviation, four standard deviations; `None` with too few steps.
    pub bound: Option<f64>,
}

impl Visits {
    /// Whether the deviation is within its bound.
    pub fn is_within(&self) -> bool {
        self.bound.is_none_or(|bound| (self.visits - self.predicted).abs() <= bound)
    }
}

/// The step at which a run of 2, 3 or 4 was first repeated; `None` if none was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct FirstRepeat {
    /// Runs of two steps.
    pub k2: Option<usize>,
    /// Runs of three steps.
    pub k3: Option<usize>,
    /// Runs of four steps.
    pub k4: Option<usize>,
}

impl Simulation {
    /// Walks `steps` steps from `seed`. `None` if `flock` cannot be walked.
    pub fn run(flock: &Arc<Flock>, seed: u64, steps: usize) -> Option<Self> {
        let mut walk = Walk::start(Arc::clone(flock), seed).filter(|_| flock.is_walkable())?;
        let start = walk.place();
        let exits: Vec<Exit> = (0..steps).map_while(|_| walk.step()).map(|step| step.exit).collect();
        Some(Self::of(flock, start, &exits))
    }

    /// The figures of the walk that starts at `start` and takes `exits`.
    pub fn of(flock: &Flock, start: SheepIx, exits: &[Exit]) -> Self {
        let graph = flock.graph();
        let mut log = WalkRecord::new(flock, exits.len() as u64 + 1);
        log.visit(flock, start);
        for &exit in exits {
            log.elapsed_s += flock.seconds(&flock.transition(exit).clip);
            log.visit(flock, graph.target(exit));
        }
        log.settle(flock);
        log.returns_s.sort_by(f64::total_cmp);
        let returns = &log.returns_s;
        let minutes = |s: f64| s / MINUTE_S;
        let mean = returns.iter().sum::<f64>() / returns.len() as f64;
        let sheep = visits_by_id(flock, &log.tally);
        Self {
            outside: sheep.iter().filter(|sheep| !sheep.is_within()).count(),
            worst_ratio: worst_ratio(flock, &log.tally),
            min_return_minutes: returns.first().copied().map(minutes),
            p05_return_minutes: returns.get(returns.len() / 20).copied().map(minutes),
            mean_return_minutes: (!returns.is_empty()).then(|| minutes(mean)),
            most_off: log.most_off,
            first_repeat: FirstRepeat {
                k2: first_repeat(exits, 2),
                k3: first_repeat(exits, 3),
                k4: first_repeat(exits, 4),
            },
            longest_repeat: longest_repeat(exits),
            minutes: minutes(log.elapsed_s),
            sheep,
        }
    }
}

/// The record of a walk, by the ordinals of the part that is played.
struct WalkRecord {
    elapsed_s: f64,
    tally: Tally,
    /// When each sheep's last visit began, and which visit of all it was.
    last: Vec<Option<(f64, u64)>>,
    returns_s: Vec<f64>,
    most_off: f64,
}

impl WalkRecord {
    fn new(flock: &Flock, steps: u64) -> Self {
        let n = flock.graph().len();
        let (tally, last) = (Tally::new(n, steps), vec![None; n]);
        Self { elapsed_s: 0.0, tally, last, returns_s: Vec::new(), most_off: 0.0 }
    }

    fn visit(&mut self, flock: &Flock, sheep: SheepIx) {
        // A sheep is furthest behind just before a visit and furthest ahead just after.
        self.look(flock, sheep);
        let at = sheep.index();
        if let Some((then_s, _)) = self.last[at] {
            self.returns_s.push(self.elapsed_s - then_s);
        }
        self.last[at] = Some((self.elapsed_s, self.tally.steps()));
        self.tally.visit(sheep);
        self.look(flock, sheep);
        self.elapsed_s += flock.visit_seconds(sheep);
    }

    fn look(&mut self, flock: &Flock, sheep: SheepIx) {
        let due = self.tally.steps() as f64 * flock.share(sheep);
        self.most_off = self.most_off.max((due - self.tally.visits(sheep) as f64).abs());
    }

    fn settle(&mut self, flock: &Flock) {
        for sheep in flock.graph().sheep() {
            self.look(flock, sheep);
        }
    }
}

/// Visits of all sheep of the manifest: those outside the part that is played have none.
fn visits_by_id(flock: &Flock, tally: &Tally) -> Vec<Visits> {
    let total = tally.steps() as f64;
    let bounds = tally.bounds(|sheep| flock.share(sheep));
    let visits = |sheep: &Sheep| {
        let played = flock.graph().find(&sheep.id);
        let count = played.map_or(0, |at| tally.visits(at));
        let bound = played.map_or(0.0, |at| bounds[at.index()] / total);
        Visits {
            id: sheep.id.clone(),
            visits: count as f64 / total,
            count,
            predicted: played.map_or(0.0, |at| flock.share(at)),
            bound: Some(bound).filter(|bound| bound.is_finite()),
        }
    };
    let mut all: Vec<Visits> = flock.manifest().sheep.iter().map(visits).collect();
    all.sort_by(|a, b| a.id.cmp(&b.id));
    all.dedup_by(|a, b| a.id == b.id);
    all
}

fn worst_ratio(flock: &Flock, tally: &Tally) -> Option<f64> {
    let wants: f64 = flock.manifest().sheep.iter().map(|sheep| sheep.want).sum();
    let ratio = |sheep: &Sheep| {
        let had = flock.graph().find(&sheep.id).map_or(0, |at| tally.visits(at));
        let ratio = (had as f64 / tally.steps() as f64) / (sheep.want / wants);
        ratio.max(1.0 / ratio)
    };
    let worst = flock.manifest().sheep.iter().map(ratio).fold(1.0, f64::max);
    worst.is_finite().then_some(worst)
}

/// After how many steps a run of `length` was complete that had been walked before.
fn first_repeat(exits: &[Exit], length: usize) -> Option<usize> {
    let mut seen = std::collections::HashSet::new();
    exits.windows(length).position(|run| !seen.insert(run)).map(|at| at + length)
}

/// The length of the longest run that occurs twice in `exits`, overlaps included.
fn longest_repeat(exits: &[Exit]) -> usize {
    // If a run is repeated, so are its prefixes: binary search is possible.
    let (mut comes, mut lacks) = (0, exits.len().max(1));
    while lacks - comes > 1 {
        let middle = usize::midpoint(comes, lacks);
        if repeats(exits, middle) { comes = middle } else { lacks = middle }
    }
    comes
}

/// Whether a run of `length` occurs twice.
fn repeats(exits: &[Exit], length: usize) -> bool {
    const BASE: u64 = 0xD134_2543_DE82_EF95;
    let code = |exit: Exit| (u64::from(exit.0) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xBF58_476D_1CE4_E5B9;
    let top = (1..length).fold(1u64, |power, _| power.wrapping_mul(BASE));
    let mut starts: HashMap<u64, usize> = HashMap::new();
    let mut sum = exits[..length].iter().fold(0u64, |sum, &exit| sum.wrapping_mul(BASE).wrapping_add(code(exit)));
    for start in 0..=exits.len() - length {
        if start > 0 {
            let left = sum.wrapping_sub(code(exits[start - 1]).wrapping_mul(top));
            sum = left.wrapping_mul(BASE).wrapping_add(code(exits[start + length - 1]));
        }
        // The rolling hash only finds candidates, which are compared.
        if let Some(earlier) = starts.insert(sum, start)
            && exits[earlier..earlier + length] == exits[start..start + length]
        {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_longest_repeat_is_what_comparing_all_pairs_finds(
            exits in prop::collection::vec((0u32..3).prop_map(Exit), 0..60),
        ) {
            let common = |a: usize, b: usize| (0..exits.len() - b).take_while(|i| exits[a + i] == exits[b + i]).count();
            let pairs = (0..exits.len()).flat_map(|a| (a + 1..exits.len()).map(move |b| (a, b)));
            let longest = pairs.map(|(a, b)| common(a, b)).max().unwrap_or(0);
            prop_assert_eq!(longest_repeat(&exits), longest);
        }
    }
}
