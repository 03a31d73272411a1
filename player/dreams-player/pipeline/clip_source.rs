//! The clip source: a thread that chooses the next clip, opens it and reads it into memory, long before its join.
//!
//! Owns the walk and what happens when a clip is bad: it is left out for the rest of the run, logged once, and the path
//! goes around it: another transition, else the loop again, else nothing, and the last frame stays lit. The switch to
//! another flock is `flock_switch.rs`. Never decodes.

mod flock_switch;

use crate::pipeline::decoder::{ClipEnd, Order};
use crate::pipeline::first_frame::FirstFrame;
use crate::pipeline::start_gate::StartGate;
use crate::recording::{Faults, Kind, SharedView};
use crate::stream::{Generation, Plan, ScheduledClip};
use diagnostics::chain;
use flock::{ClipHash, ClipPath, Itinerary, Leg};
use player::{ThreadError, threads};
use std::collections::BTreeSet;
use std::error::Error;
use std::fs::File;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::thread::{self, JoinHandle};
use std::time::Duration;
use timing::{FrameCount, Nanos};
use tracing::debug;
use video::{Clip, ClipError, Form, ProbeError};

pub(crate) use flock_switch::Successor;

/// How long to wait, when nothing can be played, before all clips get another chance: storage may come back.
const RETRY: Duration = Duration::from_secs(30);

/// How long to wait when the machine is out of memory or file descriptors.
const SHORTAGE_PAUSE: Duration = Duration::from_millis(100);
/// So often a clip is opened that the machine seems too short of something to open: for a minute. A damaged index may look
/// like that, too, and must not hold the picture for ever; the clip counts as missing, which is tried again later.
const SHORTAGE_TRIES: u32 = 600;

/// The walk, and where its clips are.
pub(crate) struct ClipSource {
    /// The path of the flock to play, as configured.
    pub(crate) source: PathBuf,
    /// The path of the flock that stands in while that one cannot be played.
    pub(crate) spare: PathBuf,
    /// The flock that is played.
    pub(crate) generation: Generation,
    /// The flock that is to be played next, as far as it is known.
    pub(crate) successor: Successor,
    pub(crate) form: Form,
    /// The next clip is of another form than those before.
    pub(crate) is_reformed: bool,
    pub(crate) itinerary: Itinerary,
    /// How many clips to order; `None` for no end.
    pub(crate) clips: Option<u64>,
    pub(crate) faults: Faults,
    pub(crate) plan: Arc<Plan>,
    pub(crate) view: Arc<SharedView>,
    pub(crate) gate: Arc<StartGate>,
    /// The clock.
    pub(crate) now: fn() -> Nanos,
    /// Empty at the start.
    pub(crate) strikes: Strikes,
    /// Sends the first frame; `None` once that was done.
    pub(crate) first_frame: Option<FirstFrame>,
}

impl ClipSource {
    /// Starts the thread. It orders clips as fast as `orders` takes them, and leaves out those that ended damaged.
    pub(crate) fn open(
        self,
        orders: SyncSender<Order>,
        clip_ends: Receiver<ClipEnd>,
    ) -> Result<JoinHandle<()>, ThreadError> {
        threads::start("clip source", move || self.work(&orders, &clip_ends))
    }

    fn work(mut self, orders: &SyncSender<Order>, clip_ends: &Receiver<ClipEnd>) {
        let mut unauthentic: Option<ClipPath> = None;
        let mut ended = ClipEnds::default();
        let mut number = 1;
        loop {
            self.retry_missing();
            let Some(leg) = self.itinerary.next_leg() else {
                if self.wait_for_something(&mut ended, orders, clip_ends) {
                    continue;
                }
                return;
            };
            if self.change(&leg) {
                unauthentic = None;
                continue;
            }
            // A clip that decoded badly is left out only now that the leg after it is drawn: the path does not go back
            // to before a clip that is shown.
            let Some(mut bad) = self.bad_clips(&mut ended, number, orders, clip_ends) else { return };
            bad.extend(unauthentic.take());
            for clip in &bad {
                self.leave_out(clip, false);
            }
            if bad.contains(&leg.clip.path) {
                continue;
            }
            if self.clips.is_some_and(|clips| number > clips + ended.empty) {
                // Never played, but where the path goes on: the place to keep when the run has ended.
                self.add_to_plan(self.scheduled(number, leg));
                return;
            }
            let admitted = self.admit(&leg, number);
            if admitted.is_none() && self.change(&leg) {
                continue;
            }
            if let Some(clip) = admitted {
                let path = leg.clip.path.clone();
                let hash = leg.clip.hash;
                let scheduled = self.scheduled(number, leg);
                self.add_to_plan(Arc::clone(&scheduled));
                if number == 1 {
                    self.send_first_frame(&clip, &scheduled);
                }
                // What follows is for a decoder of its own.
                let is_reformed = std::mem::take(&mut self.is_reformed);
                let rest = is_reformed.then_some(Order::Rest);
                if rest.into_iter().chain([Order::Play(clip, scheduled)]).any(|order| orders.send(order).is_err()) {
                    return;
                }
                if number == 1 {
                    self.gate.wait();
                    unauthentic = Some(path).filter(|path| !self.is_authentic(path, hash));
                }
                number += 1;
            }
        }
    }

    /// Sends the first frame of the run's first clip ahead, and waits until it is lit. With one processor only, a decoder
    /// that starts meanwhile would double the time to that picture.
    fn send_first_frame(&mut self, clip: &Clip, scheduled: &Arc<ScheduledClip>) {
        if let Some(first_frame) = self.first_frame.take() {
            first_frame.send(clip, Arc::clone(scheduled));
            self.gate.wait();
        }
    }

    /// There is nothing to play. Whether there may be something by now; `false` if the run is over.
    fn wait_for_something(
        &mut self,
        ended: &mut ClipEnds,
        orders: &SyncSender<Order>,
        clip_ends: &Receiver<ClipEnd>,
    ) -> bool {
        self.faults.once(Kind::Barren, "flock", "no clip of the flock can be played".to_owned());
        self.generation.failed();
        if self.change_from_nothing() {
            return true;
        }
        if self.clips.is_some() || !ended.wait(orders, clip_ends, &self.plan) {
            return false;
        }
        self.strikes = Strikes::default();
        self.itinerary.unblock();
        true
    }

    /// The bad ones among the clips that have ended before clip `number`; `None` if the run is over.
    fn bad_clips(
        &mut self,
        ended: &mut ClipEnds,
        number: u64,
        orders: &SyncSender<Order>,
        clip_ends: &Receiver<ClipEnd>,
    ) -> Option<Vec<ClipPath>> {
        let mut bad: Vec<_> = clip_ends.try_iter().filter_map(|clip_end| self.count(ended, &clip_end)).collect();
        if self.clips.is_some_and(|clips| number > clips + ended.empty) && ended.count + 1 < number {
            // Clips without a picture do not count: how many there are is known when all have ended.
            orders.send(Order::Rest).ok()?;
            while ended.count + 1 < number {
                bad.extend(self.count(ended, &clip_ends.recv().ok()?));
            }
        }
        Some(bad)
    }

    /// Counts the end of a clip; returns the clip if it is bad, and of the flock that is played.
    fn count(&mut self, ended: &mut ClipEnds, clip_end: &ClipEnd) -> Option<ClipPath> {
        let bad = ended.count(clip_end, &self.plan);
        if !Arc::ptr_eq(&clip_end.scheduled.flock, &self.generation.flock) {
            return None;
        }
        bad
    }

    fn scheduled(&self, number: u64, leg: Leg) -> Arc<ScheduledClip> {
        let (clip, frames, what) = (leg.clip.path, leg.clip.frames, leg.clip.what);
        let (flock, trial) = (Arc::clone(&self.generation.flock), self.generation.trial.clone());
        Arc::new(ScheduledClip {
            number,
            clip,
            frames,
            what,
            place: leg.place,
            flock,
            trial,
            is_damaged: AtomicBool::new(false),
        })
    }

    fn add_to_plan(&self, scheduled: Arc<ScheduledClip>) {
        let on_screen = self.view.get().shown.and_then(|shown| Some(shown.scheduled?.number));
        self.plan.add(scheduled, on_screen);
    }

    /// Takes a bad clip out of the path. One that is missing may come back, and does not end a trial.
    fn leave_out(&mut self, clip: &ClipPath, is_missing: bool) {
        if !is_missing {
            self.generation.failed();
        }
        self.itinerary.block(clip);
        if is_missing {
            self.strikes.missing = Some((self.now)());
        } else {
            self.strikes.damaged.insert(clip.clone());
        }
    }

    /// Gives missing clips another chance where no way leads on without them: a moment's failure of the storage must
    /// not leave one sheep on the wall for ever.
    fn retry_missing(&mut self) {
        let is_over = |at| u128::from((self.now)().since(at)) >= RETRY.as_nanos();
        if self.strikes.missing.is_some_and(is_over) && !self.itinerary.has_exit() {
            self.strikes.missing = None;
            self.itinerary.unblock();
            for clip in &self.strikes.damaged {
                self.itinerary.block(clip);
            }
        }
    }

    /// Opens a leg's clip and reads it into memory; strikes it if it is bad. The first one is only opened: the
    /// picture comes first.
    fn admit(&mut self, leg: &Leg, number: u64) -> Option<Clip> {
        let path = &leg.clip.path;
        let file = path.inside(&self.generation.folder);
        let open = || Clip::open(&file, &self.form, leg.clip.frames);
        let opened = retry_on_shortage(&self.faults, path, open, ClipError::is_shortage, SHORTAGE_TRIES);
        let mut is_missing = false;
        let admitted = match opened {
            Ok(clip) if number == 1 => Some(clip),
            Ok(mut clip) if leg.clip.hash.is_none() => {
                if let Err(error) = clip.page_in() {
                    debug!(clip = path.as_str(), error = chain(&error), "clip is not paged in");
                }
                Some(clip)
            }
            Ok(clip) => self.is_authentic(path, leg.clip.hash).then_some(clip),
            Err(error) => {
                is_missing = kind(&error) == Kind::MissingClip;
                self.faults.once(kind(&error), path.as_str(), chain(&error));
                None
            }
        };
        if admitted.is_none() {
            self.leave_out(path, is_missing);
        }
        admitted
    }

    /// Whether the clip's bytes are those of the manifest's hash, where it has one. Reading them pages them in.
    fn is_authentic(&self, path: &ClipPath, hash: Option<ClipHash>) -> bool {
        let Some(expected) = hash else { return true };
        let hashed = || File::open(path.inside(&self.generation.folder)).and_then(ClipHash::of);
        let message = match retry_on_shortage(&self.faults, path, hashed, video::is_shortage, u32::MAX) {
            Ok(found) if found == expected => return true,
            // It is no fault: the path goes over to the other manifest.
            Ok(_) if self.generation.is_being_replaced() => return false,
            Ok(found) => {
                format!("clip `{}` is not the manifest's (expected {expected}, found {found})", path.as_str())
            }
            Err(error) => format!("cannot read clip `{}`: {}", path.as_str(), chain(&error)),
        };
        self.faults.once(Kind::DamagedClip, path.as_str(), message);
        false
    }
}

/// Does something with a clip, as often as it fails because the machine is short of something; `most` times at most.
fn retry_on_shortage<T, E: Error + 'static>(
    faults: &Faults,
    clip: &ClipPath,
    work: impl Fn() -> Result<T, E>,
    is_shortage: impl Fn(&E) -> bool,
    most: u32,
) -> Result<T, E> {
    let mut tries = 0;
    loop {
        tries += 1;
        match work() {
            Err(error) if tries < most && is_shortage(&error) => {
                let message = format!("cannot open clip `{}` yet: {}", clip.as_str(), chain(&error));
                faults.once(Kind::MissingClip, "shortage", message);
                thread::park_timeout(SHORTAGE_PAUSE);
            }
            done => return done,
        }
    }
}

/// The clips that the path leaves out, beside what the path itself knows.
#[derive(Debug, Default)]
pub(crate) struct Strikes {
    /// Clips that will not get better.
    damaged: BTreeSet<ClipPath>,
    /// When the last clip was left out that may come back.
    missing: Option<Nanos>,
}

/// Counts of the clips that have ended.
#[derive(Default)]
struct ClipEnds {
    count: u64,
    /// Those of them without a picture.
    empty: u64,
}

impl ClipEnds {
    /// Counts an end; returns the clip if it is bad.
    fn count(&mut self, clip_end: &ClipEnd, plan: &Plan) -> Option<ClipPath> {
        self.count += 1;
        if clip_end.frames == FrameCount(0) {
            self.empty += 1;
            plan.remove(clip_end.scheduled.number);
        }
        clip_end.is_damaged.then(|| clip_end.scheduled.clip.clone())
    }

    /// Tells that there is nothing to play and waits; `false` if the run is over.
    fn wait(&mut self, orders: &SyncSender<Order>, clip_ends: &Receiver<ClipEnd>, plan: &Plan) -> bool {
        if orders.send(Order::Barren).is_err() {
            return false;
        }
        loop {
            match clip_ends.recv_timeout(RETRY) {
                Ok(clip_end) => drop(self.count(&clip_end, plan)),
                Err(RecvTimeoutError::Timeout) => return true,
                Err(RecvTimeoutError::Disconnected) => return false,
            }
        }
    }
}

fn kind(error: &ClipError) -> Kind {
    match error {
        ClipError::Form { .. } => Kind::WrongClip,
        ClipError::Probe { error: ProbeError::NotAFile { .. } | ProbeError::Open { .. } } => Kind::MissingClip,
        ClipError::Probe { .. } => Kind::DamagedClip,
    }
}

#[cfg(test)]
mod tests;
