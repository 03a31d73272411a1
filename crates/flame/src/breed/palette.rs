//! Palettes by chance.
//!
//! Owns our ramps of colours, and what becomes of a palette. Never looks a colour up.
//!
//! Start at [`drawn`].

use std::f64::consts::TAU;

use species::Rng;

use super::chance::{even, happens, pick};
use crate::animate::oklab::{Lab, shown, to_oklab, turned};
use crate::genome::Palette;

/// How often a palette is one of our ramps; else its ramp is by chance, too.
const OURS: f64 = 0.7;
/// The brightest that ripples make a colour.
const BRIGHTEST: f64 = 0.97;
/// How likely a crossed palette goes over to the other parent at an entry.
const SWITCHES: f64 = 0.01;

/// A stop of a ramp: where it is, `0.0..1.0`, and the lightness, the chroma and the hue in degrees of its colour in Oklab.
type Stop = [f64; 4];

/// Ramps that lead back to their beginning, designed for the demo.
#[rustfmt::skip]
const RAMPS: [&[Stop]; 18] = [
    // Ember and teal.
    &[[0.0, 0.42, 0.16, 25.0], [0.18, 0.62, 0.20, 40.0], [0.32, 0.90, 0.12, 85.0], [0.45, 0.50, 0.10, 40.0],
      [0.6, 0.40, 0.09, 205.0], [0.75, 0.68, 0.13, 195.0], [0.87, 0.92, 0.06, 180.0], [0.95, 0.45, 0.12, 300.0]],
    // Peacock.
    &[[0.0, 0.38, 0.14, 265.0], [0.2, 0.55, 0.16, 240.0], [0.38, 0.72, 0.14, 195.0], [0.5, 0.86, 0.17, 145.0],
      [0.62, 0.93, 0.12, 100.0], [0.74, 0.55, 0.12, 160.0], [0.88, 0.38, 0.14, 300.0]],
    // Dusk.
    &[[0.0, 0.36, 0.16, 285.0], [0.22, 0.50, 0.22, 310.0], [0.4, 0.66, 0.22, 0.0], [0.55, 0.78, 0.16, 50.0],
      [0.66, 0.94, 0.07, 85.0], [0.78, 0.55, 0.17, 15.0], [0.9, 0.38, 0.14, 270.0]],
    // Ice.
    &[[0.0, 0.36, 0.14, 262.0], [0.25, 0.52, 0.17, 252.0], [0.45, 0.75, 0.12, 225.0], [0.58, 0.95, 0.04, 200.0],
      [0.7, 0.70, 0.10, 220.0], [0.82, 0.50, 0.16, 285.0], [0.92, 0.62, 0.20, 330.0]],
    // Gold and ink.
    &[[0.0, 0.36, 0.11, 265.0], [0.2, 0.42, 0.12, 275.0], [0.35, 0.50, 0.09, 60.0], [0.5, 0.70, 0.14, 75.0],
      [0.62, 0.92, 0.10, 92.0], [0.74, 0.66, 0.15, 60.0], [0.86, 0.42, 0.13, 25.0]],
    // Fern.
    &[[0.0, 0.36, 0.09, 165.0], [0.2, 0.50, 0.13, 150.0], [0.36, 0.70, 0.19, 135.0], [0.5, 0.90, 0.15, 115.0],
      [0.62, 0.80, 0.13, 85.0], [0.75, 0.50, 0.12, 45.0], [0.88, 0.38, 0.10, 200.0]],
    // Rosewood.
    &[[0.0, 0.38, 0.13, 15.0], [0.2, 0.52, 0.19, 12.0], [0.38, 0.70, 0.17, 5.0], [0.52, 0.88, 0.08, 20.0],
      [0.64, 0.75, 0.10, 70.0], [0.78, 0.46, 0.08, 150.0], [0.9, 0.36, 0.09, 330.0]],
    // Aurora.
    &[[0.0, 0.36, 0.14, 285.0], [0.16, 0.48, 0.18, 290.0], [0.32, 0.60, 0.14, 220.0], [0.48, 0.78, 0.17, 165.0],
      [0.6, 0.92, 0.15, 130.0], [0.74, 0.60, 0.14, 190.0], [0.88, 0.50, 0.22, 330.0]],
    // Copper and verdigris.
    &[[0.0, 0.40, 0.11, 45.0], [0.2, 0.60, 0.14, 50.0], [0.34, 0.82, 0.11, 65.0], [0.46, 0.94, 0.05, 80.0],
      [0.58, 0.62, 0.10, 180.0], [0.74, 0.45, 0.09, 195.0], [0.88, 0.38, 0.10, 30.0]],
    // Violet and lime.
    &[[0.0, 0.36, 0.17, 295.0], [0.22, 0.52, 0.23, 300.0], [0.4, 0.72, 0.15, 305.0], [0.52, 0.92, 0.06, 320.0],
      [0.64, 0.86, 0.18, 120.0], [0.76, 0.56, 0.14, 140.0], [0.9, 0.38, 0.12, 250.0]],
    // Lapis and rose.
    &[[0.0, 0.36, 0.18, 265.0], [0.2, 0.50, 0.21, 262.0], [0.36, 0.68, 0.13, 240.0], [0.5, 0.90, 0.05, 220.0],
      [0.62, 0.78, 0.14, 355.0], [0.76, 0.60, 0.21, 0.0], [0.9, 0.40, 0.16, 320.0]],
    // Honey.
    &[[0.0, 0.38, 0.10, 35.0], [0.22, 0.56, 0.15, 45.0], [0.42, 0.76, 0.16, 70.0], [0.56, 0.95, 0.08, 95.0],
      [0.7, 0.80, 0.07, 200.0], [0.84, 0.50, 0.09, 235.0], [0.93, 0.38, 0.09, 300.0]],
    // Flamingo.
    &[[0.0, 0.40, 0.17, 345.0], [0.2, 0.62, 0.23, 355.0], [0.38, 0.78, 0.15, 15.0], [0.5, 0.94, 0.05, 50.0],
      [0.64, 0.72, 0.13, 190.0], [0.8, 0.48, 0.11, 210.0], [0.92, 0.37, 0.14, 290.0]],
    // The deep sea.
    &[[0.0, 0.34, 0.11, 240.0], [0.2, 0.46, 0.12, 225.0], [0.4, 0.64, 0.12, 200.0], [0.55, 0.86, 0.12, 175.0],
      [0.66, 0.95, 0.06, 120.0], [0.76, 0.74, 0.18, 55.0], [0.86, 0.52, 0.18, 35.0], [0.94, 0.36, 0.12, 285.0]],
    // Opal.
    &[[0.0, 0.40, 0.10, 270.0], [0.18, 0.66, 0.11, 300.0], [0.34, 0.86, 0.07, 350.0], [0.5, 0.94, 0.06, 80.0],
      [0.66, 0.84, 0.09, 165.0], [0.82, 0.62, 0.11, 225.0]],
    // Wine.
    &[[0.0, 0.35, 0.13, 5.0], [0.2, 0.44, 0.17, 350.0], [0.38, 0.58, 0.20, 335.0], [0.52, 0.74, 0.15, 300.0],
      [0.64, 0.92, 0.05, 280.0], [0.76, 0.80, 0.13, 80.0], [0.88, 0.50, 0.13, 40.0]],
    // Saffron and blue.
    &[[0.0, 0.38, 0.15, 262.0], [0.25, 0.58, 0.17, 255.0], [0.42, 0.85, 0.07, 230.0], [0.5, 0.96, 0.03, 100.0],
      [0.6, 0.84, 0.15, 80.0], [0.76, 0.64, 0.18, 52.0], [0.9, 0.42, 0.14, 20.0]],
    // Jade.
    &[[0.0, 0.34, 0.08, 185.0], [0.22, 0.52, 0.11, 175.0], [0.42, 0.74, 0.14, 165.0], [0.56, 0.94, 0.07, 150.0],
      [0.7, 0.74, 0.11, 280.0], [0.84, 0.50, 0.19, 295.0], [0.93, 0.38, 0.12, 240.0]],
];

/// A palette by chance.
pub(super) fn drawn(rng: &mut Rng) -> Palette {
    let by_chance;
    let ramp: &[Stop] = if happens(rng, OURS) {
        RAMPS[rng.below(RAMPS.len())]
    } else {
        by_chance = ramp(rng);
        &by_chance
    };
    let (shift, is_mirrored, ripple) = (rng.unit(), happens(rng, 0.5), pick(rng, &[0.0, 0.0, 0.0, 0.1, 0.18]));
    let hue = if happens(rng, 1.0 / 3.0) { even(rng, -14.0, 14.0) } else { 0.0 };
    Palette::from_fn(|entry| {
        let own = entry as f64 / Palette::LEN as f64;
        let place = if is_mirrored { 1.0 - own } else { own };
        let [lightness, a, b] = turned(along(ramp, (place + shift).rem_euclid(1.0)), libm::sincos(hue.to_radians()));
        let lightness = lightness * (1.0 + ripple * libm::sin(12.0 * TAU * own));
        bytes(shown([lightness.min(BRIGHTEST), a, b]).map(|channel| 255.0 * channel))
    })
}

/// A ramp by chance: hues wander, dark and bright stops take turns.
fn ramp(rng: &mut Rng) -> Vec<Stop> {
    let stops = 5 + rng.below(3);
    let (mut hue, way) = (360.0 * rng.unit(), pick(rng, &[-1.0, 1.0]));
    let bright = rng.below(stops);
    let stop = |number: usize| {
        // Most steps are small; now and then the ramp goes over to the other side of the circle.
        hue += way * if happens(rng, 0.2) { even(rng, 120.0, 200.0) } else { even(rng, 5.0, 55.0) };
        let away = number.abs_diff(bright).min(stops - number.abs_diff(bright)) as f64 / stops as f64;
        let lightness = 0.94 - 1.15 * away + 0.08 * rng.signed();
        let chroma = even(rng, 0.06, 0.22) * if number == bright { 0.5 } else { 1.0 };
        [number as f64 / stops as f64, lightness.clamp(0.34, 0.96), chroma, hue]
    };
    (0..stops).map(stop).collect()
}

/// The colour at a place of a ramp, `0.0..1.0`.
fn along(ramp: &[Stop], place: f64) -> Lab {
    let next = ramp.iter().position(|stop| stop[0] > place);
    let low = ramp[next.unwrap_or(ramp.len()).saturating_sub(1)];
    let high = next.map_or([1.0, ramp[0][1], ramp[0][2], ramp[0][3]], |next| ramp[next]);
    let part = ((place - low[0]) / (high[0] - low[0])).clamp(0.0, 1.0);
    let eased = part * part * (3.0 - 2.0 * part);
    let lab = |[_, lightness, chroma, hue]: Stop| turned([lightness, chroma, 0.0], libm::sincos(hue.to_radians()));
    let [low, high] = [lab(low), lab(high)];
    std::array::from_fn(|axis| low[axis] + (high[axis] - low[axis]) * eased)
}

/// The same palette with all hues turned by `degrees`.
pub(super) fn with_hues_turned(palette: &Palette, degrees: f64) -> Palette {
    let turn = libm::sincos(degrees.to_radians());
    Palette::from_fn(|entry| {
        let [red, green, blue, alpha] = palette.entries[entry];
        let lab = to_oklab([red, green, blue].map(|channel| channel.clamp(0.0, 255.0) / 255.0));
        let [red, green, blue, _] = bytes(shown(turned(lab, turn)).map(|channel| 255.0 * channel));
        [red, green, blue, alpha]
    })
}

/// Entries of either, going over to the other one now and then.
pub(super) fn crossed(a: &Palette, b: &Palette, rng: &mut Rng) -> Palette {
    let mut from_b = happens(rng, 0.5);
    Palette::from_fn(|entry| {
        from_b ^= happens(rng, SWITCHES);
        if from_b { b.entries[entry] } else { a.entries[entry] }
    })
}

/// An opaque colour in whole numbers, which files hold in few letters.
pub(super) fn bytes(colour: [f64; 3]) -> [f64; 4] {
    let [red, green, blue] = colour.map(|channel| channel.clamp(0.0, 255.0).round());
    [red, green, blue, 255.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn palettes_are_colourful_continuous_and_never_twice_the_same() {
        let mut rng = Rng::stream(1, 0);
        let palettes: Vec<Palette> = (0..100).map(|_| drawn(&mut rng)).collect();
        for (number, palette) in palettes.iter().enumerate() {
            assert!(palettes[..number].iter().all(|other| other != palette));
            let neighbours = palette.entries.iter().zip(palette.entries.iter().cycle().skip(1));
            for (a, b) in neighbours {
                assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 80.0), "palette {number}: {a:?}, {b:?}");
            }
            let spread = |channel: usize| {
                let values = palette.entries.iter().map(|entry| entry[channel]);
                values.clone().fold(0.0, f64::max) - values.fold(255.0, f64::min)
            };
            assert!((0..3).any(|channel| spread(channel) > 80.0), "palette {number}");
        }
    }

    #[test]
    fn a_crossed_palette_has_runs_of_both() {
        let [a, b] = [0.0, 255.0].map(|light| Palette::from_fn(|_| [light, light, light, 255.0]));
        let mut rng = Rng::stream(2, 0);
        let crossed: Vec<Palette> = (0..100).map(|_| crossed(&a, &b, &mut rng)).collect();
        let switches = |palette: &Palette| palette.entries.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let all: usize = crossed.iter().map(switches).sum();
        assert!((180..330).contains(&all), "{all}");
    }
}
