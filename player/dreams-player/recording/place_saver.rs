//! The place saver: a thread that saves the walk's place at every join, and counts the clips shown for a flock on trial.
//!
//! Owns the store of the place during the run. A place that is outdated before the disk is free is not written; a join of
//! a flock on trial counts all the same.

use crate::recording::faults::{Faults, Kind};
use crate::recording::place_store::PlaceStore;
use crate::stream::ScheduledClip;
use diagnostics::chain;
use player::{ThreadError, threads};
use std::iter::once;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::thread::JoinHandle;

/// The way to the place saver.
#[derive(Debug)]
pub(crate) struct PlaceSaver {
    scheduled_clips: Sender<Arc<ScheduledClip>>,
    /// An answer for each place that is saved; `None` where the run does not wait for it.
    kept: Option<Receiver<()>>,
    thread: JoinHandle<()>,
}

impl PlaceSaver {
    /// Starts the thread; without `store` it saves no places. If it `is_synchronous` the run waits for each place, which
    /// is right where no vblank waits.
    pub(crate) fn start(store: Option<PlaceStore>, faults: Faults, is_synchronous: bool) -> Result<Self, ThreadError> {
        let (scheduled_clips, inbox) = channel();
        let (done, kept) = is_synchronous.then(|| sync_channel(1)).unzip();
        let work = move || save_places(store, &inbox, done.as_ref(), &faults);
        Ok(Self { scheduled_clips, kept, thread: threads::start("place saver", work)? })
    }

    /// Saves the place of a clip whose first frame is lit: soon, or now if the saver is synchronous.
    pub(crate) fn save(&self, scheduled: &Arc<ScheduledClip>) {
        // A saver that is gone has panicked and logged that; the picture goes on.
        if self.scheduled_clips.send(Arc::clone(scheduled)).is_ok()
            && let Some(kept) = &self.kept
        {
            kept.recv().ok();
        }
    }

    /// Ends the thread when it has saved everything.
    pub(crate) fn end(self) {
        drop(self.scheduled_clips);
        self.thread.join().ok();
    }
}

fn save_places(
    mut store: Option<PlaceStore>,
    inbox: &Receiver<Arc<ScheduledClip>>,
    done: Option<&SyncSender<()>>,
    faults: &Faults,
) {
    let mut on_glass: Option<Arc<ScheduledClip>> = None;
    while let Ok(scheduled) = inbox.recv() {
        for scheduled in once(scheduled).chain(inbox.try_iter()) {
            if let Some(ended) = on_glass.replace(scheduled)
                && !ended.is_damaged.load(Ordering::Acquire)
                && let Some(trial) = &ended.trial
            {
                trial.shown();
            }
        }
        if let (Some(store), Some(scheduled)) = (&mut store, &on_glass)
            && let Err(error) = store.save(&scheduled.place.to_bytes())
        {
            faults.once(Kind::Place, "keep", format!("cannot save the walk's place: {}", chain(&error)));
        }
        if let Some(done) = done {
            done.send(()).ok();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::PlaceSaver;
    use crate::recording::faults::Faults;
    use crate::recording::place_store::PlaceStore;
    use crate::stream::scheduled_clip::tests::scheduled_clips;

    #[test]
    fn the_newest_place_is_on_the_disk_when_the_saver_has_ended() {
        for is_synchronous in [false, true] {
            let dir = tempfile::tempdir().unwrap();
            let (store, _) = PlaceStore::open(dir.path()).unwrap();
            let saver = PlaceSaver::start(Some(store), Faults::new(|_| ()), is_synchronous).unwrap();
            let scheduled_clips = scheduled_clips(20, 3);
            for scheduled in &scheduled_clips {
                saver.save(scheduled);
                if is_synchronous {
                    assert_eq!(PlaceStore::open(dir.path()).unwrap().1, Some(scheduled.place.to_bytes()));
                }
            }
            saver.end();
            assert_eq!(PlaceStore::open(dir.path()).unwrap().1, Some(scheduled_clips[19].place.to_bytes()));
        }
    }
}
