//! Shares of 100 random flocks against walks of 10,000,000 steps: 20 minutes of one core.
//!
//! Owns the table on stdout. Exits with 1 if a claim is broken. `tests/claims.rs` runs the same, shorter.
#![allow(clippy::print_stdout, reason = "the table is this program's answer")]

use std::ops::Range;
use std::process::ExitCode;

mod claims;

use claims::Errors;

const STEPS: u64 = 10_000_000;

fn main() -> ExitCode {
    let (mut memoryless, mut steered) = (Errors::default(), Errors::default());
    for seed in 0..claims::FLOCKS {
        let flock = claims::flock(seed);
        let thrown = claims::memoryless(&flock, seed, STEPS);
        memoryless.add(&flock, &thrown, &claims::memoryless_bounds(&flock, STEPS));
        let tally = claims::steered(&flock, seed, STEPS);
        steered.add(&flock, &tally, &claims::steered_bounds(&flock, &tally));
    }
    println!("walk        sheep  flocks outside  worst, bounds  errors, sigmas  most visits off, and the bound");
    let held = [tell("memoryless", &memoryless, claims::MEMORYLESS), tell("steered", &steered, claims::STEERED)];
    if held == [true, true] { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Prints the errors of one kind of walk; whether they keep the claims.
fn tell(name: &str, errors: &Errors, sizes: Range<f64>) -> bool {
    let (sheep, outside, worst, sigmas) = (errors.sheep(), errors.outside, errors.worst(), errors.sigmas());
    let (most, bound) = errors.most;
    println!("{name:<11} {sheep:>5} {outside:>15} {worst:>14.2} {sigmas:>15.2} {most:>16.1} {bound:>9.1}");
    let broken = errors.broken(sizes);
    for claim in &broken {
        println!("{name}: broken: {claim}");
    }
    broken.is_empty()
}
