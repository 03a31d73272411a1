//! The saver: a thread that keeps the walk's place at every join, and counts for a trial what was on the glass.
//!
//! Owns the slots while the run lasts. A place that is overtaken while the disk is busy is not written at all; a join of a
//! flock on trial counts all the same.

use crate::recording::faults::{Faults, Kind};
use crate::recording::place_store::Slots;
use crate::stream::scheduled_clip::Turn;
use player::ending::chain;
use player::threads::{self, ThreadError};
use std::iter::once;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::thread::JoinHandle;

/// The way to the saver.
#[derive(Debug)]
pub(crate) struct Saver {
    turns: Sender<Arc<Turn>>,
    /// Tells of every turn that is kept; `None` where nobody waits for that.
    kept: Option<Receiver<()>>,
    thread: JoinHandle<()>,
}

impl Saver {
    /// Starts the thread; without `slots` it keeps no places. A patient saver is waited for, which is right where no
    /// vblank waits.
    ///
    /// # Errors
    /// [`ThreadError`].
    pub(crate) fn start(slots: Option<Slots>, faults: Faults, is_patient: bool) -> Result<Self, ThreadError> {
        let (turns, inbox) = channel();
        let (done, kept) = is_patient.then(|| sync_channel(1)).unzip();
        let work = move || keep_places(slots, &inbox, done.as_ref(), &faults);
        Ok(Self { turns, kept, thread: threads::start("place saver", work)? })
    }

    /// Keeps the place of `turn`, which has come to the glass: soon, or now if the saver is patient.
    pub(crate) fn keep(&self, turn: &Arc<Turn>) {
        // A saver that is gone has panicked, and told so; the picture goes on.
        if self.turns.send(Arc::clone(turn)).is_ok()
            && let Some(kept) = &self.kept
        {
            kept.recv().ok();
        }
    }

    /// Ends the thread when it has kept everything.
    pub(crate) fn end(self) {
        drop(self.turns);
        self.thread.join().ok();
    }
}

fn keep_places(mut slots: Option<Slots>, inbox: &Receiver<Arc<Turn>>, done: Option<&SyncSender<()>>, faults: &Faults) {
    let mut on_glass: Option<Arc<Turn>> = None;
    while let Ok(turn) = inbox.recv() {
        for turn in once(turn).chain(inbox.try_iter()) {
            if let Some(ended) = on_glass.replace(turn)
                && !ended.is_damaged.load(Ordering::Acquire)
                && let Some(trial) = &ended.trial
            {
                trial.shown();
            }
        }
        if let (Some(slots), Some(turn)) = (&mut slots, &on_glass)
            && let Err(error) = slots.keep(&turn.place.to_bytes())
        {
            faults.once(Kind::Place, "keep", format!("cannot keep the walk's place: {}", chain(&error)));
        }
        if let Some(done) = done {
            done.send(()).ok();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Saver;
    use crate::recording::faults::Faults;
    use crate::recording::place_store::Slots;
    use crate::stream::scheduled_clip::tests::turns;

    #[test]
    fn the_newest_place_is_on_the_disk_when_the_saver_has_ended() {
        for is_patient in [false, true] {
            let dir = tempfile::tempdir().unwrap();
            let (slots, _) = Slots::open(dir.path()).unwrap();
            let saver = Saver::start(Some(slots), Faults::new(|_| ()), is_patient).unwrap();
            let turns = turns(20, 3);
            for turn in &turns {
                saver.keep(turn);
                if is_patient {
                    assert_eq!(Slots::open(dir.path()).unwrap().1, Some(turn.place.to_bytes()));
                }
            }
            saver.end();
            assert_eq!(Slots::open(dir.path()).unwrap().1, Some(turns[19].place.to_bytes()));
        }
    }
}
