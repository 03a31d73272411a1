//! The list of a flock's files, with their hashes.
//!
//! Owns which files go into a bundle: the manifest, every clip and genome that it names, and `credits.toml` if there is one,
//! each hashed on all cores; and whether that is too much for a unit. Never judges what the files hold: `dreams check` does.
//!
//! Start at [`contents`].

use std::collections::BTreeSet;
use std::error::Error;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use bundle::{Contents, FileEntry, FilePath, ObjectId, Refusal};
use flock::{ClipPath, FILE_NAME, Fault, FaultKind, Manifest, ManifestError};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::paths::CREDITS;
use crate::program::{Exit, Fatal, chain, progress};

/// Why a file cannot be listed.
#[derive(Debug, thiserror::Error)]
enum FileListError {
    #[error("`{path}` cannot go into a bundle")]
    Name { path: String, source: bundle::NameError },
    #[error("cannot read `{path}`")]
    Read { path: PathBuf, source: io::Error },
}

/// The list of the files of the flock in `folder`. Shows its progress on a terminal.
pub fn contents(folder: &Path, manifest: &Manifest) -> Result<Contents, Fatal> {
    let paths: Vec<&str> = paths(folder, manifest).into_iter().collect();
    let length = |path: &&str| fs::metadata(folder.join(path)).map_or(0, |status| status.len());
    let bar = progress::bytes("hashing", paths.iter().map(length).sum());
    let entries: Result<Vec<FileEntry>, FileListError> = paths
        .par_iter()
        .map(|path| {
            let entry = entry(folder, path)?;
            bar.inc(entry.size);
            Ok(entry)
        })
        .collect();
    bar.finish_and_clear();
    let entries = entries.map_err(|error| {
        let exit = if matches!(error, FileListError::Read { .. }) { Exit::Unreadable } else { Exit::Malformed };
        Fatal::new(exit, error)
    })?;
    Contents::new(entries).map_err(|refused| Fatal::new(Exit::No, refused))
}

/// The fault of the flock in `folder` if its manifest, or the list of its files, is more than a unit has the memory for.
/// Errors: If its manifest cannot be read.
pub fn too_large(folder: &Path, manifest: &Manifest) -> Result<Option<Fault>, Fatal> {
    match Manifest::read_on_unit(folder) {
        Err(error @ (ManifestError::NotPlain { .. } | ManifestError::TooLarge { .. })) => Ok(Some(large(&error))),
        Err(error) => Err(error.into()),
        Ok(_) => Ok(unhashed(folder, manifest).err().map(|refused| large(&refused))),
    }
}

fn large(why: &(dyn Error + 'static)) -> Fault {
    let message = chain(why);
    Fault { kind: FaultKind::Large, sheep: None, from: None, to: None, clip: None, message }
}

/// The list of the files of the flock in `folder` in its final length: it has the hash of each path in place of the hash of
/// the file.
fn unhashed(folder: &Path, manifest: &Manifest) -> Result<Contents, Refusal> {
    let entry = |path: &str| {
        let size = fs::metadata(folder.join(path)).map_or(0, |status| status.len());
        // `dreams pack` refuses what has a name that a bundle cannot have.
        Some(FileEntry { path: FilePath::new(path).ok()?, id: ObjectId::of(path.as_bytes()), size })
    };
    Contents::new(paths(folder, manifest).into_iter().filter_map(entry).collect())
}

fn paths<'m>(folder: &Path, manifest: &'m Manifest) -> BTreeSet<&'m str> {
    let genomes = manifest.sheep.iter().filter_map(|sheep| sheep.genome.as_ref());
    let named = manifest.clips().map(|clip| &clip.path).chain(genomes).map(ClipPath::as_str);
    // Whoever passes the flock on has to say who made it: the licences ask for it.
    let credits = Some(CREDITS).filter(|name| folder.join(name).is_file());
    named.chain([FILE_NAME]).chain(credits).collect()
}

fn entry(folder: &Path, path: &str) -> Result<FileEntry, FileListError> {
    let name = FilePath::new(path).map_err(|source| FileListError::Name { path: path.to_owned(), source })?;
    let file = folder.join(path);
    let read = File::open(&file).and_then(ObjectId::of_reader);
    let (id, size) = read.map_err(|source| FileListError::Read { path: file, source })?;
    Ok(FileEntry { path: name, id, size })
}
