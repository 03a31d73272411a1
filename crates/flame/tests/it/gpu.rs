//! Pictures that a GPU draws, beside those of the processor.
//!
//! Owns the claim that both are the same but for chance, at equal samples. Any GPU that Vulkan knows will do, a software driver
//! too. Needs the feature `gpu`: `make gpu` runs it.

#![allow(clippy::print_stdout, reason = "the figures of each picture, where one looks for a reason")]

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use crate::mixed;
use flame::genome::Genome;
use flame::{Arithmetic, Backend, Filter, Image, Loop, Motion, RenderError, Renderer, Settings};

/// No filter: what is compared is samples.
const SETTINGS: Settings = Settings {
    size: Some([96, 72]),
    spp: Some(300.0),
    psnr: None,
    supersample: Some(1),
    temporal_samples: Some(50),
    filter: Filter::None,
    seed: 1,
    arithmetic: Arithmetic::Fastest,
};

/// How much more pictures of a GPU and of the processor may differ than those of either do by chance, in dB.
const TOLERANCE: f64 = 0.5;

/// How much noisier those of the GPU may be, in dB.
const NOISE: f64 = 1.0;

/// How much more or less light they may have, as a part of it.
const LIGHT: f64 = 0.005;

/// One for all tests: shaders are compiled once, and frames take turns.
static GPU: LazyLock<Renderer> = LazyLock::new(|| Renderer::new(2).unwrap().with_backend(Backend::gpu().unwrap()));

fn on_gpu(motion: &dyn Motion, seed: u64) -> Image {
    GPU.render(motion, 3.0, &Settings { seed, ..SETTINGS }).unwrap()
}

fn on_cpu(motion: &dyn Motion, seed: u64) -> Image {
    Renderer::new(2).unwrap().render(motion, 3.0, &Settings { seed, ..SETTINGS }).unwrap()
}

/// The mean square difference.
fn difference(one: &Image, other: &Image) -> f64 {
    let pairs = one.pixels.as_flattened().iter().zip(other.pixels.as_flattened());
    pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>() / one.pixels.as_flattened().len() as f64
}

/// In dB.
fn psnr(differences: impl IntoIterator<Item = f64>) -> f64 {
    let all: Vec<f64> = differences.into_iter().collect();
    -10.0 * (all.iter().sum::<f64>() / all.len() as f64).max(1e-12).log10()
}

/// How much `images` of different seeds differ.
fn noise(images: &[Image]) -> f64 {
    let pairs = (0..images.len()).flat_map(|one| (0..one).map(move |other| (one, other)));
    psnr(pairs.map(|(one, other)| difference(&images[one], &images[other])))
}

fn mean(images: &[Image]) -> f64 {
    let light = || images.iter().flat_map(|image| image.pixels.as_flattened());
    light().copied().map(f64::from).sum::<f64>() / light().count() as f64
}

/// What is wrong with the pictures of `motion` that the GPU draws, if anything is.
fn fault(name: &str, motion: &dyn Motion) -> Option<String> {
    // Where a few pictures leave a doubt, more of them tell.
    fault_of(3, name, motion).and_then(|_| fault_of(12, name, motion))
}

/// The same, by so many pictures of each.
fn fault_of(count: u64, name: &str, motion: &dyn Motion) -> Option<String> {
    let gpu: Vec<_> = (0..count).map(|seed| on_gpu(motion, seed)).collect();
    let cpu: Vec<_> = (count..2 * count).map(|seed| on_cpu(motion, seed)).collect();
    let noises = [noise(&gpu), noise(&cpu)];
    // What both have in noise, and no more.
    let usual = psnr(noises.map(|noise| 10_f64.powf(-noise / 10.0)));
    let found = psnr(gpu.iter().flat_map(|gpu| cpu.iter().map(|cpu| difference(gpu, cpu))));
    let (light, expected) = (mean(&gpu), mean(&cpu));
    let told = format!(
        "{name}: {found:.2} dB, by chance {usual:.2} ({:.2} on the GPU, {:.2} on the processor); light {light:.5} and \
         {expected:.5}",
        noises[0], noises[1]
    );
    println!("{told}");
    let is_alike = found >= usual - TOLERANCE && noises[0] >= noises[1] - NOISE;
    (!is_alike || (light / expected - 1.0).abs() > LIGHT).then_some(told)
}

fn genome(file: &str) -> Genome {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/genomes").join(file);
    Genome::parse(&fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn every_variation_gives_the_same_picture_on_a_gpu() {
    let texts = mixed::texts();
    assert!(texts.len() >= 99, "{}", texts.len());
    let faults: Vec<_> = texts.iter().filter_map(|(name, text)| fault(name, &Genome::parse(text).unwrap())).collect();
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn mixtures_xaos_final_transforms_opacity_and_symmetry_give_the_same_picture_on_a_gpu() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/genomes");
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    files.sort();
    assert!(files.len() > 10, "{files:?}");
    let of_file = |file: &std::ffi::OsString| fault(file.to_str().unwrap(), &genome(file.to_str().unwrap()));
    let faults: Vec<_> = files.iter().filter_map(of_file).collect();
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn a_loop_moves_and_blurs_alike_on_a_gpu() {
    let faults: Vec<_> = ["xaos.flam3", "post-and-final.flam3", "opacity.flam3"]
        .iter()
        .filter_map(|file| fault(file, &Loop::new(&genome(file), 30.0)))
        .collect();
    assert!(faults.is_empty(), "{faults:#?}");
    let moving = Loop::new(&genome("opacity.flam3"), 30.0);
    let still = Settings { temporal_samples: Some(1), ..SETTINGS };
    let (sharp, blurred) = (GPU.render(&moving, 3.0, &still).unwrap(), [1, 2, 3].map(|seed| on_gpu(&moving, seed)));
    assert!(psnr([difference(&sharp, &blurred[0])]) < noise(&blurred) - 6.0);
}

#[test]
fn noise_that_is_asked_for_is_reached_on_a_gpu() {
    let genome = genome("xaos.flam3");
    let settings = Settings { psnr: Some(36.0), filter: Filter::Variance, ..SETTINGS };
    let measured = GPU.render_measured(&genome, 3.0, &settings).unwrap();
    let expected = Renderer::new(2).unwrap().render_measured(&genome, 3.0, &settings).unwrap();
    let (samples, usual) = (measured.samples as f64, expected.samples as f64);
    assert!(measured.psnr >= Some(36.0) && (samples / usual - 1.0).abs() < 0.2, "{samples} samples, {usual} as a rule");
    let pictures = psnr([difference(&measured.image, &expected.image)]);
    assert!(pictures > 31.0, "{pictures} dB");
}

#[test]
fn one_device_gives_the_same_bits_each_time_and_others_with_another_seed() {
    let genome = genome("eight-with-xaos.flam3");
    let first = on_gpu(&genome, 5);
    assert!(first.pixels == on_gpu(&genome, 5).pixels);
    assert!(first.pixels != on_gpu(&genome, 6).pixels);
}

#[test]
fn sums_of_more_than_32_bits_are_exact_on_a_gpu() {
    // All samples fall into few cells: the transform is a point.
    let text = "<flame size=\"8 6\" scale=\"4\" filter=\"0.1\" quality=\"1\" temporal_samples=\"1\" estimator_radius=\"0\" \
                brightness=\"1\" gamma=\"1\"><xform weight=\"1\" color=\"0\" coefs=\"0 0 0 0 0.1 0.1\" linear=\"1\"/>\
                <color index=\"0\" rgb=\"40 20 10\"/></flame>";
    let genome = Genome::parse(text).unwrap();
    // 4.8 million samples of 2040 in one cell, which is more than 2^33.
    let settings = Settings { size: Some([8, 6]), spp: Some(100_000.0), ..SETTINGS };
    let gpu = GPU.render(&genome, 0.0, &settings).unwrap();
    let cpu = Renderer::new(2).unwrap().render(&genome, 0.0, &settings).unwrap();
    let brightest = cpu.pixels.as_flattened().iter().copied().fold(0.0, f32::max);
    assert!(brightest > 0.05, "{brightest}");
    let found = psnr([difference(&gpu, &cpu)]);
    assert!(found > 80.0, "{found} dB");
}

#[test]
fn a_frame_that_does_not_fit_into_the_gpu_is_refused_with_both_sizes() {
    let huge = Settings { size: Some([17_000, 17_000]), spp: Some(0.01), ..SETTINGS };
    let refused = GPU.render(&genome("xaos.flam3"), 0.0, &huge).unwrap_err();
    let RenderError::GpuMemory { needed, most, .. } = &refused else { panic!("{refused}") };
    assert!(*needed >= 4_600 && most < needed, "{refused}");
    // The next frame is drawn as if nothing had been.
    assert_eq!(fault("after the refusal", &genome("xaos.flam3")), None);
}
