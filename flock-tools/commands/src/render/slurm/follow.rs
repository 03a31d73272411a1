//! The loop that follows the tasks of a plan.
//!
//! Owns what is known of them, the progress, and when a clip is encoded: as soon as its frames are complete, beside the
//! loop, on all cores of this machine. Never renders a frame that the cluster renders.
//!
//! Start at [`Follower::run`].

use std::collections::{HashMap, HashSet};
use std::fs;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::{self, ScopedJoinHandle};
use std::time::Duration;

use operations::program::now::{Stopwatch, pause};
use operations::program::progress::FrameProgress;
use operations::program::{Exit, Fatal, print};
use operations::render::clip_job::{frames_of, is_taken};
use operations::render::machine;
use operations::render::make::{MakeError, Outcome, RunOptions, make, make_fatal};
use operations::render::shard::Part;

use super::cluster::{Cluster, ClusterError, LiveTask, log_of};
use super::plan_file::PlanFile;
use super::task::{MOST_TRIES, Next, Task};
use super::{FOLDER, LOG, Run, SlurmArgs, SlurmError, Survey, cluster_fatal};

/// How long the cluster may not answer, while its controller is started again.
const LONGEST_SILENCE: Duration = Duration::from_mins(10);

/// The shortest and the longest time between two looks, in seconds.
const BETWEEN_LOOKS_S: (f64, f64) = (0.5, 20.0);

/// How often a clip whose frames are complete may be in the hands of another process, with no task left.
const MOST_BUSY: u32 = 3;

/// The last lines of a task's output that are told.
const LINES_OF_LOG: usize = 6;

/// What encoding came to, by the numbers of clips.
type Encoded = Result<Vec<(usize, Outcome)>, MakeError>;

/// Follows the tasks of a plan.
pub(super) struct Follower<'r, 'a> {
    run: &'r Run<'a>,
    args: &'r SlurmArgs,
    /// The plan and its tasks in the cluster; `None` where only the encoding is left.
    sent: Option<(PlanFile, Cluster)>,
    tasks: Vec<Task>,
    outcomes: Vec<Outcome>,
    /// The number of frames of each clip that are left.
    left: Vec<usize>,
    /// How often each clip was found in the hands of another process.
    busy: Vec<u32>,
    progress: FrameProgress,
    frames: u64,
    /// The tasks in the cluster at the last look.
    live: usize,
    /// Since when the cluster does not answer.
    silence: Option<Stopwatch>,
    /// Why tasks wait, as far as it was told.
    told: HashSet<String>,
}

impl<'r, 'a> Follower<'r, 'a> {
    pub(super) fn new(
        run: &'r Run<'a>,
        args: &'r SlurmArgs,
        sent: Option<(PlanFile, Cluster)>,
        tasks: Vec<Task>,
        survey: Survey,
    ) -> Self {
        let frames = tasks.iter().map(|task| task.left.len() as u64).sum();
        Self {
            run,
            args,
            sent,
            tasks,
            busy: vec![0; survey.left.len()],
            left: survey.left.iter().map(Vec::len).collect(),
            outcomes: survey.outcomes,
            progress: FrameProgress::new(frames),
            frames: 0,
            live: 0,
            silence: None,
            told: HashSet::new(),
        }
    }

    /// The number of frames that were finished meanwhile.
    pub(super) fn frames(&self) -> u64 {
        self.frames
    }

    /// Follows the tasks until their frames are finished and encoded, or the run is stopped.
    /// Errors: [`Fatal`], if a task ends again and again without a frame, or the cluster does not answer for ten minutes.
    pub(super) fn run(&mut self) -> Result<Vec<Outcome>, Fatal> {
        let run = self.run;
        let watch = Stopwatch::start();
        let followed = thread::scope(|scope| {
            let mut encoding: Option<ScopedJoinHandle<'_, Encoded>> = None;
            while !run.stop.load(Ordering::Relaxed) {
                let looked = self.look().and_then(|()| {
                    let ended = encoding.take_if(|thread| thread.is_finished());
                    ended.map_or(Ok(()), |thread| self.take(joined(thread)))
                });
                if looked.is_err() {
                    // The encoding ends at once.
                    run.stop.store(true, Ordering::Relaxed);
                    return looked;
                }
                if encoding.is_none() {
                    let complete = self.complete();
                    if complete.is_empty() && self.tasks.iter().all(|task| task.left.is_empty()) {
                        return Ok(());
                    }
                    if !complete.is_empty() {
                        encoding = Some(scope.spawn(move || encode(run, &complete)));
                    }
                }
                let (least, most) = BETWEEN_LOOKS_S;
                let wait = Duration::from_secs_f64((watch.wall().as_secs_f64() / 30.0).clamp(least, most));
                pause(wait, &run.stop);
            }
            encoding.map_or(Ok(()), |thread| self.take(joined(thread)))
        });
        self.progress.end();
        followed?;
        self.end();
        Ok(self.outcomes.clone())
    }

    /// Tells what goes on after an interruption, or deletes the plan.
    fn end(&self) {
        let Some((plan, cluster)) = &self.sent else { return };
        if self.run.stop.load(Ordering::Relaxed) {
            let tasks = print::count(self.live, "task");
            print::note(&format!(
                "interrupted; {tasks} in the cluster go on (`scancel --name={}` ends them), and the same command follows \
                 them",
                cluster.name
            ));
            return;
        }
        // What it leaves, the next run deletes.
        let _ = fs::remove_file(self.run.folder.join(FOLDER).join(plan.name()).with_extension("json"));
    }

    /// One look at the cluster and at the frames of its tasks; sends those again that ended early.
    fn look(&mut self) -> Result<(), Fatal> {
        let Some((_, cluster)) = &self.sent else { return Ok(()) };
        let live = match cluster.live() {
            Ok(live) => live,
            Err(error) => return self.unanswered(error),
        };
        self.silence = None;
        self.live = live.len();
        self.tell(&live);
        self.take_finished(&live);
        self.leave_to_others(&live);
        let again: Vec<usize> = (0..self.tasks.len()).filter(|at| self.next(*at, &live) == Next::SendAgain).collect();
        if let Some(at) = (0..self.tasks.len()).find(|at| self.next(*at, &live) == Next::GiveUp) {
            return Err(self.given_up(&self.tasks[at]));
        }
        if again.is_empty() { Ok(()) } else { self.send_again(&again) }
    }

    fn next(&self, at: usize, live: &HashMap<u32, LiveTask>) -> Next {
        let task = &self.tasks[at];
        task.next(live.contains_key(&task.index))
    }

    /// Takes the frames out of the tasks that are there and whole. A task that is not live has written all that it will.
    fn take_finished(&mut self, live: &HashMap<u32, LiveTask>) {
        let (run, ahead) = (self.run, 2 * self.run.threads.get());
        for task in self.tasks.iter_mut().filter(|task| !task.left.is_empty()) {
            let state = live.get(&task.index);
            if state.is_some_and(|task| task.state == "PENDING") {
                continue;
            }
            let store = |clip: usize| frames_of(&run.selection.clips[clip], run.look, run.folder);
            if state.is_none() {
                let clips: HashSet<usize> = task.left.iter().map(|(clip, _)| *clip).collect();
                for clip in clips {
                    store(clip).refresh();
                }
            }
            let is_there = |clip: usize, frame| store(clip).get(frame).is_ok_and(|picture| picture.is_some());
            let found = task.take_finished(state.map(|_| ahead), is_there);
            for (clip, _) in &found {
                self.left[*clip] -= 1;
            }
            self.frames += found.len() as u64;
            if !found.is_empty() {
                self.progress.add(found.len() as u64);
            }
        }
    }

    /// Takes the frames of clips out of tasks that ended which a process outside the cluster renders.
    fn leave_to_others(&mut self, live: &HashMap<u32, LiveTask>) {
        let clips = &self.run.selection.clips;
        for task in self.tasks.iter_mut().filter(|task| !live.contains_key(&task.index)) {
            let of: HashSet<usize> = task.left.iter().map(|(clip, _)| *clip).collect();
            for clip in of.into_iter().filter(|clip| is_taken(self.run.folder, &clips[*clip].path)) {
                self.outcomes[clip] = Outcome::Busy;
                let before = task.left.len();
                task.left.retain(|(left, _)| *left != clip);
                self.progress.skip((before - task.left.len()) as u64);
            }
        }
    }

    /// Tells how many tasks run, and once of each reason why one waits for a person.
    fn tell(&mut self, live: &HashMap<u32, LiveTask>) {
        let waiting: Vec<&LiveTask> = live.values().filter(|task| task.state == "PENDING").collect();
        let running = live.len() - waiting.len();
        let reason = waiting.first().map(|task| format!(" ({})", task.reason)).unwrap_or_default();
        self.progress.tell(&format!("{running} tasks run, {} wait{reason}", waiting.len()));
        for task in waiting {
            if task.reason.to_lowercase().contains("held") && self.told.insert(task.reason.clone()) {
                let note = format!("note: the cluster holds tasks back: {}", task.reason);
                self.progress.suspend(|| print::note(&note));
            }
        }
    }

    fn send_again(&mut self, again: &[usize]) -> Result<(), Fatal> {
        let Some((plan, _)) = &self.sent else { return Ok(()) };
        let indices: Vec<u32> = again.iter().map(|at| self.tasks[*at].index).collect();
        match self.run.submit(plan, &indices, self.args) {
            Err(error) => self.unanswered(error),
            Ok(job) => {
                let tasks = print::count(again.len(), "task");
                let note = format!("{tasks} ended before all frames were finished: sent again as job {job}");
                self.progress.suspend(|| print::note(&note));
                for at in again {
                    self.tasks[*at].sent(&job);
                }
                Ok(())
            }
        }
    }

    /// The cluster did not answer with what was asked for. It may come back.
    fn unanswered(&mut self, error: ClusterError) -> Result<(), Fatal> {
        let since = self.silence.get_or_insert_with(Stopwatch::start);
        if since.wall() < LONGEST_SILENCE { Ok(()) } else { Err(cluster_fatal(error)) }
    }

    /// Ends all tasks: one ends again and again without a frame.
    fn given_up(&self, task: &Task) -> Fatal {
        if let Some((_, cluster)) = &self.sent {
            // The error of the task is what counts.
            let _ = cluster.cancel();
        }
        let log = log_of(self.run.folder, LOG, task.job.as_deref().unwrap_or_default(), task.index);
        let text = fs::read(&log).map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default();
        let lines: Vec<&str> = text.lines().collect();
        let said = lines[lines.len().saturating_sub(LINES_OF_LOG)..].join("\n");
        let error = SlurmError::GivenUp { index: task.index, tries: MOST_TRIES, log, said };
        Fatal::new(Exit::Unreadable, error).hint("the frames that are finished stay; the same command continues")
    }

    /// The clips whose frames are complete and that are not encoded.
    fn complete(&self) -> Vec<usize> {
        let is_complete = |clip: &usize| self.left[*clip] == 0 && self.outcomes[*clip] == Outcome::Unfinished;
        (0..self.left.len()).filter(is_complete).collect()
    }

    /// Takes in what encoding came to. A clip that a task has not left yet is tried again.
    fn take(&mut self, encoded: Encoded) -> Result<(), Fatal> {
        for (clip, outcome) in encoded.map_err(make_fatal)? {
            if outcome == Outcome::Busy {
                self.busy[clip] += u32::from(self.live == 0);
                if self.busy[clip] < MOST_BUSY {
                    continue;
                }
            }
            self.outcomes[clip] = outcome;
        }
        Ok(())
    }
}

/// Encodes the clips of these numbers on all cores.
fn encode(run: &Run<'_>, numbers: &[usize]) -> Encoded {
    let options = RunOptions {
        threads: machine::cores().min(NonZeroUsize::new(numbers.len()).unwrap_or(NonZeroUsize::MIN)),
        keep_frames: run.keep_frames,
        stop: Arc::clone(&run.stop),
        part: Part::Whole,
        shows_progress: false,
    };
    let clips = numbers.iter().map(|number| &run.selection.clips[*number]);
    let made = make(clips, run.look, run.folder, &options, run.finished)?;
    Ok(numbers.iter().copied().zip(made.outcomes).collect())
}

fn joined(thread: ScopedJoinHandle<'_, Encoded>) -> Encoded {
    thread.join().expect("a panic while encoding is a bug")
}
