//! AMD's graphics with the display core: amdgpu.
//!
//! Owns three: Raven, Picasso and Dali (DCN1); Renoir to Phoenix (DCN2 and 3); Carrizo, Polaris and Vega (DCE).
//!
//! Sources: `drivers/gpu/drm/amd/display/amdgpu_dm/` of Linux 6.12: `amdgpu_dm.c` (`amdgpu_dm_connector_init_helper`,
//! `amdgpu_dm_atomic_check`, `fill_dc_scaling_info`: NV12 on DCN1 only from its first row on), `amdgpu_dm_crtc.c` (no CRTC
//! without its primary plane), `amdgpu_dm_plane.c` (formats, rotations), `amdgpu_dm_color.c` (`amdgpu_dm_verify_lut_sizes`:
//! 4096 or 256 entries), `amdgpu_display.c` (pitches in 256 bytes); display/dc/dml (no quarter turn of linear memory on DCN);
//! snapshots 960127d8dcfb and 5899a4bb5076 (with `max bpc` and `content type` left) of drmdb.
//! There is no `Broadcast RGB` in Linux 6.12. A ramp in a flip has it wait for all CRTCs.
//! Less certain: that DCE shows a quarter turn of linear memory rightly, so that it is not described as one that turns.

use super::{BLENDING, CONTENT_TYPE, CORE, IN_FORMATS, ROTATE_ALL, ValueRange, YUV};
use crate::kms::scripted::family::{Family, Limits, Row, Window};
use crate::paint::Format;
use ValueRange::{Any, Choice, UpTo};

const CONNECTOR: &[Row] = &[
    Row::new("n", "scaling mode", Choice(&[("None", 0), ("Full", 1), ("Center", 2), ("Full aspect", 3)]))
        .left(1)
        .sets_mode(),
    Row::new("n", "underscan", Choice(&[("off", 0), ("on", 1), ("auto", 2)])).left(1),
    Row::new("n", "underscan hborder", UpTo(128)).left(40),
    Row::new("n", "underscan vborder", UpTo(128)).left(30),
    Row::new("n", "max bpc", UpTo(16)).at(16).left(8).sets_mode(),
    Row::new("n", "content type", CONTENT_TYPE).left(1).sets_mode(),
    Row::new(
        "n",
        "Colorspace",
        Choice(&[("Default", 0), ("BT709_YCC", 2), ("opRGB", 7), ("BT2020_RGB", 9), ("BT2020_YCC", 10)]),
    )
    .left(9)
    .sets_mode(),
    Row::new("n", "HDR_OUTPUT_METADATA", Any).left(904).sets_mode(),
];

const COLOURS: &[Row] = &[
    Row::new("c", "DEGAMMA_LUT", Any).left(901),
    Row::new("c", "CTM", Any).left(902),
    Row::new("c", "GAMMA_LUT", Any).left(903),
    Row::new("c", "GAMMA_LUT_SIZE", Any).fixed(4096),
    Row::new("p", "rotation", ROTATE_ALL).at(1).left(4),
    Row::new("p", "zpos", UpTo(8)).fixed(2),
];

const LIMITS: Limits = Limits {
    formats: &[Format::Nv12, Format::Xr24],
    has_modifiers: true,
    pitch: 256,
    largest: (16_384, 16_384),
    shrinks: 400,
    must_cover: false,
    turns_linear: false,
    window: Window::Moves,
    ramps: &[256, 4096],
    waits_to_dim: true,
    has_vblanks: true,
    fastest_khz: 594_000,
    has_one_mode: false,
};

pub(crate) const DCN1: Family = Family {
    driver: "amdgpu",
    about: "Raven, Picasso, Dali (DCN1)",
    connector: "HDMI-A-1",
    rows: &[CORE, CONNECTOR, COLOURS, YUV, &[IN_FORMATS]],
    limits: Limits { window: Window::RefusedForNv12, ..LIMITS },
    has_overlay: true,
};

pub(crate) const DCN2: Family = Family {
    driver: "amdgpu",
    about: "Renoir to Phoenix (DCN2, DCN3)",
    connector: "DP-1",
    rows: &[CORE, CONNECTOR, COLOURS, YUV, BLENDING, &[IN_FORMATS]],
    limits: LIMITS,
    has_overlay: true,
};

pub(crate) const DCE: Family = Family {
    driver: "amdgpu",
    about: "Carrizo, Polaris, Vega (DCE)",
    connector: "HDMI-A-1",
    rows: &[CORE, CONNECTOR, COLOURS],
    limits: Limits { formats: &[Format::Xr24], has_modifiers: false, ..LIMITS },
    has_overlay: false,
};
