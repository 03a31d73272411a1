//! Samples per CPU second of this renderer and of `flam3-render`, on two of the test genomes, in one run.
//!
//! Owns the measurement: one JSON document on stdout. Never checks pictures: `tests/flam3.rs` does.
//!
//! Run `cargo run --release -p flame --example speed`.
#![expect(clippy::print_stdout, reason = "the answer goes to stdout")]

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::Command;

use flame::{Genome, Renderer, Settings};
use serde_json::{Value, json};

/// Ticks of the CPU clock in a second, as `/proc` counts them.
const TICKS_PER_SECOND: f64 = 100.0;

fn main() -> Result<(), Box<dyn Error>> {
    let rows = ["turned-symmetry", "first-seven"].map(measured).into_iter().collect::<Result<Vec<_>, _>>()?;
    println!("{:#}", json!({ "genomes": rows }));
    Ok(())
}

/// Both renderers' rates on one genome, at 640x360 and 100 samples per pixel, one thread each.
fn measured(name: &str) -> Result<Value, Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/genomes");
    let mut genome = Genome::parse(&fs::read_to_string(folder.join(name).with_extension("flam3"))?)?;
    genome.camera.scale *= 5.0;
    genome.camera.size = [640, 360];
    genome.sampling.quality = 100.0;
    let samples = 640.0 * 360.0 * genome.sampling.quality;
    let file = std::env::temp_dir().join(format!("{name}-{}.flam3", std::process::id()));
    fs::write(&file, genome.to_xml())?;

    let renderer = Renderer::new(1)?;
    let [before, _] = cpu_seconds()?;
    renderer.render(&genome, 0.0, &Settings { temporal_samples: Some(1), seed: 1, ..Settings::default() })?;
    let [after, children] = cpu_seconds()?;
    let ran = Command::new("flam3-render")
        .env("in", &file)
        .env("out", file.with_extension("png"))
        .env("format", "png")
        .env("nthreads", "1")
        .env("verbose", "0")
        .output()?;
    let [_, children_after] = cpu_seconds()?;
    fs::remove_file(file.with_extension("png"))?;
    fs::remove_file(&file)?;
    if !ran.status.success() {
        return Err(format!("flam3-render ended with {}", ran.status).into());
    }
    Ok(json!({
        "genome": name,
        "samples": samples,
        "ours_samples_per_cpu_s": samples / (after - before),
        "flam3_samples_per_cpu_s": samples / (children_after - children),
    }))
}

/// CPU seconds of this process and of its children so far.
fn cpu_seconds() -> Result<[f64; 2], Box<dyn Error>> {
    let stat = fs::read_to_string("/proc/self/stat")?;
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    let ticks: Vec<f64> = after_name.split_whitespace().skip(11).take(4).map(str::parse).collect::<Result<_, _>>()?;
    let [user, system, child_user, child_system] = ticks[..] else { return Err("no CPU times in `/proc`".into()) };
    Ok([(user + system) / TICKS_PER_SECOND, (child_user + child_system) / TICKS_PER_SECOND])
}
