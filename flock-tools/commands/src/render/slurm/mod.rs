//! `dreams render --on slurm`: the frames of a flock, rendered by a Slurm cluster that shares its folder.
//!
//! Owns the order of things: the plan is written, its tasks are sent as an array, their frames are verified as they come, a
//! task that ended early is sent again, and a clip whose frames are complete is encoded here. Nothing of it is in this
//! process alone: one that was killed is replaced by the same command, which follows the tasks that are there.
//! `plan_file.rs` has the plan, `task.rs` what becomes of a task, `cluster.rs` Slurm's commands, `follow.rs` the loop.
//!
//! Start at [`Run::follow`].

mod cluster;
mod follow;
pub(super) mod plan_file;
mod task;

use std::env;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use flock::ClipHash;
use operations::program::{Exit, Fatal, print};
use operations::render::clip_job::{Claim, ClipJob};
use operations::render::make::{MakeError, Outcome, RunResult, make_fatal};
use operations::render::plan::{ClipPlan, Look};
use operations::render::selection::Selection;
use operations::render::shard::{MOST_PARTS, Part, Shard};
use video::Encoder;

use cluster::{Batch, Cluster, ClusterError};
use follow::Follower;
use plan_file::PlanFile;
use task::Task;

/// The folder of plans, locks and the output of tasks, in the flock's folder.
const FOLDER: &str = ".render/slurm";

/// The output of a task, in Slurm's words.
const LOG: &str = ".render/slurm/%A_%a.log";

/// The most tasks of an array as Slurm comes: its indices are below 1001.
const MOST_TASKS: u32 = 1000;

/// Memory of a task besides that of its frames, in bytes.
const BYTES_OF_A_TASK: u64 = 200 << 20;

/// The options for the cluster.
#[derive(Clone, Debug, Default, PartialEq, Eq, clap::Args)]
pub(super) struct SlurmArgs {
    /// With --on slurm: the partition
    #[arg(long, value_name = "NAME")]
    partition: Option<String>,
    /// With --on slurm: the time limit of a task, as sbatch takes it; one that reaches it is sent again
    #[arg(long, value_name = "LIMIT")]
    time: Option<String>,
    /// With --on slurm: the most tasks, each with its piece of the frames
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_PARTS)))]
    tasks: Option<u32>,
    /// With --on slurm: another word for sbatch, such as --sbatch=--account=art; may be given again
    #[arg(long, value_name = "WORD", allow_hyphen_values = true)]
    sbatch: Vec<String>,
}

/// Why a cluster does not render.
#[derive(Debug, thiserror::Error)]
enum SlurmError {
    #[error("another run with --on slurm works on the flock in `{folder}`")]
    Busy { folder: PathBuf },
    #[error("the cluster does not take the work")]
    Cluster { source: ClusterError },
    #[error("task {index} ended {tries} times without a new frame; the end of `{log}`: {said}")]
    GivenUp { index: u32, tries: u32, log: PathBuf, said: String },
}

/// A rendering by a cluster.
pub(super) struct Run<'a> {
    /// The flock's folder.
    pub(super) folder: &'a Path,
    pub(super) selection: &'a Selection,
    pub(super) look: &'a Look,
    /// The words of a command line that give this look.
    pub(super) words: Vec<String>,
    /// Cores of a task.
    pub(super) threads: NonZeroUsize,
    /// Whether frames are kept when their clip is finished.
    pub(super) keep_frames: bool,
    /// Once it is set, this run ends; the tasks go on.
    pub(super) stop: Arc<AtomicBool>,
    /// Called for each clip that is in its place.
    pub(super) finished: &'a (dyn Fn(&ClipPlan, ClipHash) + Sync),
}

/// What is there before a plan is made.
struct Survey {
    /// What is known of each clip.
    outcomes: Vec<Outcome>,
    /// The frames of each clip that are left.
    left: Vec<Vec<u32>>,
}

impl Run<'_> {
    /// Has the cluster render all frames that are left, and encodes the clips. Returns when nothing is left, or the run is
    /// stopped.
    /// Errors: [`Fatal`], if the cluster refuses, or a task ends again and again without a frame. Frames and clips stay.
    pub(super) fn follow(&self, args: &SlurmArgs) -> Result<RunResult, Fatal> {
        let clips = &self.selection.clips;
        let _lock = self.lock()?;
        if let Some(clip) = clips.first() {
            let checked = Encoder::check(&clip.path.inside(self.folder), &self.look.form, clip.quality);
            checked.map_err(|error| make_fatal(MakeError::Encode(error)))?;
        }
        let (mut frames, mut before) = (0, vec![Outcome::Unfinished; clips.len()]);
        loop {
            let survey = self.survey().map_err(make_fatal)?;
            let adopted = self.adopted()?;
            let is_adopted = adopted.is_some();
            let (plan, tasks) = match adopted {
                Some(plan) => {
                    let tasks = adopted_tasks(&plan, clips, &survey);
                    (Some(plan), tasks)
                }
                None => self.sent(&survey, args)?,
            };
            let cluster = Cluster { name: plan.as_ref().map(|plan| plan.name().to_owned()).unwrap_or_default() };
            let mut follower = Follower::new(self, args, plan.map(|plan| (plan, cluster)), tasks, survey);
            // What one round made, the next finds there.
            let kept = |(before, now)| if matches!(before, Outcome::Made(_)) { before } else { now };
            let outcomes: Vec<Outcome> = before.into_iter().zip(follower.run()?).map(kept).collect();
            frames += follower.frames();
            if self.stop.load(Ordering::Relaxed) || !is_adopted {
                return Ok(RunResult { outcomes, frames });
            }
            before = outcomes;
        }
    }

    /// Keeps other runs of this kind away until it is dropped.
    fn lock(&self) -> Result<File, Fatal> {
        let folder = self.folder.join(FOLDER);
        fs::create_dir_all(&folder).map_err(|source| Fatal::write(&folder, source))?;
        let path = folder.join("lock");
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(&path);
        let file = file.map_err(|source| Fatal::write(&path, source))?;
        match file.try_lock() {
            Ok(()) => Ok(file),
            Err(TryLockError::WouldBlock) => {
                Err(Fatal::new(Exit::No, SlurmError::Busy { folder: self.folder.to_owned() }))
            }
            Err(TryLockError::Error(source)) => Err(Fatal::write(&path, source)),
        }
    }

    /// Looks at all clips, and verifies the frames that are there.
    fn survey(&self) -> Result<Survey, MakeError> {
        let all = Part::Shard(Shard::ALL);
        let mut survey = Survey { outcomes: Vec::new(), left: Vec::new() };
        for (number, clip) in self.selection.clips.iter().enumerate() {
            let (outcome, left) = match ClipJob::claim(clip, number, self.look, self.folder, &all)? {
                Claim::Busy => (Outcome::Busy, Vec::new()),
                Claim::Job(_, missing) => (Outcome::Unfinished, missing),
                Claim::UpToDate(hash) => (Outcome::UpToDate(hash), Vec::new()),
            };
            survey.outcomes.push(outcome);
            survey.left.push(left);
        }
        Ok(survey)
    }

    /// The plan of an earlier run whose tasks are still in the cluster. Plans that are over are deleted, and the tasks of
    /// one for something else are ended.
    fn adopted(&self) -> Result<Option<PlanFile>, Fatal> {
        let folder = self.folder.join(FOLDER);
        let read = |source| Fatal::read(&folder, source);
        let names = fs::read_dir(&folder).and_then(Iterator::collect::<io::Result<Vec<_>>>).map_err(read)?;
        let mut adopted = None;
        for path in names.into_iter().map(|entry| entry.path()) {
            if path.extension().is_none_or(|ending| ending != "json") {
                continue;
            }
            // A crash may have left anything.
            if let Ok(plan) = PlanFile::read(&path) {
                let cluster = Cluster { name: plan.name().to_owned() };
                let tasks = cluster.live().map_err(cluster_fatal)?.len();
                if tasks > 0 && plan.is_of(&self.selection.clips) {
                    print::note(&format!("following {} of an earlier run", print::count(tasks, "task")));
                    adopted = Some(plan);
                    continue;
                }
                if tasks > 0 {
                    print::note(&format!("ending {} of an earlier run, for other clips", print::count(tasks, "task")));
                    cluster.cancel().map_err(cluster_fatal)?;
                }
            }
            fs::remove_file(&path).map_err(|source| Fatal::write(&path, source))?;
        }
        Ok(adopted)
    }

    /// Plans what `survey` has left and sends it. There is no plan where nothing is left.
    fn sent(&self, survey: &Survey, args: &SlurmArgs) -> Result<(Option<PlanFile>, Vec<Task>), Fatal> {
        let clips = &self.selection.clips;
        let frames: usize = survey.left.iter().map(Vec::len).sum();
        let Some(each) = u32::try_from(frames.div_ceil(self.threads.get())).ok().filter(|tasks| *tasks > 0) else {
            return Ok((None, Vec::new()));
        };
        let name = format!("dreams-{:08x}", rand::random::<u32>());
        let left = clips.iter().zip(&survey.left).filter(|(_, left)| !left.is_empty());
        let tasks = each.min(args.tasks.unwrap_or(MOST_TASKS));
        let plan = PlanFile::new(name, tasks, left.map(|(clip, left)| (clip, &left[..])));
        let path = self.folder.join(FOLDER).join(plan.name()).with_extension("json");
        plan.write(&path)?;
        let mut tasks: Vec<Task> =
            (1..).zip(plan.frames(clips)).map(|(index, frames)| Task::new(index, frames)).collect();
        let indices: Vec<u32> = tasks.iter().map(|task| task.index).collect();
        let job = self.submit(&plan, &indices, args).map_err(|error| {
            let _ = fs::remove_file(&path);
            cluster_fatal(error)
        })?;
        for task in &mut tasks {
            task.job = Some(job.clone());
        }
        print::note(&format!("job {job}: {} for {frames} frames", print::count(tasks.len(), "task")));
        Ok((Some(plan), tasks))
    }

    /// Sends the tasks `indices` of `plan`. Returns the job's number.
    fn submit(&self, plan: &PlanFile, indices: &[u32], args: &SlurmArgs) -> Result<String, ClusterError> {
        let start = |source| ClusterError::Start { program: "dreams", source };
        let (program, folder) = (env::current_exe().map_err(start)?, fs::canonicalize(self.folder).map_err(start)?);
        let name = plan.name();
        let mut words = vec![
            "render".to_owned(),
            ".".to_owned(),
            format!("--plan={FOLDER}/{name}.json"),
            format!("--shard=\"$SLURM_ARRAY_TASK_ID/{}\"", plan.tasks()),
            format!("--threads={}", self.threads),
        ];
        words.extend(self.words.iter().cloned());
        let bytes = self.selection.bytes * self.threads.get() as u64 + BYTES_OF_A_TASK;
        let batch = Batch { folder: &folder, log: LOG, program: &program, words: &words, threads: self.threads, bytes };
        Cluster { name: name.to_owned() }.submit(&batch, indices, args)
    }
}

/// The tasks of a plan of an earlier run, with what is left of their frames.
fn adopted_tasks(plan: &PlanFile, clips: &[ClipPlan], survey: &Survey) -> Vec<Task> {
    let is_left = |(clip, frame): &(usize, u32)| survey.left[*clip].binary_search(frame).is_ok();
    let tasks = (1..).zip(plan.frames(clips));
    tasks.map(|(index, frames)| Task::new(index, frames.into_iter().filter(is_left).collect())).collect()
}

fn cluster_fatal(source: ClusterError) -> Fatal {
    let hint = "the same command continues where this one stopped; `sinfo` tells what the cluster has";
    Fatal::new(Exit::Unreadable, SlurmError::Cluster { source }).hint(hint)
}
