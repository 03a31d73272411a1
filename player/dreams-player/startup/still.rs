//! The last resort: a still picture on the screen, while the player cannot run.
//!
//! Owns a screen, a drawn picture, and the messages to systemd. Opens no flock and no decoder, so that their faults do
//! not matter here; the only file that it reads is the owner's settings of the display. Never ends by itself: it waits
//! for a screen that is not there.
//!
//! Start at [`hold`].

use crate::fatal::Fatal;
use crate::settings::{Config, ScreenChoice};
use crate::startup::handover;
use crate::startup::screen_opening;
use crate::startup::signals::{stop_on_signals, watchdog_interval};
use crate::stream::{FaultCard, StreamFormat};
use diagnostics::chain;
use screen::{Event, OutputSettings, Screen, ScreenError};
use sd_notify::NotifyState;
use settings::Owner;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;
use timing::Rate;
use tracing::{info, warn};

/// The size that the picture is drawn in: it is scaled to any screen.
const SIZE: (u32, u32) = (1280, 720);
const FPS: u64 = 30;
/// The longest wait for one event of the screen.
const QUIET: Duration = Duration::from_millis(250);
/// The time between two attempts to open a screen.
const PAUSE: Duration = Duration::from_secs(2);

/// Lights a still picture and holds it until a signal ends it.
/// Errors: [`Fatal`], if signals cannot be received.
pub(crate) fn hold(config: &Config) -> Result<(), Fatal> {
    let stop = stop_on_signals()?;
    let often = watchdog_interval().unwrap_or(Duration::from_secs(1));
    let output = Owner::kept(&config.owner).output();
    let Some(screen) = awaited(&config.screen, &output, &stop) else { return Ok(()) };
    info!("showing a still picture until the player runs again");
    keep(screen, &FaultCard::draw(SIZE), often, &stop, &|state| sd_notify::notify(&[state]).unwrap_or_default());
    Ok(())
}

/// The screen, as soon as there is one; `None` if a signal comes before.
fn awaited(choice: &ScreenChoice, output: &OutputSettings, stop: &AtomicBool) -> Option<Box<dyn Screen>> {
    let fps = Rate::new(FPS, 1).expect("30 Hz is a rate");
    let mut is_told = false;
    while !stop.load(Ordering::Relaxed) {
        let handed = handover::take(handover::SOCKET.as_ref()).map(|handed| handed.card);
        match screen_opening::screen(choice, StreamFormat { fps, size: SIZE, free: false }, output.clone(), handed) {
            Ok(screen) => return Some(screen),
            Err(error) if !is_told => warn!(error = chain(&error), "cannot open a screen, trying again"),
            Err(_) => {}
        }
        is_told = true;
        thread::park_timeout(PAUSE);
    }
    None
}

/// Holds the picture on the screen. Its first flip is READY; every `often` it is lit once more, which feeds the watchdog.
fn keep(
    mut screen: Box<dyn Screen>,
    picture: &FaultCard,
    often: Duration,
    stop: &AtomicBool,
    tell: &dyn Fn(NotifyState<'_>),
) {
    let mut is_ready = false;
    let mut is_away = screen.info().is_none();
    light(&mut *screen, picture);
    let mut quiet = Duration::ZERO;
    while !stop.load(Ordering::Relaxed) {
        match screen.next_event(QUIET) {
            Event::Flip { .. } => {
                tell(if is_ready { NotifyState::Watchdog } else { NotifyState::Ready });
                (is_ready, quiet) = (true, Duration::ZERO);
            }
            Event::Back => {
                is_away = false;
                light(&mut *screen, picture);
            }
            Event::Recovered { .. } => light(&mut *screen, picture),
            Event::Lost { .. } => is_away = true,
            Event::Vblank { .. } | Event::Asleep | Event::Changed => {}
            Event::Idle => quiet += QUIET,
        }
        if quiet >= often {
            quiet = Duration::ZERO;
            if is_away && is_ready {
                // The process works; it is the screen that is missing.
                tell(NotifyState::Watchdog);
            }
            light(&mut *screen, picture);
        }
    }
    tell(NotifyState::Stopping);
}

fn light(screen: &mut dyn Screen, picture: &FaultCard) {
    match screen.stage(&picture.picture()) {
        Ok(()) => screen.commit(),
        Err(error @ (ScreenError::Size { .. } | ScreenError::Open { .. })) => {
            warn!(error = chain(&error), "cannot show the still picture");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{FaultCard, NotifyState, keep};
    use screen::{Event, Light, OutputSettings, Picture, Screen, ScreenError, ScreenInfo};
    use std::cell::RefCell;
    use std::collections::VecDeque;
    use std::rc::Rc;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::Duration;
    use timing::{Nanos, Rate, Vblank};

    /// A screen that tells what is written down for it, and raises `stop` after that.
    struct Scripted {
        events: VecDeque<Event>,
        /// How many events had been told when a picture was lit.
        lit_after: Rc<RefCell<Vec<usize>>>,
        told: usize,
        stop: Arc<AtomicBool>,
    }

    impl Screen for Scripted {
        fn info(&self) -> Option<ScreenInfo> {
            None
        }

        fn stage(&mut self, _: &Picture<'_>) -> Result<(), ScreenError> {
            Ok(())
        }

        fn commit(&mut self) {
            self.lit_after.borrow_mut().push(self.told);
        }

        fn notify_at(&mut self, _: Vblank) {}

        fn set_format(&mut self, _: (u32, u32), _: Rate) {}

        fn set_light(&mut self, _: Light) {}

        fn set_output(&mut self, _: &OutputSettings) {}

        fn next_event(&mut self, _: Duration) -> Event {
            self.told += 1;
            let event = self.events.pop_front().unwrap_or(Event::Idle);
            self.stop.store(self.events.is_empty(), Ordering::Relaxed);
            event
        }
    }

    #[test]
    fn a_still_picture_is_lit_again_whenever_that_may_help_and_the_watchdog_hears_of_it() {
        let flip = || Event::Flip { vblank: Vblank(1), at: Nanos(0) };
        let reason = String::new;
        let (lost, back) = (Event::Lost { reason: reason() }, Event::Back);
        let idle = [const { Event::Idle }; 4];
        let mut events = VecDeque::from([back.clone(), flip(), Event::Recovered { reason: reason() }, flip()]);
        events.extend(idle.clone()); // A second: lit once more.
        events.extend([flip(), lost]);
        events.extend(idle); // A second in the dark.
        events.extend([back, flip()]);
        let (lit_after, stop) = (Rc::default(), Arc::new(AtomicBool::new(false)));
        let screen = Scripted { events, lit_after: Rc::clone(&lit_after), told: 0, stop: Arc::clone(&stop) };
        let heard = RefCell::new(Vec::new());
        let tell = |state: NotifyState<'_>| heard.borrow_mut().push(state.to_string());
        keep(Box::new(screen), &FaultCard::draw((64, 48)), Duration::from_secs(1), &stop, &tell);
        assert_eq!(*lit_after.borrow(), [0, 1, 3, 8, 14, 15]);
        let fed = "WATCHDOG=1";
        assert_eq!(*heard.borrow(), ["READY=1", fed, fed, fed, fed, "STOPPING=1"]);
    }
}
