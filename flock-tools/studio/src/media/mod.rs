//! What the page shows of sheep: strips, posters, clips in pieces, packets, previews of transitions; and clips that are
//! rendered.
//!
//! Owns the keys by which the page asks for them, and the folder in which they are kept. A key stands for files as they are
//! now: a clip that is rendered again has another one. Everything kept is made again if it is deleted. Never changes the
//! manifest but as `dreams render` does, and never draws a clip in another way.
//!
//! | file | what is there |
//! |---|---|
//! | `sources.rs`, `keys.rs` | keys, and what they stand for; those of one flock |
//! | `cache.rs`, `limit.rs` | the files that are kept, each made once; those that are kept no longer |
//! | `picture.rs`, `strip.rs` | small pictures; the strip and the poster of a sheep |
//! | `between.rs`, `moving.rs` | previews of a transition: three pictures with their figures; a small clip that grows |
//! | `clips.rs` | fragments and packets of clips |
//! | `rendering.rs`, `cost.rs` | the clips that are missing; what they cost |
//! | `stopping.rs` | how work is told to stop |
//!
//! Start at [`Media::open`].

mod between;
mod cache;
mod clips;
mod cost;
mod keys;
mod limit;
mod moving;
mod picture;
mod rendering;
mod sources;
mod stopping;
mod strip;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use cache::Cache;
use sources::Sources;
use strip::StripLook;

pub(super) use keys::Keys;
pub(super) use rendering::{RENDER_KEY, Wanted};

/// The folder of what is kept, in the studio's own.
const CACHE: &str = "cache";

/// The pictures and clips of one flock.
pub(super) struct Media {
    folder: PathBuf,
    cache: Cache,
    sources: Sources,
    /// What is told of strips that are made.
    looks: Mutex<HashMap<String, StripLook>>,
}

/// Why there is nothing to show.
#[derive(Debug, thiserror::Error)]
pub(super) enum MediaError {
    /// The work was told to stop.
    #[error("it was cancelled")]
    Cancelled,
    /// A file could not be read or written.
    #[error("cannot use `{path}`: {source}")]
    File {
        /// Which.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// A genome or a clip cannot be shown.
    #[error("cannot show {what}: {reason}")]
    Refused {
        /// Which.
        what: String,
        /// Why.
        reason: String,
    },
    /// The key stands for nothing, or for something of another kind.
    #[error("nothing has the key `{key}` any more")]
    Unknown {
        /// The key.
        key: String,
    },
}

impl Media {
    /// Those of the flock in `folder`, kept in the studio's `own` folder.
    pub(super) fn open(folder: &Path, own: &Path) -> Self {
        let cache = Cache::open(&own.join(CACHE));
        Self { folder: folder.to_owned(), cache, sources: Sources::default(), looks: Mutex::default() }
    }
}

impl MediaError {
    fn refused(what: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::Refused { what: what.into(), reason: reason.into() }
    }

    fn file(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { path, source }
    }
}
