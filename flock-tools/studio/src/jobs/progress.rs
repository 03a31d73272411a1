//! What work tells of itself, and is told.
//!
//! Owns the handle that every piece of work is given. Never ends the work: it must ask, often, whether it is cancelled.
//!
//! Start at [`Progress`].

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::JobId;
use super::queue::Shared;

/// The handle of a job that runs.
#[derive(Clone)]
pub(crate) struct Progress {
    shared: Arc<Shared>,
    id: JobId,
    cancel: Arc<AtomicBool>,
    is_silent: bool,
}

impl std::fmt::Debug for Progress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Progress").field("id", &self.id).finish_non_exhaustive()
    }
}

impl Progress {
    pub(super) fn new(shared: Arc<Shared>, id: JobId, cancel: Arc<AtomicBool>) -> Self {
        Self { shared, id, cancel, is_silent: false }
    }

    /// The handle for a part of the work: it is held and cancelled with the job, and the job's steps are not its own.
    #[must_use]
    pub(crate) fn for_part(&self) -> Self {
        Self { is_silent: true, ..self.clone() }
    }

    /// `done` of `of` steps are done; `of` is 0 while it is not known.
    pub(crate) fn set(&self, done: u64, of: u64) {
        if self.is_silent {
            return;
        }
        self.shared.change(self.id, |entry, now| {
            entry.set(done, of, now);
            entry.may_tell(now)
        });
    }

    /// Adds a line to the job's log.
    pub(crate) fn log(&self, line: &str) {
        self.shared.change(self.id, |entry, _| {
            entry.log(line);
            true
        });
    }

    /// The job waits for something outside, which `text` names, such as a passphrase at the terminal. It goes on with the
    /// next [`Progress::set`] or [`Progress::log`].
    pub(crate) fn waiting_for(&self, text: &str) {
        self.shared.change(self.id, |entry, _| {
            entry.log(text);
            entry.job.state = super::State::Waiting;
            true
        });
    }

    /// Returns when the job may go on: not while it is paused, nor while a clip has to give way to what somebody waits for.
    /// Returns at once if it is cancelled. Work calls it between frames.
    pub(crate) fn wait_if_paused(&self) {
        self.shared.wait_if_held(self.id, &self.cancel);
    }

    /// Whether the work should end now, with any error.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::OnceLock;

    use super::*;
    use crate::jobs::{Kind, NewJob, Priority};

    impl Progress {
        /// A handle that nobody listens to.
        pub(crate) fn detached() -> Self {
            Self::cancelled_after(u64::MAX)
        }

        /// A handle that nobody listens to, of a job that is cancelled as soon as so many steps are done.
        pub(crate) fn cancelled_after(steps: u64) -> Self {
            let flag = Arc::new(OnceLock::<Arc<AtomicBool>>::new());
            let begun = Arc::clone(&flag);
            let shared = Shared::alone(Box::new(move |job| {
                if let Some(flag) = begun.get().filter(|_| job.done >= steps) {
                    flag.store(true, Ordering::Relaxed);
                }
            }));
            let new = NewJob::new(Priority::Clip, Kind::Render, "");
            let id = shared.push(new, Box::new(|_| Ok(serde_json::Value::Null))).id;
            let cancel = shared.begin(id);
            flag.set(Arc::clone(&cancel)).expect("it is set once");
            Self::new(shared, id, cancel)
        }

        /// Cancels this job, as [`super::Queue::cancel`] does.
        pub(crate) fn cancel(&self) {
            self.cancel.store(true, Ordering::Relaxed);
            self.shared.wake_all();
        }
    }
}
