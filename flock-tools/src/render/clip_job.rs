//! One clip on its way: its frames, its lock, its record, and how it comes under its name.
//!
//! Owns the workshop in the flock's folder. A clip is encoded beside its place, its hash recorded, and only then does
//! it take its name: at every moment the name has a whole clip or the one that was there before.
//!
//! Start at [`Bench::take`]; `make.rs` says who does it.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use flock::{ClipHash, ClipPath};
use video::{Encoder, Yuv420p};

use super::frames::FrameStore;
use super::make::MakeError;
use super::plan::{ClipPlan, Look};

/// Where frames and records lie, in the flock's folder.
pub(super) const WORKSHOP: &str = ".render";

/// What became of the attempt to take a clip.
pub(super) enum Taken<'a> {
    /// Another process has it.
    Busy,
    /// It is there, made from just this.
    Stood(ClipHash),
    /// It is ours, and these of its frames are missing.
    Open(Bench<'a>, Vec<u32>),
}

/// One clip on its way, ours as long as this lives.
pub(super) struct Bench<'a> {
    clip: &'a ClipPlan,
    number: usize,
    /// Where the finished clip goes.
    path: PathBuf,
    record: Record,
    store: FrameStore,
    /// How many frames are not rendered yet.
    left: AtomicU32,
}

/// What a finished clip was made from and what it hashes to. The file is locked as long as somebody works on the clip.
struct Record {
    path: PathBuf,
    file: File,
}

impl<'a> Bench<'a> {
    /// Takes `clip`, which is number `number` of its run, and sees what earlier runs left of it.
    pub(super) fn take(clip: &'a ClipPlan, number: usize, look: &Look, folder: &Path) -> Result<Taken<'a>, MakeError> {
        let path = clip.path.inside(folder);
        let workshop = folder.join(WORKSHOP).join(clip.path.as_str());
        for parent in [&path, &workshop].into_iter().filter_map(|path| path.parent()) {
            fs::create_dir_all(parent).map_err(at(parent))?;
        }
        let Some(mut record) = Record::lock(folder, &clip.path)? else { return Ok(Taken::Busy) };
        if path.is_file()
            && let Some((made_as, hash)) = record.read()?
            && made_as == clip.made_as
            && hash == hash_of(&path)?
        {
            return Ok(Taken::Stood(hash));
        }
        let store = FrameStore::open(&workshop, look.form.size, clip.pictures).map_err(at(&workshop))?;
        let mut missing = Vec::new();
        for frame in 0..clip.frames.0 {
            if store.get(frame).map_err(at(&workshop))?.is_none() {
                missing.push(frame);
            }
        }
        let left = AtomicU32::new(missing.len() as u32);
        Ok(Taken::Open(Self { clip, number, path, record, store, left }, missing))
    }

    /// What is made.
    pub(super) fn clip(&self) -> &'a ClipPlan {
        self.clip
    }

    /// Its number in its run.
    pub(super) fn number(&self) -> usize {
        self.number
    }

    /// Keeps a rendered frame. Answers whether it was the last one that was missing.
    pub(super) fn keep(&self, frame: u32, picture: &Yuv420p) -> Result<bool, MakeError> {
        self.store.put(frame, picture).map_err(at(&self.path))?;
        Ok(self.left.fetch_sub(1, Ordering::AcqRel) == 1)
    }

    /// Encodes the frames and gives the clip its name; `None` if `stop` was set before.
    pub(super) fn finish(&self, look: &Look, stop: &AtomicBool) -> Result<Option<ClipHash>, MakeError> {
        let new = with_suffix(&self.path, ".new");
        let finished = self.encode(&new, look, stop);
        if !matches!(finished, Ok(Some(_))) {
            // Of no use to anyone, and the disk may be full.
            let _ = fs::remove_file(&new);
        }
        finished
    }

    fn encode(&self, new: &Path, look: &Look, stop: &AtomicBool) -> Result<Option<ClipHash>, MakeError> {
        let mut encoder = Encoder::create(new, &look.form, look.quality).map_err(MakeError::Encode)?;
        for frame in 0..self.clip.frames.0 {
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            let picture = self.store.get(frame).map_err(at(&self.path))?;
            let picture = picture.ok_or_else(|| MakeError::Torn { clip: self.clip.path.clone(), frame })?;
            encoder.push(&picture).map_err(MakeError::Encode)?;
        }
        encoder.finish().map_err(MakeError::Encode)?;
        let hash = hash_of(new)?;
        self.record.write(self.clip.made_as, hash)?;
        fs::rename(new, &self.path).map_err(at(&self.path))?;
        let folder = self.path.parent().unwrap_or(Path::new("."));
        File::open(folder).and_then(|folder| folder.sync_all()).map_err(at(folder))?;
        Ok(Some(hash))
    }

    /// Throws the frames away.
    pub(super) fn clear(&self) -> Result<(), MakeError> {
        self.store.clear().map_err(at(&self.path))
    }
}

impl Record {
    /// The record of the clip at `path` in the flock's `folder`, locked; `None` if another process has it.
    fn lock(folder: &Path, path: &ClipPath) -> Result<Option<Self>, MakeError> {
        let path = record_of(folder, path);
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
        let file = file.map_err(at(&path))?;
        match file.try_lock() {
            Ok(()) => Ok(Some(Self { path, file })),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(source)) => Err(MakeError::File { path, source }),
        }
    }

    fn read(&mut self) -> Result<Option<(ClipHash, ClipHash)>, MakeError> {
        let mut text = String::new();
        match self.file.read_to_string(&mut text) {
            // A crash may have left anything.
            Err(error) if error.kind() == io::ErrorKind::InvalidData => Ok(None),
            read => read.map(|_| parsed(&text)).map_err(at(&self.path)),
        }
    }

    fn write(&self, made_as: ClipHash, hash: ClipHash) -> Result<(), MakeError> {
        let mut file = &self.file;
        let written = file.rewind().and_then(|()| file.set_len(0)).and_then(|()| write!(file, "{made_as}\n{hash}\n"));
        written.and_then(|()| file.sync_all()).map_err(at(&self.path))
    }
}

/// The hash of the clip that the tools made last at `path` in the flock's `folder`, if they made one.
pub(crate) fn recorded(folder: &Path, path: &ClipPath) -> Option<ClipHash> {
    let text = fs::read_to_string(record_of(folder, path)).ok()?;
    Some(parsed(&text)?.1)
}

/// What the file at `path` hashes to.
pub(crate) fn hash_of(path: &Path) -> Result<ClipHash, MakeError> {
    File::open(path).and_then(ClipHash::of).map_err(at(path))
}

fn record_of(folder: &Path, path: &ClipPath) -> PathBuf {
    with_suffix(&folder.join(WORKSHOP).join(path.as_str()), ".made")
}

/// What the clip was made from, and its hash.
fn parsed(record: &str) -> Option<(ClipHash, ClipHash)> {
    let (made_as, hash) = record.strip_suffix('\n')?.split_once('\n')?;
    ClipHash::parse(made_as).ok().zip(ClipHash::parse(hash).ok())
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name: OsString = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

fn at(path: &Path) -> impl Fn(io::Error) -> MakeError {
    let path = path.to_owned();
    move |source| MakeError::File { path: path.clone(), source }
}
