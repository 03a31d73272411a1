//! Where decoded frames lie until they are lit.
//!
//! Owns how many are made at a time: when the shelf is full the decoder rests until a batch of them is gone, and then
//! makes that batch in one go: one that is woken for every frame finds its caches taken by others every time, which costs
//! it some 3 in 100. Never fewer lie there than are promised, unless the decoder is too slow. Whoever takes one is never
//! kept waiting by who lays them down.
//!
//! Start at [`shelf`].

use crate::stream::scheduled_clip::Shown;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SendError, SyncSender, TryRecvError, sync_channel};
use std::sync::{Arc, OnceLock};
use std::thread::{self, Thread};
use std::time::Duration;

/// Frames made in one go, beyond those that must lie ready.
const BATCH: usize = 8;

/// Where frames come from.
pub(crate) trait Supply {
    /// The next frame, waiting for it at most `patience`.
    fn next(&mut self, patience: Duration) -> Given;
}

/// What a supply gives.
#[derive(Debug)]
pub(crate) enum Given {
    /// The first frame of the run, ahead of the stream, which brings it again.
    Opening(Shown),
    /// The next frame.
    Frame(Shown),
    /// Nothing yet.
    Nothing,
    /// Nothing, and for now there is nothing to come: no clip can be played.
    Barren,
    /// Nothing ever: the run is complete.
    Finished,
}

/// A shelf on which `ahead` frames lie ready at least: who lays them down, and who takes them.
pub(crate) fn shelf(ahead: usize) -> (Hand, Frames) {
    let (frames, shelf) = sync_channel(ahead + BATCH);
    let count = Arc::new(Count::default());
    let hand = Hand { frames, ahead, count: Arc::clone(&count) };
    (hand, Frames { shelf, ahead, count })
}

/// How many frames lie there, and who rests meanwhile.
#[derive(Debug, Default)]
struct Count {
    lying: AtomicUsize,
    is_closed: AtomicBool,
    resting: OnceLock<Thread>,
}

/// Lays frames down. Belongs to one thread.
#[derive(Debug)]
pub(crate) struct Hand {
    frames: SyncSender<Given>,
    ahead: usize,
    count: Arc<Count>,
}

impl Hand {
    /// Lays one down, after a rest if the shelf is full.
    ///
    /// # Errors
    /// The frame, if nobody will ever take it.
    pub(crate) fn lay(&self, given: Given) -> Result<(), SendError<Given>> {
        let lying = || self.count.lying.load(Ordering::Acquire);
        if lying() >= self.ahead + BATCH {
            self.count.resting.get_or_init(thread::current);
            while lying() > self.ahead && !self.count.is_closed.load(Ordering::Acquire) {
                thread::park();
            }
        }
        self.count.lying.fetch_add(1, Ordering::AcqRel);
        self.frames.send(given)
    }

    /// The way to the shelf for the opening, which does not count.
    pub(crate) fn side(&self) -> SyncSender<Given> {
        self.frames.clone()
    }
}

/// Takes frames. When it goes, nobody rests any more.
#[derive(Debug)]
pub(crate) struct Frames {
    shelf: Receiver<Given>,
    ahead: usize,
    count: Arc<Count>,
}

impl Frames {
    fn wake(&self) {
        if let Some(resting) = self.count.resting.get() {
            resting.unpark();
        }
    }
}

impl Supply for Frames {
    fn next(&mut self, patience: Duration) -> Given {
        let given = if patience.is_zero() {
            self.shelf.try_recv().map_err(|error| matches!(error, TryRecvError::Disconnected))
        } else {
            self.shelf.recv_timeout(patience).map_err(|error| matches!(error, RecvTimeoutError::Disconnected))
        };
        let is_counted = matches!(given, Ok(Given::Frame(_) | Given::Barren));
        if is_counted && self.count.lying.fetch_sub(1, Ordering::AcqRel) == self.ahead + 1 {
            self.wake();
        }
        given.unwrap_or_else(|is_over| if is_over { Given::Finished } else { Given::Nothing })
    }
}

impl Drop for Frames {
    fn drop(&mut self) {
        self.count.is_closed.store(true, Ordering::Release);
        self.wake();
    }
}

#[cfg(test)]
mod tests {
    use super::{BATCH, Given, Supply, shelf};
    use crate::stream::scheduled_clip::tests::{frames, turns};
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::thread;
    use std::time::Duration;

    #[test]
    fn frames_are_made_in_batches_and_never_fewer_lie_ready_than_promised() {
        let (hand, mut taker) = shelf(3);
        let made = &AtomicUsize::new(0);
        thread::scope(|scope| {
            scope.spawn(move || {
                while hand.lay(Given::Frame(frames(&turns(1, 1)).remove(0))).is_ok() {
                    made.fetch_add(1, Ordering::SeqCst);
                }
            });
            let is_there = |wanted: usize| {
                (0..2_000).any(|_| {
                    thread::park_timeout(Duration::from_millis(1));
                    made.load(Ordering::SeqCst) == wanted
                })
            };
            for round in 1..4 {
                assert!(is_there(3 + round * BATCH), "round {round}: {made:?}");
                for taken in 1..=BATCH {
                    assert_eq!(made.load(Ordering::SeqCst), 3 + round * BATCH, "it rests while {taken} are taken");
                    assert!(matches!(taker.next(Duration::ZERO), Given::Frame(_)));
                }
            }
            // Nobody rests for one who is gone.
            assert!(is_there(3 + 4 * BATCH));
            drop(taker);
        });
    }
}
