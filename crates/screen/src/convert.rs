//! BT.709 limited-range YUV to full-range RGB, in integers.
//!
//! Owns the player's colour conversion, for planes that take RGB only. Start at [`xrgb_row`]; a test compares it with
//! the float matrix.

/// Pixels converted together: a length that compilers turn into vector instructions.
const BLOCK: usize = 16;
/// Fraction bits of the sums before they are rounded.
const SUM_BITS: u32 = 5;
/// Left shifts that let samples fill an `i16`: luma of -16 to 239, chroma of -128 to 127.
const LUMA_SHIFT: u32 = 7;
const CHROMA_SHIFT: u32 = 8;

/// BT.709 luma weights of red, green and blue. `video` cannot see this crate and has its own copy; a test compares them.
const WEIGHTS: [f64; 3] = [0.2126, 0.7152, 0.0722];
/// Limited range to full range: 219 steps of luma and 224 of chroma become 255.
const LUMA: i16 = fixed(255.0 / 219.0, LUMA_SHIFT);
const RED_FROM_V: i16 = fixed(2.0 * (1.0 - WEIGHTS[0]) * 255.0 / 224.0, CHROMA_SHIFT);
const GREEN_FROM_U: i16 = fixed(-2.0 * (1.0 - WEIGHTS[2]) * WEIGHTS[2] / WEIGHTS[1] * 255.0 / 224.0, CHROMA_SHIFT);
const GREEN_FROM_V: i16 = fixed(-2.0 * (1.0 - WEIGHTS[0]) * WEIGHTS[0] / WEIGHTS[1] * 255.0 / 224.0, CHROMA_SHIFT);
const BLUE_FROM_U: i16 = fixed(2.0 * (1.0 - WEIGHTS[2]) * 255.0 / 224.0, CHROMA_SHIFT);

/// `coefficient` such that [`high`] of it and a sample shifted left by `shift` has `SUM_BITS` fraction bits.
const fn fixed(coefficient: f64, shift: u32) -> i16 {
    let scaled = coefficient * (1u32 << (16 + SUM_BITS - shift)) as f64;
    (if scaled < 0.0 { scaled - 0.5 } else { scaled + 0.5 }) as i16
}

/// The upper half of the product: one instruction per eight of them.
fn high(a: i16, b: i16) -> i16 {
    ((i32::from(a) * i32::from(b)) >> 16) as i16
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
    let chroma = u.chunks(BLOCK / 2).zip(v.chunks(BLOCK / 2));
    for ((out, y), (u, v)) in out.chunks_mut(BLOCK * 4).zip(y.chunks(BLOCK)).zip(chroma) {
        let (mut luma, mut blue, mut red) = ([16; BLOCK], [128; BLOCK / 2], [128; BLOCK / 2]);
        luma[..y.len()].copy_from_slice(y);
        blue[..u.len()].copy_from_slice(u);
        red[..v.len()].copy_from_slice(v);
        let pixels = block(luma, blue, red);
        for (bytes, pixel) in out.chunks_exact_mut(4).zip(pixels) {
            bytes.copy_from_slice(&pixel.to_le_bytes());
        }
    }
}

/// One pass per step, each over whole arrays, so that the compiler vectorises it.
fn block(y: [u8; BLOCK], u: [u8; BLOCK / 2], v: [u8; BLOCK / 2]) -> [u32; BLOCK] {
    let luma = y.map(|y| high((i16::from(y) - 16) << LUMA_SHIFT, LUMA) + (1 << (SUM_BITS - 1)));
    let u = u.map(|u| (i16::from(u) - 128) << CHROMA_SHIFT);
    let v = v.map(|v| (i16::from(v) - 128) << CHROMA_SHIFT);
    let green: [i16; BLOCK / 2] = std::array::from_fn(|at| high(u[at], GREEN_FROM_U) + high(v[at], GREEN_FROM_V));
    let channel = |chroma: [i16; BLOCK / 2]| -> [u8; BLOCK] {
        let twice: [i16; BLOCK] = std::array::from_fn(|at| chroma[at / 2]);
        std::array::from_fn(|at| ((luma[at] + twice[at]) >> SUM_BITS).clamp(0, 255) as u8)
    };
    let (blue, red) = (u.map(|u| high(u, BLUE_FROM_U)), v.map(|v| high(v, RED_FROM_V)));
    let (blue, green, red) = (channel(blue), channel(green), channel(red));
    std::array::from_fn(|at| u32::from_le_bytes([blue[at], green[at], red[at], 255]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The published BT.709 matrix, in floats.
    fn by_the_book(y: u8, u: u8, v: u8) -> [f64; 3] {
        let [kr, _, kb] = WEIGHTS;
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
    fn a_row_of_any_even_length_is_converted_to_its_end() {
        for width in (2..70).step_by(2) {
            let mut out = vec![0; width * 4];
            xrgb_row(&mut out, &vec![235; width], &vec![128; width / 2], &vec![128; width / 2]);
            assert_eq!(out, vec![255; width * 4]);
        }
    }

    #[test]
    fn black_is_black_and_white_is_white() {
        let mut out = [0; 8];
        xrgb_row(&mut out, &[16, 235], &[128], &[128]);
        assert_eq!(out, [0, 0, 0, 255, 255, 255, 255, 255]);
    }
}
