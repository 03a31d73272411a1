//! A KMS card in memory, on a hand-driven clock, of any family of drivers, that fails where a test says.
//!
//! Owns a model of what the kernel keeps: property values, framebuffers, the flip in flight. Panics where we would
//! harm a real display: a framebuffer removed or what it shows written while it may be on the screen, two commits in
//! flight, a busy wait, a value that a property does not take. Its wiring: one connector, one CRTC, a primary plane, and an
//! overlay that a dead process has left behind. What its family refuses is in `check.rs`; the families are in `families/`.
//!
//! Start at [`Scripted::of`] and [`Scripted::fail`]; the tests are in `fault_matrix.rs`, `night.rs`, `each_family.rs` and
//! `choices.rs`.

mod calls;
mod check;
mod choices;
mod each_family;
pub(crate) mod families;
pub(crate) mod family;
pub(super) mod fault_matrix;
mod night;

use super::card::{Connector, ConnectorStatus, Id, KmsEvent, Request, Source};
use super::modes::refresh;
use crate::paint::Layout;
use drm::control::{Mode, ModeFlags};
use families::generic::GENERIC;
use family::{Family, mode};
use rustix::io::Errno;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::io;
use timing::{Nanos, Vblank};

thread_local!(static CLOCK: Cell<u64> = const { Cell::new(0) });

/// The hand-driven clock of this thread.
pub(crate) fn now() -> Nanos {
    Nanos(CLOCK.get())
}

/// Advances the clock by `ns` in which the player does not run.
pub(crate) fn oversleep(ns: u64) {
    CLOCK.set(CLOCK.get() + ns);
}

pub(crate) const MS: u64 = 1_000_000;
/// How long a display takes to answer a probe.
const PROBE_NS: u64 = 40 * MS;
const CONNECTOR: Id = Id(30);
const CRTC: Id = Id(40);
const PRIMARY: Id = Id(50);
const OVERLAY: Id = Id(51);
/// The overlay's picture, which belongs to a process that is no more.
const FOREIGN_FB: u64 = 7;

/// The kinds of commits that the recovery policy distinguishes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    Test,
    Light,
    Flip,
    Darken,
}

/// The kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    /// The commit is refused.
    Refused(Errno),
    /// The commit is taken, but the next flip never happens.
    LostFlip,
    /// The commit is taken, and the next flip happens, but its event never comes.
    LostEvent,
    /// The same, but its event comes 150 ms later.
    LateEvent,
}

/// What this card is like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quirk {
    /// The plane does not keep what it is told about colours.
    ForgetsColours,
    /// It cannot tell its vblank before the first flip.
    LateVblanks,
    /// It takes no framebuffer that is higher than the mode.
    NoTallFramebuffers,
    /// It shows a framebuffer from its first row on, or not at all.
    NoWindow,
    /// It takes no ramp with a flip.
    StiffRamp,
    /// It moves the window within a framebuffer only where a mode may be set.
    StiffWindow,
    /// Its display has a backlight.
    Backlight,
}

/// A fault to come: at the `nth` commit of `kind`, and then for `ns`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fault {
    pub(crate) kind: Kind,
    pub(crate) nth: u32,
    pub(crate) effect: Effect,
    pub(crate) ns: u64,
}

/// A flip that the card has taken.
struct Pending {
    source: Source,
    vblank: u64,
    effect: Option<Effect>,
}

/// The card.
pub(crate) struct Scripted {
    pub(crate) family: &'static Family,
    /// When the card is taken away, and which one takes its place.
    pub(crate) handover: Option<(Nanos, &'static Family)>,
    /// It was taken away while it was open.
    is_gone: bool,
    fault: Option<Fault>,
    /// When the fault was injected, and until when it lasts.
    pub(crate) injected_at: Option<(Nanos, Nanos)>,
    commits: BTreeMap<Kind, u32>,
    lost_flip: Option<Effect>,
    /// When the display is plugged in (true) or out.
    pub(crate) plugs: VecDeque<(Nanos, bool)>,
    pub(crate) plug: ConnectorStatus,
    pub(crate) modes: Vec<Mode>,
    /// When the display tells of other modes.
    pub(crate) late_modes: Option<(Nanos, Vec<Mode>)>,
    pub(crate) quirk: Option<Quirk>,
    open: bool,
    values: BTreeMap<(Id, &'static str), u64>,
    pub(crate) fbs: BTreeMap<Id, Vec<u8>>,
    /// How every framebuffer that ever was is laid out.
    layouts: BTreeMap<Id, Layout>,
    pub(crate) blobs: BTreeSet<Id>,
    /// Every mode that ever was, by its blob.
    made: BTreeMap<u64, Mode>,
    /// What every blob held that ever was.
    blob_bytes: BTreeMap<u64, Vec<u8>>,
    next_id: u32,
    /// What is scanned out.
    pub(crate) on_screen: Option<Source>,
    pending: Option<Pending>,
    asked: Vec<u64>,
    happenings: VecDeque<KmsEvent>,
    late: VecDeque<(Nanos, KmsEvent)>,
    spins: u32,
    /// Every lasting mode set.
    pub(crate) modesets: u32,
    /// How bright the backlight is, in thousandths.
    pub(crate) backlight: u16,
    /// When somebody switches away from the console (false) and back.
    pub(crate) switches: VecDeque<(Nanos, bool)>,
    pub(crate) has_released_console: bool,
    /// When the probe that is asked for ends.
    probed_at: Option<Nanos>,
}

impl Scripted {
    /// A card with nearly all features, and a display with 64x48 at 60 Hz; the clock starts at one second.
    pub(crate) fn new() -> Self {
        Self::of(&GENERIC)
    }

    /// The same of this family, as other processes have left it.
    pub(crate) fn of(family: &'static Family) -> Self {
        CLOCK.set(1000 * MS);
        let mut card = Self {
            family,
            handover: None,
            is_gone: false,
            fault: None,
            injected_at: None,
            commits: BTreeMap::new(),
            lost_flip: None,
            plugs: VecDeque::new(),
            plug: ConnectorStatus::In,
            modes: vec![mode((64, 48, 250, 80, 52, ModeFlags::empty(), true))],
            late_modes: None,
            quirk: None,
            open: false,
            values: BTreeMap::new(),
            fbs: BTreeMap::new(),
            layouts: BTreeMap::new(),
            blobs: BTreeSet::new(),
            made: BTreeMap::new(),
            blob_bytes: BTreeMap::new(),
            next_id: 1000,
            on_screen: None,
            pending: None,
            asked: Vec::new(),
            happenings: VecDeque::new(),
            late: VecDeque::new(),
            spins: 0,
            modesets: 0,
            backlight: 0,
            switches: VecDeque::new(),
            has_released_console: false,
            probed_at: None,
        };
        card.set_left();
        card
    }

    /// Everything is as other processes have left it.
    fn set_left(&mut self) {
        self.values.clear();
        for (kind, object) in Self::objects() {
            let rows = self.family.all().filter(|row| row.kinds.contains(kind));
            self.values.extend(rows.map(|row| ((object, row.name), row.left)));
        }
        if self.family.has_overlay {
            self.values.extend([((OVERLAY, "FB_ID"), FOREIGN_FB), ((OVERLAY, "CRTC_ID"), u64::from(CRTC.0))]);
        }
    }

    pub(crate) fn fail(mut self, fault: Fault) -> Self {
        self.fault = Some(fault);
        self
    }

    pub(crate) fn value(&self, plane: Id, name: &'static str) -> u64 {
        self.values.get(&(plane, name)).copied().unwrap_or(0)
    }

    /// What the CRTC makes of the brightest sample: by its ramp, and by the first number of its matrix.
    pub(crate) fn brightest(&self) -> u16 {
        let ramp = self.ramp(self.value(CRTC, "GAMMA_LUT")).and_then(|ramp| ramp.last().copied()).unwrap_or(u16::MAX);
        let matrix = self.blob_bytes.get(&self.value(CRTC, "CTM"));
        let factor = matrix.map_or(1 << 32, |bytes| u64::from_ne_bytes(bytes[..8].try_into().expect("eight bytes")));
        ((u64::from(ramp) * factor) >> 32) as u16
    }

    /// The red of the ramp in `blob`.
    fn ramp(&self, blob: u64) -> Option<Vec<u16>> {
        let red = |entry: &[u8]| u16::from_ne_bytes([entry[0], entry[1]]);
        self.blob_bytes.get(&blob).map(|bytes| bytes.chunks(8).map(red).collect())
    }

    /// The objects, by the letters of their kinds.
    pub(crate) fn objects() -> [(char, Id); 4] {
        [('n', CONNECTOR), ('c', CRTC), ('p', PRIMARY), ('o', OVERLAY)]
    }

    /// The sample of luma, or of blue, at this pixel of the buffer that is scanned out.
    pub(crate) fn sample(&self, (x, y): (u32, u32)) -> u8 {
        let source = self.on_screen.expect("something is lit");
        let layout = &self.layouts[&source.fb];
        let bytes = layout.format.allocation((1, 1)).2 / 8;
        self.fbs[&source.fb][((source.top + y) * layout.pitches[0] + x * bytes) as usize]
    }

    /// Whether the CRTC drives the display.
    pub(crate) fn is_on(&self) -> bool {
        self.value(CRTC, "ACTIVE") == 1
    }

    /// The ids of the two planes: the primary, and the overlay left behind.
    pub(crate) fn planes() -> (Id, Id) {
        (PRIMARY, OVERLAY)
    }

    /// The mode that is set.
    pub(crate) fn mode(&self) -> Option<Mode> {
        self.made.get(&self.value(CRTC, "MODE_ID")).copied().filter(|_| self.is_on())
    }

    fn period(&self) -> u64 {
        self.mode().as_ref().or(self.modes.first()).and_then(refresh).map_or(20 * MS, |rate| rate.span_ns(1))
    }

    fn begins(&self, vblank: u64) -> Nanos {
        Nanos(vblank * self.period())
    }

    fn current(&self) -> u64 {
        now().0 / self.period()
    }

    fn id(&mut self) -> Id {
        self.next_id += 1;
        Id(self.next_id)
    }

    /// Fails while the card is closed, gone, or another's.
    fn usable(&self, commit: bool) -> io::Result<()> {
        let lasting = self.injected_at.filter(|(_, until)| *until > now()).and(self.fault).map(|fault| fault.effect);
        match lasting {
            _ if self.is_gone => Err(Errno::NODEV.into()),
            _ if !self.open => Err(Errno::BADF.into()),
            Some(Effect::Refused(Errno::NODEV)) => Err(Errno::NODEV.into()),
            Some(Effect::Refused(Errno::ACCESS)) if commit => Err(Errno::ACCESS.into()),
            _ => Ok(()),
        }
    }

    /// Injects the fault if this commit is the one; rejects commits while it lasts.
    fn inject(&mut self, kind: Kind) -> io::Result<()> {
        let seen = self.commits.entry(kind).or_default();
        *seen += 1;
        let Some(fault) = self.fault.filter(|fault| fault.kind == kind) else { return Ok(()) };
        let first = self.injected_at.is_none() && *seen == fault.nth + 1;
        if first {
            self.injected_at = Some((now(), now().after(fault.ns)));
        }
        let lasts = self.injected_at.is_some_and(|(_, until)| until > now());
        match fault.effect {
            Effect::Refused(errno) if first || lasts => Err(errno.into()),
            Effect::LostFlip | Effect::LostEvent | Effect::LateEvent if first || lasts => {
                self.lost_flip = Some(fault.effect);
                Ok(())
            }
            Effect::Refused(_) | Effect::LostFlip | Effect::LostEvent | Effect::LateEvent => Ok(()),
        }
    }

    fn apply(&mut self, request: &Request) {
        for &(object, property, value) in &request.0 {
            let name = self.family.row(property).name;
            if self.quirk != Some(Quirk::ForgetsColours) || !name.starts_with("COLOR_") {
                self.values.insert((object, name), value);
            }
        }
    }

    /// Delivers what is due by now.
    fn pass(&mut self) {
        let (time, current) = (now(), self.current());
        while self.plugs.front().is_some_and(|(at, _)| *at <= time) {
            let is_in = self.plugs.pop_front().is_some_and(|(_, plugged)| plugged);
            self.plug = if is_in { ConnectorStatus::In } else { ConnectorStatus::Out };
            self.happenings.push_back(KmsEvent::Hotplug);
        }
        while self.switches.front().is_some_and(|(at, _)| *at <= time) {
            let is_back = self.switches.pop_front().is_some_and(|(_, is_back)| is_back);
            self.has_released_console &= !is_back;
            self.happenings.push_back(if is_back { KmsEvent::SwitchBack } else { KmsEvent::SwitchAway });
        }
        if let Some((_, modes)) = self.late_modes.take_if(|(at, _)| *at <= time) {
            self.modes = modes;
            self.happenings.push_back(KmsEvent::Hotplug);
        }
        if let Some((_, family)) = self.handover.take_if(|(at, _)| *at <= time) {
            // Both tell: the one that goes and the one that comes.
            self.family = family;
            (self.is_gone, self.on_screen, self.pending) = (self.open, None, None);
            self.happenings.extend([KmsEvent::Hotplug, KmsEvent::Hotplug]);
        }
        if let Some(flip) = self.pending.take_if(|flip| flip.vblank <= current && flip.effect != Some(Effect::LostFlip))
        {
            self.on_screen = Some(flip.source);
            let event = KmsEvent::Flip { vblank: Vblank(flip.vblank as u32), at: self.begins(flip.vblank) };
            match flip.effect {
                None => self.happenings.push_back(event),
                Some(Effect::LateEvent) => self.late.push_back((time.after(150 * MS), event)),
                Some(Effect::LostFlip | Effect::LostEvent | Effect::Refused(_)) => {}
            }
        }
        while self.late.front().is_some_and(|(at, _)| *at <= time) {
            self.happenings.extend(self.late.pop_front().map(|(_, event)| event));
        }
        if self.probed_at.take_if(|at| *at <= time).is_some() {
            self.happenings.push_back(KmsEvent::Probed(Box::new(self.connector())));
        }
        let (due, later) = self.asked.iter().partition::<Vec<_>, _>(|asked| **asked <= current);
        self.asked = later;
        let event = KmsEvent::Vblank { vblank: Vblank(current as u32), at: self.begins(current) };
        self.happenings.extend(due.iter().map(|_| event.clone()));
    }

    fn connector(&self) -> Connector {
        Connector {
            id: CONNECTOR,
            name: self.family.connector.to_owned(),
            plug: self.plug,
            modes: if self.plug == ConnectorStatus::Out { Vec::new() } else { self.modes.clone() },
            crtcs: 1,
            properties: self.family.properties('n', |name| self.value(CONNECTOR, name)),
        }
    }

    fn next_due(&self) -> Option<Nanos> {
        let flip = self.pending.iter().filter(|flip| flip.effect != Some(Effect::LostFlip)).map(|flip| flip.vblank);
        let vblanks = flip.chain(self.asked.iter().copied()).map(|vblank| self.begins(vblank));
        let told = self.plugs.front().map(|(at, _)| *at).into_iter().chain(self.late.front().map(|(at, _)| *at));
        let late = self.late_modes.as_ref().map(|(at, _)| *at).into_iter().chain(self.handover.map(|(at, _)| at));
        let switched = self.switches.front().map(|(at, _)| *at);
        vblanks.chain(told).chain(late).chain(switched).chain(self.probed_at).min()
    }
}

/// The row that a value of `SRC_Y` means.
fn top_of(value: u64) -> u32 {
    (value >> 16) as u32
}
