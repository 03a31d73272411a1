//! The claims of the walk, for a trip of any length.
//!
//! Owns the flocks they are tried on, the memoryless walk they are held against, and the judgement. Included by the
//! year (`main.rs`) and by the short run of the tests (`tests/claims.rs`), so that both try the same.

use std::sync::Arc;

use flock::{
    Clip, ClipKind, ClipPath, Exit, Flock, Itinerary, Manifest, Place, Sheep, SheepId, Simulation, Transition,
};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use timing::{FrameCount, Rate};

/// Sheep of the flocks, and transitions from each.
const SHEEP: usize = 200;
const EXITS: usize = 4;
/// Frames of every clip: 25 s at 30 per second, so that a step takes 50 s.
const FRAMES: u32 = 750;
/// Steps of an hour.
const HOUR: usize = 72;
/// Claim 1: a sheep's visits stay within so many of its due.
const MOST_OFF: f64 = 20.0;
/// Claim 2: the 5th percentile of return times is at least this part of the mean.
const EARLIEST: f64 = 0.25;

/// How the weights of a flock's transitions are drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Weights {
    /// All 1.
    Equal,
    /// Between 1/4 and 1.
    Mixed,
}

/// Where a walk went.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Trip {
    /// The first sheep.
    pub(crate) start: SheepId,
    /// Every step.
    pub(crate) exits: Vec<Exit>,
}

/// A flock of 200 sheep with 4 transitions each, drawn from `seed`.
pub(crate) fn flock(seed: u64, weights: Weights) -> Arc<Flock> {
    let mut random = ChaCha12Rng::seed_from_u64(seed);
    let id = |at: usize| SheepId::new(&format!("{at}")).expect("digits are fine");
    let clip = |path: String| {
        let path = ClipPath::new(&path).expect("a plain path is fine");
        Clip { path, frames: FrameCount(FRAMES), hash: None }
    };
    let sheep = |at| Sheep { id: id(at), clip: Some(clip(format!("{at}"))), genome: None, want: 1.0, repeat: 1 };
    let mut transitions = Vec::new();
    for from in 0..SHEEP {
        // A ring holds the flock together; the other targets are chance.
        let mut targets = vec![(from + 1) % SHEEP];
        while targets.len() < EXITS {
            let to = (random.next_u64() % SHEEP as u64) as usize;
            if to != from && !targets.contains(&to) {
                targets.push(to);
            }
        }
        for to in targets {
            let weight = match weights {
                Weights::Equal => 1.0,
                Weights::Mixed => 0.25 + 0.75 * unit(&mut random),
            };
            transitions.push(Transition { from: id(from), to: id(to), clip: clip(format!("{from}={to}")), weight });
        }
    }
    Arc::new(Flock::new(Manifest {
        name: format!("claims {seed}"),
        size: (64, 64),
        fps: Rate::new(30, 1).expect("30 is a rate"),
        sheep: (0..SHEEP).map(sheep).collect(),
        transitions,
    }))
}

/// The unit's walk, saved to bytes and restored `restarts` times at moments drawn by chance.
pub(crate) fn steered(flock: &Arc<Flock>, seed: u64, steps: usize, restarts: usize) -> Trip {
    let mut moments = ChaCha12Rng::seed_from_u64(seed);
    let mut at: Vec<usize> = (0..restarts).map(|_| (moments.next_u64() % steps as u64) as usize).collect();
    at.sort_unstable();
    at.dedup();
    let (mut at, mut path) = (at.into_iter().peekable(), Itinerary::start(Arc::clone(flock), seed));
    let (mut start, mut exits) = (None, Vec::with_capacity(steps));
    while exits.len() < steps {
        if at.next_if(|&moment| moment <= exits.len()).is_some() {
            let bytes = path.next_leg().expect("a walk has no end").place.to_bytes();
            let place = Place::from_bytes(&bytes).expect("a place reads back");
            path = Itinerary::resume(Arc::clone(flock), &place).expect("the flock is the same");
        }
        match path.next_clip().expect("a walk has no end").what {
            ClipKind::Loop { sheep } => start = start.or(Some(sheep)),
            ClipKind::Transition { from, to } => {
                let graph = flock.graph();
                let sheep = |id| graph.find(id).expect("a walk stays in its flock");
                exits.push(graph.between(sheep(&from), sheep(&to)).expect("a walk takes transitions"));
            }
        }
    }
    Trip { start: start.expect("a walk starts with a visit"), exits }
}

/// A walk that only throws dice.
pub(crate) fn memoryless(flock: &Flock, seed: u64, steps: usize) -> Trip {
    let mut random = ChaCha12Rng::seed_from_u64(seed);
    let graph = flock.graph();
    let mut place = graph.sheep().next().expect("a flock has sheep");
    let start = flock.id(place).clone();
    let mut exits = Vec::with_capacity(steps);
    for _ in 0..steps {
        let mut left = unit(&mut random);
        let fell = |exit: &Exit| {
            left -= graph.chance(*exit);
            left < 0.0
        };
        let exit = graph.exits(place).find(fell).or(graph.exits(place).last()).expect("every sheep has exits");
        exits.push(exit);
        place = graph.target(exit);
    }
    Trip { start, exits }
}

/// The figures of a trip.
pub(crate) fn figures(flock: &Flock, trip: &Trip) -> Simulation {
    Simulation::of(flock, flock.graph().find(&trip.start).expect("a walk stays in its flock"), &trip.exits)
}

/// The 5th percentile of return times as a part of their mean.
pub(crate) fn earliest(figures: &Simulation) -> f64 {
    figures.p05_return_minutes.zip(figures.mean_return_minutes).map_or(0.0, |(early, mean)| early / mean)
}

/// The claims that `figures` break.
pub(crate) fn broken(figures: &Simulation) -> Vec<String> {
    let mut broken = Vec::new();
    if figures.most_off > MOST_OFF {
        broken.push(format!("a sheep was {:.1} visits off its due, at most {MOST_OFF}", figures.most_off));
    }
    if earliest(figures) < EARLIEST {
        broken.push(format!("returns come at {:.3} of their mean, at least {EARLIEST}", earliest(figures)));
    }
    if figures.longest_repeat >= HOUR {
        broken.push(format!("{} steps came twice in a row, at most {}", figures.longest_repeat, HOUR - 1));
    }
    broken
}

/// A number from 0 up to 1.
fn unit(random: &mut ChaCha12Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}
