//! Raspberry Pi's graphics: vc4.
//!
//! Owns the Pi 4. The Pi 5 differs in its largest framebuffer alone, as far as a player can see.
//!
//! Sources: `drivers/gpu/drm/vc4/` of Linux 6.12: `vc4_hdmi.c` (`vc4_hdmi_connector_init`: margins on HDMI, too),
//! `vc4_plane.c` (formats, rotations, any scale), `vc4_crtc.c` (no gamma and no matrix from the Pi 4 on), `vc4_kms.c`
//! (framebuffers up to 7680); `drm_hdmi_state_helper.c` (`Broadcast RGB`); raspberrypi/linux #5034 and #4695.
//! Less certain: how many scaled planes the line memory takes (`ENOSPC`), which one plane does not reach.

use super::{BLENDING, BROADCAST_RGB, CORE, HDMI_COLORSPACE, IN_FORMATS, ValueRange, YUV};
use crate::kms::scripted::family::{Family, Limits, Row, Window};
use crate::paint::Format;
use ValueRange::{Any, Bits, UpTo};

const OWN: &[Row] = &[
    Row::new("n", "max bpc", UpTo(12)).at(12).sets_mode(),
    Row::new("n", "HDR_OUTPUT_METADATA", Any).left(904).sets_mode(),
    Row::new("n", "Colorspace", HDMI_COLORSPACE).left(9).sets_mode(),
    Row::new("n", "left margin", UpTo(100)).left(10),
    Row::new("n", "right margin", UpTo(100)).left(10),
    Row::new("n", "top margin", UpTo(100)).left(20),
    Row::new("n", "bottom margin", UpTo(100)).left(20),
    Row::new("n", "Broadcast RGB", BROADCAST_RGB).left(2).sets_mode(),
    Row::new("po", "rotation", Bits(&[("rotate-0", 1), ("rotate-180", 4), ("reflect-x", 16), ("reflect-y", 32)]))
        .at(1)
        .left(4),
    Row::new("p", "zpos", UpTo(17)).fixed(0),
    IN_FORMATS,
];

pub(crate) const PI4: Family = Family {
    driver: "vc4",
    about: "Raspberry Pi 4 and 5",
    connector: "HDMI-A-1",
    rows: &[CORE, OWN, YUV, BLENDING],
    limits: Limits {
        formats: &Format::ALL,
        has_modifiers: true,
        pitch: 1,
        largest: (7680, 7680),
        shrinks: 10_000,
        must_cover: false,
        turns_linear: false,
        window: Window::Moves,
        ramps: &[],
        waits_to_dim: false,
        has_vblanks: true,
        fastest_khz: 340_000,
        has_one_mode: false,
    },
    has_overlay: true,
};
