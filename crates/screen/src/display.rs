//! The display of this machine: a KMS card's, or the firmware's framebuffer while no driver has come.
//!
//! Owns which of the two shows the picture. The framebuffer is what is there before a driver comes, and for ever where none
//! does. Once a card can light something it takes the picture over; a card that is there and dark leaves it to the framebuffer
//! meanwhile.
//!
//! Start at [`Display::open`].

use crate::firmware_screen::FirmwareScreen;
use crate::kms::Uevents;
use crate::{Event, Keeper, KmsScreen, KmsSettings, Light, Lit, OutputSettings, Picture, Screen, ScreenError};
use rustix::fs::{fstat, major};
use std::os::fd::OwnedFd;
use std::time::Duration;
use timing::{Nanos, Rate, Vblank};

/// How often a card is looked for after something has come or gone, and for how long: a driver takes its time.
const SOON: Duration = Duration::from_millis(100);
const FOR: Duration = Duration::from_secs(10);
/// How often otherwise.
const SELDOM: Duration = Duration::from_secs(10);

/// The major number of the nodes of KMS cards.
const CARDS: u32 = 226;

/// Whether this is an open node of a KMS card: its picture goes with the last descriptor. The framebuffer's stays.
pub fn is_card(device: &OwnedFd) -> bool {
    fstat(device).is_ok_and(|status| major(status.st_rdev) == CARDS)
}

/// The display of this machine.
pub struct Display {
    device: Device,
    /// That a card has taken over is told by two events, of which this is the second.
    is_back: bool,
}

enum Device {
    /// A card shows the picture, or waits for its display.
    Card(Box<KmsScreen>),
    /// The firmware's framebuffer shows it.
    Firmware(Box<Waiting>),
}

/// The firmware's framebuffer, and what it waits for.
struct Waiting {
    firmware: FirmwareScreen,
    /// What a card would be opened with.
    settings: KmsSettings,
    light: Light,
    uevents: Option<Uevents>,
    /// When a card is looked for next, and until when that is soon.
    look: Nanos,
    soon_until: Nanos,
}

impl Display {
    /// The card that was asked for; without such a wish, the first that can light something, else the firmware's framebuffer.
    ///
    /// # Errors
    /// [`ScreenError::Open`] if there is neither.
    pub fn open(settings: KmsSettings) -> Result<Self, ScreenError> {
        let card = match KmsScreen::open(settings.clone()) {
            Ok(card) if card.lit().is_some() => return Ok(Self::on(Device::Card(Box::new(card)))),
            card => card,
        };
        let firmware = match settings.device {
            None => FirmwareScreen::open(settings.size, settings.now, &settings.output),
            Some(_) => None,
        };
        let Some(firmware) = firmware else { return card.map(|card| Self::on(Device::Card(Box::new(card)))) };
        tracing::info!("no driver lights a display: the picture goes to the firmware's framebuffer");
        let now = (settings.now)();
        Ok(Self::on(Device::Firmware(Box::new(Waiting {
            firmware,
            // A descriptor that was kept has been tried, and is closed.
            settings: KmsSettings { keeper: Keeper { kept: None, ..settings.keeper }, ..settings },
            light: Light::FULL,
            uevents: Uevents::subscribe().ok(),
            look: now,
            soon_until: now.after(FOR.as_nanos() as u64),
        }))))
    }

    fn on(device: Device) -> Self {
        Self { device, is_back: false }
    }

    /// Leaves the device with what is on its glass to whoever gets it from the caller; `None` if it is not open.
    pub fn bequeath(self) -> Option<OwnedFd> {
        match self.device {
            Device::Card(card) => card.bequeath(),
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
    /// A card that can light something now, if it is time to look for one.
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
        let mut card = KmsScreen::open(self.settings.clone()).ok().filter(|card| card.lit().is_some())?;
        card.set_light(self.light);
        self.firmware.leave_console_to_the_card();
        Some(card)
    }
}

impl Screen for Display {
    fn lit(&self) -> Option<Lit> {
        self.screen().lit()
    }

    fn stage(&mut self, picture: &Picture<'_>) -> Result<(), ScreenError> {
        self.screen_mut().stage(picture)
    }

    fn commit(&mut self) {
        self.screen_mut().commit();
    }

    fn fit(&mut self, size: (u32, u32), fps: Rate) {
        if let Device::Firmware(waiting) = &mut self.device {
            (waiting.settings.size, waiting.settings.fps) = (size, fps);
        }
        self.screen_mut().fit(size, fps);
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
            return Event::Lost { reason: "the display's own driver has come, and takes the picture over".to_owned() };
        }
        waiting.firmware.next_event(timeout.min(SOON))
    }
}
