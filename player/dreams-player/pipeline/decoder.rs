//! The decoder thread: makes frames of clips, ahead of the screen.
//!
//! Owns the one endless decoder session and keeps it fed with clips long before it needs them. Never opens a clip:
//! `clip_source.rs` does. The frames wait in the queue for the flip thread; when it is full, this thread waits.

use crate::pipeline::frame_queue::{FrameSender, NextFrame};
use crate::pipeline::start_gate::StartGate;
use crate::recording::{Faults, Kind};
use crate::stream::{Frame, Pixels, ScheduledClip};
use diagnostics::chain;
use player::{ThreadError, threads};
use std::collections::VecDeque;
use std::num::NonZero;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, Sender, TryRecvError};
use std::thread::JoinHandle;
use timing::FrameCount;
use video::{Clip, ClipNumber, Poll, Session, SessionError};

/// What the clip source orders.
pub(crate) enum Order {
    /// Play this clip when all before it are over.
    Play(Clip, Arc<ScheduledClip>),
    /// Play what was ordered to its end, and pass on that there is nothing more for now.
    Barren,
    /// Play what was ordered to its end, so that all its clips end.
    Rest,
}

/// How a clip ended.
#[derive(Debug)]
pub(crate) struct ClipEnd {
    pub(crate) scheduled: Arc<ScheduledClip>,
    /// How many of its frames came out.
    pub(crate) frames: FrameCount,
    pub(crate) is_damaged: bool,
}

/// How many clips may have gone in whole while nothing comes out, beyond the decoder's threads: an H.264 decoder holds
/// back 16 pictures at most. More are clips without a picture, of which it would never tell.
const STUCK_AFTER: usize = 24;

/// How frames are made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DecoderSettings {
    /// Decoder threads.
    pub(crate) threads: NonZero<usize>,
    /// For how long the opened clips beyond the one being decoded are to last.
    pub(crate) prefetch_ms: u64,
    /// Whether every frame is hashed.
    pub(crate) is_hashed: bool,
}

impl DecoderSettings {
    /// Starts the thread. It ends when the orders do, and then says why if it had to end before.
    pub(crate) fn open(
        self,
        frames: FrameSender,
        orders: Receiver<Order>,
        clip_ends: Sender<ClipEnd>,
        faults: Faults,
        gate: Arc<StartGate>,
    ) -> Result<JoinHandle<Result<(), SessionError>>, ThreadError> {
        let decode = move || {
            let session = Session::new(self.threads)?;
            let (scheduled_clips, rest) = (VecDeque::new(), None);
            Decoder { session, orders, scheduled_clips, rest, frames, made: 0, settings: self, clip_ends, faults, gate }
                .work()
        };
        threads::start("decoder", decode)
    }
}

struct Decoder {
    session: Session,
    orders: Receiver<Order>,
    /// Clips that have not ended, oldest first.
    scheduled_clips: VecDeque<(ClipNumber, Arc<ScheduledClip>)>,
    /// The session is to come to its end before more is ordered.
    rest: Option<Rest>,
    frames: FrameSender,
    made: u64,
    settings: DecoderSettings,
    clip_ends: Sender<ClipEnd>,
    faults: Faults,
    gate: Arc<StartGate>,
}

/// What comes after a rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rest {
    /// A new session, for more clips.
    Onward,
    /// The same, but first the presenter learns that there is nothing more for now.
    Barren,
}

/// The flip thread has ended: no frame is needed any more.
struct NoReceiver;

impl Decoder {
    fn work(mut self) -> Result<(), SessionError> {
        let mut may_order = true;
        loop {
            while may_order && self.rest.is_none() && self.prefetched_ms() < self.settings.prefetch_ms {
                match self.orders.try_recv() {
                    Ok(order) => self.take(order),
                    Err(TryRecvError::Empty) => break,
                    Err(TryRecvError::Disconnected) => may_order = false,
                }
            }
            if self.is_stuck() {
                self.rest.get_or_insert(Rest::Onward);
            }
            if !may_order || self.rest.is_some() {
                self.session.finish();
            }
            match self.session.poll() {
                Poll::Frame(frame) => {
                    if self.hand_over(frame).is_err() {
                        return Ok(());
                    }
                }
                Poll::Starved => may_order = self.orders.recv().map(|order| self.take(order)).is_ok(),
                Poll::ClipEnd { frames, damage, .. } => self.clip_end(frames, damage.first()),
                Poll::Finished if !may_order => return Ok(()),
                Poll::Finished => {
                    if self.rest.take() == Some(Rest::Barren) && self.frames.push(NextFrame::Barren).is_err() {
                        return Ok(());
                    }
                    self.session = Session::new(self.settings.threads)?;
                }
                Poll::Failed(error) => return Err(error),
            }
        }
    }

    /// Whether so many clips have gone in without an answer that there will be none.
    fn is_stuck(&self) -> bool {
        self.scheduled_clips.len() - self.session.queued().min(self.scheduled_clips.len())
            > STUCK_AFTER + self.settings.threads.get()
    }

    /// For how long the opened clips beyond the one being decoded will last.
    fn prefetched_ms(&self) -> u64 {
        let lasts_ms = |scheduled: &ScheduledClip| {
            let fps = scheduled.flock.manifest().fps;
            1_000 * u64::from(scheduled.frames.0) * u64::from(fps.den()) / u64::from(fps.num())
        };
        self.scheduled_clips.iter().skip(1).map(|(_, scheduled)| lasts_ms(scheduled)).sum()
    }

    fn take(&mut self, order: Order) {
        match order {
            Order::Play(clip, scheduled) => self.scheduled_clips.push_back((self.session.push(clip), scheduled)),
            Order::Barren => self.rest = Some(Rest::Barren),
            Order::Rest => self.rest = Some(Rest::Onward),
        }
    }

    fn hand_over(&mut self, frame: video::Frame) -> Result<(), NoReceiver> {
        let scheduled = self
            .scheduled_clips
            .iter()
            .find(|(clip, _)| *clip == frame.clip())
            .map(|(_, scheduled)| Arc::clone(scheduled));
        let (in_clip, index) = (frame.in_clip(), self.made);
        self.made += 1;
        let pixels = Pixels::Decoded(frame);
        let hash = self.settings.is_hashed.then(|| pixels.md5());
        self.frames
            .push(NextFrame::Frame(Frame { pixels, scheduled, in_clip, index, hash }))
            .map_err(|_| NoReceiver)?;
        if index == 0 {
            self.gate.wait();
        }
        Ok(())
    }

    /// Passes the end of the oldest clip on, and adds a fault if it is damaged.
    fn clip_end(&mut self, frames: FrameCount, damage: Option<&video::Damage>) {
        let Some((_, scheduled)) = self.scheduled_clips.pop_front() else { return };
        if let Some(damage) = damage {
            let clip = scheduled.clip.as_str();
            self.faults.once(Kind::DamagedClip, clip, format!("clip `{clip}` is damaged: {}", chain(damage)));
            scheduled.is_damaged.store(true, Ordering::Release);
        }
        // The clip source may have ordered its last clip and be gone.
        self.clip_ends.send(ClipEnd { scheduled, frames, is_damaged: damage.is_some() }).ok();
    }
}

#[cfg(test)]
mod tests {
    use super::{DecoderSettings, Order};
    use crate::pipeline::frame_queue::{FrameSource, NextFrame, frame_queue};
    use crate::pipeline::grey_clip::{SIZE, encode};
    use crate::pipeline::start_gate::StartGate;
    use crate::recording::Faults;
    use crate::stream::scheduled_clip::tests::scheduled_clips;
    use std::num::NonZero;
    use std::path::Path;
    use std::sync::Arc;
    use std::sync::mpsc::{channel, sync_channel};
    use std::time::Duration;
    use std::{fs, thread};
    use timing::{FrameCount, Rate};
    use video::{Clip, Form};

    /// Makes a clip that can be opened and shows nothing: every slice is filled with ones.
    fn empty(clip: &Path) {
        encode(clip);
        let mut bytes = fs::read(clip).unwrap();
        let data = bytes.windows(4).position(|name| name == b"mdat").unwrap();
        let size = u32::from_be_bytes(bytes[data - 4..data].try_into().unwrap()) as usize;
        let (mut at, end) = (data + 4, data - 4 + size);
        while at < end {
            let length = u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
            if [1, 5].contains(&(bytes[at + 4] & 0x1f)) {
                bytes[at + 5..at + 4 + length].fill(0xff);
            }
            at += 4 + length;
        }
        fs::write(clip, bytes).unwrap();
    }

    #[test]
    fn clips_that_decode_to_nothing_are_reported_and_the_next_good_one_is_shown_whole() {
        let folder = tempfile::tempdir().unwrap();
        let (good, bad) = (folder.path().join("good.mp4"), folder.path().join("bad.mp4"));
        encode(&good);
        empty(&bad);
        for threads in [1, 4] {
            let (orders, inbox) = sync_channel(1);
            let (clip_ends, ends) = channel();
            let settings =
                DecoderSettings { threads: NonZero::new(threads).unwrap(), prefetch_ms: 60, is_hashed: false };
            let faults = Faults::new(|_| ());
            let gate = Arc::new(StartGate::default());
            gate.open();
            let (sender, mut frames) = frame_queue(8);
            let decoder = settings.open(sender, inbox, clip_ends, faults.clone(), gate).unwrap();
            let (good, bad) = (good.clone(), bad.clone());
            let clip_source = thread::spawn(move || {
                let form = Form { size: SIZE, fps: Rate::new(30, 1).unwrap() };
                let order = |path, scheduled| Order::Play(Clip::open(path, &form, FrameCount(2)).unwrap(), scheduled);
                let mut scheduled_clips = scheduled_clips(200, 2).into_iter();
                // No more is ordered than a decoder may hold back and a few.
                for scheduled in scheduled_clips.by_ref().take(60) {
                    orders.send(order(&bad, scheduled)).unwrap();
                }
                let first = ends.recv_timeout(Duration::from_secs(10)).expect("it is told while orders may come");
                assert!(first.frames == FrameCount(0) && first.is_damaged && first.scheduled.number == 1);
                orders.send(order(&good, scheduled_clips.next().unwrap())).unwrap();
                drop(orders);
                ends.iter().map(|end| end.frames.0).sum::<u32>()
            });
            let shown: Vec<_> = std::iter::from_fn(|| match frames.next(Duration::from_secs(20)) {
                NextFrame::Frame(frame) => Some((frame.scheduled.unwrap().number, frame.in_clip)),
                NextFrame::First(_) | NextFrame::Nothing | NextFrame::Barren | NextFrame::Finished => None,
            })
            .collect();
            assert_eq!(shown, [(61, 0), (61, 1)], "{threads} threads");
            assert_eq!(clip_source.join().unwrap(), 2);
            decoder.join().unwrap().unwrap();
            assert_eq!(faults.count(), 1, "one clip is bad");
        }
    }
}
