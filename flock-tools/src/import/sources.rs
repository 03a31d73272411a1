//! The files to import, found in the paths of the command line.
//!
//! Owns the search through folders, and the list of files that are skipped for their names. Never opens a file.
//!
//! Start at [`Sources::find`].

use std::collections::HashMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::SkippedFile;
use super::file_kind::{FileKind, file_kind};
use crate::program::Fatal;
use crate::render::plan::ClipRole;

/// The deepest level of folders in folders.
const DEEPEST: usize = 64;

/// The files to import, in the order in which they are taken in: loops, transitions, genomes, each by name.
#[derive(Debug, Default)]
pub(super) struct Sources {
    pub(super) clips: Vec<(PathBuf, ClipRole)>,
    pub(super) genomes: Vec<PathBuf>,
    pub(super) skipped: Vec<SkippedFile>,
    /// Clips that were voted down or deleted; only their names are left.
    pub(super) tombstones: usize,
    /// Files of other kinds.
    pub(super) others: usize,
}

impl Sources {
    /// The files in `paths`: files, and folders with all that is in them. `given` is the role of all videos of the command
    /// line, if it names one.
    /// Errors: If a path is missing, or a folder cannot be listed.
    pub(super) fn find(paths: &[PathBuf], given: Option<&ClipRole>) -> Result<Self, Fatal> {
        let mut sources = Self::default();
        for path in paths {
            let kind = fs::metadata(path).map_err(|source| Fatal::read(path, source))?;
            if kind.is_dir() {
                sources.walk(path, 0)?;
            } else {
                sources.add(path, given, true);
            }
        }
        sources.clips.sort_by(|a, b| (is_transition(&a.1), &a.0).cmp(&(is_transition(&b.1), &b.0)));
        sources.genomes.sort();
        sources.skip_duplicates();
        Ok(sources)
    }

    /// Adds the files in `folder`. Links to folders are not followed: they may lead in a circle.
    fn walk(&mut self, folder: &Path, depth: usize) -> Result<(), Fatal> {
        let cannot = |source| Fatal::read(folder, source);
        let mut inside: Vec<_> = fs::read_dir(folder).map_err(cannot)?.collect::<io::Result<_>>().map_err(cannot)?;
        inside.sort_by_key(fs::DirEntry::path);
        for entry in inside {
            let kind = entry.file_type().map_err(cannot)?;
            if kind.is_dir() && depth < DEEPEST {
                self.walk(&entry.path(), depth + 1)?;
            } else if !kind.is_dir() && !entry.path().is_dir() {
                self.add(&entry.path(), None, false);
            }
        }
        Ok(())
    }

    fn add(&mut self, path: &Path, given: Option<&ClipRole>, is_given: bool) {
        let kind = file_kind(path);
        match (kind, given) {
            (FileKind::Genomes, _) => self.genomes.push(path.to_owned()),
            (_, Some(role)) => self.clips.push((path.to_owned(), role.clone())),
            (FileKind::Clip(role), None) => self.clips.push((path.to_owned(), role)),
            (FileKind::Unclear(reason), None) => self.skipped.push(SkippedFile { source: path.to_owned(), reason }),
            (FileKind::Tombstone, None) => self.tombstones += 1,
            (FileKind::Other, None) if is_given => {
                let reason = "its ending is not one that is imported (expected a video or a genome)".to_owned();
                self.skipped.push(SkippedFile { source: path.to_owned(), reason });
            }
            (FileKind::Other, None) => self.others += 1,
        }
    }

    /// Skips every clip of a role that another clip has already.
    fn skip_duplicates(&mut self) {
        let mut first: HashMap<ClipRole, PathBuf> = HashMap::new();
        let clips = std::mem::take(&mut self.clips);
        for (path, role) in clips {
            if let Some(first) = first.get(&role) {
                let reason = format!("it shows {}, as does `{}`", in_words(&role), first.display());
                self.skipped.push(SkippedFile { source: path, reason });
            } else {
                first.insert(role.clone(), path.clone());
                self.clips.push((path, role));
            }
        }
    }
}

/// A clip's part of the graph, in words.
fn in_words(role: &ClipRole) -> String {
    match role {
        ClipRole::Loop(id) => format!("the loop of `{id}`"),
        ClipRole::Transition(from, to) => format!("the transition from `{from}` to `{to}`"),
    }
}

fn is_transition(role: &ClipRole) -> bool {
    matches!(role, ClipRole::Transition(..))
}
