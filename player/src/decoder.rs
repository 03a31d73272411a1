//! The decoder thread: turns clips into frames, ahead of the glass.
//!
//! Owns the one endless decoder session and keeps it fed with clips long before it needs them. Never opens a clip:
//! `library.rs` does. The frames wait in a bounded channel for the flip thread, which is what holds this thread back.

use crate::faults::{Faults, Kind};
use crate::report::{Fatal, chain};
use crate::show::{Given, Supply};
use crate::turn::{Shown, Still, Turn};
use flock::ClipPath;
use md5::{Digest, Md5};
use screen::Picture;
use std::collections::VecDeque;
use std::num::NonZero;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, TryRecvError, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;
use timing::Rate;
use video::{Clip, ClipNumber, Poll, Session, SessionError};

/// What the library orders.
pub(crate) enum Order {
    /// Play this clip when all before it are over.
    Play(Clip, Arc<Turn>),
    /// There is nothing to play for now.
    Barren,
}

/// How frames are made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Workshop {
    /// Decoder threads.
    pub(crate) threads: NonZero<usize>,
    /// Frames decoded ahead.
    pub(crate) ahead: usize,
    /// How many frames beyond the clip being decoded are to lie ready in opened clips.
    pub(crate) prefetch: u64,
    /// Whether every frame is hashed.
    pub(crate) is_hashed: bool,
}

impl Workshop {
    /// How many frames `prefetch_ms` are at `fps`, rounded up.
    pub(crate) fn frames_in(prefetch_ms: u64, fps: Rate) -> u64 {
        (prefetch_ms * u64::from(fps.num())).div_ceil(1_000 * u64::from(fps.den()))
    }

    /// Starts the thread. It ends when the orders do, and then says why if it had to end before.
    ///
    /// # Errors
    /// [`Fatal`] if the thread cannot be started.
    pub(crate) fn open(
        self,
        orders: Receiver<Order>,
        bad: Sender<ClipPath>,
        faults: Faults,
    ) -> Result<(Frames, JoinHandle<Result<(), SessionError>>), Fatal> {
        // One more lies in the decoder's hand, waiting for its place on the shelf.
        let (frames, shelf) = sync_channel(self.ahead.saturating_sub(1));
        let decode = move || {
            let session = Session::new(self.threads)?;
            Bench { session, orders, turns: VecDeque::new(), frames, made: 0, workshop: self, bad, faults }.work()
        };
        let thread = thread::Builder::new().name("decoder".to_owned()).spawn(decode);
        Ok((Frames(shelf), thread.map_err(|source| Fatal::Thread { name: "decoder", source })?))
    }
}

/// The frames that lie ready.
#[derive(Debug)]
pub(crate) struct Frames(Receiver<Given>);

impl Supply for Frames {
    fn next(&mut self, patience: Duration) -> Given {
        let given = if patience.is_zero() {
            self.0.try_recv().map_err(|error| matches!(error, TryRecvError::Disconnected))
        } else {
            self.0.recv_timeout(patience).map_err(|error| matches!(error, RecvTimeoutError::Disconnected))
        };
        given.unwrap_or_else(|is_over| if is_over { Given::Finished } else { Given::Nothing })
    }
}

struct Bench {
    session: Session,
    orders: Receiver<Order>,
    /// Clips that have not ended, oldest first.
    turns: VecDeque<(ClipNumber, Arc<Turn>)>,
    frames: SyncSender<Given>,
    made: u64,
    workshop: Workshop,
    bad: Sender<ClipPath>,
    faults: Faults,
}

/// The flip thread is gone: there is nobody to decode for.
struct Unwanted;

impl Bench {
    fn work(mut self) -> Result<(), SessionError> {
        let mut may_order = true;
        loop {
            while may_order && self.prefetched() < self.workshop.prefetch {
                may_order = match self.orders.try_recv() {
                    Ok(order) => self.take(order).is_ok(),
                    Err(TryRecvError::Empty) => break,
                    Err(TryRecvError::Disconnected) => false,
                };
            }
            if !may_order {
                self.session.finish();
            }
            match self.session.poll() {
                Poll::Frame(frame) => {
                    if self.hand_over(frame).is_err() {
                        return Ok(());
                    }
                }
                Poll::Starved => may_order = self.orders.recv().is_ok_and(|order| self.take(order).is_ok()),
                Poll::ClipEnd { damage, .. } => {
                    if let (Some((_, turn)), Some(first)) = (self.turns.pop_front(), damage.first()) {
                        self.blame(&turn, first);
                    }
                }
                Poll::Finished => return Ok(()),
                Poll::Failed(error) => return Err(error),
            }
        }
    }

    /// How many frames lie in opened clips beyond the one being decoded.
    fn prefetched(&self) -> u64 {
        self.turns.iter().skip(1).map(|(_, turn)| u64::from(turn.frames.0)).sum()
    }

    fn take(&mut self, order: Order) -> Result<(), Unwanted> {
        match order {
            Order::Play(clip, turn) => {
                self.turns.push_back((self.session.push(clip), turn));
                Ok(())
            }
            Order::Barren => self.frames.send(Given::Barren).map_err(|_| Unwanted),
        }
    }

    fn hand_over(&mut self, frame: video::Frame) -> Result<(), Unwanted> {
        let turn = self.turns.iter().find(|(clip, _)| *clip == frame.clip()).map(|(_, turn)| Arc::clone(turn));
        let (number, index) = (frame.in_clip(), self.made);
        self.made += 1;
        let still = Still::Decoded(frame);
        let hash = self.workshop.is_hashed.then(|| md5(&still.picture()));
        self.frames.send(Given::Frame(Shown { still, turn, frame: number, index, hash })).map_err(|_| Unwanted)
    }

    /// Tells once that a clip is damaged, and has it struck from the path.
    fn blame(&self, turn: &Turn, damage: &video::Damage) {
        let clip = turn.clip.as_str();
        self.faults.once(Kind::DamagedClip, clip, format!("clip `{clip}` is damaged: {}", chain(damage)));
        // The library may have ordered its last clip and be gone.
        self.bad.send(turn.clip.clone()).ok();
    }
}

/// The MD5 of a picture's visible planes, as ffmpeg's framemd5 has it.
fn md5(picture: &Picture<'_>) -> [u8; 16] {
    let mut md5 = Md5::new();
    for row in (0..3).flat_map(|plane| picture.rows(plane)) {
        md5.update(row);
    }
    md5.finalize().into()
}

#[cfg(test)]
mod tests {
    use super::{Workshop, md5};
    use screen::Picture;
    use timing::Rate;

    #[test]
    fn padding_is_not_hashed() {
        let tight = Picture { width: 4, height: 2, planes: [b"abcdefgh", b"ij", b"kl"], strides: [4, 2, 2] };
        let padded = Picture { planes: [b"abcd..efgh", b"ij..", b"kl.."], strides: [6, 4, 4], ..tight };
        assert_eq!(md5(&tight), md5(&padded));
        // `printf abcdefghijkl | md5sum`
        let expected = 0x9fc9_d606_9120_30dc_a865_82ed_6259_5cf7_u128;
        assert_eq!(u128::from_be_bytes(md5(&tight)), expected);
    }

    #[test]
    fn prefetched_time_is_rounded_up_to_whole_frames() {
        assert_eq!(Workshop::frames_in(2_000, Rate::new(30, 1).unwrap()), 60);
        assert_eq!(Workshop::frames_in(2_000, Rate::new(24_000, 1_001).unwrap()), 48);
    }
}
