//! How clean pictures are at equal processor time: ours, `flam3-render`, and `flam3-render` with its density estimator.
//! Each is compared with a reference of its own renderer; flam3's with ours, too, and the better figure counts.
//!
//! Owns the measurement and its bound: one JSON document on stdout; the exit status is 1 where the bound is not kept.
//! The processor time is that of a picture of 1280x720, and less for a smaller one by its area.
//!
//! Run `cargo run --release -p flame --example quality [WxH [SPP [SECONDS...]]]`: the size, 160x90 unless given; samples
//! per pixel of the reference, 16000; seconds at 1280x720, 10 and 60.
#![expect(clippy::print_stdout, reason = "the answer goes to stdout")]

mod peer;

use std::error::Error;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;
use std::process::{Command, ExitCode};

use flame::{Filter, Genome, Image, Renderer, Settings};
use peer::{cpu_seconds, genomes};
use serde_json::{Value, json};

/// At least so many decibels more than the better one of flam3's.
const LEAST_AHEAD_DB: f64 = 4.0;

/// Processor seconds that a measurement takes at least: the clock ticks ten milliseconds.
const LEAST_SECONDS: f64 = 0.6;

/// How often the number of samples is corrected until the time is right.
const CORRECTIONS: usize = 3;

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Renders {
    Ours,
    Flam3,
    Flam3Estimated,
}

/// A genome with its references.
struct Case {
    name: String,
    genome: Genome,
    /// By our renderer, and by flam3: whatever the two do not have in common is held against neither.
    truths: [Vec<f32>; 2],
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let size = words.first().map_or("160x90", String::as_str);
    let (width, height) = size.split_once('x').ok_or("wanted a size such as 160x90")?;
    let size = [width.parse()?, height.parse()?];
    let spp = words.get(1).map_or(Ok(16_000.0), |word| word.parse())?;
    let seconds: Vec<f64> = words.iter().skip(2).map(|word| word.parse()).collect::<Result<_, _>>()?;
    let rows = rows(size, spp, if seconds.is_empty() { &[10.0, 60.0] } else { &seconds })?;
    let least = rows.iter().map(|row| row["ahead_db"].as_f64().unwrap_or(0.0)).fold(f64::MAX, f64::min);
    let bounds = json!({ "least_ahead_db": least, "bound_db": LEAST_AHEAD_DB });
    println!("{:#}", json!({ "size": size, "reference_spp": spp, "rows": rows, "bounds": bounds }));
    Ok(if least >= LEAST_AHEAD_DB { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Every genome after so many `seconds` at 1280x720, compared with references of `spp` samples per pixel.
fn rows(size: [u32; 2], spp: f64, seconds: &[f64]) -> Result<Vec<Value>, Box<dyn Error>> {
    let part = f64::from(size[0]) * f64::from(size[1]) / (1280.0 * 720.0);
    let mut rows = Vec::new();
    for file in genomes() {
        let case = Case::new(&file, size, spp)?;
        for seconds in seconds {
            let row = case.row(*seconds, part)?;
            eprintln!("{row}");
            rows.push(row);
        }
    }
    Ok(rows)
}

impl Case {
    fn new(file: &Path, size: [u32; 2], spp: f64) -> Result<Case, Box<dyn Error>> {
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut genome = Genome::parse(&fs::read_to_string(file)?)?;
        genome.camera = genome.camera.resized(size);
        genome.sampling.supersample = 2;
        genome.sampling.temporal_samples = 1;
        // Radius 9 is flam3's own where a file says nothing.
        genome.sampling.estimator_radius = genome.sampling.estimator_radius.max(9.0);
        let settings = Settings { spp: Some(spp), seed: 4711, filter: Filter::None, ..Settings::default() };
        let ours = light(&Renderer::new(0)?.render(&genome, 0.0, &settings)?);
        let mut plain = genome.clone();
        plain.sampling.estimator_radius = 0.0;
        let flam3 = by_flam3(&plain, spp)?;
        Ok(Case { name, genome, truths: [ours, flam3] })
    }

    /// All three after so many `seconds` at 1280x720, of which this picture gets `part`.
    fn row(&self, seconds: f64, part: f64) -> Result<Value, Box<dyn Error>> {
        let renders = [Renders::Ours, Renders::Flam3, Renders::Flam3Estimated];
        let mut found = Vec::new();
        for renders in renders {
            found.push(self.found(renders, seconds * part)?);
        }
        let [ours, flam3, estimated] = found[..] else { return Err("three were asked".into()) };
        let tell = |(spp, cpu_s, psnr): (f64, f64, f64)| json!({ "spp": spp, "cpu_s": cpu_s, "psnr": psnr });
        Ok(json!({
            "genome": self.name, "seconds_at_720p": seconds, "ahead_db": ours.2 - flam3.2.max(estimated.2),
            "ours": tell(ours), "flam3": tell(flam3), "flam3_estimated": tell(estimated),
        }))
    }

    /// Samples per pixel in `seconds` of processor time, the time that they took, and decibels.
    fn found(&self, renders: Renders, seconds: f64) -> Result<(f64, f64, f64), Box<dyn Error>> {
        let renderer = Renderer::new(1)?;
        let mut spp: f64 = if renders == Renders::Ours { 300.0 } else { 40.0 };
        let (mut cost, mut picture) = (0.0, Vec::new());
        for correction in 0..=CORRECTIONS {
            let before = used()?;
            let mut count = 0.0;
            while count == 0.0 || used()? - before < LEAST_SECONDS {
                picture = self.drawn(renders, spp, &renderer)?;
                count += 1.0;
            }
            cost = (used()? - before) / count;
            // What is within a twentieth is compared as it is.
            if correction == CORRECTIONS || (cost / seconds - 1.0).abs() < 0.05 {
                break;
            }
            spp = (spp * (seconds / cost).clamp(0.02, 20.0)).max(1.0);
        }
        let nearest = match renders {
            Renders::Ours => psnr(&picture, &self.truths[0]),
            Renders::Flam3 | Renders::Flam3Estimated => {
                self.truths.iter().map(|truth| psnr(&picture, truth)).fold(f64::MIN, f64::max)
            }
        };
        Ok((spp, cost, nearest))
    }

    fn drawn(&self, renders: Renders, spp: f64, renderer: &Renderer) -> Result<Vec<f32>, Box<dyn Error>> {
        let mut genome = self.genome.clone();
        match renders {
            Renders::Ours => {
                let settings = Settings { spp: Some(spp), seed: 1, ..Settings::default() };
                return Ok(light(&renderer.render(&genome, 0.0, &settings)?));
            }
            Renders::Flam3 => genome.sampling.estimator_radius = 0.0,
            Renders::Flam3Estimated => {}
        }
        by_flam3(&genome, spp)
    }
}

/// What `flam3-render` makes of `genome` with so many samples per pixel, on one thread.
fn by_flam3(genome: &Genome, spp: f64) -> Result<Vec<f32>, Box<dyn Error>> {
    let mut genome = genome.clone();
    genome.sampling.quality = spp;
    let file = std::env::temp_dir().join(format!("quality-{}.flam3", std::process::id()));
    let out = file.with_extension("png");
    fs::write(&file, genome.to_xml())?;
    let ran = Command::new("flam3-render")
        .envs([("in", &file), ("out", &out)])
        .envs([("format", "png"), ("bpc", "16"), ("nthreads", "1"), ("verbose", "0")])
        .output()?;
    if !ran.status.success() {
        return Err(format!("flam3-render ended with {}", ran.status).into());
    }
    let picture = read_png(&out)?;
    fs::remove_file(&out)?;
    fs::remove_file(&file)?;
    Ok(picture)
}

fn light(image: &Image) -> Vec<f32> {
    image.pixels.as_flattened().to_vec()
}

/// Red, green and blue of a PNG file of 16 bits.
fn read_png(file: &Path) -> Result<Vec<f32>, Box<dyn Error>> {
    let mut reader = png::Decoder::new(BufReader::new(File::open(file)?)).read_info()?;
    let mut bytes = vec![0; reader.output_buffer_size().ok_or("the picture is too large")?];
    let frame = reader.next_frame(&mut bytes)?;
    let channels = frame.color_type.samples();
    if frame.bit_depth != png::BitDepth::Sixteen {
        return Err(format!("`{}` has {:?} bits, 16 were asked for", file.display(), frame.bit_depth).into());
    }
    let levels: Vec<f32> =
        bytes.chunks_exact(2).map(|two| f32::from(u16::from_be_bytes([two[0], two[1]])) / 65535.0).collect();
    Ok(levels.chunks(channels).flat_map(|pixel| &pixel[..3]).copied().collect())
}

fn psnr(a: &[f32], b: &[f32]) -> f64 {
    let error: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    -10.0 * (error / b.len() as f64).log10()
}

/// CPU seconds of this process and its children together.
fn used() -> Result<f64, Box<dyn Error>> {
    Ok(cpu_seconds()?.iter().sum())
}
