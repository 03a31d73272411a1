//! The hashes of rendered clips, in the flock's manifest.
//!
//! Owns when and how they get there: after every finished clip, as an edit that leaves everything else as the artist
//! wrote it. Never hashes a clip that the tools have no record of.
//!
//! Start at [`settle`].

use std::fs::OpenOptions;
use std::io;
use std::path::{Path, PathBuf};

use flock::{Clip, ClipHash, FILE_NAME, Manifest};

use super::clip_job::{WORKSHOP, hash_of, recorded};
use super::plan::Shows;
use super::selection::shown;
use crate::flock_folder::Draft;
use crate::program::{Exit, Fatal};

/// Held while the manifest is edited.
const LOCK: &str = "lock";

/// Why hashes were not written. The manifest is unchanged.
#[derive(Debug, thiserror::Error)]
#[error("cannot write the hashes of rendered clips to `{FILE_NAME}` in `{folder}`")]
struct Unsettled {
    folder: PathBuf,
    source: io::Error,
}

/// Writes the hash of every clip that stands as the tools made it last, and that the manifest does not know yet, into
/// the manifest of the flock in `folder`. What an interrupted run left to do is done here too.
///
/// # Errors
/// [`Fatal`] if the manifest cannot be read or written. It is then unchanged, and the next run does it.
pub(crate) fn settle(folder: &Path) -> Result<(), Fatal> {
    let unsettled = |source| Fatal::new(Exit::Unreadable, Unsettled { folder: folder.to_owned(), source });
    if !folder.join(WORKSHOP).is_dir() {
        return Ok(());
    }
    // Others that render this flock write hashes, too, and on machines where a folder cannot be locked.
    let lock = OpenOptions::new().write(true).create(true).truncate(false).open(folder.join(WORKSHOP).join(LOCK));
    let lock = lock.map_err(unsettled)?;
    lock.lock().map_err(unsettled)?;
    let mut draft = Draft::take(folder)?;
    let due = due(folder, draft.edit.manifest());
    if due.is_empty() {
        return Ok(());
    }
    for (shows, clip) in due {
        let edited = match &shows {
            Shows::Loop(id) => draft.edit.set_loop(id, clip),
            Shows::Transition(from, to) => draft.edit.set_transition_clip(from, to, clip),
        };
        edited.map_err(|error| Fatal::new(Exit::Malformed, error))?;
    }
    draft.save()
}

/// The clips whose hash stands in no manifest or is another one, as they are to stand there.
fn due(folder: &Path, manifest: &Manifest) -> Vec<(Shows, Clip)> {
    let differs = |(shows, clip): (Shows, &Clip)| {
        let hash = recorded(folder, &clip.path).filter(|hash| clip.hash != Some(*hash))?;
        let stands = hash_of(&clip.path.inside(folder)).is_ok_and(|found: ClipHash| found == hash);
        stands.then(|| (shows, Clip { hash: Some(hash), ..clip.clone() }))
    };
    shown(manifest).filter_map(differs).collect()
}
