//! The keys of pictures and clips, as answers have them.
//!
//! Owns which key stands for what in one flock. Keys are found by looking at files, none of which is opened.
//!
//! Start at [`Keys::new`].

use std::path::Path;

use flock::{Clip, Manifest, SheepId};
use timing::FrameCount;
use video::Form;

use super::Media;
use super::sources::Pair;

/// The keys of one flock.
#[derive(Clone, Copy)]
pub(crate) struct Keys<'a> {
    media: &'a Media,
    manifest: &'a Manifest,
    form: Form,
}

impl<'a> Keys<'a> {
    /// Those of `media`, for the flock of `manifest`.
    pub(crate) fn new(media: &'a Media, manifest: &'a Manifest) -> Self {
        Self { media, manifest, form: Form { size: manifest.size, fps: manifest.fps } }
    }

    /// The key of the strip of a sheep with this loop and this genome.
    pub(crate) fn strip(&self, clip: Option<&Clip>, genome: Option<&Path>) -> Option<String> {
        self.media.strip_key(self.form, clip, genome)
    }

    /// The key of a clip's fragments; `None` if it is not there.
    pub(crate) fn fragments(&self, clip: &Clip) -> Option<String> {
        self.media.fragments_key(self.form, clip)
    }

    /// The activity and the colour (`#rrggbb`) of a strip that is there.
    pub(crate) fn look(&self, strip: &str) -> Option<(f64, String)> {
        self.media.look(strip)
    }

    /// The key of the previews of a transition of so many frames, which need not exist; `None` without two genomes.
    pub(crate) fn pair(&self, from: &SheepId, to: &SheepId, frames: u32) -> Option<String> {
        self.media.pair_key(self.manifest, &Pair { from, to, frames: FrameCount(frames) })
    }

    /// The key of the moving preview of a transition, if it is there as a whole.
    pub(crate) fn moving(&self, from: &SheepId, to: &SheepId, frames: u32) -> Option<String> {
        let key = self.pair(from, to, frames)?;
        self.media.moving(&key, u64::MAX).filter(|(_, is_whole)| *is_whole).map(|_| key)
    }

    /// Seconds that a transition takes to render on all cores of this machine, if that is known.
    pub(crate) fn cost_s(&self, from: &SheepId, to: &SheepId, frames: u32) -> Option<f64> {
        self.media.cost_s(self.manifest, from, to, FrameCount(frames), false)
    }
}
