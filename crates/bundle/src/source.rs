//! The source of a bundle: a stick or a server.
//!
//! Owns the layout that both have in common, and the calls of a source. A source is untrusted: everything that it
//! returns is verified. The updater implements the network source.
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

/// The path of the statements about keys.
pub const STATEMENTS: &str = "statements";

/// A place that has bundles.
pub trait Source {
    /// Opens the small file at `path`, one of [`seal_path`](crate::seal_path), [`system_path`](crate::system_path) and
    /// [`STATEMENTS`]. At most `limit` bytes and one more will be read.
    ///
    /// # Errors
    /// The source's error; [`io::ErrorKind::NotFound`] if there is no such file.
    fn small(&mut self, path: &str, limit: u64) -> io::Result<Box<dyn Read + '_>>;

    /// Opens the object `id` of `size` bytes at the byte `from`, which is at most its size. The reader may yield less
    /// or more: at most one byte beyond its size is read.
    ///
    /// # Errors
    /// The source's error; [`io::ErrorKind::NotFound`] if there is no such object.
    fn object(&mut self, id: &ObjectId, size: u64, from: u64) -> io::Result<Box<dyn Read + '_>>;
}
