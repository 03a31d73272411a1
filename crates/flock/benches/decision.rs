//! What one decision of the walk costs.
//!
//! Owns the measurement: one JSON line per flock on stdout, medians of five runs. Exits with 1 if a decision takes 10 us
//! or more at 1,000 sheep, or 100 us or more at 100,000.
#![allow(clippy::print_stdout, reason = "the figures are this program's answer")]

use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use flock::{Clip, ClipPath, Flock, Manifest, Sheep, SheepId, Transition, Walk};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use timing::{FrameCount, Rate};

/// Sheep, transitions from each, and what a decision may cost.
const CASES: [(usize, usize, u64); 3] = [(1_000, 4, 10_000), (100_000, 4, 100_000), (100_000, 10, 100_000)];
/// Decisions of one run, and runs.
const DECISIONS: u32 = 20_000;
const RUNS: usize = 5;

fn main() -> ExitCode {
    let sound = CASES.map(|(sheep, exits, limit_ns)| {
        let ns = median_ns(sheep, exits);
        println!(r#"{{"bench":"decision","sheep":{sheep},"exits":{exits},"ns":{ns},"limit_ns":{limit_ns}}}"#);
        ns < limit_ns
    });
    if sound.iter().all(|&held| held) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

#[expect(clippy::disallowed_methods, reason = "a bench reads the clock")]
fn median_ns(sheep: usize, exits: usize) -> u64 {
    let mut walk = Walk::start(flock(sheep, exits), 1).expect("the flock can be walked");
    let mut runs = [(); RUNS].map(|()| {
        let start = Instant::now();
        for _ in 0..DECISIONS {
            walk.step().expect("every sheep has exits");
        }
        start.elapsed().as_nanos() as u64 / u64::from(DECISIONS)
    });
    runs.sort_unstable();
    runs[RUNS / 2]
}

/// A ring of `sheep` with chance targets besides, `exits` from each.
fn flock(sheep: usize, exits: usize) -> Arc<Flock> {
    let mut random = ChaCha12Rng::seed_from_u64(1);
    let id = |at: usize| SheepId::new(&format!("{at}")).expect("digits are fine");
    let path = ClipPath::new("clip").expect("a plain path is fine");
    let clip = Clip { path, frames: FrameCount(1), hash: None };
    let mut transitions = Vec::new();
    for from in 0..sheep {
        for number in 0..exits {
            let chance = (random.next_u64() % sheep as u64) as usize;
            let to = if number == 0 { (from + 1) % sheep } else { chance };
            transitions.push(Transition { from: id(from), to: id(to), clip: clip.clone(), weight: 1.0 });
        }
    }
    let one = |at| Sheep { id: id(at), clip: None, genome: None, want: 1.0, repeat: 1 };
    Arc::new(Flock::new(Manifest {
        name: "bench".into(),
        size: (64, 64),
        fps: Rate::new(30, 1).expect("30 is a rate"),
        sheep: (0..sheep).map(one).collect(),
        transitions,
    }))
}
