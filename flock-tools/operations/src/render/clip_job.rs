//! The rendering of one clip: its lock, its frames, its record, and its final rename.
//!
//! Owns the scratch folder in the flock's folder. A clip is encoded beside its place, its hash is recorded, and then it is
//! renamed: at every moment its path has the whole new clip, or what was there before.
//!
//! Start at [`ClipJob::claim`]; `make.rs` gives the jobs to threads.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use flock::{ClipHash, ClipPath};
use video::{Encoder, Yuv420p};

use super::frames::FrameStore;
use super::make::MakeError;
use super::plan::{ClipPlan, Look};
use super::shard::{Part, Shard};
use crate::flock_folder::paths;

/// The scratch folder of frames and records, in the flock's folder.
pub const SCRATCH: &str = ".render";

/// The answer to the claim of a clip.
pub enum Claim<'a> {
    /// Another process renders it.
    Busy,
    /// It is there, rendered from the same recipe.
    UpToDate(ClipHash),
    /// This process renders it or its part of it, and these frames are missing.
    Job(ClipJob<'a>, Vec<u32>),
}

/// A clip that this process renders; other processes leave it alone until this is dropped. Those that render parts of it
/// share it.
pub struct ClipJob<'a> {
    clip: &'a ClipPlan,
    number: usize,
    /// The path of the finished clip.
    path: PathBuf,
    record: Record,
    store: FrameStore,
    /// The number of frames that are not rendered yet.
    left: AtomicU32,
}

/// The recipe of a finished clip and its hash. The file is locked while a process renders the clip.
struct Record {
    path: PathBuf,
    file: File,
}

impl<'a> ClipJob<'a> {
    /// Claims `part` of `clip`, which is number `number` of its run, and looks for the frames that earlier runs rendered.
    pub fn claim(
        clip: &'a ClipPlan,
        number: usize,
        look: &Look,
        folder: &Path,
        part: &Part,
    ) -> Result<Claim<'a>, MakeError> {
        let path = clip.path.inside(folder);
        let scratch = folder.join(SCRATCH).join(clip.path.as_str());
        for parent in [&path, &scratch].into_iter().filter_map(|path| path.parent()) {
            fs::create_dir_all(parent).map_err(at(parent))?;
        }
        let Some(mut record) = Record::lock(folder, &clip.path, part)? else { return Ok(Claim::Busy) };
        if path.is_file()
            && let Some((recipe, hash)) = record.read()?
            && recipe == clip.recipe
            && hash == hash_of(&path)?
        {
            return Ok(Claim::UpToDate(hash));
        }
        let store = FrameStore::open(&scratch, look.form.size, clip.picture_recipe).map_err(at(&scratch))?;
        if part.is_encoded() {
            store.sweep().map_err(at(&scratch))?;
        }
        let mut missing = Vec::new();
        for frame in (0..clip.frames.0).filter(|frame| part.has(&clip.path, *frame)) {
            if store.get(frame).map_err(at(&scratch))?.is_none() {
                missing.push(frame);
            }
        }
        let left = AtomicU32::new(missing.len() as u32);
        Ok(Claim::Job(Self { clip, number, path, record, store, left }, missing))
    }

    /// Its plan.
    pub fn clip(&self) -> &'a ClipPlan {
        self.clip
    }

    /// Its number in its run.
    pub fn number(&self) -> usize {
        self.number
    }

    /// Stores a rendered frame. Returns whether it was the last one that was missing.
    pub fn store(&self, frame: u32, picture: &Yuv420p) -> Result<bool, MakeError> {
        self.store.put(frame, picture).map_err(at(&self.path))?;
        Ok(self.left.fetch_sub(1, Ordering::AcqRel) == 1)
    }

    /// Encodes the frames and renames the clip to its path; `None` if `stop` was set before.
    pub fn finish(&self, look: &Look, stop: &AtomicBool) -> Result<Option<ClipHash>, MakeError> {
        let new = paths::with_suffix(&self.path, ".new");
        let finished = self.encode(&new, look, stop);
        if !matches!(finished, Ok(Some(_))) {
            // It is useless, and the disk may be full.
            let _ = fs::remove_file(&new);
        }
        finished
    }

    fn encode(&self, new: &Path, look: &Look, stop: &AtomicBool) -> Result<Option<ClipHash>, MakeError> {
        let mut encoder = Encoder::create(new, &look.form, self.clip.quality).map_err(MakeError::Encode)?;
        for frame in 0..self.clip.frames.0 {
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            let picture = self.store.get(frame).map_err(at(&self.path))?;
            let picture = picture.ok_or_else(|| MakeError::DamagedFrame { clip: self.clip.path.clone(), frame })?;
            encoder.push(&picture).map_err(MakeError::Encode)?;
        }
        encoder.finish().map_err(MakeError::Encode)?;
        let hash = hash_of(new)?;
        self.record.write(self.clip.recipe, hash)?;
        durable::persist(new, &self.path).map_err(at(&self.path))?;
        Ok(Some(hash))
    }

    /// Deletes the frames.
    pub fn clear(&self) -> Result<(), MakeError> {
        self.store.clear().map_err(at(&self.path))
    }
}

impl Record {
    /// The record of the clip at `path` in the flock's `folder`, locked for `part`; `None` if another process has it.
    fn lock(folder: &Path, path: &ClipPath, part: &Part) -> Result<Option<Self>, MakeError> {
        let path = record_of(folder, path);
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
        let file = file.map_err(at(&path))?;
        match if part.is_encoded() { file.try_lock() } else { file.try_lock_shared() } {
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

    fn write(&self, recipe: ClipHash, hash: ClipHash) -> Result<(), MakeError> {
        let mut file = &self.file;
        let written = file.rewind().and_then(|()| file.set_len(0)).and_then(|()| write!(file, "{recipe}\n{hash}\n"));
        written.and_then(|()| file.sync_all()).map_err(at(&self.path))
    }
}

/// The recipe and the hash of the clip that the tools rendered last at `path` in the flock's `folder`, if they did.
pub fn recorded(folder: &Path, path: &ClipPath) -> Option<(ClipHash, ClipHash)> {
    parsed(&fs::read_to_string(record_of(folder, path)).ok()?)
}

/// Whether a process renders the whole clip at `path` in the flock's `folder`, and not only a part of it.
pub fn is_taken(folder: &Path, path: &ClipPath) -> bool {
    matches!(Record::lock(folder, path, &Part::Shard(Shard::ALL)), Ok(None))
}

/// The frames of `clip` in the flock's `folder`, of a run that writes none of them.
pub fn frames_of(clip: &ClipPlan, look: &Look, folder: &Path) -> FrameStore {
    FrameStore::at(&folder.join(SCRATCH).join(clip.path.as_str()), look.form.size, clip.picture_recipe)
}

/// The hash of the file at `path`.
pub fn hash_of(path: &Path) -> Result<ClipHash, MakeError> {
    File::open(path).and_then(ClipHash::of).map_err(at(path))
}

fn record_of(folder: &Path, path: &ClipPath) -> PathBuf {
    paths::with_suffix(&folder.join(SCRATCH).join(path.as_str()), ".made")
}

/// The recipe of the clip, and its hash.
fn parsed(record: &str) -> Option<(ClipHash, ClipHash)> {
    let (recipe, hash) = record.strip_suffix('\n')?.split_once('\n')?;
    ClipHash::parse(recipe).ok().zip(ClipHash::parse(hash).ok())
}

fn at(path: &Path) -> impl Fn(io::Error) -> MakeError {
    let path = path.to_owned();
    move |source| MakeError::File { path: path.clone(), source }
}
