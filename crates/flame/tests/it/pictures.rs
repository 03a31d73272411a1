//! What pictures are independent of, and what they survive.
//!
//! Owns claims about whole renders that need no other renderer beside ours; `flam3.rs` compares.

use crate::bred;
use flame::genome::{Genome, TemporalShape};
use flame::variations::{Kind, Variation};
use flame::{Arithmetic, Filter, FrameCost, Image, Loop, Motion, RenderError, Renderer, Settings, Transition};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

const SMALL: Settings = Settings {
    size: Some([64, 48]),
    spp: Some(50.0),
    psnr: None,
    supersample: Some(2),
    temporal_samples: Some(4),
    filter: Filter::Variance,
    seed: 5,
    arithmetic: Arithmetic::Fastest,
};

fn xaos() -> Genome {
    Genome::parse(include_str!("../genomes/xaos.flam3")).unwrap()
}

fn brightness(image: &Image) -> f64 {
    image.pixels.as_flattened().iter().map(|light| f64::from(*light)).sum::<f64>() / image.pixels.len() as f64
}

fn psnr(image: &Image, truth: &Image) -> f64 {
    let pairs = image.pixels.as_flattened().iter().zip(truth.pixels.as_flattened());
    let error: f64 = pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum();
    -10.0 * (error / (3 * truth.pixels.len()) as f64).log10()
}

#[test]
fn pixels_are_the_same_for_any_number_of_threads() {
    // Enough samples for several parts, which threads take as they come.
    let settings = Settings { spp: Some(1500.0), ..SMALL };
    for seed in 0..12 {
        let turning = Loop::new(&if seed == 0 { xaos() } else { bred::genome(seed) }, 30.0);
        let draw = |threads| Renderer::new(threads).unwrap().render(&turning, 7.0, &settings).unwrap();
        let alone = draw(1);
        assert!(seed > 0 || brightness(&alone) > 0.05);
        for threads in [2, 3, 7] {
            assert_eq!(alone, draw(threads), "genome {seed}, {threads} threads");
        }
    }
}

#[test]
fn pixels_are_the_same_for_every_instruction_set() {
    let renderer = Renderer::new(2).unwrap();
    let mut genomes: Vec<Genome> = (0..40).map(bred::genome).collect();
    genomes.push(xaos());
    for (number, genome) in genomes.iter().enumerate() {
        let draw = |arithmetic| renderer.render(genome, 0.0, &Settings { arithmetic, ..SMALL }).unwrap();
        let portable = draw(Arithmetic::Portable);
        assert_eq!(draw(Arithmetic::Fastest), portable, "genome {number}");
        assert_eq!(draw(Arithmetic::Avx2), portable, "genome {number} by AVX2");
    }
}

/// The checksum of the pictures that [`flame::VERSION`] makes. Where it changes, so must the version: else a clip that was
/// begun by one renderer is finished by another.
const PICTURES: (u32, u64) = (4, 207_015_997_764_396_559);

#[test]
fn another_renderer_has_another_version() {
    let renderer = Renderer::new(2).unwrap();
    let mut checksum = 0xcbf2_9ce4_8422_2325_u64;
    for seed in 0..12 {
        let sheep = [bred::genome(seed), bred::genome(seed + 100)].map(|genome| Loop::new(&genome, 60.0));
        let between = Transition::new(&sheep[0], &sheep[1], 30.0);
        for (motion, filter) in [(&sheep[0] as &dyn Motion, Filter::Variance), (&between, Filter::Flam3)] {
            let image = renderer.render(motion, 11.0, &Settings { filter, ..SMALL }).unwrap();
            for byte in image.to_rgb16().iter().flat_map(|light| light.to_le_bytes()) {
                checksum = (checksum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        }
    }
    assert_eq!((flame::VERSION, checksum), PICTURES, "raise `flame::VERSION` and write both down here");
}

#[test]
fn colours_that_are_pulled_slowly_are_where_they_would_be_after_all_time() {
    // After the first transform both are as likely; after the second it is 0.3 to 1: 0.684 of all steps are of the second.
    let text = "<flame size=\"64 48\" scale=\"12\" brightness=\"0.3\" gamma=\"1\">\
        <xform weight=\"1\" color=\"0\" color_speed=\"0.002\" coefs=\"0.6 0.3 -0.4 0.5 0.5 0.2\" linear=\"1\"/>\
        <xform weight=\"1\" color=\"1\" color_speed=\"0.002\" coefs=\"0.7 -0.2 0.3 0.6 -0.4 0.3\" linear=\"1\" chaos=\"0.3 1\"/>\
        </flame>";
    let mut genome = Genome::parse(text).unwrap();
    let palette = |entry: usize| [255.0 - entry as f64, 0.0, entry as f64, 255.0];
    genome.palette = Some(flame::genome::Palette::from_fn(palette));
    let settings = Settings { size: None, spp: Some(3000.0), ..SMALL };
    let image = Renderer::new(2).unwrap().render(&genome, 0.0, &settings).unwrap();
    let [red, blue] = [0, 2].map(|channel| image.pixels.iter().map(|pixel| f64::from(pixel[channel])).sum::<f64>());
    let place = blue / (red + blue);
    assert!((place - 0.5 / (0.5 + 0.3 / 1.3)).abs() < 0.02, "{place}");
}

#[test]
fn another_seed_is_another_noise_in_the_same_picture() {
    let renderer = Renderer::new(0).unwrap();
    let draw = |seed| renderer.render(&xaos(), 0.0, &Settings { seed, ..SMALL }).unwrap();
    let (one, other) = (draw(1), draw(2));
    assert_ne!(one, other);
    assert!((brightness(&one) - brightness(&other)).abs() < 0.02 * brightness(&one));
}

#[test]
fn brightness_does_not_depend_on_size_quality_cells_or_moments() {
    let renderer = Renderer::new(0).unwrap();
    // A cloud without fine structure: where there is some, a logarithm of a mean is not a mean of logarithms.
    let mut genome = Genome { xforms: xaos().xforms.split_off(2), ..xaos() };
    genome.xforms[0].variations = vec![Variation::new(Kind::GaussianBlur, 1.5)];
    let draw = |settings: &Settings| brightness(&renderer.render(&genome, 0.0, settings).unwrap());
    let usual = Settings { spp: Some(400.0), ..SMALL };
    let first = draw(&usual);
    for changed in [
        Settings { size: Some([128, 96]), ..usual },
        Settings { spp: Some(1200.0), ..usual },
        Settings { supersample: Some(1), ..usual },
        Settings { temporal_samples: Some(1), ..usual },
    ] {
        let second = draw(&changed);
        assert!((first - second).abs() < 0.03 * first, "{first} became {second} by {changed:?}");
    }
}

#[test]
fn a_soft_shutter_is_as_bright_as_a_hard_one() {
    let renderer = Renderer::new(0).unwrap();
    let draw = |shape| {
        let mut genome = xaos();
        genome.sampling.temporal_shape = shape;
        genome.sampling.temporal_exponent = 2.0;
        let settings = Settings { spp: Some(400.0), temporal_samples: Some(20), ..SMALL };
        brightness(&renderer.render(&genome, 0.0, &settings).unwrap())
    };
    let hard = draw(TemporalShape::Box);
    for shape in [TemporalShape::Gaussian, TemporalShape::Exp] {
        assert!((draw(shape) - hard).abs() < 0.03 * hard, "{shape:?}: {} instead of {hard}", draw(shape));
    }
}

/// A genome that lets filters work.
fn noisy() -> Genome {
    let mut genome = xaos();
    genome.sampling.estimator_radius = 9.0;
    genome
}

/// `genome` at 96x72, 2 x 2 cells a pixel.
fn filtered(genome: &Genome, spp: f64, filter: Filter, seed: u64) -> Image {
    let settings = Settings { size: Some([96, 72]), spp: Some(spp), temporal_samples: Some(1), filter, seed, ..SMALL };
    Renderer::new(0).unwrap().render(genome, 0.0, &settings).unwrap()
}

/// What filters are judged by: one with much noise, and two of the demo.
fn judged() -> [(&'static str, Genome); 3] {
    let demo = |text: &str| Genome::parse(text).unwrap();
    [
        ("xaos", noisy()),
        ("caldera", demo(include_str!("../../../../flock-tools/demo/genomes/caldera.flam3"))),
        ("nocturne", demo(include_str!("../../../../flock-tools/demo/genomes/nocturne.flam3"))),
    ]
}

#[test]
fn the_noise_filter_gains_much_from_few_samples_and_loses_nothing_of_many() {
    for (name, genome) in &judged() {
        let truth = filtered(genome, 20_000.0, Filter::None, 1);
        let mut before = 0.0;
        for (spp, gain) in [(20.0, 1.0), (80.0, 0.5), (400.0, 0.0), (4000.0, -0.05)] {
            let [raw, smooth] =
                [Filter::None, Filter::Variance].map(|filter| psnr(&filtered(genome, spp, filter, 2), &truth));
            println!("{name}, {spp} samples per pixel: {raw:.2} dB as they are, {smooth:.2} dB filtered");
            assert!(smooth >= raw + gain, "{name}, {spp} samples per pixel: {raw} dB became {smooth} dB");
            assert!(smooth > before, "{name}: the filter caps the picture at {before} dB");
            before = smooth;
        }
    }
}

#[test]
fn the_noise_filter_keeps_light_and_leaves_black_black() {
    // Few samples are too dark, because light bends: the filter may come nearer to what many show, and not farther from it.
    for (name, genome) in &judged() {
        let truth = brightness(&filtered(genome, 20_000.0, Filter::None, 1));
        for spp in [10.0, 100.0, 1000.0] {
            let [raw, smooth] =
                [Filter::None, Filter::Variance].map(|filter| brightness(&filtered(genome, spp, filter, 2)) / truth);
            println!("{name}, {spp} samples per pixel: light {raw:.4} as they are, {smooth:.4} filtered");
            let (before, after) = ((raw - 1.0).abs(), (smooth - 1.0).abs());
            assert!(after < before + 0.01, "{name}, {spp} samples per pixel: {raw} became {smooth} of the light");
        }
    }
    // A small bright disc far from all else.
    let mut genome = Genome { xforms: xaos().xforms.split_off(2), ..noisy() };
    genome.xforms[0].variations = vec![Variation::new(Kind::Blur, 0.1)];
    genome.xforms[0].post = flame::genome::Affine::IDENTITY;
    genome.tone.background = [0.0; 3];
    genome.camera.center = [0.0, 0.0];
    let [raw, smooth] = [Filter::None, Filter::Variance].map(|filter| filtered(&genome, 50.0, filter, 2));
    let is_lit = |number: usize| raw.pixels[number].iter().any(|light| *light > 0.0);
    assert!((0..raw.pixels.len()).any(is_lit), "nothing is in view");
    for (number, pixel) in smooth.pixels.iter().enumerate() {
        let (column, row) = ((number % 96) as isize, (number / 96) as isize);
        let near = (-3..=3).flat_map(|down| (-3..=3).map(move |across| (row + down, column + across)));
        let near = near.filter(|(row, column)| (0..72).contains(row) && (0..96).contains(column));
        if !near.map(|(row, column)| (row * 96 + column) as usize).any(is_lit) {
            assert!(pixel.iter().all(|light| *light < 0.5 / 255.0), "{column}, {row}: {pixel:?} was black");
        }
    }
}

#[test]
fn the_samples_of_a_picture_are_the_same_with_and_without_a_filter() {
    let settings = Settings { filter: Filter::None, ..SMALL };
    let renderer = Renderer::new(2).unwrap();
    let genome = xaos();
    let plain = renderer.render(&genome, 0.0, &settings).unwrap();
    let aimed = renderer.render_measured(&genome, 0.0, &Settings { psnr: Some(10.0), ..settings }).unwrap();
    let as_many = Settings { spp: Some(16.0), ..settings };
    assert!(psnr(&aimed.image, &renderer.render(&genome, 0.0, &as_many).unwrap()) > 90.0, "halves make the whole");
    assert_ne!(plain, aimed.image);
}

#[test]
fn a_frame_with_a_target_is_drawn_until_its_noise_is_that_small() {
    for (name, genome) in &judged() {
        let truth = filtered(genome, 30_000.0, Filter::None, 1);
        for filter in [Filter::None, Filter::Variance] {
            let mut before = 0;
            for target in [32.0, 36.0, 40.0, 44.0] {
                let settings = Settings {
                    size: Some([96, 72]),
                    temporal_samples: Some(1),
                    psnr: Some(target),
                    spp: Some(1.0),
                    filter,
                    ..SMALL
                };
                let draw = |threads| Renderer::new(threads).unwrap().render_measured(genome, 0.0, &settings).unwrap();
                let one = draw(1);
                assert_eq!(one, draw(3), "the rounds are the same for any number of threads");
                let (told, found) = (one.psnr.unwrap(), psnr(&one.image, &truth));
                let samples = one.samples;
                println!("{name}, {target} dB, {filter:?}: {samples} samples, told {told:.2}, found {found:.2}");
                assert!(told >= target && told < target + 6.0, "{name}, {target} dB: {told} dB");
                assert!(found > target - 0.05, "{name}, {target} dB: told {told} dB, found {found} dB");
                assert!(samples >= before, "{name}, {target} dB");
                before = samples;
            }
            assert!(before > 3_000_000, "{name}: as many for 44 dB");
        }
    }
    let genome = noisy();
    for bad in [0.0, -3.0, 9.9, 60.1, 200.0, f64::NAN, f64::INFINITY] {
        let refused = FrameCost::of(&genome, 0.0, &Settings { psnr: Some(bad), ..SMALL });
        assert!(matches!(refused, Err(RenderError::Range { name: "psnr", .. })), "{bad}: {refused:?}");
    }
    let refused = FrameCost::of(&genome, 0.0, &Settings { psnr: Some(40.0), filter: Filter::Flam3, ..SMALL });
    assert!(refused.unwrap_err().to_string().contains("flam3"));
}

#[test]
fn no_legal_genome_makes_anything_but_light() {
    let renderer = Renderer::new(0).unwrap();
    for seed in 0..60 {
        let mut genome = bred::genome(seed);
        genome.camera.zoom = 0.0;
        let image = renderer.render(&genome, 0.0, &Settings { spp: Some(5.0), ..SMALL }).unwrap();
        assert!(image.pixels.as_flattened().iter().all(|light| (0.0..=1.0).contains(light)), "seed {seed}");
    }
}

#[test]
fn a_renderer_that_is_told_to_stop_leaves_off_at_once() {
    let stop = Arc::new(AtomicBool::new(true));
    let renderer = Renderer::new(2).unwrap().with_stop_flag(Arc::clone(&stop));
    let endless = Settings { spp: Some(1e6), size: Some([1000, 1000]), ..SMALL };
    assert_eq!(renderer.render(&xaos(), 0.0, &endless), Err(RenderError::Stopped));
    let endless = Settings { psnr: Some(60.0), ..endless };
    assert_eq!(renderer.render(&xaos(), 0.0, &endless), Err(RenderError::Stopped));
    stop.store(false, Ordering::Relaxed);
    assert!(renderer.render(&xaos(), 0.0, &SMALL).is_ok());
}

#[test]
fn a_frame_tells_what_it_takes_before_it_is_drawn() {
    let demand = FrameCost::of(&xaos(), 0.0, &SMALL).unwrap();
    // Two halves of whole steps of 2048 orbits.
    assert_eq!(demand.samples, (64_u64 * 48 * 50).next_multiple_of(4096));
    let large = FrameCost::of(&xaos(), 0.0, &Settings { size: Some([6400, 4800]), ..SMALL }).unwrap();
    let cells = 4 * 6400 * 4800;
    assert!((40 * cells..60 * cells).contains(&large.bytes), "{large:?}");
    for change in [
        Settings { spp: Some(0.0), ..SMALL },
        Settings { spp: Some(f64::NAN), ..SMALL },
        Settings { spp: Some(1e300), ..SMALL },
        Settings { temporal_samples: Some(0), ..SMALL },
        Settings { temporal_samples: Some(u32::MAX), ..SMALL },
        Settings { supersample: Some(0), ..SMALL },
        Settings { supersample: Some(u32::MAX), ..SMALL },
        Settings { size: Some([0, 48]), ..SMALL },
        Settings { size: Some([u32::MAX, u32::MAX]), ..SMALL },
    ] {
        let refused = FrameCost::of(&xaos(), 0.0, &change);
        assert!(matches!(refused, Err(RenderError::Range { .. })), "{change:?}: {refused:?}");
    }
}

#[test]
fn what_cannot_be_drawn_is_refused_by_name() {
    let renderer = Renderer::new(1).unwrap();
    let refused = |change: fn(&mut Genome)| {
        let mut genome = xaos();
        change(&mut genome);
        renderer.render(&genome, 0.0, &SMALL).unwrap_err().to_string()
    };
    assert_eq!(
        refused(|genome| genome.palette = None),
        "the genome has no palette, only the number of one in flam3's library"
    );
    assert_eq!(refused(|genome| genome.xforms.clear()), "the genome has no transform with a weight above 0, among 0");
    assert_eq!(refused(|genome| genome.camera.scale = 0.0), "`scale` is 0, expected a finite number above 0");
    let unknown = refused(|genome| genome.xforms[1].extra.push(("waltz".into(), "0.7".into())));
    assert_eq!(unknown, "this renderer does not draw the variation `waltz` (`0.7`, transform 1)");
}
