//! The folder of a flock: its manifest, read and edited; the paths and the contents of its files.
//!
//! Owns what all commands do alike with a flock on the artist's disk. Never opens a clip.
//!
//! Start at [`open::manifest`].

pub mod file_list;
pub mod ids;
pub mod open;
pub mod paths;
