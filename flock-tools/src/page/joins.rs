//! How the clips of a flock meet, on its page.
//!
//! Owns which joins are shown, and the two frames of each: the last of the one clip and the first of the next. Never
//! judges: `crate::joins` does, and `sheet/joins.js` draws.
//!
//! Start at [`Joins::of`].

use std::path::Path;

use flock::{Flock, SheepIx};

use super::picture::{Picture, Pixels};
use crate::decoder::Decoder;
use crate::joins::Join;
use crate::thumbnail;

/// So many joins are shown: two rows on a desk.
const SHOWN: usize = 6;
/// How wide their pictures are, at most, in pixels.
const WIDTH: u32 = 400;
/// Bytes of a picture, about, before it is written as text.
const BYTES: usize = 40_000;

/// What the page tells of all joins.
#[derive(Debug, serde::Serialize)]
pub(super) struct Joins {
    /// How many were judged.
    judged: usize,
    /// How many of them jump.
    pub(super) jumps: usize,
    /// How many could not be judged: a clip is not there, or damaged.
    unseen: usize,
    /// The worst, the worst first.
    worst: Vec<Shown>,
}

/// A join as it is shown.
#[derive(Debug, serde::Serialize)]
struct Shown {
    /// The sheep where the clips meet, by its place on the page.
    at: Option<usize>,
    before: String,
    after: String,
    /// What is furthest off, in words and figures.
    told: String,
    /// Against what is allowed: above 1 it jumps.
    severity: f64,
    /// The last frame of the one clip and the first of the other.
    frames: [String; 2],
}

impl Joins {
    /// Judges the joins of `flock` in `folder`; `None` where none can be.
    pub(super) fn of(folder: &Path, flock: &Flock, decoder: &dyn Decoder) -> Option<Self> {
        let manifest = flock.manifest();
        let judged = decoder.judge(folder, manifest);
        let shown = |join: &Join| Shown::of(join, folder, flock, decoder);
        (!judged.joins.is_empty()).then(|| Self {
            judged: judged.joins.len(),
            jumps: judged.jumps().count(),
            unseen: judged.unseen.len(),
            worst: judged.joins.iter().filter_map(shown).take(SHOWN).collect(),
        })
    }
}

impl Shown {
    fn of(join: &Join, folder: &Path, flock: &Flock, decoder: &dyn Decoder) -> Option<Self> {
        let manifest = flock.manifest();
        let Join { place, figures } = join;
        let frames = decoder.meeting(join, folder, manifest).ok()?;
        // The last two of the one clip, or its only one, and then the first ones of the other.
        let first = place.before.frames.0.min(2) as usize;
        let picture = |at: usize| {
            let small = thumbnail::shrink(frames.get(at)?, WIDTH.min(manifest.size.0));
            let pixels = Pixels { size: (small.width, small.height), rgb: small.rgb };
            Some(Picture::of(&pixels, BYTES)?.url)
        };
        let whole = flock.whole();
        Some(Self {
            at: whole.sheep().find(|sheep| *whole.id(*sheep) == place.sheep).map(SheepIx::index),
            before: place.before.path.as_str().to_owned(),
            after: place.after.path.as_str().to_owned(),
            told: figures.told(),
            severity: (figures.severity * 100.0).round() / 100.0,
            frames: [picture(first.checked_sub(1)?)?, picture(first)?],
        })
    }
}
