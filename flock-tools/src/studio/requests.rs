//! The bodies of the page's requests.
//!
//! Owns their forms; what they mean, the handlers know. Members that a form does not name are passed over.

use ::studio::document::{EditRequest, MarkKind, Revision};
use flock::SheepId;

use super::breeding::children::Lock;

/// `POST /api/marks`.
#[derive(Debug, serde::Deserialize)]
pub(super) struct Marks {
    pub(super) marks: Vec<MarkOf>,
}

/// A mark, a rating or both of a sheep.
#[derive(Debug, serde::Deserialize)]
pub(super) struct MarkOf {
    pub(super) sheep: SheepId,
    #[serde(default)]
    pub(super) mark: Option<MarkKind>,
    #[serde(default)]
    pub(super) rating: Option<u8>,
}

/// `POST /api/pins`: without a place the sheep is let go.
#[derive(Debug, serde::Deserialize)]
pub(super) struct Pin {
    pub(super) sheep: SheepId,
    pub(super) x: Option<f64>,
    pub(super) y: Option<f64>,
}

/// `POST /api/joins/bad`.
#[derive(Debug, serde::Deserialize)]
pub(super) struct JoinMark {
    pub(super) from: SheepId,
    pub(super) to: SheepId,
    pub(super) bad: bool,
}

/// `GET /api/state?by&since`: what is new to a page that has the state of this tag.
#[derive(Debug, Default, serde::Deserialize)]
pub(super) struct StateQuery {
    #[serde(default)]
    pub(super) by: Option<String>,
    #[serde(default)]
    pub(super) since: Option<String>,
}

/// `POST /api/undo` and `/api/redo`: with the tag of its state the page is answered what is new.
#[derive(Debug, Default, serde::Deserialize)]
pub(super) struct StepRequest {
    #[serde(default)]
    pub(super) since: Option<String>,
}

/// `GET /api/walk?seed&steps&from`.
#[derive(Debug, serde::Deserialize)]
pub(super) struct WalkQuery {
    pub(super) seed: Option<u64>,
    pub(super) steps: Option<usize>,
    pub(super) from: Option<String>,
}

/// `GET /api/balance?fairness&floor&by&afresh`.
#[derive(Debug, Default, serde::Deserialize)]
pub(super) struct Terms {
    pub(super) fairness: Option<String>,
    pub(super) floor: Option<f64>,
    pub(super) by: Option<String>,
    #[serde(default)]
    pub(super) afresh: bool,
}

/// `GET /api/prune?keep&by`: the part with the sheep `keep` is kept.
#[derive(Debug, Default, serde::Deserialize)]
pub(super) struct PruneQuery {
    #[serde(default)]
    pub(super) keep: Option<String>,
    #[serde(default)]
    pub(super) by: Option<String>,
}

/// `POST /api/breed`.
#[derive(Debug, serde::Deserialize)]
pub(super) struct BreedRequest {
    #[serde(default)]
    pub(super) parents: Vec<String>,
    #[serde(default)]
    pub(super) species: Option<String>,
    #[serde(default)]
    pub(super) count: Option<usize>,
    #[serde(default)]
    pub(super) strength: Option<f64>,
    #[serde(default)]
    pub(super) locks: Vec<Lock>,
    #[serde(default)]
    pub(super) seed: Option<u64>,
}

/// `POST /api/broods/accept`.
#[derive(Debug, serde::Deserialize)]
pub(super) struct Accept {
    pub(super) cells: Vec<String>,
    pub(super) into: Destination,
}

/// Where accepted sheep go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Destination {
    Pool,
    Flock,
}

/// `GET /api/lineage?at`.
#[derive(Debug, serde::Deserialize)]
pub(super) struct LineageQuery {
    pub(super) at: Option<String>,
}

/// `POST /api/votes/import`: documents of units; those that name no unit are of `unit`.
#[derive(Debug, serde::Deserialize)]
pub(super) struct VotesText {
    pub(super) text: String,
    #[serde(default)]
    pub(super) unit: Option<String>,
}

/// `GET /api/globe?agents`.
#[derive(Debug, serde::Deserialize)]
pub(super) struct GlobeQuery {
    pub(super) agents: Option<usize>,
}

/// `POST /api/globe`: the strings that were touched; `keep` puts them into the pool instead.
#[derive(Debug, serde::Deserialize)]
pub(super) struct GlobeRequest {
    pub(super) strings: Vec<String>,
    #[serde(default)]
    pub(super) keep: bool,
}

/// `POST /api/jobs`.
#[derive(Debug, serde::Deserialize)]
pub(super) struct JobRequest {
    pub(super) kind: String,
    #[serde(default)]
    pub(super) sheep: Option<String>,
    #[serde(default)]
    pub(super) from: Option<String>,
    #[serde(default)]
    pub(super) to: Option<String>,
    #[serde(default)]
    pub(super) all_missing: bool,
    #[serde(default)]
    pub(super) draft: bool,
    #[serde(default)]
    pub(super) dry: bool,
}

/// `POST /api/jobs/pause`, and `/api/jobs/ID/pause` for one job.
#[derive(Debug, serde::Deserialize)]
pub(super) struct Pause {
    pub(super) paused: bool,
}

/// `POST /api/previews`.
#[derive(Debug, serde::Deserialize)]
pub(super) struct PreviewRequest {
    pub(super) from: String,
    pub(super) to: String,
    pub(super) kind: PreviewKind,
}

/// What is previewed of a transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum PreviewKind {
    Middles,
    Moving,
}

/// `POST /api/ship/check`.
#[derive(Debug, serde::Deserialize)]
pub(super) struct CheckRequest {
    #[serde(default)]
    pub(super) joins: bool,
}

/// `POST /api/ship/pack`: the name of a key, and the units that it is for.
#[derive(Debug, serde::Deserialize)]
pub(super) struct PackRequest {
    pub(super) key: String,
    #[serde(default)]
    pub(super) units: Vec<String>,
    #[serde(default)]
    pub(super) allow_jumps: bool,
}

/// `POST /api/ship/publish`: one of the targets that the page was told.
#[derive(Debug, serde::Deserialize)]
pub(super) struct PublishRequest {
    pub(super) to: String,
}

/// `GET /media/packets/KEY?from&to`: frames from the one up to the other.
#[derive(Debug, serde::Deserialize)]
pub(super) struct PacketsQuery {
    pub(super) from: u32,
    pub(super) to: u32,
}

/// `GET /media/middle/KEY?at`: 1 to 3.
#[derive(Debug, serde::Deserialize)]
pub(super) struct MiddleQuery {
    pub(super) at: usize,
}

/// `GET /media/preview/KEY?from`: the bytes from this one on.
#[derive(Debug, serde::Deserialize)]
pub(super) struct PreviewQuery {
    pub(super) from: Option<u64>,
}

/// `POST /api/edits`.
#[derive(Debug, serde::Deserialize)]
pub(super) struct EditsRequest {
    /// The revision that they were meant for.
    pub(super) revision: Revision,
    /// Edits of one gesture are undone at once.
    #[serde(default)]
    pub(super) gesture: Option<String>,
    pub(super) edits: Vec<EditRequest>,
    /// Whether sheep may go off the wall.
    #[serde(default)]
    pub(super) force: bool,
    #[serde(default)]
    pub(super) by: Option<String>,
    /// With the tag of its state the page is answered what is new.
    #[serde(default)]
    pub(super) since: Option<String>,
}

/// `POST /api/whatif`.
#[derive(Debug, serde::Deserialize)]
pub(super) struct WhatIfRequest {
    pub(super) edits: Vec<EditRequest>,
    /// Is carried back, so that the newest answer counts.
    #[serde(default)]
    pub(super) sequence: Option<u64>,
    #[serde(default)]
    pub(super) by: Option<String>,
}
