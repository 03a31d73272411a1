//! Genomes that nobody means: refused by name, or drawn as light; never a panic, never a machine brought down.
//!
//! Owns claims about numbers far outside of taste. What ordinary genomes look like is for `pictures.rs`.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use flame::genome::{FilterShape, Genome};
use flame::variations::Kind;
use flame::{Filter, FrameCost, Loop, Motion, RenderError, Renderer, Settings, Transition};

const TINY: Settings = Settings {
    size: Some([16, 12]),
    spp: Some(4.0),
    supersample: None,
    temporal_samples: Some(3),
    filter: Filter::Variance,
    seed: 1,
};

/// What a number may be in a file.
const NUMBERS: [&str; 12] =
    ["0", "-0", "1", "-1", "0.5", "1e-300", "-1e-300", "1e300", "-1e300", "1.7e308", "64", "4294967295"];

fn xaos() -> Genome {
    Genome::parse(include_str!("genomes/xaos.flam3")).unwrap()
}

/// Draws `motion` at `frame` where it can be drawn: everything must then be light.
fn draw(motion: &dyn Motion, frame: f64, settings: &Settings, what: &str) -> Result<(), RenderError> {
    let demand = FrameCost::of(motion, frame, settings)?;
    if demand.samples > 10_000_000 || demand.bytes > 1 << 30 {
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
    let plain = ["weight", "color", "color_speed", "opacity", "animate", "symmetry"].map(str::to_owned);
    let kinds = Kind::ALL.into_iter().flat_map(|kind| {
        let parameters = kind.parameters().iter().map(move |one| format!("{}_{}", kind.name(), one.name));
        std::iter::once(kind.name().to_owned()).chain(parameters)
    });
    let palette = "<color index=\"0\" rgb=\"255 128 0\"/>";
    for name in plain.into_iter().chain(kinds) {
        for number in NUMBERS {
            let kind = Kind::ALL.into_iter().find(|kind| name.starts_with(kind.name()) && *kind.name() != *name);
            let with = kind.map_or(String::new(), |kind| format!("{}=\"0.7\"", kind.name()));
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
    let own = Settings { size: None, spp: None, temporal_samples: None, ..TINY };
    assert_eq!(named(&|genome| genome.camera.size = [0, 0], &TINY), "scale");
    assert_eq!(named(&|genome| genome.camera.zoom = 1e3, &own), "samples");
    assert_eq!(named(&|genome| genome.sampling.quality = 1e300, &own), "samples");
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
