//! Colours, as people write them and as light.
//!
//! Owns `#rrggbb`, the curve between displayable and linear light, and the shoulder that keeps bright light from becoming
//! flat. Never knows what is coloured.
//!
//! Start at [`Colour`] and [`Screen`].

use std::fmt::{Display, Formatter};

/// Red, green and blue as on a screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour(pub [u8; 3]);

impl Colour {
    /// Reads `#rrggbb`.
    pub fn parse(text: &str) -> Option<Colour> {
        let digits = text
            .strip_prefix('#')
            .filter(|digits| digits.len() == 6 && digits.bytes().all(|byte| byte.is_ascii_hexdigit()))?;
        let number = u32::from_str_radix(digits, 16).ok()?;
        Some(Colour([16, 8, 0].map(|shift| (number >> shift) as u8)))
    }

    /// Linear light, 0 to 1.
    pub(crate) fn light(self) -> [f32; 3] {
        self.0.map(|byte| {
            let shown = f64::from(byte) / 255.0;
            let light = if shown <= 0.040_45 { shown / 12.92 } else { libm::pow((shown + 0.055) / 1.055, 2.4) };
            light as f32
        })
    }

    /// How bright it is on a screen, 0 to 1, by BT.709.
    pub(crate) fn luma(self) -> f64 {
        let [red, green, blue] = self.0.map(f64::from);
        (0.2126 * red + 0.7152 * green + 0.0722 * blue) / 255.0
    }

    /// The colour of a hue in turns, with saturation and value of 0 to 1.
    pub(crate) fn of_hue(hue: f64, saturation: f64, value: f64) -> Colour {
        let part = |shift: f64| {
            let place = (hue + shift).rem_euclid(1.0) * 6.0;
            let share = (2.0 - (place - 3.0).abs()).clamp(0.0, 1.0);
            (255.0 * value * (1.0 - saturation * share) + 0.5) as u8
        };
        // A channel is weakest opposite to its own hue.
        Colour([part(0.0), part(2.0 / 3.0), part(1.0 / 3.0)])
    }
}

impl Display for Colour {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        let [red, green, blue] = self.0;
        write!(formatter, "#{red:02x}{green:02x}{blue:02x}")
    }
}

/// A colour between two, channel by channel.
pub(crate) fn mixed(from: [f32; 3], to: [f32; 3], part: f32) -> [f32; 3] {
    [0, 1, 2].map(|channel| from[channel] + (to[channel] - from[channel]) * part)
}

/// Steps of the table.
const STEPS: usize = 4096;

/// From linear light without limit to displayable light.
pub(crate) struct Screen {
    table: Vec<f32>,
}

impl Screen {
    /// Bytes of its table.
    pub(crate) const BYTES: u64 = 4 * (STEPS as u64 + 2);

    pub(crate) fn new() -> Screen {
        let shown = |step: usize| {
            let part = (step as f64 / STEPS as f64).min(1.0);
            let light = if part < 1.0 { 1.0 - libm::exp(-part / (1.0 - part)) } else { 1.0 };
            let shown = if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * libm::pow(light, 1.0 / 2.4) - 0.055 };
            shown as f32
        };
        Screen { table: (0..STEPS + 2).map(shown).collect() }
    }

    /// Displayable light of `light` >= 0: 1 - exp(-light), as sRGB encodes it.
    #[inline]
    pub(crate) fn shown(&self, light: f32) -> f32 {
        let place = light / (1.0 + light) * STEPS as f32;
        let step = (place as usize).min(STEPS);
        let (low, high) = (self.table[step], self.table[step + 1]);
        (low + (high - low) * (place - step as f32)).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_read_as_they_are_written() {
        for text in ["#000000", "#ff8001", "#0a1b2c"] {
            assert_eq!(Colour::parse(text).unwrap().to_string(), text);
        }
        for text in ["", "#", "#12345", "#1234567", "123456", "#+12345", "#gg0000"] {
            assert_eq!(Colour::parse(text), None, "{text}");
        }
        assert_eq!(Colour::of_hue(0.0, 1.0, 1.0), Colour([255, 0, 0]));
        assert_eq!(Colour::of_hue(1.0 / 3.0, 1.0, 1.0), Colour([0, 255, 0]));
        assert_eq!(Colour::of_hue(2.0 / 3.0, 0.5, 1.0), Colour([128, 128, 255]));
    }

    #[test]
    fn light_rises_to_white_without_a_flat_part_and_dark_light_stays_what_it_is() {
        let screen = Screen::new();
        let shown: Vec<f32> = (0..600).map(|step| screen.shown(step as f32 / 100.0)).collect();
        assert!(shown.windows(2).all(|pair| pair[0] < pair[1]) && shown[0] == 0.0);
        assert_eq!(screen.shown(f32::MAX / 4.0), 1.0);
        for byte in 0..60 {
            let dark = Colour([byte; 3]);
            let found = screen.shown(dark.light()[0]) * 255.0;
            assert!((found - f32::from(byte)).abs() < 0.02 * f32::from(byte) + 0.1, "{byte}: {found}");
        }
    }
}
