//! The polynomials of the elementary functions in `f32`, the coefficient of the highest power first.
//!
//! Owns their coefficients, and numbers that arguments are reduced by. Never calculates: `lanes.rs` does, and so do
//! shaders.
//!
//! # Source
//! Arc tangent: Abramowitz & Stegun, *Handbook of Mathematical Functions* (1964), 4.4.49. Sine, cosine, logarithm and
//! power of 2: the minimax polynomials of Moshier's Cephes library (`sinf`, `cosf`, `logf`, `exp2f`).

/// (sin r - r) / r³ over r², for r in -π/4..=π/4.
pub const SIN: [f32; 3] = [-1.951_529_6e-4, 8.332_161e-3, -1.666_665_5e-1];

/// (cos r - 1 + r² / 2) / r⁴ over r², for r in -π/4..=π/4.
pub const COS: [f32; 3] = [2.443_315_7e-5, -1.388_731_6e-3, 4.166_664_6e-2];

/// (atan s - s) / s³ over s², for s in 0..=1.
pub const ATAN: [f32; 8] = [
    2.866_225_7e-3,
    -1.616_573_7e-2,
    4.290_961_4e-2,
    -7.528_964e-2,
    1.065_626_4e-1,
    -0.142_089,
    1.999_355_1e-1,
    -3.333_314_5e-1,
];

/// (ln (1 + m) - m + m² / 2) / m³ over m, for 1 + m in √½..√2.
pub const LOG: [f32; 9] = [
    7.037_683_6e-2,
    -1.151_461e-1,
    1.167_699_9e-1,
    -1.242_014_1e-1,
    1.424_932_3e-1,
    -1.666_805_8e-1,
    2.000_071_5e-1,
    -2.5e-1,
    0.333_333_3,
];

/// 2^x over x, for x in -½..=½.
pub const EXP2: [f32; 7] =
    [1.535_336_2e-4, 1.339_887_4e-3, 9.618_437e-3, 5.550_332_6e-2, 2.402_264_8e-1, 6.931_472e-1, 1.0];

/// What π/2 as f32 lacks.
pub const LACKING: f32 = -4.371_139e-8;

/// √½ in bits: what is left of a number by its power of 2 lies in √½..√2.
pub const HALF_ROOT: u32 = 0x3f35_04f3;
