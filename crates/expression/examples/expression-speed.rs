//! Samples per CPU-second of an expression of 18 nodes with two noises, what a wall's frame of it takes, and what the small
//! pictures of candidates take that are bred.
//!
//! Owns the measurement and its bounds: one JSON document on stdout; the exit status is 1 where a bound is not kept. Never
//! checks pictures: the tests do.
//!
//! Run `cargo run --release -p expression --example expression-speed`.
#![expect(clippy::print_stdout, reason = "the answer goes to stdout")]

use std::error::Error;
use std::fs;
use std::process::ExitCode;

use expression::{Cost, Expressions, Genome, Loop, Node, Samples, Settings, cost, render};
use species::{Breed, Rng, Threads};

const EXPRESSION: &str = "(+ (* (warped-bw-noise x (* y z) 0.4 7) 0.8) (sin (- (bw-noise 0.3 2) (* 3 y))))";
const SIZE: [u32; 2] = [1280, 720];
/// Ticks of the CPU clock in a second, as `/proc` counts them.
const TICKS_PER_SECOND: f64 = 100.0;
/// Each figure is the least of so many, on a machine that does other things as well.
const ROUNDS: u32 = 5;
/// At least so many samples a CPU-second, at most so many CPU-seconds a frame.
const LEAST_SAMPLES: f64 = 100e6;
const MOST_SECONDS: f64 = 2.0;
/// Candidates of a brood, small pictures of each, at most so many CPU-seconds for all, and CPU-milliseconds to compile one's.
const CANDIDATES: u64 = 20;
const PICTURES: u32 = 24;
const MOST_STRIPS_SECONDS: f64 = 2.0;
const MOST_COMPILE_MS: f64 = 1.0;
/// Frames of a candidate's loop.
const FRAMES: f64 = 384.0;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let (text, is_kept) = measured()?;
    println!("{text}");
    Ok(if is_kept { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// All figures, and whether every bound is kept.
fn measured() -> Result<(String, bool), Box<dyn Error>> {
    let node = Node::parse(EXPRESSION)?;
    let (nodes, turning) = (node.size(), Loop::new(&Genome::from(node), 240.0));
    let even = Settings { size: SIZE, samples: Samples::Sixteen, is_blurred: true };
    let seconds = least_seconds(&turning, even)?;
    let adaptive = least_seconds(&turning, Settings { samples: Samples::Adaptive, ..even })?;
    let strips = strips_seconds(&candidates())?;
    let compile = compile_ms(&turning, &even)?;
    let is_kept = rate(seconds) >= LEAST_SAMPLES
        && seconds <= MOST_SECONDS
        && strips <= MOST_STRIPS_SECONDS
        && compile <= MOST_COMPILE_MS;
    Ok((answer(nodes, [seconds, adaptive, strips], compile, &cost(&turning, 0.0, &even)?), is_kept))
}

/// Samples a CPU-second of a frame with 16 a pixel.
fn rate(seconds: f64) -> f64 {
    16.0 * f64::from(SIZE[0]) * f64::from(SIZE[1]) / seconds
}

/// All figures with their bounds, as JSON.
fn answer(nodes: usize, [seconds, adaptive, strips]: [f64; 3], compile: f64, cost: &Cost) -> String {
    let rate = rate(seconds);
    let figures = [
        ("nodes", nodes as f64),
        ("samples_per_cpu_s", rate.round()),
        ("least_samples_per_cpu_s", LEAST_SAMPLES),
        ("frame_cpu_s", seconds),
        ("most_frame_cpu_s", MOST_SECONDS),
        ("adaptive_frame_cpu_s", adaptive),
        ("strips_of_20_candidates_cpu_s", strips),
        ("most_strips_of_20_candidates_cpu_s", MOST_STRIPS_SECONDS),
        ("compile_ms", compile),
        ("most_compile_ms", MOST_COMPILE_MS),
        ("estimated_ns_per_sample", f64::from(cost.ns_per_sample)),
        ("measured_ns_per_sample", 1e9 / rate),
    ];
    let lines: Vec<String> =
        figures.iter().map(|(name, figure)| format!("  \"{name}\": {}", (figure * 100.0).round() / 100.0)).collect();
    format!("{{\n{}\n}}", lines.join(",\n"))
}

/// Different candidates, as a brood has them: a third are strangers, the others children by mutation and by crossing.
fn candidates() -> Vec<Box<dyn species::Genome>> {
    let mut brood: Vec<Box<dyn species::Genome>> = Vec::new();
    for seed in 0..CANDIDATES {
        let mut rng = Rng::stream(seed, 5);
        let stranger = Expressions.random(&mut rng);
        let child = match seed % 3 {
            0 => None,
            1 => Expressions.mutate(&*stranger, 1.0, &mut rng),
            _ => brood.last().and_then(|parent| Expressions.cross([&*stranger, &**parent], &mut rng)),
        };
        brood.push(child.map_or(stranger, |(child, _)| child));
    }
    brood
}

/// CPU-seconds of the small pictures of all candidates, with everything that is done for them once; the least of all rounds.
fn strips_seconds(candidates: &[Box<dyn species::Genome>]) -> Result<f64, Box<dyn Error>> {
    const SMALL: [u32; 2] = [160, 90];
    let settings = species::Settings {
        size: SMALL,
        spp: Some(1.0),
        psnr: None,
        supersample: None,
        temporal_samples: Some(1),
        smooths: false,
        seed: 1,
    };
    let threads = Threads::new(1)?;
    let mut least = f64::MAX;
    for _ in 0..ROUNDS {
        let start = cpu_seconds()?;
        for candidate in candidates {
            let turning = candidate.turning(SMALL, FRAMES);
            for picture in 0..PICTURES {
                turning.frame(FRAMES * f64::from(picture) / f64::from(PICTURES), &settings, &threads)?;
            }
        }
        least = least.min(cpu_seconds()? - start);
    }
    Ok(least)
}

/// CPU-milliseconds until a frame's four moments are compiled.
fn compile_ms(turning: &Loop, settings: &Settings) -> Result<f64, Box<dyn Error>> {
    let start = cpu_seconds()?;
    for frame in 0..1000 {
        cost(turning, f64::from(frame), settings)?;
    }
    // Seconds for a thousand are milliseconds for one.
    Ok(cpu_seconds()? - start)
}

/// CPU-seconds of one frame by one thread.
fn least_seconds(turning: &Loop, settings: Settings) -> Result<f64, Box<dyn Error>> {
    let threads = Threads::new(1)?;
    let mut least = f64::MAX;
    for round in 0..ROUNDS {
        let start = cpu_seconds()?;
        render(turning, f64::from(round), &settings, &threads)?;
        least = least.min(cpu_seconds()? - start);
    }
    Ok(least)
}

/// CPU-seconds of this process so far.
fn cpu_seconds() -> Result<f64, Box<dyn Error>> {
    let stat = fs::read_to_string("/proc/self/stat")?;
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    let ticks: Vec<f64> = after_name.split_whitespace().skip(11).take(2).map(str::parse).collect::<Result<_, _>>()?;
    Ok(ticks.iter().sum::<f64>() / TICKS_PER_SECOND)
}
