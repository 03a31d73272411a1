//! Files that come into a flock.
//!
//! Owns the look at a genome or a clip before it is taken in, and its copy. Files that lie in the flock's folder already
//! stay where they are. Never edits the manifest.
//!
//! Start at [`clip`] and [`genome`].

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use flame::{Genome, GenomeError};
use flock::{Clip, ClipHash, ClipPath, SheepId};
use timing::FrameCount;
use video::Form;

use super::Desk;
use crate::check::clips;
use crate::decoder::DecoderHandle;
use crate::flock_folder::paths;
use crate::program::{Exit, Fatal, save};

/// What clip is wished for.
pub(super) struct Wish<'a> {
    /// The file, if it is there already.
    pub(super) file: Option<&'a Path>,
    /// Its frames, if it is yet to be rendered and somebody said.
    pub(super) frames: Option<u32>,
    /// Its frames if nobody said.
    pub(super) or: u32,
}

/// A file from elsewhere, and its place in the flock's folder.
pub(super) struct Incoming {
    from: PathBuf,
    to: ClipPath,
}

/// A genome that was looked at.
pub(super) struct Known {
    pub(super) path: ClipPath,
    pub(super) incoming: Option<Incoming>,
    /// What an artist might want to know of it.
    pub(super) note: Option<String>,
}

/// Why a file was not taken in.
#[derive(Debug, thiserror::Error)]
enum Untaken {
    #[error("cannot copy `{from}` to `{to}`")]
    Copy { from: PathBuf, to: PathBuf, source: io::Error },
    #[error("clip `{path}` has {found} frames (asked for {expected})")]
    Frames { path: PathBuf, expected: u32, found: FrameCount },
    #[error("`{path}` is not a genome")]
    NotAGenome { path: PathBuf, source: GenomeError },
    #[error("clip `{path}` {why}")]
    OtherForm { path: PathBuf, why: String },
    #[error("cannot read `{path}`")]
    Read { path: PathBuf, source: io::Error },
    #[error("`{to}` is another file than `{from}`")]
    Taken { from: PathBuf, to: PathBuf },
}

/// The clip that is wished for, for the place that `place` gives to a name's ending. A file that is in that place
/// already is taken as it is.
///
/// # Errors
/// If the file is not in the flock's form or cannot be read.
pub(super) fn clip(
    desk: &Desk,
    wish: &Wish,
    place: impl Fn(&str) -> ClipPath,
    decoder: DecoderHandle,
) -> Result<(Clip, Option<Incoming>), Fatal> {
    let usual = place(paths::CLIP);
    let there = usual.inside(&desk.folder);
    let file = match wish.file {
        Some(file) => file,
        None if there.exists() => &there,
        None => {
            let frames = FrameCount(wish.frames.unwrap_or(wish.or));
            return Ok((Clip { path: usual, frames, hash: None }, None));
        }
    };
    let unreadable = |source| Fatal::new(Exit::Unreadable, Untaken::Read { path: file.to_owned(), source });
    let hash = File::open(file).and_then(ClipHash::of).map_err(unreadable)?;
    let form = Form { size: desk.manifest().size, fps: desk.manifest().fps };
    let frames = clips::frames(file, &form, decoder.get()?).map_err(|why| {
        let refused = Untaken::OtherForm { path: file.to_owned(), why };
        Fatal::new(Exit::No, refused).hint("`flock import` brings clips into the flock's form")
    })?;
    if let Some(expected) = wish.frames.filter(|expected| FrameCount(*expected) != frames) {
        let refused = Untaken::Frames { path: file.to_owned(), expected, found: frames };
        return Err(Fatal::new(Exit::No, refused));
    }
    let (path, incoming) = settle(&desk.folder, file, place(ending(file).unwrap_or(paths::CLIP)));
    Ok((Clip { path, frames, hash: Some(hash) }, incoming))
}

/// The genome in `file`, for the sheep `id`.
///
/// # Errors
/// If it cannot be read or is not one genome.
pub(super) fn genome(desk: &Desk, file: &Path, id: &SheepId) -> Result<Known, Fatal> {
    let path = || file.to_owned();
    let text = fs::read_to_string(file).map_err(|source| {
        let malformed = source.kind() == io::ErrorKind::InvalidData;
        let exit = if malformed { Exit::Malformed } else { Exit::Unreadable };
        Fatal::new(exit, Untaken::Read { path: path(), source })
    })?;
    let genome = Genome::parse(&text).map_err(|source| {
        let several = matches!(source, GenomeError::Count { found } if found > 1);
        let fatal = Fatal::new(Exit::Malformed, Untaken::NotAGenome { path: path(), source });
        if several { fatal.hint("`flock import` takes files with several flames") } else { fatal }
    })?;
    let ([width, height], size) = (genome.camera.size, desk.manifest().size);
    let other_shape = u64::from(width) * u64::from(size.1) != u64::from(height) * u64::from(size.0);
    let note = other_shape.then(|| {
        format!(
            "note: the genome of `{id}` was made for {width}x{height}; in this flock it is drawn {}x{}",
            size.0, size.1
        )
    });
    let (path, incoming) = settle(&desk.folder, file, paths::genome(id, ending(file).unwrap_or(paths::GENOME)));
    Ok(Known { path, incoming, note })
}

impl Incoming {
    /// Copies all files to their places, or none if one of those is taken by another file and it is not forced.
    pub(super) fn bring_all(incoming: impl Iterator<Item = Incoming>, folder: &Path, force: bool) -> Result<(), Fatal> {
        let mut copies = Vec::new();
        for Incoming { from, to } in incoming {
            let to = to.inside(folder);
            let unreadable = |source| Fatal::new(Exit::Unreadable, Untaken::Read { path: to.clone(), source });
            if !to.exists() || (force && to.is_file()) {
                copies.push((from, to));
            } else if !to.is_file() || !same_bytes(&from, &to).map_err(unreadable)? {
                let taken = Fatal::new(Exit::No, Untaken::Taken { from, to });
                return Err(taken.hint("--force replaces it"));
            }
        }
        for (from, to) in copies {
            let parent = to.parent().unwrap_or(folder);
            let copied = fs::create_dir_all(parent).and_then(|()| save::copy(&from, &to));
            copied.map_err(|source| Fatal::new(Exit::Unreadable, Untaken::Copy { from, to, source }))?;
        }
        Ok(())
    }
}

/// Whether two files have the same bytes.
///
/// # Errors
/// What the kernel says of either.
pub(super) fn same_bytes(a: &Path, b: &Path) -> io::Result<bool> {
    let hash = |path: &Path| File::open(path).and_then(ClipHash::of);
    Ok(fs::metadata(a)?.len() == fs::metadata(b)?.len() && hash(a)? == hash(b)?)
}

/// Where `file` is in `folder`, or that it comes to `place`.
fn settle(folder: &Path, file: &Path, place: ClipPath) -> (ClipPath, Option<Incoming>) {
    let inside = || {
        let file = fs::canonicalize(file).ok()?;
        let inside = file.strip_prefix(fs::canonicalize(folder).ok()?).ok()?;
        ClipPath::new(inside.to_str()?).ok()
    };
    match inside() {
        Some(path) => (path, None),
        None => (place.clone(), Some(Incoming { from: file.to_owned(), to: place })),
    }
}

/// What the name of `file` ends in, if that is plain.
fn ending(file: &Path) -> Option<&str> {
    let ending = file.extension()?.to_str()?;
    ending.chars().all(|c| c.is_ascii_alphanumeric()).then_some(ending)
}
