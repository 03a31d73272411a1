//! Which screen to light.
//!
//! Owns the choice between a KMS display and the virtual screen. Never drives it: `presenter.rs` does.

use crate::settings::ScreenChoice;
use crate::stream::StreamFormat;
use diagnostics::chain;
use player::now;
use screen::{Display, FdStore, KmsSettings, OutputSettings, Screen, ScreenError, VirtualScreen, is_card};
use sd_notify::NotifyState;
use std::os::fd::{AsFd, BorrowedFd, IntoRawFd, OwnedFd};
use std::path::PathBuf;
use timing::Rate;
use tracing::{info, warn};

/// The refresh of a virtual screen without a mode of its own.
const REFRESH_HZ: u64 = 60;
/// The name of the DRM card in the file descriptor store of systemd.
const FD_NAME: &str = "card";

/// Opens the screen that was asked for, driven as `output` says. A display asked for by name may be dark for now: it is
/// waited for. A free clock always means the virtual screen, since no display has such a clock.
/// Errors: [`ScreenError`], if it was asked for by name and cannot be opened.
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
        Ok(screen) if screen.info().is_some() => Some(Box::new(screen)),
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

/// The settings of a display, and where its DRM card is stored.
pub(crate) fn settings(
    device: Option<PathBuf>,
    format: StreamFormat,
    output: OutputSettings,
    keeper: FdStore,
) -> KmsSettings {
    KmsSettings { device, size: format.size, fps: format.fps, now, keeper, output }
}

/// The file descriptor store of systemd (`FileDescriptorStoreMax=`), where there is one: when the player dies, the last
/// frame stays lit until the next start lights another. A card that the prelude `handed` over is stored there from now
/// on.
fn keeper(handed: Option<OwnedFd>) -> FdStore {
    let handed = handed.filter(is_card).map(|card| {
        keep(Some(card.as_fd()));
        card.into_raw_fd()
    });
    let kept = sd_notify::listen_fds_with_names().ok().into_iter().flatten();
    let kept = kept.filter(|(_, name)| name == FD_NAME).map(|(number, _)| number).last();
    FdStore { kept: kept.or(handed), keep }
}

fn keep(card: Option<BorrowedFd<'_>>) {
    let told = match card {
        Some(card) => sd_notify::notify_with_fds(&[NotifyState::FdStore, NotifyState::FdName(FD_NAME)], &[card]),
        None => sd_notify::notify(&[NotifyState::FdStoreRemove, NotifyState::FdName(FD_NAME)]),
    };
    if let Err(error) = told {
        warn!(error = chain(&error), "cannot store the DRM fd with systemd: the screen goes dark if the player dies");
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
