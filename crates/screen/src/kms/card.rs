//! What a KMS card offers, as plain data, and the thin interface to it.
//!
//! Owns the [`Kms`] trait and its vocabulary. Never decides anything: `choose.rs` and `ladder.rs` do.
//! Implementations: `device.rs` (the kernel) and `scripted.rs` (tests).

use crate::paint::{Format, Layout};
use drm::control::Mode;
use rustix::io::Errno;
use std::io;
use std::time::Duration;
use timing::{Nanos, Vblank};

/// A KMS object or property: connector, CRTC, plane, framebuffer, blob. Never 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Id(pub u32);

/// One property of one object, with its present value.
#[derive(Clone, Debug)]
pub struct Property {
    /// To set it by.
    pub id: Id,
    /// As the kernel names it: `CRTC_ID`, `rotation`.
    pub name: String,
    /// Its value now.
    pub value: u64,
    /// Whether it may be set.
    pub mutable: bool,
    /// Which values it takes.
    pub values: Values,
}

/// The values that a property takes.
#[derive(Clone, Debug)]
pub enum Values {
    /// Numbers up to `max`.
    UpTo {
        /// The largest.
        max: u64,
    },
    /// One of these.
    Named(Vec<(String, u64)>),
    /// The sum of some of these.
    Bits(Vec<(String, u64)>),
    /// An object or a blob.
    Other,
}

/// The properties of one object.
#[derive(Clone, Debug, Default)]
pub struct Properties(pub Vec<Property>);

impl Properties {
    /// The property called `name`.
    pub fn get(&self, name: &str) -> Option<&Property> {
        self.0.iter().find(|property| property.name == name)
    }

    /// The value of `name` now, 0 if there is no such property.
    pub fn value(&self, name: &str) -> u64 {
        self.get(name).map_or(0, |property| property.value)
    }

    /// The object that `name` refers to.
    pub fn object(&self, name: &str) -> Option<Id> {
        u32::try_from(self.value(name)).ok().filter(|&id| id != 0).map(Id)
    }

    /// The number behind `choice` of the enumeration `name`, if it may be set to that.
    pub fn choice(&self, name: &str, choice: &str) -> Option<(Id, u64)> {
        let property = self.get(name).filter(|property| property.mutable)?;
        let Values::Named(values) = &property.values else { return None };
        values.iter().find(|(named, _)| named == choice).map(|&(_, value)| (property.id, value))
    }

    /// The choice that the enumeration `name` is set to now.
    pub fn chosen(&self, name: &str) -> Option<&str> {
        let property = self.get(name)?;
        let Values::Named(values) = &property.values else { return None };
        values.iter().find(|(_, value)| *value == property.value).map(|(named, _)| named.as_str())
    }

    /// The number behind the bit `bit` of `name`, if it may be set.
    pub fn bit(&self, name: &str, bit: &str) -> Option<(Id, u64)> {
        let property = self.get(name).filter(|property| property.mutable)?;
        let Values::Bits(bits) = &property.values else { return None };
        bits.iter().find(|(named, _)| named == bit).map(|&(_, value)| (property.id, value))
    }
}

/// Whether a display is plugged in, as far as its connector can tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Plug {
    /// One is.
    In,
    /// The connector cannot tell: VGA, for one, or a display that does not answer.
    Unknown,
    /// None is.
    Out,
}

/// A connector of the card, with what is plugged in.
#[derive(Clone, Debug)]
pub struct Connector {
    /// Its id.
    pub id: Id,
    /// `HDMI-A-1`.
    pub name: String,
    /// Whether something is plugged in; its modes may not be known yet.
    pub plug: Plug,
    /// What the display takes, as far as it is known.
    pub modes: Vec<Mode>,
    /// Bit `n`: the CRTC of index `n` can drive it.
    pub crtcs: u32,
    /// `CRTC_ID`, `link-status` and others.
    pub properties: Properties,
}

impl Connector {
    /// Whether it may bring light: something is plugged in that takes a mode, or it cannot tell.
    pub fn may_light(&self) -> bool {
        match self.plug {
            Plug::In => !self.modes.is_empty(),
            Plug::Unknown => true,
            Plug::Out => false,
        }
    }

    /// Whether its display needs the timings of a cathode-ray tube.
    pub fn is_analogue(&self) -> bool {
        ["VGA-", "DVI-A-", "Composite-", "SVIDEO-", "Component-", "TV-"].iter().any(|kind| self.name.starts_with(kind))
    }
}

/// A scan-out engine.
#[derive(Clone, Debug)]
pub struct Crtc {
    /// Its id.
    pub id: Id,
    /// Its place among the card's CRTCs, which vblank calls and masks count by.
    pub index: u32,
    /// The mode that it drives now.
    pub mode: Option<Mode>,
    /// `ACTIVE`, `MODE_ID` and others.
    pub properties: Properties,
}

/// A layer of a CRTC.
#[derive(Clone, Debug)]
pub struct Plane {
    /// Its id.
    pub id: Id,
    /// Bit `n`: the CRTC of index `n` can show it.
    pub crtcs: u32,
    /// Which of our formats it takes in linear memory.
    pub formats: Vec<PlaneFormat>,
    /// `FB_ID`, `type` and others.
    pub properties: Properties,
}

/// A format that a plane takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlaneFormat {
    /// The format.
    pub format: Format,
    /// Whether "linear" may be said to the kernel; else it must be left unsaid.
    pub explicit: bool,
}

/// All that a card has, at one moment.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// Its driver, as the kernel names it: `i915`.
    pub driver: String,
    /// Its connectors, without writeback.
    pub connectors: Vec<Connector>,
    /// Its scan-out engines, by index.
    pub crtcs: Vec<Crtc>,
    /// Its layers.
    pub planes: Vec<Plane>,
}

/// What to allocate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferSpec {
    /// Pixels across and down, even.
    pub size: (u32, u32),
    /// The plane's format.
    pub format: PlaneFormat,
    /// How many buffers, one below the other in one framebuffer.
    pub count: u32,
}

/// What a plane shows: a framebuffer, from one of its rows on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source {
    /// The framebuffer.
    pub fb: Id,
    /// Its first row that is shown, even.
    pub top: u32,
}

impl Source {
    /// What a plane with these properties shows.
    pub fn of(plane: &Properties) -> Option<Self> {
        let top = (plane.value("SRC_Y") >> 16) as u32;
        plane.object("FB_ID").map(|fb| Self { fb, top })
    }
}

/// A scan-out buffer: memory, and what the kernel knows it by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Buffer {
    /// Where a plane finds it.
    pub source: Source,
    /// How its memory is laid out.
    pub layout: Layout,
}

/// Property values to be set together, as (object, property, value).
#[derive(Clone, Debug, Default)]
pub struct Request(pub Vec<(Id, Id, u64)>);

impl Request {
    /// Adds `name` of `object`; without effect where there is no such property, or it may not be set.
    pub fn set(&mut self, object: Id, properties: &Properties, name: &str, value: u64) {
        if let Some(property) = properties.get(name).filter(|property| property.mutable) {
            self.0.push((object, property.id, value));
        }
    }

    /// Adds the choice `choice` of the enumeration `name`; without effect where there is no such choice.
    pub fn choose(&mut self, object: Id, properties: &Properties, name: &str, choice: &str) {
        self.0.extend(properties.choice(name, choice).map(|(id, value)| (object, id, value)));
    }
}

/// The four ways in which we commit. There is no flip that may set a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum How {
    /// Changes nothing: would a [`How::Modeset`] be accepted?
    Test,
    /// Waits until it is on the glass; must not need a new mode.
    Settle,
    /// Waits until it is on the glass; may set the mode.
    Modeset,
    /// Returns at once; a [`Happening::Flip`] follows.
    Flip,
}

/// What a card tells by itself.
#[derive(Clone, Debug)]
pub enum Happening {
    /// A [`How::Flip`] is on the glass.
    Flip {
        /// Since this vblank.
        vblank: Vblank,
        /// Which began at this monotonic time.
        at: Nanos,
    },
    /// A vblank that was asked for has begun.
    Vblank {
        /// The vblank now.
        vblank: Vblank,
        /// When it began, monotonic.
        at: Nanos,
    },
    /// A cable or a card came or went: probe the connectors.
    Hotplug,
    /// A [`Kms::probe`] has ended: the connector as it is now.
    Probed(Box<Connector>),
    /// A [`Kms::probe`] has failed: the card may be gone.
    ProbeFailed(Errno),
    /// Somebody switches to another console: close the card, then [`Kms::let_console_go`].
    SwitchAway,
    /// Somebody has switched back to our console.
    SwitchBack,
}

/// The kernel's side of a screen. Errors carry the kernel's error number; `EINTR` never comes out.
pub trait Kms {
    /// The card in words: `/dev/dri/card0`.
    fn name(&self) -> String;

    /// Opens the card, if it is closed.
    ///
    /// # Errors
    /// There is no such card, or it is no KMS card.
    fn open(&mut self) -> io::Result<()>;

    /// Closes the card. The kernel then frees its framebuffers and buffers, and the glass goes dark.
    fn close(&mut self);

    /// Lets the console have the display that somebody switches to.
    fn let_console_go(&mut self);

    /// Becomes, or stays, the one process that may commit.
    ///
    /// # Errors
    /// `EBUSY` or `EACCES` while another process is.
    fn take_master(&mut self) -> io::Result<()>;

    /// Probes the connectors and reads everything. It takes as long as displays take to answer: never for a card that shows a
    /// picture.
    ///
    /// # Errors
    /// What the kernel says.
    fn survey(&mut self) -> io::Result<Survey>;

    /// Has `connector` probed by another thread. [`Happening::Probed`] follows, or [`Happening::ProbeFailed`].
    fn probe(&mut self, connector: Id);

    /// The properties of `plane` by the kernel's books.
    ///
    /// # Errors
    /// What the kernel says.
    fn plane_properties(&mut self, plane: Id) -> io::Result<Properties>;

    /// Makes a framebuffer and allocates its buffers, of whatever colour.
    ///
    /// # Errors
    /// What the kernel says; nothing is left behind.
    fn create(&mut self, spec: BufferSpec) -> io::Result<Vec<Buffer>>;

    /// Frees a framebuffer with its buffers. It must not be bound to a plane.
    fn destroy(&mut self, fb: Id);

    /// Lets `paint` write the memory behind the framebuffer of `source`: all of it, of which only what the layout of
    /// that buffer covers may be changed.
    ///
    /// # Errors
    /// It cannot be mapped.
    fn write(&mut self, source: Source, paint: &mut dyn FnMut(&mut [u8])) -> io::Result<()>;

    /// Makes a blob of `mode`, to set it by.
    ///
    /// # Errors
    /// What the kernel says.
    fn create_mode(&mut self, mode: &Mode) -> io::Result<Id>;

    /// Makes a blob of `bytes`, for a property that takes one.
    ///
    /// # Errors
    /// What the kernel says.
    fn create_blob(&mut self, bytes: &[u8]) -> io::Result<Id>;

    /// Finds the backlight of the display at `connector`, in the place of one found before. `false` if there is none that
    /// may be set.
    fn find_backlight(&mut self, connector: &str) -> bool;

    /// Sets the backlight that was found to so many thousandths of its power; returns at once.
    fn set_backlight(&mut self, thousandths: u16);

    /// Frees a blob. What was set by it stays set.
    fn destroy_blob(&mut self, blob: Id);

    /// Sets all of `request`, or nothing.
    ///
    /// # Errors
    /// What the kernel says.
    fn commit(&mut self, how: How, request: &Request) -> io::Result<()>;

    /// The present vblank of the CRTC of index `crtc`, and when it began.
    ///
    /// # Errors
    /// The CRTC is off, or has no vblanks.
    fn vblank(&mut self, crtc: u32) -> io::Result<(Vblank, Nanos)>;

    /// Asks for a [`Happening::Vblank`] at `vblank`, or at once if that is past.
    ///
    /// # Errors
    /// The CRTC is off, or has no vblanks.
    fn ask_vblank(&mut self, crtc: u32, vblank: Vblank) -> io::Result<()>;

    /// Waits for the next happening, at most `timeout`; may end early without one.
    ///
    /// # Errors
    /// The card is gone.
    fn wait(&mut self, timeout: Duration) -> io::Result<Option<Happening>>;
}
