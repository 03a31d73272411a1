//! Driver families, each as public sources tell of it.
//!
//! Owns the properties that all of them have, and the list of them. Where a fact is not certain its file says so. Nothing here
//! was read off a device: what a real one does besides, only a real one tells.
//!
//! Source of what is said here: the kernel's `drm_mode_config.c`, `drm_connector.c`, `drm_blend.c`, `drm_color_mgmt.c` and
//! `drm_atomic_uapi.c`, 6.12.

pub(crate) mod amdgpu;
pub(crate) mod generic;
pub(crate) mod i915;
pub(crate) mod simple;
pub(crate) mod vc4;

use super::family::{Family, Row, ValueRange};
use ValueRange::{Any, Bits, Choice, UpTo};

/// All families of real drivers.
pub(crate) const ALL: [&Family; 12] = [
    &i915::HASWELL,
    &i915::SKYLAKE,
    &i915::KABY_LAKE,
    &i915::TIGER_LAKE,
    &i915::ALDER_LAKE_N,
    &amdgpu::DCN1,
    &amdgpu::DCN2,
    &amdgpu::DCE,
    &vc4::PI4,
    &simple::SIMPLEDRM,
    &simple::VIRTIO_GPU,
    &simple::BOCHS,
];

const KIND: ValueRange = Choice(&[("Overlay", 0), ("Primary", 1), ("Cursor", 2)]);

/// What every atomic driver has.
pub(crate) const CORE: &[Row] = &[
    Row::new("npo", "CRTC_ID", Any),
    Row::new("n", "link-status", Choice(&[("Good", 0), ("Bad", 1)])).sets_mode(),
    Row::new("c", "ACTIVE", UpTo(1)),
    Row::new("c", "MODE_ID", Any),
    Row::new("c", "VRR_ENABLED", UpTo(1)).left(1),
    Row::new("p", "type", KIND).fixed(1),
    Row::new("o", "type", KIND).fixed(0),
    Row::new("po", "FB_ID", Any),
    Row::new("po", "SRC_X", Any),
    Row::new("po", "SRC_Y", Any),
    Row::new("po", "SRC_W", Any),
    Row::new("po", "SRC_H", Any),
    Row::new("po", "CRTC_X", Any),
    Row::new("po", "CRTC_Y", Any),
    Row::new("po", "CRTC_W", Any),
    Row::new("po", "CRTC_H", Any),
];

pub(crate) const IN_FORMATS: Row = Row::new("p", "IN_FORMATS", Any).fixed(1);
pub(crate) const CONTENT_TYPE: ValueRange =
    Choice(&[("No Data", 0), ("Graphics", 1), ("Photo", 2), ("Cinema", 3), ("Game", 4)]);
pub(crate) const BROADCAST_RGB: ValueRange = Choice(&[("Automatic", 0), ("Full", 1), ("Limited 16:235", 2)]);
pub(crate) const ASPECT_RATIO: ValueRange = Choice(&[("Automatic", 0), ("4:3", 1), ("16:9", 2)]);
pub(crate) const HDMI_COLORSPACE: ValueRange = Choice(&[
    ("Default", 0),
    ("SMPTE_170M_YCC", 1),
    ("BT709_YCC", 2),
    ("XVYCC_601", 3),
    ("XVYCC_709", 4),
    ("SYCC_601", 5),
    ("opYCC_601", 6),
    ("opRGB", 7),
    ("BT2020_CYCC", 8),
    ("BT2020_RGB", 9),
    ("BT2020_YCC", 10),
    ("DCI-P3_RGB_D65", 11),
    ("DCI-P3_RGB_Theater", 12),
]);
pub(crate) const PANEL_ORIENTATION: ValueRange =
    Choice(&[("Normal", 0), ("Upside Down", 1), ("Left Side Up", 2), ("Right Side Up", 3)]);
pub(crate) const ENCODING: ValueRange =
    Choice(&[("ITU-R BT.601 YCbCr", 0), ("ITU-R BT.709 YCbCr", 1), ("ITU-R BT.2020 YCbCr", 2)]);
pub(crate) const RANGE: ValueRange = Choice(&[("YCbCr limited range", 0), ("YCbCr full range", 1)]);
pub(crate) const BLEND: ValueRange = Choice(&[("None", 2), ("Pre-multiplied", 0), ("Coverage", 1)]);
pub(crate) const SCALING_FILTER: ValueRange = Choice(&[("Default", 0), ("Nearest Neighbor", 1)]);
pub(crate) const ROTATE_HALF: ValueRange = Bits(&[("rotate-0", 1), ("rotate-180", 4)]);
pub(crate) const ROTATE_ALL: ValueRange =
    Bits(&[("rotate-0", 1), ("rotate-90", 2), ("rotate-180", 4), ("rotate-270", 8)]);

/// The colours of planes that take YUV, which another process has set otherwise.
pub(crate) const YUV: &[Row] =
    &[Row::new("p", "COLOR_ENCODING", ENCODING).at(1).left(0), Row::new("p", "COLOR_RANGE", RANGE).left(1)];

/// Blending, which another process has set otherwise.
pub(crate) const BLENDING: &[Row] = &[
    Row::new("po", "alpha", UpTo(0xffff)).at(0xffff).left(0x8000),
    Row::new("po", "pixel blend mode", BLEND).at(2).left(0),
];
