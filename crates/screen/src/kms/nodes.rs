//! The KMS cards in `/dev/dri` and `/sys`.
//!
//! Lists cards without opening them.

use std::fs::{self, File};
use std::io;
use std::path::PathBuf;

/// The cards of this machine, the first one first.
pub(super) fn cards() -> io::Result<Vec<PathBuf>> {
    let mut paths: Vec<PathBuf> = fs::read_dir("/dev/dri")?.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("card")));
    paths.sort_by_cached_key(|path| (path.as_os_str().len(), path.clone()));
    Ok(paths)
}

/// Whether the open `card` has a GPU, and so a `renderD*` beside it.
pub(super) fn has_render_node(card: &File) -> bool {
    let Ok(stat) = rustix::fs::fstat(card) else { return false };
    let (major, minor) = (rustix::fs::major(stat.st_rdev), rustix::fs::minor(stat.st_rdev));
    let siblings = fs::read_dir(format!("/sys/dev/char/{major}:{minor}/device/drm"));
    siblings.is_ok_and(|nodes| nodes.flatten().any(|node| node.file_name().to_string_lossy().starts_with("renderD")))
}
