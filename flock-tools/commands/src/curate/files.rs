//! Files that are added to a flock.
//!
//! Owns the check of a genome or a clip before it is added, and its copy. Files in the flock's folder stay where they are.
//! Never edits the manifest.
//!
//! Start at [`clip`] and [`genome`].

use std::error::Error;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use flame::Backend;
use flame::genome::Unsupported;
use flock::{Clip, ClipHash, ClipPath, SheepId};
use operations::check::clips;
use operations::decoder::DecoderHandle;
use operations::flock_folder::paths;
use operations::program::{Exit, Fatal};
use operations::species::{self, Refused, reasons};
use timing::FrameCount;
use video::Form;

use super::EditSession;

/// The clip that the command line asks for.
pub(super) struct ClipRequest<'a> {
    /// The file, if one is named.
    pub(super) file: Option<&'a Path>,
    /// Its frames, if they are given.
    pub(super) frames: Option<u32>,
    /// Its frames if it is yet to be rendered and none are given.
    pub(super) default_frames: u32,
}

/// The copy of a file from elsewhere into the flock's folder.
pub(super) struct FileCopy {
    from: PathBuf,
    to: ClipPath,
}

/// A genome that was read.
pub(super) struct GenomeFile {
    pub(super) path: ClipPath,
    pub(super) copy: Option<FileCopy>,
    /// Hints for the artist.
    pub(super) notes: Vec<String>,
    /// What of it is not drawn.
    pub(super) undrawn: Unsupported,
}

/// Why a file was not added.
#[derive(Debug, thiserror::Error)]
enum AddError {
    #[error("cannot copy `{from}` to `{to}`")]
    Copy { from: PathBuf, to: PathBuf, source: io::Error },
    #[error("clip `{path}` has {found} frames (asked for {expected})")]
    Frames { path: PathBuf, expected: u32, found: FrameCount },
    #[error("`{path}` is not a genome")]
    NotAGenome { path: PathBuf, source: Box<dyn Error> },
    #[error("cannot copy `{from}`: `{to}` is another file")]
    Occupied { from: PathBuf, to: PathBuf },
    #[error("clip `{path}` {why}")]
    OtherForm { path: PathBuf, why: String },
    #[error("cannot read `{path}`")]
    Read { path: PathBuf, source: Box<dyn Error> },
}

/// The clip that is asked for, at the path that `place` gives for an ending. A file that is there already is used.
/// Errors: If the file is not in the flock's form or cannot be read.
pub(super) fn clip(
    session: &EditSession,
    request: &ClipRequest,
    place: impl Fn(&str) -> ClipPath,
    decoder: DecoderHandle,
) -> Result<(Clip, Option<FileCopy>), Fatal> {
    let usual = place(paths::CLIP);
    let there = usual.inside(&session.folder);
    let file = match request.file {
        Some(file) => file,
        None if there.exists() => &there,
        None => {
            let frames = FrameCount(request.frames.unwrap_or(request.default_frames));
            return Ok((Clip { path: usual, frames, hash: None }, None));
        }
    };
    let hash = File::open(file).and_then(ClipHash::of).map_err(|source| Fatal::read(file, source))?;
    let form = Form { size: session.manifest().size, fps: session.manifest().fps };
    let frames = clips::frames(file, &form, decoder.get()?).map_err(|why| {
        let refused = AddError::OtherForm { path: file.to_owned(), why };
        Fatal::new(Exit::No, refused).hint("`dreams import` brings clips into the flock's form")
    })?;
    if let Some(expected) = request.frames.filter(|expected| FrameCount(*expected) != frames) {
        let refused = AddError::Frames { path: file.to_owned(), expected, found: frames };
        return Err(Fatal::new(Exit::No, refused));
    }
    let (path, copy) = place_in(&session.folder, file, place(ending(file).unwrap_or(paths::CLIP)));
    Ok((Clip { path, frames, hash: Some(hash) }, copy))
}

/// The genome in `file`, for the sheep `id`.
/// Errors: If it cannot be read or is not one genome.
pub(super) fn genome(session: &EditSession, file: &Path, id: &SheepId) -> Result<GenomeFile, Fatal> {
    let refused = |why: Refused| {
        let path = file.to_owned();
        let fatal = Fatal::new(why.exit, AddError::NotAGenome { path, source: why.source });
        match why.hint {
            Some(hint) => fatal.hint(hint),
            None => fatal,
        }
    };
    let text = species::text(file).map_err(|why| {
        let (path, source) = (file.to_owned(), why.source);
        Fatal::new(why.exit, AddError::Read { path, source })
    })?;
    let genome = species::parse(file, &text, &Backend::default()).map_err(refused)?;
    let size = session.manifest().size;
    let [width, height] = genome.made_for().unwrap_or([size.0, size.1]);
    let other_shape = u64::from(width) * u64::from(size.1) != u64::from(height) * u64::from(size.0);
    let note = other_shape.then(|| {
        format!(
            "note: the genome of `{id}` was made for {width}x{height}; in this flock it is drawn {}x{}",
            size.0, size.1
        )
    });
    let (path, copy) = place_in(&session.folder, file, paths::genome(id, ending(file).unwrap_or(paths::GENOME)));
    let mut notes: Vec<String> = note.into_iter().collect();
    let undrawn = reasons::undrawn(&*genome);
    let Unsupported { refused, without } = &undrawn;
    if !refused.is_empty() {
        notes.push(format!("note: the genome of `{id}` cannot be drawn: {}", reasons::refusal(refused)));
    }
    if !without.is_empty() {
        notes.push(format!("note: the genome of `{id}` is drawn without {without}"));
    }
    Ok(GenomeFile { path, copy, notes, undrawn })
}

impl FileCopy {
    /// Makes all copies, or none if another file is in the place of one and `force` is not set.
    pub(super) fn run_all(
        copy: impl Iterator<Item = FileCopy>,
        session: &mut EditSession,
        force: bool,
    ) -> Result<(), Fatal> {
        let (folder, draft) = (&session.folder, &mut session.draft);
        let (mut copies, mut places) = (Vec::new(), Vec::new());
        for FileCopy { from, to: place } in copy {
            let to = place.inside(folder);
            let unreadable = |source| Fatal::read(&to, source);
            if !to.exists() || (force && to.is_file()) {
                copies.push((from, to));
                places.push(place);
            } else if !to.is_file() || !same_bytes(&from, &to).map_err(unreadable)? {
                let occupied = Fatal::new(Exit::No, AddError::Occupied { from, to });
                return Err(occupied.hint("--force replaces it"));
            }
        }
        draft.writes(places.iter().map(ClipPath::as_str));
        for (from, to) in copies {
            let parent = to.parent().unwrap_or(folder);
            let copied = fs::create_dir_all(parent).and_then(|()| durable::copy(&from, &to));
            copied.map_err(|source| Fatal::new(Exit::Unreadable, AddError::Copy { from, to, source }))?;
        }
        Ok(())
    }
}

/// Whether two files have the same bytes.
/// Errors: The system's error for either.
pub(super) fn same_bytes(a: &Path, b: &Path) -> io::Result<bool> {
    let hash = |path: &Path| File::open(path).and_then(ClipHash::of);
    Ok(fs::metadata(a)?.len() == fs::metadata(b)?.len() && hash(a)? == hash(b)?)
}

/// The path of `file` in `folder`; if it is not in there, `place` and the copy to it.
fn place_in(folder: &Path, file: &Path, place: ClipPath) -> (ClipPath, Option<FileCopy>) {
    let inside = || {
        let file = fs::canonicalize(file).ok()?;
        let inside = file.strip_prefix(fs::canonicalize(folder).ok()?).ok()?;
        ClipPath::new(inside.to_str()?).ok()
    };
    match inside() {
        Some(path) => (path, None),
        None => (place.clone(), Some(FileCopy { from: file.to_owned(), to: place })),
    }
}

/// The ending of `file`, if it has only letters and digits.
fn ending(file: &Path) -> Option<&str> {
    let ending = file.extension()?.to_str()?;
    ending.chars().all(|c| c.is_ascii_alphanumeric()).then_some(ending)
}
