//! Colours as the eye sees them: blending without mud.
//!
//! Owns the conversion to and from Oklab, and the way from one palette to another through it. Never looks a colour up.
//!
//! Start at [`Way`].
//!
//! # Source
//! Björn Ottosson, *A perceptual color space for image processing* (2020), and IEC 61966-2-1 (sRGB).

use super::transition::mix;
use crate::genome::Palette;

/// How much a mixture's colourfulness is raised at most, where opposite colours cancel out.
const MOST_GAIN: f64 = 3.0;

/// Lightness and two axes of colour.
pub(crate) type Lab = [f64; 3];

/// The way from one palette to another.
///
/// The hues of all entries turn together, by as much as brings the mean of the one palette's to the other's the shorter
/// way round. Neighbouring entries so stay neighbours, and the way leads around grey rather than through it. What still
/// cancels out is made as colourful as its ends, within limits.
#[derive(Clone, Debug)]
pub(super) struct Way {
    /// The colours of each entry, with what is outside of `0.0..=255.0` cut off.
    ends: Vec<[Lab; 2]>,
    /// How far all hues turn, in radians.
    turn: f64,
}

impl Way {
    /// The way from `from` to `to`.
    pub(super) fn new(from: &Palette, to: &Palette) -> Way {
        let colour = |entry: &[f64; 4]| to_oklab(cut(entry).map(|channel| channel / 255.0));
        let ends: Vec<_> = from.entries.iter().zip(&to.entries).map(|(a, b)| [colour(a), colour(b)]).collect();
        // The sum of all turns as complex numbers: pairs of dull colours count less.
        let (along, across) = ends.iter().fold((0.0, 0.0), |(along, across), [a, b]| {
            (along + a[1] * b[1] + a[2] * b[2], across + a[1] * b[2] - a[2] * b[1])
        });
        let turn = if along == 0.0 && across == 0.0 { 0.0 } else { libm::atan2(across, along) };
        Way { ends, turn }
    }

    /// All entries at `part` of the way, `0.0..=1.0`, each channel `0.0..=255.0`.
    pub(super) fn at(&self, part: f64) -> Vec<[f64; 3]> {
        let turns = [part, part - 1.0].map(|part| libm::sincos(self.turn * part));
        self.ends.iter().map(|ends| Self::entry(*ends, turns, part)).collect()
    }

    fn entry([a, b]: [Lab; 2], turns: [(f64, f64); 2], part: f64) -> [f64; 3] {
        let [a, b] = [turned(a, turns[0]), turned(b, turns[1])];
        let mut blended: Lab = std::array::from_fn(|axis| mix(a[axis], b[axis], part));
        let (wanted, found) = (mix(colourfulness(a), colourfulness(b), part), colourfulness(blended));
        if found > 0.0 {
            let gain = wanted * MOST_GAIN / libm::hypot(wanted, (MOST_GAIN * MOST_GAIN - 1.0).sqrt() * found);
            blended = [blended[0], blended[1] * gain, blended[2] * gain];
        }
        shown(blended).map(|channel| channel * 255.0)
    }
}

/// Red, green and blue of a palette's entry, cut to `0.0..=255.0`.
pub(super) fn cut(entry: &[f64; 4]) -> [f64; 3] {
    [entry[0], entry[1], entry[2]].map(|channel| channel.clamp(0.0, 255.0))
}

fn colourfulness([_, a, b]: Lab) -> f64 {
    libm::hypot(a, b)
}

pub(crate) fn turned([lightness, a, b]: Lab, (sin, cos): (f64, f64)) -> Lab {
    [lightness, cos * a - sin * b, sin * a + cos * b]
}

/// The nearest colour that a screen shows, of the same lightness and hue.
pub(crate) fn shown(colour: Lab) -> [f64; 3] {
    let fits = |rgb: [f64; 3]| rgb.iter().all(|channel| (-1e-6..=1.0 + 1e-6).contains(channel));
    let with = |share: f64| to_linear([colour[0], colour[1] * share, colour[2] * share]);
    let (mut low, mut high) = (0.0, 1.0);
    if fits(with(1.0)) {
        low = 1.0;
    } else {
        for _ in 0..45 {
            let middle = f64::midpoint(low, high);
            if fits(with(middle)) { low = middle } else { high = middle }
        }
    }
    with(low).map(|channel| encoded(channel.clamp(0.0, 1.0)))
}

pub(crate) fn to_oklab(rgb: [f64; 3]) -> Lab {
    let [r, g, b] = rgb.map(decoded);
    let l = libm::cbrt(0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b);
    let m = libm::cbrt(0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b);
    let s = libm::cbrt(0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b);
    [
        0.210_454_255_3 * l + 0.793_617_785 * m - 0.004_072_046_8 * s,
        1.977_998_495_1 * l - 2.428_592_205 * m + 0.450_593_709_9 * s,
        0.025_904_037_1 * l + 0.782_771_766_2 * m - 0.808_675_766 * s,
    ]
}

fn to_linear([lightness, a, b]: Lab) -> [f64; 3] {
    let cube = |root: f64| root * root * root;
    let l = cube(lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b);
    let m = cube(lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b);
    let s = cube(lightness - 0.089_484_177_5 * a - 1.291_485_548 * b);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701 * s,
    ]
}

/// From what files hold to light.
fn decoded(channel: f64) -> f64 {
    if channel <= 0.040_45 { channel / 12.92 } else { libm::pow((channel + 0.055) / 1.055, 2.4) }
}

/// From light to what files hold.
fn encoded(light: f64) -> f64 {
    if light <= 0.003_130_8 { light * 12.92 } else { 1.055 * libm::pow(light, 1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oklab_and_back_is_the_same_colour() {
        for rgb in
            [[1.0, 0.5, 0.2], [0.0, 0.3, 0.9], [0.4, 0.4, 0.4], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.9, 0.1, 0.8]]
        {
            let back = shown(to_oklab(rgb));
            assert!(rgb.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-4), "{rgb:?} became {back:?}");
        }
        // Ottosson's own example: the lightness of a pure blue.
        assert!((to_oklab([0.0, 0.0, 1.0])[0] - 0.452).abs() < 1e-3);
    }

    #[test]
    fn half_way_between_opposite_colours_there_is_no_grey() {
        let plain = |colour: [f64; 3]| Palette::from_fn(|_| [colour[0], colour[1], colour[2], 255.0]);
        for (from, to) in [
            ([255.0, 0.0, 0.0], [0.0, 255.0, 255.0]),
            ([0.0, 0.0, 255.0], [255.0, 255.0, 0.0]),
            ([40.0, 160.0, 60.0], [200.0, 60.0, 160.0]),
        ] {
            let way = Way::new(&plain(from), &plain(to));
            let ends = [from, to].map(|colour| to_oklab(colour.map(|channel| channel / 255.0)));
            let middle = to_oklab(way.at(0.5)[0].map(|channel| channel / 255.0));
            let least = colourfulness(ends[0]).min(colourfulness(ends[1]));
            // No screen shows a turquoise as colourful as blue and yellow.
            assert!(colourfulness(middle) > 0.5 * least, "{from:?} to {to:?}: {:?}", way.at(0.5)[0]);
            assert!(middle[0] > 0.95 * ends[0][0].min(ends[1][0]), "dark: {:?}", way.at(0.5)[0]);
        }
    }
}
