//! The bodies of the page's requests.
//!
//! Owns their forms; what they mean, the handlers know. Members that a form does not name are passed over.

use flock::SheepId;

use crate::breeding::children::Lock;
use crate::document::{EditRequest, MarkKind, Revision};

/// `POST /api/marks`.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct Marks {
    pub(crate) marks: Vec<MarkOf>,
}

/// A mark, a rating or both of a sheep.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct MarkOf {
    pub(crate) sheep: SheepId,
    pub(crate) mark: Option<MarkKind>,
    pub(crate) rating: Option<u8>,
}

/// `POST /api/pins`: without a place the sheep is let go.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct Pin {
    pub(crate) sheep: SheepId,
    pub(crate) x: Option<f64>,
    pub(crate) y: Option<f64>,
}

/// `POST /api/joins/bad`.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct JoinMark {
    pub(crate) from: SheepId,
    pub(crate) to: SheepId,
    pub(crate) bad: bool,
}

/// `GET /api/state?by&since`: what is new to a page that has the state of this tag.
#[derive(Debug, Default, serde::Deserialize)]
pub(crate) struct StateQuery {
    pub(crate) by: Option<String>,
    pub(crate) since: Option<String>,
}

/// `POST /api/undo` and `/api/redo`: with the tag of its state the page is answered what is new.
#[derive(Debug, Default, serde::Deserialize)]
pub(crate) struct StepRequest {
    pub(crate) since: Option<String>,
}

/// `GET /api/walk?seed&steps&from`.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct WalkQuery {
    pub(crate) seed: Option<u64>,
    pub(crate) steps: Option<usize>,
    pub(crate) from: Option<String>,
}

/// `GET /api/balance?fairness&floor&by&afresh`.
#[derive(Debug, Default, serde::Deserialize)]
pub(crate) struct Terms {
    pub(crate) fairness: Option<String>,
    pub(crate) floor: Option<f64>,
    pub(crate) by: Option<String>,
    #[serde(default)]
    pub(crate) afresh: bool,
}

/// `GET /api/prune?keep&by`: the part with the sheep `keep` is kept.
#[derive(Debug, Default, serde::Deserialize)]
pub(crate) struct PruneQuery {
    pub(crate) keep: Option<String>,
    pub(crate) by: Option<String>,
}

/// `POST /api/breed`.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct BreedRequest {
    #[serde(default)]
    pub(crate) parents: Vec<String>,
    pub(crate) species: Option<String>,
    pub(crate) count: Option<usize>,
    pub(crate) strength: Option<f64>,
    #[serde(default)]
    pub(crate) locks: Vec<Lock>,
    pub(crate) seed: Option<u64>,
}

/// `POST /api/broods/accept`.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct Accept {
    pub(crate) cells: Vec<String>,
    pub(crate) into: Destination,
}

/// Where accepted sheep go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Destination {
    Pool,
    Flock,
}

/// `GET /api/lineage?at`.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct LineageQuery {
    pub(crate) at: Option<String>,
}

/// `POST /api/votes/import`: documents of units; those that name no unit are of `unit`.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct VotesText {
    pub(crate) text: String,
    pub(crate) unit: Option<String>,
}

/// `GET /api/globe?agents`.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct GlobeQuery {
    pub(crate) agents: Option<usize>,
}

/// `POST /api/globe`: the strings that were touched; `keep` puts them into the pool instead.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct GlobeRequest {
    pub(crate) strings: Vec<String>,
    #[serde(default)]
    pub(crate) keep: bool,
}

/// `POST /api/jobs`.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct JobRequest {
    pub(crate) kind: String,
    pub(crate) sheep: Option<String>,
    pub(crate) from: Option<String>,
    pub(crate) to: Option<String>,
    #[serde(default)]
    pub(crate) all_missing: bool,
    #[serde(default)]
    pub(crate) draft: bool,
    #[serde(default)]
    pub(crate) dry: bool,
}

/// `POST /api/jobs/pause`, and `/api/jobs/ID/pause` for one job.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct Pause {
    pub(crate) paused: bool,
}

/// `POST /api/previews`.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct PreviewRequest {
    pub(crate) from: String,
    pub(crate) to: String,
    pub(crate) kind: PreviewKind,
}

/// What is previewed of a transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum PreviewKind {
    Middles,
    Moving,
}

/// `POST /api/ship/check`.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct CheckRequest {
    #[serde(default)]
    pub(crate) joins: bool,
}

/// `POST /api/ship/pack`: the name of a key, and the units that it is for.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct PackRequest {
    pub(crate) key: String,
    #[serde(default)]
    pub(crate) units: Vec<String>,
    #[serde(default)]
    pub(crate) allow_jumps: bool,
}

/// `POST /api/ship/publish`: one of the targets that the page was told.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct PublishRequest {
    pub(crate) to: String,
}

/// `GET /media/packets/KEY?from&to`: frames from the one up to the other.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct PacketsQuery {
    pub(crate) from: u32,
    pub(crate) to: u32,
}

/// `GET /media/middle/KEY?at`: 1 to 3.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct MiddleQuery {
    pub(crate) at: usize,
}

/// `GET /media/preview/KEY?from`: the bytes from this one on.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct PreviewQuery {
    pub(crate) from: Option<u64>,
}

/// `POST /api/edits`.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct EditsRequest {
    /// The revision that they were meant for.
    pub(crate) revision: Revision,
    /// Edits of one gesture are undone at once.
    pub(crate) gesture: Option<String>,
    pub(crate) edits: Vec<EditRequest>,
    /// Whether sheep may go off the wall.
    #[serde(default)]
    pub(crate) force: bool,
    pub(crate) by: Option<String>,
    /// With the tag of its state the page is answered what is new.
    pub(crate) since: Option<String>,
}

/// `POST /api/whatif`.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct WhatIfRequest {
    pub(crate) edits: Vec<EditRequest>,
    /// Is carried back, so that the newest answer counts.
    pub(crate) sequence: Option<u64>,
    pub(crate) by: Option<String>,
}
