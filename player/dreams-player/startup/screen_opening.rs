//! Which screen to light.
//!
//! Owns the choice between a KMS display and the virtual screen. Never drives it: `presenter.rs` does.

use crate::settings::choices::ScreenChoice;
use crate::stream::format::StreamFormat;
use player::ending::chain;
use player::now::now;
use screen::{Display, Keeper, KmsSettings, OutputSettings, Screen, ScreenError, VirtualScreen, is_card};
use sd_notify::NotifyState;
use std::os::fd::{AsFd, BorrowedFd, IntoRawFd, OwnedFd};
use std::path::PathBuf;
use timing::Rate;
use tracing::{info, warn};

/// The refresh of a virtual screen that nobody described.
const REFRESH_HZ: u64 = 60;
/// What the card is called that systemd keeps for us.
const KEPT: &str = "card";

/// Takes the screen that was asked for, to be driven as `output` says. A display asked for by name may be dark for now: it is waited for. With a
/// free clock any screen is the virtual one, since no display has such a clock.
///
/// # Errors
/// [`ScreenError`], if it was asked for by name and cannot be had.
pub(crate) fn screen(
    choice: &ScreenChoice,
    format: StreamFormat,
    output: OutputSettings,
    handed: Option<OwnedFd>,
) -> Result<Box<dyn Screen>, ScreenError> {
    match choice {
        ScreenChoice::Auto if format.free => Ok(virtual_screen(None, format)),
        ScreenChoice::Auto => Ok(display(format, output, handed).unwrap_or_else(|| virtual_screen(None, format))),
        ScreenChoice::Kms(device) => {
            Ok(Box::new(Display::open(settings(device.clone(), format, output, keeper(handed)))?))
        }
        ScreenChoice::Virtual(mode) => Ok(virtual_screen(*mode, format)),
    }
}

/// A display that can be lit now.
fn display(format: StreamFormat, output: OutputSettings, handed: Option<OwnedFd>) -> Option<Box<dyn Screen>> {
    match Display::open(settings(None, format, output, keeper(handed))) {
        Ok(screen) if screen.lit().is_some() => Some(Box::new(screen)),
        Ok(_) => {
            info!("no display can be lit now; `--screen kms` waits for one");
            None
        }
        Err(error) => {
            info!(error = chain(&error), "there is no display");
            None
        }
    }
}

/// What a display is to show, and who keeps it.
pub(crate) fn settings(
    device: Option<PathBuf>,
    format: StreamFormat,
    output: OutputSettings,
    keeper: Keeper,
) -> KmsSettings {
    KmsSettings { device, size: format.size, fps: format.fps, now, keeper, output }
}

/// systemd, if it has started us and keeps descriptors (`FileDescriptorStoreMax=`): whatever becomes of us, the last frame
/// stays until its next start of us lights another. It keeps a card that was `handed` to us from now on.
fn keeper(handed: Option<OwnedFd>) -> Keeper {
    let handed = handed.filter(is_card).map(|card| {
        keep(Some(card.as_fd()));
        card.into_raw_fd()
    });
    let kept = sd_notify::listen_fds_with_names().ok().into_iter().flatten();
    let kept = kept.filter(|(_, name)| name == KEPT).map(|(number, _)| number).last();
    Keeper { kept: kept.or(handed), keep }
}

fn keep(card: Option<BorrowedFd<'_>>) {
    let told = match card {
        Some(card) => sd_notify::notify_with_fds(&[NotifyState::FdStore, NotifyState::FdName(KEPT)], &[card]),
        None => sd_notify::notify(&[NotifyState::FdStoreRemove, NotifyState::FdName(KEPT)]),
    };
    if let Err(error) = told {
        warn!(error = chain(&error), "nobody keeps the picture where the player falls");
    }
}

fn virtual_screen(mode: Option<((u32, u32), Rate)>, format: StreamFormat) -> Box<dyn Screen> {
    let pace = if format.free { screen::Pace::Free } else { screen::Pace::Timer };
    let to_measure = || {
        let refresh = Rate::new(REFRESH_HZ, 1).expect("60 Hz is a rate");
        VirtualScreen::new(format.size, refresh, pace, now).to_measure()
    };
    Box::new(mode.map_or_else(to_measure, |(size, refresh)| VirtualScreen::new(size, refresh, pace, now)))
}
