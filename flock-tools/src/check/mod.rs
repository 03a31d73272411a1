//! `dreams check`: the faults of a flock.
//!
//! Owns the command and its answer. The flock crate finds the faults of the graph, `clips.rs` those of the clips,
//! `joins/` the joins that jump.

pub(crate) mod clips;

use std::path::{Path, PathBuf};

use flock::{ClipPath, Fault, FaultKind, Flock, forced_repeats};

use crate::decoder::{Decoder, DecoderHandle};
use crate::flock_folder::{file_list, open};
use crate::joins::{self, Figures, JudgedJoin, Judgement};
use crate::program::{Exit, Fatal, print};

/// Tell every fault of a flock: names, graph and clips
///
/// Every clip is opened, compared with the manifest and decoded from end to end. With --joins, the end of every clip is
/// played into every clip that may follow it, and every join that does not meet, in value or in velocity, is named with
/// figures. A flock is `large` if its manifest, or the list of its files, is more than a unit has the memory for.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the flock has no fault
  1  faults were found; each is named with its kind
  2  the command line or the manifest is wrong
  3  the manifest could not be read, or the answer or the contact sheet not written")]
pub(crate) struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// Judge every join too
    #[arg(long)]
    joins: bool,
    /// Draw the frames around the worst joins, side by side, into this PNG file
    #[arg(long, value_name = "FILE", requires = "joins")]
    contact_sheet: Option<PathBuf>,
    /// Answer with one JSON document: {"ok": ..., "faults": [...]}
    #[arg(long)]
    json: bool,
}

#[derive(serde::Serialize)]
struct Answer<'a> {
    ok: bool,
    faults: FaultList<'a>,
}

/// The faults in the answer: those that are no jumps, and the jumps. Each is put into its form as it is written: a large
/// flock may have a million.
struct FaultList<'a>(&'a [Fault], &'a [(Fault, JoinAnswer)]);

/// A fault in the answer: with the figures of its join, if it is a jump.
#[derive(serde::Serialize)]
struct FaultAnswer<'a> {
    #[serde(flatten)]
    fault: &'a Fault,
    #[serde(flatten)]
    join: Option<&'a JoinAnswer>,
}

/// The part of the answer that only a `jump` has.
#[derive(serde::Serialize)]
struct JoinAnswer {
    /// The clip that ends.
    before: ClipPath,
    /// The clip that begins.
    after: ClipPath,
    #[serde(flatten)]
    figures: Figures,
}

impl serde::Serialize for FaultList<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let others = self.0.iter().map(|fault| FaultAnswer { fault, join: None });
        serializer.collect_seq(others.chain(self.1.iter().map(|(fault, join)| FaultAnswer { fault, join: Some(join) })))
    }
}

/// Joins that could not be judged although no clip has a fault: the machine failed.
#[derive(Debug, thiserror::Error)]
#[error("cannot judge {count} joins, `{before}` into `{after}` first: {reason}")]
struct UnjudgedJoins {
    count: usize,
    before: ClipPath,
    after: ClipPath,
    reason: String,
}

/// Runs the command.
pub(crate) fn run(args: &Args, decoder: DecoderHandle) -> Result<Exit, Fatal> {
    let flock = Flock::new(open::manifest(&args.dir)?);
    let manifest = flock.manifest();
    let faults = faults_but_jumps(&args.dir, &flock, decoder)?;
    let mut jumps = Vec::new();
    if args.joins {
        let decoder = decoder.get()?;
        let judgement = joins::judge_with_bar(&args.dir, manifest, decoder);
        if faults.is_empty() {
            require_all_judged(&judgement)?;
        }
        jumps.extend(judgement.jumps().map(jump));
        if let Some(sheet) = &args.contact_sheet {
            let drawn = joins::draw(&args.dir, manifest, &judgement, sheet, decoder);
            drawn.map_err(|error| Fatal::new(Exit::Unreadable, error))?;
        }
    }
    note_forced_repeats(&flock);
    let count = faults.len() + jumps.len();
    if args.json {
        print::json(&Answer { ok: count == 0, faults: FaultList(&faults, &jumps) })?;
    } else {
        print::lines(faults.iter().chain(jumps.iter().map(|(fault, _)| fault)).map(line))?;
        print::note(&print::count(count, "fault"));
    }
    Ok(if count == 0 { Exit::Fine } else { Exit::No })
}

/// Every fault of the flock in `folder`: of its graph, its clips and its joins.
/// Errors: If a join could not be judged although no clip has a fault.
pub(crate) fn every_fault(folder: &Path, flock: &Flock, decoder: &'static dyn Decoder) -> Result<Vec<Fault>, Fatal> {
    let mut faults = faults_but_jumps(folder, flock, DecoderHandle(Some(decoder)))?;
    let judgement = joins::judge_with_bar(folder, flock.manifest(), decoder);
    if faults.is_empty() {
        require_all_judged(&judgement)?;
    }
    faults.extend(judgement.jumps().map(|join| jump(join).0));
    Ok(faults)
}

/// The fault of a join that jumps.
pub(crate) fn fault_of_jump(join: &JudgedJoin) -> Fault {
    jump(join).0
}

/// Every fault of the flock in `folder`: of its size, its graph and its clips.
fn faults_but_jumps(folder: &Path, flock: &Flock, decoder: DecoderHandle) -> Result<Vec<Fault>, Fatal> {
    let large = file_list::too_large(folder, flock.manifest())?;
    let mut faults = clips::faults(folder, flock.manifest(), decoder)?;
    faults.splice(0..0, large.into_iter().chain(flock.faults().iter().cloned()));
    Ok(faults)
}

/// Ends the command if a join could not be judged.
fn require_all_judged(judgement: &Judgement) -> Result<(), Fatal> {
    let Some((join, reason)) = judgement.unjudged.first() else { return Ok(()) };
    let (before, after) = (join.before.path.clone(), join.after.path.clone());
    let unjudged = UnjudgedJoins { count: judgement.unjudged.len(), before, after, reason: reason.clone() };
    Err(Fatal::new(Exit::Unreadable, unjudged))
}

/// The fault of a join that jumps, with its figures.
fn jump(JudgedJoin { join, figures }: &JudgedJoin) -> (Fault, JoinAnswer) {
    let (before, after) = (join.before.path.clone(), join.after.path.clone());
    let why = figures.worst_in_words();
    let message = format!("at sheep `{}` clip `{before}` does not meet `{after}`: {why}", join.sheep);
    let fault = Fault {
        kind: FaultKind::Jump,
        sheep: Some(join.sheep.clone()),
        from: join.between.as_ref().map(|(from, _)| from.clone()),
        to: join.between.as_ref().map(|(_, to)| to.clone()),
        clip: Some(join.clip_to_render().path.clone()),
        message,
    };
    (fault, JoinAnswer { before, after, figures: *figures })
}

/// `kind: message`, the kind as in JSON.
pub(crate) fn line(fault: &Fault) -> String {
    let kind = serde_json::to_value(fault.kind).expect("a kind is a word");
    format!("{}: {}", kind.as_str().unwrap_or_default(), fault.message)
}

/// Notes on stderr where the graph makes the walk repeat itself. That is no fault.
fn note_forced_repeats(flock: &Flock) {
    let single = forced_repeats(flock.graph());
    if let Some(first) = single.first() {
        print::note(&format!(
            "note: {} of {} sheep have a single transition that leaves them, `{first}` first: what follows them is always \
             the same",
            single.len(),
            flock.graph().len()
        ));
    }
}
