//! The counting of votes.
//!
//! Owns the order for a press: ask the player what was seen, count, store, and only then acknowledge: the mark on the picture
//! means that the vote survives a power cut. Owns the looks in between, by which showings are counted. Waits for a device or a
//! player that is not there. Never logs a press, and keeps no time of one.
//!
//! Start at [`count`].

use crate::config::Config;
use crate::fatal::Fatal;
use crate::glass;
use crate::show;
use diagnostics::chain;
use player::input_devices::{Input, InputDevices};
use player::{ClockReader, acknowledgement, clock_us, now};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use settings::ButtonDevice;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;
use timing::Nanos;
use tracing::{debug, info, warn};
use votes::{Buttons, Credit, DAY_S, Ledger, LedgerId, Lit, Press, SEEN_MS, Store, seen};

/// The time between two looks at what is shown. No clip of a flock is that short.
const OFTEN_NS: u64 = 500_000_000;
/// The longest time between two looks for which somebody is said to have been near.
const LONGEST_LOOK_NS: u64 = 2 * OFTEN_NS;
/// The longest that an event waits to be read: while the player does not answer.
const OLDEST_NS: u64 = 4_000_000_000;
const NS_PER_MS: u64 = 1_000_000;
/// Presses that may be taken back, at most.
const MOST_CREDITS: usize = 16;

/// Counts until a signal. Without a device there is nothing to do.
/// Errors: [`Fatal`], if the votes cannot be read.
pub(crate) fn count(config: &Config) -> Result<(), Fatal> {
    if config.device.is_none() && config.presence.is_none() {
        info!("no input device is configured, no votes are counted");
        return Ok(());
    }
    let stop = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&stop);
    ctrlc::set_handler(move || raised.store(true, Ordering::Relaxed)).map_err(Fatal::Signals)?;
    let mut counting = Counting::open(config)?;
    while !stop.load(Ordering::Relaxed) {
        counting.wait();
        counting.read();
        counting.look();
    }
    counting.save();
    Ok(())
}

/// The counting of a run.
struct Counting<'c> {
    config: &'c Config,
    store: Store,
    ledger: Ledger,
    buttons: Buttons,
    device: InputDevices,
    presence: InputDevices,
    is_near: bool,
    /// The presses of keys that are held, or were held last.
    credits: Vec<(u16, Credit)>,
    /// When the last look was, and what was lit then.
    looked: Option<(Nanos, Vec<Lit>)>,
    /// Whether it was said that the store does not take the votes.
    is_warned: bool,
}

impl<'c> Counting<'c> {
    fn open(config: &'c Config) -> Result<Self, Fatal> {
        let (store, kept) = Store::open(&config.store)?;
        let ledger = match kept {
            Some(ledger) if ledger.is_noisy() == config.noise => ledger,
            // Exact totals beside noisy ones would tell what the noise hides.
            Some(ledger) => {
                show::keep(&config.store, &ledger.sent())?;
                ledger.renewed(fresh_id(), today(), config.noise)
            }
            None => Ledger::new(fresh_id(), today(), config.noise),
        };
        let of = |device: &Option<ButtonDevice>| device.as_ref().map_or_else(InputDevices::default, InputDevices::of);
        Ok(Self {
            config,
            store,
            ledger,
            buttons: Buttons::new(config.up.0, config.down.and_then(|key| key.0)),
            device: of(&config.device),
            presence: of(&config.presence.clone().map(ButtonDevice::At)),
            is_near: false,
            credits: Vec::new(),
            looked: None,
            is_warned: false,
        })
    }

    /// Waits until a device has something to say, or it is time for a look.
    fn wait(&mut self) {
        let now = now();
        let left_ns = self.looked.as_ref().map_or(0, |(at, _)| at.after(OFTEN_NS).since(now));
        let files = [self.device.open(now), self.presence.open(now)].concat();
        let mut watched: Vec<_> = files.iter().map(|file| PollFd::new(*file, PollFlags::IN)).collect();
        let timeout = Timespec::try_from(Duration::from_nanos(left_ns)).ok();
        if let Err(error) = poll(&mut watched, timeout.as_ref())
            && error != Errno::INTR
        {
            debug!(%error, "cannot wait for the input devices");
            thread::park_timeout(Duration::from_nanos(left_ns.min(OFTEN_NS)));
        }
    }

    /// Reads the devices.
    fn read(&mut self) {
        for input in self.presence.read() {
            self.is_near = matches!(input, Input::Key { value: 1.., .. });
        }
        for input in self.device.read() {
            match input {
                Input::Key { code, value, at_us } => {
                    // A look at a player that does not answer takes a second: the press was before.
                    let at = Nanos(now().0.saturating_sub(age_ns(at_us, clock_us())));
                    if let Some(press) = self.buttons.on(code, value, at.0) {
                        self.press(press, at);
                    }
                }
                Input::Lost => self.buttons.forget(),
            }
        }
        for key in self.buttons.stuck(now().0) {
            let stuck = self.credits.iter().position(|(held, _)| *held == key);
            let credit = stuck.map(|place| self.credits.remove(place).1);
            if credit.is_some_and(|credit| self.ledger.take_back(&credit)) {
                self.save();
            }
        }
    }

    /// Counts a press that came at `at`, and acknowledges it when the disk has it.
    fn press(&mut self, press: Press, at: Nanos) {
        let lit = self.lit();
        let ago_ms = SEEN_MS + now().since(at) / NS_PER_MS;
        let Some(visit) = seen(&lit, ago_ms).cloned() else { return };
        let Some(credit) = self.ledger.vote(&visit, press.vote) else { return };
        let is_stored = !credit.is_change() || self.save();
        self.credits.retain(|(key, _)| *key != press.key);
        self.credits.truncate(MOST_CREDITS - 1);
        self.credits.insert(0, (press.key, credit));
        if let Some(path) = self.config.acknowledge.0.as_ref().filter(|_| is_stored)
            && let Err(error) = acknowledgement::tell(path)
        {
            debug!(%error, "the player shows no mark");
        }
    }

    /// Looks what is shown, if it is time. A picture that does not move is no showing.
    fn look(&mut self) {
        let at = now();
        if self.looked.as_ref().is_some_and(|(then, _)| at.since(*then) < OFTEN_NS) {
            return;
        }
        let lit = self.lit();
        let Some((then, before)) = self.looked.replace((at, lit.clone())) else { return };
        let Some(visit) = seen(&lit, 0).filter(|_| lit != before) else { return };
        let is_changed = self.ledger.show(visit, at.0, &mut rand::random::<u64>);
        if self.is_near {
            let near_ns = at.since(then).min(LONGEST_LOOK_NS);
            self.ledger.near(visit, u32::try_from(near_ns / NS_PER_MS).unwrap_or(u32::MAX));
        }
        if self.ledger.is_full() && self.keep() {
            let full = self.ledger.clone();
            self.ledger = full.renewed(fresh_id(), today(), self.config.noise);
        }
        if is_changed {
            self.save();
        }
    }

    /// What the player shows; nothing while it does not answer.
    fn lit(&self) -> Vec<Lit> {
        glass::ask(&self.config.status).unwrap_or_else(|error| {
            debug!(error = chain(&error), "the player does not say what is shown");
            Vec::new()
        })
    }

    /// Keeps the totals of a ledger that ends; returns whether the disk has them.
    fn keep(&self) -> bool {
        show::keep(&self.config.store, &self.ledger.sent())
            .inspect_err(|error| debug!(error = chain(error), "cannot keep the totals so far"))
            .is_ok()
    }

    /// Saves the votes; returns whether the disk has them. What could not be saved is saved with the next vote.
    fn save(&mut self) -> bool {
        let saved = self.store.save(&self.ledger);
        if let Err(error) = &saved
            && !std::mem::replace(&mut self.is_warned, true)
        {
            warn!(error = chain(error), "cannot save the votes, none is acknowledged until that works again");
        }
        self.is_warned &= saved.is_err();
        saved.is_ok()
    }
}

/// How old an event of `at_us` is at `clock_us`, both in microseconds since 1970. The clock may have been set between them:
/// an event that would be from the future, or older than anything can wait, is new.
fn age_ns(at_us: u64, clock_us: u64) -> u64 {
    let age_ns = clock_us.checked_sub(at_us).map(|age_us| age_us.saturating_mul(1_000));
    age_ns.filter(|age_ns| *age_ns <= OLDEST_NS).unwrap_or(0)
}

fn fresh_id() -> LedgerId {
    LedgerId(rand::random())
}

/// The day, since 1970; 0 while the time is not known.
fn today() -> u32 {
    ClockReader::of_machine().read().known_s().and_then(|known_s| u32::try_from(known_s / DAY_S).ok()).unwrap_or(0)
}
