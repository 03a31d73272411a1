//! Samples per CPU-second of this renderer and of `flam3-render`, side by side in one run.
//!
//! Owns the measurement and its bounds: one JSON document on stdout; the exit status is 1 where a bound is not kept. Never
//! checks pictures: `tests/it/flam3.rs` does.
//!
//! Run `cargo run --release -p flame --example speed`.
#![expect(clippy::print_stdout, reason = "the answer goes to stdout")]
#![expect(clippy::disallowed_methods, reason = "it measures time")]

mod peer;

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::Instant;

use flame::variations::{Kind, Variation};
use flame::{Arithmetic, Genome, Renderer, Settings};
use peer::{cpu_seconds, genomes};
use serde_json::{Value, json};

/// The pictures are as large as a wall's.
const SIZE: [u32; 2] = [1280, 720];

/// Samples per pixel. What a frame costs whatever its samples is measured with the few, and taken off.
const FEW: f64 = 1.0;
const MANY: f64 = 101.0;

/// Each figure is the median of so many.
const ROUNDS: usize = 3;

/// At least so many times flam3's samples per CPU-second: in the geometric mean, by AVX-512 and by AVX2, and for every
/// genome.
const LEAST: [(&str, f64); 3] = [("avx512", 7.0), ("avx2", 6.0), ("worst", 4.5)];

/// At most so many CPU-seconds for a frame whatever its samples.
const MOST_FIXED: f64 = 0.3;

/// A second thread costs at most so much more CPU time for the same frame, and makes it at least so many times as fast: in
/// the geometric mean, and the latter where nothing else runs.
const MOST_CPU_OF_TWO: f64 = 1.05;
const LEAST_SPEED_OF_TWO: f64 = 1.9;

/// A sample of a flame with depth costs at most so many times one of the same flame drawn flat: in the geometric mean.
const MOST_FOR_DEPTH: f64 = 1.5;

/// CPU-seconds of a frame of few samples and of many.
type Costs = [f64; 2];

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let rows = genomes().iter().map(|file| measured(file)).collect::<Result<Vec<_>, _>>()?;
    let (answer, is_kept) = judged(&rows);
    println!("{answer:#}");
    Ok(if is_kept { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// All figures with their bounds, and whether these are kept.
fn judged(rows: &[Value]) -> (Value, bool) {
    let all = |name: &str| rows.iter().map(|row| row[name].as_f64().unwrap_or(0.0)).collect::<Vec<_>>();
    let mean = |name: &str| (all(name).iter().map(|ratio| ratio.ln()).sum::<f64>() / rows.len() as f64).exp();
    let worst = all("avx2_ratio").into_iter().fold(f64::MAX, f64::min);
    let ratios = [mean("avx512_ratio"), mean("avx2_ratio"), worst];
    let fixed = all("ours_fixed_cpu_s").into_iter().fold(0.0, f64::max);
    let two = [mean("two_threads_cpu_ratio"), mean("two_threads_speed")];
    let is_kept = LEAST.iter().zip(ratios).all(|((_, least), ratio)| ratio >= *least)
        && fixed <= MOST_FIXED
        && two[0] <= MOST_CPU_OF_TWO
        && mean("depth_cpu_ratio") <= MOST_FOR_DEPTH
        && two[1] >= LEAST_SPEED_OF_TWO;
    let bound = |((name, least), ratio): (&(&str, f64), f64)| json!({ "name": name, "least": least, "ratio": ratio });
    let bounds: Vec<Value> = LEAST.iter().zip(ratios).map(bound).collect();
    let answer = json!({
        "genomes": rows,
        "ratios": bounds,
        "fixed_cpu_s": fixed,
        "most_fixed_cpu_s": MOST_FIXED,
        "depth": { "cpu_ratio": mean("depth_cpu_ratio"), "most_cpu_ratio": MOST_FOR_DEPTH },
        "two_threads": {
            "cpu_ratio": two[0],
            "most_cpu_ratio": MOST_CPU_OF_TWO,
            "speed": two[1],
            "least_speed": LEAST_SPEED_OF_TWO,
        },
    });
    (answer, is_kept)
}

/// Both renderers' costs on one genome, one thread each.
fn measured(file: &Path) -> Result<Value, Box<dyn Error>> {
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let mut genome = Genome::parse(&fs::read_to_string(file)?)?;
    genome.camera = genome.camera.resized(SIZE);
    genome.sampling.supersample = 2;
    genome.sampling.estimator_radius = 0.0;
    let mut costs: [Vec<Costs>; 3] = Default::default();
    let mut seconds = Vec::new();
    for _ in 0..ROUNDS {
        let [few, many] = [FEW, MANY].map(|spp| ours(&genome, spp, Arithmetic::Fastest, 1));
        let (few, many, two) = (few?, many?, ours(&genome, MANY, Arithmetic::Fastest, 2)?);
        costs[0].push([few.cpu, many.cpu]);
        seconds.push([two.cpu / many.cpu, many.wall / two.wall]);
        let [few, many] = [FEW, MANY].map(|spp| ours(&genome, spp, Arithmetic::Avx2, 1));
        costs[1].push([few?.cpu, many?.cpu]);
        costs[2].push([theirs(&genome, FEW)?, theirs(&genome, MANY)?]);
    }
    let samples = (MANY - FEW) * f64::from(SIZE[0]) * f64::from(SIZE[1]);
    let [fastest, avx2, flam3] = costs.map(|mut rounds| {
        rounds.sort_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
        rounds[ROUNDS / 2]
    });
    let rate = |[few, many]: Costs| samples / (many - few);
    let [cpu_of_two, speed_of_two] = [0, 1].map(|of| {
        let mut rounds: Vec<f64> = seconds.iter().map(|figures| figures[of]).collect();
        rounds.sort_by(f64::total_cmp);
        rounds[ROUNDS / 2]
    });
    Ok(json!({
        "genome": name,
        "ours_samples_per_cpu_s": rate(fastest),
        "ours_avx2_samples_per_cpu_s": rate(avx2),
        "flam3_samples_per_cpu_s": rate(flam3),
        "ours_fixed_cpu_s": fastest[0],
        "flam3_fixed_cpu_s": flam3[0],
        "avx512_ratio": rate(fastest) / rate(flam3),
        "avx2_ratio": rate(avx2) / rate(flam3),
        "depth_cpu_ratio": depth_ratio(&genome)?,
        "two_threads_cpu_ratio": cpu_of_two,
        "two_threads_speed": speed_of_two,
    }))
}

/// How many times as much a sample costs once the camera is tilted, of a flame that has depth: the median of all rounds.
fn depth_ratio(genome: &Genome) -> Result<f64, Box<dyn Error>> {
    let mut flat = genome.clone();
    for xform in &mut flat.xforms {
        for variation in xform.variations.iter_mut().filter(|variation| variation.kind == Kind::Linear) {
            variation.kind = Kind::Linear3D;
        }
        xform.variations.push(Variation::new(Kind::Zcone, 0.2));
    }
    let mut tilted = flat.clone();
    (tilted.camera.pose.pitch, tilted.camera.pose.perspective) = (0.5, 0.2);
    let mut ratios = Vec::new();
    for _ in 0..ROUNDS {
        let mut sample = [0.0; 2];
        for (sample, genome) in sample.iter_mut().zip([&flat, &tilted]) {
            let [few, many] = [FEW, MANY].map(|spp| ours(genome, spp, Arithmetic::Fastest, 1));
            *sample = many?.cpu - few?.cpu;
        }
        ratios.push(sample[1] / sample[0]);
    }
    ratios.sort_by(f64::total_cmp);
    Ok(ratios[ROUNDS / 2])
}

/// What a frame takes, in seconds of the processors and of the clock.
struct Cost {
    cpu: f64,
    wall: f64,
}

/// What our frame of `spp` samples per pixel takes on so many threads.
fn ours(genome: &Genome, spp: f64, arithmetic: Arithmetic, threads: usize) -> Result<Cost, Box<dyn Error>> {
    let renderer = Renderer::new(threads)?;
    let settings = Settings { spp: Some(spp), temporal_samples: Some(1), seed: 1, arithmetic, ..Settings::default() };
    let ([before, _], start) = (cpu_seconds()?, Instant::now());
    renderer.render(genome, 0.0, &settings)?;
    let wall = start.elapsed().as_secs_f64();
    let [after, _] = cpu_seconds()?;
    Ok(Cost { cpu: after - before, wall })
}

/// CPU-seconds of flam3's frame of `spp` samples per pixel.
fn theirs(genome: &Genome, spp: f64) -> Result<f64, Box<dyn Error>> {
    let mut genome = genome.clone();
    genome.sampling.quality = spp;
    let file = std::env::temp_dir().join(format!("speed-{}.flam3", std::process::id()));
    fs::write(&file, genome.to_xml())?;
    let [_, before] = cpu_seconds()?;
    let ran = Command::new("flam3-render")
        .env("in", &file)
        .env("out", file.with_extension("png"))
        .env("format", "png")
        .env("nthreads", "1")
        .env("verbose", "0")
        .output()?;
    let [_, after] = cpu_seconds()?;
    fs::remove_file(file.with_extension("png"))?;
    fs::remove_file(&file)?;
    if ran.status.success() {
        Ok(after - before)
    } else {
        Err(format!("flam3-render ended with {}", ran.status).into())
    }
}
