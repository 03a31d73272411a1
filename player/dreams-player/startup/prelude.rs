//! The prelude: the first picture of the path, on the glass before anything else of the unit is up.
//!
//! Lights the picture that the player would begin with, holds it, and hands DRM card and place over to the player. Plays
//! nothing, saves no place, begins no trial. On any error it ends: the player handles that.
//!
//! Start at [`play`]; `dreams-early` in `image-build/system` runs it.

use crate::control::BrightnessControl;
use crate::fatal::Fatal;
use crate::recording::saved_place;
use crate::settings::{Config, ScreenChoice};
use crate::startup::handover;
use crate::startup::screen_opening;
use crate::stream::{Generation, Pixels, StreamFormat, path};
use diagnostics::Exit;
use flock::Place;
use player::{ClockReader, threads};
use screen::{Display, Event, FdStore, Light, OutputSettings, Screen, ScreenError};
use settings::hours::Lighting;
use std::io::{self, Write};
use std::os::fd::{AsFd, OwnedFd};
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;
use tracing::info;

/// How long the player waits for the prelude. A prelude without a picture by then ends and closes the DRM card.
const PATIENCE: Duration = Duration::from_secs(15);
/// The longest wait for one event of the screen.
const QUIET: Duration = Duration::from_millis(250);

/// Lights the first picture, says so on standard output, and holds it until the player takes it over.
/// Errors: [`Fatal`], if there is no such picture or no screen, or the socket cannot be made.
pub(crate) fn play(config: &Config) -> Result<(), Fatal> {
    let is_lit = Arc::new(AtomicBool::new(false));
    end_in_time(Arc::clone(&is_lit))?;
    let mut control = BrightnessControl::new(config.day(), &config.owner);
    let Lighting::On { thousandths } = control.look(ClockReader::of_machine().read().known_s()) else {
        info!("outside the configured hours: the prelude lights nothing");
        return Ok(());
    };
    let light = Light::On { thousandths };
    let (place, pixels, format) = begin(config)?;
    let Some(card) = lit(&config.screen, format, control.output(), &pixels, light)? else {
        info!("no display can be lit now");
        return Ok(());
    };
    is_lit.store(true, Ordering::Relaxed);
    // The process that started us may have closed its end.
    let tell = || drop(io::stdout().write_all(b"lit\n"));
    handover::give(handover::SOCKET.as_ref(), card.as_fd(), &place.to_bytes(), tell)
        .map_err(|source| Fatal::HandOver { socket: handover::SOCKET, source })
}

fn end_in_time(is_lit: Arc<AtomicBool>) -> Result<(), Fatal> {
    let wait = move || {
        thread::park_timeout(PATIENCE);
        if !is_lit.load(Ordering::Relaxed) {
            process::exit(Exit::Unreadable as i32);
        }
    };
    Ok(threads::start("deadline", wait).map(drop)?)
}

/// What the player would begin with, and where in the path that is.
fn begin(config: &Config) -> Result<(Place, Pixels, StreamFormat), Fatal> {
    let generation = Generation::open_or(&config.flock, &config.spare)?;
    let kept = saved_place(&config.state).and_then(|bytes| Place::from_bytes(&bytes).ok());
    let flock = &generation.flock;
    let leg = path(flock, kept, config.seed).next_leg();
    let picture = leg.and_then(|leg| {
        let file = leg.clip.path.inside(&generation.folder);
        let clip = video::Clip::open(&file, &generation.form(), leg.clip.frames).ok()?;
        Some((leg.place, Pixels::Decoded(video::first_frame(&clip)?)))
    });
    let (place, pixels) = picture.ok_or_else(|| Fatal::NothingToPlay { flock: config.flock.clone() })?;
    Ok((place, pixels, StreamFormat::of(flock, false)))
}

/// The DRM card that shows the picture; `None` where no display can be lit.
fn lit(
    choice: &ScreenChoice,
    format: StreamFormat,
    output: &OutputSettings,
    pixels: &Pixels,
    light: Light,
) -> Result<Option<OwnedFd>, ScreenError> {
    let device = match choice {
        ScreenChoice::Kms(device) => device.clone(),
        ScreenChoice::Auto => None,
        ScreenChoice::Virtual(_) => return Ok(None),
    };
    let mut screen = Display::open(screen_opening::settings(device, format, output.clone(), FdStore::NOBODY))?;
    screen.set_light(light);
    if screen.info().is_none() {
        return Ok(None);
    }
    screen.stage(&pixels.picture())?;
    screen.commit();
    loop {
        match screen.next_event(QUIET) {
            Event::Flip { .. } => return Ok(screen.into_fd()),
            Event::Lost { .. } | Event::Asleep => return Ok(None),
            Event::Vblank { .. } | Event::Back | Event::Changed | Event::Recovered { .. } | Event::Idle => {}
        }
    }
}
