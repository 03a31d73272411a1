//! The files of a flock on the artist's disk, by content.
//!
//! Owns which files travel: the manifest, and every clip and genome that it names, each hashed on all cores. Never
//! judges them: `flock check` does.
//!
//! Start at [`contents`].

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use bundle::{Contents, FileEntry, FilePath, ObjectId};
use flock::{ClipPath, FILE_NAME, Manifest};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::refused;
use crate::progress;
use crate::report::{Exit, Fatal};

/// Why a file cannot travel.
#[derive(Debug, thiserror::Error)]
enum Unlisted {
    #[error("`{path}` cannot travel")]
    Name { path: String, source: bundle::NameError },
    #[error("cannot read `{path}`")]
    Read { path: PathBuf, source: io::Error },
}

/// The list of the files of the flock in `folder`. Shows its progress on a terminal.
pub(super) fn contents(folder: &Path, manifest: &Manifest) -> Result<Contents, Fatal> {
    let genomes = manifest.sheep.iter().filter_map(|sheep| sheep.genome.as_ref());
    let named = manifest.clips().map(|clip| &clip.path).chain(genomes).map(ClipPath::as_str);
    let paths: BTreeSet<&str> = named.chain([FILE_NAME]).collect();
    let paths: Vec<&str> = paths.into_iter().collect();
    let length = |path: &&str| fs::metadata(folder.join(path)).map_or(0, |status| status.len());
    let bar = progress::bytes("hashing", paths.iter().map(length).sum());
    let entries: Result<Vec<FileEntry>, Unlisted> = paths
        .par_iter()
        .map(|path| {
            let entry = entry(folder, path)?;
            bar.inc(entry.size);
            Ok(entry)
        })
        .collect();
    bar.finish_and_clear();
    let entries = entries.map_err(|error| {
        let exit = if matches!(error, Unlisted::Read { .. }) { Exit::Unreadable } else { Exit::Malformed };
        Fatal::new(exit, error)
    })?;
    Contents::new(entries).map_err(refused)
}

fn entry(folder: &Path, path: &str) -> Result<FileEntry, Unlisted> {
    let name = FilePath::new(path).map_err(|source| Unlisted::Name { path: path.to_owned(), source })?;
    let file = folder.join(path);
    let read = File::open(&file).and_then(ObjectId::of_reader);
    let (id, size) = read.map_err(|source| Unlisted::Read { path: file, source })?;
    Ok(FileEntry { path: name, id, size })
}
