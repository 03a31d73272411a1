//! Samples per second of a GPU, and of one core of this machine, in one run.
//!
//! Owns the measurement: one JSON document on stdout, with the name of the GPU. There is no bound: what is at hand may be a
//! driver in software. Never checks pictures: `tests/it/gpu.rs` does.
//!
//! Run `make bench what=gpu`.
#![expect(clippy::print_stdout, reason = "the answer goes to stdout")]
#![expect(clippy::disallowed_methods, reason = "it measures time")]

use std::error::Error;
use std::fs;
use std::path::Path;
use std::time::Instant;

use flame::{Backend, Filter, Genome, Renderer, Settings};
use serde_json::{Value, json};

/// The pictures are as large as a wall's.
const SIZE: [u32; 2] = [1280, 720];

/// A measurement takes at least so many seconds, or so many samples per pixel, whatever is first.
const ENOUGH: f64 = 1.0;
const MOST: f64 = 20_000.0;

/// From simple ones to eight transforms with xaos and a final one.
const GENOMES: [&str; 6] = [
    "first-seven.flam3",
    "roots-and-blurs.flam3",
    "post-and-final.flam3",
    "xaos.flam3",
    "eight-with-xaos.flam3",
    "turned-symmetry.flam3",
];

fn main() -> Result<(), Box<dyn Error>> {
    let backend = Backend::gpu()?;
    let name = backend.name().unwrap_or_default().to_owned();
    let (gpu, core) = (Renderer::new(0)?.with_backend(backend), Renderer::new(1)?);
    let rows = GENOMES.into_iter().map(|file| row(file, &gpu, &core)).collect::<Result<Vec<_>, _>>()?;
    let [samples, ratio] = ["gpu_samples_per_s", "ratio"].map(|key| mean(&rows, key));
    let means = json!({ "gpu_samples_per_s": samples, "ratio": ratio });
    println!("{:#}", json!({ "gpu": name, "genomes": rows, "geometric_means": means }));
    Ok(())
}

/// What is measured with the genome in `file`.
fn row(file: &str, gpu: &Renderer, core: &Renderer) -> Result<Value, Box<dyn Error>> {
    let genome = genome(file)?;
    let (gpu, core) = (rate(gpu, &genome)?, rate(core, &genome)?);
    Ok(json!({ "genome": file, "gpu_samples_per_s": gpu, "core_samples_per_s": core, "ratio": gpu / core }))
}

/// The geometric mean of a figure of all `rows`.
fn mean(rows: &[Value], key: &str) -> f64 {
    let logarithms: Vec<f64> = rows.iter().filter_map(|row| row[key].as_f64()).map(f64::ln).collect();
    (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp()
}

fn genome(file: &str) -> Result<Genome, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/genomes").join(file);
    Ok(Genome::parse(&fs::read_to_string(path)?)?)
}

/// Samples in a second, what a frame costs whatever its samples taken off.
fn rate(renderer: &Renderer, genome: &Genome) -> Result<f64, Box<dyn Error>> {
    let seconds = |spp: f64| -> Result<f64, Box<dyn Error>> {
        let (size, supersample, filter) = (Some(SIZE), Some(2), Filter::None);
        let settings = Settings { size, spp: Some(spp), supersample, filter, ..Settings::default() };
        let begin = Instant::now();
        renderer.render(genome, 0.0, &settings)?;
        Ok(begin.elapsed().as_secs_f64())
    };
    // The first frame of a genome waits for its shader.
    seconds(1.0)?;
    let fixed = seconds(1.0)?;
    let mut spp = 4.0;
    loop {
        let taken = seconds(spp)? - fixed;
        if taken >= ENOUGH || spp >= MOST {
            return Ok((spp - 1.0) * f64::from(SIZE[0] * SIZE[1]) / taken);
        }
        spp *= 2.0;
    }
}
