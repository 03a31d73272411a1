//! The plan of an import as a whole, told before anything is encoded.
//!
//! Owns its figures and its words: how many clips and sheep, which clips are resampled and which look faster or slower, by
//! which matrix colours are read, what it costs. Never decides anything.
//!
//! Start at [`Summary::of`].

use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroUsize;

use flock::SheepId;
use operations::program::print;
use serde::Serialize;
use timing::Rate;

use super::estimate::Cost;
use super::plan::{ClipPlan, FilePlan, MatrixBy};

/// Bytes of a gigabyte.
const GIGABYTE: f64 = 1e9;
/// Seconds of an hour.
const HOUR_S: f64 = 3600.0;

/// The plan in the answer.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Summary {
    clips: usize,
    encode: usize,
    copy: usize,
    /// Clips that the flock has, and which are replaced.
    replace: usize,
    /// Sheep that these clips show or lead to.
    sheep: usize,
    /// Frames of all clips in the flock, as far as the files tell.
    frames: u64,
    rates: Vec<RateGroup>,
    matrices: Vec<MatrixGroup>,
    #[serde(flatten)]
    cost: Option<CostAnswer>,
}

/// The cost of all of it, with a dry run.
#[derive(Clone, Copy, Debug, Serialize)]
struct CostAnswer {
    cpu_hours: f64,
    hours: f64,
    gigabytes: f64,
    #[serde(skip)]
    threads: NonZeroUsize,
}

/// Clips of one rate.
#[derive(Clone, Debug, Serialize)]
struct RateGroup {
    /// Frames per second by their files.
    fps: Option<String>,
    clips: usize,
    /// Frames in the flock for each of theirs; 1: none is repeated or left out.
    frames_for_each: f64,
    /// How many times as fast they look as their files tell.
    speed: Option<f64>,
}

/// Clips whose colours are read by one matrix for one reason.
#[derive(Clone, Debug, Serialize)]
struct MatrixGroup {
    matrix: &'static str,
    by: MatrixBy,
    clips: usize,
}

impl Summary {
    /// The summary of `plans` for a flock of `fps` frames a second.
    pub(super) fn of(plans: &[ClipPlan], fps: Rate) -> Self {
        let files = || plans.iter().map(ClipPlan::first);
        let sheep: BTreeSet<&SheepId> = plans.iter().flat_map(|plan| plan.role.sheep()).collect();
        let mut rates: BTreeMap<(Option<(u32, u32)>, bool), RateGroup> = BTreeMap::new();
        let mut matrices: BTreeMap<(&str, MatrixBy), usize> = BTreeMap::new();
        for file in files() {
            let key = (file.about.fps.map(|fps| (fps.num(), fps.den())), file.pace.is_some());
            rates.entry(key).or_insert_with(|| RateGroup::of(file, fps)).clips += 1;
            if file.encode.is_some() {
                *matrices.entry(file.colours).or_default() += 1;
            }
        }
        let encode = files().filter(|file| file.encode.is_some()).count();
        Self {
            clips: plans.len(),
            encode,
            copy: plans.len() - encode,
            replace: plans.iter().filter(|plan| plan.replaces).count(),
            sheep: sheep.len(),
            frames: files().filter_map(|file| file.frames(fps)).sum(),
            rates: rates.into_values().collect(),
            matrices: matrices.into_iter().map(|((matrix, by), clips)| MatrixGroup { matrix, by, clips }).collect(),
            cost: None,
        }
    }

    /// The same, with what it costs on `threads` threads.
    pub(super) fn with_cost(self, cost: Cost, threads: NonZeroUsize) -> Self {
        let at_once = threads.get().min(self.encode).max(1);
        let cpu_hours = cost.cpu_seconds / HOUR_S;
        let hours = cpu_hours / at_once as f64;
        Self { cost: Some(CostAnswer { cpu_hours, hours, gigabytes: cost.bytes / GIGABYTE, threads }), ..self }
    }

    /// Notes on stderr what will be done.
    pub(super) fn note(&self, fps: Rate) {
        if self.clips == 0 {
            return;
        }
        let replaced = if self.replace > 0 { format!(", {} to replace", self.replace) } else { String::new() };
        print::note(&format!(
            "plan: {} of {} sheep: {} to encode, {} to copy{replaced}",
            print::count(self.clips, "clip"),
            self.sheep,
            self.encode,
            self.copy
        ));
        for group in &self.rates {
            print::note(&format!("plan: {}", group.words(fps)));
        }
        for group in self.matrices.iter().filter(|group| group.by != MatrixBy::File) {
            print::note(&format!("plan: {}", group.words()));
        }
    }

    /// What it costs, as one line.
    pub(super) fn cost_line(&self) -> Option<String> {
        let CostAnswer { cpu_hours, hours, gigabytes, threads } = self.cost?;
        Some(format!(
            "total {} of {} sheep, {} frames, {cpu_hours:.3} CPU hours, {hours:.3} hours with {threads} threads, \
             {gigabytes:.3} GB",
            print::count(self.clips, "clip"),
            self.sheep,
            self.frames
        ))
    }
}

impl RateGroup {
    /// The group of `file`, without clips.
    fn of(file: &FilePlan, fps: Rate) -> Self {
        let told = file.about.fps.map(|fps| fps.to_string());
        Self { fps: told, clips: 0, frames_for_each: file.frames_for_each(fps), speed: file.speed(fps) }
    }

    fn words(&self, fps: Rate) -> String {
        let clips = print::count(self.clips, "clip");
        let told =
            self.fps.as_ref().map_or("that tell no rate".to_owned(), |fps| format!("of {fps} frames per second"));
        let is_resampled = (self.frames_for_each - 1.0).abs() > f64::EPSILON;
        let frames = if is_resampled {
            format!("resampled to the flock's {fps}, {:.3} frames for each", self.frames_for_each)
        } else {
            "frame for frame".to_owned()
        };
        let pace = match self.speed {
            Some(speed) if (speed - 1.0).abs() > f64::EPSILON => {
                let remedy = if is_resampled { "" } else { "; --fps as-told keeps their pace" };
                let word = if speed > 1.0 { "faster" } else { "slower" };
                format!(", {word} at the flock's {fps}: {speed:.3} times as fast as told{remedy}")
            }
            Some(_) => ", at their pace".to_owned(),
            None => String::new(),
        };
        format!("{clips} {told}: {frames}{pace}")
    }
}

impl MatrixGroup {
    fn words(&self) -> String {
        let clips = print::count(self.clips, "clip");
        let matrix = self.matrix.replace("bt", "BT.");
        match self.by {
            MatrixBy::File => format!("colours of {clips} are read by {matrix}, as the files tell"),
            MatrixBy::Option => format!("colours of {clips} are read by {matrix}, as --matrix tells"),
            MatrixBy::Origin => format!(
                "colours of {clips} without a tag are read by {matrix}, as Electric Sheep made them; --matrix overrides"
            ),
            MatrixBy::Size => {
                format!("colours of {clips} without a tag are read by {matrix}, by their size; --matrix overrides")
            }
        }
    }
}
