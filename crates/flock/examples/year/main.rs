//! A year of walking: the claims of the walk at full length, beside a memoryless walk on the same flocks.
//!
//! Owns the table on stdout. Exits with 1 if the steered walk breaks a claim. `tests/claims.rs` runs the same, shorter.
#![allow(clippy::print_stdout, reason = "the table is this program's answer")]

use std::process::ExitCode;

use flock::Simulation;

mod claims;

/// Steps of a year of 50-second steps.
const YEAR: usize = 630_000;
/// Power cuts in it.
const RESTARTS: usize = 1000;
/// The flocks: so many with each kind of weights.
const SEEDS: u64 = 3;

fn main() -> ExitCode {
    let mut sound = true;
    println!("flock        walk        most off  p05/mean  longest repeat  first k2  k3  k4");
    for seed in 0..SEEDS {
        for weights in [claims::Weights::Equal, claims::Weights::Mixed] {
            sound &= year(seed, weights);
        }
    }
    if sound { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// One flock's year; whether every claim held.
fn year(seed: u64, weights: claims::Weights) -> bool {
    let flock = claims::flock(seed, weights);
    let name = format!("{seed} {weights:?}");
    let through = claims::steered(&flock, seed, YEAR, 0);
    let cut = claims::steered(&flock, seed, YEAR, RESTARTS);
    let figures = claims::figures(&flock, &through);
    print(&name, "steered", &figures);
    print(&name, "memoryless", &claims::figures(&flock, &claims::memoryless(&flock, seed, YEAR)));
    let mut broken = claims::broken(&figures);
    if cut != through {
        broken.push(format!("{RESTARTS} restarts changed the walk"));
    }
    for claim in &broken {
        println!("{name}: broken: {claim}");
    }
    broken.is_empty()
}

fn print(name: &str, walk: &str, figures: &Simulation) {
    let first = |k: Option<usize>| k.map_or("-".to_owned(), |steps| steps.to_string());
    println!(
        "{name:<12} {walk:<11} {:>8.1} {:>9.3} {:>15} {:>9} {:>3} {:>3}",
        figures.most_off,
        claims::earliest(figures),
        figures.longest_repeat,
        first(figures.first_repeat.k2),
        first(figures.first_repeat.k3),
        first(figures.first_repeat.k4),
    );
}
