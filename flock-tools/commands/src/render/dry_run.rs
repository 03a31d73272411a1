//! The answer of a dry run: what would be rendered, and what it costs.
//!
//! Owns the count of frames that earlier runs have left, the look at the middles of transitions, and the answer.
//! `estimate.rs` measures. Never writes a file.
//!
//! Start at [`DryRun::new`].

use std::num::NonZeroUsize;
use std::path::Path;

use flock::ClipPath;
use operations::program::{Exit, Fatal, print};
use operations::render::clip_job::frames_of;
use operations::render::estimate;
use operations::render::plan::{ClipPlan, Look};
use operations::render::selection::{Selection, SkippedClip};
use operations::render::shard::Part;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use species::{Middle, MiddleFault, RenderError, Threads};

/// A clip in the answer.
#[derive(serde::Serialize)]
struct DryClip<'a> {
    clip: &'a ClipPath,
    /// All of them.
    frames: u32,
    /// `missing`, or `changed` for one that was rendered from another recipe.
    state: &'static str,
    /// Frames of this run's part that are rendered already.
    kept: u32,
    /// Whether it is a dissolve of two loops' pictures: there is no transition of their genomes, or a duller one.
    dissolve: bool,
    /// How good a transition is half way.
    #[serde(skip_serializing_if = "Option::is_none")]
    middle: Option<DryMiddle>,
    #[serde(skip)]
    left: u32,
}

/// The middle of a transition in the answer: see [`Middle`].
#[derive(serde::Serialize)]
struct DryMiddle {
    score: f64,
    brightness: f64,
    contrast: f64,
    lit: f64,
    white: f64,
    flicker: f64,
    faults: Vec<&'static str>,
}

impl From<Middle> for DryMiddle {
    fn from(middle: Middle) -> Self {
        let Middle { score, brightness, contrast, lit, white, flicker, faults } = middle;
        Self {
            score,
            brightness,
            contrast,
            lit,
            white,
            flicker,
            faults: faults.into_iter().map(MiddleFault::name).collect(),
        }
    }
}

/// The answer; with `--json` as it is.
#[derive(serde::Serialize)]
pub(super) struct DryRun<'a> {
    clips: Vec<DryClip<'a>>,
    left_out: &'a [SkippedClip],
    /// Frames to render.
    frames: u64,
    /// Frames that earlier runs have rendered.
    kept: u64,
    /// Samples to draw.
    samples: f64,
    cpu_hours: f64,
    /// On this machine.
    hours: f64,
    #[serde(skip)]
    threads: NonZeroUsize,
    /// What draws the samples, where that is not the processor.
    #[serde(skip_serializing_if = "Option::is_none")]
    gpu: Option<String>,
}

impl<'a> DryRun<'a> {
    /// Of `part` of the clips of `selection` in the flock's `folder`, with so many threads.
    /// Errors: [`Fatal`] if one cannot be rendered.
    pub(super) fn new(
        selection: &'a Selection,
        look: &Look,
        folder: &Path,
        part: &Part,
        threads: NonZeroUsize,
        gpu: Option<String>,
    ) -> Result<Self, Fatal> {
        let mut clips = Vec::new();
        let mut samples = 0.0;
        let malformed = |error| Fatal::new(Exit::Malformed, error);
        let middles = middles(selection, look).map_err(malformed)?;
        for (clip, middle) in selection.clips.iter().zip(middles) {
            let store = frames_of(clip, look, folder);
            let wanted: Vec<u32> = (0..clip.frames.0).filter(|frame| part.has(&clip.path, *frame)).collect();
            let kept = wanted.iter().filter(|frame| store.has(**frame)).count() as u32;
            let left = wanted.len() as u32 - kept;
            samples += estimate::samples(clip, left, look).map_err(malformed)?;
            let state = if selection.changed.contains(&clip.path) { "changed" } else { "missing" };
            let (frames, dissolve) = (clip.frames.0, clip.is_dissolve);
            clips.push(DryClip { clip: &clip.path, frames, state, kept, dissolve, middle, left });
        }
        let left = selection.clips.iter().zip(&clips).map(|(clip, told)| (clip, told.left));
        let seconds = estimate::seconds(left, look).map_err(malformed)?;
        let cpu_hours = seconds.cpu / 3600.0;
        // On a GPU frames take turns, though the processor may filter one meanwhile.
        let hours = if gpu.is_some() { seconds.wall / 3600.0 } else { cpu_hours / threads.get() as f64 };
        Ok(Self {
            left_out: &selection.left_out,
            frames: clips.iter().map(|clip| u64::from(clip.left)).sum(),
            kept: clips.iter().map(|clip| u64::from(clip.kept)).sum(),
            clips,
            samples,
            cpu_hours,
            hours,
            threads,
            gpu,
        })
    }

    /// Prints it.
    pub(super) fn print(&self, json: bool) -> Result<(), Fatal> {
        if json {
            return print::json(self);
        }
        let Self { frames, kept, samples, cpu_hours, hours, threads, gpu, .. } = self;
        let line = |clip: &DryClip| {
            let kept = if clip.kept > 0 { format!(", {} of them rendered", clip.kept) } else { String::new() };
            let middle = clip.middle.as_ref().map_or(String::new(), |middle| {
                let score = format!(", middle {:.2}", middle.score);
                [&[&*score], &middle.faults[..]].concat().join(", ")
            });
            let dissolve = if clip.dissolve { ", a dissolve" } else { "" };
            format!("{} {} frames{kept}, {}{dissolve}{middle}", clip.clip, clip.frames, clip.state)
        };
        let already = if *kept > 0 { format!(" ({kept} more are rendered)") } else { String::new() };
        let sum = format!(
            "total {frames} frames{already}, {samples:.3e} samples, {cpu_hours:.3} CPU hours, {hours:.3} hours with \
             {threads} threads{}",
            gpu.as_ref().map_or(String::new(), |gpu| format!(" and {gpu}"))
        );
        print::lines(self.clips.iter().map(line).chain([sum]))
    }
}

/// The middle of each clip that is a transition, on all cores.
fn middles(selection: &Selection, look: &Look) -> Result<Vec<Option<DryMiddle>>, RenderError> {
    let one_thread = || Threads::new(1).map_err(|error| RenderError::Refused(error.into()));
    let middle = |clip: &ClipPlan| Ok(clip.middle(look, &one_thread()?)?.map(DryMiddle::from));
    selection.clips.par_iter().map(middle).collect()
}
