//! The interface between the player and a screen.
//!
//! Owns the [`Screen`] trait and its events. The player's cadence decides when a frame is due. Implementations: `kms/`
//! (a real display) and `virtual_screen.rs` (a picture in memory).

use crate::{OutputSettings, Picture};
use std::path::PathBuf;
use std::time::Duration;
use timing::{Nanos, Rate, Vblank};

/// The connector, mode and format of a screen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScreenInfo {
    /// The screen's name: `kms:/dev/dri/card0 HDMI-A-1` or `virtual`.
    pub screen: String,
    /// The mode's name and exact refresh: `1280x720@60`.
    pub mode: String,
    /// Pixels across and down.
    pub size: (u32, u32),
    /// The pixel format on the plane, as its fourcc: `YU12`, `NV12` or `XR24`.
    pub format: String,
    /// Exact vblanks per second.
    pub refresh: Rate,
    /// The owner's settings that the screen does not fulfil, each as a sentence.
    pub notes: Vec<String>,
    /// What becomes less when it is dimmed.
    pub dimmed_by: DimmedBy,
    /// Where its cable is plugged in; `None` for a screen without a card.
    pub connector: Option<ConnectorId>,
}

/// A connector of a KMS card.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConnectorId {
    /// The card's device, as `/dev/dri/card0`, or a link to it.
    pub card: PathBuf,
    /// The connector's name: `HDMI-A-1`.
    pub name: String,
}

impl ConnectorId {
    /// What the kernel calls it in `/sys/class/drm`: `card0-HDMI-A-1`; `None` if the card is gone.
    pub(crate) fn folder(&self) -> Option<String> {
        let card = self.card.canonicalize().ok()?;
        Some(format!("{}-{}", card.file_name()?.to_str()?, self.name))
    }
}

/// What becomes less when a screen is dimmed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DimmedBy {
    /// The light behind the picture.
    Backlight,
    /// Nothing: brightness has no effect.
    Nothing,
    /// The signal of each sample, over black.
    Samples,
}

/// How bright a screen is to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// Off: the display is in standby.
    Off,
    /// On, with this brightness in thousandths, 1000 at most. A screen that cannot be dimmed is at full brightness.
    On {
        /// Of each sample, after everything else.
        thousandths: u16,
    },
}

impl Light {
    /// As the picture is.
    pub const FULL: Self = Self::On { thousandths: 1000 };
}

/// The events of a screen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// The committed picture is on the screen since `vblank`, which began at `at`.
    Flip {
        /// The vblank at which it arrived.
        vblank: Vblank,
        /// When that vblank began, on the kernel's monotonic clock, whose origin may not be that of the `now` that a
        /// screen was given: compare such times with each other.
        at: Nanos,
    },
    /// The vblank asked for with [`Screen::notify_at`] has begun.
    Vblank {
        /// The vblank counter now; may lie past the one asked for.
        vblank: Vblank,
        /// When it began; see [`Event::Flip`].
        at: Nanos,
    },
    /// The screen is dark or gone (unplugged, another master, device removed). Pending flips will not come. Keep
    /// calling [`Screen::next_event`], which tries to recover until [`Event::Back`].
    Lost {
        /// The cause, for the log.
        reason: String,
    },
    /// The display sleeps, as [`Light::Off`] has asked. Pending flips will not come; after [`Light::On`]
    /// [`Event::Back`] follows, or [`Event::Lost`] if there is no display by then.
    Asleep,
    /// There is a mode again, see [`Screen::info`]. Nothing is lit until the next picture is staged and committed.
    Back,
    /// A flip or vblank event was lost, or commits failed for a while; the screen has recovered and the picture stays.
    /// No event is pending any more: commit again, with or without a new picture. Reported so that it can be counted.
    Recovered {
        /// The cause and the recovery step, for the log.
        reason: String,
    },
    /// The display configuration changes with the next [`Event::Flip`]: for pictures of another size or rate, new
    /// settings of the owner, or a better mode. See [`Screen::info`].
    Changed,
    /// Nothing happened within the timeout.
    Idle,
}

/// Errors of a screen that do not pass. Those that may pass by themselves are [`Event`]s.
#[derive(Debug, thiserror::Error)]
pub enum ScreenError {
    /// No such device, or not a KMS device.
    #[error("cannot open screen `{device}`")]
    Open {
        /// As the user gave it.
        device: String,
        /// The kernel error.
        source: std::io::Error,
    },
    /// The picture's size is odd or zero, or larger than the screen can scan out.
    #[error("picture of {width}x{height} does not fit a screen of {screen_width}x{screen_height}")]
    Size {
        /// The picture's width.
        width: u32,
        /// The picture's height.
        height: u32,
        /// The screen's width.
        screen_width: u32,
        /// The screen's height.
        screen_height: u32,
    },
}

/// A surface that lights one picture per flip. One thread drives it; every call but [`Screen::next_event`]
/// returns without waiting for a vblank.
pub trait Screen {
    /// Mode and format of the screen; `None` while there is no display (unplugged, not DRM master).
    fn info(&self) -> Option<ScreenInfo>;

    /// Copies `picture` into the free back buffer, so that [`Screen::commit`] is quick. Staging again before a commit
    /// replaces what was staged. Without effect while nothing is lit.
    ///
    /// # Errors
    /// [`ScreenError::Size`]. What is lit stays lit.
    fn stage(&mut self, picture: &Picture<'_>) -> Result<(), ScreenError>;

    /// Shows the staged picture from the next vblank on; [`Event::Flip`] reports it. With nothing staged the same
    /// picture is committed again. At most one commit is in flight: a second before its flip is ignored, and what is
    /// staged stays staged. Without effect while nothing is lit.
    fn commit(&mut self);

    /// Sets size and rate of the pictures, from the next staged one on. A mode is set only if another one is better for
    /// them.
    fn set_format(&mut self, size: (u32, u32), fps: Rate);

    /// Sets the brightness from the next flip on, or switches the display off with the next [`Screen::next_event`]. The
    /// default is [`Light::FULL`]; the setting survives hot-plug and recovery.
    fn set_light(&mut self, light: Light);

    /// Applies new settings of the owner as soon as possible. Those that cannot be fulfilled are listed in
    /// [`ScreenInfo::notes`].
    fn set_output(&mut self, output: &OutputSettings);

    /// Asks for an [`Event::Vblank`] at `vblank`, or at once if that is past; a later call replaces it. Without effect
    /// while nothing is lit, and before the first flip.
    fn notify_at(&mut self, vblank: Vblank);

    /// Waits for the next event, at most `timeout`. Recovery and modesets are done here and may take longer.
    fn next_event(&mut self, timeout: Duration) -> Event;
}
