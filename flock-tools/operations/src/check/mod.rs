//! The faults of a flock, and each in words.
//!
//! Owns which faults there are. The flock crate finds those of the graph, `clips.rs` those of the clips, `genomes.rs` those
//! of the genomes, `joins/` the joins that jump.
//!
//! Start at [`every_fault`].

pub mod clips;
pub mod genomes;

use std::path::Path;

use flock::{ClipPath, Fault, FaultKind, Flock};

use crate::decoder::{Decoder, DecoderHandle};
use crate::flock_folder::file_list;
use crate::joins::{self, JudgedJoin, Judgement};
use crate::program::{Exit, Fatal};

/// Joins that could not be judged although no clip has a fault: the machine failed.
#[derive(Debug, thiserror::Error)]
#[error("cannot judge {count} joins, `{before}` into `{after}` first: {reason}")]
struct UnjudgedJoins {
    count: usize,
    before: ClipPath,
    after: ClipPath,
    reason: String,
}

/// Every fault of the flock in `folder`: of its graph, its clips and its joins.
/// Errors: If a join could not be judged although no clip has a fault.
pub fn every_fault(folder: &Path, flock: &Flock, decoder: &'static dyn Decoder) -> Result<Vec<Fault>, Fatal> {
    let mut faults = faults_but_jumps(folder, flock, DecoderHandle(Some(decoder)))?;
    let judgement = joins::judge_with_bar(folder, flock.manifest(), decoder);
    if faults.is_empty() {
        require_all_judged(&judgement)?;
    }
    faults.extend(judgement.jumps().map(fault_of_jump));
    Ok(faults)
}

/// Every fault of the flock in `folder`: of its size, its graph and its clips.
pub fn faults_but_jumps(folder: &Path, flock: &Flock, decoder: DecoderHandle) -> Result<Vec<Fault>, Fatal> {
    let large = file_list::too_large(folder, flock.manifest())?;
    let mut faults = clips::faults(folder, flock.manifest(), decoder)?;
    faults.splice(0..0, large.into_iter().chain(flock.faults().iter().cloned()));
    Ok(faults)
}

/// Ends the command if a join could not be judged.
pub fn require_all_judged(judgement: &Judgement) -> Result<(), Fatal> {
    let Some((join, reason)) = judgement.unjudged.first() else { return Ok(()) };
    let (before, after) = (join.before.path.clone(), join.after.path.clone());
    let unjudged = UnjudgedJoins { count: judgement.unjudged.len(), before, after, reason: reason.clone() };
    Err(Fatal::new(Exit::Unreadable, unjudged))
}

/// The fault of a join that jumps.
pub fn fault_of_jump(JudgedJoin { join, figures }: &JudgedJoin) -> Fault {
    let (before, after) = (&join.before.path, &join.after.path);
    let why = figures.worst_in_words();
    let message = format!("at sheep `{}` clip `{before}` does not meet `{after}`: {why}", join.sheep);
    Fault {
        kind: FaultKind::Jump,
        sheep: Some(join.sheep.clone()),
        from: join.between.as_ref().map(|(from, _)| from.clone()),
        to: join.between.as_ref().map(|(_, to)| to.clone()),
        clip: Some(join.clip_to_render().path.clone()),
        message,
    }
}

/// `kind: message`, the kind as in JSON.
pub fn line(fault: &Fault) -> String {
    let kind = serde_json::to_value(fault.kind).expect("a kind is a word");
    format!("{}: {}", kind.as_str().unwrap_or_default(), fault.message)
}
