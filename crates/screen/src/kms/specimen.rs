//! The objects of a scripted card, as a survey tells of them.
//!
//! Owns which object has which property, and the makers of planes and modes for tests. Never keeps a value:
//! `scripted.rs` does.

use super::card::{Id, Plane, PlaneFormat, Properties, Property, Values};
use crate::paint::Format;
use drm::control::{Mode, ModeFlags, ModeTypeFlags};

/// The kinds of object that have a property, its name, and its choices.
pub(crate) type PropertyRow = (&'static str, &'static str, &'static [(&'static str, u64)]);

/// Which object kinds (`n` connector, `c` CRTC, `p` primary, `o` overlay) have which property, and what it takes.
/// Its id is 100 and its place in this list.
pub(crate) const SCHEMA: [PropertyRow; 25] = [
    ("ncpo", "", &[]),
    ("npo", "CRTC_ID", &[]),
    ("n", "link-status", &[("Good", 0), ("Bad", 1)]),
    ("c", "ACTIVE", &[]),
    ("c", "MODE_ID", &[]),
    ("c", "VRR_ENABLED", &[]),
    ("c", "GAMMA_LUT", &[]),
    ("c", "GAMMA_LUT_SIZE", &[]),
    ("p", "type", &[("Overlay", 0), ("Primary", 1), ("Cursor", 2)]),
    ("po", "FB_ID", &[]),
    ("po", "SRC_X", &[]),
    ("po", "SRC_Y", &[]),
    ("po", "SRC_W", &[]),
    ("po", "SRC_H", &[]),
    ("po", "CRTC_X", &[]),
    ("po", "CRTC_Y", &[]),
    ("po", "CRTC_W", &[]),
    ("po", "CRTC_H", &[]),
    ("po", "rotation", &[]),
    ("po", "alpha", &[]),
    ("p", "COLOR_ENCODING", &[("ITU-R BT.601 YCbCr", 0), ("ITU-R BT.709 YCbCr", 1)]),
    ("p", "COLOR_RANGE", &[("YCbCr limited range", 0), ("YCbCr full range", 1)]),
    ("p", "pixel blend mode", &[("None", 2), ("Pre-multiplied", 0)]),
    ("p", "zpos", &[]),
    ("p", "IN_FORMATS", &[]),
];

/// The properties of an object of `kind`, with the values that `value` gives by name.
pub(crate) fn properties(kind: char, value: impl Fn(&'static str) -> u64) -> Properties {
    let has = SCHEMA.iter().enumerate().filter(|(_, (kinds, ..))| kinds.contains(kind));
    let property = |(index, &(_, name, choices)): (usize, &PropertyRow)| Property {
        id: Id(100 + index as u32),
        name: name.to_owned(),
        value: if name == "type" { 1 } else { value(name) },
        mutable: !["type", "zpos", "IN_FORMATS", "GAMMA_LUT_SIZE"].contains(&name),
        values: match choices {
            [] if name == "alpha" => Values::UpTo { max: 0xffff },
            [] => Values::Other,
            choices => Values::Named(choices.iter().map(|&(choice, value)| (choice.to_owned(), value)).collect()),
        },
    };
    Properties(has.map(property).collect())
}

/// A plane of the only CRTC that takes all our formats.
pub(crate) fn plane(id: Id, properties: Properties) -> Plane {
    let formats = Format::ALL.map(|format| PlaneFormat { format, explicit: true }).into();
    Plane { id, crtcs: 1, formats, properties }
}

/// A mode of (width, height, kilohertz, total width, total height, flags, preferred).
pub(crate) fn mode((width, height, clock, htotal, vtotal, flags, preferred): ModeRow) -> Mode {
    let type_ = if preferred { ModeTypeFlags::PREFERRED.bits() } else { 0 };
    let (hdisplay, vdisplay) = (width, height);
    let raw = drm_ffi::drm_mode_modeinfo {
        clock,
        hdisplay,
        htotal,
        vdisplay,
        vtotal,
        flags: flags.bits(),
        type_,
        ..Default::default()
    };
    raw.into()
}

/// What [`mode`] takes.
pub(crate) type ModeRow = (u16, u16, u32, u16, u16, ModeFlags, bool);
