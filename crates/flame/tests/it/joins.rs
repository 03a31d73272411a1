//! Rendered frames meet at joins, of slow loops and of transitions of half their length.
//!
//! Owns the claims on pixels; `motion.rs` has those on numbers.

use crate::mixed;
use flame::variations::{Kind, Variation};
use flame::{Exposed, Exposure, Filter, Genome, Image, Loop, Motion, Renderer, Settings, Transition};
use species::Threads;

/// Frames of loops of a minute and of transitions of half of one, at 30 a second.
const LOOP: f64 = 1800.0;
const TRANSITION: f64 = 900.0;

/// Enough samples for motion of a fifth of a degree a frame to show above the noise, which is another one where a transform
/// comes in that draws random numbers of its own.
const SETTINGS: Settings = Settings {
    size: Some([48, 27]),
    spp: Some(80_000.0),
    psnr: None,
    supersample: Some(1),
    temporal_samples: Some(4),
    filter: Filter::None,
    seed: 3,
    arithmetic: flame::Arithmetic::Fastest,
};

/// The root mean square of `weights` times `images`, in levels of 255.
fn rms(images: &[&Image], weights: &[f64]) -> f64 {
    let count = images[0].pixels.as_flattened().len();
    let sum =
        |i: usize| images.iter().zip(weights).map(move |(image, w)| w * f64::from(image.pixels.as_flattened()[i]));
    let squares: f64 = (0..count).map(|i| sum(i).sum::<f64>().powi(2)).sum();
    255.0 * (squares / count as f64).sqrt()
}

#[test]
fn rendered_frames_meet_at_the_joins_of_minute_long_loops_with_transitions_of_half_a_minute() {
    let renderer = Renderer::new(0).unwrap();
    let sheep = [
        include_str!("../../../../flock-tools/demo/genomes/nautilus.flam3"),
        include_str!("../../../../flock-tools/demo/genomes/caldera.flam3"),
    ]
    .map(|text| Loop::new(&Genome::parse(text).unwrap(), LOOP));
    for [from, to] in [[0, 1], [1, 0]].map(|pair| pair.map(|i| &sheep[i])) {
        let way = Transition::new(from, to, TRANSITION);
        let exposure = Exposure::measure(&way, TRANSITION, &Threads::new(0).unwrap()).unwrap();
        let way = Exposed { motion: &way, exposure: &exposure };
        let draw = |motion: &dyn Motion, frame: f64| renderer.render(motion, frame, &SETTINGS).unwrap();
        let inside =
            |motion: &dyn Motion, frame: f64| rms(&[&draw(motion, frame + 1.0), &draw(motion, frame)], &[1.0, -1.0]);
        let usual = [inside(from, 700.0), inside(to, 700.0), inside(&way, 300.0), inside(&way, 600.0)];
        let usual = usual.into_iter().fold(f64::INFINITY, f64::min);
        // The loops carried on through the joins: the first frames of the transition, and its last ones backwards.
        for (motion, join, inwards) in [(from, LOOP, 1.0), (to, 0.0, -1.0)] {
            let at = if inwards > 0.0 { 0.0 } else { TRANSITION };
            let off = |frames: f64| {
                let (loop_frame, own) = (draw(motion, join + frames * inwards), draw(&way, at + frames * inwards));
                rms(&[&loop_frame, &own], &[1.0, -1.0])
            };
            let (value, velocity) = (off(0.0), off(1.0));
            println!("value off by {value:.3}, velocity by {velocity:.3}, a frame changes by {usual:.3} at least");
            assert!(value < usual && velocity < usual, "{value}, {velocity}, {usual}");
        }
    }
}

#[test]
fn a_variation_comes_in_from_nothing_and_goes_out_to_nothing() {
    let renderer = Renderer::new(0).unwrap();
    let settings = Settings { spp: Some(4000.0), temporal_samples: Some(1), ..SETTINGS };
    let mut jumps = Vec::new();
    for (name, text) in mixed::texts().into_iter().chain(mixed::of_others()) {
        let with = Genome::parse(&text).unwrap();
        let mut without = with.clone();
        without.xforms[0].variations = vec![Variation::new(Kind::Linear, 0.3)];
        let [without, with] = [without, with].map(|genome| Loop::new(&genome, LOOP));
        for (from, to, frame) in [(&without, &with, 0.01), (&with, &without, TRANSITION - 0.01)] {
            let draw = |motion: &dyn Motion, frame: f64| renderer.render(motion, frame, &settings).unwrap();
            let plain = draw(&without, 0.0);
            let off = rms(&[&draw(&Transition::new(from, to, TRANSITION), frame), &plain], &[1.0, -1.0]);
            println!("{name}: {off:.2}");
            if off >= 3.0 {
                jumps.push(format!("{name}, {frame}: off by {off:.2} levels of 255"));
            }
        }
    }
    assert!(jumps.is_empty(), "{jumps:#?}");
}
