//! How many genomes of a folder draw, by the program that wrote them, why the others do not, and how pictures agree with
//! those of the programs themselves.
//!
//! Owns the measurement and its bounds: one JSON document on stdout; the exit status is 1 where a bound is not kept. The
//! folder is the caller's: no genome of others is in the repository. A program draws its own genomes where it is installed:
//! `flam3-render` those of flam3, `emberrender` those of Fractorium, and `jwildfire-render` those of JWildfire: a script that
//! hands its arguments to `java org.jwildfire.cli.FlameRenderer`. That takes its spatial filter from its own `RenderOptions`
//! and not from the file: pictures are compared without one, which is a radius of 0.25 there (0 takes 4 % of the light).
//!
//! Run `make bench what=genomes GENOMES=FOLDER`.
#![expect(clippy::print_stdout, reason = "the answer goes to stdout")]

use std::collections::BTreeMap;
use std::error::Error;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use flame::genome::Program;
use flame::{Backend, Filter, Flame, Genome, Image, Renderer, Settings};
use operations::species::{palettes, text};
use serde_json::{Value, json};
use species::Genome as _;

/// The larger side of pictures, in pixels.
const SIDE: f64 = 160.0;
/// Their samples per pixel; those that do not agree by then are drawn once more with the larger number, so that no noise
/// counts as a difference.
const SAMPLES: [f64; 2] = [1500.0, 8000.0];

/// At least so many of 100 genomes draw, by the program that wrote them.
const LEAST_DRAWN: [(Program, f64); 2] = [(Program::Fractorium, 85.0), (Program::JWildfire, 65.0)];
/// A picture agrees at so many decibels; so many of 100 of those that are compared have to.
const AGREES_DB: f64 = 30.0;
const LEAST_AGREEING: f64 = 90.0;

/// What is known of the genomes of a program.
#[derive(Default)]
struct Source {
    drawn: u32,
    /// Drawn, but not quite as asked: what is left out, by its name.
    without: BTreeMap<String, u32>,
    refused: u32,
    unreadable: u32,
    /// Why genomes are refused: names, and how many genomes each stops.
    reasons: BTreeMap<String, u32>,
    decibels: Vec<f64>,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("wanted a folder of genomes: make bench what=genomes GENOMES=FOLDER")?;
    let (answer, is_kept) = verdict(&counted(Path::new(&folder))?);
    println!("{answer:#}");
    Ok(if is_kept { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// What became of all genomes below `folder`, by the program that wrote them.
fn counted(folder: &Path) -> Result<BTreeMap<&'static str, Source>, Box<dyn Error>> {
    let mut sources: BTreeMap<&'static str, Source> = BTreeMap::new();
    let mut files = Vec::new();
    list(folder, &mut files)?;
    files.sort();
    let renderer = Renderer::new(0)?;
    for file in &files {
        let Ok(text) = text(file) else { continue };
        let Ok(parts) = Genome::split(&text) else {
            sources.entry("unknown").or_default().unreadable += 1;
            continue;
        };
        for part in parts {
            match part.genome {
                Ok(genome) => measure(&genome, &part.text, &renderer, &mut sources),
                Err(_) => sources.entry("unknown").or_default().unreadable += 1,
            }
        }
    }
    Ok(sources)
}

/// Adds the files of `folder` and of those below it that may have genomes.
fn list(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), Box<dyn Error>> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let is_flame = path.extension().is_some_and(|end| ["flame", "flam3", "xml"].iter().any(|known| end == *known));
        if path.is_dir() {
            list(&path, files)?;
        } else if is_flame {
            files.push(path);
        }
    }
    Ok(())
}

fn measure(genome: &Genome, text: &str, renderer: &Renderer, sources: &mut BTreeMap<&'static str, Source>) {
    let program = genome.program();
    let source = sources.entry(program.map_or("unknown", Program::name)).or_default();
    let unsupported = genome.unsupported();
    for (reasons, counts) in [(&unsupported.refused, &mut source.reasons), (&unsupported.without, &mut source.without)]
    {
        let mut names: Vec<&str> = reasons.0.iter().map(|reason| reason.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        for name in names {
            *counts.entry(name.to_owned()).or_default() += 1;
        }
    }
    let Ok(genome) = palettes::coloured(genome.clone()) else {
        source.refused += 1;
        return;
    };
    let turning = Flame::new(genome.clone(), Backend::default()).turning(genome.camera.size, 30.0);
    let settings = species::Settings {
        size: [64, 36],
        spp: Some(1.0),
        psnr: None,
        supersample: Some(1),
        temporal_samples: Some(1),
        smooths: false,
        seed: 1,
    };
    if turning.demand(0.0, &settings).is_err() {
        source.refused += 1;
        return;
    }
    source.drawn += 1;
    let Some(program) = program else { return };
    let compare = |samples| {
        let theirs = their_picture(program, &genome, text, samples)?;
        let ours = our_picture(&genome, samples, renderer).filter(|ours| ours.pixels.len() == theirs.pixels.len())?;
        Some(psnr(&ours, &theirs))
    };
    let [few, many] = SAMPLES;
    let found = compare(few);
    // Where the larger number fails, the first figure counts: a picture that does not agree is never left out.
    source.decibels.extend(if found.is_some_and(|found| found < AGREES_DB) { compare(many).or(found) } else { found });
}

/// How much smaller pictures are than `genome` says, and their size.
fn reduced(genome: &Genome) -> (f64, [u32; 2]) {
    let size = genome.camera.size;
    let factor = SIDE / f64::from(size[0].max(size[1]));
    (factor, size.map(|side| (f64::from(side) * factor).round() as u32))
}

/// `text` with the attribute `name` of its flame as `change` makes it.
fn changed(text: &str, name: &str, change: impl Fn(&str) -> Option<String>) -> Option<String> {
    let head = &text[..text.find('>')?];
    let start = head.find(&format!(" {name}=\""))? + name.len() + 3;
    let end = start + text[start..].find('"')?;
    Some([&text[..start], &change(&text[start..end])?, &text[end..]].concat())
}

/// The picture of the program that wrote the genome, where that is installed.
fn their_picture(program: Program, genome: &Genome, text: &str, samples: f64) -> Option<Image> {
    let (renderer, variables) = match program {
        Program::Flam3 => ("flam3-render", true),
        Program::Fractorium => ("emberrender", false),
        Program::JWildfire => ("jwildfire-render", false),
        Program::Apophysis | Program::Flam3h => return None,
    };
    let scratch = tempfile::tempdir().ok()?;
    let [file, picture] = ["a.flame", "a.png"].map(|name| scratch.path().join(name));
    // By what the file says: their own options for size cut off the rest of a pixel, and so move the picture.
    let (factor, [width, height]) = reduced(genome);
    let mut command = Command::new(renderer);
    if program == Program::JWildfire {
        // It scales by its own options.
        let smooth = changed(text, "antialias_amount", |_| Some("0.0".to_owned())).unwrap_or_else(|| text.to_owned());
        fs::write(&file, smooth).ok()?;
        command.arg("-f").arg(&file).args(["-w", &width.to_string(), "-h", &height.to_string()]);
        command.args(["-q", &samples.to_string()]);
        command.output().ok().filter(|done| done.status.success())?;
        return read(&picture);
    }
    let text = changed(text, "size", |_| Some(format!("{width} {height}")))?;
    let text = changed(&text, "scale", |scale| Some((scale.trim().parse::<f64>().ok()? * factor).to_string()))?;
    fs::write(&file, format!("<flames>{text}</flames>")).ok()?;
    if variables {
        command.env("in", &file).env("out", &picture).env("format", "png");
        command.env("qs", (samples / genome.sampling.quality).to_string());
    } else {
        command.arg(format!("--in={}", file.display())).arg(format!("--out={}", picture.display()));
        command.args([format!("--quality={samples}"), "--format=png".to_owned()]);
        // Otherwise it draws `cross`, `sin` and others not as flam3, and one of four cells of a pixel only.
        command.args(["--flam3_compat", "--supersample=1"]);
    }
    command.output().ok().filter(|done| done.status.success())?;
    read(&picture)
}

/// The picture in a PNG file of 8 bits.
fn read(path: &Path) -> Option<Image> {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).ok()?)).read_info().ok()?;
    let mut bytes = vec![0; reader.output_buffer_size()?];
    let info = reader.next_frame(&mut bytes).ok()?;
    let each = info.color_type.samples();
    let pixels = bytes[..info.buffer_size()].chunks_exact(each).filter(|pixel| pixel.len() >= 3);
    let pixels = pixels.map(|pixel| [pixel[0], pixel[1], pixel[2]].map(|byte| f32::from(byte) / 255.0)).collect();
    Some(Image { width: info.width as usize, height: info.height as usize, pixels })
}

/// Ours, as large as theirs.
fn our_picture(genome: &Genome, samples: f64, renderer: &Renderer) -> Option<Image> {
    let mut genome = genome.clone();
    let (factor, size) = reduced(&genome);
    (genome.camera.size, genome.camera.scale) = (size, genome.camera.scale * factor);
    if genome.program() == Some(Program::JWildfire) {
        move_as_jwildfire(&mut genome);
    }
    let settings = Settings {
        size: None,
        spp: Some(samples),
        temporal_samples: Some(1),
        supersample: Some(1),
        filter: Filter::Flam3,
        ..Settings::default()
    };
    renderer.render(&genome, 0.0, &settings).ok()
}

/// Moves the picture of `genome` to where JWildfire draws it, half a pixel to the left and up, and takes its filters away.
fn move_as_jwildfire(genome: &mut Genome) {
    let Genome { camera, sampling, .. } = genome;
    let (sin, cos) = camera.rotate.to_radians().sin_cos();
    let [x, y] = camera.center;
    let turned = [x * cos - y * sin, x * sin + y * cos];
    let half = 0.5 / (camera.scale * camera.zoom.exp2());
    camera.center = [0, 1]
        .map(|axis| turned[axis] * camera.center_turns + camera.center[axis] * (1.0 - camera.center_turns) + half);
    camera.center_turns = 0.0;
    (sampling.filter_radius, sampling.estimator_radius) = (0.0, 0.0);
}

/// The peak signal-to-noise ratio of two pictures of one size, in decibels.
fn psnr(a: &Image, b: &Image) -> f64 {
    let pairs = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    let error: f64 = pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum();
    -10.0 * (error / (3 * a.pixels.len()) as f64).max(1e-10).log10()
}

/// All figures with their bounds, and whether these are kept.
fn verdict(sources: &BTreeMap<&'static str, Source>) -> (Value, bool) {
    let mut is_kept = true;
    let mut rows = Vec::new();
    for (name, source) in sources {
        let all = source.drawn + source.refused + source.unreadable;
        let percent = 100.0 * f64::from(source.drawn) / f64::from(all.max(1));
        let least = LEAST_DRAWN.iter().find(|(program, _)| program.name() == *name).map(|(_, least)| *least);
        is_kept &= least.is_none_or(|least| percent >= least);
        let mut decibels = source.decibels.clone();
        decibels.sort_by(f64::total_cmp);
        let agreeing = decibels.iter().filter(|found| **found >= AGREES_DB).count();
        let agreeing = 100.0 * agreeing as f64 / decibels.len().max(1) as f64;
        is_kept &= decibels.is_empty() || agreeing >= LEAST_AGREEING;
        let most = |counts: &BTreeMap<String, u32>| {
            let mut counts: Vec<_> = counts.iter().collect();
            counts.sort_by_key(|(name, count)| (std::cmp::Reverse(**count), *name));
            counts.into_iter().take(40).map(|(name, count)| json!([name, count])).collect::<Vec<_>>()
        };
        rows.push(json!({
            "program": name,
            "genomes": all,
            "drawn": source.drawn,
            "drawn_percent": percent,
            "least_percent": least,
            "refused": source.refused,
            "unreadable": source.unreadable,
            "refused_for": most(&source.reasons),
            "drawn_without": most(&source.without),
            "compared": decibels.len(),
            "median_db": decibels.get(decibels.len() / 2),
            "agreeing_percent": (!decibels.is_empty()).then_some(agreeing),
        }));
    }
    (json!({ "sources": rows, "agrees_db": AGREES_DB, "least_agreeing_percent": LEAST_AGREEING }), is_kept)
}
