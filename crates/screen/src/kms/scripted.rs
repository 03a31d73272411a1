//! A KMS card in memory, on a hand-driven clock, that fails where a test says.
//!
//! Owns a model of what the kernel keeps: property values, framebuffers, the flip in flight. Panics where we would
//! harm a real display: a framebuffer removed or what it shows written while it may be on the glass, two commits in
//! flight, a busy wait. Its wiring: one connector, one CRTC, a primary plane, and an overlay that a dead process has left
//! behind; `specimen.rs` makes them.
//!
//! Start at [`Scripted::fail`]; the tests are in `fault_matrix.rs`.

use super::card::{Buffer, BufferSpec, Connector, Crtc, Happening, How, Id, Kms, Request, Source, Survey};
use super::choose::refresh;
use super::specimen::{SCHEMA, mode, plane, properties};
use crate::paint::Layout;
use drm::control::{Mode, ModeFlags};
use rustix::io::Errno;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::io;
use std::time::Duration;
use timing::{Nanos, Vblank};

thread_local!(static CLOCK: Cell<u64> = const { Cell::new(0) });

/// The hand-driven clock of this thread.
pub(crate) fn now() -> Nanos {
    Nanos(CLOCK.get())
}

/// Lets `ns` pass in which the player did not run.
pub(crate) fn oversleep(ns: u64) {
    CLOCK.set(CLOCK.get() + ns);
}

pub(crate) const MS: u64 = 1_000_000;
const CONNECTOR: Id = Id(30);
const CRTC: Id = Id(40);
const PRIMARY: Id = Id(50);
const OVERLAY: Id = Id(51);
/// The overlay's picture, which belongs to a process that is no more.
const FOREIGN_FB: u64 = 7;

/// A kind of commit, as the ladder tells them apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    Test,
    Light,
    Flip,
    Darken,
}

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ill {
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
    /// It has no vblanks, and flips at once.
    NoVblanks,
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
    /// There is a lamp behind its display.
    Lamp,
}

/// A fault to come: at the `nth` commit of `kind`, and then for `ns`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fault {
    pub(crate) kind: Kind,
    pub(crate) nth: u32,
    pub(crate) ill: Ill,
    pub(crate) ns: u64,
}

/// A flip that the card has taken.
struct Pending {
    source: Source,
    vblank: u64,
    ill: Option<Ill>,
}

/// The card.
pub(crate) struct Scripted {
    fault: Option<Fault>,
    /// When the fault struck, and until when it lasts.
    pub(crate) struck: Option<(Nanos, Nanos)>,
    commits: BTreeMap<Kind, u32>,
    ill_flip: Option<Ill>,
    /// When the display is plugged in (true) or out.
    pub(crate) plugs: VecDeque<(Nanos, bool)>,
    connected: bool,
    pub(crate) modes: Vec<Mode>,
    pub(crate) quirk: Option<Quirk>,
    open: bool,
    values: BTreeMap<(Id, &'static str), u64>,
    pub(crate) fbs: BTreeMap<Id, Vec<u8>>,
    pub(crate) blobs: BTreeSet<Id>,
    /// Every mode that ever was, by its blob.
    made: BTreeMap<u64, Mode>,
    /// The red of every ramp that ever was, by its blob.
    ramps: BTreeMap<u64, Vec<u16>>,
    next_id: u32,
    /// What is scanned out.
    pub(crate) glass: Option<Source>,
    pending: Option<Pending>,
    asked: Vec<u64>,
    happenings: VecDeque<Happening>,
    late: VecDeque<(Nanos, Happening)>,
    spins: u32,
    /// Every lasting mode set.
    pub(crate) modesets: u32,
    /// With so many thousandths the lamp shines.
    pub(crate) lamp: u16,
}

impl Scripted {
    /// A card with a display that takes 64x48 at 60 Hz; the clock starts at one second.
    pub(crate) fn new() -> Self {
        CLOCK.set(1000 * MS);
        let mut card = Self {
            fault: None,
            struck: None,
            commits: BTreeMap::new(),
            ill_flip: None,
            plugs: VecDeque::new(),
            connected: true,
            modes: vec![mode((64, 48, 250, 80, 52, ModeFlags::empty(), true))],
            quirk: None,
            open: false,
            values: BTreeMap::new(),
            fbs: BTreeMap::new(),
            blobs: BTreeSet::new(),
            made: BTreeMap::new(),
            ramps: BTreeMap::new(),
            next_id: 1000,
            glass: None,
            pending: None,
            asked: Vec::new(),
            happenings: VecDeque::new(),
            late: VecDeque::new(),
            spins: 0,
            modesets: 0,
            lamp: 0,
        };
        for (name, value) in [("FB_ID", FOREIGN_FB), ("CRTC_ID", u64::from(CRTC.0))] {
            card.values.insert((OVERLAY, name), value);
        }
        card.values.insert((CRTC, "GAMMA_LUT_SIZE"), 256);
        card.values.insert((PRIMARY, "rotation"), 4);
        card.values.insert((PRIMARY, "COLOR_RANGE"), 1);
        card
    }

    pub(crate) fn fail(mut self, fault: Fault) -> Self {
        self.fault = Some(fault);
        self
    }

    pub(crate) fn value(&self, plane: Id, name: &'static str) -> u64 {
        self.values.get(&(plane, name)).copied().unwrap_or(0)
    }

    /// What the CRTC makes of the brightest sample.
    pub(crate) fn brightest(&self) -> u16 {
        let ramp = self.ramps.get(&self.value(CRTC, "GAMMA_LUT"));
        ramp.and_then(|ramp| ramp.last().copied()).unwrap_or(u16::MAX)
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
        let lasting = self.struck.filter(|(_, until)| *until > now()).and(self.fault).map(|fault| fault.ill);
        match lasting {
            _ if !self.open => Err(Errno::BADF.into()),
            Some(Ill::Refused(Errno::NODEV)) => Err(Errno::NODEV.into()),
            Some(Ill::Refused(Errno::ACCESS)) if commit => Err(Errno::ACCESS.into()),
            _ => Ok(()),
        }
    }

    /// Strikes if this commit is the one; refuses while the fault lasts.
    fn strike(&mut self, kind: Kind) -> io::Result<()> {
        let seen = self.commits.entry(kind).or_default();
        *seen += 1;
        let Some(fault) = self.fault.filter(|fault| fault.kind == kind) else { return Ok(()) };
        let first = self.struck.is_none() && *seen == fault.nth + 1;
        if first {
            self.struck = Some((now(), now().after(fault.ns)));
        }
        let lasts = self.struck.is_some_and(|(_, until)| until > now());
        match fault.ill {
            Ill::Refused(errno) if first || lasts => Err(errno.into()),
            Ill::LostFlip | Ill::LostEvent | Ill::LateEvent if first || lasts => {
                self.ill_flip = Some(fault.ill);
                Ok(())
            }
            Ill::Refused(_) | Ill::LostFlip | Ill::LostEvent | Ill::LateEvent => Ok(()),
        }
    }

    fn apply(&mut self, request: &Request) {
        for &(object, property, value) in &request.0 {
            let name = SCHEMA[property.0 as usize - 100].1;
            if self.quirk != Some(Quirk::ForgetsColours) || !name.starts_with("COLOR_") {
                self.values.insert((object, name), value);
            }
        }
    }

    /// Delivers what is due by now.
    fn pass(&mut self) {
        let (time, current) = (now(), self.current());
        while self.plugs.front().is_some_and(|(at, _)| *at <= time) {
            self.connected = self.plugs.pop_front().is_some_and(|(_, plugged)| plugged);
            self.happenings.push_back(Happening::Hotplug);
        }
        if let Some(flip) = self.pending.take_if(|flip| flip.vblank <= current && flip.ill != Some(Ill::LostFlip)) {
            self.glass = Some(flip.source);
            let event = Happening::Flip { vblank: Vblank(flip.vblank as u32), at: self.begins(flip.vblank) };
            match flip.ill {
                None => self.happenings.push_back(event),
                Some(Ill::LateEvent) => self.late.push_back((time.after(150 * MS), event)),
                Some(Ill::LostFlip | Ill::LostEvent | Ill::Refused(_)) => {}
            }
        }
        while self.late.front().is_some_and(|(at, _)| *at <= time) {
            self.happenings.extend(self.late.pop_front().map(|(_, event)| event));
        }
        let (due, later) = self.asked.iter().partition::<Vec<_>, _>(|asked| **asked <= current);
        self.asked = later;
        let event = Happening::Vblank { vblank: Vblank(current as u32), at: self.begins(current) };
        self.happenings.extend(due.iter().map(|_| event));
    }

    fn next_due(&self) -> Option<Nanos> {
        let flip = self.pending.iter().filter(|flip| flip.ill != Some(Ill::LostFlip)).map(|flip| flip.vblank);
        let vblanks = flip.chain(self.asked.iter().copied()).map(|vblank| self.begins(vblank));
        let told = self.plugs.front().map(|(at, _)| *at).into_iter().chain(self.late.front().map(|(at, _)| *at));
        vblanks.chain(told).min()
    }
}

impl Kms for Scripted {
    fn name(&self) -> String {
        "/dev/dri/scripted".to_owned()
    }

    fn open(&mut self) -> io::Result<()> {
        let was = std::mem::replace(&mut self.open, true);
        self.usable(false).inspect_err(|_| self.open = was)
    }

    fn close(&mut self) {
        self.open = false;
        self.fbs.clear();
        self.blobs.clear();
        self.glass = None;
        self.pending = None;
        self.asked.clear();
        self.late.clear();
        self.happenings.clear();
        self.values.insert((CRTC, "ACTIVE"), 0);
        self.values.insert((PRIMARY, "FB_ID"), 0);
    }

    fn take_master(&mut self) -> io::Result<()> {
        self.usable(true)
    }

    fn survey(&mut self) -> io::Result<Survey> {
        self.usable(false)?;
        let connector = Connector {
            id: CONNECTOR,
            name: "HDMI-A-1".to_owned(),
            connected: self.connected,
            modes: if self.connected { self.modes.clone() } else { Vec::new() },
            crtcs: 1,
            properties: properties('n', |name| self.value(CONNECTOR, name)),
        };
        let mode = self.mode();
        let properties_of = |kind, id| properties(kind, |name| self.value(id, name));
        let crtc = Crtc { id: CRTC, index: 0, mode, properties: properties_of('c', CRTC) };
        let planes = [(PRIMARY, 'p'), (OVERLAY, 'o')].map(|(id, kind)| plane(id, properties_of(kind, id)));
        Ok(Survey { connectors: vec![connector], crtcs: vec![crtc], planes: planes.into() })
    }

    fn create(&mut self, spec: BufferSpec) -> io::Result<Vec<Buffer>> {
        self.usable(false)?;
        if self.quirk == Some(Quirk::NoTallFramebuffers) && spec.count > 1 {
            return Err(Errno::INVAL.into());
        }
        let (format, size) = (spec.format.format, (spec.size.0, spec.size.1 * spec.count));
        let layout = Layout::new(format, size, format.allocation(size).2 / 8 * size.0);
        let fb = self.id();
        self.fbs.insert(fb, vec![0; layout.bytes()]);
        let tops = (0..spec.count).map(|nth| nth * spec.size.1);
        Ok(tops.map(|top| Buffer { source: Source { fb, top }, layout: layout.part(top, spec.size.1) }).collect())
    }

    fn destroy(&mut self, fb: Id) {
        assert!(self.glass.is_none_or(|source| source.fb != fb), "a framebuffer on the glass was removed");
        assert_ne!(self.value(PRIMARY, "FB_ID"), u64::from(fb.0), "a bound framebuffer was removed");
        assert!(self.fbs.remove(&fb).is_some(), "a framebuffer was removed twice");
    }

    fn write(&mut self, source: Source, paint: &mut dyn FnMut(&mut [u8])) -> io::Result<()> {
        self.pass();
        assert_ne!(self.glass, Some(source), "what is on the glass was written");
        assert!(self.pending.as_ref().is_none_or(|flip| flip.source != source), "what is committed was written");
        paint(self.fbs.get_mut(&source.fb).expect("a framebuffer that is no more was written"));
        Ok(())
    }

    fn create_mode(&mut self, mode: &Mode) -> io::Result<Id> {
        self.usable(false)?;
        let blob = self.id();
        self.blobs.insert(blob);
        self.made.insert(u64::from(blob.0), *mode);
        Ok(blob)
    }

    fn create_ramp(&mut self, ramp: &[[u16; 4]]) -> io::Result<Id> {
        self.usable(false)?;
        let blob = self.id();
        self.blobs.insert(blob);
        self.ramps.insert(u64::from(blob.0), ramp.iter().map(|entry| entry[0]).collect());
        Ok(blob)
    }

    fn find_lamp(&mut self, _: &str) -> bool {
        self.quirk == Some(Quirk::Lamp)
    }

    fn shine(&mut self, thousandths: u16) {
        assert_eq!(self.quirk, Some(Quirk::Lamp), "a lamp that is not there was set");
        self.lamp = thousandths;
    }

    fn destroy_blob(&mut self, blob: Id) {
        assert!(self.blobs.remove(&blob), "a blob was removed twice");
    }

    fn commit(&mut self, how: How, request: &Request) -> io::Result<()> {
        let wanted = |name: &str| {
            let found =
                request.0.iter().find(|(object, id, _)| *object != OVERLAY && SCHEMA[id.0 as usize - 100].1 == name);
            found.map(|(_, _, value)| *value)
        };
        let kind = match how {
            How::Test => Kind::Test,
            How::Flip => Kind::Flip,
            How::Settle | How::Modeset if wanted("ACTIVE") == Some(0) => Kind::Darken,
            How::Settle | How::Modeset => Kind::Light,
        };
        self.usable(true)?;
        self.strike(kind)?;
        self.pass();
        let source =
            wanted("FB_ID").zip(wanted("SRC_Y")).map(|(fb, top)| Source { fb: Id(fb as u32), top: top_of(top) });
        if kind != Kind::Darken {
            let is_alive = source.is_some_and(|source| self.fbs.contains_key(&source.fb));
            assert!(is_alive, "{kind:?} of a framebuffer that is no more");
            let moves = source.is_some_and(|source| u64::from(source.top) << 16 != self.value(PRIMARY, "SRC_Y"));
            match self.quirk {
                Some(Quirk::NoWindow) if source.is_some_and(|source| source.top > 0) => return Err(Errno::INVAL.into()),
                Some(Quirk::StiffWindow) if kind == Kind::Flip && moves => return Err(Errno::INVAL.into()),
                _ => {}
            }
        }
        match kind {
            Kind::Test => return Ok(()),
            Kind::Flip => {
                let is_dimmed = wanted("GAMMA_LUT").is_some();
                let count = 2 + usize::from(is_dimmed);
                assert_eq!(request.0.len(), count, "a flip sets what the plane shows, how bright, and nothing else");
                if is_dimmed && self.quirk == Some(Quirk::StiffRamp) {
                    return Err(Errno::INVAL.into());
                }
                if let Some(flip) = &self.pending {
                    // After the watchdog has barked we may ask; the kernel says so.
                    assert!(self.current() >= flip.vblank + 3, "two commits in flight");
                    return Err(Errno::BUSY.into());
                }
                let (source, ill) = (source.expect("asserted above"), self.ill_flip.take());
                let vblank = self.current() + u64::from(self.quirk != Some(Quirk::NoVblanks));
                self.pending = Some(Pending { source, vblank, ill });
            }
            Kind::Light | Kind::Darken => {
                // A blocking commit: what was pending is over, one way or the other, and a vblank has passed.
                self.pending = None;
                CLOCK.set(self.begins(self.current() + 1).0);
                self.modesets += u32::from(how == How::Modeset && kind == Kind::Light);
                self.glass = source.filter(|_| kind == Kind::Light);
            }
        }
        self.apply(request);
        Ok(())
    }

    fn shown(&mut self, plane: Id) -> io::Result<Option<Source>> {
        self.usable(false)?;
        let source = Source { fb: Id(self.value(plane, "FB_ID") as u32), top: top_of(self.value(plane, "SRC_Y")) };
        Ok(Some(source).filter(|source| source.fb.0 != 0))
    }

    fn vblank(&mut self, _: u32) -> io::Result<(Vblank, Nanos)> {
        self.usable(false)?;
        if self.quirk == Some(Quirk::NoVblanks) {
            return Err(Errno::OPNOTSUPP.into());
        }
        let is_early = self.quirk == Some(Quirk::LateVblanks) && !self.commits.contains_key(&Kind::Flip);
        if is_early || self.value(CRTC, "ACTIVE") == 0 {
            return Err(Errno::INVAL.into());
        }
        Ok((Vblank(self.current() as u32), self.begins(self.current())))
    }

    fn ask_vblank(&mut self, _: u32, vblank: Vblank) -> io::Result<()> {
        self.usable(false)?;
        let ahead = vblank.since(Vblank(self.current() as u32));
        self.asked.push(self.current().saturating_add_signed(ahead.into()));
        Ok(())
    }

    fn wait(&mut self, timeout: Duration) -> io::Result<Option<Happening>> {
        self.pass();
        if let Some(happening) = self.happenings.pop_front() {
            self.spins = 0;
            return Ok(Some(happening));
        }
        self.spins = if timeout.is_zero() { self.spins + 1 } else { 0 };
        assert!(self.spins < 100, "a busy wait");
        let end = now().after(timeout.as_nanos() as u64);
        let due = self.next_due().map_or(end, |due| due.min(end));
        CLOCK.set(due.max(now()).0);
        self.pass();
        Ok(self.happenings.pop_front())
    }
}

/// The row that a value of `SRC_Y` means.
fn top_of(value: u64) -> u32 {
    (value >> 16) as u32
}
