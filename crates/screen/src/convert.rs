//! BT.709 limited-range YUV to full-range RGB, in integers.
//!
//! Owns the one colour conversion of the player, for planes that take no YUV. Never runs where a plane converts by
//! itself. Start at [`xrgb_row`]; a test compares it with the float matrix.

/// Fraction bits of the coefficients below: 14 keeps every product within `i32`.
const BITS: u32 = 14;
/// 255 / 219: luma's range to full range.
const LUMA: i32 = fixed(255.0 / 219.0);
/// BT.709 (Kr = 0.2126, Kb = 0.0722), chroma's range of 224 to full range of 255.
const RED_FROM_V: i32 = fixed(2.0 * (1.0 - 0.2126) * 255.0 / 224.0);
const GREEN_FROM_U: i32 = fixed(2.0 * (1.0 - 0.0722) * 0.0722 / 0.7152 * 255.0 / 224.0);
const GREEN_FROM_V: i32 = fixed(2.0 * (1.0 - 0.2126) * 0.2126 / 0.7152 * 255.0 / 224.0);
const BLUE_FROM_U: i32 = fixed(2.0 * (1.0 - 0.0722) * 255.0 / 224.0);

const fn fixed(coefficient: f64) -> i32 {
    (coefficient * (1 << BITS) as f64 + 0.5) as i32
}

/// Converts one row of luma and its half-wide rows of chroma to little-endian XRGB8888. Each chroma sample colours
/// two pixels, as scan-out hardware does.
///
/// * `y` — an even number of samples; `u`, `v` — half as many.
/// * `out` — four bytes per luma sample: B, G, R, X.
///
/// # Source
/// ITU-R BT.709-6, items 3.2 to 3.5.
pub(crate) fn xrgb_row(out: &mut [u8], y: &[u8], u: &[u8], v: &[u8]) {
    for (((pixels, y), &u), &v) in out.chunks_exact_mut(8).zip(y.chunks_exact(2)).zip(u).zip(v) {
        let (u, v) = (i32::from(u) - 128, i32::from(v) - 128);
        let red = RED_FROM_V * v;
        let green = -GREEN_FROM_U * u - GREEN_FROM_V * v;
        let blue = BLUE_FROM_U * u;
        let near = LUMA * (i32::from(y[0]) - 16) + (1 << (BITS - 1));
        let far = LUMA * (i32::from(y[1]) - 16) + (1 << (BITS - 1));
        let full = |sum: i32| (sum >> BITS).clamp(0, 255) as u8;
        pixels.copy_from_slice(&[
            full(near + blue),
            full(near + green),
            full(near + red),
            255,
            full(far + blue),
            full(far + green),
            full(far + red),
            255,
        ]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The matrix of BT.709 as it is published, in floats.
    fn by_the_book(y: u8, u: u8, v: u8) -> [f64; 3] {
        let (kr, kb) = (0.2126, 0.0722);
        let kg = 1.0 - kr - kb;
        let luma = (f64::from(y) - 16.0) / 219.0;
        let (pb, pr) = ((f64::from(u) - 128.0) / 224.0, (f64::from(v) - 128.0) / 224.0);
        let red = luma + 2.0 * (1.0 - kr) * pr;
        let blue = luma + 2.0 * (1.0 - kb) * pb;
        let green = (luma - kr * red - kb * blue) / kg;
        [blue, green, red].map(|light| (light * 255.0).clamp(0.0, 255.0))
    }

    #[test]
    fn every_colour_is_within_one_step_of_the_float_matrix() {
        let mut out = [0; 8];
        for y in 0..=255 {
            for u in (0..=255).step_by(3) {
                for v in (0..=255).step_by(3) {
                    xrgb_row(&mut out, &[y, 235 - y.min(235)], &[u], &[v]);
                    for (channel, exact) in by_the_book(y, u, v).into_iter().enumerate() {
                        let off = (f64::from(out[channel]) - exact).abs();
                        assert!(off <= 1.0, "y {y} u {u} v {v} channel {channel}: {} for {exact}", out[channel]);
                    }
                }
            }
        }
    }

    #[test]
    fn black_is_black_and_white_is_white() {
        let mut out = [0; 8];
        xrgb_row(&mut out, &[16, 235], &[128], &[128]);
        assert_eq!(out, [0, 0, 0, 255, 255, 255, 255, 255]);
    }
}
