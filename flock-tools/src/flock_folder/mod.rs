//! The folder of a flock: its manifest, read and edited; the paths and the contents of its files.
//!
//! Owns what all commands do alike with a flock on the artist's disk. Never opens a clip.
//!
//! Start at [`open::manifest`], or at [`Draft`] for a command that edits.

mod draft;
pub(crate) mod file_list;
pub(crate) mod ids;
pub(crate) mod open;
pub(crate) mod paths;

pub(crate) use draft::Draft;
