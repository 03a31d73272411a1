//! The last resort: a still picture on the screen, while the player itself cannot be had.
//!
//! Owns as little as that takes: a screen, a drawn picture, the words to systemd. Opens no flock and no decoder, so that
//! whatever is wrong with them is not wrong here; of files, only what the owner has set of the display. Never ends by itself: a screen that is not there is waited for.
//!
//! Start at [`hold`].

use crate::fatal::Fatal;
use crate::settings::choices::ScreenChoice;
use crate::settings::config::Config;
use crate::startup::handover;
use crate::startup::screen_opening;
use crate::startup::signals::{stop_on_signals, watchdog_interval};
use crate::stream::fault_card::Card;
use crate::stream::format::StreamFormat;
use player::ending::chain;
use player::owner::Owner;
use screen::{Event, OutputSettings, Screen, ScreenError};
use sd_notify::NotifyState;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;
use timing::Rate;
use tracing::{info, warn};

/// What the picture is drawn for: it is scaled to any screen.
const SIZE: (u32, u32) = (1280, 720);
const FPS: u64 = 30;
/// How long the screen may say nothing before we look up.
const QUIET: Duration = Duration::from_millis(250);
/// Between two looks for a screen that cannot be opened.
const PAUSE: Duration = Duration::from_secs(2);

/// Lights a still picture and holds it until somebody wants it to end.
///
/// # Errors
/// [`Fatal`], if it cannot hear of that.
pub(crate) fn hold(config: &Config) -> Result<(), Fatal> {
    let stop = stop_on_signals()?;
    let often = watchdog_interval().unwrap_or(Duration::from_secs(1));
    let output = Owner::kept(&config.owner).output();
    let Some(screen) = awaited(&config.screen, &output, &stop) else { return Ok(()) };
    info!("a still picture is held until the player comes back");
    keep(screen, &Card::draw(SIZE), often, &stop, &|state| sd_notify::notify(&[state]).unwrap_or_default());
    Ok(())
}

/// The screen, as soon as there is one; `None` if somebody wants it to end before.
fn awaited(choice: &ScreenChoice, output: &OutputSettings, stop: &AtomicBool) -> Option<Box<dyn Screen>> {
    let fps = Rate::new(FPS, 1).expect("30 Hz is a rate");
    let mut is_told = false;
    while !stop.load(Ordering::Relaxed) {
        let handed = handover::take().map(|handed| handed.card);
        match screen_opening::screen(choice, StreamFormat { fps, size: SIZE, free: false }, output.clone(), handed) {
            Ok(screen) => return Some(screen),
            Err(error) if !is_told => warn!(error = chain(&error), "there is no screen to be opened yet"),
            Err(_) => {}
        }
        is_told = true;
        thread::park_timeout(PAUSE);
    }
    None
}

/// Holds the picture on the screen. Ready is its first flip; `often` it is lit once more, which the watchdog is fed by.
fn keep(mut screen: Box<dyn Screen>, card: &Card, often: Duration, stop: &AtomicBool, tell: &dyn Fn(NotifyState<'_>)) {
    let mut is_ready = false;
    let mut is_away = screen.lit().is_none();
    light(&mut *screen, card);
    let mut quiet = Duration::ZERO;
    while !stop.load(Ordering::Relaxed) {
        match screen.next_event(QUIET) {
            Event::Flip { .. } => {
                tell(if is_ready { NotifyState::Watchdog } else { NotifyState::Ready });
                (is_ready, quiet) = (true, Duration::ZERO);
            }
            Event::Back => {
                is_away = false;
                light(&mut *screen, card);
            }
            Event::Recovered { .. } => light(&mut *screen, card),
            Event::Lost { .. } => is_away = true,
            Event::Vblank { .. } | Event::Asleep | Event::Changed => {}
            Event::Idle => quiet += QUIET,
        }
        if quiet >= often {
            quiet = Duration::ZERO;
            if is_away && is_ready {
                // Alive, and working towards a screen.
                tell(NotifyState::Watchdog);
            }
            light(&mut *screen, card);
        }
    }
    tell(NotifyState::Stopping);
}

fn light(screen: &mut dyn Screen, card: &Card) {
    match screen.stage(&card.picture()) {
        Ok(()) => screen.commit(),
        Err(error @ (ScreenError::Size { .. } | ScreenError::Open { .. })) => {
            warn!(error = chain(&error), "the still picture cannot be lit");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Card, NotifyState, keep};
    use screen::{Event, Light, Lit, OutputSettings, Picture, Screen, ScreenError};
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
        fn lit(&self) -> Option<Lit> {
            None
        }

        fn stage(&mut self, _: &Picture<'_>) -> Result<(), ScreenError> {
            Ok(())
        }

        fn commit(&mut self) {
            self.lit_after.borrow_mut().push(self.told);
        }

        fn notify_at(&mut self, _: Vblank) {}

        fn fit(&mut self, _: (u32, u32), _: Rate) {}

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
        keep(Box::new(screen), &Card::draw((64, 48)), Duration::from_secs(1), &stop, &tell);
        assert_eq!(*lit_after.borrow(), [0, 1, 3, 8, 14, 15]);
        let fed = "WATCHDOG=1";
        assert_eq!(*heard.borrow(), ["READY=1", fed, fed, fed, fed, "STOPPING=1"]);
    }
}
