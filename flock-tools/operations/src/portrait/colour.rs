//! The colour of a sheep on the page.
//!
//! Owns how it is found in a picture, and the colour of a sheep without one. Never draws.
//!
//! # Source
//! Björn Ottosson, *A perceptual color space for image processing* (2020): `OKLab`.

use std::f64::consts::TAU;
use std::fmt;

use super::layout::Numbers;

/// Parts of the circle of hues among which the strongest is found.
const HUES: usize = 24;
/// The limits of lightness and chroma of a sheep's colour: it must be visible on dark and on light backgrounds.
const LIGHTNESS: (f64, f64) = (0.58, 0.84);
const CHROMA: (f64, f64) = (0.10, 0.19);

/// A colour of less chroma is grey and stays grey.
const GREY: f64 = 0.015;

/// A colour of the screen; as text it is CSS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour([u8; 3]);

/// Lightness from 0 to 1, and two axes of colour: green to red, blue to yellow.
#[derive(Clone, Copy, Debug)]
struct Lab {
    l: f64,
    a: f64,
    b: f64,
}

impl Colour {
    /// The colour of a sheep without a picture: always the same for an id.
    pub fn of_id(id: &str) -> Self {
        let mut numbers = Numbers::of(id);
        let (hue, l, chroma) = (TAU * numbers.next(), 0.55 + 0.2 * numbers.next(), 0.08 + 0.06 * numbers.next());
        Lab { l, a: chroma * hue.cos(), b: chroma * hue.sin() }.rgb()
    }

    /// The most striking colour of a picture: the mean of its strongest hue, without the dark background.
    ///
    /// * `rgb`: 8 bits each of red, green and blue, pixel after pixel.
    pub fn of_picture(rgb: &[u8]) -> Self {
        let mut sums = [[0.0; 4]; HUES];
        for pixel in rgb.as_chunks().0 {
            let Lab { l, a, b } = Lab::of(*pixel);
            let weight = l * a.hypot(b) + 1e-4 * l;
            let hue = ((b.atan2(a) / TAU).rem_euclid(1.0) * HUES as f64) as usize % HUES;
            for (sum, part) in sums[hue].iter_mut().zip([1.0, l, a, b]) {
                *sum += weight * part;
            }
        }
        let around =
            |hue: usize, part: usize| [HUES - 1, 0, 1].map(|off| sums[(hue + off) % HUES][part]).iter().sum::<f64>();
        let strongest = (0..HUES).max_by(|&a, &b| around(a, 0).total_cmp(&around(b, 0))).unwrap_or(0);
        let weight = around(strongest, 0);
        if weight <= 0.0 {
            return Lab { l: LIGHTNESS.0, a: 0.0, b: 0.0 }.rgb();
        }
        let [l, a, b] = [1, 2, 3].map(|part| around(strongest, part) / weight);
        let chroma = a.hypot(b);
        let wished = if chroma < GREY { chroma } else { chroma.clamp(CHROMA.0, CHROMA.1) };
        let stronger = if chroma > 0.0 { wished / chroma } else { 1.0 };
        Lab { l: l.clamp(LIGHTNESS.0, LIGHTNESS.1), a: stronger * a, b: stronger * b }.rgb()
    }
}

impl fmt::Display for Colour {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [r, g, b] = self.0;
        write!(f, "#{r:02x}{g:02x}{b:02x}")
    }
}

impl Lab {
    fn of(rgb: [u8; 3]) -> Self {
        let [r, g, b] = rgb.map(|level| {
            let level = f64::from(level) / 255.0;
            if level <= 0.04045 { level / 12.92 } else { ((level + 0.055) / 1.055).powf(2.4) }
        });
        let cone = |x: f64, y: f64, z: f64| (x * r + y * g + z * b).cbrt();
        let long = cone(0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9);
        let middle = cone(0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6);
        let short = cone(0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5);
        Self {
            l: 0.210_454_255_3 * long + 0.793_617_785_0 * middle - 0.004_072_046_8 * short,
            a: 1.977_998_495_1 * long - 2.428_592_205_0 * middle + 0.450_593_709_9 * short,
            b: 0.025_904_037_1 * long + 0.782_771_766_2 * middle - 0.808_675_766_0 * short,
        }
    }

    /// The nearest colour that a screen can show: chroma is reduced, hue is kept.
    fn rgb(self) -> Colour {
        let linear = |strength: f64| {
            let (a, b) = (strength * self.a, strength * self.b);
            let long = (self.l + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
            let middle = (self.l - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
            let short = (self.l - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
            [
                4.076_741_662_1 * long - 3.307_711_591_3 * middle + 0.230_969_929_2 * short,
                -1.268_438_004_6 * long + 2.609_757_401_1 * middle - 0.341_319_396_5 * short,
                -0.004_196_086_3 * long - 0.703_418_614_7 * middle + 1.707_614_701_0 * short,
            ]
        };
        let fits = |light: &[f64; 3]| light.iter().all(|level| (-1e-4..=1.0001).contains(level));
        let light =
            (0..=20).map(|weaker| linear(1.0 - f64::from(weaker) / 20.0)).find(fits).unwrap_or_else(|| linear(0.0));
        Colour(light.map(|level| {
            let level = level.clamp(0.0, 1.0);
            let coded = if level <= 0.003_130_8 { 12.92 * level } else { 1.055 * level.powf(1.0 / 2.4) - 0.055 };
            (255.0 * coded + 0.5) as u8
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(parts: &[([u8; 3], usize)]) -> Vec<u8> {
        parts.iter().flat_map(|&(rgb, count)| rgb.repeat(count)).collect()
    }

    #[test]
    fn a_colour_goes_to_the_perceptual_space_and_back() {
        for rgb in [[0, 0, 0], [255, 255, 255], [255, 0, 0], [0, 255, 0], [0, 0, 255], [12, 200, 99], [240, 164, 92]] {
            assert_eq!(Lab::of(rgb).rgb(), Colour(rgb));
        }
    }

    #[test]
    fn a_picture_is_remembered_by_its_strong_colour_and_not_by_its_ground() {
        let Colour([r, g, b]) =
            Colour::of_picture(&picture(&[([2, 2, 3], 900), ([180, 60, 20], 60), ([20, 40, 60], 40)]));
        assert!(r > 150 && r > g + 60 && g >= b, "{r} {g} {b}");
    }

    #[test]
    fn black_and_grey_pictures_have_a_colour_too() {
        let Colour([r, g, b]) = Colour::of_picture(&picture(&[([0, 0, 0], 100)]));
        assert!(r == g && g == b && r > 80, "{r} {g} {b}");
        let Colour([r, g, b]) = Colour::of_picture(&picture(&[([90, 90, 90], 100)]));
        assert!(r.abs_diff(g) < 3 && g.abs_diff(b) < 3 && r >= 90, "{r} {g} {b}");
        assert_eq!(Colour::of_picture(&[]), Colour::of_picture(&picture(&[([0, 0, 0], 1)])));
    }

    #[test]
    fn an_id_has_its_colour_for_good() {
        assert_eq!(Colour::of_id("191.21054").to_string(), Colour::of_id("191.21054").to_string());
        assert_ne!(Colour::of_id("191.21054"), Colour::of_id("191.21055"));
        let text = Colour::of_id("x").to_string();
        assert!(text.len() == 7 && text.starts_with('#'), "{text}");
    }
}
