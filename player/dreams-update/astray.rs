//! A flock on a stick that no unit takes from there.
//!
//! Owns the look for what people lay out wrongly: a flock's folder that nobody has signed, and bundles in a folder of the
//! stick instead of at its top. Anything else on a stick is nobody's business. Reads names only, and follows no link.
//!
//! Start at [`Astray::on`].

use serde::Serialize;
use std::ffi::OsStr;
use std::fs;
use std::path::Path;

/// Names that are read of a folder, at most: a stick may have any number.
const NAMES: usize = 2_000;
/// Letters of a folder's name that is shown to people, at most.
const SHOWN: usize = 20;

/// What is on a stick without a bundle.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Astray {
    /// Bundles, one folder down: in this one, or in one whose name is not shown.
    Below(Option<String>),
    /// A flock without a seal.
    Unsigned,
}

impl Astray {
    /// What is at `top`, or in a folder there; `None` if there is neither bundle nor flock, or it cannot be read.
    /// Bundles are preferred to flocks.
    pub(crate) fn on(top: &Path) -> Option<Self> {
        let mut unsigned = is_flock(top);
        for folder in fs::read_dir(top).ok()?.take(NAMES).flatten() {
            if !folder.file_type().is_ok_and(|kind| kind.is_dir()) || is_hidden(&folder.file_name()) {
                continue;
            }
            if has_seals(&folder.path()) {
                return Some(Self::Below(folder.file_name().to_str().filter(|name| is_plain(name)).map(str::to_owned)));
            }
            unsigned |= is_flock(&folder.path());
        }
        unsigned.then_some(Self::Unsigned)
    }
}

/// Whether it is a folder of an operating system: for what was deleted, among others.
fn is_hidden(name: &OsStr) -> bool {
    name.as_encoded_bytes().first().is_some_and(|first| b".$".contains(first))
}

fn is_flock(folder: &Path) -> bool {
    fs::symlink_metadata(folder.join(flock::FILE_NAME)).is_ok_and(|found| found.is_file())
}

fn has_seals(folder: &Path) -> bool {
    let seals = folder.join("seals");
    let is_seal = |name: &str| name.strip_suffix(".seal").is_some();
    fs::symlink_metadata(&seals).is_ok_and(|found| found.is_dir())
        && fs::read_dir(&seals)
            .is_ok_and(|names| names.take(NAMES).flatten().any(|entry| entry.file_name().to_str().is_some_and(is_seal)))
}

/// Whether people can read the name on the picture, and nothing else.
fn is_plain(name: &str) -> bool {
    name.len() <= SHOWN && name.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c))
}
