//! One clip's turn in the run, and one picture of it.
//!
//! Owns what travels with a frame from the decoder to the glass. Never owns a thread: `clip_source.rs` makes the turns,
//! `decoder.rs` the pictures, `presenter.rs` lights them.

use crate::stream::fault_card::Card;
use crate::stream::generation::Trial;
use flock::{ClipPath, Flock, Place};
use md5::{Digest, Md5};
use screen::Picture;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use timing::FrameCount;

/// One clip's turn in the run.
#[derive(Debug)]
pub(crate) struct Turn {
    /// From 1 in this run; the turn of a higher number comes later.
    pub(crate) number: u64,
    /// The clip, as the manifest names it.
    pub(crate) clip: ClipPath,
    /// How many frames the manifest promises.
    pub(crate) frames: FrameCount,
    /// Where the walk stands: resumed from here it plays this clip first.
    pub(crate) place: Place,
    /// The flock that it is of.
    pub(crate) flock: Arc<Flock>,
    /// Whose trial it counts for, when it was on the glass to its end.
    pub(crate) trial: Option<Arc<Trial>>,
    /// It did not decode cleanly. Known before its last frame is lit.
    pub(crate) is_damaged: AtomicBool,
}

/// A picture to light: cheap to clone, its pixels are shared.
#[derive(Clone, Debug)]
pub(crate) struct Shown {
    /// The pixels.
    pub(crate) still: Still,
    /// Whose turn it is; `None` for the fault card.
    pub(crate) turn: Option<Arc<Turn>>,
    /// Its number in its clip, from 0.
    pub(crate) frame: u32,
    /// Its number in the run, from 0: a gap would be a frame that was decoded and never lit.
    pub(crate) index: u64,
    /// The MD5 of its visible planes, if the run is hashed.
    pub(crate) hash: Option<[u8; 16]>,
}

impl Shown {
    /// Whether `other` is the same frame of the same turn.
    pub(crate) fn is(&self, other: &Self) -> bool {
        let number = |shown: &Self| shown.turn.as_ref().map(|turn| turn.number);
        number(self).is_some() && (number(self), self.frame) == (number(other), other.frame)
    }
}

/// Where pixels come from.
#[derive(Clone, Debug)]
pub(crate) enum Still {
    /// A clip.
    Decoded(video::Frame),
    /// Our own pen.
    Drawn(Arc<Card>),
}

impl Still {
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
    use super::{Card, Shown, Still, Turn, md5};
    use flock::{Flock, Itinerary, Manifest};
    use screen::Picture;
    use std::path::Path;
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    /// The first `count` turns of a flock of one sheep, whose loop is `loop.mp4` and has `frames` frames.
    pub(crate) fn turns(count: u64, frames: u32) -> Vec<Arc<Turn>> {
        let text = format!(
            "format = 1\nname = \"one\"\nsize = [16, 16]\nfps = [30, 1]\n\
             [[sheep]]\nid = \"one\"\nframes = {frames}\nclip = \"loop.mp4\"\n"
        );
        let manifest = Manifest::parse(&text, Path::new("flock.toml")).unwrap();
        let flock = Arc::new(Flock::new(manifest));
        let mut itinerary = Itinerary::start(Arc::clone(&flock), 1);
        let turn = |number| {
            let leg = itinerary.next_leg().unwrap();
            let (clip, frames, flock) = (leg.clip.path, leg.clip.frames, Arc::clone(&flock));
            let is_damaged = AtomicBool::new(false);
            Arc::new(Turn { number, clip, frames, place: leg.place, flock, trial: None, is_damaged })
        };
        (1..=count).map(turn).collect()
    }

    /// Every frame of every turn; frame `index` of the run is `index + 1` bright.
    pub(crate) fn frames(turns: &[Arc<Turn>]) -> Vec<Shown> {
        let in_clips = turns.iter().flat_map(|turn| (0..turn.frames.0).map(move |frame| (turn, frame)));
        let shown = |(index, (turn, frame)): (usize, (&Arc<Turn>, u32))| Shown {
            still: Still::Drawn(Arc::new(Card::plain(index as u8 + 1))),
            turn: Some(Arc::clone(turn)),
            frame,
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
}
