//! A finished picture.
//!
//! Owns the layout of displayable light. Never knows which species drew it or where it goes: writing a PNG or encoding a clip
//! is the caller's.
//!
//! Start at [`Image`].

/// Displayable light: `[height][width][3]` f32, row-major, red green blue, each in `0.0..=1.0`.
///
/// The values are gamma-encoded for a screen, full range, BT.709 primaries.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `height * width` pixels of red, green, blue.
    pub pixels: Vec<[f32; 3]>,
}

impl Image {
    /// The picture as `[height][width][3]` bytes, full range, dithered: on average a byte is what the light is, so that
    /// dark gradients have no steps. Black and white stay what they are. The pattern is fixed, another one for each colour,
    /// and has no structure that is seen.
    ///
    /// # Source
    /// Jorge Jimenez, *Next Generation Post Processing in Call of Duty* (2014): interleaved gradient noise.
    pub fn to_rgb8(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(3 * self.pixels.len());
        for (number, pixel) in self.pixels.iter().enumerate() {
            let (column, row) = (number % self.width, number / self.width);
            for (channel, light) in pixel.iter().enumerate() {
                bytes.push((light * 255.0 + threshold(column + 29 * channel, row)) as u8);
            }
        }
        bytes
    }

    /// The picture as `[height][width][3]` u16, full range, rounded to nearest.
    pub fn to_rgb16(&self) -> Vec<u16> {
        self.pixels.as_flattened().iter().map(|light| (light * 65535.0 + 0.5) as u16).collect()
    }
}

/// What is added before rounding down, from 0 up to 1.
fn threshold(column: usize, row: usize) -> f32 {
    // In f64 and modulo 1 at once: far from the corner, f32 would leave few of its values.
    let inner = 0.067_110_56 * column as f64 + 0.005_837_15 * row as f64;
    let threshold = 52.982_918_9 * inner.fract();
    (threshold.fract() as f32).min(0.999)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_on_average_what_the_light_is_and_black_and_white_stay() {
        let (width, height) = (128, 96);
        let even = |light: f32| Image { width, height, pixels: vec![[light; 3]; width * height] }.to_rgb8();
        assert!(even(0.0).iter().all(|byte| *byte == 0) && even(1.0).iter().all(|byte| *byte == 255));
        for light in [0.001, 0.0137, 0.02, 0.5, 0.987] {
            let bytes = even(light);
            for channel in 0..3 {
                let of_channel = || bytes.iter().skip(channel).step_by(3).map(|byte| f32::from(*byte));
                let mean = of_channel().sum::<f32>() / (width * height) as f32;
                assert!((mean - 255.0 * light).abs() < 0.02, "{light}: {mean}");
                let near = of_channel().all(|byte| (byte - 255.0 * light).abs() <= 1.0);
                assert!(near, "{light}: a byte is further than one step away");
            }
        }
    }
}
