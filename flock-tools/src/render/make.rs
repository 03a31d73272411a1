//! From plans to clips: every core renders, finished clips stay, an interrupted run goes on where it was.
//!
//! Owns the order of the work and the record of what is done. Never decides what is made: the plans do. Several
//! processes may work on one flock, on one machine or on many: each takes the clips that nobody else has taken.
//!
//! Start at [`make`]. A clip's frames are kept by `frames.rs` until the clip is whole; `bench.rs` puts them together.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::{io, slice, thread, vec};

use flame::Renderer;
use flock::{ClipHash, ClipPath};
use indicatif::{ProgressBar, ProgressStyle};
use video::{EncodeError, Encoder};

use super::bench::{Bench, Taken};
use super::plan::{ClipPlan, Look};

/// How the work is shared out.
#[derive(Clone, Debug)]
pub(crate) struct Effort {
    /// Frames rendered at once.
    pub(crate) threads: NonZeroUsize,
    /// Whether frames outlive their clip, so that another encoding needs no rendering.
    pub(crate) keep_frames: bool,
    /// Once it is set, everyone leaves off within a moment.
    pub(crate) stop: Arc<AtomicBool>,
}

/// How it ended for a clip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Another process is at it.
    Busy,
    /// It was finished now.
    Made(ClipHash),
    /// An earlier run made it from just this.
    Stood(ClipHash),
    /// It was not finished: the run was stopped.
    Unfinished,
}

/// What a run did.
#[derive(Debug)]
pub(crate) struct Yield {
    /// One for each plan.
    pub(crate) outcomes: Vec<Outcome>,
    /// Frames that were rendered now.
    pub(crate) frames: u64,
}

/// Why clips were not made. What was finished stays finished.
#[derive(Debug, thiserror::Error)]
pub(crate) enum MakeError {
    /// A clip could not be encoded.
    #[error("cannot finish a clip")]
    Encode(#[source] EncodeError),
    /// A file or folder could not be read or written.
    #[error("cannot use `{path}`")]
    File {
        /// Which.
        path: PathBuf,
        /// What the kernel said.
        source: io::Error,
    },
    /// A frame could not be rendered.
    #[error("cannot render frame {frame} of `{clip}`: {reason}")]
    Render {
        /// The clip.
        clip: ClipPath,
        /// The frame, from 0.
        frame: u32,
        /// What the renderer said.
        reason: String,
    },
    /// The system refused threads.
    #[error("cannot start rendering: {reason}")]
    Threads {
        /// What it said.
        reason: String,
    },
    /// A rendered frame was damaged on the disk before it was encoded.
    #[error("frame {frame} of `{clip}` is damaged on the disk (the next run renders it again)")]
    Torn {
        /// The clip.
        clip: ClipPath,
        /// The frame, from 0.
        frame: u32,
    },
}

/// Makes `clips` in `folder`, except those that an earlier run made from just the same. `finished` hears of each as it
/// comes under its name.
///
/// # Errors
/// [`MakeError`] names the clip. What is finished stays finished, and rendered frames are kept.
pub(crate) fn make(
    clips: &[ClipPlan],
    look: &Look,
    folder: &Path,
    effort: &Effort,
    finished: &(dyn Fn(&ClipPlan, ClipHash) + Sync),
) -> Result<Yield, MakeError> {
    if let Some(clip) = clips.first() {
        // Before days of rendering, not after.
        Encoder::check(&clip.path.inside(folder), &look.form, look.quality).map_err(MakeError::Encode)?;
    }
    let shift = Shift {
        look,
        folder,
        effort,
        finished,
        progress: progress(clips.iter().map(|clip| u64::from(clip.frames.0)).sum()),
        queue: Mutex::new(Queue { waiting: clips.iter(), passed: 0, open: None }),
        outcomes: Mutex::new(vec![Outcome::Unfinished; clips.len()]),
        frames: AtomicU64::new(0),
    };
    thread::scope(|scope| {
        let mut hands = Vec::new();
        for _ in 0..effort.threads.get() {
            match thread::Builder::new().spawn_scoped(scope, || shift.work()) {
                Ok(hand) => hands.push(hand),
                Err(error) if hands.is_empty() => return Err(MakeError::Threads { reason: error.to_string() }),
                // Those that are there do the work.
                Err(_) => break,
            }
        }
        let ended: Vec<_> =
            hands.into_iter().map(|hand| hand.join().expect("a panic while rendering is a bug")).collect();
        ended.into_iter().collect::<Result<(), _>>()
    })?;
    shift.progress.finish_and_clear();
    let outcomes = shift.outcomes.into_inner().unwrap_or_else(PoisonError::into_inner);
    Ok(Yield { outcomes, frames: shift.frames.into_inner() })
}

/// What all threads share.
struct Shift<'a> {
    look: &'a Look,
    folder: &'a Path,
    effort: &'a Effort,
    finished: &'a (dyn Fn(&ClipPlan, ClipHash) + Sync),
    progress: ProgressBar,
    queue: Mutex<Queue<'a>>,
    outcomes: Mutex<Vec<Outcome>>,
    frames: AtomicU64,
}

/// The work that nobody has taken yet.
struct Queue<'a> {
    waiting: slice::Iter<'a, ClipPlan>,
    /// How many of the clips no longer wait.
    passed: usize,
    /// The clip at hand and those of its frames that nobody has taken.
    open: Option<(Arc<Bench<'a>>, vec::IntoIter<u32>)>,
}

/// A frame to render, or none where only the encoding is left.
struct Task<'a> {
    bench: Arc<Bench<'a>>,
    frame: Option<u32>,
}

impl<'a> Shift<'a> {
    /// Takes task after task, until none is left, someone failed or the run is stopped.
    fn work(&self) -> Result<(), MakeError> {
        let done = self.work_on();
        if done.is_err() {
            self.effort.stop.store(true, Ordering::Relaxed);
        }
        done
    }

    fn work_on(&self) -> Result<(), MakeError> {
        let renderer = Renderer::new(1).map_err(|error| MakeError::Threads { reason: error.to_string() })?;
        let renderer = renderer.with_stop_flag(Arc::clone(&self.effort.stop));
        while !self.effort.stop.load(Ordering::Relaxed) {
            let Some(task) = self.next()? else { break };
            self.do_it(&task, &renderer)?;
        }
        Ok(())
    }

    /// The next task. Whoever comes for the first one of a clip looks at what earlier runs left of it.
    fn next(&self) -> Result<Option<Task<'a>>, MakeError> {
        let mut queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some((bench, frames)) = &mut queue.open {
                if let Some(frame) = frames.next() {
                    return Ok(Some(Task { bench: Arc::clone(bench), frame: Some(frame) }));
                }
                queue.open = None;
            }
            let Some(clip) = queue.waiting.next() else { return Ok(None) };
            let number = queue.passed;
            queue.passed += 1;
            let (outcome, missing) = match Bench::take(clip, number, self.look, self.folder)? {
                Taken::Busy => (Outcome::Busy, 0),
                Taken::Stood(hash) => (Outcome::Stood(hash), 0),
                Taken::Open(bench, missing) => {
                    let (bench, count) = (Arc::new(bench), missing.len());
                    self.progress.dec_length(u64::from(clip.frames.0) - count as u64);
                    if missing.is_empty() {
                        return Ok(Some(Task { bench, frame: None }));
                    }
                    queue.open = Some((bench, missing.into_iter()));
                    continue;
                }
            };
            self.progress.dec_length(u64::from(clip.frames.0) - missing);
            self.note(number, outcome);
        }
    }

    /// Renders the frame; whoever renders the last one of a clip finishes it.
    fn do_it(&self, Task { bench, frame }: &Task<'a>, renderer: &Renderer) -> Result<(), MakeError> {
        if let Some(frame) = *frame {
            let (clip, number) = (bench.clip(), frame);
            let failed = |reason| MakeError::Render { clip: clip.path.clone(), frame, reason };
            let Some(picture) = clip.picture(number, self.look, renderer).map_err(failed)? else { return Ok(()) };
            let last = bench.keep(frame, &picture)?;
            self.frames.fetch_add(1, Ordering::Relaxed);
            self.progress.inc(1);
            if !last {
                return Ok(());
            }
        }
        if let Some(hash) = bench.finish(self.look, &self.effort.stop)? {
            self.note(bench.number(), Outcome::Made(hash));
            self.progress.suspend(|| (self.finished)(bench.clip(), hash));
            if !self.effort.keep_frames {
                bench.clear()?;
            }
        }
        Ok(())
    }

    fn note(&self, number: usize, outcome: Outcome) {
        self.outcomes.lock().unwrap_or_else(PoisonError::into_inner)[number] = outcome;
    }
}

/// Frames and what remains of the time, on a terminal; nothing elsewhere.
fn progress(frames: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} frames, {eta} to go").expect("a fixed template");
    ProgressBar::new(frames).with_style(style)
}
