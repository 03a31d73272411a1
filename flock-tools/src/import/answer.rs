//! What an import tells when it has ended.
//!
//! Owns the JSON document and the lines for people. Never decides anything.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use flock::{ClipHash, ClipPath, SheepId};
use serde::Serialize;
use timing::FrameCount;

use super::LeftOut;
use super::genomes::Flamed;
use super::plan::Plan;
use crate::program::{Fatal, print};
use crate::render::plan::Shows;

/// What an import did, or would do.
#[derive(Default, Serialize)]
pub(super) struct Answer {
    pub(super) clips: Vec<Done>,
    pub(super) genomes: Vec<Flamed>,
    /// Sheep that imported transitions start or end with, and that had to be added, without loops.
    pub(super) added: Vec<SheepId>,
    pub(super) left_out: Vec<LeftOut>,
    pub(super) tombstones: usize,
    pub(super) interrupted: bool,
}

/// What became of a clip.
#[derive(Serialize)]
pub(super) struct Done {
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
    /// In the flock; with a dry run, as the file tells.
    #[serde(skip_serializing_if = "Option::is_none")]
    frames: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    hash: Option<String>,
    /// What the file tells of its origin, kept in the clip.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    tags: BTreeMap<String, String>,
}

impl Done {
    /// What became of the clip `source`, which shows `shows` and lies in the flock at `clip`.
    pub(super) fn new(source: &Path, shows: &Shows, clip: ClipPath, state: &'static str) -> Self {
        let (sheep, from, to) = match shows.clone() {
            Shows::Loop(id) => (Some(id), None, None),
            Shows::Transition(from, to) => (None, Some(from), Some(to)),
        };
        let (source, tags) = (source.to_owned(), BTreeMap::new());
        Self { source, sheep, from, to, clip, state, frames: None, hash: None, tags }
    }

    /// What became of the clip of `plan`.
    pub(super) fn of(plan: &Plan, state: &'static str) -> Self {
        let tags = plan.about.tags.iter().cloned().collect();
        Self { tags, ..Self::new(&plan.source, &plan.shows, plan.path.clone(), state) }
    }

    /// The same, with what is known of its frames and its bytes.
    pub(super) fn told(self, frames: Option<FrameCount>, hash: Option<ClipHash>) -> Self {
        Self { frames: frames.map(|frames| frames.0), hash: hash.map(|hash| hash.to_string()), ..self }
    }

    /// The same in a line.
    pub(super) fn line(&self) -> String {
        let frames = self.frames.map_or(String::new(), |frames| format!(" {frames} frames,"));
        format!("{}{frames} {} from `{}`", self.clip, self.state, self.source.display())
    }
}

impl Answer {
    /// Tells everything but, without `json`, the clips that were told as they came. `others` files were of other kinds.
    pub(super) fn tell(&self, others: usize, json: bool) -> Result<(), Fatal> {
        if json {
            return print::json(self);
        }
        let foreseen = self.clips.iter().filter(|clip| ["copy", "encode"].contains(&clip.state)).map(Done::line);
        let flame = |flamed: &Flamed| {
            format!("{} {} as sheep `{}` from `{}`", flamed.genome, flamed.state, flamed.sheep, flamed.source.display())
        };
        let flames = self.genomes.iter().filter(|flamed| flamed.state != "stood").map(flame);
        print::lines(foreseen.chain(flames))?;
        for id in &self.added {
            print::note(&format!("note: sheep `{id}` is added without a loop: it is only passed through"));
        }
        for LeftOut { source, reason } in &self.left_out {
            print::note(&format!("left out `{}`: {reason}", source.display()));
        }
        let stood = self.clips.iter().filter(|clip| clip.state == "stood").count()
            + self.genomes.iter().filter(|flamed| flamed.state == "stood").count();
        for (count, what) in [
            (stood, "in the flock already"),
            (self.tombstones, "only a name: voted down or deleted"),
            (others, "of kinds that are not imported"),
        ] {
            if count > 0 {
                print::note(&format!("note: {} passed over, {what}", print::count(count, "file")));
            }
        }
        if self.interrupted {
            print::note("interrupted; the same command goes on where this one stopped");
        }
        Ok(())
    }
}
