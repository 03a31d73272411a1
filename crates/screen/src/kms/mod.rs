//! A real display: one connector of one KMS card, driven by atomic commits.
//!
//! Owns the screen's states: dark, ready (buffers are allocated, the previous picture is still lit), lit. Each frame is
//! one commit with `NONBLOCK | PAGE_FLIP_EVENT`, without a modeset; modes are set by blocking commits inside
//! [`Screen::next_event`]. There is no busy wait, and no error is final: faults of cable, driver or another DRM master
//! are reported as an [`Event`].
//!
//! Start at [`KmsScreen`]. From dark to ready: `bring_up.rs`, in the order of `choose.rs`. Errors: `recovery.rs`, by
//! the rules of `recovery_policy.rs`; hot-plug: `hot_plug.rs`; another configuration: `change_over.rs`; brightness and
//! the night: `dimming.rs` and `light.rs`. `card.rs` is the interface to the kernel, `device.rs` its implementation.

mod backlight;
mod bring_up;
mod candidate;
mod card;
mod change_over;
mod choose;
mod console;
mod cvt;
mod device;
mod dimming;
mod hot_plug;
mod in_formats;
mod light;
mod modes;
mod nodes;
mod plan;
mod prober;
mod properties;
mod reading;
mod recovery;
mod recovery_policy;
mod ring;
#[cfg(test)]
mod scripted;
mod uevents;

pub(crate) use candidate::fit;
pub(crate) use card::Kms;
pub(crate) use console::{Console, Switch};
pub(crate) use device::Device;
pub use device::FdStore;
pub(crate) use uevents::Uevents;

use crate::output::OutputSettings;
use crate::paint::{blacken, paint};
use crate::transform::{Transform, Transformer};
use crate::vblank_clock::VblankClock;
use crate::{ConnectorId, Event, Light, Picture, Screen, ScreenError, ScreenInfo};
use candidate::{Candidate, Rect, mode_size};
use card::{Buffer, Id, KmsEvent, Survey};
use dimming::Dimming;
use hot_plug::HotPlug;
use plan::Plan;
use ring::Ring;
use std::collections::VecDeque;
use std::io;
use std::mem::ManuallyDrop;
use std::os::fd::OwnedFd;
use std::path::PathBuf;
use std::time::Duration;
use timing::{Nanos, Rate, Vblank};

/// The largest pictures: 8K.
const MAX_PICTURE: (u32, u32) = (8192, 8192);

/// What to light, and where.
#[derive(Clone, Debug)]
pub struct KmsSettings {
    /// The card, as `/dev/dri/card0`; `None` for the first that can light a display.
    pub device: Option<PathBuf>,
    /// Width and height of the first pictures in pixels, even.
    pub size: (u32, u32),
    /// The pictures' rate: a refresh that is a multiple of it is preferred.
    pub fps: Rate,
    /// The monotonic clock. Any origin will do: the times in events are the kernel's own (`CLOCK_MONOTONIC`).
    pub now: fn() -> Nanos,
    /// Keeps the last frame on the screen if this process crashes.
    pub keeper: FdStore,
    /// The owner's settings of the display.
    pub output: OutputSettings,
}

/// A display on a KMS card.
pub struct KmsScreen<K: Kms = Device> {
    kms: K,
    settings: KmsSettings,
    phase: Phase,
    /// Candidates that failed since all of them were last tried.
    refused: Vec<Candidate>,
    /// Attempts since the last flip.
    tries: u32,
    notices: VecDeque<Event>,
    /// The newest vblank that was reported.
    told: Vblank,
    /// As bright as it is to be.
    light: Light,
    /// The output that takes over with the next commit.
    coming: Option<Box<Output>>,
    /// The previous output, which may be on the screen until the new one is lit.
    leaving: Option<Box<Output>>,
    transformer: Transformer,
    cable: HotPlug,
    /// Another console is active.
    is_elsewhere: bool,
}

enum Phase {
    /// Nothing is to be lit.
    Asleep,
    /// No display can be lit; the next attempt is at `retry`.
    Dark { retry: Nanos },
    /// Buffers are allocated.
    Up(Box<Output>),
}

/// A display configuration with its buffers.
struct Output {
    plan: Plan,
    /// The owner's settings that it was made for.
    made_for: OutputSettings,
    /// The card's resources at that time.
    survey: Survey,
    mode: Id,
    ring: Ring<FilledBuffer>,
    /// Our picture is on the screen.
    lit: bool,
    flight: CommitState,
    asked: Option<VblankRequest>,
    /// Computed vblanks, where the driver has none (virtual machines, firmware framebuffers).
    own_vblanks: Option<VblankClock>,
    /// Set when a flip's event was given up, and may still come: the vblank at that time, or of the last flip since.
    gave_up_at: Option<Vblank>,
    /// Flips that failed since the last one with a new picture.
    failed_in_a_row: u32,
    dimming: Dimming,
    /// The plane was seen to keep our colour properties.
    has_colours: bool,
}

/// A buffer with the rectangle of its picture; the rest is black.
struct FilledBuffer {
    buffer: Buffer,
    area: Option<Rect>,
}

/// How far the pending commit is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum CommitState {
    /// There is none.
    Landed,
    /// A blocking commit follows at `next`; first tried at `since`.
    Lighting { next: Nanos, since: Nanos },
    /// Committed at vblank `from`; the watchdog acts at `deadline`.
    Flying { from: Option<Vblank>, deadline: Nanos },
    /// Flipped at once by a driver without vblanks; it counts from `at`.
    Landing { vblank: Vblank, at: Nanos },
    /// The kernel was busy: the next attempt is at `next`; the watchdog acts at `deadline`.
    Retrying { next: Nanos, deadline: Nanos },
}

/// A vblank that the player has requested.
#[derive(Clone, Copy, Debug)]
struct VblankRequest {
    vblank: Vblank,
    deadline: Nanos,
}

impl Output {
    /// Whether a flip at `vblank` belongs to a commit that was given up.
    fn gave_up(&self, vblank: Vblank) -> bool {
        self.gave_up_at.is_some_and(|at| vblank.since(at) <= 0)
    }

    /// The vblank at `now`, by the kernel's counter or our clock, and its start.
    fn vblank(&self, kms: &mut impl Kms, now: Nanos) -> io::Result<(Vblank, Nanos)> {
        match self.own_vblanks {
            Some(own_vblanks) => Ok((Vblank(own_vblanks.at(now) as u32), own_vblanks.begins(own_vblanks.at(now)))),
            None => kms.vblank(self.plan.crtc),
        }
    }
}

impl KmsScreen<Device> {
    /// Opens a card of this machine. Without a display, or while another process is DRM master, the screen is dark and
    /// tries again.
    ///
    /// # Errors
    /// [`ScreenError::Open`] if there is no such card, or it is no KMS card.
    pub fn open(settings: KmsSettings) -> Result<Self, ScreenError> {
        Self::on(Device::new(settings.device.clone(), settings.keeper), settings)
    }

    /// The card with its picture, to hand over to another process; `None` if it is not open. The picture stays as long
    /// as a process has the card open.
    pub fn into_fd(self) -> Option<OwnedFd> {
        // The picture's framebuffers are not freed: the next process takes them over.
        let screen = ManuallyDrop::new(self);
        screen.kms.card_fd()?.try_clone_to_owned().ok()
    }
}

impl<K: Kms> KmsScreen<K> {
    /// A screen on `kms`.
    fn on(mut kms: K, settings: KmsSettings) -> Result<Self, ScreenError> {
        kms.open().map_err(|source| ScreenError::Open { device: kms.name(), source })?;
        let phase = Phase::Dark { retry: (settings.now)() };
        let mut screen = Self {
            kms,
            settings,
            phase,
            refused: Vec::new(),
            tries: 0,
            notices: VecDeque::new(),
            light: Light::FULL,
            told: Vblank(0),
            coming: None,
            leaving: None,
            transformer: Transformer::default(),
            cable: HotPlug::default(),
            is_elsewhere: false,
        };
        screen.attempt();
        // Lit from the start is no news.
        screen.notices.retain(|notice| *notice != Event::Back);
        Ok(screen)
    }

    fn now(&self) -> Nanos {
        (self.settings.now)()
    }

    fn period(&self) -> Duration {
        match &self.phase {
            Phase::Up(output) => Duration::from_nanos(output.plan.refresh.span_ns(1)),
            Phase::Asleep | Phase::Dark { .. } => Duration::ZERO,
        }
    }

    /// The earliest time at which something must be done without an event.
    fn next_wakeup(&self) -> Option<Nanos> {
        let output = match &self.phase {
            // In the past, so that it is due at once.
            Phase::Asleep => return (self.light != Light::Off).then_some(Nanos(0)),
            Phase::Dark { retry } => return Some(*retry),
            Phase::Up(output) => output,
        };
        let flight = match output.flight {
            CommitState::Landed => None,
            CommitState::Lighting { next, .. } | CommitState::Retrying { next, .. } => Some(next),
            CommitState::Flying { deadline, .. } => Some(deadline),
            CommitState::Landing { at, .. } => Some(at),
        };
        let asked = output.asked.map(|asked| asked.deadline);
        flight.into_iter().chain(asked).chain(self.cable.look_at()).min()
    }

    /// Does what is due by `now`.
    fn run_due(&mut self, now: Nanos) {
        if self.next_wakeup().is_none_or(|next_wakeup| next_wakeup > now) {
            return;
        }
        let flight = match &self.phase {
            Phase::Asleep => return self.switch_on(),
            Phase::Dark { .. } => return self.attempt(),
            Phase::Up(_) if self.cable.look_at().is_some_and(|at| at <= now) => return self.probe(),
            Phase::Up(output) => output.flight,
        };
        match flight {
            CommitState::Lighting { next, since } if next <= now => self.light(since),
            CommitState::Retrying { next, deadline } if next <= now => self.submit(Some(deadline)),
            CommitState::Landing { vblank, at } if at <= now => self.on_flip(vblank, at),
            CommitState::Flying { from, deadline } if deadline <= now => self.overdue(from),
            CommitState::Landed
            | CommitState::Lighting { .. }
            | CommitState::Retrying { .. }
            | CommitState::Landing { .. }
            | CommitState::Flying { .. } => self.vblank_overdue(),
        }
    }

    /// Commits the pending buffer. `deadline`: of the first attempt, if this is a later one.
    fn submit(&mut self, deadline: Option<Nanos>) {
        let (now, period) = (self.now(), self.period());
        let Phase::Up(output) = &mut self.phase else { return };
        let Some(source) = output.ring.pending().map(|painted| painted.buffer.source) else { return };
        let deadline = deadline.unwrap_or(now.after(recovery_policy::patience(period).as_nanos() as u64));
        let from = output.vblank(&mut self.kms, now).ok().map(|(vblank, _)| vblank);
        match light::flip(&mut self.kms, output, source) {
            Ok(()) => {
                let deadline = now.after(recovery_policy::patience(period).as_nanos() as u64);
                output.flight = CommitState::Flying { from, deadline };
            }
            Err(error) => self.flip_failed(&error, deadline),
        }
    }

    /// The pending picture is on the screen since `vblank`.
    fn on_flip(&mut self, vblank: Vblank, at: Nanos) {
        let Phase::Up(output) = &mut self.phase else { return };
        if output.ring.flipped() {
            output.failed_in_a_row = 0;
        }
        output.flight = CommitState::Landed;
        // The given-up commit lies before this flip. It is updated, because the wrapping counter compares only nearby
        // vblanks.
        output.gave_up_at = output.gave_up_at.map(|_| vblank);
        self.tries = 0;
        self.cable.on_lit(self.settings.now);
        self.notices.push_back(Event::Flip { vblank, at });
    }

    fn on_event(&mut self, happening: KmsEvent) {
        let output = match (&happening, &mut self.phase) {
            (KmsEvent::SwitchAway, _) => return self.leave_console(),
            (KmsEvent::SwitchBack, _) => return self.return_to_console(),
            (KmsEvent::Hotplug, Phase::Dark { retry }) => {
                *retry = self.cable.not_before((self.settings.now)());
                return;
            }
            (_, Phase::Asleep | Phase::Dark { .. }) => return,
            (_, Phase::Up(output)) => output,
        };
        match happening {
            KmsEvent::Flip { vblank, .. } if output.gave_up(vblank) => {
                tracing::debug!("a late page flip event of a commit that was given up");
            }
            KmsEvent::Flip { vblank, at } if matches!(output.flight, CommitState::Flying { .. }) => match output
                .own_vblanks
            {
                None => self.on_flip(vblank, at),
                Some(own_vblanks) => {
                    let next = own_vblanks.at((self.settings.now)()) + 1;
                    output.flight = CommitState::Landing { vblank: Vblank(next as u32), at: own_vblanks.begins(next) };
                }
            },
            KmsEvent::Vblank { vblank, at } => {
                if output.asked.take_if(|asked| vblank.since(asked.vblank) >= 0).is_some() {
                    self.notices.push_back(Event::Vblank { vblank, at });
                }
            }
            KmsEvent::Flip { .. } => tracing::debug!("an unexpected page flip event"),
            KmsEvent::Hotplug => self.probe(),
            KmsEvent::Probed(connector) => self.probed(*connector),
            KmsEvent::ProbeFailed(errno) => self.card_failed(&errno.into()),
            KmsEvent::SwitchAway | KmsEvent::SwitchBack => {}
        }
    }
}

impl<K: Kms> Screen for KmsScreen<K> {
    fn info(&self) -> Option<ScreenInfo> {
        let Phase::Up(output) = &self.phase else { return None };
        let (width, height) = mode_size(&output.plan.way.mode);
        Some(ScreenInfo {
            screen: format!("kms:{} {}", self.kms.name(), output.plan.connector),
            mode: format!("{width}x{height}@{}", output.plan.refresh),
            size: (width, height),
            format: output.plan.way.format.format.name().to_owned(),
            refresh: output.plan.refresh,
            notes: output.plan.unmet.clone(),
            dimmed_by: output.dimming.by(),
            connector: Some(ConnectorId { card: self.kms.name().into(), name: output.plan.connector.clone() }),
        })
    }

    fn stage(&mut self, picture: &Picture<'_>) -> Result<(), ScreenError> {
        let Phase::Up(output) = &mut self.phase else { return Ok(()) };
        let output = self.coming.as_mut().unwrap_or(output);
        picture.check(MAX_PICTURE)?;
        let Some(FilledBuffer { buffer, area: held }) = output.ring.stage() else { return Ok(()) };
        let way = &output.plan.way;
        let area = way.area((picture.width, picture.height), buffer.layout.size);
        // A picture that covers the buffer needs no black border.
        let has_border = held.replace(area) != Some(area) && (area.width, area.height) != buffer.layout.size;
        let (rotation, thousandths) = (way.copy_rotation, output.dimming.software_dim());
        let transform = Transform { rotation, size: (area.width, area.height), thousandths };
        let picture = self.transformer.apply(picture, transform);
        let written = self.kms.write(buffer.source, &mut |bytes| {
            if has_border {
                blacken(bytes, &buffer.layout);
            }
            paint(bytes, &buffer.layout, (area.left, area.top), &picture);
        });
        if let Err(error) = written {
            tracing::debug!(%error, "cannot write to a scan-out buffer");
        }
        Ok(())
    }

    fn commit(&mut self) {
        self.change_over();
        let Phase::Up(output) = &mut self.phase else { return };
        if output.flight != CommitState::Landed || output.ring.commit().is_none() {
            return;
        }
        if output.lit {
            self.submit(None);
        } else {
            let now = (self.settings.now)();
            output.flight = CommitState::Lighting { next: now, since: now };
        }
    }

    fn set_format(&mut self, size: (u32, u32), fps: Rate) {
        self.prepare_for(size, fps);
    }

    fn set_light(&mut self, light: Light) {
        self.light = light;
        self.dim();
    }

    fn set_output(&mut self, output: &OutputSettings) {
        self.change_output(output);
    }

    fn notify_at(&mut self, vblank: Vblank) {
        let (now, period) = (self.now(), self.period());
        let Phase::Up(output) = &mut self.phase else { return };
        if !output.lit {
            return;
        }
        if let Some(own_vblanks) = output.own_vblanks {
            output.asked =
                Some(VblankRequest { vblank, deadline: own_vblanks.begins(own_vblanks.unwrap_near(vblank, now)) });
            return;
        }
        let crtc = output.plan.crtc;
        let ahead = vblank.since(self.told).max(0);
        let wait = period * ahead.cast_unsigned() + recovery_policy::patience(period);
        output.asked = Some(VblankRequest { vblank, deadline: now.after(wait.as_nanos() as u64) });
        if let Err(error) = self.kms.request_vblank(crtc, vblank) {
            tracing::debug!(%error, "cannot request a vblank event");
        }
    }

    fn next_event(&mut self, timeout: Duration) -> Event {
        let mut end = None;
        loop {
            if let Some(notice) = self.notices.pop_front() {
                if let Event::Flip { vblank, .. } | Event::Vblank { vblank, .. } = notice {
                    self.told = vblank;
                }
                return notice;
            }
            if self.light == Light::Off && !matches!(self.phase, Phase::Asleep) {
                self.sleep();
                continue;
            }
            // Read once per turn: it is a system call where there is no vDSO.
            let now = self.now();
            let end = *end.get_or_insert(now.after(u64::try_from(timeout.as_nanos()).unwrap_or(u64::MAX)));
            self.run_due(now);
            if !self.notices.is_empty() {
                continue;
            }
            let until = self.next_wakeup().map_or(end, |next_wakeup| next_wakeup.min(end));
            match self.kms.wait(Duration::from_nanos(until.since(now))) {
                Ok(Some(happening)) => self.on_event(happening),
                Ok(None) if self.now() >= end => return Event::Idle,
                Ok(None) => {}
                Err(error) => self.card_failed(&error),
            }
        }
    }
}
