//! Palettes: 256 colours and how to look them up.
//!
//! Owns the colours and their conversion to and from HSV. XML is read in `parse.rs`; interpolation is in
//! `animate/palette.rs`.
//!
//! Start at [`Palette`].

/// 256 colours: red, green, blue and alpha, each `0.0..=255.0` as files hold them.
#[derive(Clone, Debug, PartialEq)]
pub struct Palette {
    /// The colours by index.
    pub entries: Vec<[f64; 4]>,
}

impl Palette {
    /// How many colours a palette has.
    pub const LEN: usize = 256;

    /// A palette from a colour for every index.
    pub fn from_fn(entry: impl FnMut(usize) -> [f64; 4]) -> Palette {
        Palette { entries: (0..Palette::LEN).map(entry).collect() }
    }

    /// The palette of `colours`, which are any number above 0: each of the 256 is blended from the two nearest ones, the
    /// first and the last stay.
    pub(crate) fn resampled(colours: &[[f64; 4]]) -> Palette {
        let last = colours.len() - 1;
        Palette::from_fn(|i| {
            let (whole, part) = (i * last / (Palette::LEN - 1), (i * last % (Palette::LEN - 1)) as f64 / 255.0);
            let [low, high] = [whole, last.min(whole + 1)].map(|at| colours[at]);
            std::array::from_fn(|c| low[c] * (1.0 - part) + high[c] * part)
        })
    }

    /// Whether colours that follow each other differ by more than an eighth of the range, in any channel.
    pub(crate) fn is_uneven(&self) -> bool {
        let differ = |pair: &[[f64; 4]]| (0..3).any(|channel| (pair[1][channel] - pair[0][channel]).abs() > 32.0);
        self.entries.windows(2).any(differ)
    }

    /// The colour of the entry in which `coordinate` (`0.0..=1.0`) falls.
    pub fn step(&self, coordinate: f64) -> [f64; 4] {
        self.entries[((coordinate * Palette::LEN as f64) as usize).min(Palette::LEN - 1)]
    }

    /// The colour between the two entries nearest to `coordinate` (`0.0..=1.0`).
    pub fn linear(&self, coordinate: f64) -> [f64; 4] {
        let place = (coordinate * Palette::LEN as f64).clamp(0.0, (Palette::LEN - 1) as f64);
        let low = (place as usize).min(Palette::LEN - 2);
        let part = place - low as f64;
        std::array::from_fn(|i| self.entries[low][i] * (1.0 - part) + self.entries[low + 1][i] * part)
    }
}

/// Hue in `0.0..6.0`, saturation and value of red, green and blue on any scale; value keeps the scale.
pub(crate) fn to_hsv([red, green, blue]: [f64; 3]) -> [f64; 3] {
    let high = red.max(green).max(blue);
    let low = red.min(green).min(blue);
    let spread = high - low;
    if spread <= 0.0 {
        return [0.0, 0.0, high];
    }
    let hue = if high == red {
        (green - blue) / spread
    } else if high == green {
        2.0 + (blue - red) / spread
    } else {
        4.0 + (red - green) / spread
    };
    [hue.rem_euclid(6.0), spread / high, high]
}

/// The inverse of [`to_hsv`]; any hue, taken modulo 6.
pub(crate) fn from_hsv([hue, saturation, value]: [f64; 3]) -> [f64; 3] {
    let channel = |offset: f64| {
        let place = (offset + hue).rem_euclid(6.0);
        value * (1.0 - saturation * place.min(4.0 - place).clamp(0.0, 1.0))
    };
    [channel(5.0), channel(3.0), channel(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hsv_and_back_is_the_same_colour() {
        for rgb in [[1.0, 0.5, 0.2], [0.0, 0.3, 0.9], [0.4, 0.4, 0.4], [0.0, 0.0, 0.0], [0.9, 0.1, 0.8]] {
            let back = from_hsv(to_hsv(rgb));
            assert!(rgb.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-12), "{rgb:?} became {back:?}");
        }
    }

    #[test]
    fn a_palette_of_any_length_goes_from_its_first_colour_to_its_last() {
        for length in [1, 2, 100, 256, 512, 1024] {
            let ramp: Vec<[f64; 4]> =
                (0..length).map(|i| [200.0 * f64::from(i) / f64::from(length), 0.0, 0.0, 255.0]).collect();
            let entries = Palette::resampled(&ramp).entries;
            assert_eq!((entries[0], entries[255], entries.len()), (ramp[0], ramp[ramp.len() - 1], 256), "{length}");
            let step = (entries[255][0] - entries[0][0]) / 255.0;
            assert!(entries.windows(2).all(|pair| (pair[1][0] - pair[0][0] - step).abs() < 1e-9), "{length}");
        }
        let own: Vec<[f64; 4]> = (0..256).map(|i| [f64::from(i * 77 % 256), 1.0, 2.0, 3.0]).collect();
        assert_eq!(Palette::resampled(&own).entries, own, "256 colours stay to the bit");
    }

    #[test]
    fn linear_lookup_blends_neighbours_and_step_does_not() {
        let ramp = Palette::from_fn(|i| [i as f64, 0.0, 0.0, 255.0]);
        assert_eq!(ramp.step(10.5 / 256.0)[0], 10.0);
        assert_eq!(ramp.linear(10.5 / 256.0)[0], 10.5);
        assert_eq!(ramp.step(1.0)[0], 255.0);
        assert_eq!(ramp.linear(1.0)[0], 255.0);
    }
}
