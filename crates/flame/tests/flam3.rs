//! Our pictures against those of `flam3-render`, used as a black box.
//!
//! Owns the comparison at 2000 samples per pixel without density estimation. The genomes in `genomes/` were bred
//! for it and together use every variation and every feature of a transform. Where `flam3-render` (Debian:
//! `flam3-utils`) is missing these tests fail: install it.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![allow(clippy::float_cmp, reason = "values are read, not computed")]

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::Command;

use flame::genome::Genome;
use flame::variations::Kind;
use flame::{Image, Renderer, Settings};

/// Least agreement with flam3, in decibels.
const LEAST_PSNR: f64 = 35.0;

fn genomes() -> Vec<(PathBuf, Genome)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/genomes");
    let mut files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let read = |path: PathBuf| {
        let genome = Genome::parse(&fs::read_to_string(&path).unwrap()).unwrap();
        (path, genome)
    };
    files.into_iter().map(read).collect()
}

/// The picture that `flam3-render` makes of a file: red, green, blue bytes.
fn theirs(genome: &Path) -> Vec<u8> {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join(genome.with_extension("png").file_name().unwrap());
    let run = Command::new("flam3-render")
        .env("in", genome)
        .env("out", &out)
        .env("format", "png")
        .env("nthreads", "1")
        .env("isaac_seed", "agreement")
        .env("verbose", "0")
        .output()
        .expect("`flam3-render` runs: install the package `flam3-utils`");
    assert!(run.status.success(), "flam3-render: {}", String::from_utf8_lossy(&run.stderr));
    let mut reader = png::Decoder::new(BufReader::new(File::open(out).unwrap())).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let channels = reader.next_frame(&mut pixels).unwrap().color_type.samples();
    pixels.chunks(channels).flat_map(|pixel| &pixel[..3]).copied().collect()
}

/// Peak signal-to-noise ratio of two byte pictures, in decibels.
fn psnr(ours: &Image, theirs: &[u8]) -> f64 {
    let ours = ours.to_rgb8();
    assert_eq!(ours.len(), theirs.len());
    let error: f64 = ours.iter().zip(theirs).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
    10.0 * (255.0 * 255.0 * ours.len() as f64 / error.max(1.0)).log10()
}

#[test]
fn pictures_agree_with_flam3() {
    let renderer = Renderer::new(0).unwrap();
    let mut worse = Vec::new();
    for (path, genome) in genomes() {
        assert_eq!((genome.sampling.quality, genome.sampling.estimator_radius), (2000.0, 0.0), "{}", path.display());
        let settings = Settings { temporal_samples: Some(1), seed: 1, ..Settings::default() };
        let image = renderer.render(&genome, 0.0, &settings).unwrap();
        let agreement = psnr(&image, &theirs(&path));
        println!("{agreement:5.1} dB {}", path.file_stem().unwrap().to_string_lossy());
        let lit = image.pixels.iter().filter(|[red, green, blue]| red + green + blue > 0.1).count();
        assert!(lit * 10 > image.pixels.len(), "{} is nearly black: it proves nothing", path.display());
        if agreement < LEAST_PSNR {
            worse.push((path, agreement));
        }
    }
    assert!(worse.is_empty(), "below {LEAST_PSNR} dB: {worse:?}");
}

#[test]
fn the_genomes_use_every_variation_and_every_feature() {
    let genomes: Vec<Genome> = genomes().into_iter().map(|(_, genome)| genome).collect();
    assert!(genomes.len() >= 12);
    let drawn = |genome: &Genome| genome.xforms.iter().chain(&genome.final_xform).cloned().collect::<Vec<_>>();
    let xforms: Vec<_> = genomes.iter().flat_map(drawn).collect();
    let used: BTreeSet<Kind> = xforms.iter().flat_map(|xform| &xform.variations).map(|v| v.kind).collect();
    assert_eq!(used.len(), Kind::ALL.len(), "only {used:?}");
    assert!(xforms.iter().any(|xform| xform.post != flame::genome::Affine::IDENTITY));
    assert!(xforms.iter().any(|xform| !xform.chaos.is_empty()));
    assert!(xforms.iter().any(|xform| xform.opacity < 1.0 && xform.opacity > 0.0));
    assert!(genomes.iter().any(|genome| genome.final_xform.is_some()));
    assert!(genomes.iter().any(|genome| genome.symmetries.iter().any(|kind| *kind < 0)));
    assert!(genomes.iter().any(|genome| genome.palette_mode == flame::genome::PaletteMode::Linear));
}
