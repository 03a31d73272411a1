//! What an artist named, as files to import.
//!
//! Owns the walk through folders and the list of what is left out by its name. Never opens a file.
//!
//! Start at [`Sources::find`].

use std::collections::HashMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::LeftOut;
use super::file_kind::{Named, named};
use crate::program::{Exit, Fatal};
use crate::render::plan::Shows;

/// Folders in folders, at most.
const DEEPEST: usize = 64;

/// The files to import, in the order in which they are taken in: loops, transitions, genomes, each by name.
#[derive(Debug, Default)]
pub(super) struct Sources {
    pub(super) clips: Vec<(PathBuf, Shows)>,
    pub(super) genomes: Vec<PathBuf>,
    pub(super) left_out: Vec<LeftOut>,
    /// Clips that were voted down or deleted, of which the name is left.
    pub(super) tombstones: usize,
    /// Files of other kinds.
    pub(super) others: usize,
}

/// A file or folder that was named and cannot be looked at.
#[derive(Debug, thiserror::Error)]
#[error("cannot read `{path}`")]
struct Unread {
    path: PathBuf,
    source: io::Error,
}

impl Sources {
    /// What is in `named`: files, and folders with all that is in them. `told` is what all videos show, where their
    /// names do not tell.
    ///
    /// # Errors
    /// If one of them is not there or a folder cannot be listed.
    pub(super) fn find(paths: &[PathBuf], told: Option<&Shows>) -> Result<Self, Fatal> {
        let mut sources = Self::default();
        for path in paths {
            let kind = fs::metadata(path).map_err(unread(path))?;
            if kind.is_dir() {
                sources.walk(path, 0).map_err(|(path, source)| unread(&path)(source))?;
            } else {
                sources.add(path, told, true);
            }
        }
        sources.clips.sort_by(|a, b| (is_transition(&a.1), &a.0).cmp(&(is_transition(&b.1), &b.0)));
        sources.genomes.sort();
        sources.leave_out_seconds();
        Ok(sources)
    }

    /// Adds what is in `folder`. Links to folders are not followed: they may lead around.
    fn walk(&mut self, folder: &Path, depth: usize) -> Result<(), (PathBuf, io::Error)> {
        let cannot = |source| (folder.to_owned(), source);
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

    fn add(&mut self, path: &Path, told: Option<&Shows>, by_name: bool) {
        let name = named(path);
        match (name, told) {
            (Named::Genomes, _) => self.genomes.push(path.to_owned()),
            (_, Some(shows)) => self.clips.push((path.to_owned(), shows.clone())),
            (Named::Clip(shows), None) => self.clips.push((path.to_owned(), shows)),
            (Named::Odd(reason), None) => self.left_out.push(LeftOut { source: path.to_owned(), reason }),
            (Named::Tombstone, None) => self.tombstones += 1,
            (Named::Other, None) if by_name => {
                let reason = "its name is of no kind that is imported (expected a video or a genome)".to_owned();
                self.left_out.push(LeftOut { source: path.to_owned(), reason });
            }
            (Named::Other, None) => self.others += 1,
        }
    }

    /// Leaves out every clip that shows what another one shows.
    fn leave_out_seconds(&mut self) {
        let mut first: HashMap<Shows, PathBuf> = HashMap::new();
        let clips = std::mem::take(&mut self.clips);
        for (path, shows) in clips {
            if let Some(first) = first.get(&shows) {
                let reason = format!("it shows {}, as does `{}`", what(&shows), first.display());
                self.left_out.push(LeftOut { source: path, reason });
            } else {
                first.insert(shows.clone(), path.clone());
                self.clips.push((path, shows));
            }
        }
    }
}

/// A clip's part of the graph, in words.
pub(super) fn what(shows: &Shows) -> String {
    match shows {
        Shows::Loop(id) => format!("the loop of `{id}`"),
        Shows::Transition(from, to) => format!("the transition from `{from}` to `{to}`"),
    }
}

fn is_transition(shows: &Shows) -> bool {
    matches!(shows, Shows::Transition(..))
}

fn unread(path: &Path) -> impl FnOnce(io::Error) -> Fatal {
    let path = path.to_owned();
    move |source| Fatal::new(Exit::Unreadable, Unread { path, source })
}
