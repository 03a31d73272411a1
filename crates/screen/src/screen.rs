//! The one interface between the player and whatever is lit.
//!
//! Owns the [`Screen`] trait and its events. Never decides when a frame is due: the player's cadence does.
//! Implementations: `kms/` (a real display) and `virtual_screen.rs` (a picture in memory).

use crate::{OutputSettings, Picture};
use std::time::Duration;
use timing::{Nanos, Rate, Vblank};

/// What is lit, and how.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lit {
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
    /// What people on site are to be told of it, each as a sentence: what the screen does not do as its owner has set it.
    pub notes: Vec<String>,
}

/// How bright a screen is to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// Not at all: the display sleeps, and draws the power of a display that sleeps.
    Off,
    /// As bright as so many thousandths of every sample make it, 1000 at most. A screen that cannot be dimmed has all.
    On {
        /// Of each sample, after everything else.
        thousandths: u16,
    },
}

impl Light {
    /// As the picture is.
    pub const FULL: Self = Self::On { thousandths: 1000 };
}

/// What a screen tells its player.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// The committed picture is on the glass since `vblank`, which began at `at`.
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
    /// The screen is dark or gone (unplugged, another master, device removed). Pending flips will not come.
    /// Keep calling [`Screen::next_event`]: it works towards [`Event::Back`] by itself.
    Lost {
        /// One sentence for the log: what was seen.
        reason: String,
    },
    /// The display sleeps, as [`Light::Off`] has asked. Pending flips will not come; after a [`Light::On`] comes
    /// [`Event::Back`], or [`Event::Lost`] if there is nothing to light by then.
    Asleep,
    /// There is a mode again; [`Screen::lit`] tells it. Nothing is lit until the next [`Screen::commit`]: re-stage.
    Back,
    /// A flip or vblank event was lost or a commit failed for a while; the screen repaired itself and the picture
    /// stands. No event is pending any more: commit again, whether or not there is something new to stage. Reported
    /// so that it can be counted.
    Recovered {
        /// One sentence for the log: what was seen and which rung of the ladder helped.
        reason: String,
    },
    /// Another way of lighting pictures takes the place of the one before, with the next [`Event::Flip`]: pictures of another
    /// form, other settings of the owner, a better mode. [`Screen::lit`] tells it.
    Changed,
    /// Nothing happened within the timeout.
    Idle,
}

/// Why a screen cannot go on. Everything that time or a cable can mend is an [`Event`] instead.
#[derive(Debug, thiserror::Error)]
pub enum ScreenError {
    /// No such device, or it is no KMS device.
    #[error("cannot open screen `{device}`")]
    Open {
        /// As the user gave it.
        device: String,
        /// What the kernel said.
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
    /// What is lit; `None` while there is nothing to light (unplugged, not master).
    fn lit(&self) -> Option<Lit>;

    /// Copies `picture` into the free back buffer, so that [`Screen::commit`] is quick. Staging again before a commit
    /// replaces what was staged. Without effect while nothing is lit.
    ///
    /// # Errors
    /// [`ScreenError::Size`]. What is lit stays lit.
    fn stage(&mut self, picture: &Picture<'_>) -> Result<(), ScreenError>;

    /// Sends the staged picture to the glass at the next vblank; [`Event::Flip`] tells its arrival. With nothing staged
    /// it lights the same picture again. At most one commit is in flight: a second before its flip is ignored, and
    /// what is staged stays staged. Without effect while nothing is lit.
    fn commit(&mut self);

    /// From the next picture that is staged on, pictures are of `size` and come at `fps`: they go over to the glass as every
    /// other, and a mode is set only where another one is better for them.
    fn fit(&mut self, size: (u32, u32), fps: Rate);

    /// Makes it as bright as `light` from the next flip on, or lets it sleep from the next [`Screen::next_event`] on. It is
    /// [`Light::FULL`] until this is called, and stays as it was told across whatever happens.
    fn set_light(&mut self, light: Light);

    /// Goes by other settings of the display's owner, as soon as it can. What it cannot do as they say, it does otherwise, and
    /// [`Lit::notes`] tells.
    fn set_output(&mut self, output: &OutputSettings);

    /// Asks for an [`Event::Vblank`] at `vblank`, or at once if that is past; a later call replaces it. Without effect
    /// while nothing is lit, and before the first flip.
    fn notify_at(&mut self, vblank: Vblank);

    /// Waits for the next event, at most `timeout`. Repairs, and modes being set, are done in here and may take longer.
    fn next_event(&mut self, timeout: Duration) -> Event;
}
