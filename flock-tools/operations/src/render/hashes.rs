//! Writes the hashes of rendered clips into the flock's manifest.
//!
//! Owns the edit: after every finished clip, and nothing but the hashes is changed. Never hashes a clip that the tools have
//! no record of.
//!
//! Start at [`write_hashes`].

use std::fs::OpenOptions;
use std::io;
use std::path::{Path, PathBuf};

use flock::Draft;
use flock::{Clip, ClipHash, FILE_NAME, Manifest};

use super::clip_job::{SCRATCH, hash_of, recorded};
use super::plan::ClipRole;
use super::selection::shown;
use crate::program::{Exit, Fatal};

/// The file that is locked while the manifest is edited.
const LOCK: &str = "lock";

/// Why hashes were not written. The manifest is unchanged.
#[derive(Debug, thiserror::Error)]
#[error("cannot write the hashes of rendered clips to `{FILE_NAME}` in `{folder}`")]
struct HashesError {
    folder: PathBuf,
    source: io::Error,
}

/// Writes the hashes that the manifest of the flock in `folder` lacks: of every clip that is as the tools rendered it last.
/// This includes the clips of interrupted runs.
/// Errors: [`Fatal`] if the manifest cannot be read or written. It is then unchanged, and the next run writes them.
pub fn write_hashes(folder: &Path) -> Result<(), Fatal> {
    let hashes_fatal = |source| Fatal::new(Exit::Unreadable, HashesError { folder: folder.to_owned(), source });
    if !folder.join(SCRATCH).is_dir() {
        return Ok(());
    }
    // Other processes that render this flock write hashes, too, also where a folder cannot be locked.
    let lock = OpenOptions::new().write(true).create(true).truncate(false).open(folder.join(SCRATCH).join(LOCK));
    let lock = lock.map_err(hashes_fatal)?;
    lock.lock().map_err(hashes_fatal)?;
    let mut draft = Draft::lock(folder)?;
    let missing = missing(folder, draft.edit.manifest());
    if missing.is_empty() {
        return Ok(());
    }
    for (role, clip) in missing {
        let edited = match &role {
            ClipRole::Loop(id) => draft.edit.set_loop(id, clip),
            ClipRole::Transition(from, to) => draft.edit.set_transition_clip(from, to, clip),
        };
        edited.map_err(|error| Fatal::new(Exit::Malformed, error))?;
    }
    Ok(draft.save()?)
}

/// The clips whose hash the manifest lacks, or has another one, with their hashes.
fn missing(folder: &Path, manifest: &Manifest) -> Vec<(ClipRole, Clip)> {
    let with_hash = |(role, clip): (ClipRole, &Clip)| {
        let (_, hash) = recorded(folder, &clip.path).filter(|(_, hash)| clip.hash != Some(*hash))?;
        let is_current = hash_of(&clip.path.inside(folder)).is_ok_and(|found: ClipHash| found == hash);
        is_current.then(|| (role, Clip { hash: Some(hash), ..clip.clone() }))
    };
    shown(manifest).filter_map(with_hash).collect()
}
