//! A real display: one connector of one KMS card, driven by atomic commits.
//!
//! Owns the screen's life: dark, ready (buffers stand, the previous picture is still lit), lit. Per frame it commits
//! `NONBLOCK | PAGE_FLIP_EVENT`, one at a time, and never sets a mode; modes are set, waiting, inside
//! [`Screen::next_event`]. Never busy-waits, never gives up: what a cable, a driver or another master does is an
//! [`Event`].
//!
//! Start at [`KmsScreen`]. From dark to ready: `bring_up.rs`, in the order of `choose.rs`. When something fails:
//! `recovery.rs`, by the rules of `ladder.rs`; cables that come and go: `hot_plug.rs`. Another way to light pictures:
//! `change_over.rs`. How bright, and the night: `dimming.rs` and `light.rs`. The kernel is behind `card.rs`; `device.rs` is the
//! real one.

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
mod ladder;
mod light;
mod modes;
mod nodes;
mod plan;
mod prober;
mod properties;
mod reading;
mod recovery;
mod ring;
#[cfg(test)]
mod scripted;
mod uevents;

pub(crate) use candidate::fitted;
pub(crate) use card::Kms;
pub(crate) use console::{Console, Switch};
pub(crate) use device::Device;
pub use device::Keeper;
pub(crate) use uevents::Uevents;

use crate::beat::Beat;
use crate::fit::{Fitter, Fitting};
use crate::output::OutputSettings;
use crate::paint::{blacken, paint};
use crate::{Event, Light, Lit, Picture, Screen, ScreenError};
use candidate::{Candidate, Rect, mode_size};
use card::{Buffer, Happening, Id, Survey};
use dimming::Dimming;
use hot_plug::Cable;
use plan::Plan;
use ring::Ring;
use std::collections::VecDeque;
use std::io;
use std::mem::ManuallyDrop;
use std::os::fd::OwnedFd;
use std::path::PathBuf;
use std::time::Duration;
use timing::{Nanos, Rate, Vblank};

/// The largest pictures that are taken: of 8K.
const LARGEST_PICTURE: (u32, u32) = (8192, 8192);

/// What to light, and where.
#[derive(Clone, Debug)]
pub struct KmsSettings {
    /// The card, as `/dev/dri/card0`; `None` for the first that can light something.
    pub device: Option<PathBuf>,
    /// The pictures' width and height in pixels, even; of the first ones.
    pub size: (u32, u32),
    /// The pictures' rate: a refresh that is a multiple of it is preferred.
    pub fps: Rate,
    /// The monotonic clock. Any origin will do: the times in events are the kernel's own (`CLOCK_MONOTONIC`).
    pub now: fn() -> Nanos,
    /// Who keeps the last frame on the glass if this process falls.
    pub keeper: Keeper,
    /// What the owner of the display has set.
    pub output: OutputSettings,
}

/// A display on a KMS card.
pub struct KmsScreen<K: Kms = Device> {
    kms: K,
    settings: KmsSettings,
    phase: Phase,
    /// Ways that the kernel refused since all of them were last tried.
    refused: Vec<Candidate>,
    /// Attempts to light something since the last flip.
    tries: u32,
    notices: VecDeque<Event>,
    /// The newest vblank that the player was told of.
    told: Vblank,
    /// As bright as it is to be.
    light: Light,
    /// How pictures of another form will be lit, from the next commit on.
    coming: Option<Box<Output>>,
    /// What may be on the glass until the output that took its place is lit.
    leaving: Option<Box<Output>>,
    fitter: Fitter,
    cable: Cable,
    /// Somebody looks at another console.
    is_elsewhere: bool,
}

enum Phase {
    /// Nothing is to be lit.
    Asleep,
    /// Nothing can be lit; the next attempt is at `retry`.
    Dark { retry: Nanos },
    /// Buffers stand.
    Up(Box<Output>),
}

/// A way to light pictures, with its buffers.
struct Output {
    plan: Plan,
    /// The settings of the display's owner by which it was made.
    made_for: OutputSettings,
    /// What the card had to choose from.
    survey: Survey,
    mode: Id,
    ring: Ring<Painted>,
    /// A picture of ours is on the glass.
    lit: bool,
    flight: Flight,
    asked: Option<Asked>,
    /// Our own count of vblanks, where the driver has none (virtual machines, firmware framebuffers).
    beat: Option<Beat>,
    /// Once a flip's event was taken for lost, and may yet come: the vblank then, or of the last flip since.
    gave_up_at: Option<Vblank>,
    /// Flips that went wrong since the last that brought another picture.
    failed_in_a_row: u32,
    dimming: Dimming,
    /// The plane is known to keep our colours.
    has_colours: bool,
}

/// A buffer, and where the picture in it lies: around that, it is black.
struct Painted {
    buffer: Buffer,
    area: Option<Rect>,
}

/// How far the pending commit is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Flight {
    /// There is none.
    Landed,
    /// It is to be lit, waiting, at `next`; first tried at `since`.
    Lighting { next: Nanos, since: Nanos },
    /// The kernel has it since vblank `from`; the watchdog barks at `deadline`.
    Flying { from: Option<Vblank>, deadline: Nanos },
    /// The kernel has flipped without waiting for a vblank, having none: it counts from `at`.
    Landing { vblank: Vblank, at: Nanos },
    /// The kernel was busy: once more at `next`; the watchdog barks at `deadline`.
    Retrying { next: Nanos, deadline: Nanos },
}

/// A vblank that the player waits for.
#[derive(Clone, Copy, Debug)]
struct Asked {
    vblank: Vblank,
    deadline: Nanos,
}

impl Output {
    /// Whether a flip at `vblank` is that of a commit whose event was taken for lost.
    fn gave_up(&self, vblank: Vblank) -> bool {
        self.gave_up_at.is_some_and(|at| vblank.since(at) <= 0)
    }

    /// The vblank at `now`, by the kernel's count or by our own, and when it began.
    fn vblank(&self, kms: &mut impl Kms, now: Nanos) -> io::Result<(Vblank, Nanos)> {
        match self.beat {
            Some(beat) => Ok((Vblank(beat.at(now) as u32), beat.begins(beat.at(now)))),
            None => kms.vblank(self.plan.crtc),
        }
    }
}

impl KmsScreen<Device> {
    /// Opens a card of this machine. Without a display, or while another process is master, the screen is dark and
    /// waits for its time.
    ///
    /// # Errors
    /// [`ScreenError::Open`] if there is no such card, or it is no KMS card.
    pub fn open(settings: KmsSettings) -> Result<Self, ScreenError> {
        Self::on(Device::new(settings.device.clone(), settings.keeper), settings)
    }

    /// Leaves the card with what is on its glass to whoever gets it from the caller; `None` if it is not open. The picture
    /// stays as long as anybody has the card open.
    pub fn bequeath(self) -> Option<OwnedFd> {
        // What belongs to the picture is not given back: the card's numbers will be others'.
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
            fitter: Fitter::default(),
            cable: Cable::default(),
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

    /// The earliest time at which something must be done without being told.
    fn wake(&self) -> Option<Nanos> {
        let output = match &self.phase {
            // Long ago: whoever looks at the clock after this must not find it still to come.
            Phase::Asleep => return (self.light != Light::Off).then_some(Nanos(0)),
            Phase::Dark { retry } => return Some(*retry),
            Phase::Up(output) => output,
        };
        let flight = match output.flight {
            Flight::Landed => None,
            Flight::Lighting { next, .. } | Flight::Retrying { next, .. } => Some(next),
            Flight::Flying { deadline, .. } => Some(deadline),
            Flight::Landing { at, .. } => Some(at),
        };
        let asked = output.asked.map(|asked| asked.deadline);
        flight.into_iter().chain(asked).chain(self.cable.look_at()).min()
    }

    /// Does what is due by `now`.
    fn act(&mut self, now: Nanos) {
        if self.wake().is_none_or(|wake| wake > now) {
            return;
        }
        let flight = match &self.phase {
            Phase::Asleep => return self.rise(),
            Phase::Dark { .. } => return self.attempt(),
            Phase::Up(_) if self.cable.look_at().is_some_and(|at| at <= now) => return self.probe(),
            Phase::Up(output) => output.flight,
        };
        match flight {
            Flight::Lighting { next, since } if next <= now => self.light(since),
            Flight::Retrying { next, deadline } if next <= now => self.submit(Some(deadline)),
            Flight::Landing { vblank, at } if at <= now => self.landed(vblank, at),
            Flight::Flying { from, deadline } if deadline <= now => self.overdue(from),
            Flight::Landed
            | Flight::Lighting { .. }
            | Flight::Retrying { .. }
            | Flight::Landing { .. }
            | Flight::Flying { .. } => self.vblank_overdue(),
        }
    }

    /// Hands the pending buffer to the kernel. `deadline`: of the first try, if this is not it.
    fn submit(&mut self, deadline: Option<Nanos>) {
        let (now, period) = (self.now(), self.period());
        let Phase::Up(output) = &mut self.phase else { return };
        let Some(source) = output.ring.pending().map(|painted| painted.buffer.source) else { return };
        let deadline = deadline.unwrap_or(now.after(ladder::patience(period).as_nanos() as u64));
        let from = output.vblank(&mut self.kms, now).ok().map(|(vblank, _)| vblank);
        match light::flip(&mut self.kms, output, source) {
            Ok(()) => {
                let deadline = now.after(ladder::patience(period).as_nanos() as u64);
                output.flight = Flight::Flying { from, deadline };
            }
            Err(error) => self.flip_failed(&error, deadline),
        }
    }

    /// The pending picture is on the glass since `vblank`.
    fn landed(&mut self, vblank: Vblank, at: Nanos) {
        let Phase::Up(output) = &mut self.phase else { return };
        if output.ring.flipped() {
            output.failed_in_a_row = 0;
        }
        output.flight = Flight::Landed;
        // What was given up lies before this flip; measured from long ago the wrapped counter would call it the future.
        output.gave_up_at = output.gave_up_at.map(|_| vblank);
        self.tries = 0;
        self.cable.lights(self.settings.now);
        self.notices.push_back(Event::Flip { vblank, at });
    }

    fn happened(&mut self, happening: Happening) {
        let output = match (&happening, &mut self.phase) {
            (Happening::SwitchAway, _) => return self.leave_console(),
            (Happening::SwitchBack, _) => return self.return_to_console(),
            (Happening::Hotplug, Phase::Dark { retry }) => {
                *retry = self.cable.not_before((self.settings.now)());
                return;
            }
            (_, Phase::Asleep | Phase::Dark { .. }) => return,
            (_, Phase::Up(output)) => output,
        };
        match happening {
            Happening::Flip { vblank, .. } if output.gave_up(vblank) => {
                tracing::debug!("a flip event came after it was given up");
            }
            Happening::Flip { vblank, at } if matches!(output.flight, Flight::Flying { .. }) => match output.beat {
                None => self.landed(vblank, at),
                Some(beat) => {
                    let next = beat.at((self.settings.now)()) + 1;
                    output.flight = Flight::Landing { vblank: Vblank(next as u32), at: beat.begins(next) };
                }
            },
            Happening::Vblank { vblank, at } => {
                if output.asked.take_if(|asked| vblank.since(asked.vblank) >= 0).is_some() {
                    self.notices.push_back(Event::Vblank { vblank, at });
                }
            }
            Happening::Flip { .. } => tracing::debug!("a flip event came that nothing waits for"),
            Happening::Hotplug => self.probe(),
            Happening::Probed(connector) => self.probed(*connector),
            Happening::ProbeFailed(errno) => self.card_failed(&errno.into()),
            Happening::SwitchAway | Happening::SwitchBack => {}
        }
    }
}

impl<K: Kms> Screen for KmsScreen<K> {
    fn lit(&self) -> Option<Lit> {
        let Phase::Up(output) = &self.phase else { return None };
        let (width, height) = mode_size(&output.plan.way.mode);
        Some(Lit {
            screen: format!("kms:{} {}", self.kms.name(), output.plan.connector),
            mode: format!("{width}x{height}@{}", output.plan.refresh),
            size: (width, height),
            format: output.plan.way.format.format.name().to_owned(),
            refresh: output.plan.refresh,
            notes: output.plan.unmet.clone(),
        })
    }

    fn stage(&mut self, picture: &Picture<'_>) -> Result<(), ScreenError> {
        let Phase::Up(output) = &mut self.phase else { return Ok(()) };
        let output = self.coming.as_mut().unwrap_or(output);
        picture.check(LARGEST_PICTURE)?;
        let Some(Painted { buffer, area: held }) = output.ring.stage() else { return Ok(()) };
        let way = &output.plan.way;
        let area = way.area((picture.width, picture.height), buffer.layout.size);
        // Around a picture that covers it all there is nothing to blacken.
        let has_border = held.replace(area) != Some(area) && (area.width, area.height) != buffer.layout.size;
        let (rotation, thousandths) = (way.copy_rotation, output.dimming.of_samples());
        let fitting = Fitting { rotation, size: (area.width, area.height), thousandths };
        let fitted = self.fitter.fit(picture, fitting);
        let written = self.kms.write(buffer.source, &mut |bytes| {
            if has_border {
                blacken(bytes, &buffer.layout);
            }
            paint(bytes, &buffer.layout, (area.left, area.top), &fitted);
        });
        if let Err(error) = written {
            tracing::debug!(%error, "cannot write a scan-out buffer");
        }
        Ok(())
    }

    fn commit(&mut self) {
        self.change_over();
        let Phase::Up(output) = &mut self.phase else { return };
        if output.flight != Flight::Landed || output.ring.commit().is_none() {
            return;
        }
        if output.lit {
            self.submit(None);
        } else {
            let now = (self.settings.now)();
            output.flight = Flight::Lighting { next: now, since: now };
        }
    }

    fn fit(&mut self, size: (u32, u32), fps: Rate) {
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
        if let Some(beat) = output.beat {
            output.asked = Some(Asked { vblank, deadline: beat.begins(beat.unwrapped(vblank, now)) });
            return;
        }
        let crtc = output.plan.crtc;
        let ahead = vblank.since(self.told).max(0);
        let wait = period * ahead.cast_unsigned() + ladder::patience(period);
        output.asked = Some(Asked { vblank, deadline: now.after(wait.as_nanos() as u64) });
        if let Err(error) = self.kms.ask_vblank(crtc, vblank) {
            tracing::debug!(%error, "cannot ask for a vblank event");
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
            // Once around: a system call where there is no vDSO.
            let now = self.now();
            let end = *end.get_or_insert(now.after(u64::try_from(timeout.as_nanos()).unwrap_or(u64::MAX)));
            self.act(now);
            if !self.notices.is_empty() {
                continue;
            }
            let until = self.wake().map_or(end, |wake| wake.min(end));
            match self.kms.wait(Duration::from_nanos(until.since(now))) {
                Ok(Some(happening)) => self.happened(happening),
                Ok(None) if self.now() >= end => return Event::Idle,
                Ok(None) => {}
                Err(error) => self.card_failed(&error),
            }
        }
    }
}
