//! The features and limits of a driver family, as plain data.
//!
//! Owns the vocabulary in which `families/` describes drivers, and the makers of surveyed objects and modes for tests. Never
//! keeps a value: the card in `mod.rs` does; never refuses anything: `check.rs` does.
//!
//! Start at [`Family`].

use crate::kms::card::{Id, Plane, PlaneFormat, Properties, Property, Values};
use crate::paint::Format;
use drm::control::{Mode, ModeFlags, ModeTypeFlags};

/// A family of drivers, with one connector, one CRTC, a primary plane, and an overlay where it has any.
#[derive(Debug)]
pub(crate) struct Family {
    /// The driver, as the kernel names it.
    pub(crate) driver: &'static str,
    /// Which of its devices this describes.
    pub(crate) about: &'static str,
    /// The connector's name.
    pub(crate) connector: &'static str,
    /// Every property of every object.
    pub(crate) rows: &'static [&'static [Row]],
    /// What it refuses.
    pub(crate) limits: Limits,
    /// Whether there is an overlay plane.
    pub(crate) has_overlay: bool,
}

/// Limits of a family of drivers.
#[expect(clippy::struct_excessive_bools, reason = "each is a fact of its own")]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// The formats that the primary plane takes in linear memory.
    pub(crate) formats: &'static [Format],
    /// Whether planes tell which memory layouts they take (`IN_FORMATS`).
    pub(crate) has_modifiers: bool,
    /// A framebuffer's rows begin at multiples of so many bytes.
    pub(crate) pitch: u32,
    /// The largest framebuffer, across and down.
    pub(crate) largest: (u32, u32),
    /// A picture may be shown at most so many times smaller than it is, in hundredths; 0 for a plane that does not scale.
    pub(crate) shrinks: u32,
    /// Whether the plane must cover the whole mode.
    pub(crate) must_cover: bool,
    /// Whether a quarter turn works with linear memory.
    pub(crate) turns_linear: bool,
    /// What it does with a window that does not begin at the framebuffer's first row.
    pub(crate) window: Window,
    /// How many entries a gamma ramp may have.
    pub(crate) ramps: &'static [u32],
    /// Whether a ramp or a matrix in a flip waits for a vblank before it returns.
    pub(crate) waits_to_dim: bool,
    /// Whether it counts vblanks.
    pub(crate) has_vblanks: bool,
    /// The fastest pixel clock, in kilohertz.
    pub(crate) fastest_khz: u32,
    /// Whether it takes the first mode of its list and no other.
    pub(crate) has_one_mode: bool,
}

/// What becomes of a window within a framebuffer that moves with a flip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Window {
    /// It moves.
    Moves,
    /// With NV12 it is refused elsewhere than at the first row.
    RefusedForNv12,
    /// It is accepted and not shown: the display freezes.
    Ignored,
}

/// One property of one or more kinds of object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    /// `n` connector, `c` CRTC, `p` primary plane, `o` overlay.
    pub(crate) kinds: &'static str,
    pub(crate) name: &'static str,
    pub(crate) takes: ValueRange,
    /// The neutral value: as the driver sets it.
    pub(crate) neutral: u64,
    /// The value that another process has left.
    pub(crate) left: u64,
    /// It cannot be set.
    pub(crate) is_fixed: bool,
    /// To change it takes a commit that may set a mode.
    pub(crate) sets_mode: bool,
}

/// What a property takes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ValueRange {
    /// One of these.
    Choice(&'static [(&'static str, u64)]),
    /// The sum of some of these.
    Bits(&'static [(&'static str, u64)]),
    /// Numbers up to this.
    UpTo(u64),
    /// An object, a blob or any number.
    Any,
}

impl Row {
    pub(crate) const fn new(kinds: &'static str, name: &'static str, takes: ValueRange) -> Self {
        Self { kinds, name, takes, neutral: 0, left: 0, is_fixed: false, sets_mode: false }
    }

    /// Its neutral value, which is left.
    pub(crate) const fn at(mut self, value: u64) -> Self {
        (self.neutral, self.left) = (value, value);
        self
    }

    /// What another process has left.
    pub(crate) const fn left(mut self, value: u64) -> Self {
        self.left = value;
        self
    }

    pub(crate) const fn fixed(mut self, value: u64) -> Self {
        self.is_fixed = true;
        self.at(value)
    }

    pub(crate) const fn sets_mode(mut self) -> Self {
        self.sets_mode = true;
        self
    }

    /// Whether the property takes `value`.
    pub(crate) fn takes(&self, value: u64) -> bool {
        match self.takes {
            ValueRange::Choice(choices) => choices.iter().any(|(_, choice)| *choice == value),
            ValueRange::Bits(bits) => value & !bits.iter().fold(0, |all, (_, bit)| all | bit) == 0,
            ValueRange::UpTo(most) => value <= most,
            ValueRange::Any => true,
        }
    }
}

/// The number of the first property; the others follow in the order of the rows.
const FIRST: u32 = 100;

impl Family {
    /// The row of the property with this number.
    pub(crate) fn row(&self, property: Id) -> &'static Row {
        self.all().nth((property.0 - FIRST) as usize).expect("a property of this family")
    }

    /// The row of the property of this name, of an object of `kind`.
    pub(crate) fn named(&self, kind: char, name: &str) -> Option<&'static Row> {
        self.all().find(|row| row.kinds.contains(kind) && row.name == name)
    }

    pub(crate) fn all(&self) -> impl Iterator<Item = &'static Row> + use<> {
        self.rows.iter().flat_map(|rows| rows.iter())
    }

    /// The properties of an object of `kind`, with the values that `value` gives by name.
    pub(crate) fn properties(&self, kind: char, value: impl Fn(&'static str) -> u64) -> Properties {
        let has = (FIRST..).zip(self.all()).filter(|(_, row)| row.kinds.contains(kind));
        let owned = |names: &[(&str, u64)]| names.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
        let property = |(id, row): (u32, &'static Row)| Property {
            id: Id(id),
            name: row.name.to_owned(),
            value: value(row.name),
            mutable: !row.is_fixed,
            values: match row.takes {
                ValueRange::Choice(choices) => Values::Named(owned(choices)),
                ValueRange::Bits(bits) => Values::Bits(owned(bits)),
                ValueRange::UpTo(max) => Values::UpTo { max },
                ValueRange::Any => Values::Other,
            },
        };
        Properties(has.map(property).collect())
    }

    /// A plane of the only CRTC.
    pub(crate) fn plane(&self, id: Id, properties: Properties) -> Plane {
        let explicit = self.limits.has_modifiers;
        let formats = Format::ALL.into_iter().filter(|format| self.limits.formats.contains(format));
        Plane { id, crtcs: 1, formats: formats.map(|format| PlaneFormat { format, explicit }).collect(), properties }
    }
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
