//! The queue of what takes long: strips, previews, clips, checks, packs.
//!
//! Owns the order, the progress, pause and cancel, and the list of what a restart must go on with. Work runs on threads of
//! its own, clips at a lower priority for the kernel, never on the threads that answer pages. Never knows what the work does.
//!
//! Start at [`Queue::open`], then [`Progress`], which the work is given.

mod entry;
mod kept;
mod progress;
mod queue;
#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};
use serde_json::Value;

pub(crate) use kept::Kept;
pub(crate) use progress::Progress;
pub(crate) use queue::{Queue, Settings};

/// What a job does, on a thread of the queue. Its answer is kept with the job; an error is a sentence for the artist.
pub(crate) type Work = Box<dyn FnOnce(&Progress) -> Result<Value, String> + Send>;

/// The number of a job, unique in a flock's folder while the list of kept jobs is there.
pub(crate) type JobId = u64;

/// How soon a job is begun. Of the same priority the older one comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Priority {
    /// Somebody waits for it before the page. Running clips give way to it.
    Interactive,
    /// A picture of what the page shows. No clip has its threads.
    Preview,
    /// All else: clips, checks, packs. A pause holds these, and no others.
    Clip,
}

/// What kind of job it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Kind {
    /// New genomes, with their strips.
    Brood,
    /// Faults of the clips.
    Check,
    /// How much is seen of each join.
    Joins,
    /// The strips of all sheep, which tell their activity and their colour.
    Measure,
    /// Pictures from the middle of a transition.
    Middles,
    /// A small moving preview of a transition.
    Moving,
    /// A signed bundle.
    Pack,
    /// A bundle copied to where units find it.
    Publish,
    /// A clip of the flock.
    Render,
    /// A strip of a sheep.
    Strip,
}

/// How far a job is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum State {
    /// Not begun.
    Queued,
    /// On a thread.
    Running,
    /// On a thread, and waiting for something outside, which the last line of its log names.
    Waiting,
    /// Ended with its result.
    Done,
    /// Ended with an error.
    Failed,
    /// Ended because it was asked to.
    Cancelled,
}

/// A job, as the page reads it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Job {
    /// Its number.
    pub(crate) id: JobId,
    /// What kind of work it is.
    pub(crate) kind: Kind,
    /// What it makes, in words.
    pub(crate) what: String,
    /// What it makes, for programs: the same text means the same result. At most one such job is queued or running.
    pub(crate) key: Option<String>,
    /// What it is about, for the page.
    pub(crate) about: Option<Value>,
    /// How far it is.
    pub(crate) state: State,
    /// Whether it is held, apart from the others: it is not begun, or stands still between two steps.
    pub(crate) paused: bool,
    /// Whether it can be held now: it is queued, or has steps between which it can stand still.
    pub(crate) can_pause: bool,
    /// How many steps are done, of `of`.
    pub(crate) done: u64,
    /// How many steps there are; 0 while that is not known.
    pub(crate) of: u64,
    /// Steps per second of the time that it ran, without pauses.
    pub(crate) per_second: Option<f64>,
    /// Seconds that the rest takes at that pace.
    pub(crate) left_s: Option<f64>,
    /// Seconds that all of it was expected to take.
    pub(crate) cost_s: Option<f64>,
    /// The last lines that it logged.
    pub(crate) log: Vec<String>,
    /// Why it failed.
    pub(crate) error: Option<String>,
    /// What it answered.
    pub(crate) result: Option<Value>,
}

/// A job to be added.
#[derive(Clone, Debug)]
pub(crate) struct NewJob {
    /// How soon.
    pub(crate) priority: Priority,
    /// What kind of work.
    pub(crate) kind: Kind,
    /// What it makes, in words.
    pub(crate) what: String,
    /// As [`Job::key`].
    pub(crate) key: Option<String>,
    /// As [`Job::about`].
    pub(crate) about: Option<Value>,
    /// As [`Job::cost_s`].
    pub(crate) cost_s: Option<f64>,
    /// What a restart needs to make the work again; `None` for a job that a restart forgets.
    pub(crate) spec: Option<Value>,
}

impl NewJob {
    /// A job that a restart forgets, and that may be queued twice.
    pub(crate) fn new(priority: Priority, kind: Kind, what: impl Into<String>) -> Self {
        Self { priority, kind, what: what.into(), key: None, about: None, cost_s: None, spec: None }
    }
}

impl Kind {
    /// Whether work of this kind stands still between its steps while it is held.
    fn has_steps(self) -> bool {
        match self {
            Self::Check | Self::Measure | Self::Render => true,
            Self::Brood | Self::Joins | Self::Middles | Self::Moving | Self::Pack | Self::Publish | Self::Strip => {
                false
            }
        }
    }
}

impl State {
    /// Whether nothing more comes of it.
    pub(crate) fn is_over(self) -> bool {
        match self {
            Self::Queued | Self::Running | Self::Waiting => false,
            Self::Done | Self::Failed | Self::Cancelled => true,
        }
    }
}
