//! Renders clips from their plans on all cores; an interrupted run continues where it stopped.
//!
//! Owns the queue of frames and the threads. Never chooses the clips: `selection.rs` does. Several processes may render one
//! flock, on one machine or on many: each takes clips that no other process has claimed.
//!
//! Start at [`make`]. `frames.rs` stores the frames of a clip until it is encoded; `clip_job.rs` encodes it.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::{io, thread, vec};

use flock::{ClipHash, ClipPath};
use species::Threads;
use video::{EncodeError, Encoder};

use super::clip_job::{Claim, ClipJob};
use super::plan::{ClipPlan, Look};
use super::shard::Part;
use crate::program::{Exit, Fatal, progress::FrameProgress};

/// How a run renders.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Frames rendered at once.
    pub threads: NonZeroUsize,
    /// Whether frames are kept when their clip is finished, so that another encoding needs no rendering.
    pub keep_frames: bool,
    /// Once it is set, all threads stop within a moment.
    pub stop: Arc<AtomicBool>,
    /// Which frames.
    pub part: Part,
    /// Whether progress is shown on stderr.
    pub shows_progress: bool,
}

/// What rendering did with a clip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Another process renders it.
    Busy,
    /// This run finished it.
    Made(ClipHash),
    /// This run's part of its frames is rendered.
    Rendered,
    /// An earlier run made it from the same recipe.
    UpToDate(ClipHash),
    /// It was not finished: the run was stopped.
    Unfinished,
}

/// The result of a run.
#[derive(Debug)]
pub struct RunResult {
    /// One for each plan.
    pub outcomes: Vec<Outcome>,
    /// Frames that this run rendered.
    pub frames: u64,
}

/// Why clips were not made. Finished clips stay.
#[derive(Debug, thiserror::Error)]
pub enum MakeError {
    /// A rendered frame was damaged on the disk before it was encoded.
    #[error("frame {frame} of `{clip}` is damaged on the disk (the next run renders it again)")]
    DamagedFrame {
        /// The clip.
        clip: ClipPath,
        /// The frame, from 0.
        frame: u32,
    },
    /// A clip could not be encoded.
    #[error("cannot encode a clip")]
    Encode(#[source] EncodeError),
    /// A file or folder could not be read or written.
    #[error("cannot use `{path}`")]
    File {
        /// Which.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// A frame could not be rendered.
    #[error("cannot render frame {frame} of `{clip}`: {reason}")]
    Render {
        /// The clip.
        clip: ClipPath,
        /// The frame, from 0.
        frame: u32,
        /// The renderer's error.
        reason: String,
    },
    /// The system refused threads.
    #[error("cannot start rendering: {reason}")]
    Threads {
        /// Its error.
        reason: String,
    },
}

/// Follows a run.
pub trait Watch: Sync {
    /// Returns when the next frame may be begun.
    fn hold(&self);
    /// `done` of `of` frames are there, rendered by this run or by an earlier one.
    fn rendered(&self, done: u64, of: u64);
}

/// Nobody follows the run.
struct Unwatched;

impl Watch for Unwatched {
    fn hold(&self) {}
    fn rendered(&self, _: u64, _: u64) {}
}

/// Makes `clips` in `folder`, or this run's part of them, except those that an earlier run made from the same recipe.
/// `finished` is called for each clip that is in its place.
/// Errors: [`MakeError`] names the clip. Finished clips and rendered frames are kept.
pub fn make<'a>(
    clips: impl IntoIterator<Item = &'a ClipPlan>,
    look: &Look,
    folder: &Path,
    options: &RunOptions,
    finished: &(dyn Fn(&ClipPlan, ClipHash) + Sync),
) -> Result<RunResult, MakeError> {
    make_watched(clips, look, folder, options, finished, &Unwatched)
}

/// The same; `watch` follows it.
/// Errors: As [`make`].
pub fn make_watched<'a>(
    clips: impl IntoIterator<Item = &'a ClipPlan>,
    look: &Look,
    folder: &Path,
    options: &RunOptions,
    finished: &(dyn Fn(&ClipPlan, ClipHash) + Sync),
    watch: &dyn Watch,
) -> Result<RunResult, MakeError> {
    let clips: Vec<_> = clips.into_iter().collect();
    let part = &options.part;
    if let Some(clip) = clips.first().filter(|_| part.is_encoded()) {
        // Before days of rendering.
        Encoder::check(&clip.path.inside(folder), &look.form, clip.quality).map_err(MakeError::Encode)?;
    }
    let pool = Pool {
        look,
        folder,
        options,
        finished,
        watch,
        there: AtomicU64::new(0),
        of: frames(&clips, part),
        progress: if options.shows_progress {
            FrameProgress::new(frames(&clips, part))
        } else {
            FrameProgress::hidden()
        },
        outcomes: Mutex::new(vec![Outcome::Unfinished; clips.len()]),
        queue: Mutex::new(Queue { waiting: clips.into_iter(), passed: 0, open: None }),
        frames: AtomicU64::new(0),
    };
    thread::scope(|scope| {
        let mut threads = Vec::new();
        for _ in 0..options.threads.get() {
            match thread::Builder::new().spawn_scoped(scope, || pool.work()) {
                Ok(thread) => threads.push(thread),
                Err(error) if threads.is_empty() => return Err(MakeError::Threads { reason: error.to_string() }),
                // The threads that could be started do the work.
                Err(_) => break,
            }
        }
        let results: Vec<_> =
            threads.into_iter().map(|thread| thread.join().expect("a panic while rendering is a bug")).collect();
        results.into_iter().collect::<Result<(), _>>()
    })?;
    pool.progress.end();
    let outcomes = pool.outcomes.into_inner().unwrap_or_else(PoisonError::into_inner);
    Ok(RunResult { outcomes, frames: pool.frames.into_inner() })
}

/// The number of frames of `clips` that are in `part`.
fn frames(clips: &[&ClipPlan], part: &Part) -> u64 {
    clips.iter().map(|clip| frames_in(clip, part)).sum()
}

fn frames_in(clip: &ClipPlan, part: &Part) -> u64 {
    (0..clip.frames.0).filter(|frame| part.has(&clip.path, *frame)).count() as u64
}

/// The state that all threads share.
struct Pool<'a> {
    look: &'a Look,
    folder: &'a Path,
    options: &'a RunOptions,
    finished: &'a (dyn Fn(&ClipPlan, ClipHash) + Sync),
    watch: &'a dyn Watch,
    /// Frames that are there, of all.
    there: AtomicU64,
    of: u64,
    progress: FrameProgress,
    queue: Mutex<Queue<'a>>,
    outcomes: Mutex<Vec<Outcome>>,
    frames: AtomicU64,
}

/// The work that no thread has taken yet.
struct Queue<'a> {
    waiting: vec::IntoIter<&'a ClipPlan>,
    /// The number of clips that no longer wait.
    passed: usize,
    /// The current clip and those of its frames that no thread has taken.
    open: Option<(Arc<ClipJob<'a>>, vec::IntoIter<u32>)>,
}

/// A frame to render, or none where only the encoding is left.
struct Task<'a> {
    job: Arc<ClipJob<'a>>,
    frame: Option<u32>,
}

impl<'a> Pool<'a> {
    /// Runs tasks until none is left, a thread fails or the run is stopped.
    fn work(&self) -> Result<(), MakeError> {
        let result = self.run_tasks();
        if result.is_err() {
            self.options.stop.store(true, Ordering::Relaxed);
        }
        result
    }

    fn run_tasks(&self) -> Result<(), MakeError> {
        let threads = Threads::new(1).map_err(|error| MakeError::Threads { reason: error.to_string() })?;
        let threads = threads.with_stop_flag(Arc::clone(&self.options.stop));
        loop {
            self.watch.hold();
            if self.options.stop.load(Ordering::Relaxed) {
                break;
            }
            let Some(task) = self.next()? else { break };
            self.run(&task, &threads)?;
        }
        Ok(())
    }

    /// The next task. The thread that takes the first one of a clip claims the clip.
    fn next(&self) -> Result<Option<Task<'a>>, MakeError> {
        let mut queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some((job, frames)) = &mut queue.open {
                if let Some(frame) = frames.next() {
                    return Ok(Some(Task { job: Arc::clone(job), frame: Some(frame) }));
                }
                queue.open = None;
            }
            let Some(clip) = queue.waiting.next() else { return Ok(None) };
            let number = queue.passed;
            queue.passed += 1;
            let part = &self.options.part;
            let (outcome, missing) = match ClipJob::claim(clip, number, self.look, self.folder, part)? {
                Claim::Busy => (Outcome::Busy, Vec::new()),
                Claim::UpToDate(hash) => (Outcome::UpToDate(hash), Vec::new()),
                Claim::Job(_, missing) if missing.is_empty() && !part.is_encoded() => (Outcome::Rendered, missing),
                Claim::Job(job, missing) => {
                    let job = Arc::new(job);
                    self.skip(frames_in(clip, part) - missing.len() as u64);
                    if missing.is_empty() {
                        return Ok(Some(Task { job, frame: None }));
                    }
                    queue.open = Some((job, missing.into_iter()));
                    continue;
                }
            };
            self.skip(frames_in(clip, part) - missing.len() as u64);
            self.set_outcome(number, outcome);
        }
    }

    /// Renders the frame; the thread that renders the last one of a clip encodes the clip.
    fn run(&self, Task { job, frame }: &Task<'a>, threads: &Threads) -> Result<(), MakeError> {
        if let Some(frame) = *frame {
            let (clip, number) = (job.clip(), frame);
            let failed = |reason| MakeError::Render { clip: clip.path.clone(), frame, reason };
            let Some(picture) = clip.picture(number, self.look, threads).map_err(failed)? else { return Ok(()) };
            let last = job.store(frame, &picture)?;
            self.frames.fetch_add(1, Ordering::Relaxed);
            self.progress.add(1);
            self.tell(1);
            if !last {
                return Ok(());
            }
            if !self.options.part.is_encoded() {
                self.set_outcome(job.number(), Outcome::Rendered);
                return Ok(());
            }
        }
        if let Some(hash) = job.finish(self.look, &self.options.stop)? {
            self.set_outcome(job.number(), Outcome::Made(hash));
            self.progress.suspend(|| (self.finished)(job.clip(), hash));
            if !self.options.keep_frames {
                job.clear()?;
            }
        }
        Ok(())
    }

    /// So many frames are there from earlier runs.
    fn skip(&self, frames: u64) {
        self.progress.skip(frames);
        self.tell(frames);
    }

    /// So many more frames are there.
    fn tell(&self, frames: u64) {
        self.watch.rendered(self.there.fetch_add(frames, Ordering::Relaxed) + frames, self.of);
    }

    fn set_outcome(&self, number: usize, outcome: Outcome) {
        self.outcomes.lock().unwrap_or_else(PoisonError::into_inner)[number] = outcome;
    }
}

/// Ends a command whose clips could not be made.
pub fn make_fatal(error: MakeError) -> Fatal {
    Fatal::new(Exit::Unreadable, error).hint("the same command continues where this one stopped")
}
