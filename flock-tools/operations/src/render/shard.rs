//! Which frames a run renders: all, or its part of them.
//!
//! Owns the cut of a rendering into parts, by frames and not by clips, so that many machines render one clip. The cut
//! depends on the frame alone: it is the same whatever other runs have finished. Never renders.
//!
//! Start at [`Part::has`].

use std::collections::HashMap;
use std::ops::Range;

use flock::ClipPath;

/// Most parts of a rendering.
pub const MOST_PARTS: u32 = 1_000_000;

/// One of several equal parts of the frames of a flock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// From 1.
    index: u32,
    /// The number of parts.
    of: u32,
}

/// The frames that a run renders.
#[derive(Clone, Debug)]
pub enum Part {
    /// These of these clips. They are not encoded.
    Listed(HashMap<ClipPath, Vec<Range<u32>>>),
    /// One of several equal parts. It is not encoded.
    Shard(Shard),
    /// All frames, of clips that are then encoded.
    Whole,
}

/// `2/7`: the second of seven parts.
pub fn shard(text: &str) -> Result<Shard, String> {
    let numbers = text.split_once('/').and_then(|(index, of)| Some((index.parse().ok()?, of.parse().ok()?)));
    let shard = numbers.filter(|(index, of)| (1..=MOST_PARTS).contains(of) && (1..=*of).contains(index));
    let refused =
        || format!("wanted a part and the number of parts, from 1/1 to {MOST_PARTS}/{MOST_PARTS}, such as 2/7");
    shard.map(|(index, of)| Shard { index, of }).ok_or_else(refused)
}

impl Shard {
    /// The one part that has all frames.
    pub const ALL: Self = Self { index: 1, of: 1 };

    /// Its number, from 1, and the number of all.
    pub fn numbers(self) -> (u32, u32) {
        (self.index, self.of)
    }

    /// Every so many frames of a clip are in it: neighbours cost about the same, so parts do, too. Clips begin with
    /// different parts, or the last parts of short clips would be empty.
    fn has(self, clip: &ClipPath, frame: u32) -> bool {
        let first = clip.as_str().bytes().fold(0_u32, |sum, byte| sum.wrapping_mul(31).wrapping_add(byte.into()));
        first.wrapping_add(frame) % self.of == self.index - 1
    }
}

impl Part {
    /// Whether frame `frame` of `clip` is in it.
    pub fn has(&self, clip: &ClipPath, frame: u32) -> bool {
        match self {
            Self::Listed(frames) => {
                frames.get(clip).is_some_and(|ranges| ranges.iter().any(|range| range.contains(&frame)))
            }
            Self::Shard(shard) => shard.has(clip, frame),
            Self::Whole => true,
        }
    }

    /// Whether clips are encoded.
    pub fn is_encoded(&self) -> bool {
        matches!(self, Self::Whole)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_frame_is_in_exactly_one_part_and_parts_are_alike() {
        let clips: Vec<_> = (0..40).map(|n| ClipPath::new(&format!("loops/{n}.mp4")).unwrap()).collect();
        for of in [1, 3, 7, 50] {
            let parts: Vec<_> = (1..=of).map(|n| Part::Shard(shard(&format!("{n}/{of}")).unwrap())).collect();
            let mut counts = vec![0; parts.len()];
            for (clip, frame) in clips.iter().flat_map(|clip| (0..30).map(move |frame| (clip, frame))) {
                let with: Vec<_> = (0..parts.len()).filter(|at| parts[*at].has(clip, frame)).collect();
                assert_eq!(with.len(), 1, "frame {frame} of {clip} in {of} parts");
                counts[with[0]] += 1;
            }
            let mean = 40 * 30 / of;
            assert!(counts.iter().all(|count| (mean / 2..=mean * 2).contains(count)), "{of}: {counts:?}");
        }
    }

    #[test]
    fn parts_that_there_are_not_are_refused() {
        assert_eq!(shard("7/7").map(Shard::numbers), Ok((7, 7)));
        for bad in ["", "0/3", "4/3", "1", "1/0", "-1/3", "1/3/5", "1/1000001", "a/b"] {
            assert!(shard(bad).unwrap_err().contains("2/7"), "{bad}");
        }
    }
}
