//! The figures of pictures that are made up.
//!
//! Owns claims on what is found, and on what is wrong. Never draws a species.

use super::{FigureFault, Figures};
use crate::made::Made;
use crate::threads::Threads;

const FRAMES: f64 = 384.0;

fn figures(picture: fn(f32, f32, f64) -> [f32; 3]) -> Figures {
    Figures::of(&Made(picture), FRAMES, [1280, 720], &Threads::new(1).unwrap()).unwrap()
}

/// Waves in colours that run from left to right, 96 frames long.
fn waves(x: f32, y: f32, frame: f64) -> [f32; 3] {
    let turns = f64::from(x) - frame / 96.0;
    let wave = (turns - turns.floor()) as f32;
    let wave = 3.6 * wave * (1.0 - wave);
    [wave, 0.5 * wave, 0.2 + 0.2 * y]
}

/// 0 where the loop starts, 1 half way.
fn half_way(frame: f64) -> f32 {
    let part = (frame / FRAMES) as f32;
    4.0 * part * (1.0 - part)
}

#[test]
fn what_may_be_shown_has_no_fault() {
    let found = figures(waves);
    assert_eq!(found.faults(), []);
    assert!(found.activity > 0.002 && found.flicker < 0.3 && found.unevenness < 1.2, "{found:?}");
    assert!(found.colourfulness > 0.2 && found.contrast > 0.1 && found.black < 0.2, "{found:?}");
}

#[test]
fn grey_has_no_colour() {
    let found = figures(|x, y, frame| [waves(x, y, frame)[0]; 3]);
    assert!(found.colourfulness < 1e-6, "{found:?}");
}

#[test]
fn what_is_wrong_is_named() {
    let faults = |picture: fn(f32, f32, f64) -> [f32; 3]| figures(picture).faults();
    let named = [
        (faults(|_, _, _| [0.0; 3]), vec!["black", "dark", "flat", "still"]),
        (faults(|x, y, frame| waves(x, y, frame).map(|light| 0.8 + 0.15 * light)), vec!["bright", "flat"]),
        (faults(|x, y, frame| waves(x, y, frame).map(|light| (2.0 * light - 0.4).clamp(0.0, 1.0))), vec!["clipped"]),
        (faults(|x, y, frame| waves(x, y, frame).map(|light| 0.4 + 0.05 * light)), vec!["flat"]),
        // One colour once in a loop.
        (faults(|x, y, frame| waves(x, y, frame).map(|light| 0.2 + 0.7 * light * half_way(frame))), vec!["flat"]),
        (faults(|x, y, _| waves(x, y, 0.0)), vec!["still"]),
        (faults(|x, y, frame| waves(x, y, 48.0 * (frame % 2.0))), vec!["strobing"]),
        // It rests for half of the loop, and then jumps a little.
        (faults(|x, y, frame| waves(x, y, 9.0 * (frame - 46.0).clamp(0.0, 8.0))), vec!["strobing", "uneven"]),
    ];
    for (found, expected) in named {
        let found: Vec<_> = found.into_iter().map(FigureFault::name).collect();
        assert_eq!(found, expected);
    }
}

#[test]
fn one_place_with_all_the_light_dominates_and_others_do_not() {
    fn ball(x: f32, y: f32, size: f32, frame: f64) -> [f32; 3] {
        let u = 0.1 * (2.0 * ((frame / FRAMES) as f32 - 0.5).abs() - 0.5);
        [(1.0 - ((x - u) * (x - u) + y * y) / (size * size)).clamp(0.0, 0.9); 3]
    }
    assert!(figures(|x, y, frame| ball(x, y, 0.15, frame)).faults().contains(&FigureFault::Dominated));
    assert!(!figures(|x, y, frame| ball(x, y, 1.0, frame)).faults().contains(&FigureFault::Dominated));
}

#[test]
fn figures_are_the_same_on_any_number_of_threads() {
    let found = [1, 2, 7]
        .map(|threads| Figures::sketched(&Made(waves), FRAMES, [720, 1280], &Threads::new(threads).unwrap()).unwrap());
    assert!(found[0] == found[1] && found[1] == found[2]);
}

#[test]
fn the_compared_figures_tell_what_they_are_named_for() {
    type Pixel = fn(f32, f32, f64) -> [f32; 3];
    // One hue, and all of them; mirrored and not; in the middle and in a corner; smooth and rough.
    let one_hue: Pixel = |x, y, frame| [waves(x, y, frame)[0], 0.0, 0.0];
    let all_hues: Pixel = |x, _, _| [0.0, 2.0, 4.0].map(|third| 0.5 + 0.4 * (6.0 * x + third * 1.047).sin());
    let mirrored: Pixel = |x, y, _| [(2.0 * (x * x + y)).clamp(0.0, 0.9); 3];
    let ramp: Pixel = |x, _, _| [(0.5 + 0.4 * x).clamp(0.0, 1.0); 3];
    let corner: Pixel = |x, y, _| [if x > 0.3 && y > 0.1 { 0.9 } else { 0.0 }; 3];
    let line: Pixel = |x, y, _| [if y.abs() < 0.005 { 0.5 + 0.1 * x } else { 0.0 }; 3];
    let rough: Pixel = |x, y, _| [((x * 12_345.6).sin() * (y * 6_543.2).sin() * 999.0).rem_euclid(1.0); 3];
    let find = |picture: Pixel| figures(picture);
    let (plain, colours) = (find(one_hue), find(all_hues));
    assert!(plain.hue_entropy < 0.01 && colours.hue_entropy > 0.9, "{plain:?} {colours:?}");
    assert!(find(mirrored).symmetry > 0.99 && find(ramp).symmetry > 0.99 && find(corner).symmetry < 0.6);
    assert!(find(ramp).offset > 0.02 && find(corner).offset > 0.3 && find(mirrored).offset < find(corner).offset);
    let (ramp, line, rough) = (find(ramp), find(line), find(rough));
    assert!(line.dimension < 1.3 && ramp.dimension > 1.7, "{line:?} {ramp:?}");
    assert!(rough.edges > 0.5 && ramp.edges < 0.001 && rough.compressed > 5.0 * ramp.compressed, "{rough:?} {ramp:?}");
    assert!(rough.luma_entropy > 0.8 && line.luma_entropy < 0.2, "{rough:?} {line:?}");
    let black = find(|_, _, _| [0.0; 3]);
    assert!(black.compared().iter().all(|figure| figure.is_finite()) && black.dimension == 0.0, "{black:?}");
}

#[test]
fn every_compared_figure_has_its_name() {
    let found = figures(waves);
    let shown = format!("{found:?}");
    for (name, value) in Figures::NAMES.iter().zip(found.compared()) {
        assert!(shown.contains(&format!("{name}: {value:?}")), "{name} is not {value} in {shown}");
    }
}
