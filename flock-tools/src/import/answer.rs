//! The answer of an import.
//!
//! Owns the JSON document and the lines for people. Never decides anything.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use flock::{ClipHash, ClipPath, SheepId};
use serde::Serialize;
use timing::FrameCount;

use super::SkippedFile;
use super::genomes::GenomeAnswer;
use super::plan::Plan;
use crate::program::{Fatal, print};
use crate::render::plan::ClipRole;

/// The answer with `--json`.
#[derive(Default, Serialize)]
pub(super) struct Answer {
    pub(super) clips: Vec<ClipAnswer>,
    pub(super) genomes: Vec<GenomeAnswer>,
    /// Sheep that imported transitions start or end with, and that had to be added, without loops.
    pub(super) added: Vec<SheepId>,
    pub(super) left_out: Vec<SkippedFile>,
    pub(super) tombstones: usize,
    pub(super) interrupted: bool,
}

/// A clip in the answer.
#[derive(Serialize)]
pub(super) struct ClipAnswer {
    source: PathBuf,
    /// Of a loop.
    #[serde(skip_serializing_if = "Option::is_none")]
    sheep: Option<SheepId>,
    /// Of a transition.
    #[serde(skip_serializing_if = "Option::is_none")]
    from: Option<SheepId>,
    #[serde(skip_serializing_if = "Option::is_none")]
    to: Option<SheepId>,
    clip: ClipPath,
    /// `copied` or `encoded`, with a dry run `copy` or `encode`; `stood`: the flock has it.
    state: &'static str,
    /// In the flock; with a dry run, by the file's header.
    #[serde(skip_serializing_if = "Option::is_none")]
    frames: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    hash: Option<String>,
    /// The tags of the file, which are kept in the clip.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    tags: BTreeMap<String, String>,
}

impl ClipAnswer {
    /// The clip from `source`, which is `role` and has the path `clip` in the flock.
    pub(super) fn new(source: &Path, role: &ClipRole, clip: ClipPath, state: &'static str) -> Self {
        let (sheep, from, to) = match role.clone() {
            ClipRole::Loop(id) => (Some(id), None, None),
            ClipRole::Transition(from, to) => (None, Some(from), Some(to)),
        };
        let (source, tags) = (source.to_owned(), BTreeMap::new());
        Self { source, sheep, from, to, clip, state, frames: None, hash: None, tags }
    }

    /// The clip of `plan`.
    pub(super) fn of(plan: &Plan, state: &'static str) -> Self {
        let tags = plan.about.tags.iter().cloned().collect();
        Self { tags, ..Self::new(&plan.source, &plan.role, plan.path.clone(), state) }
    }

    /// The same, with its frames and its hash.
    pub(super) fn with(self, frames: Option<FrameCount>, hash: Option<ClipHash>) -> Self {
        Self { frames: frames.map(|frames| frames.0), hash: hash.map(|hash| hash.to_string()), ..self }
    }

    /// The same as a line.
    pub(super) fn line(&self) -> String {
        let frames = self.frames.map_or(String::new(), |frames| format!(" {frames} frames,"));
        format!("{}{frames} {} from `{}`", self.clip, self.state, self.source.display())
    }
}

impl Answer {
    /// Prints the answer. Without `json` the imported clips were printed already. `others` files were of other kinds.
    pub(super) fn print(&self, others: usize, json: bool) -> Result<(), Fatal> {
        if json {
            return print::json(self);
        }
        let planned = self.clips.iter().filter(|clip| ["copy", "encode"].contains(&clip.state)).map(ClipAnswer::line);
        let flame = |genome: &GenomeAnswer| {
            format!("{} {} as sheep `{}` from `{}`", genome.genome, genome.state, genome.sheep, genome.source.display())
        };
        let flames = self.genomes.iter().filter(|genome| genome.state != "stood").map(flame);
        print::lines(planned.chain(flames))?;
        for id in &self.added {
            print::note(&format!("note: sheep `{id}` is added without a loop: it is only passed through"));
        }
        for SkippedFile { source, reason } in &self.left_out {
            print::note(&format!("left out `{}`: {reason}", source.display()));
        }
        let already_there = self.clips.iter().filter(|clip| clip.state == "stood").count()
            + self.genomes.iter().filter(|genome| genome.state == "stood").count();
        for (count, what) in [
            (already_there, "in the flock already"),
            (self.tombstones, "only a name: voted down or deleted"),
            (others, "of kinds that are not imported"),
        ] {
            if count > 0 {
                print::note(&format!("note: {} passed over, {what}", print::count(count, "file")));
            }
        }
        if self.interrupted {
            print::note("interrupted; the same command continues where this one stopped");
        }
        Ok(())
    }
}
