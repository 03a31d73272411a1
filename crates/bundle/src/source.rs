//! Where a bundle comes from: a stick or a server, which look the same from here.
//!
//! Owns the layout that both have in common, and how little a source must be able to do. Whatever it answers is
//! checked: a source may lie, and only costs time. Never opens a socket: the updater's own source does.
//!
//! ```text
//! seals/lobby.seal        for the unit `lobby`; `all.seal` for every other
//! systems/lobby.seal      the same of systems
//! objects/3f/a91c...      content, by its digest: the lists of files, the files, the statements that seals expect
//! statements              what keys say about keys, if there is anything
//! ```
//!
//! Start at [`Source`]; a folder is one: [`crate::Folder`].

use std::io::{self, Read};

use crate::names::ObjectId;

/// Where the statements about keys lie.
pub const STATEMENTS: &str = "statements";

/// A place that has bundles.
pub trait Source {
    /// Opens the small file at `path`, one of [`seal_path`](crate::seal_path), [`system_path`](crate::system_path) and
    /// [`STATEMENTS`]. At most `limit` bytes and one more will be read.
    ///
    /// # Errors
    /// What the world says; [`io::ErrorKind::NotFound`] if there is no such file.
    fn small(&mut self, path: &str, limit: u64) -> io::Result<Box<dyn Read + '_>>;

    /// Opens the object `id` of `size` bytes at the byte `from`, which is at most its size. The reader may yield less
    /// than was promised, or more: at most one byte beyond its size is read.
    ///
    /// # Errors
    /// What the world says; [`io::ErrorKind::NotFound`] if there is no such object.
    fn object(&mut self, id: &ObjectId, size: u64, from: u64) -> io::Result<Box<dyn Read + '_>>;
}
