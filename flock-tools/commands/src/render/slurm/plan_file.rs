//! The plan that the tasks of a cluster work by.
//!
//! Owns the file: which frames of which clips each task renders, and by which recipe, so that a task that runs later, or on
//! another machine, renders what was sent or nothing. Never runs a task.
//!
//! Start at [`PlanFile::new`]; [`PlanFile::part`] is what a task renders.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use flock::ClipPath;
use operations::program::{Exit, Fatal};
use operations::render::plan::ClipPlan;
use operations::render::shard::{MOST_PARTS, Part, Shard};

/// The version of the file's form.
const FORMAT: u32 = 1;

/// A plan.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PlanFile {
    format: u32,
    /// The name of its jobs in the cluster, and of its file.
    name: String,
    /// The number of tasks.
    tasks: u32,
    clips: Vec<PlannedClip>,
}

/// Frames of a clip.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct PlannedClip {
    clip: String,
    /// The hash of all that its pictures depend on.
    recipe: String,
    frames: Vec<Range<u32>>,
}

/// Why a task does not work by a plan. It renders nothing.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PlanError {
    #[error("the plan has recipe {planned} for `{clip}`, this flock and program have {found}")]
    Changed { clip: String, planned: String, found: String },
    #[error("the plan has `{clip}`, which cannot be rendered here")]
    Clip { clip: String },
    #[error("`{path}` is no plan")]
    Form { path: PathBuf, source: serde_json::Error },
    #[error("plan `{path}` has format {found}, this program reads {FORMAT}")]
    Format { path: PathBuf, found: u32 },
    #[error("plan `{path}` has frames {start} to {end} of `{clip}` (expected an end after the start)")]
    Frames { path: PathBuf, clip: String, start: u32, end: u32 },
    #[error("plan `{path}` has {found} tasks (expected 1 to {MOST_PARTS})")]
    Tasks { path: PathBuf, found: u32 },
    #[error("the plan has {tasks} tasks, and not task {index} of {of}")]
    Task { tasks: u32, index: u32, of: u32 },
}

impl PlanFile {
    /// The plan `name` of so many tasks, for the frames of each of `clips` that are left.
    pub(super) fn new<'a>(
        name: String,
        tasks: u32,
        clips: impl IntoIterator<Item = (&'a ClipPlan, &'a [u32])>,
    ) -> Self {
        let clip = |(clip, frames): (&ClipPlan, &[u32])| PlannedClip {
            clip: clip.path.as_str().to_owned(),
            recipe: clip.picture_recipe.to_string(),
            frames: ranges(frames),
        };
        Self { format: FORMAT, name, tasks, clips: clips.into_iter().map(clip).collect() }
    }

    /// The plan at `path`.
    pub(crate) fn read(path: &Path) -> Result<Self, Fatal> {
        let text = fs::read_to_string(path).map_err(|source| Fatal::read(path, source))?;
        let malformed = |error| Fatal::new(Exit::Malformed, error);
        let plan: Self = serde_json::from_str(&text)
            .map_err(|source| malformed(PlanError::Form { path: path.to_owned(), source }))?;
        if plan.format != FORMAT {
            return Err(malformed(PlanError::Format { path: path.to_owned(), found: plan.format }));
        }
        if !(1..=MOST_PARTS).contains(&plan.tasks) {
            return Err(malformed(PlanError::Tasks { path: path.to_owned(), found: plan.tasks }));
        }
        for PlannedClip { clip, frames, .. } in &plan.clips {
            if let Some(Range { start, end }) = frames.iter().find(|range| range.is_empty()) {
                let (path, clip) = (path.to_owned(), clip.clone());
                return Err(malformed(PlanError::Frames { path, clip, start: *start, end: *end }));
            }
        }
        Ok(plan)
    }

    /// Writes it to `path`, whole or not at all.
    pub(super) fn write(&self, path: &Path) -> Result<(), Fatal> {
        let text = serde_json::to_string(self).map_err(|error| Fatal::new(Exit::Unreadable, error))?;
        durable::write(path, text.as_bytes()).map_err(|source| Fatal::write(path, source))
    }

    /// The name of its jobs in the cluster.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// The number of tasks.
    pub(super) fn tasks(&self) -> u32 {
        self.tasks
    }

    /// The clips that task `shard` renders frames of.
    pub(crate) fn paths(&self, shard: Shard) -> HashSet<ClipPath> {
        let clips = self.of_task(shard.numbers().0).into_iter();
        clips.filter_map(|(clip, _)| ClipPath::new(&self.clips[clip].clip).ok()).collect()
    }

    /// What task `shard` renders, where `clips` are as they are now.
    /// Errors: [`PlanError`], if anything is not as it was when the plan was made.
    pub(crate) fn part(&self, shard: Shard, clips: &[ClipPlan]) -> Result<Part, Fatal> {
        let (index, of) = shard.numbers();
        let malformed = |error| Fatal::new(Exit::Malformed, error);
        if of != self.tasks {
            return Err(malformed(PlanError::Task { tasks: self.tasks, index, of }));
        }
        let mut frames: HashMap<ClipPath, Vec<Range<u32>>> = HashMap::new();
        for (number, range) in self.of_task(index) {
            let clip = self.clip(number, clips).map_err(malformed)?;
            frames.entry(clip.path.clone()).or_default().push(range);
        }
        Ok(Part::Listed(frames))
    }

    /// Whether some of its clips are among `clips`, and all of these have the same recipes.
    pub(super) fn is_of(&self, clips: &[ClipPlan]) -> bool {
        let found: Vec<_> = (0..self.clips.len()).map(|number| self.clip(number, clips)).collect();
        let is_changed = |found: &Result<_, PlanError>| matches!(found, Err(PlanError::Changed { .. }));
        found.iter().any(Result::is_ok) && !found.iter().any(is_changed)
    }

    /// The frames of every task, by their clip's number in `clips`; without those of other clips.
    pub(super) fn frames(&self, clips: &[ClipPlan]) -> Vec<Vec<(usize, u32)>> {
        let numbers: HashMap<&str, usize> =
            clips.iter().enumerate().map(|(number, clip)| (clip.path.as_str(), number)).collect();
        let number = |planned: usize| numbers.get(&*self.clips[planned].clip).copied();
        let of_task = |task| {
            let parts = self.of_task(task).into_iter().filter_map(|(planned, range)| Some((number(planned)?, range)));
            parts.flat_map(|(clip, range)| range.map(move |frame| (clip, frame))).collect()
        };
        (1..=self.tasks).map(of_task).collect()
    }

    /// Number `number` of the plan's clips, if it is among `clips` and has the same recipe.
    fn clip<'a>(&self, number: usize, clips: &'a [ClipPlan]) -> Result<&'a ClipPlan, PlanError> {
        let PlannedClip { clip, recipe, .. } = self.clips[number].clone();
        let Some(found) = clips.iter().find(|found| found.path.as_str() == clip) else {
            return Err(PlanError::Clip { clip });
        };
        let (planned, now) = (recipe, found.picture_recipe.to_string());
        if planned == now { Ok(found) } else { Err(PlanError::Changed { clip, planned, found: now }) }
    }

    /// The frames of task `task`, from 1, by the numbers of their clips in the plan: a piece of all in their order, so that
    /// clips are complete one after the other.
    fn of_task(&self, task: u32) -> Vec<(usize, Range<u32>)> {
        let all =
            || self.clips.iter().enumerate().flat_map(|(clip, it)| it.frames.iter().map(move |range| (clip, range)));
        let total: u64 = all().map(|(_, range)| u64::from(range.end - range.start)).sum();
        let border = |task: u32| total * u64::from(task) / u64::from(self.tasks);
        let (from, to) = (border(task.saturating_sub(1)), border(task));
        let (mut pieces, mut passed) = (Vec::new(), 0);
        for (clip, range) in all() {
            let at =
                |place: u64| range.start + place.saturating_sub(passed).min(u64::from(range.end - range.start)) as u32;
            let piece = at(from)..at(to);
            if !piece.is_empty() {
                pieces.push((clip, piece));
            }
            passed += u64::from(range.end - range.start);
        }
        pieces
    }
}

/// Ascending numbers as ranges.
pub(super) fn ranges(numbers: &[u32]) -> Vec<Range<u32>> {
    let mut ranges: Vec<Range<u32>> = Vec::new();
    for &number in numbers {
        match ranges.last_mut() {
            Some(last) if last.end == number => last.end += 1,
            _ => ranges.push(number..number + 1),
        }
    }
    ranges
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(tasks: u32) -> PlanFile {
        let clip = |name: &str, frames: &[u32]| PlannedClip {
            clip: name.to_owned(),
            recipe: "b3:".to_owned(),
            frames: ranges(frames),
        };
        let clips = vec![clip("a", &[0, 1, 2, 5, 6]), clip("b", &[]), clip("c", &[3, 4, 5, 6, 7, 8, 9])];
        PlanFile { format: FORMAT, name: "dreams-1".to_owned(), tasks, clips }
    }

    #[test]
    fn the_tasks_of_a_plan_have_every_frame_once_and_in_order() {
        for tasks in [1, 2, 5, 12, 40] {
            let plan = plan(tasks);
            let pieces = (1..=tasks).flat_map(|task| plan.of_task(task));
            let frames: Vec<_> = pieces.flat_map(|(clip, range)| range.map(move |frame| (clip, frame))).collect();
            let all = [0, 1, 2, 5, 6].map(|frame| (0, frame)).into_iter();
            let all: Vec<_> = all.chain((3..10).map(|frame| (2, frame))).collect();
            assert_eq!(frames, all, "{tasks} tasks");
        }
    }

    #[test]
    fn a_plan_is_read_as_it_was_written_and_nothing_else_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plan.json");
        plan(3).write(&path).unwrap();
        assert_eq!(PlanFile::read(&path).unwrap(), plan(3));
        let text = fs::read_to_string(&path).unwrap();
        let other = |from: &str, to: &str| {
            assert!(text.contains(from), "{text}");
            text.replace(from, to)
        };
        for bad in [
            String::new(),
            "{}".to_owned(),
            text[..text.len() / 2].to_owned(),
            other("\"format\":1", "\"format\":2"),
            other("\"tasks\":3", "\"tasks\":0"),
            other("\"tasks\":3", "\"tasks\":4000000000"),
            other("\"start\":5,\"end\":7", "\"start\":7,\"end\":5"),
        ] {
            fs::write(&path, &bad).unwrap();
            assert!(PlanFile::read(&path).is_err(), "{bad}");
        }
    }
}
