//! A job in the queue, with its work and its pace.
//!
//! Owns the figures of a job's pace: steps per second of the time that it ran. Never locks anything.
//!
//! Start at [`Entry`].

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use serde_json::Value;

use super::{Job, JobId, NewJob, Priority, State, Work};

/// The most lines of a log that are kept.
const MOST_LINES: usize = 200;
/// The least time between two messages of one job's progress.
const TOLD_EVERY: Duration = Duration::from_millis(250);

/// A job with what the queue needs of it. Times are since the program's start.
pub(super) struct Entry {
    pub(super) job: Job,
    pub(super) priority: Priority,
    /// What a restart needs.
    pub(super) spec: Option<Value>,
    /// Taken by the thread that runs it.
    pub(super) work: Option<Work>,
    cancel: Arc<AtomicBool>,
    /// Since when it runs, less its pauses.
    since: Duration,
    told: Duration,
}

impl Entry {
    pub(super) fn new(id: JobId, new: NewJob, work: Work) -> Self {
        let NewJob { priority, kind, what, key, about, cost_s, spec } = new;
        let job = Job {
            id,
            kind,
            what,
            key,
            about,
            state: State::Queued,
            paused: false,
            can_pause: true,
            done: 0,
            of: 0,
            per_second: None,
            left_s: None,
            cost_s,
            log: Vec::new(),
            error: None,
            result: None,
        };
        let (cancel, zero) = (Arc::new(AtomicBool::new(false)), Duration::ZERO);
        Self { job, priority, spec, work: Some(work), cancel, since: zero, told: zero }
    }

    /// It is begun: the flag that cancels it.
    pub(super) fn begin(&mut self, now: Duration) -> Arc<AtomicBool> {
        (self.job.state, self.since, self.told) = (State::Running, now, now);
        Arc::clone(&self.cancel)
    }

    /// Has it end soon.
    pub(super) fn cancel(&self) {
        self.cancel.store(true, Ordering::Relaxed);
    }

    pub(super) fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    /// `done` of `of` steps are done.
    pub(super) fn set(&mut self, done: u64, of: u64, now: Duration) {
        let job = &mut self.job;
        (job.done, job.of, job.state) = (done.min(of.max(done)), of, State::Running);
        let ran = now.saturating_sub(self.since).as_secs_f64();
        job.per_second = (done > 0 && ran > 0.0).then(|| done as f64 / ran);
        job.left_s = job.per_second.map(|pace| of.saturating_sub(done) as f64 / pace);
    }

    /// Holds it if it can be held, or lets it go on.
    pub(super) fn pause(&mut self, is_paused: bool) {
        self.job.paused = is_paused && self.job.can_pause;
    }

    /// Adds a line to its log, without what a terminal would take for a command. It goes on, if it waited.
    pub(super) fn log(&mut self, line: &str) {
        let line = line.chars().filter(|letter| !letter.is_control()).collect();
        if self.job.state == State::Waiting {
            self.job.state = State::Running;
        }
        let log = &mut self.job.log;
        log.push(line);
        let surplus = log.len().saturating_sub(MOST_LINES);
        log.drain(..surplus);
    }

    /// It stood still for `time`, which does not count.
    pub(super) fn stood_still(&mut self, time: Duration) {
        self.since += time;
    }

    /// Whether its progress may be told now.
    pub(super) fn may_tell(&mut self, now: Duration) -> bool {
        let may = now >= self.told + TOLD_EVERY;
        if may {
            self.told = now;
        }
        may
    }

    /// It has ended with `result`.
    pub(super) fn end(&mut self, result: Result<Value, String>) {
        let job = &mut self.job;
        (job.left_s, self.work) = (None, None);
        (job.paused, job.can_pause) = (false, false);
        match result {
            // What was finished all the same is there.
            Ok(result) => (job.state, job.result) = (State::Done, Some(result)),
            Err(_) if self.cancel.load(Ordering::Relaxed) => job.state = State::Cancelled,
            Err(error) => (job.state, job.error) = (State::Failed, Some(error)),
        }
    }
}
