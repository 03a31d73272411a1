//! Intel's graphics: i915, and xe, which shares its display code.
//!
//! Owns five generations, of which Skylake stands for Broxton, Kaby Lake for Coffee and Comet Lake, Tiger Lake for Ice Lake
//! and Alder Lake-S, and Alder Lake-N for Alder Lake-P, Raptor Lake-P and Meteor Lake.
//!
//! Sources: `drivers/gpu/drm/i915/display/` of Linux 6.12: `intel_hdmi.c` (`intel_hdmi_add_properties`), `intel_dp.c`
//! (`intel_edp_add_properties`), `intel_connector.c`, `intel_color.c` (`check_lut_size`: any length but the platform's
//! own and 256 is refused), `i9xx_plane.c` and `skl_universal_plane.c` (formats, rotations, `skl_plane_check_fb`: no
//! quarter turn with linear memory), `skl_scaler.c` (a third at most, a half with NV12 on display 9), `intel_atomic.c`
//! (`intel_digital_connector_atomic_check`); snapshots 3098e364a885, 73d91f466984, ba23a2b55a38 and e2c1bb803152 (with
//! `Broadcast RGB` left on full) of drmdb. Less certain: that a changed `Broadcast RGB` of an HDMI connector always
//! takes a commit that may set a mode: it does where the levels differ.

use super::{
    ASPECT_RATIO, BLENDING, BROADCAST_RGB, CONTENT_TYPE, CORE, ENCODING, HDMI_COLORSPACE, IN_FORMATS,
    PANEL_ORIENTATION, RANGE, ROTATE_ALL, ROTATE_HALF, SCALING_FILTER, ValueRange,
};
use crate::kms::scripted::family::{Family, Limits, Row, Window};
use crate::paint::Format;
use ValueRange::{Any, Choice, UpTo};

const HDMI: &[Row] = &[
    Row::new("n", "audio", Choice(&[("force-dvi", u64::MAX - 1), ("off", u64::MAX), ("auto", 0), ("on", 1)])),
    Row::new("n", "Broadcast RGB", BROADCAST_RGB).left(1).sets_mode(),
    Row::new("n", "aspect ratio", ASPECT_RATIO).left(1).sets_mode(),
    Row::new("n", "Colorspace", HDMI_COLORSPACE).left(9).sets_mode(),
    Row::new("n", "content type", CONTENT_TYPE).left(3).sets_mode(),
    Row::new("n", "max bpc", UpTo(12)).at(12).sets_mode(),
];

const PANEL: &[Row] = &[
    Row::new("n", "panel orientation", PANEL_ORIENTATION).fixed(3),
    Row::new("n", "scaling mode", Choice(&[("Full", 1), ("Center", 2), ("Full aspect", 3)])).at(3).left(2),
    Row::new("n", "Broadcast RGB", BROADCAST_RGB).left(1),
    Row::new("n", "max bpc", UpTo(12)).at(12).left(6).sets_mode(),
];

/// A CRTC's colours, with a ramp of so many entries.
const fn colours(entries: u64) -> [Row; 5] {
    [
        Row::new("c", "DEGAMMA_LUT", Any).left(901),
        Row::new("c", "CTM", Any).left(902),
        Row::new("c", "GAMMA_LUT", Any).left(903),
        Row::new("c", "GAMMA_LUT_SIZE", Any).fixed(entries),
        Row::new("c", "DEGAMMA_LUT_SIZE", Any).fixed(33),
    ]
}
const SHORT: &[Row] = &colours(1024);
const LONG: &[Row] = &colours(262_145);

/// Display 9 and later.
const UNIVERSAL: &[Row] = &[
    Row::new("p", "COLOR_ENCODING", ENCODING).at(1).left(0),
    Row::new("p", "COLOR_RANGE", RANGE).left(1),
    Row::new("p", "zpos", UpTo(4)).fixed(0),
    IN_FORMATS,
];

const LIMITS: Limits = Limits {
    formats: &[Format::Nv12, Format::Xr24],
    has_modifiers: true,
    pitch: 64,
    largest: (16_384, 16_384),
    shrinks: 299,
    must_cover: false,
    turns_linear: false,
    window: Window::Moves,
    ramps: &[256, 1024],
    waits_to_dim: false,
    has_vblanks: true,
    fastest_khz: 300_000,
    has_one_mode: false,
};

/// Display 7.5 and 8: Haswell and Broadwell.
pub(crate) const HASWELL: Family = Family {
    driver: "i915",
    about: "Haswell, Broadwell",
    connector: "HDMI-A-1",
    rows: &[CORE, HDMI, SHORT, &[Row::new("p", "rotation", ROTATE_HALF).at(1), IN_FORMATS]],
    limits: Limits { formats: &[Format::Xr24], shrinks: 0, must_cover: true, ..LIMITS },
    has_overlay: true,
};

/// Display 9 without planar formats: Skylake.
pub(crate) const SKYLAKE: Family = Family {
    driver: "i915",
    about: "Skylake, Broxton",
    connector: "HDMI-A-1",
    rows: &[CORE, HDMI, SHORT, UNIVERSAL, BLENDING, &[Row::new("p", "rotation", ROTATE_ALL).at(1).left(4)]],
    limits: Limits { formats: &[Format::Xr24], ..LIMITS },
    has_overlay: true,
};

/// Display 9 with NV12: Kaby Lake and after it.
pub(crate) const KABY_LAKE: Family =
    Family { about: "Kaby, Coffee and Comet Lake", limits: Limits { shrinks: 199, ..LIMITS }, ..SKYLAKE };

/// Display 11 and 12.
pub(crate) const TIGER_LAKE: Family = Family {
    driver: "i915",
    about: "Ice, Tiger and Rocket Lake, Alder Lake-S",
    connector: "HDMI-A-1",
    rows: &[
        CORE,
        HDMI,
        LONG,
        UNIVERSAL,
        BLENDING,
        &[
            Row::new("p", "rotation", ROTATE_ALL).at(1).left(4),
            Row::new("pc", "SCALING_FILTER", SCALING_FILTER).left(1),
            Row::new("n", "HDR_OUTPUT_METADATA", Any).left(904).sets_mode(),
        ],
    ],
    limits: Limits { ramps: &[256, 262_145], fastest_khz: 594_000, ..LIMITS },
    has_overlay: true,
};

/// Display 13, at a panel that is built in on its side.
pub(crate) const ALDER_LAKE_N: Family = Family {
    driver: "i915",
    about: "Alder Lake-N and -P, Raptor Lake-P, Meteor Lake; a built-in panel",
    connector: "eDP-1",
    rows: &[CORE, PANEL, SHORT, UNIVERSAL, BLENDING, &[Row::new("p", "rotation", ROTATE_HALF).at(1).left(4)]],
    limits: Limits { fastest_khz: 594_000, ..LIMITS },
    has_overlay: true,
};
