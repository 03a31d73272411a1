//! The list of jobs that a restart goes on with.
//!
//! Owns the file: one JSON document, replaced as a whole. A list that is missing or damaged is empty: it loses no art.
//!
//! Start at [`KeptList`].

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{JobId, Kind, NewJob, Priority};

/// A job that was not over when the program ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Kept {
    /// Its number, which it keeps.
    pub(crate) id: JobId,
    /// How soon.
    pub(crate) priority: Priority,
    /// What kind of work.
    pub(crate) kind: Kind,
    /// What it makes, in words.
    pub(crate) what: String,
    /// As [`super::Job::key`].
    pub(crate) key: Option<String>,
    /// As [`super::Job::about`].
    #[serde(default)]
    pub(crate) about: Option<Value>,
    /// As [`super::Job::cost_s`].
    pub(crate) cost_s: Option<f64>,
    /// What the work is made of again.
    pub(crate) spec: Value,
}

impl Kept {
    /// The job, to be added again.
    pub(super) fn job(&self) -> NewJob {
        let Self { priority, kind, what, key, about, cost_s, spec, .. } = self.clone();
        NewJob { priority, kind, what, key, about, cost_s, spec: Some(spec) }
    }
}

/// The file of the list.
#[derive(Debug)]
pub(super) struct KeptList {
    path: PathBuf,
}

impl KeptList {
    /// The file at `path`, and what it lists.
    pub(super) fn open(path: &Path) -> (Self, Vec<Kept>) {
        let read = fs::read(path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
        (Self { path: path.to_owned() }, read.unwrap_or_default())
    }

    /// Has the file list `jobs`.
    /// Errors: What the disk says.
    pub(super) fn write(&self, jobs: &[Kept]) -> io::Result<()> {
        durable::write(&self.path, &serde_json::to_vec(jobs)?)
    }
}
