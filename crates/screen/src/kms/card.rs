//! The resources of a KMS card, as plain data, and the interface to the card.
//!
//! Owns the [`Kms`] trait and its types. Decisions are made in `choose.rs` and `recovery_policy.rs`. Implementations:
//! `device.rs` (the kernel) and `scripted/` (tests).

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

    /// The number of `choice` in the enumeration `name`, if the property can be set to it.
    pub fn choice(&self, name: &str, choice: &str) -> Option<(Id, u64)> {
        let property = self.get(name).filter(|property| property.mutable)?;
        let Values::Named(values) = &property.values else { return None };
        values.iter().find(|(named, _)| named == choice).map(|&(_, value)| (property.id, value))
    }

    /// The present choice of the enumeration `name`.
    pub fn chosen(&self, name: &str) -> Option<&str> {
        let property = self.get(name)?;
        let Values::Named(values) = &property.values else { return None };
        values.iter().find(|(_, value)| *value == property.value).map(|(named, _)| named.as_str())
    }

    /// The value of the bit `bit` of `name`, if it can be set.
    pub fn bit(&self, name: &str, bit: &str) -> Option<(Id, u64)> {
        let property = self.get(name).filter(|property| property.mutable)?;
        let Values::Bits(bits) = &property.values else { return None };
        bits.iter().find(|(named, _)| named == bit).map(|&(_, value)| (property.id, value))
    }
}

/// The connection status of a connector.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ConnectorStatus {
    /// One is.
    In,
    /// Unknown: on VGA, for example, or if the display does not answer.
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
    /// Whether a display is connected; its modes may not be known yet.
    pub plug: ConnectorStatus,
    /// The known modes of the display.
    pub modes: Vec<Mode>,
    /// Bit `n`: the CRTC of index `n` can drive it.
    pub crtcs: u32,
    /// `CRTC_ID`, `link-status` and others.
    pub properties: Properties,
}

impl Connector {
    /// Whether it may have a display: one with modes is connected, or the status is unknown.
    pub fn may_light(&self) -> bool {
        match self.plug {
            ConnectorStatus::In => !self.modes.is_empty(),
            ConnectorStatus::Unknown => true,
            ConnectorStatus::Out => false,
        }
    }

    /// Whether its display needs analogue timings.
    pub fn is_analogue(&self) -> bool {
        ["VGA-", "DVI-A-", "Composite-", "SVIDEO-", "Component-", "TV-"].iter().any(|kind| self.name.starts_with(kind))
    }
}

/// A scan-out engine.
#[derive(Clone, Debug)]
pub struct Crtc {
    /// Its id.
    pub id: Id,
    /// Its index among the card's CRTCs, used by vblank calls and masks.
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
    /// Which of our formats it scans out from linear memory.
    pub formats: Vec<PlaneFormat>,
    /// `FB_ID`, `type` and others.
    pub properties: Properties,
}

/// A format that a plane takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlaneFormat {
    /// The format.
    pub format: Format,
    /// Whether the linear modifier may be given to the kernel.
    pub explicit: bool,
}

/// The resources of a card at one moment.
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
    /// How many buffers lie below each other in one framebuffer.
    pub count: u32,
}

/// The source of a plane: a framebuffer, from a certain row on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source {
    /// The framebuffer.
    pub fb: Id,
    /// Its first row that is shown, even.
    pub top: u32,
}

impl Source {
    /// The source of a plane with these properties.
    pub fn of(plane: &Properties) -> Option<Self> {
        let top = (plane.value("SRC_Y") >> 16) as u32;
        plane.object("FB_ID").map(|fb| Self { fb, top })
    }
}

/// A scan-out buffer: its framebuffer and memory layout.
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

/// The kinds of commits. A flip never sets a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommitMode {
    /// Changes nothing: tests whether a [`CommitMode::Modeset`] would be accepted.
    Test,
    /// Blocks until it is on the screen; must not need a new mode.
    Settle,
    /// Blocks until it is on the screen; may set the mode.
    Modeset,
    /// Returns at once; a [`KmsEvent::Flip`] follows.
    Flip,
}

/// The events of a card.
#[derive(Clone, Debug)]
pub enum KmsEvent {
    /// A [`CommitMode::Flip`] is on the screen.
    Flip {
        /// Since this vblank.
        vblank: Vblank,
        /// The start of that vblank, on the monotonic clock.
        at: Nanos,
    },
    /// A vblank that was asked for has begun.
    Vblank {
        /// The vblank now.
        vblank: Vblank,
        /// When it began, monotonic.
        at: Nanos,
    },
    /// A hot-plug event of a connector or card: probe the connectors.
    Hotplug,
    /// A [`Kms::probe`] has ended: the connector as it is now.
    Probed(Box<Connector>),
    /// A [`Kms::probe`] has failed: the card may be gone.
    ProbeFailed(Errno),
    /// A switch to another console was requested: close the card, then call [`Kms::release_console`].
    SwitchAway,
    /// Our console is active again.
    SwitchBack,
}

/// The calls of a KMS card. Errors carry the kernel's error number; `EINTR` is retried.
pub trait Kms {
    /// The card's name: `/dev/dri/card0`.
    fn name(&self) -> String;

    /// Opens the card, if it is closed.
    /// Errors: There is no such card, or it is no KMS card.
    fn open(&mut self) -> io::Result<()>;

    /// Closes the card. The kernel then frees its framebuffers and buffers, and the screen goes dark.
    fn close(&mut self);

    /// Allows the requested console switch.
    fn release_console(&mut self);

    /// Becomes, or stays, DRM master: the process that may commit.
    /// Errors: `EBUSY` or `EACCES` while another process is.
    fn take_master(&mut self) -> io::Result<()>;

    /// Probes the connectors and reads everything. Displays may answer slowly: not to be used while the card shows a
    /// picture.
    fn survey(&mut self) -> io::Result<Survey>;

    /// Probes `connector` on another thread. [`KmsEvent::Probed`] follows, or [`KmsEvent::ProbeFailed`].
    fn probe(&mut self, connector: Id);

    /// The present properties of `plane`.
    fn plane_properties(&mut self, plane: Id) -> io::Result<Properties>;

    /// Creates a framebuffer and allocates its buffers, with undefined contents.
    /// Errors: The kernel's error; everything is freed.
    fn create(&mut self, spec: BufferSpec) -> io::Result<Vec<Buffer>>;

    /// Frees a framebuffer with its buffers. It must not be bound to a plane.
    fn destroy(&mut self, fb: Id);

    /// Calls `paint` with the whole memory of the framebuffer of `source`; only the part in that buffer's layout may be
    /// changed.
    /// Errors: It cannot be mapped.
    fn write(&mut self, source: Source, paint: &mut dyn FnMut(&mut [u8])) -> io::Result<()>;

    /// Creates a blob of `mode`.
    fn create_mode(&mut self, mode: &Mode) -> io::Result<Id>;

    /// Creates a blob of `bytes` for a property.
    fn create_blob(&mut self, bytes: &[u8]) -> io::Result<Id>;

    /// Finds the backlight of the display at `connector`, replacing one found before. `false` if there is none that may
    /// be written.
    fn find_backlight(&mut self, connector: &str) -> bool;

    /// Sets the backlight to this many thousandths of its maximum; returns at once.
    fn set_backlight(&mut self, thousandths: u16);

    /// Frees a blob. Settings made with it stay.
    fn destroy_blob(&mut self, blob: Id);

    /// Sets all of `request`, or nothing.
    fn commit(&mut self, how: CommitMode, request: &Request) -> io::Result<()>;

    /// The present vblank of the CRTC of index `crtc`, and when it began.
    /// Errors: The CRTC is off, or has no vblanks.
    fn vblank(&mut self, crtc: u32) -> io::Result<(Vblank, Nanos)>;

    /// Asks for a [`KmsEvent::Vblank`] at `vblank`, or at once if that is past.
    /// Errors: The CRTC is off, or has no vblanks.
    fn request_vblank(&mut self, crtc: u32, vblank: Vblank) -> io::Result<()>;

    /// Waits for the next event, at most `timeout`; may return early without one.
    /// Errors: The card is gone.
    fn wait(&mut self, timeout: Duration) -> io::Result<Option<KmsEvent>>;
}
