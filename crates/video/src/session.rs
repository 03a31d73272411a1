//! The endless decoder.
//!
//! Owns one decoder for the whole run: it is fed with the packets of one clip after another and never told that a
//! clip ended, so the last frames of a clip come out when the first packets of the next go in, and none is lost or
//! delayed by a restart. Owns the book-keeping that says which frame belongs to which clip, whatever is damaged.
//! Never waits and never starts a thread of its own: ffmpeg's threads work ahead between two calls of [`Session::poll`].
//!
//! Start at [`Session::poll`].

use crate::clip::{Clip, Next};
use crate::code::Code;
use crate::damage::Damage;
use crate::frame::Frame;
use crate::raw::{Decoder, Packet, Picture, Received, Sent};
use std::collections::VecDeque;
use std::num::NonZero;
use std::sync::Arc;
use timing::{FrameCount, FrameIndex};

/// How many findings are kept per clip: the first ones say it all.
const DAMAGE_KEPT: usize = 8;

/// A clip's place among all clips pushed into a session, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ClipNumber(pub u64);

/// Why a session cannot start or go on. No clip causes this.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SessionError {
    /// The decoder ran out of memory.
    #[error("cannot decode on: {reason}")]
    Decode {
        /// What ffmpeg said.
        reason: String,
    },
    /// ffmpeg has no H.264 decoder, or it cannot start its threads.
    #[error("cannot start the H.264 decoder with {threads} threads: {reason}")]
    Start {
        /// How many were asked for.
        threads: usize,
        /// What ffmpeg said.
        reason: String,
    },
}

/// What a session has next.
#[derive(Debug)]
pub enum Poll {
    /// The next frame.
    Frame(Frame),
    /// All packets are in and more frames will only come after [`Session::push`] or [`Session::finish`].
    Starved,
    /// The last frame of `clip` has come out, or will never come.
    ClipEnd {
        /// The clip.
        clip: ClipNumber,
        /// How many of its frames came out.
        frames: FrameCount,
        /// The first things that were wrong with it, in the order of discovery; empty if nothing was.
        damage: Vec<Damage>,
    },
    /// Everything has come out after [`Session::finish`].
    Finished,
    /// The session cannot go on.
    Failed(SessionError),
}

/// The first frame of `clip`, which has not been played: to the bit what a session will give for it, and at once. A session
/// gives its first frame only when it has seen as many packets as may be reordered, and those at the head of a clip are its
/// largest. `None` if it is not whole, of which the session will tell.
pub fn opening(clip: &Clip) -> Option<Frame> {
    const CLIP: ClipNumber = ClipNumber(0);
    let mut packet = clip.opening()?;
    packet.set_tag(Some(0));
    let mut decoder = Decoder::new(1).ok()?;
    let Sent::Taken = decoder.send(&packet, CLIP.0) else { return None };
    decoder.send_end();
    let Received::Picture(picture) = decoder.receive() else { return None };
    let is_sound = picture.size() == clip.size() && picture.is_yuv420p();
    let damaged = picture.damaged() || decoder.complaints(CLIP.0) > 0;
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
    clips: VecDeque<Playing>,
    /// Answers found and not yet given.
    ready: VecDeque<Poll>,
    /// Tags of the packets sent last, newest last: an error is told [`Decoder::lag`] packets late.
    sent: VecDeque<Option<i64>>,
    pushed: u64,
    /// The first tag of the next clip to be pushed. Every clip owns as many tags as its header promises frames.
    tags: i64,
    delivered: u64,
    finishing: Finishing,
}

/// How far the end of the session is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Finishing {
    No,
    /// No more clips will come.
    Asked,
    /// The decoder knows.
    Draining,
}

/// A clip between its first packet and its last frame.
struct Playing {
    number: ClipNumber,
    /// `None` once all packets are in.
    clip: Option<Clip>,
    /// Its tags are `first .. first + frames`, one per frame in the order of showing.
    first: i64,
    frames: FrameCount,
    size: (u32, u32),
    /// The lowest tag that may still come.
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
        let failed = |code: Code| SessionError::Start { threads: threads.get(), reason: code.to_string() };
        Ok(Self {
            decoder: Decoder::new(threads.get()).map_err(failed)?,
            packet: Packet::new().map_err(failed)?,
            loaded: false,
            loading: 0,
            clips: VecDeque::new(),
            ready: VecDeque::new(),
            sent: VecDeque::new(),
            pushed: 0,
            tags: 0,
            delivered: 0,
            finishing: Finishing::No,
        })
    }

    /// Queues `clip` after all clips pushed before. Without effect after [`Session::finish`] but for its number.
    pub fn push(&mut self, clip: Clip) -> ClipNumber {
        let number = ClipNumber(self.pushed);
        self.pushed += 1;
        if self.finishing == Finishing::No {
            let (first, frames, size) = (self.tags, clip.frames(), clip.size());
            self.tags += i64::from(frames.0);
            let (delivered, damage) = (0, Vec::new());
            self.clips.push_back(Playing {
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
        if self.finishing == Finishing::No {
            self.finishing = Finishing::Asked;
        }
    }

    /// Feeds the decoder until it has something to tell, and tells it.
    pub fn poll(&mut self) -> Poll {
        loop {
            if let Some(answer) = self.ready.pop_front() {
                return answer;
            }
            match self.decoder.receive() {
                Received::Picture(picture) => self.place(picture),
                Received::Hungry if self.load() => {
                    if let Err(code) = self.send() {
                        return failed(code);
                    }
                }
                Received::Hungry if !self.ready.is_empty() => (),
                Received::Hungry if self.finishing == Finishing::No => return Poll::Starved,
                Received::Hungry if self.finishing == Finishing::Asked => {
                    self.finishing = Finishing::Draining;
                    self.decoder.send_end();
                }
                Received::Hungry | Received::End => {
                    self.end_before(self.clips.len());
                    self.ready.push_back(Poll::Finished);
                }
                Received::Failed(Code::NO_MEMORY) => return failed(Code::NO_MEMORY),
                Received::Failed(code) => self.undecodable(code),
            }
        }
    }

    /// Puts the next packet of the oldest clip that has one into `packet`; `false` if there is none.
    fn load(&mut self) -> bool {
        while !self.loaded {
            let Some(playing) = self.clips.iter_mut().find(|playing| playing.clip.is_some()) else { return false };
            if !playing.load(&mut self.packet) {
                self.settle();
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

    /// Offers `packet` to the decoder. Only an error that is no clip's fault comes back.
    fn send(&mut self) -> Result<(), Code> {
        let answer = self.decoder.send(&self.packet, self.loading);
        self.loaded = matches!(answer, Sent::Full);
        match answer {
            Sent::Taken | Sent::Full => Ok(()),
            Sent::Failed(Code::NO_MEMORY) => Err(Code::NO_MEMORY),
            Sent::Failed(code) => {
                self.undecodable(code);
                Ok(())
            }
        }
    }

    /// Gives a picture its place, and ends the clips that it shows to be over.
    fn place(&mut self, picture: Picture) {
        // No tag: a picture that is not shown. A tag that nobody owns: its clip has ended without it.
        let Some(tag) = picture.tag() else { return };
        let Some(at) = self.clips.iter().position(|playing| playing.owns(tag)) else { return };
        if let Err(damage) = self.clips[at].admit(tag, &picture) {
            return self.clips[at].blame(damage);
        }
        self.end_before(at);
        let index = FrameIndex(self.delivered);
        self.delivered += 1;
        let Some(playing) = self.clips.front_mut() else { return };
        let complaints = self.decoder.complaints(playing.number.0);
        let frame = playing.deliver(tag, picture, index, complaints);
        self.ready.push_back(Poll::Frame(frame));
        self.settle();
    }

    /// Lays a decoding error at the door of the clip whose packet it concerns.
    fn undecodable(&mut self, code: Code) {
        let tag = self.sent.front().copied().flatten();
        let owner = self.clips.iter_mut().find(|playing| tag.is_none_or(|tag| playing.owns(tag)));
        if let Some(playing) = owner {
            let frame = tag.map_or(0, |tag| playing.frame(tag));
            playing.blame(Damage::Undecodable { frame, reason: code.to_string() });
        }
    }

    /// Ends the clips from which nothing more can come: all packets are in and the last frame is out.
    fn settle(&mut self) {
        while self.clips.front().is_some_and(Playing::is_over) {
            self.end_before(1);
        }
    }

    /// Ends the `count` oldest clips.
    fn end_before(&mut self, count: usize) {
        for playing in self.clips.drain(..count) {
            let complaints = self.decoder.complaints(playing.number.0);
            self.ready.push_back(playing.end(complaints));
        }
    }
}

impl Playing {
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

    /// Whether the picture may be shown as the frame it calls itself.
    fn admit(&self, tag: i64, picture: &Picture) -> Result<(), Damage> {
        let refuse = |reason| Err(Damage::Misplaced { frame: tag - self.first, reason });
        let ((width, height), (found_width, found_height)) = (self.size, picture.size());
        if tag < self.next {
            return refuse("a later frame has come out already".into());
        }
        if picture.size() != self.size {
            return refuse(format!("it has {found_width}x{found_height} pixels (expected {width}x{height})"));
        }
        if !picture.is_yuv420p() {
            return refuse("its pixels are not 8-bit 4:2:0".into());
        }
        Ok(())
    }

    fn deliver(&mut self, tag: i64, picture: Picture, index: FrameIndex, complaints: u32) -> Frame {
        let in_clip = self.frame(tag);
        let damaged = picture.damaged() || complaints > 0;
        if damaged {
            self.blame(Damage::Guessed { frame: in_clip });
        }
        self.next = tag + 1;
        self.delivered += 1;
        let last = self.next == self.end_tag();
        Frame { picture: Arc::new(picture), index, clip: self.number, in_clip, last, damaged }
    }

    fn blame(&mut self, damage: Damage) {
        if self.damage.len() < DAMAGE_KEPT {
            self.damage.push(damage);
        }
    }

    fn is_over(&self) -> bool {
        self.clip.is_none() && self.next == self.end_tag()
    }

    fn end(mut self, complaints: u32) -> Poll {
        let frames = FrameCount(self.delivered);
        if complaints > 0 {
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
