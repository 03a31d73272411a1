//! The usual paths of a flock's files, as `flock` has them, and files beside them.
//!
//! Owns nothing but names; `flock::paths` says what they are. Never touches a file.

use std::path::{Path, PathBuf};

pub use flock::paths::{CLIP, CREDITS, FOLDERS, GENOME, genome, of_loop, of_transition};

/// `path` with `suffix` after its name.
pub fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}
