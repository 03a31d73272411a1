//! A clip that is scheduled to play, a frame of it, and the plan of the clips to come.
//!
//! Owns what travels with a frame from the decoder to the screen. Never owns a thread: `clip_source.rs` makes scheduled
//! clips, `decoder.rs` frames, and `presenter.rs` shows these.

use crate::stream::fault_card::FaultCard;
use crate::stream::generation::Trial;
use flock::{ClipKind, ClipPath, Flock, Place};
use md5::{Digest, Md5};
use player::hold;
use screen::Picture;
use std::collections::VecDeque;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use timing::FrameCount;

/// A clip, scheduled at one place in the run.
#[derive(Debug)]
pub(crate) struct ScheduledClip {
    /// From 1 in this run; a clip of a higher number plays later.
    pub(crate) number: u64,
    /// The clip, as the manifest names it.
    pub(crate) clip: ClipPath,
    /// How many frames the manifest promises.
    pub(crate) frames: FrameCount,
    /// Which sheep it shows.
    pub(crate) what: ClipKind,
    /// Where the walk stands: resumed from here it plays this clip first.
    pub(crate) place: Place,
    /// The flock that it is of.
    pub(crate) flock: Arc<Flock>,
    /// The trial that it counts for when it was shown to its end.
    pub(crate) trial: Option<Arc<Trial>>,
    /// It did not decode cleanly. Known before its last frame is lit.
    pub(crate) is_damaged: AtomicBool,
}

/// The clips that are scheduled and not over, in their order.
#[derive(Debug, Default)]
pub(crate) struct Plan(Mutex<VecDeque<Arc<ScheduledClip>>>);

impl Plan {
    /// Adds a clip, and forgets those up to the clip `on_screen`.
    pub(crate) fn add(&self, scheduled: Arc<ScheduledClip>, on_screen: Option<u64>) {
        let mut plan = hold(&self.0);
        plan.retain(|scheduled| Some(scheduled.number) > on_screen);
        plan.push_back(scheduled);
    }

    /// Removes a clip that ended without a picture.
    pub(crate) fn remove(&self, number: u64) {
        hold(&self.0).retain(|scheduled| scheduled.number != number);
    }

    /// The clip that follows clip `number`, if it is planned.
    pub(crate) fn after(&self, number: u64) -> Option<Arc<ScheduledClip>> {
        hold(&self.0).iter().find(|scheduled| scheduled.number > number).map(Arc::clone)
    }
}

/// A frame to show: cheap to clone, its pixels are shared.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    /// The pixels.
    pub(crate) pixels: Pixels,
    /// The clip that it is of; `None` for the fault card.
    pub(crate) scheduled: Option<Arc<ScheduledClip>>,
    /// Its number in its clip, from 0.
    pub(crate) in_clip: u32,
    /// Its number in the run, from 0: a gap would be a frame that was decoded and never lit.
    pub(crate) index: u64,
    /// The MD5 of its visible planes, if the run is hashed.
    pub(crate) hash: Option<[u8; 16]>,
}

impl Frame {
    /// Whether `other` is the same frame of the same scheduled clip.
    pub(crate) fn is(&self, other: &Self) -> bool {
        let number = |shown: &Self| shown.scheduled.as_ref().map(|scheduled| scheduled.number);
        number(self).is_some() && (number(self), self.in_clip) == (number(other), other.in_clip)
    }
}

/// Where pixels come from.
#[derive(Clone, Debug)]
pub(crate) enum Pixels {
    /// A clip.
    Decoded(video::Frame),
    /// A drawing of our own.
    Drawn(Arc<FaultCard>),
}

impl Pixels {
    /// The pixels, as a screen takes them.
    pub(crate) fn picture(&self) -> Picture<'_> {
        match self {
            Self::Decoded(frame) => {
                let (width, height) = frame.size();
                Picture { width, height, planes: frame.planes(), strides: frame.strides() }
            }
            Self::Drawn(card) => card.picture(),
        }
    }

    /// The MD5 of its visible planes, as ffmpeg's framemd5 has it.
    pub(crate) fn md5(&self) -> [u8; 16] {
        md5(&self.picture())
    }
}

fn md5(picture: &Picture<'_>) -> [u8; 16] {
    let mut md5 = Md5::new();
    for row in (0..3).flat_map(|plane| picture.rows(plane)) {
        md5.update(row);
    }
    md5.finalize().into()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::{FaultCard, Frame, Pixels, Plan, ScheduledClip, md5};
    use flock::{Flock, Itinerary, Manifest};
    use screen::Picture;
    use std::path::Path;
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    /// The first `count` clips of a flock of one sheep, whose loop is `loop.mp4` and has `frames` frames.
    pub(crate) fn scheduled_clips(count: u64, frames: u32) -> Vec<Arc<ScheduledClip>> {
        let text = format!(
            "format = 1\nname = \"one\"\nsize = [16, 16]\nfps = [30, 1]\n\
             [[sheep]]\nid = \"one\"\nframes = {frames}\nclip = \"loop.mp4\"\n"
        );
        let manifest = Manifest::parse(&text, Path::new("flock.toml")).unwrap();
        let flock = Arc::new(Flock::new(manifest));
        let mut itinerary = Itinerary::start(Arc::clone(&flock), 1);
        let scheduled = |number| {
            let leg = itinerary.next_leg().unwrap();
            let (clip, frames, what) = (leg.clip.path, leg.clip.frames, leg.clip.what);
            let (flock, is_damaged) = (Arc::clone(&flock), AtomicBool::new(false));
            Arc::new(ScheduledClip { number, clip, frames, what, place: leg.place, flock, trial: None, is_damaged })
        };
        (1..=count).map(scheduled).collect()
    }

    /// Every frame of every clip; frame `index` of the run is `index + 1` bright.
    pub(crate) fn frames(scheduled_clips: &[Arc<ScheduledClip>]) -> Vec<Frame> {
        let in_clips = scheduled_clips
            .iter()
            .flat_map(|scheduled| (0..scheduled.frames.0).map(move |in_clip| (scheduled, in_clip)));
        let shown = |(index, (scheduled, in_clip)): (usize, (&Arc<ScheduledClip>, u32))| Frame {
            pixels: Pixels::Drawn(Arc::new(FaultCard::plain(index as u8 + 1))),
            scheduled: Some(Arc::clone(scheduled)),
            in_clip,
            index: index as u64,
            hash: None,
        };
        in_clips.enumerate().map(shown).collect()
    }

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
    fn a_clip_that_ended_without_a_picture_is_not_planned_any_more() {
        let plan = Plan::default();
        for scheduled in scheduled_clips(3, 2) {
            plan.add(scheduled, None);
        }
        plan.remove(2);
        assert_eq!(plan.after(1).map(|scheduled| scheduled.number), Some(3));
        plan.remove(3);
        assert!(plan.after(1).is_none());
    }
}
