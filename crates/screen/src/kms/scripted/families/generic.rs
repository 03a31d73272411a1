//! A card that can do nearly all, for the claims that are not about a driver.
//!
//! Owns one description. It is no driver's: it has what the claims of `fault_matrix.rs` and `night.rs` need.

use super::{BLENDING, CORE, IN_FORMATS, ROTATE_ALL, ValueRange, YUV};
use crate::kms::scripted::family::{Family, Limits, Row, Window};
use crate::paint::Format;
use ValueRange::{Any, UpTo};

const OWN: &[Row] = &[
    Row::new("c", "GAMMA_LUT", Any),
    Row::new("c", "GAMMA_LUT_SIZE", UpTo(65_536)).fixed(256),
    Row::new("po", "rotation", ROTATE_ALL).at(1).left(4),
    Row::new("p", "zpos", UpTo(8)).fixed(0),
    IN_FORMATS,
];

pub(crate) const GENERIC: Family = Family {
    driver: "scripted",
    about: "nothing real",
    connector: "HDMI-A-1",
    rows: &[CORE, YUV, BLENDING, OWN],
    limits: LIMITS,
    has_overlay: true,
};

/// Few.
pub(crate) const LIMITS: Limits = Limits {
    formats: &Format::ALL,
    has_modifiers: true,
    pitch: 1,
    largest: (16_384, 16_384),
    shrinks: 400,
    must_cover: false,
    turns_linear: true,
    window: Window::Moves,
    ramps: &[256],
    waits_to_dim: false,
    has_vblanks: true,
    fastest_khz: 600_000,
    has_one_mode: false,
};

/// The same, with a plane that shows pictures pixel by pixel or not at all.
pub(crate) const UNSCALED: Family = Family { limits: Limits { shrinks: 0, must_cover: true, ..LIMITS }, ..GENERIC };

const NO_RAMP: &[Row] =
    &[Row::new("c", "CTM", Any).left(902), Row::new("po", "rotation", ROTATE_ALL).at(1).left(4), IN_FORMATS];

/// The same with a matrix of colours, and no gamma ramp.
pub(crate) const MATRIX: Family = Family { rows: &[CORE, YUV, BLENDING, NO_RAMP], ..GENERIC };

/// The same without vblanks: it flips at once.
pub(crate) const UNCOUNTED: Family = Family { limits: Limits { has_vblanks: false, ..LIMITS }, ..GENERIC };
