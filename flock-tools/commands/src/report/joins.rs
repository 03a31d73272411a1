//! The joins of a flock on its page.
//!
//! Owns the choice of the joins that are shown, and the two frames of each: the last of the one clip and the first of the
//! next. Never judges: `operations::joins` does. `sheet/joins.js` draws.
//!
//! Start at [`Joins::of`].

use std::path::Path;

use flock::{Flock, SheepIx};
use operations::decoder::Decoder;
use operations::decoder::thumbnail;
use operations::joins::{JudgedJoin, judge_with_bar};
use operations::portrait::picture::Picture;

/// The most joins that are shown: two rows on a desktop screen.
const SHOWN: usize = 6;
/// The most that their pictures are wide, in pixels.
const WIDTH: u32 = 400;
/// Bytes of a picture, about, before it is written as text.
const BYTES: usize = 40_000;

/// All joins, on the page.
#[derive(Debug, serde::Serialize)]
pub(super) struct Joins {
    /// The number that was judged.
    judged: usize,
    /// The number of those that jump.
    pub(super) jumps: usize,
    /// The number that could not be judged: a clip is missing or damaged.
    unjudged: usize,
    /// The worst, the worst first.
    worst: Vec<JoinFacts>,
}

/// A join on the page.
#[derive(Debug, serde::Serialize)]
struct JoinFacts {
    /// The sheep where the clips meet, by its index on the page.
    at: Option<usize>,
    before: String,
    after: String,
    /// The worst figure, in words.
    why: String,
    /// In parts of what is allowed: above 1 it jumps.
    severity: f64,
    /// The last frame of the one clip and the first of the other.
    frames: [String; 2],
}

impl Joins {
    /// Judges the joins of `flock` in `folder`; `None` if none can be judged.
    pub(super) fn of(folder: &Path, flock: &Flock, decoder: &dyn Decoder) -> Option<Self> {
        let manifest = flock.manifest();
        let judgement = judge_with_bar(folder, manifest, decoder);
        let facts = |judged: &JudgedJoin| JoinFacts::of(judged, folder, flock, decoder);
        (!judgement.joins.is_empty()).then(|| Self {
            judged: judgement.joins.len(),
            jumps: judgement.jumps().count(),
            unjudged: judgement.unjudged.len(),
            worst: judgement.joins.iter().filter_map(facts).take(SHOWN).collect(),
        })
    }
}

impl JoinFacts {
    fn of(judged: &JudgedJoin, folder: &Path, flock: &Flock, decoder: &dyn Decoder) -> Option<Self> {
        let manifest = flock.manifest();
        let JudgedJoin { join, figures } = judged;
        let frames = join.pictures(folder, manifest, decoder).ok()?;
        // The last two of the one clip, or its only one, and then the first ones of the other.
        let first = join.before.frames.0.min(2) as usize;
        let picture = |at: usize| {
            let small = thumbnail::shrink(frames.get(at)?, WIDTH.min(manifest.size.0));
            Some(Picture::of(&small, BYTES)?.url)
        };
        let whole = flock.whole();
        Some(Self {
            at: whole.sheep().find(|sheep| *whole.id(*sheep) == join.sheep).map(SheepIx::index),
            before: join.before.path.as_str().to_owned(),
            after: join.after.path.as_str().to_owned(),
            why: figures.worst_in_words(),
            severity: (figures.severity * 100.0).round() / 100.0,
            frames: [picture(first.checked_sub(1)?)?, picture(first)?],
        })
    }
}
