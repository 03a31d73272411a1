//! The library thread: chooses the next clip, opens it and reads it into memory, long before its join.
//!
//! Owns the walk and what happens when a clip is bad: it is struck for the run, told once, and the path goes on
//! around it: another transition, else the loop again, else nothing, and the last frame stays lit. How the path goes
//! over to another flock stands in `flock_switch.rs`. Never decodes.

mod flock_switch;

use crate::pipeline::decoder::{Order, Report};
use crate::pipeline::first_frame::Herald;
use crate::pipeline::start_gate::StartGate;
use crate::recording::faults::{Faults, Kind};
use crate::recording::view::SharedView;
use crate::stream::generation::Generation;
use crate::stream::plan::Plan;
use crate::stream::scheduled_clip::Turn;
use flock::{ClipHash, ClipPath, Itinerary, Leg};
use player::ending::chain;
use player::threads::{self, ThreadError};
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
const REPRIEVE: Duration = Duration::from_secs(30);

/// How long to wait for a machine that is short of something.
const BREATH: Duration = Duration::from_millis(100);

/// The walk, and where its clips are.
pub(crate) struct Library {
    /// Where the flock to be played is said to be.
    pub(crate) source: PathBuf,
    /// The one that is played.
    pub(crate) generation: Generation,
    /// What is known of the one that is to be played instead.
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
    pub(crate) struck: Struck,
    /// Brings the opening; `None` once it was sent.
    pub(crate) herald: Option<Herald>,
}

impl Library {
    /// Starts the thread. It orders clips as fast as `orders` takes them, and strikes those that `reports` call
    /// damaged.
    ///
    /// # Errors
    /// [`ThreadError`].
    pub(crate) fn open(
        self,
        orders: SyncSender<Order>,
        reports: Receiver<Report>,
    ) -> Result<JoinHandle<()>, ThreadError> {
        threads::start("clip source", move || self.work(&orders, &reports))
    }

    fn work(mut self, orders: &SyncSender<Order>, reports: &Receiver<Report>) {
        let mut unauthentic: Option<ClipPath> = None;
        let mut ended = Ends::default();
        let mut number = 1;
        loop {
            self.forgive_the_missing();
            let Some(leg) = self.itinerary.next_leg() else {
                if self.wait_for_something(&mut ended, orders, reports) {
                    continue;
                }
                return;
            };
            if self.change(&leg) {
                unauthentic = None;
                continue;
            }
            // What turned out bad on its way to the glass is struck only now that the leg after it is drawn: the path
            // does not go back to before a clip that is shown.
            let Some(mut bad) = self.hear(&mut ended, number, orders, reports) else { return };
            bad.extend(unauthentic.take());
            for clip in &bad {
                self.strike(clip, false);
            }
            if bad.contains(&leg.clip.path) {
                continue;
            }
            if self.clips.is_some_and(|clips| number > clips + ended.mute) {
                // Never played, but where the path goes on: the place to keep when the run has ended.
                self.add_to_plan(self.turn(number, leg));
                return;
            }
            if let Some(clip) = self.admit(&leg, number) {
                let path = leg.clip.path.clone();
                let hash = leg.clip.hash;
                let turn = self.turn(number, leg);
                self.add_to_plan(Arc::clone(&turn));
                if number == 1 {
                    self.announce(&clip, &turn);
                }
                // What follows is for a decoder of its own.
                let is_reformed = std::mem::take(&mut self.is_reformed);
                let rest = is_reformed.then_some(Order::Rest);
                if rest.into_iter().chain([Order::Play(clip, turn)]).any(|order| orders.send(order).is_err()) {
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

    /// Sends the herald ahead of the run's first clip, and waits until his picture is lit. Where there is one processor
    /// only, a stream that came up meanwhile would double the time to that picture.
    fn announce(&mut self, clip: &Clip, turn: &Arc<Turn>) {
        if let Some(herald) = self.herald.take() {
            herald.announce(clip, Arc::clone(turn));
            self.gate.wait();
        }
    }

    /// There is nothing to play. Whether there may be something by now; `false` if the run is over.
    fn wait_for_something(&mut self, ended: &mut Ends, orders: &SyncSender<Order>, reports: &Receiver<Report>) -> bool {
        self.faults.once(Kind::Barren, "flock", "no clip of the flock can be played".to_owned());
        self.generation.failed();
        if self.change_from_nothing() {
            return true;
        }
        if self.clips.is_some() || !ended.wait(orders, reports, &self.plan) {
            return false;
        }
        self.struck = Struck::default();
        self.itinerary.forgive();
        true
    }

    /// The bad ones among the clips that have ended before turn `number`; `None` if the run is over.
    fn hear(
        &mut self,
        ended: &mut Ends,
        number: u64,
        orders: &SyncSender<Order>,
        reports: &Receiver<Report>,
    ) -> Option<Vec<ClipPath>> {
        let mut bad: Vec<_> = reports.try_iter().filter_map(|report| self.learn(ended, &report)).collect();
        if self.clips.is_some_and(|clips| number > clips + ended.mute) && ended.count + 1 < number {
            // Clips without a picture do not count: how many there are is known when all have ended.
            orders.send(Order::Rest).ok()?;
            while ended.count + 1 < number {
                bad.extend(self.learn(ended, &reports.recv().ok()?));
            }
        }
        Some(bad)
    }

    /// Counts the end of a clip; returns the clip if it is bad, and of the flock that is played.
    fn learn(&mut self, ended: &mut Ends, report: &Report) -> Option<ClipPath> {
        let bad = ended.learn(report, &self.plan);
        if !Arc::ptr_eq(&report.turn.flock, &self.generation.flock) {
            return None;
        }
        bad
    }

    fn turn(&self, number: u64, leg: Leg) -> Arc<Turn> {
        let (clip, frames) = (leg.clip.path, leg.clip.frames);
        let (flock, trial) = (Arc::clone(&self.generation.flock), self.generation.trial.clone());
        Arc::new(Turn { number, clip, frames, place: leg.place, flock, trial, is_damaged: AtomicBool::new(false) })
    }

    fn add_to_plan(&self, turn: Arc<Turn>) {
        let on_screen = self.view.get().shown.and_then(|shown| Some(shown.turn?.number));
        self.plan.add(turn, on_screen);
    }

    /// Takes a bad clip out of the path. One that is missing may come back, and is nobody's fault.
    fn strike(&mut self, clip: &ClipPath, is_missing: bool) {
        if !is_missing {
            self.generation.failed();
        }
        self.itinerary.strike(clip);
        if is_missing {
            self.struck.missing = Some((self.now)());
        } else {
            self.struck.damaged.insert(clip.clone());
        }
    }

    /// Gives missing clips another chance where no way leads on without them: a moment's failure of the storage must
    /// not leave one sheep on the wall for ever.
    fn forgive_the_missing(&mut self) {
        let is_over = |at| u128::from((self.now)().since(at)) >= REPRIEVE.as_nanos();
        if self.struck.missing.is_some_and(is_over) && !self.itinerary.leads_on() {
            self.struck.missing = None;
            self.itinerary.forgive();
            for clip in &self.struck.damaged {
                self.itinerary.strike(clip);
            }
        }
    }

    /// Opens a leg's clip and reads it into memory; strikes it if it is bad. The first one is only opened: the
    /// picture comes first.
    fn admit(&mut self, leg: &Leg, number: u64) -> Option<Clip> {
        let path = &leg.clip.path;
        let file = path.inside(&self.generation.folder);
        let open = || Clip::open(&file, &self.form, leg.clip.frames);
        let opened = self.patiently(path, open, ClipError::is_shortage);
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
            self.strike(path, is_missing);
        }
        admitted
    }

    /// Whether the clip's bytes are those of the manifest's hash, where it has one. Reading them pages them in.
    fn is_authentic(&self, path: &ClipPath, hash: Option<ClipHash>) -> bool {
        let Some(expected) = hash else { return true };
        let hashed = || File::open(path.inside(&self.generation.folder)).and_then(ClipHash::of);
        let message = match self.patiently(path, hashed, video::is_shortage) {
            Ok(found) if found == expected => return true,
            Ok(found) => {
                format!("clip `{}` is not the manifest's (expected {expected}, found {found})", path.as_str())
            }
            Err(error) => format!("cannot read clip `{}`: {}", path.as_str(), chain(&error)),
        };
        self.faults.once(Kind::DamagedClip, path.as_str(), message);
        false
    }

    /// Does something with a clip, as often as it fails because the machine is short of something.
    fn patiently<T, E: Error + 'static>(
        &self,
        clip: &ClipPath,
        work: impl Fn() -> Result<T, E>,
        is_shortage: impl Fn(&E) -> bool,
    ) -> Result<T, E> {
        loop {
            match work() {
                Err(error) if is_shortage(&error) => {
                    let message = format!("cannot open clip `{}` yet: {}", clip.as_str(), chain(&error));
                    self.faults.once(Kind::MissingClip, "shortage", message);
                    thread::park_timeout(BREATH);
                }
                done => return done,
            }
        }
    }
}

/// What is struck, beside the path's own strikes.
#[derive(Debug, Default)]
pub(crate) struct Struck {
    /// Clips that will not get better.
    damaged: BTreeSet<ClipPath>,
    /// When the last clip was struck that may come back.
    missing: Option<Nanos>,
}

/// How the clips ended that have.
#[derive(Default)]
struct Ends {
    count: u64,
    /// Those of them without a picture.
    mute: u64,
}

impl Ends {
    /// Counts an end; returns the clip if it is bad.
    fn learn(&mut self, report: &Report, plan: &Plan) -> Option<ClipPath> {
        self.count += 1;
        if report.frames == FrameCount(0) {
            self.mute += 1;
            plan.remove(report.turn.number);
        }
        report.is_damaged.then(|| report.turn.clip.clone())
    }

    /// Tells that there is nothing to play and waits; `false` if the run is over.
    fn wait(&mut self, orders: &SyncSender<Order>, reports: &Receiver<Report>, plan: &Plan) -> bool {
        if orders.send(Order::Barren).is_err() {
            return false;
        }
        loop {
            match reports.recv_timeout(REPRIEVE) {
                Ok(report) => drop(self.learn(&report, plan)),
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
pub(crate) mod tests;
