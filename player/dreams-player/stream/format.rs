//! The size and the rate of what is played.
//!
//! Owns what a flock's manifest says of them, for the screen and for the decoder. Never judges a clip: `video` does.

use flock::Flock;
use timing::Rate;
use video::Form;

/// What a screen is to show; size and rate until a flock of others comes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StreamFormat {
    /// The flock's frames per second.
    pub(crate) fps: Rate,
    /// Its pictures' size.
    pub(crate) size: (u32, u32),
    /// Whether the screen flips as fast as frames come, instead of by the time.
    pub(crate) free: bool,
}

impl StreamFormat {
    /// That of `flock`.
    pub(crate) fn of(flock: &Flock, free: bool) -> Self {
        Self { fps: flock.manifest().fps, size: flock.manifest().size, free }
    }
}

/// What the clips of `flock` are to be.
pub(crate) fn form(flock: &Flock) -> Form {
    Form { size: flock.manifest().size, fps: flock.manifest().fps }
}
