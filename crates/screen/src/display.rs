//! The display of this machine: a KMS card's, or the firmware's framebuffer while no driver is loaded.
//!
//! Owns the choice between the two. The framebuffer is used before a driver is loaded, and always where there is none.
//! A card takes over as soon as it can light a display.
//!
//! Start at [`Display::open`].

use crate::firmware_screen::FirmwareScreen;
use crate::kms::Uevents;
use crate::{Event, FdStore, KmsScreen, KmsSettings, Light, OutputSettings, Picture, Screen, ScreenError, ScreenInfo};
use rustix::fs::{fstat, major};
use std::os::fd::OwnedFd;
use std::time::Duration;
use timing::{Nanos, Rate, Vblank};

/// How often a card is looked for after a hot-plug event, and for how long: drivers load slowly.
const SOON: Duration = Duration::from_millis(100);
const FOR: Duration = Duration::from_secs(10);
/// How often otherwise.
const SELDOM: Duration = Duration::from_secs(10);

/// The major number of the nodes of KMS cards.
const CARDS: u32 = 226;

/// Whether this is an open node of a KMS card, whose picture disappears when its last descriptor is closed. That of the
/// framebuffer stays.
pub fn is_card(device: &OwnedFd) -> bool {
    fstat(device).is_ok_and(|status| major(status.st_rdev) == CARDS)
}

/// The display of this machine.
pub struct Display {
    device: Device,
    /// A card's take-over is reported by two events, of which this is the second.
    is_back: bool,
}

enum Device {
    /// A card shows the picture, or waits for its display.
    Card(Box<KmsScreen>),
    /// The firmware's framebuffer shows it.
    Firmware(Box<Waiting>),
}

/// The firmware's framebuffer, and the card that it waits for.
struct Waiting {
    firmware: FirmwareScreen,
    /// The settings to open a card.
    settings: KmsSettings,
    light: Light,
    uevents: Option<Uevents>,
    /// When a card is looked for next, and until when the interval is short.
    look: Nanos,
    soon_until: Nanos,
}

impl Display {
    /// Opens the card in the settings; without one, the first that can light a display, else the firmware's framebuffer.
    ///
    /// # Errors
    /// [`ScreenError::Open`] if there is neither.
    pub fn open(settings: KmsSettings) -> Result<Self, ScreenError> {
        let card = match KmsScreen::open(settings.clone()) {
            Ok(card) if card.info().is_some() => return Ok(Self::on(Device::Card(Box::new(card)))),
            card => card,
        };
        let firmware = match settings.device {
            None => FirmwareScreen::open(settings.size, settings.now, &settings.output),
            Some(_) => None,
        };
        let Some(firmware) = firmware else { return card.map(|card| Self::on(Device::Card(Box::new(card)))) };
        tracing::info!("no DRM driver for a display, using the firmware framebuffer");
        let now = (settings.now)();
        Ok(Self::on(Device::Firmware(Box::new(Waiting {
            firmware,
            // A stored descriptor was tried already, and is closed.
            settings: KmsSettings { keeper: FdStore { kept: None, ..settings.keeper }, ..settings },
            light: Light::FULL,
            uevents: Uevents::subscribe().ok(),
            look: now,
            soon_until: now.after(FOR.as_nanos() as u64),
        }))))
    }

    fn on(device: Device) -> Self {
        Self { device, is_back: false }
    }

    /// The device with its picture, to hand over to another process; `None` if it is not open.
    pub fn into_fd(self) -> Option<OwnedFd> {
        match self.device {
            Device::Card(card) => card.into_fd(),
            Device::Firmware(waiting) => Some(waiting.firmware.into_fd()),
        }
    }

    fn screen(&self) -> &dyn Screen {
        match &self.device {
            Device::Card(card) => &**card,
            Device::Firmware(waiting) => &waiting.firmware,
        }
    }

    fn screen_mut(&mut self) -> &mut dyn Screen {
        match &mut self.device {
            Device::Card(card) => &mut **card,
            Device::Firmware(waiting) => &mut waiting.firmware,
        }
    }
}

impl Waiting {
    /// A card that can light a display now, if it is time to look for one.
    fn card(&mut self) -> Option<KmsScreen> {
        let now = (self.settings.now)();
        if self.uevents.as_mut().is_some_and(Uevents::display_changed) {
            (self.look, self.soon_until) = (now, now.after(FOR.as_nanos() as u64));
        }
        if now < self.look {
            return None;
        }
        let is_soon = now < self.soon_until || self.firmware.is_gone();
        self.look = now.after(if is_soon { SOON } else { SELDOM }.as_nanos() as u64);
        let mut card = KmsScreen::open(self.settings.clone()).ok().filter(|card| card.info().is_some())?;
        card.set_light(self.light);
        self.firmware.leave_console_to_the_card();
        Some(card)
    }
}

impl Screen for Display {
    fn info(&self) -> Option<ScreenInfo> {
        self.screen().info()
    }

    fn stage(&mut self, picture: &Picture<'_>) -> Result<(), ScreenError> {
        self.screen_mut().stage(picture)
    }

    fn commit(&mut self) {
        self.screen_mut().commit();
    }

    fn set_format(&mut self, size: (u32, u32), fps: Rate) {
        if let Device::Firmware(waiting) = &mut self.device {
            (waiting.settings.size, waiting.settings.fps) = (size, fps);
        }
        self.screen_mut().set_format(size, fps);
    }

    fn set_light(&mut self, light: Light) {
        if let Device::Firmware(waiting) = &mut self.device {
            waiting.light = light;
        }
        self.screen_mut().set_light(light);
    }

    fn set_output(&mut self, output: &OutputSettings) {
        if let Device::Firmware(waiting) = &mut self.device {
            waiting.settings.output = output.clone();
        }
        self.screen_mut().set_output(output);
    }

    fn notify_at(&mut self, vblank: Vblank) {
        self.screen_mut().notify_at(vblank);
    }

    fn next_event(&mut self, timeout: Duration) -> Event {
        if std::mem::take(&mut self.is_back) {
            return Event::Back;
        }
        let waiting = match &mut self.device {
            Device::Card(card) => return card.next_event(timeout),
            Device::Firmware(waiting) => waiting,
        };
        if let Some(card) = waiting.card() {
            (self.device, self.is_back) = (Device::Card(Box::new(card)), true);
            return Event::Lost {
                reason: "the display's DRM driver was loaded, switching from the firmware framebuffer to it".to_owned(),
            };
        }
        waiting.firmware.next_event(timeout.min(SOON))
    }
}
