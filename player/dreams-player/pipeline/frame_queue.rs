//! The queue of decoded frames, from the decoder to the presenter.
//!
//! Owns how many are decoded at a time: when the queue is full the decoder waits until a batch of them is gone, and then
//! decodes that batch without a pause. A decoder that wakes for every frame finds its caches cold each time, which costs
//! it 3 %. The queue never holds fewer than were asked for, unless the decoder is too slow. The presenter never waits for
//! a lock.
//!
//! Start at [`frame_queue`].

use crate::stream::Frame;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SendError, SyncSender, TryRecvError, sync_channel};
use std::sync::{Arc, OnceLock};
use std::thread::{self, Thread};
use std::time::Duration;

/// Frames decoded without a pause, beyond those that must be ready.
const BATCH: usize = 8;

/// Where frames come from.
pub(crate) trait FrameSource {
    /// The next frame, waiting for it at most `patience`.
    fn next(&mut self, patience: Duration) -> NextFrame;
}

/// What a source gives.
#[derive(Debug)]
pub(crate) enum NextFrame {
    /// The first frame of the run, ahead of the stream, which brings it again.
    First(Frame),
    /// The next frame.
    Frame(Frame),
    /// Nothing yet.
    Nothing,
    /// Nothing, and for now there is nothing to come: no clip can be played.
    Barren,
    /// Nothing ever: the run is complete.
    Finished,
}

/// A queue that holds at least `ahead` frames: its two ends.
pub(crate) fn frame_queue(ahead: usize) -> (FrameSender, FrameReceiver) {
    let (frames, receiver) = sync_channel(ahead + BATCH);
    let count = Arc::new(Count::default());
    let sender = FrameSender { frames, ahead, count: Arc::clone(&count) };
    (sender, FrameReceiver { receiver, ahead, count })
}

/// How many frames it holds, and the thread that waits for room.
#[derive(Debug, Default)]
struct Count {
    queued: AtomicUsize,
    is_closed: AtomicBool,
    waiting: OnceLock<Thread>,
}

/// Puts frames into the queue. Belongs to one thread.
#[derive(Debug)]
pub(crate) struct FrameSender {
    frames: SyncSender<NextFrame>,
    ahead: usize,
    count: Arc<Count>,
}

impl FrameSender {
    /// Puts one in; waits first if the queue is full.
    /// Errors: The frame, if the receiver is gone.
    pub(crate) fn push(&self, next: NextFrame) -> Result<(), SendError<NextFrame>> {
        let queued = || self.count.queued.load(Ordering::Acquire);
        if queued() >= self.ahead + BATCH {
            self.count.waiting.get_or_init(thread::current);
            while queued() > self.ahead && !self.count.is_closed.load(Ordering::Acquire) {
                thread::park();
            }
        }
        self.count.queued.fetch_add(1, Ordering::AcqRel);
        self.frames.send(next)
    }

    /// A second sender, for the first frame, which is not counted.
    pub(crate) fn first_frame_sender(&self) -> SyncSender<NextFrame> {
        self.frames.clone()
    }
}

/// Takes frames. When it is dropped, the sender waits no more.
#[derive(Debug)]
pub(crate) struct FrameReceiver {
    receiver: Receiver<NextFrame>,
    ahead: usize,
    count: Arc<Count>,
}

impl FrameReceiver {
    fn wake(&self) {
        if let Some(waiting) = self.count.waiting.get() {
            waiting.unpark();
        }
    }
}

impl FrameSource for FrameReceiver {
    fn next(&mut self, patience: Duration) -> NextFrame {
        let next = if patience.is_zero() {
            self.receiver.try_recv().map_err(|error| matches!(error, TryRecvError::Disconnected))
        } else {
            self.receiver.recv_timeout(patience).map_err(|error| matches!(error, RecvTimeoutError::Disconnected))
        };
        let is_counted = matches!(next, Ok(NextFrame::Frame(_) | NextFrame::Barren));
        if is_counted && self.count.queued.fetch_sub(1, Ordering::AcqRel) == self.ahead + 1 {
            self.wake();
        }
        next.unwrap_or_else(|is_over| if is_over { NextFrame::Finished } else { NextFrame::Nothing })
    }
}

impl Drop for FrameReceiver {
    fn drop(&mut self) {
        self.count.is_closed.store(true, Ordering::Release);
        self.wake();
    }
}

#[cfg(test)]
mod tests {
    use super::{BATCH, FrameSource, NextFrame, frame_queue};
    use crate::stream::scheduled_clip::tests::{frames, scheduled_clips};
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::thread;
    use std::time::Duration;

    #[test]
    fn frames_are_made_in_batches_and_never_fewer_lie_ready_than_promised() {
        let (sender, mut taker) = frame_queue(3);
        let made = &AtomicUsize::new(0);
        thread::scope(|scope| {
            scope.spawn(move || {
                while sender.push(NextFrame::Frame(frames(&scheduled_clips(1, 1)).remove(0))).is_ok() {
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
                    assert!(matches!(taker.next(Duration::ZERO), NextFrame::Frame(_)));
                }
            }
            // The sender does not wait for a receiver that is gone.
            assert!(is_there(3 + 4 * BATCH));
            drop(taker);
        });
    }
}
