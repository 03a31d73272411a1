//! The endless decoder.
//!
//! Owns one decoder for the whole run: it receives the packets of one clip after another and is not flushed between
//! them, so the last frames of a clip come out when the first packets of the next go in, and none is lost or delayed by
//! a restart. Owns the mapping of frames to clips, also where clips are damaged. It does not wait and starts no thread:
//! ffmpeg's threads work ahead between two calls of [`Session::poll`].
//!
//! Start at [`Session::poll`].

use crate::clip::{Clip, Next};
use crate::code::Code;
use crate::damage::Damage;
use crate::frame::Frame;
use crate::raw::{Decoder, Packet, Picture, ReceiveResult, SendResult};
use std::collections::VecDeque;
use std::num::NonZero;
use std::sync::Arc;
use timing::{FrameCount, FrameIndex};

/// How many damages are kept per clip: the first ones suffice.
const MAX_DAMAGE: usize = 8;

/// A clip's place among all clips pushed into a session, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ClipNumber(pub u64);

/// Why a session cannot start or continue. A clip never causes this.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SessionError {
    /// The decoder ran out of memory.
    #[error("cannot continue decoding: {reason}")]
    Decode {
        /// The message of ffmpeg.
        reason: String,
    },
    /// ffmpeg has no H.264 decoder, or it cannot start its threads.
    #[error("cannot start the H.264 decoder with {threads} threads: {reason}")]
    Start {
        /// How many were asked for.
        threads: usize,
        /// The message of ffmpeg.
        reason: String,
    },
}

/// The next result of a session.
#[derive(Debug)]
pub enum Poll {
    /// The next frame.
    Frame(Frame),
    /// All packets are in and more frames will only come after [`Session::push`] or [`Session::finish`].
    Starved,
    /// `clip` has ended: its last frame was returned, or is missing.
    ClipEnd {
        /// The clip.
        clip: ClipNumber,
        /// How many of its frames came out.
        frames: FrameCount,
        /// The first damages found; empty if there were none.
        damage: Vec<Damage>,
    },
    /// All frames were returned after [`Session::finish`].
    Finished,
    /// The session cannot go on.
    Failed(SessionError),
}

/// Decodes the first frame of `clip`, which has not been played, at once and bit-exact. A session returns its first
/// frame only after as many packets as may be reordered, and those at the start of a clip are its largest. `None` if
/// the frame is damaged, which the session will report.
pub fn first_frame(clip: &Clip) -> Option<Frame> {
    const CLIP: ClipNumber = ClipNumber(0);
    let mut packet = clip.first_packet()?;
    packet.set_tag(Some(0));
    let mut decoder = Decoder::new(1, false).ok()?;
    let SendResult::Taken = decoder.send(&packet, CLIP.0) else { return None };
    decoder.send_end();
    let ReceiveResult::Picture(picture) = decoder.receive() else { return None };
    let is_sound = picture.size() == clip.size() && picture.is_yuv420p();
    let damaged = picture.is_damaged() || decoder.error_count(CLIP.0) > 0;
    let last = clip.frames() == FrameCount(1);
    (is_sound && !damaged).then(|| Frame {
        picture: Arc::new(picture),
        index: FrameIndex(0),
        clip: CLIP,
        in_clip: 0,
        last,
        damaged,
    })
}

/// One endless decoder. Frames come in order, each once, each with its clip.
pub struct Session {
    decoder: Decoder,
    packet: Packet,
    /// Whether `packet` waits for room in the decoder.
    loaded: bool,
    /// The clip that `packet` is of.
    loading: u64,
    /// Clips that have not ended, oldest first; only the newest ones still hold packets.
    clips: VecDeque<ActiveClip>,
    /// Results that were not yet returned.
    ready: VecDeque<Poll>,
    /// Tags of the packets sent last, newest last: an error is reported [`Decoder::lag`] packets late.
    sent: VecDeque<Option<i64>>,
    pushed: u64,
    /// The first tag of the next clip to be pushed. Every clip owns as many tags as its header promises frames.
    tags: i64,
    delivered: u64,
    finishing: EndState,
}

/// How far the end of the session is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum EndState {
    No,
    /// No more clips will come.
    Asked,
    /// The decoder knows.
    Draining,
}

/// A clip between its first packet and its last frame.
struct ActiveClip {
    number: ClipNumber,
    /// `None` once all packets are in.
    clip: Option<Clip>,
    /// Its tags are `first .. first + frames`, one per frame in the order of showing.
    first: i64,
    frames: FrameCount,
    size: (u32, u32),
    /// The lowest tag still expected.
    next: i64,
    delivered: u32,
    damage: Vec<Damage>,
}

impl Session {
    /// A session whose decoder works on `threads` frames at a time. Each thread beyond the first delays the frames by
    /// one packet and costs a few frames of memory.
    ///
    /// # Errors
    /// [`SessionError::Start`].
    pub fn new(threads: NonZero<usize>) -> Result<Self, SessionError> {
        Self::start(threads, false)
    }

    /// The same, with frames that tell their [`Frame::quantiser`], which costs time.
    ///
    /// # Errors
    /// [`SessionError::Start`].
    pub fn with_quantisers(threads: NonZero<usize>) -> Result<Self, SessionError> {
        Self::start(threads, true)
    }

    fn start(threads: NonZero<usize>, quantisers: bool) -> Result<Self, SessionError> {
        let failed = |code: Code| SessionError::Start { threads: threads.get(), reason: code.to_string() };
        Ok(Self {
            decoder: Decoder::new(threads.get(), quantisers).map_err(failed)?,
            packet: Packet::new().map_err(failed)?,
            loaded: false,
            loading: 0,
            clips: VecDeque::new(),
            ready: VecDeque::new(),
            sent: VecDeque::new(),
            pushed: 0,
            tags: 0,
            delivered: 0,
            finishing: EndState::No,
        })
    }

    /// Queues `clip` after all clips pushed before. Without effect after [`Session::finish`] but for its number.
    pub fn push(&mut self, clip: Clip) -> ClipNumber {
        let number = ClipNumber(self.pushed);
        self.pushed += 1;
        if self.finishing == EndState::No {
            let (first, frames, size) = (self.tags, clip.frames(), clip.size());
            self.tags += i64::from(frames.0);
            let (delivered, damage) = (0, Vec::new());
            self.clips.push_back(ActiveClip {
                number,
                clip: Some(clip),
                first,
                frames,
                size,
                next: first,
                delivered,
                damage,
            });
        }
        number
    }

    /// How many clips still hold packets, counting the one being read.
    pub fn queued(&self) -> usize {
        self.clips.iter().filter(|playing| playing.clip.is_some()).count()
    }

    /// No more clips: the last frames come out, then [`Poll::Finished`] for ever.
    pub fn finish(&mut self) {
        if self.finishing == EndState::No {
            self.finishing = EndState::Asked;
        }
    }

    /// Feeds the decoder until there is a result, and returns it.
    pub fn poll(&mut self) -> Poll {
        loop {
            if let Some(answer) = self.ready.pop_front() {
                return answer;
            }
            match self.decoder.receive() {
                ReceiveResult::Picture(picture) => self.place(picture),
                ReceiveResult::NeedsInput if self.load() => {
                    if let Err(code) = self.send() {
                        return failed(code);
                    }
                }
                ReceiveResult::NeedsInput if !self.ready.is_empty() => (),
                ReceiveResult::NeedsInput if self.finishing == EndState::No => return Poll::Starved,
                ReceiveResult::NeedsInput if self.finishing == EndState::Asked => {
                    self.finishing = EndState::Draining;
                    self.decoder.send_end();
                }
                ReceiveResult::NeedsInput | ReceiveResult::End => {
                    self.end_before(self.clips.len());
                    self.ready.push_back(Poll::Finished);
                }
                ReceiveResult::Failed(Code::NO_MEMORY) => return failed(Code::NO_MEMORY),
                ReceiveResult::Failed(code) => self.on_decode_error(code),
            }
        }
    }

    /// Puts the next packet of the oldest clip that has one into `packet`; `false` if there is none.
    fn load(&mut self) -> bool {
        while !self.loaded {
            let Some(playing) = self.clips.iter_mut().find(|playing| playing.clip.is_some()) else { return false };
            if !playing.load(&mut self.packet) {
                self.end_finished_clips();
                continue;
            }
            (self.loaded, self.loading) = (true, playing.number.0);
            self.sent.push_back(self.packet.pts());
            if self.sent.len() > self.decoder.lag() + 1 {
                self.sent.pop_front();
            }
        }
        true
    }

    /// Sends `packet` to the decoder. Only errors that no clip causes are returned.
    fn send(&mut self) -> Result<(), Code> {
        let answer = self.decoder.send(&self.packet, self.loading);
        self.loaded = matches!(answer, SendResult::Full);
        match answer {
            SendResult::Taken | SendResult::Full => Ok(()),
            SendResult::Failed(Code::NO_MEMORY) => Err(Code::NO_MEMORY),
            SendResult::Failed(code) => {
                self.on_decode_error(code);
                Ok(())
            }
        }
    }

    /// Assigns a picture to its clip, and ends the clips before that.
    fn place(&mut self, picture: Picture) {
        // No tag: a picture that is not shown. A tag without an owner: its clip has ended already.
        let Some(tag) = picture.tag() else { return };
        let Some(at) = self.clips.iter().position(|playing| playing.owns(tag)) else { return };
        if let Err(damage) = self.clips[at].check_picture(tag, &picture) {
            return self.clips[at].blame(damage);
        }
        self.end_before(at);
        let index = FrameIndex(self.delivered);
        self.delivered += 1;
        let Some(playing) = self.clips.front_mut() else { return };
        let error_count = self.decoder.error_count(playing.number.0);
        let frame = playing.deliver(tag, picture, index, error_count);
        self.ready.push_back(Poll::Frame(frame));
        self.end_finished_clips();
    }

    /// Adds a decoding error to the damage of the clip whose packet caused it.
    fn on_decode_error(&mut self, code: Code) {
        let tag = self.sent.front().copied().flatten();
        let owner = self.clips.iter_mut().find(|playing| tag.is_none_or(|tag| playing.owns(tag)));
        if let Some(playing) = owner {
            let frame = tag.map_or(0, |tag| playing.frame(tag));
            playing.blame(Damage::Undecodable { frame, reason: code.to_string() });
        }
    }

    /// Ends the clips from which nothing more can come: all packets are in and the last frame is out.
    fn end_finished_clips(&mut self) {
        while self.clips.front().is_some_and(ActiveClip::is_over) {
            self.end_before(1);
        }
    }

    /// Ends the `count` oldest clips.
    fn end_before(&mut self, count: usize) {
        for playing in self.clips.drain(..count) {
            let error_count = self.decoder.error_count(playing.number.0);
            self.ready.push_back(playing.end(error_count));
        }
    }
}

impl ActiveClip {
    /// Reads the next packet and gives it its tag; `false` if there are no more.
    fn load(&mut self, packet: &mut Packet) -> bool {
        let Some(mut clip) = self.clip.take() else { return false };
        let next = clip.next(packet, &mut |damage| self.blame(damage));
        packet.set_tag(match next {
            Next::Packet(frame) => Some(self.first + i64::from(frame)),
            Next::Hidden => None,
            Next::End => return false,
        });
        self.clip = Some(clip);
        true
    }

    fn owns(&self, tag: i64) -> bool {
        (self.first..self.end_tag()).contains(&tag)
    }

    fn end_tag(&self) -> i64 {
        self.first + i64::from(self.frames.0)
    }

    /// The frame of the clip that `tag` stands for.
    fn frame(&self, tag: i64) -> u32 {
        u32::try_from(tag - self.first).unwrap_or(0)
    }

    /// Checks that the picture's tag and size fit the clip.
    fn check_picture(&self, tag: i64, picture: &Picture) -> Result<(), Damage> {
        let refuse = |reason| Err(Damage::Misplaced { frame: tag - self.first, reason });
        let ((width, height), (found_width, found_height)) = (self.size, picture.size());
        if tag < self.next {
            return refuse("a later frame was already returned".into());
        }
        if picture.size() != self.size {
            return refuse(format!("it has {found_width}x{found_height} pixels (expected {width}x{height})"));
        }
        if !picture.is_yuv420p() {
            return refuse("its pixels are not 8-bit 4:2:0".into());
        }
        Ok(())
    }

    fn deliver(&mut self, tag: i64, picture: Picture, index: FrameIndex, error_count: u32) -> Frame {
        let in_clip = self.frame(tag);
        let damaged = picture.is_damaged() || error_count > 0;
        if damaged {
            self.blame(Damage::Guessed { frame: in_clip });
        }
        self.next = tag + 1;
        self.delivered += 1;
        let last = self.next == self.end_tag();
        Frame { picture: Arc::new(picture), index, clip: self.number, in_clip, last, damaged }
    }

    fn blame(&mut self, damage: Damage) {
        if self.damage.len() < MAX_DAMAGE {
            self.damage.push(damage);
        }
    }

    fn is_over(&self) -> bool {
        self.clip.is_none() && self.next == self.end_tag()
    }

    fn end(mut self, error_count: u32) -> Poll {
        let frames = FrameCount(self.delivered);
        if error_count > 0 {
            self.blame(Damage::Guessed { frame: self.frame(self.next - 1) });
        }
        if frames != self.frames {
            self.damage.push(Damage::TooFew { expected: self.frames, found: frames });
        }
        Poll::ClipEnd { clip: self.number, frames, damage: self.damage }
    }
}

fn failed(code: Code) -> Poll {
    Poll::Failed(SessionError::Decode { reason: code.to_string() })
}
