//! A real KMS card, through the kernel.
//!
//! Owns the card's descriptor, its buffers and the uevent socket, and turns ioctls into the plain data of `card.rs`.
//! Retries only after `EINTR`. Memory is mapped in `raw.rs`, properties are read in `properties.rs`, objects in
//! `reading.rs`. Start at [`Device::new`].

use super::backlight::{Backlight, CONNECTORS};
use super::card::{Buffer, BufferSpec, CommitMode, Connector, Id, Kms, KmsEvent, Properties, Request, Source, Survey};
use super::console::{Console, Switch};
use super::nodes::{cards, has_render_node};
use super::prober::Prober;
use super::properties::PropertyCache;
use super::reading::{handle, read_properties, read_survey, uninterrupted};
use super::uevents::Uevents;
use crate::paint::Layout;
use crate::raw::{Memory, take_inherited_fd};
use drm::control::atomic::AtomicModeReq;
use drm::control::{AtomicCommitFlags, Device as Control, Mode, framebuffer, from_u32, plane, property};
use drm::{ClientCapability, Device as Basic, DriverCapability, VblankWaitFlags, VblankWaitTarget};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use std::collections::{HashMap, VecDeque};
use std::fs::{File, OpenOptions};
use std::io;
use std::ops::RangeInclusive;
use std::os::fd::{AsFd, BorrowedFd, RawFd};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::time::Duration;
use timing::{Nanos, Vblank};

/// A KMS card of this machine.
pub struct Device {
    /// The card in the settings; `None` for the first that can light a display.
    asked: Option<PathBuf>,
    keeper: FdStore,
    card: Option<Card>,
    uevents: Option<Uevents>,
    happenings: VecDeque<KmsEvent>,
    /// Of the display that is lit.
    backlight: Option<Backlight>,
    /// The console that the player was started on. After the card, which is closed first.
    console: Option<Console>,
}

/// Keeps the card open if this process crashes, so that the last frame stays on the screen: systemd's file descriptor
/// store.
#[derive(Clone, Copy, Debug)]
pub struct FdStore {
    /// The descriptor of a card that was stored before, which this process owns.
    pub kept: Option<RawFd>,
    /// Stores this card, or removes the stored one.
    pub keep: fn(Option<BorrowedFd<'_>>),
}

impl FdStore {
    /// No store: the picture disappears with the process.
    pub const NOBODY: Self = Self { kept: None, keep: |_| {} };
}

impl Device {
    /// The card at `path`, or the first that can light a display; not yet opened.
    pub fn new(path: Option<PathBuf>, keeper: FdStore) -> Self {
        let uevents = Uevents::subscribe()
            .inspect_err(|error| tracing::warn!(%error, "cannot subscribe to hot-plug events, polling the connectors"))
            .ok();
        Self { asked: path, keeper, card: None, uevents, happenings: VecDeque::new(), backlight: None, console: None }
    }

    /// The open card.
    pub(super) fn card_fd(&self) -> Option<BorrowedFd<'_>> {
        self.card.as_ref().map(AsFd::as_fd)
    }

    fn card(&mut self) -> io::Result<&mut Card> {
        self.card.as_mut().ok_or_else(|| Errno::NODEV.into())
    }
}

impl Kms for Device {
    fn name(&self) -> String {
        let open = self.card.as_ref().map(|card| &card.path);
        open.or(self.asked.as_ref()).map_or_else(|| "any card".to_owned(), |path| path.display().to_string())
    }

    fn open(&mut self) -> io::Result<()> {
        if self.card.is_some() {
            return Ok(());
        }
        if let Some(kept) = self.keeper.kept.take() {
            match Card::adopt(take_inherited_fd(kept).into(), self.asked.as_deref()) {
                Ok(mut card) => {
                    card.start_prober();
                    self.card = Some(card);
                    return Ok(());
                }
                Err(error) => {
                    tracing::info!(%error, "cannot use the stored DRM card, opening it again");
                    (self.keeper.keep)(None);
                }
            }
        }
        let mut card = match &self.asked {
            Some(path) => Card::open(path)?,
            None => Card::first()?,
        };
        card.start_prober();
        self.card = Some(card);
        if self.console.is_none() {
            let taken = Console::take();
            self.console = taken
                .inspect_err(|error| tracing::warn!(%error, "cannot set the console to graphics mode"))
                .ok()
                .flatten();
        }
        Ok(())
    }

    fn close(&mut self) {
        if self.card.take().is_some_and(|card| card.is_kept) {
            (self.keeper.keep)(None);
        }
        self.happenings.clear();
    }

    fn release_console(&mut self) {
        if let Some(console) = &self.console {
            console.release();
        }
    }

    fn take_master(&mut self) -> io::Result<()> {
        let card = self.card()?;
        if card.left.is_some() { card.is_master() } else { uninterrupted(|| card.acquire_master_lock()) }
    }

    fn survey(&mut self) -> io::Result<Survey> {
        self.card()?.survey()
    }

    fn create(&mut self, spec: BufferSpec) -> io::Result<Vec<Buffer>> {
        self.card()?.create(spec)
    }

    fn destroy(&mut self, fb: Id) {
        if let Some(card) = &mut self.card {
            card.destroy(fb);
        }
    }

    fn write(&mut self, source: Source, paint: &mut dyn FnMut(&mut [u8])) -> io::Result<()> {
        self.card()?.buffers.get_mut(&source.fb).ok_or(Errno::NOENT)?.write(paint)
    }

    fn create_mode(&mut self, mode: &Mode) -> io::Result<Id> {
        let card = self.card()?;
        let raw: drm_ffi::drm_mode_modeinfo = (*mode).into();
        let blob = uninterrupted(|| card.create_property_blob(&raw))?;
        Ok(Id(u64::from(blob) as u32))
    }

    fn create_blob(&mut self, bytes: &[u8]) -> io::Result<Id> {
        let card = self.card()?;
        let made = uninterrupted(|| drm_ffi::mode::create_property_blob(card.as_fd(), &mut bytes.to_vec()))?;
        Ok(Id(made.blob_id))
    }

    fn destroy_blob(&mut self, blob: Id) {
        if let Some(card) = &self.card {
            let _ = card.destroy_property_blob(blob.0.into());
        }
    }

    fn find_backlight(&mut self, connector: &str) -> bool {
        let card = self.card.as_ref().map(|card| card.path.as_path());
        self.backlight = card.and_then(|card| Backlight::find(Path::new(CONNECTORS), card, connector));
        self.backlight.is_some()
    }

    fn set_backlight(&mut self, thousandths: u16) {
        if let Some(backlight) = &self.backlight {
            backlight.set(thousandths);
        }
    }

    fn commit(&mut self, how: CommitMode, request: &Request) -> io::Result<()> {
        let mut atomic = AtomicModeReq::new();
        for &(object, property, value) in &request.0 {
            let (Some(object), Some(property)) = (from_u32(object.0), from_u32::<property::Handle>(property.0)) else {
                return Err(Errno::INVAL.into());
            };
            atomic.add_raw_property(object, property, value);
        }
        let flags = match how {
            CommitMode::Test => AtomicCommitFlags::TEST_ONLY | AtomicCommitFlags::ALLOW_MODESET,
            CommitMode::Settle => AtomicCommitFlags::empty(),
            CommitMode::Modeset => AtomicCommitFlags::ALLOW_MODESET,
            CommitMode::Flip => AtomicCommitFlags::NONBLOCK | AtomicCommitFlags::PAGE_FLIP_EVENT,
        };
        let keep = self.keeper.keep;
        let card = self.card()?;
        uninterrupted(|| card.atomic_commit(flags, atomic.clone()))?;
        if matches!(how, CommitMode::Settle | CommitMode::Modeset) {
            card.free_inherited();
            if !std::mem::replace(&mut card.is_kept, true) {
                keep(Some(card.as_fd()));
            }
        }
        Ok(())
    }

    fn probe(&mut self, connector: Id) {
        match self.card.as_ref().map(|card| card.prober.as_ref()) {
            Some(Some(prober)) => prober.ask(connector),
            // The display is assumed to be unchanged.
            Some(None) => tracing::debug!("cannot probe the connector: its thread is not running"),
            None => self.happenings.push_back(KmsEvent::ProbeFailed(Errno::NODEV)),
        }
    }

    fn plane_properties(&mut self, plane: Id) -> io::Result<Properties> {
        let card = self.card()?;
        card.plane_properties(handle(plane)?)
    }

    fn vblank(&mut self, crtc: u32) -> io::Result<(Vblank, Nanos)> {
        let card = self.card()?;
        let reply =
            uninterrupted(|| card.wait_vblank(VblankWaitTarget::Relative(0), VblankWaitFlags::empty(), crtc, 0))?;
        Ok((Vblank(reply.frame()), nanos(reply.time().unwrap_or_default())))
    }

    fn request_vblank(&mut self, crtc: u32, vblank: Vblank) -> io::Result<()> {
        let card = self.card()?;
        let target = || VblankWaitTarget::Absolute(vblank.0);
        uninterrupted(|| card.wait_vblank(target(), VblankWaitFlags::EVENT, crtc, 0)).map(drop)
    }

    fn wait(&mut self, timeout: Duration) -> io::Result<Option<KmsEvent>> {
        if let Some(happening) = self.happenings.pop_front() {
            return Ok(Some(happening));
        }
        let timeout = Timespec::try_from(timeout.min(Duration::from_hours(1))).expect("an hour fits a timespec");
        let prober = self.card.as_ref().and_then(|card| card.prober.as_ref());
        // Any of them may be missing, so each is identified by its index among those present.
        let sources = [
            self.card.as_ref().map(AsFd::as_fd),
            prober.map(Prober::event_fd),
            self.uevents.as_ref().map(AsFd::as_fd),
            self.console.as_ref().map(Console::event_fd),
        ];
        let has = sources.map(|source| source.is_some());
        let watch = |source| PollFd::from_borrowed_fd(source, PollFlags::IN);
        let mut watched: Vec<_> = sources.into_iter().flatten().map(watch).collect();
        match poll(&mut watched, Some(&timeout)) {
            Ok(0) | Err(Errno::INTR) => return Ok(None),
            Ok(_) => {}
            Err(error) => return Err(error.into()),
        }
        let mut seen = watched.iter().map(PollFd::revents);
        let mut next = |is_there| if is_there { seen.next().unwrap_or(PollFlags::empty()) } else { PollFlags::empty() };
        let [card, probed, told, switched] = has.map(&mut next);
        if card.intersects(PollFlags::ERR | PollFlags::HUP | PollFlags::NVAL) {
            return Err(Errno::NODEV.into());
        }
        if let Some(open) = self.card.as_ref().filter(|_| card.contains(PollFlags::IN)) {
            open.read_events(&mut self.happenings)?;
        }
        while let Some(answer) = prober.filter(|_| !probed.is_empty()).and_then(Prober::answer) {
            let found = |connector| KmsEvent::Probed(Box::new(connector));
            self.happenings.push_back(answer.map_or_else(KmsEvent::ProbeFailed, found));
        }
        while let Some(switch) = self.console.as_ref().filter(|_| !switched.is_empty()).and_then(Console::switch) {
            self.happenings.push_back(match switch {
                Switch::Away => KmsEvent::SwitchAway,
                Switch::Back => KmsEvent::SwitchBack,
            });
        }
        if self.uevents.as_mut().is_some_and(|source| !told.is_empty() && source.display_changed()) {
            self.happenings.push_back(KmsEvent::Hotplug);
        }
        Ok(self.happenings.pop_front())
    }
}

/// An open card. When it is closed the kernel frees everything that was created on it.
struct Card {
    /// Before the descriptor: mappings and gbm objects go first.
    buffers: HashMap<Id, Memory>,
    gbm: Option<gbm::Device<std::os::fd::OwnedFd>>,
    path: PathBuf,
    file: File,
    properties: PropertyCache,
    /// Whether the driver supports format modifiers.
    modifiers: bool,
    /// For a card inherited from a previous process: its framebuffers, one of which may be on the screen.
    left: Option<Vec<framebuffer::Handle>>,
    /// Whether it stays open without us.
    is_kept: bool,
    /// Probes the connector in use; `None` if the thread cannot be started.
    prober: Option<Prober>,
}

/// How many GEM handles of a previous process are looked for: it has about three.
const MAX_INHERITED: RangeInclusive<u32> = 1..=64;

impl AsFd for Card {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.file.as_fd()
    }
}

impl Basic for Card {}
impl Control for Card {}

impl Card {
    /// Opens the KMS card at `path`.
    fn open(path: &Path) -> io::Result<Self> {
        let nonblocking = rustix::fs::OFlags::NONBLOCK.bits().cast_signed();
        let file = OpenOptions::new().read(true).write(true).custom_flags(nonblocking).open(path)?;
        Self::of(file, path.to_owned())
    }

    /// Takes over `file` from a previous process, whose last frame may be on the screen; it must be the card `asked` for.
    fn adopt(file: File, asked: Option<&Path>) -> io::Result<Self> {
        let device = |path: &Path| rustix::fs::stat(path).map(|stat| stat.st_rdev).ok();
        let ours = rustix::fs::fstat(&file)?.st_rdev;
        let mut nodes = asked.map_or_else(cards, |asked| Ok(vec![asked.to_owned()]))?.into_iter();
        let path = nodes.find(|path| device(path) == Some(ours)).ok_or(Errno::NODEV)?;
        // Its GEM handles are unknown, so they are closed. Framebuffers keep their buffers.
        for handle in MAX_INHERITED {
            drm_ffi::gem::close(file.as_fd(), handle).ok();
        }
        let mut card = Self::of(file, path)?;
        card.left = Some(card.resource_handles()?.framebuffers().to_vec());
        card.is_kept = true;
        Ok(card)
    }

    fn of(file: File, path: PathBuf) -> io::Result<Self> {
        let properties = PropertyCache::default();
        let mut card = Self {
            buffers: HashMap::new(),
            gbm: None,
            path,
            file,
            properties,
            modifiers: false,
            left: None,
            is_kept: false,
            prober: None,
        };
        card.set_client_capability(ClientCapability::UniversalPlanes, true)?;
        card.set_client_capability(ClientCapability::Atomic, true)?;
        card.resource_handles()?;
        card.modifiers = card.get_driver_capability(DriverCapability::AddFB2Modifiers).is_ok_and(|cap| cap == 1);
        if has_render_node(&card.file) {
            let gbm = card.file.as_fd().try_clone_to_owned().and_then(gbm::Device::new);
            card.gbm = gbm.inspect_err(|error| tracing::info!(%error, "no GBM device, using dumb buffers")).ok();
        }
        Ok(card)
    }

    /// The first card with a display connected, else the first card.
    fn first() -> io::Result<Self> {
        let mut dark = Err(Errno::NODEV.into());
        for path in cards()? {
            let opened = Self::open(&path).and_then(|mut card| card.survey().map(|survey| (card, survey)));
            match opened {
                Ok((card, survey)) => {
                    if survey.connectors.iter().any(Connector::may_light) {
                        return Ok(card);
                    }
                    if dark.is_err() {
                        dark = Ok(card);
                    }
                }
                Err(error) => tracing::debug!(card = %path.display(), %error, "cannot use this card, trying the next"),
            }
        }
        dark
    }

    fn start_prober(&mut self) {
        let started = Prober::start(&self.file);
        self.prober = started
            .inspect_err(|error| tracing::warn!(%error, "cannot start the connector probe: unplugging a display is not detected"))
            .ok();
    }

    /// Checks that the card is DRM master. Master cannot be acquired here, because the process that opened the card is
    /// gone.
    fn is_master(&self) -> io::Result<()> {
        match uninterrupted(|| drm_ffi::auth::auth_magic_token(self.as_fd(), 0)) {
            // No client has that token: the error shows that the check for master passed.
            Err(error) if error.raw_os_error() != Some(Errno::INVAL.raw_os_error()) => Err(error),
            _ => Ok(()),
        }
    }

    /// Frees the framebuffers of the previous process, now that another frame is on the screen.
    fn free_inherited(&mut self) {
        for framebuffer in self.left.as_mut().map(std::mem::take).unwrap_or_default() {
            self.destroy_framebuffer(framebuffer).ok();
        }
    }

    /// Reads everything. A removed card may still answer while it is open; its device node is gone.
    fn survey(&mut self) -> io::Result<Survey> {
        if rustix::fs::stat(&self.path)?.st_rdev != rustix::fs::fstat(&self.file)?.st_rdev {
            return Err(Errno::NODEV.into());
        }
        let mut cache = std::mem::take(&mut self.properties);
        let survey = read_survey(self, self.modifiers, &mut cache);
        self.properties = cache;
        survey
    }

    fn plane_properties(&mut self, plane: plane::Handle) -> io::Result<Properties> {
        let mut cache = std::mem::take(&mut self.properties);
        let properties = read_properties(self, plane, &mut cache);
        self.properties = cache;
        properties
    }

    fn create(&mut self, spec: BufferSpec) -> io::Result<Vec<Buffer>> {
        if spec.count > 1 && self.gbm.is_some() {
            // GPU memory is synchronised as a whole for each write, including the buffer on the screen.
            return Err(Errno::INVAL.into());
        }
        let (format, size) = (spec.format.format, (spec.size.0, spec.size.1 * spec.count));
        let memory = Memory::allocate(&self.file, self.gbm.as_ref(), format.allocation(size))?;
        let layout = Layout::new(format, size, memory.pitch());
        let handles = layout.pitches.map(|pitch| if pitch == 0 { 0 } else { memory.handle() });
        let flags = if spec.format.explicit { drm_ffi::DRM_MODE_FB_MODIFIERS } else { 0 };
        let ((width, height), code) = (size, format.fourcc());
        let (pitches, offsets) = (&layout.pitches, &layout.offsets);
        let made =
            drm_ffi::mode::add_fb2(self.as_fd(), width, height, code, &handles, pitches, offsets, &[0; 4], flags);
        match made {
            Ok(made) => {
                let fb = Id(made.fb_id);
                self.buffers.insert(fb, memory);
                let tops = (0..spec.count).map(|nth| nth * spec.size.1);
                Ok(tops
                    .map(|top| Buffer { source: Source { fb, top }, layout: layout.part(top, spec.size.1) })
                    .collect())
            }
            Err(error) => {
                memory.free(&self.file);
                Err(error)
            }
        }
    }

    fn destroy(&mut self, fb: Id) {
        if let Err(error) = drm_ffi::mode::rm_fb(self.as_fd(), fb.0) {
            tracing::debug!(%error, fb = fb.0, "cannot remove a framebuffer");
        }
        if let Some(memory) = self.buffers.remove(&fb) {
            memory.free(&self.file);
        }
    }

    fn read_events(&self, happenings: &mut VecDeque<KmsEvent>) -> io::Result<()> {
        let events = match uninterrupted(|| self.receive_events()) {
            Ok(events) => events,
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(()),
            Err(error) => return Err(error),
        };
        happenings.extend(events.filter_map(|event| match event {
            drm::control::Event::PageFlip(flip) => {
                Some(KmsEvent::Flip { vblank: Vblank(flip.frame), at: nanos(flip.duration) })
            }
            drm::control::Event::Vblank(vblank) => {
                Some(KmsEvent::Vblank { vblank: Vblank(vblank.frame), at: nanos(vblank.time) })
            }
            drm::control::Event::Unknown(_) => None,
        }));
        Ok(())
    }
}

fn nanos(time: Duration) -> Nanos {
    Nanos(u64::try_from(time.as_nanos()).unwrap_or(u64::MAX))
}
