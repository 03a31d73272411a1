//! Genomes that nobody means: refused by name, or drawn as light; never a panic, never a machine brought down.
//!
//! Owns claims about numbers far outside of taste. What ordinary genomes look like is for `pictures.rs`.

use flame::genome::{FilterShape, Genome};
use flame::variations::Kind;
use flame::{Arithmetic, Filter, FrameCost, Loop, Motion, RenderError, Renderer, Settings, Transition};

const TINY: Settings = Settings {
    size: Some([16, 12]),
    spp: Some(4.0),
    psnr: None,
    supersample: None,
    temporal_samples: Some(3),
    filter: Filter::Variance,
    seed: 1,
    arithmetic: Arithmetic::Fastest,
};

/// What a number may be in a file.
const NUMBERS: [&str; 12] =
    ["0", "-0", "1", "-1", "0.5", "1e-300", "-1e-300", "1e300", "-1e300", "1.7e308", "64", "4294967295"];

fn xaos() -> Genome {
    Genome::parse(include_str!("../genomes/xaos.flam3")).unwrap()
}

/// Draws `motion` at `frame` where it can be drawn: everything must then be light.
fn draw(motion: &dyn Motion, frame: f64, settings: &Settings, what: &str) -> Result<(), RenderError> {
    let demand = FrameCost::of(motion, frame, settings)?;
    if demand.samples > 10_000_000 || demand.bytes > 1 << 30 || demand.cell_steps > 100_000_000 {
        return Ok(());
    }
    let image = Renderer::new(1).unwrap().render(motion, frame, settings)?;
    let dark = image.pixels.as_flattened().iter().find(|light| !(0.0..=1.0).contains(*light));
    assert_eq!(dark, None, "{what}");
    Ok(())
}

#[test]
fn any_number_in_any_attribute_of_a_flame_is_refused_or_drawn() {
    let text = xaos().to_xml();
    let head = text.split('>').next().unwrap();
    let names: Vec<&str> =
        head.split('"').step_by(2).filter_map(|part| part.trim().strip_suffix('=')?.rsplit(' ').next()).collect();
    assert!(names.len() > 20, "{names:?}");
    for name in names {
        let start = text.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
        let end = start + text[start..].find('"').unwrap();
        let count = text[start..end].split(' ').count();
        for number in NUMBERS {
            let odd = format!("{}{}{}", &text[..start], [number].repeat(count).join(" "), &text[end..]);
            let Ok(genome) = Genome::parse(&odd) else { continue };
            for filter in [Filter::None, Filter::Variance, Filter::Flam3] {
                let what = format!("{name} = {number}, {filter:?}");
                let _ = draw(&Loop::new(&genome, 30.0), 7.0, &Settings { filter, ..TINY }, &what);
                let _ =
                    draw(&Loop::new(&genome, 30.0), 7.0, &Settings { size: None, spp: None, filter, ..TINY }, &what);
            }
        }
    }
}

#[test]
fn any_number_in_any_part_of_a_transform_is_drawn() {
    let plain =
        ["weight", "color", "color_speed", "opacity", "animate", "symmetry"].map(|name| (name.to_owned(), None));
    let kinds = Kind::ALL.into_iter().flat_map(|kind| {
        let parameters = kind.parameters().iter().map(move |one| (format!("{}_{}", kind.name(), one.name), Some(kind)));
        std::iter::once((kind.name().to_owned(), None)).chain(parameters)
    });
    let palette = "<color index=\"0\" rgb=\"255 128 0\"/>";
    for (name, of) in plain.into_iter().chain(kinds) {
        for number in NUMBERS {
            let with = of.map_or(String::new(), |kind| format!("{}=\"0.7\"", kind.name()));
            let post = if number == "0" { "post=\"0 0 0 0 0 0\"" } else { "" };
            let odd = format!(
                "<flame><xform weight=\"1\" coefs=\"0 0 0 0 0 0\" julia=\"1\"/>\
                 <xform coefs=\"0.5 0.1 -0.2 0.6 0.3 {number}\" chaos=\"{number} {number}\" {post} {with} {name}=\"{number}\"/>\
                 <finalxform linear=\"1\"/>{palette}</flame>"
            );
            let what = format!("{name} = {number}");
            let Ok(genome) = Genome::parse(&odd) else { panic!("{what}: {:?}", Genome::parse(&odd)) };
            let _ = draw(&Loop::new(&genome, 30.0), 7.0, &TINY, &what);
            let way = Transition::new(&Loop::new(&genome, 30.0), &Loop::new(&xaos(), 20.0), 10.0);
            draw(&way, 5.0, &TINY, &what).unwrap_or_else(|error| panic!("half way, {what}: {error}"));
        }
    }
}

#[test]
fn a_transition_between_unlike_samplings_is_drawn_at_every_moment() {
    let (mut a, mut b) = (xaos(), xaos());
    (a.camera.size, b.camera.size) = ([60, 40], [30, 30]);
    (a.sampling.supersample, b.sampling.supersample) = (1, 3);
    (a.sampling.filter_radius, b.sampling.filter_radius) = (0.3, 4.0);
    (a.sampling.filter_shape, b.sampling.filter_shape) = (FilterShape::Gaussian, FilterShape::Lanczos3);
    (a.sampling.temporal_width, b.sampling.temporal_width) = (2.0, 3.0);
    for (from, to) in [(&a, &b), (&b, &a)] {
        let way = Transition::new(&Loop::new(from, 20.0), &Loop::new(to, 30.0), 4.0);
        for frame in 0..9 {
            let settings = Settings { size: None, temporal_samples: Some(9), ..TINY };
            draw(&way, f64::from(frame) / 2.0, &settings, "half way").unwrap();
            draw(&way, f64::from(frame) / 2.0, &Settings { temporal_samples: Some(9), ..TINY }, "half way").unwrap();
        }
    }
}

#[test]
fn what_nothing_chooses_at_either_end_is_not_missed_on_the_way() {
    let weights = |weights: [f64; 2]| {
        let mut genome = xaos();
        genome.xforms.truncate(2);
        for (xform, weight) in genome.xforms.iter_mut().zip(weights) {
            xform.weight = weight;
        }
        Loop::new(&genome, 30.0)
    };
    let way = Transition::new(&weights([1.0, -1.0]), &weights([-1.0, 1.0]), 10.0);
    draw(&way, 5.0, &TINY, "half way").unwrap();
}

#[test]
fn what_would_take_all_memory_or_for_ever_is_refused() {
    let named = |change: &dyn Fn(&mut Genome), settings: &Settings| {
        let mut genome = xaos();
        change(&mut genome);
        match FrameCost::of(&genome, 0.0, settings) {
            Err(RenderError::Range { name, .. }) => name,
            other => panic!("{other:?}"),
        }
    };
    let own = Settings { size: None, spp: None, temporal_samples: None, filter: Filter::Flam3, ..TINY };
    assert_eq!(named(&|genome| genome.camera.size = [0, 0], &TINY), "scale");
    assert_eq!(named(&|genome| genome.camera.zoom = 1e3, &own), "zoom");
    assert_eq!(named(&|genome| genome.sampling.quality = 1e300, &own), "quality");
    assert_eq!(named(&|genome| genome.sampling.estimator_radius = 1e9, &own), "estimator_radius");
    assert_eq!(named(&|genome| genome.sampling.temporal_samples = u32::MAX, &own), "temporal_samples");
    let wide = |genome: &mut Genome| (genome.sampling.filter_radius, genome.sampling.supersample) = (64.0, 64);
    assert_eq!(named(&wide, &own), "filter");
    let many = |genome: &mut Genome| genome.xforms = genome.xforms.iter().cycle().take(100_000).cloned().collect();
    assert_eq!(named(&many, &own), "xform");
    assert_eq!(named(&|genome| genome.symmetries = vec![i32::MIN], &own), "xform");
    assert_eq!(named(&|genome| genome.symmetries = vec![200; 1_000_000], &own), "xform");
    let (many, few) = (Genome { symmetries: vec![i32::MAX], ..xaos() }, xaos());
    let way = Transition::new(&Loop::new(&many, 10.0), &Loop::new(&few, 10.0), 10.0);
    assert!(matches!(FrameCost::of(&way, 5.0, &TINY), Err(RenderError::Range { name: "xform", .. })));
}

/// A frame as Electric Sheep's best ones: 4K, 4 x 4 cells a pixel, quality 2000, zoom 2, estimator 11.
fn large(change: impl Fn(&mut Genome)) -> Genome {
    let mut genome = xaos();
    genome.camera = genome.camera.resized([3840, 2160]);
    genome.camera.zoom = 2.0;
    genome.sampling.quality = 2000.0;
    genome.sampling.supersample = 4;
    genome.sampling.filter_radius = 1.0;
    genome.sampling.estimator_radius = 11.0;
    change(&mut genome);
    genome
}

#[test]
fn what_takes_for_ever_is_refused_by_its_cost_and_real_frames_are_not() {
    let own = Settings { size: None, spp: None, temporal_samples: None, filter: Filter::Flam3, ..TINY };
    let real = FrameCost::of(&large(|_| ()), 0.0, &own).unwrap();
    assert_eq!(real.samples, 3840 * 2160 * 2000 * 16);
    let told = |genome: &Genome| FrameCost::of(genome, 0.0, &own).unwrap_err().to_string();
    let hd = |genome: &mut Genome| genome.camera = genome.camera.resized([1280, 720]);
    let odd = |change: fn(&mut Genome)| {
        told(&large(|genome| {
            hd(genome);
            change(genome);
        }))
    };
    assert_eq!(
        odd(|genome| genome.camera.zoom = 12.0),
        "`zoom` is 12, expected quality * 4^zoom of at most 1e6 in a pixel, and 1 to 1e12 samples in a frame"
    );
    assert_eq!(
        odd(|genome| (genome.sampling.filter_radius, genome.sampling.supersample) = (60.0, 16)),
        "`filter` is 60, expected a radius by which a frame adds up at most 2e10 cells"
    );
    assert_eq!(
        odd(|genome| genome.sampling.estimator_radius = 100.0),
        "`estimator_radius` is 100, expected a radius of at most 256 cells, by which a frame looks at most at 2e12 cells"
    );
    assert_eq!(
        odd(|genome| genome.sampling.supersample = 64),
        "`supersample` is 64, expected at most 1e9 histogram cells"
    );
    // Of a picture of any size, the largest number that passes stays below what is promised.
    let changes: [fn(&mut Genome, f64); 4] = [
        |genome, value| genome.camera.zoom = value,
        |genome, value| genome.sampling.filter_radius = value,
        |genome, value| genome.sampling.estimator_radius = value,
        |genome, value| genome.sampling.supersample = value as u32,
    ];
    for (size, change) in [[16, 12], [640, 480], [3840, 2160]].iter().flat_map(|size| changes.map(|one| (*size, one))) {
        let cost = |value: f64| {
            let genome = large(|genome| {
                genome.camera = genome.camera.resized(size);
                change(genome, value);
            });
            FrameCost::of(&genome, 0.0, &own)
        };
        let (mut passes, mut fails) = (1.0, 4096.0);
        for _ in 0..40 {
            let middle = f64::midpoint(passes, fails);
            if cost(middle).is_ok() { passes = middle } else { fails = middle }
        }
        let most = cost(passes).unwrap();
        assert!(most.samples <= 1_000_000_000_000 && most.cell_steps <= 2_100_000_000_000, "{size:?}: {most:?}");
        assert!(cost(fails).is_err() && fails < 4096.0, "{size:?}: {fails}");
    }
}

#[test]
fn the_widest_kernels_that_pass_are_drawn_on_a_small_picture() {
    // The widest filter and the widest estimator that pass, on a picture that one can wait for.
    let mut genome = xaos();
    genome.sampling.filter_radius = 64.0;
    genome.sampling.estimator_radius = 100.0;
    let settings = Settings { size: Some([96, 72]), spp: Some(0.1), filter: Filter::Flam3, ..TINY };
    let cost = FrameCost::of(&genome, 0.0, &settings).unwrap();
    assert!((30_000_000..600_000_000).contains(&cost.cell_steps), "{cost:?}");
    for filter in [Filter::Variance, Filter::Flam3] {
        Renderer::new(1).unwrap().render(&genome, 0.0, &Settings { filter, ..settings }).unwrap();
    }
}

#[test]
fn the_moments_of_many_transforms_are_refused_before_they_take_all_memory() {
    let mut genome = xaos();
    genome.xforms = genome.xforms.iter().cycle().take(256).cloned().collect();
    genome.sampling.temporal_samples = 10_000;
    let settings = Settings { temporal_samples: None, ..TINY };
    let refused = FrameCost::of(&genome, 0.0, &settings).unwrap_err();
    assert!(matches!(refused, RenderError::Range { name: "temporal_samples", .. }), "{refused}");
}

#[test]
fn a_file_nested_as_deep_as_it_likes_is_read_or_refused() {
    for depth in [100, 1_000, 1_000_000] {
        for (open, close) in [("<edit>", "</edit>"), ("<flame>", "</flame>"), ("<xform>", "</xform>")] {
            let text = format!("<flame>{}{}</flame>", open.repeat(depth), close.repeat(depth));
            if let Ok(genomes) = Genome::parse_all(&text) {
                drop(genomes);
            }
        }
    }
}
