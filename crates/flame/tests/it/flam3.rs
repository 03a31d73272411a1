//! Our pictures against those of `flam3-render`, used as a black box.
//!
//! Owns the comparison without density estimation. The genomes in `genomes/` were bred for it and together use every
//! variation of the paper and every feature of a transform; those of `mixed/` have each variation by itself. Where
//! `flam3-render` (Debian: `flam3-utils`) is missing these tests fail: install it.
//!
//! Both renderers make noise, so a picture of theirs does not agree with another of theirs, drawn with other random
//! numbers. A picture of ours has to agree as well.

#![allow(clippy::float_cmp, reason = "values are read, not computed")]

use std::collections::BTreeSet;
use std::env;
use std::fmt::{self, Display, Formatter};
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{LazyLock, Mutex};
use std::thread;

use crate::mixed;
use flame::genome::Genome;
use flame::variations::Kind;
use flame::{Image, Renderer, Settings};

/// Samples per pixel, unless `$SPP` names another number: the tests of every day have no time for 2000.
const SAMPLES: f64 = 250.0;

static SPP: LazyLock<f64> = LazyLock::new(|| env::var("SPP").map_or(SAMPLES, |told| told.parse().unwrap()));

/// How much less than theirs with theirs ours may agree with theirs, in decibels.
const LEEWAY: f64 = 0.5;

/// What agrees as well as this is not told apart from theirs, in decibels: an error of 0.8 of 255 steps, as bytes have
/// themselves.
const ENOUGH: f64 = 50.0;

/// A genome in a file that both renderers read.
struct Case {
    name: String,
    file: PathBuf,
    genome: Genome,
}

/// What a comparison found.
struct Finding {
    name: String,
    /// How ours agrees with theirs, in decibels.
    ours: f64,
    /// How theirs agrees with theirs.
    theirs: f64,
    /// Whether the picture is nearly black: it proves nothing.
    is_dark: bool,
}

impl Finding {
    fn is_bad(&self) -> bool {
        self.is_dark || self.ours < self.theirs.min(ENOUGH) - LEEWAY
    }
}

impl Display for Finding {
    fn fmt(&self, text: &mut Formatter) -> fmt::Result {
        let Finding { name, ours, theirs, is_dark } = self;
        let dark = if *is_dark { ", dark" } else { "" };
        write!(text, "{:+6.2} dB: {ours:4.1} for {theirs:4.1}, {name}{dark}", ours - theirs)
    }
}

impl Case {
    fn read(name: String, file: PathBuf) -> Case {
        let genome = Genome::parse(&fs::read_to_string(&file).unwrap()).unwrap();
        assert_eq!((genome.sampling.quality, genome.sampling.estimator_radius), (2000.0, 0.0), "{name}");
        Case { name, file, genome }
    }

    /// What a comparison finds. A picture that agrees too little may do so by chance: then the mean of more decides.
    fn compare(&self) -> Finding {
        let first = self.finding(1, 2);
        if first.is_bad() { self.finding(4, 4) } else { first }
    }

    /// Compares so many pictures of ours and of theirs, each with each.
    fn finding(&self, ours: u64, theirs: usize) -> Finding {
        let ours: Vec<Image> = (1..=ours).map(|seed| self.ours(seed)).collect();
        let theirs: Vec<Vec<u8>> =
            ["one", "two", "three", "four"][..theirs].iter().map(|seed| self.theirs(seed)).collect();
        let lit = ours[0].pixels.iter().filter(|[red, green, blue]| red + green + blue > 0.1).count();
        let is_dark = lit * 10 < ours[0].pixels.len();
        let noise: Vec<f64> =
            theirs.iter().enumerate().flat_map(|(i, a)| theirs[..i].iter().map(|b| square_error(a, b))).collect();
        let ours: Vec<Vec<u8>> = ours.iter().map(cut).collect();
        let errors: Vec<f64> = ours.iter().flat_map(|a| theirs.iter().map(|b| square_error(a, b))).collect();
        Finding { name: self.name.clone(), ours: psnr(&errors), theirs: psnr(&noise), is_dark }
    }

    fn ours(&self, seed: u64) -> Image {
        let settings = Settings { spp: Some(*SPP), temporal_samples: Some(1), seed, ..Settings::default() };
        Renderer::new(1).unwrap().render(&self.genome, 0.0, &settings).unwrap()
    }

    /// The picture that `flam3-render` makes: red, green, blue bytes.
    fn theirs(&self, seed: &str) -> Vec<u8> {
        let out = scratch(&self.name, "png");
        let run = Command::new("flam3-render")
            .env("in", &self.file)
            .env("out", &out)
            .env("format", "png")
            .env("nthreads", "1")
            .env("isaac_seed", seed)
            // Sums in double precision. Else it counts each colour of a sample in whole steps of 255, downwards: at an opacity
            // of 0.5, which is a tenth of the light, dark colours lose much, at 0.25 all.
            .env("bits", "64")
            .env("qs", (*SPP / self.genome.sampling.quality).to_string())
            .env("verbose", "0")
            .output()
            .expect("`flam3-render` runs: install the package `flam3-utils`");
        let said = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.success() && said.trim().is_empty(), "flam3-render: {}: {said}", self.name);
        let mut reader = png::Decoder::new(BufReader::new(File::open(out).unwrap())).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let channels = reader.next_frame(&mut pixels).unwrap().color_type.samples();
        pixels.chunks(channels).flat_map(|pixel| &pixel[..3]).copied().collect()
    }
}

fn scratch(name: &str, extension: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name).with_extension(extension)
}

/// The genomes in `genomes/`.
fn bred() -> Vec<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/genomes");
    let mut files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.into_iter().map(|file| Case::read(file.file_stem().unwrap().to_string_lossy().into_owned(), file)).collect()
}

/// The genomes of `mixed/`.
fn mixed() -> Vec<Case> {
    let write = |(name, text): (String, String)| {
        let file = scratch(&name, "flam3");
        fs::write(&file, text).unwrap();
        Case::read(name, file)
    };
    mixed::texts().into_iter().map(write).collect()
}

/// The bytes of a picture, rounded down as flam3 does. [`Image::to_rgb8`] rounds to the nearest.
fn cut(image: &Image) -> Vec<u8> {
    image.pixels.as_flattened().iter().map(|light| (light * 255.0) as u8).collect()
}

/// The mean square of the differences of two byte pictures.
fn square_error(one: &[u8], other: &[u8]) -> f64 {
    assert_eq!(one.len(), other.len());
    let sum: f64 = one.iter().zip(other).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
    sum / one.len() as f64
}

/// The peak signal-to-noise ratio, in decibels, of the mean of some square errors.
fn psnr(square_errors: &[f64]) -> f64 {
    let mean = square_errors.iter().sum::<f64>() / square_errors.len() as f64;
    10.0 * (255.0 * 255.0 / mean.max(1e-3)).log10()
}

#[test]
fn pictures_agree_with_flam3() {
    let cases: Vec<Case> = bred().into_iter().chain(mixed()).collect();
    assert!(cases.len() >= 120, "only {}", cases.len());
    let findings = Mutex::new(Vec::new());
    let next = Mutex::new(cases.iter());
    thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let Some(case) = next.lock().unwrap().next() else { return };
                    let finding = case.compare();
                    println!("{finding}");
                    findings.lock().unwrap().push(finding);
                }
            });
        }
    });
    let bad: Vec<String> =
        findings.into_inner().unwrap().iter().filter(|one| one.is_bad()).map(Finding::to_string).collect();
    assert!(bad.is_empty(), "ours agree less than theirs do: {bad:#?}");
}

#[test]
fn the_genomes_use_every_variation_and_every_feature() {
    let genomes: Vec<Genome> = bred().into_iter().map(|case| case.genome).collect();
    assert!(genomes.len() >= 12);
    let drawn = |genome: &Genome| genome.xforms.iter().chain(&genome.finals).cloned().collect::<Vec<_>>();
    let xforms: Vec<_> = genomes.iter().flat_map(drawn).collect();
    let used: BTreeSet<Kind> = xforms.iter().flat_map(|xform| &xform.variations).map(|v| v.kind).collect();
    assert!(Kind::FLAM3[..=Kind::Cross as usize].iter().all(|kind| used.contains(kind)), "only {used:?}");
    assert!(xforms.iter().any(|xform| xform.post != flame::genome::Affine::IDENTITY));
    assert!(xforms.iter().any(|xform| !xform.chaos.is_empty()));
    assert!(xforms.iter().any(|xform| xform.opacity < 1.0 && xform.opacity > 0.0));
    assert!(genomes.iter().any(|genome| !genome.finals.is_empty()));
    assert!(genomes.iter().any(|genome| genome.symmetries.iter().any(|kind| *kind < 0)));
    assert!(genomes.iter().any(|genome| genome.palette_mode == flame::genome::PaletteMode::Linear));
}

#[test]
fn every_variation_is_mixed_with_two_values_of_each_parameter() {
    let mixtures: Vec<Genome> = mixed::texts().iter().map(|(_, text)| Genome::parse(text).unwrap()).collect();
    for kind in Kind::FLAM3 {
        let of_kind = mixtures.iter().flat_map(|genome| &genome.xforms[0].variations).filter(|v| v.kind == kind);
        let used: Vec<_> = of_kind.filter(|v| kind == Kind::Linear || v.weight > 0.5).collect();
        assert!(!used.is_empty(), "{kind:?} is in no mixture");
        // The base of a logarithm is not flam3's.
        let parameters = kind.parameters().len() - usize::from(kind == Kind::Log);
        for index in 0..parameters {
            let values: BTreeSet<u64> = used.iter().map(|v| v.params[index].to_bits()).collect();
            assert!(values.len() > 1, "{kind:?}: parameter {index} has one value");
        }
    }
}
