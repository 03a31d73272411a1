//! From a plan to clips: every core renders, finished clips stay, an interrupted run goes on where it was.
//!
//! Owns the order of the work and the record of what is done. Never decides what is made: the plan does.
//!
//! Start at [`make`]. Each clip's frames are kept by `frames.rs` until the clip is whole.

use std::fs;
use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering};
use std::thread;

use flame::{Flame, Renderer, Settings, Species};
use flock::ClipHash;
use indicatif::{ProgressBar, ProgressStyle};
use video::{Encoder, Form, Quality, Yuv420p};

use super::DemoError;
use super::frames::FrameStore;
use super::plan::{ClipPlan, Look, Plan};

/// Where frames and records lie, in the flock's folder.
const WORKSHOP: &str = ".demo";

/// Every frame of a clip is drawn from the same random numbers: what noise there is then moves with the flame, which
/// looks calmer and costs fewer bits than noise that flickers.
const SEED: u64 = 1;

/// How the work is shared out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// Frames rendered at once.
    pub(crate) threads: NonZeroUsize,
    /// Whether frames outlive their clip, so that another encoding needs no rendering.
    pub(crate) keep_frames: bool,
}

/// Makes the clips of `plan` in `folder`, except those that an earlier run made. Answers their hashes, in the plan's
/// order.
///
/// # Errors
/// [`DemoError`] names the clip. What is finished stays finished.
pub(crate) fn make(plan: &Plan, folder: &Path, effort: Effort) -> Result<Vec<ClipHash>, DemoError> {
    let benches =
        plan.clips.iter().map(|clip| Bench::set_up(clip, &plan.look, folder)).collect::<Result<Vec<_>, _>>()?;
    let tasks: Vec<_> = benches.iter().flat_map(Bench::tasks).collect();
    let shift = Shift {
        look: &plan.look,
        keep_frames: effort.keep_frames,
        progress: progress(tasks.len()),
        next: AtomicUsize::new(0),
        stopped: AtomicBool::new(false),
        tasks,
    };
    thread::scope(|scope| {
        let hands: Vec<_> = (0..effort.threads.get()).map(|_| scope.spawn(|| shift.work())).collect();
        hands.into_iter().try_for_each(|hand| hand.join().expect("a panic while rendering is a bug"))
    })?;
    shift.progress.finish_and_clear();
    benches.iter().map(Bench::hash).collect()
}

/// Renders frame `number` of `clip` as the encoder takes it.
///
/// # Errors
/// [`DemoError::Render`].
pub(crate) fn picture(clip: &ClipPlan, number: u32, look: &Look, renderer: &Renderer) -> Result<Yuv420p, DemoError> {
    let settings = Settings {
        size: Some([look.size.0, look.size.1]),
        spp: Some(look.spp),
        supersample: Some(look.supersample),
        temporal_samples: None,
        seed: SEED,
    };
    let flame = Flame { motion: &*clip.motion, renderer };
    let failed = |reason: String| DemoError::Render { clip: clip.path.clone(), frame: number, reason };
    let image = flame.frame(f64::from(number), &settings).map_err(|error| failed(error.to_string()))?;
    Yuv420p::from_rgb16_dithered(look.size.0, look.size.1, &image.to_rgb16()).map_err(|error| failed(error.to_string()))
}

/// What all threads share.
struct Shift<'a> {
    look: &'a Look,
    keep_frames: bool,
    progress: ProgressBar,
    tasks: Vec<Task<'a>>,
    next: AtomicUsize,
    stopped: AtomicBool,
}

/// A frame to render, or none where only the encoding is left.
struct Task<'a> {
    bench: &'a Bench<'a>,
    open: &'a Open,
    frame: Option<u32>,
}

impl Shift<'_> {
    /// Takes task after task, until none is left or someone failed.
    fn work(&self) -> Result<(), DemoError> {
        let renderer = Renderer::new(1).map_err(|error| DemoError::Threads { reason: error.to_string() })?;
        while !self.stopped.load(Ordering::Relaxed) {
            let Some(task) = self.tasks.get(self.next.fetch_add(1, Ordering::Relaxed)) else { break };
            let done = task.do_it(self, &renderer);
            self.stopped.fetch_or(done.is_err(), Ordering::Relaxed);
            done?;
            self.progress.inc(1);
        }
        Ok(())
    }
}

/// One clip on its way.
struct Bench<'a> {
    clip: &'a ClipPlan,
    /// Where the finished clip goes.
    path: PathBuf,
    /// Where it is written what the finished clip was made from and what it hashes to.
    record: PathBuf,
    /// What is left to do; `None` if an earlier run finished the clip.
    open: Option<Open>,
}

/// What an earlier run left to do of a clip.
struct Open {
    store: FrameStore,
    missing: Vec<u32>,
    /// How many of `missing` are not rendered yet.
    left: AtomicU32,
}

impl<'a> Bench<'a> {
    /// Sees what an earlier run left of `clip`.
    fn set_up(clip: &'a ClipPlan, look: &Look, folder: &Path) -> Result<Self, DemoError> {
        let path = clip.path.inside(folder);
        let workshop = folder.join(WORKSHOP).join(clip.path.as_str());
        for parent in [&path, &workshop].into_iter().filter_map(|path| path.parent()) {
            fs::create_dir_all(parent).map_err(at(parent))?;
        }
        let mut bench = Self { clip, path, record: workshop.with_extension("made"), open: None };
        if !bench.is_made()? {
            bench.open = Some(Open::find(clip, look, &workshop).map_err(at(&workshop))?);
        }
        Ok(bench)
    }

    /// Whether the clip is there, made from what it would be made from now, and the same bytes as when it was made.
    fn is_made(&self) -> Result<bool, DemoError> {
        let Ok(record) = fs::read_to_string(&self.record) else { return Ok(false) };
        Ok(self.path.is_file() && record == self.record_of(self.hash()?))
    }

    fn record_of(&self, hash: ClipHash) -> String {
        format!("{}\n{hash}\n", self.clip.made_as)
    }

    /// What the finished clip hashes to.
    fn hash(&self) -> Result<ClipHash, DemoError> {
        fs::File::open(&self.path).and_then(ClipHash::of).map_err(at(&self.path))
    }

    fn tasks(&self) -> Vec<Task<'_>> {
        let Some(open) = &self.open else { return Vec::new() };
        if open.missing.is_empty() {
            return vec![Task { bench: self, open, frame: None }];
        }
        let task = |frame: &u32| Task { bench: self, open, frame: Some(*frame) };
        open.missing.iter().map(task).collect()
    }

    fn encode(&self, store: &FrameStore, look: &Look) -> Result<(), DemoError> {
        let form = Form { size: look.size, fps: look.fps };
        let quality = Quality { crf: look.crf, preset: look.preset, max_bits_per_second: None };
        let mut encoder = Encoder::create(&self.path, &form, quality).map_err(DemoError::Encode)?;
        for frame in 0..self.clip.frames.0 {
            let picture = store.get(frame).map_err(at(&self.path))?;
            let picture = picture.ok_or_else(|| DemoError::Torn { clip: self.clip.path.clone(), frame })?;
            encoder.push(&picture).map_err(DemoError::Encode)?;
        }
        encoder.finish().map_err(DemoError::Encode)?;
        fs::write(&self.record, self.record_of(self.hash()?)).map_err(at(&self.record))
    }
}

impl Open {
    fn find(clip: &ClipPlan, look: &Look, workshop: &Path) -> io::Result<Self> {
        let store = FrameStore::open(workshop, look.size, clip.pictures)?;
        let mut missing = Vec::new();
        for frame in 0..clip.frames.0 {
            if store.get(frame)?.is_none() {
                missing.push(frame);
            }
        }
        let left = AtomicU32::new(missing.len() as u32);
        Ok(Self { store, missing, left })
    }
}

impl Task<'_> {
    /// Renders the frame; whoever renders the last one finishes the clip.
    fn do_it(&self, shift: &Shift<'_>, renderer: &Renderer) -> Result<(), DemoError> {
        let Open { store, left, .. } = self.open;
        if let Some(frame) = self.frame {
            let picture = picture(self.bench.clip, frame, shift.look, renderer)?;
            store.put(frame, &picture).map_err(at(&self.bench.path))?;
            if left.fetch_sub(1, Ordering::AcqRel) > 1 {
                return Ok(());
            }
        }
        self.bench.encode(store, shift.look)?;
        if shift.keep_frames { Ok(()) } else { store.clear().map_err(at(&self.bench.path)) }
    }
}

/// Frames and what remains of the time, on a terminal; nothing elsewhere.
fn progress(tasks: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} frames, {eta} to go").expect("a fixed template");
    ProgressBar::new(tasks as u64).with_style(style)
}

fn at(path: &Path) -> impl Fn(io::Error) -> DemoError {
    let path = path.to_owned();
    move |source| DemoError::File { path: path.clone(), source }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three short clips, tiny and coarse.
    fn plan(crf: f32) -> Plan {
        let look = Look { size: (64, 36), spp: 2.0, crf, preset: "ultrafast", ..Look::small() };
        let mut plan = Plan::new(look).unwrap();
        plan.clips.truncate(3);
        plan.clips.iter_mut().for_each(|clip| clip.frames = timing::FrameCount(4));
        plan
    }

    fn effort(threads: usize) -> Effort {
        Effort { threads: NonZeroUsize::new(threads).unwrap(), keep_frames: true }
    }

    fn bytes(plan: &Plan, folder: &Path) -> Vec<Vec<u8>> {
        plan.clips.iter().map(|clip| fs::read(clip.path.inside(folder)).unwrap()).collect()
    }

    #[test]
    fn the_number_of_threads_changes_no_byte() {
        let (one, three) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let plan = plan(20.0);
        assert_eq!(make(&plan, one.path(), effort(1)).unwrap(), make(&plan, three.path(), effort(3)).unwrap());
        assert_eq!(bytes(&plan, one.path()), bytes(&plan, three.path()));
    }

    #[test]
    fn what_was_interrupted_goes_on_and_ends_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let plan = plan(20.0);
        make(&plan, folder.path(), effort(2)).unwrap();
        let whole = bytes(&plan, folder.path());
        let at = |clip: usize| plan.clips[clip].path.inside(folder.path());
        let workshop = |clip: usize| folder.path().join(WORKSHOP).join(plan.clips[clip].path.as_str());
        fs::write(at(0), &whole[0][..whole[0].len() / 2]).unwrap();
        fs::remove_file(workshop(1).with_extension("made")).unwrap();
        fs::write(workshop(1).join("000002.yuv"), b"torn").unwrap();
        fs::remove_file(at(2)).unwrap();
        make(&plan, folder.path(), effort(2)).unwrap();
        assert_eq!(bytes(&plan, folder.path()), whole);
    }

    #[test]
    fn what_is_finished_is_left_alone_until_the_settings_change() {
        let folder = tempfile::tempdir().unwrap();
        let (was, coarser) = (plan(20.0), plan(45.0));
        let first = make(&was, folder.path(), effort(2)).unwrap();
        let touched = |plan: &Plan| fs::metadata(plan.clips[0].path.inside(folder.path())).unwrap().modified().unwrap();
        let before = touched(&was);
        make(&was, folder.path(), effort(2)).unwrap();
        assert_eq!(touched(&was), before);
        assert_ne!(make(&coarser, folder.path(), effort(2)).unwrap(), first);
    }
}
