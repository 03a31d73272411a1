//! The queue and its threads.
//!
//! Owns which job is next, and when clips and paused jobs are held. Clips have threads of their own, so previews never wait
//! for one. All threads leave the processors to the page and to the browser that shows it; those of clips, to previews, too.
//!
//! Start at [`Queue::open`]; [`Inner::next`] is the order.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use rustix::process::{getpriority_process, setpriority_process};
use serde_json::Value;

use super::entry::Entry;
use super::kept::{Kept, KeptList};
use super::progress::Progress;
use super::{Job, JobId, NewJob, Priority, State, Work};
use crate::lock::locked;

/// The most jobs that are over and still listed.
const MOST_OVER: usize = 200;
/// How many threads are for what somebody looks at.
const PREVIEW_THREADS: usize = 2;
/// The least niceness of the threads of previews: without it, a page that is scrolled stands still now and then while
/// pictures are made (`make bench what=studio`).
pub(super) const PREVIEW_NICE: i32 = 10;
/// The least niceness of the threads of clips.
pub(super) const CLIP_NICE: i32 = 19;

/// How long work that is cancelled is waited for when the program ends.
const LAST_STEPS: Duration = Duration::from_secs(2);

/// The time since the program's start.
pub(crate) type Clock = fn() -> Duration;
/// Is told of every change of a job.
pub(crate) type Listener = Box<dyn Fn(&Job) + Send + Sync>;

/// What a queue is opened with.
pub(crate) struct Settings {
    /// How many clips are made at once; at least 1. What somebody looks at has threads of its own.
    pub(crate) threads: usize,
    /// Where the jobs are listed that a restart goes on with; `None` for a queue that forgets.
    pub(crate) kept: Option<PathBuf>,
    /// The time since the program's start.
    pub(crate) clock: Clock,
    /// Is told of every change of a job, outside all locks.
    pub(crate) listener: Listener,
}

/// Jobs, and the threads that run them. Dropping it cancels what runs and waits for it, for two seconds at most; jobs that
/// are kept stay in the list.
pub(crate) struct Queue {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
}

/// What the queue, its threads and all handles share.
pub(super) struct Shared {
    inner: Mutex<Inner>,
    changed: Condvar,
    clock: Clock,
    listener: Listener,
}

/// The jobs.
#[derive(Default)]
struct Inner {
    newest: JobId,
    entries: BTreeMap<JobId, Entry>,
    is_paused: bool,
    is_closing: bool,
    /// How many threads are at work.
    running: usize,
    list: Option<KeptList>,
    /// What an earlier run left, until it is added again or forgotten.
    left: Vec<Kept>,
}

impl std::fmt::Debug for Queue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Queue").field("threads", &self.threads.len()).finish_non_exhaustive()
    }
}

impl Queue {
    /// Starts the threads. What an earlier run left is in [`Queue::left`].
    /// Errors: If the system gives no threads.
    pub(crate) fn open(settings: Settings) -> std::io::Result<Self> {
        let Settings { threads, kept, clock, listener } = settings;
        let (list, left) = kept.map(|path| KeptList::open(&path)).unzip();
        let left: Vec<Kept> = left.unwrap_or_default();
        let newest = left.iter().map(|kept| kept.id).max().unwrap_or_default();
        let inner = Mutex::new(Inner { newest, list, left, ..Inner::default() });
        let shared = Arc::new(Shared { inner, changed: Condvar::new(), clock, listener });
        let mut queue = Self { shared, threads: Vec::new() };
        let previews = (0..PREVIEW_THREADS).map(|_| ("preview", false));
        for (name, takes_clips) in previews.chain((0..threads.max(1)).map(|_| ("clip", true))) {
            let shared = Arc::clone(&queue.shared);
            let thread = thread::Builder::new().name(name.to_owned());
            queue.threads.push(thread.spawn(move || shared.run_jobs(takes_clips))?);
        }
        Ok(queue)
    }

    /// Adds a job. If one with the same key is queued or runs, that one is returned, and is as urgent as the new one.
    pub(crate) fn add_job(&self, new: NewJob, work: Work) -> Job {
        self.shared.push(new, work)
    }

    /// The jobs that an earlier run left, each with what its work is made of again. They stay in the list until they are
    /// added again by [`Queue::go_on`] or given up by [`Queue::forget`].
    pub(crate) fn left(&self) -> Vec<Kept> {
        self.shared.lock().left.clone()
    }

    /// Adds again a job that an earlier run left, under its old number.
    pub(crate) fn go_on(&self, kept: &Kept, work: Work) -> Job {
        let entry = Entry::new(kept.id, kept.job(), work);
        let job = entry.job.clone();
        let mut inner = self.shared.lock();
        inner.left.retain(|left| left.id != kept.id);
        inner.entries.insert(kept.id, entry);
        drop(inner);
        self.shared.wake_all();
        (self.shared.listener)(&job);
        job
    }

    /// Gives up a job that an earlier run left.
    pub(crate) fn forget(&self, kept: &Kept) {
        let mut inner = self.shared.lock();
        inner.left.retain(|left| left.id != kept.id);
        inner.write_list();
    }

    /// All jobs that are queued, run, or were over lately; the oldest first.
    pub(crate) fn jobs(&self) -> Vec<Job> {
        self.shared.lock().entries.values().map(|entry| entry.job.clone()).collect()
    }

    /// Cancels a job: one that is queued is over at once, one that runs soon. Returns whether it is listed.
    pub(crate) fn cancel(&self, id: JobId) -> bool {
        let mut inner = self.shared.lock();
        let Some(entry) = inner.entries.get_mut(&id) else { return false };
        entry.cancel();
        let job = (entry.job.state == State::Queued).then(|| {
            entry.end(Err(String::new()));
            entry.job.clone()
        });
        if entry.spec.is_some() {
            inner.write_list();
        }
        drop(inner);
        self.shared.wake_all();
        if let Some(job) = job {
            (self.shared.listener)(&job);
        }
        true
    }

    /// Holds one job, or lets it go on: it is not begun, or stands still between two steps. Returns the job; `None` if it
    /// is not listed. [`Job::paused`] says whether it is held: one that is over, or runs without steps, cannot be.
    pub(crate) fn pause_job(&self, id: JobId, is_paused: bool) -> Option<Job> {
        let mut inner = self.shared.lock();
        let entry = inner.entries.get_mut(&id)?;
        entry.pause(is_paused);
        let job = entry.job.clone();
        drop(inner);
        self.shared.wake_all();
        (self.shared.listener)(&job);
        Some(job)
    }

    /// Holds all clips, or lets them go on.
    pub(crate) fn pause(&self, is_paused: bool) {
        self.shared.lock().is_paused = is_paused;
        self.shared.wake_all();
    }

    /// Whether clips are held.
    pub(crate) fn is_paused(&self) -> bool {
        self.shared.lock().is_paused
    }
}

impl Drop for Queue {
    fn drop(&mut self) {
        let mut inner = self.shared.lock();
        inner.is_closing = true;
        inner.entries.values().for_each(Entry::cancel);
        self.shared.wake_all();
        let runs = |inner: &mut Inner| inner.running > 0;
        let waited = self.shared.changed.wait_timeout_while(inner, LAST_STEPS, runs);
        let is_over = waited.is_ok_and(|(inner, _)| inner.running == 0);
        // Work that does not end, such as one that waits at a terminal, ends with the program.
        for thread in self.threads.drain(..).filter(|_| is_over) {
            // Work that panics is caught; the thread itself does nothing that could.
            let _ = thread.join();
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Inner> {
        // Nothing of ours panics while it holds the lock.
        locked(&self.inner)
    }

    pub(super) fn wake_all(&self) {
        self.changed.notify_all();
    }

    /// Adds a job, or finds the one that does the same.
    pub(super) fn push(&self, new: NewJob, work: Work) -> Job {
        let mut inner = self.lock();
        let same = |entry: &&mut Entry| {
            new.key.is_some() && entry.job.key == new.key && !entry.job.state.is_over() && !entry.is_cancelled()
        };
        if let Some(entry) = inner.entries.values_mut().find(same) {
            entry.priority = entry.priority.min(new.priority);
            return entry.job.clone();
        }
        inner.newest += 1;
        let (id, is_kept) = (inner.newest, new.spec.is_some());
        let entry = Entry::new(id, new, work);
        let job = entry.job.clone();
        inner.entries.insert(id, entry);
        inner.forget_the_oldest();
        if is_kept {
            inner.write_list();
        }
        drop(inner);
        self.wake_all();
        (self.listener)(&job);
        job
    }

    /// Marks the job as begun; returns the flag that cancels it.
    pub(super) fn begin(&self, id: JobId) -> Arc<AtomicBool> {
        let now = (self.clock)();
        self.lock().entries.get_mut(&id).map(|entry| entry.begin(now)).unwrap_or_default()
    }

    /// Changes a job; it is told if `change`, which is given the time, says so.
    pub(super) fn change(&self, id: JobId, change: impl FnOnce(&mut Entry, Duration) -> bool) {
        let now = (self.clock)();
        let mut inner = self.lock();
        let told = inner.entries.get_mut(&id).filter(|entry| !entry.job.state.is_over());
        let told = told.and_then(|entry| change(entry, now).then(|| entry.job.clone()));
        drop(inner);
        self.wake_all();
        if let Some(job) = told {
            (self.listener)(&job);
        }
    }

    /// Waits while a clip is held. The time does not count as its own.
    pub(super) fn wait_if_held(&self, id: JobId, cancel: &AtomicBool) {
        let begin = (self.clock)();
        let mut inner = self.lock();
        while !cancel.load(Ordering::Relaxed) && inner.holds(id) {
            inner = self.changed.wait(inner).unwrap_or_else(PoisonError::into_inner);
        }
        let stood = (self.clock)().saturating_sub(begin);
        if let Some(entry) = inner.entries.get_mut(&id) {
            entry.stood_still(stood);
        }
    }

    /// Runs jobs until the queue is closed: clips, or what somebody looks at.
    fn run_jobs(self: &Arc<Self>, takes_clips: bool) {
        let nice = if takes_clips { CLIP_NICE } else { PREVIEW_NICE };
        // Of this thread alone. Where it cannot be set, the thread works all the same.
        let _ = getpriority_process(None).and_then(|own| setpriority_process(None, own.max(nice)));
        while let Some((id, work)) = self.wait_for_job(takes_clips) {
            let cancel = self.begin(id);
            self.wake_all();
            self.tell(id);
            let progress = Progress::new(Arc::clone(self), id, cancel);
            let result = catch_unwind(AssertUnwindSafe(|| work(&progress)));
            let result =
                result.unwrap_or_else(|_| Err("the program has a bug: this job ended with a panic".to_owned()));
            self.end(id, result);
        }
    }

    fn wait_for_job(&self, takes_clips: bool) -> Option<(JobId, Work)> {
        let mut inner = self.lock();
        while !inner.is_closing {
            if let Some(found) = inner.next(takes_clips) {
                return Some(found);
            }
            inner = self.changed.wait(inner).unwrap_or_else(PoisonError::into_inner);
        }
        None
    }

    fn end(&self, id: JobId, result: Result<Value, String>) {
        let mut inner = self.lock();
        inner.running -= 1;
        // What is cancelled because the program ends is gone on with at the next start.
        if !(inner.is_closing && result.is_err()) {
            let is_kept = inner.entries.get_mut(&id).is_some_and(|entry| {
                entry.end(result);
                entry.spec.is_some()
            });
            if is_kept {
                inner.write_list();
            }
        }
        drop(inner);
        self.wake_all();
        self.tell(id);
    }

    fn tell(&self, id: JobId) {
        let job = self.lock().entries.get(&id).map(|entry| entry.job.clone());
        if let Some(job) = job {
            (self.listener)(&job);
        }
    }
}

impl Inner {
    /// The job to begin: the most urgent one, of these the oldest. It counts as running from here on.
    fn next(&mut self, takes_clips: bool) -> Option<(JobId, Work)> {
        let may_begin = |entry: &&mut Entry| {
            let is_clip = entry.priority == Priority::Clip;
            let is_held = entry.job.paused || is_clip && self.is_paused;
            entry.job.state == State::Queued && is_clip == takes_clips && !is_held
        };
        let next = self.entries.values_mut().filter(may_begin).min_by_key(|entry| (entry.priority, entry.job.id))?;
        (next.job.state, next.job.can_pause) = (State::Running, next.job.kind.has_steps());
        let (id, work) = (next.job.id, next.work.take()?);
        self.running += 1;
        Some((id, work))
    }

    /// Whether the job `id` must stand still: it is paused; or it is a clip, while there is a pause or somebody waits for
    /// something else.
    fn holds(&self, id: JobId) -> bool {
        let is_urgent =
            |entry: &Entry| entry.priority == Priority::Interactive && !entry.job.state.is_over() && !entry.job.paused;
        let Some(entry) = self.entries.get(&id) else { return false };
        let gives_way = || self.is_paused || self.entries.values().any(is_urgent);
        entry.job.paused || entry.priority == Priority::Clip && gives_way()
    }

    fn forget_the_oldest(&mut self) {
        let over = self.entries.values().filter(|entry| entry.job.state.is_over()).map(|entry| entry.job.id);
        let over: Vec<JobId> = over.collect();
        for id in &over[..over.len().saturating_sub(MOST_OVER)] {
            self.entries.remove(id);
        }
    }

    /// Writes the list of what a restart goes on with. If the disk refuses, a restart forgets: no art is lost.
    fn write_list(&self) {
        let Some(list) = &self.list else { return };
        let unfinished = self.entries.values().filter(|entry| !entry.job.state.is_over() && !entry.is_cancelled());
        let kept = unfinished.filter_map(|entry| {
            let Job { id, kind, what, key, about, cost_s, .. } = entry.job.clone();
            Some(Kept { id, priority: entry.priority, kind, what, key, about, cost_s, spec: entry.spec.clone()? })
        });
        let all: Vec<Kept> = self.left.iter().cloned().chain(kept).collect();
        let _ = list.write(&all);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicU64;

    use super::*;
    use crate::jobs::Kind;

    impl Queue {
        /// Adds a job that a restart forgets; returns its number.
        pub(crate) fn add(&self, priority: Priority, kind: Kind, what: impl Into<String>, work: Work) -> JobId {
            self.add_job(NewJob::new(priority, kind, what), work).id
        }

        /// The job of this number, if it is still listed.
        pub(crate) fn job(&self, id: JobId) -> Option<Job> {
            self.shared.lock().entries.get(&id).map(|entry| entry.job.clone())
        }

        /// Waits until `is_so` of all jobs, at most for the time `most`; returns whether it was. For programs that end, and
        /// tests.
        pub(crate) fn wait_until(&self, most: Duration, is_so: impl Fn(&[Job]) -> bool) -> bool {
            let jobs = |inner: &Inner| inner.entries.values().map(|entry| entry.job.clone()).collect::<Vec<Job>>();
            let waits = |inner: &mut Inner| !is_so(&jobs(inner));
            let waited = self.shared.changed.wait_timeout_while(self.shared.lock(), most, waits);
            let (inner, _) = waited.unwrap_or_else(PoisonError::into_inner);
            is_so(&jobs(&inner))
        }
    }

    impl Shared {
        /// What a handle without a queue has. Its clock goes on by a second with each reading, so that `listener` gets every
        /// change.
        pub(in crate::jobs) fn alone(listener: Listener) -> Arc<Self> {
            static READINGS: AtomicU64 = AtomicU64::new(0);
            let clock: Clock = || Duration::from_secs(READINGS.fetch_add(1, Ordering::Relaxed));
            Arc::new(Self { inner: Mutex::default(), changed: Condvar::new(), clock, listener })
        }
    }
}
