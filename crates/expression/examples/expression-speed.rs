//! Samples per CPU-second of an expression of 18 nodes with two noises, and what a wall's frame of it takes.
//!
//! Owns the measurement and its bounds: one JSON document on stdout; the exit status is 1 where a bound is not kept. Never
//! checks pictures: the tests do.
//!
//! Run `cargo run --release -p expression --example expression-speed`.
#![expect(clippy::print_stdout, reason = "the answer goes to stdout")]

use std::error::Error;
use std::fs;
use std::process::ExitCode;

use expression::{Cost, Genome, Loop, Node, Samples, Settings, cost, render};
use species::Threads;

const EXPRESSION: &str = "(+ (* (warped-bw-noise x (* y z) 0.4 7) 0.8) (sin (- (bw-noise 0.3 2) (* 3 y))))";
const SIZE: [u32; 2] = [1280, 720];
/// Ticks of the CPU clock in a second, as `/proc` counts them.
const TICKS_PER_SECOND: f64 = 100.0;
/// Each figure is the least of so many, on a machine that does other things as well.
const ROUNDS: u32 = 5;
/// At least so many samples a CPU-second, at most so many CPU-seconds a frame.
const LEAST_SAMPLES: f64 = 10e6;
const MOST_SECONDS: f64 = 2.0;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let node = Node::parse(EXPRESSION)?;
    let (nodes, turning) = (node.size(), Loop::new(&Genome::from(node), 240.0));
    let even = Settings { size: SIZE, samples: Samples::Sixteen, is_blurred: true };
    let seconds = least_seconds(&turning, even)?;
    let adaptive = least_seconds(&turning, Settings { samples: Samples::Adaptive, ..even })?;
    let (strips, compile) = (strips_seconds(&turning)?, compile_ms(&turning, &even)?);
    println!("{}", answer(nodes, [seconds, adaptive, strips], compile, &cost(&turning, 0.0, &even)?));
    let is_kept = rate(seconds) >= LEAST_SAMPLES && seconds <= MOST_SECONDS;
    Ok(if is_kept { ExitCode::SUCCESS } else { ExitCode::FAILURE })
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
        ("compile_ms", compile),
        ("estimated_ns_per_sample", f64::from(cost.ns_per_sample)),
        ("measured_ns_per_sample", 1e9 / rate),
    ];
    let lines: Vec<String> =
        figures.iter().map(|(name, figure)| format!("  \"{name}\": {}", (figure * 100.0).round() / 100.0)).collect();
    format!("{{\n{}\n}}", lines.join(",\n"))
}

/// CPU-seconds of 24 small pictures of each of 20 candidates.
fn strips_seconds(turning: &Loop) -> Result<f64, Box<dyn Error>> {
    let (threads, start) = (Threads::new(1)?, cpu_seconds()?);
    for frame in 0..20 * 24 {
        render(
            turning,
            f64::from(frame),
            &Settings { size: [160, 90], samples: Samples::One, is_blurred: false },
            &threads,
        )?;
    }
    Ok(cpu_seconds()? - start)
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
