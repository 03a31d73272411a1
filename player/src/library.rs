//! The library thread: chooses the next clip, opens it and reads it into memory, long before its join.
//!
//! Owns the walk and what happens when a clip is bad: it is struck for the run, told once, and the path goes on
//! around it: another transition, else the loop again, else nothing, and the last frame stays lit. Never decodes.

use crate::decoder::Order;
use crate::faults::{Faults, Kind};
use crate::glass::Glass;
use crate::report::{Fatal, chain};
use crate::turn::Turn;
use flock::{ClipHash, ClipPath, Flock, Itinerary, Leg, Place};
use std::fs::File;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::thread::{self, JoinHandle};
use std::time::Duration;
use tracing::{debug, info, warn};
use video::{Clip, ClipError, Form, ProbeError};

/// How long to wait, when nothing can be played, before all clips get another chance: storage may come back.
const REPRIEVE: Duration = Duration::from_secs(30);

/// How many bits a fresh seed has: what JSON, and so the status page, and `--seed` can tell exactly.
const FRESH_BITS: u32 = 53;

/// The walk, and where its clips are.
pub(crate) struct Library {
    /// The flock's folder.
    pub(crate) folder: PathBuf,
    pub(crate) form: Form,
    pub(crate) itinerary: Itinerary,
    /// How many clips to order; `None` for no end.
    pub(crate) clips: Option<u64>,
    pub(crate) faults: Faults,
    pub(crate) glass: Arc<Glass>,
}

/// The path of this run: where it was left, unless another seed is asked for; else a fresh one.
pub(crate) fn path(flock: &Arc<Flock>, saved: Option<Place>, seed: Option<u64>) -> Itinerary {
    let kept = saved.filter(|place| seed.is_none_or(|seed| seed == place.seed()));
    if let Some(place) = kept {
        match Itinerary::resume(Arc::clone(flock), &place) {
            Ok(itinerary) => {
                info!(seed = place.seed(), step = place.step(), "path resumed");
                return itinerary;
            }
            Err(error) => warn!(error = chain(&error), "path begins anew"),
        }
    }
    let seed = seed.unwrap_or_else(|| rand::random::<u64>() >> (u64::BITS - FRESH_BITS));
    info!(seed, "path begins");
    Itinerary::start(Arc::clone(flock), seed)
}

impl Library {
    /// Starts the thread. It orders clips as fast as `orders` takes them, and strikes those that `bad` names.
    ///
    /// # Errors
    /// [`Fatal`] if the thread cannot be started.
    pub(crate) fn open(self, orders: SyncSender<Order>, bad: Receiver<ClipPath>) -> Result<JoinHandle<()>, Fatal> {
        let work = move || self.work(&orders, &bad);
        let thread = thread::Builder::new().name("library".to_owned()).spawn(work);
        thread.map_err(|source| Fatal::Thread { name: "library", source })
    }

    fn work(mut self, orders: &SyncSender<Order>, bad: &Receiver<ClipPath>) {
        let origin = self.itinerary.clone();
        let mut last: Option<Place> = None;
        let mut unauthentic: Option<ClipPath> = None;
        let mut number = 1;
        loop {
            let Some(leg) = self.itinerary.next_leg() else {
                self.faults.once(Kind::Barren, "flock", "no clip of the flock can be played".to_owned());
                if self.clips.is_some() || !wait(orders, bad) {
                    return;
                }
                let flock = Arc::clone(origin.flock());
                let forgiven = last.as_ref().and_then(|place| Itinerary::resume(flock, place).ok());
                self.itinerary = forgiven.unwrap_or_else(|| origin.clone());
                continue;
            };
            // What turned out bad on its way to the glass is struck only now that the leg after it is drawn: the path
            // does not go back to before a clip that is shown.
            let struck: Vec<_> = unauthentic.take().into_iter().chain(bad.try_iter()).collect();
            for clip in &struck {
                self.itinerary.strike(clip);
            }
            if struck.contains(&leg.clip.path) {
                continue;
            }
            if self.clips.is_some_and(|clips| number > clips) {
                // Never played, but where the path goes on: the place to keep when the run has ended.
                return self.glass.plan(turn(number, leg));
            }
            if let Some(clip) = self.admit(&leg, number) {
                let path = leg.clip.path.clone();
                let hash = leg.clip.hash;
                last = Some(leg.place.clone());
                let turn = turn(number, leg);
                self.glass.plan(Arc::clone(&turn));
                if orders.send(Order::Play(clip, turn)).is_err() {
                    return;
                }
                if number == 1 && !self.is_authentic(&path, hash) {
                    unauthentic = Some(path);
                }
                number += 1;
            }
        }
    }

    /// Opens a leg's clip and reads it into memory; strikes it if it is bad. The first one is only opened: the
    /// picture comes first.
    fn admit(&mut self, leg: &Leg, number: u64) -> Option<Clip> {
        let path = &leg.clip.path;
        let opened = Clip::open(&path.inside(&self.folder), &self.form, leg.clip.frames);
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
                self.faults.once(kind(&error), path.as_str(), chain(&error));
                None
            }
        };
        if admitted.is_none() {
            self.itinerary.strike(path);
        }
        admitted
    }

    /// Whether the clip's bytes are those of the manifest's hash, where it has one. Reading them pages them in.
    fn is_authentic(&self, path: &ClipPath, hash: Option<ClipHash>) -> bool {
        let Some(expected) = hash else { return true };
        let message = match File::open(path.inside(&self.folder)).and_then(ClipHash::of) {
            Ok(found) if found == expected => return true,
            Ok(found) => {
                format!("clip `{}` is not the manifest's (expected {expected}, found {found})", path.as_str())
            }
            Err(error) => format!("cannot read clip `{}`: {}", path.as_str(), chain(&error)),
        };
        self.faults.once(Kind::DamagedClip, path.as_str(), message);
        false
    }
}

/// Tells that there is nothing to play and waits; `false` if the run is over.
fn wait(orders: &SyncSender<Order>, bad: &Receiver<ClipPath>) -> bool {
    if orders.send(Order::Barren).is_err() {
        return false;
    }
    loop {
        match bad.recv_timeout(REPRIEVE) {
            Ok(_) => {}
            Err(RecvTimeoutError::Timeout) => return true,
            Err(RecvTimeoutError::Disconnected) => return false,
        }
    }
}

fn turn(number: u64, leg: Leg) -> Arc<Turn> {
    Arc::new(Turn { number, clip: leg.clip.path, frames: leg.clip.frames, place: leg.place })
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
