//! Colours as light.
//!
//! Owns the ways between hue, light and what a screen shows. Pure arithmetic.
//!
//! Start at [`of_hue`].

use std::f64::consts::TAU;

/// Linear light: red, green, blue; BT.709 primaries.
pub(crate) type Light = [f32; 3];

/// The colour of this lightness and chroma, with its hue in turns; nothing is below black.
///
/// # Source
/// Björn Ottosson, *A perceptual color space for image processing* (2020): Oklab.
pub(crate) fn of_hue(lightness: f64, chroma: f64, hue: f64) -> Light {
    let (sine, cosine) = libm::sincos(TAU * hue);
    let [a, b] = [chroma * cosine, chroma * sine];
    let cones = [
        lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b,
        lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b,
        lightness - 0.089_484_177_5 * a - 1.291_485_548 * b,
    ];
    let [l, m, s] = cones.map(|cone| cone * cone * cone);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701 * s,
    ]
    .map(|light| light.max(0.0) as f32)
}

/// The light of a colour that a screen shows, `0.0..=1.0`.
///
/// # Source
/// Chilliant, *SRGB approximations for HLSL* (2012), as for [`shown`].
pub(crate) fn light(colour: [f64; 3]) -> Light {
    colour.map(|c| (c * (c * (c * 0.305_306_011 + 0.682_171_111) + 0.012_522_878)) as f32)
}

/// What a screen shows of light: bright light is compressed, so that nothing is cut off.
pub(crate) fn shown(light: f32) -> f32 {
    const KNEE: f32 = 0.65;
    let over = (light - KNEE).max(0.0) / (1.0 - KNEE);
    let light = light.clamp(0.0, KNEE) + (1.0 - KNEE) * over / (1.0 + over);
    let root = light.sqrt();
    let fourth = root.sqrt();
    let eighth = fourth.sqrt();
    (0.585_122_4 * root + 0.783_140_36 * fourth - 0.368_262_74 * eighth).clamp(0.0, 1.0)
}

pub(crate) fn mixed(a: Light, b: Light, part: f32) -> Light {
    [0, 1, 2].map(|channel| a[channel] + (b[channel] - a[channel]) * part)
}
