//! `flock check`: is this flock fit to be shown?
//!
//! Owns the command and its answer. What the graph lacks is found by the flock crate, what the clips lack by
//! `clips.rs`, how the clips meet by `joins/`.

use std::path::{Path, PathBuf};

use flock::{ClipPath, Fault, FaultKind, Flock, forced_repeats};

use crate::bundles::listing;
use crate::clips;
use crate::decoder::Video;
use crate::joins::{self, Figures, Join, Judged};
use crate::open;
use crate::report::{self, Exit, Fatal};

/// Tell every fault of a flock: names, graph and clips
///
/// Every clip is opened, compared with the manifest and decoded from end to end. With --joins, the end of every clip is
/// played into every clip that may follow it, and what does not meet, in value or in velocity, is named with figures. A
/// flock is `large` if its manifest, or the list of its files, is more than a unit has the memory for.
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
struct Answer {
    ok: bool,
    faults: Vec<Told>,
}

/// A fault as it is told: with the figures of its join, where it is one.
#[derive(serde::Serialize)]
struct Told {
    #[serde(flatten)]
    fault: Fault,
    #[serde(flatten)]
    join: Option<Meeting>,
}

/// What a `jump` tells besides.
#[derive(serde::Serialize)]
struct Meeting {
    /// The clip that ends.
    before: ClipPath,
    /// The clip that begins.
    after: ClipPath,
    #[serde(flatten)]
    figures: Figures,
}

/// Joins that could not be judged although no clip has a fault: the machine's doing.
#[derive(Debug, thiserror::Error)]
#[error("cannot judge {count} joins, `{before}` into `{after}` first: {reason}")]
struct Unseen {
    count: usize,
    before: ClipPath,
    after: ClipPath,
    reason: String,
}

/// Runs the command.
pub(crate) fn run(args: &Args, video: Video) -> Result<Exit, Fatal> {
    let flock = Flock::new(open::manifest(&args.dir)?);
    let manifest = flock.manifest();
    let of_graph = listing::too_large(&args.dir, manifest)?.into_iter().chain(flock.faults().iter().cloned());
    let plain = |fault| Told { fault, join: None };
    let mut found: Vec<Told> = of_graph.chain(clips::faults(&args.dir, manifest, video)?).map(plain).collect();
    if args.joins {
        let decoder = video.decoder()?;
        let judged = decoder.judge(&args.dir, manifest);
        if found.is_empty() {
            all_seen(&judged)?;
        }
        found.extend(judged.jumps().map(told));
        if let Some(sheet) = &args.contact_sheet {
            let drawn = joins::draw(&args.dir, manifest, &judged, sheet, decoder);
            drawn.map_err(|error| Fatal::new(Exit::Unreadable, error))?;
        }
    }
    tell_forced_repeats(&flock);
    let exit = if found.is_empty() { Exit::Fine } else { Exit::No };
    if args.json {
        report::json(&Answer { ok: found.is_empty(), faults: found })?;
    } else {
        report::lines(found.iter().map(|told| line(&told.fault)))?;
        report::note(&report::count(found.len(), "fault"));
    }
    Ok(exit)
}

/// Every fault of the flock in `folder`: of its graph, its clips and its joins.
///
/// # Errors
/// If a join could not be judged although no clip has a fault.
pub(crate) fn every_fault(folder: &Path, flock: &Flock) -> Result<Vec<Fault>, Fatal> {
    let manifest = flock.manifest();
    let mut found: Vec<Fault> = listing::too_large(folder, manifest)?.into_iter().collect();
    found.extend(flock.faults().iter().cloned());
    found.extend(clips::faults(folder, manifest, Video::here())?);
    let judged = joins::judge_with_bar(folder, manifest);
    if found.is_empty() {
        all_seen(&judged)?;
    }
    found.extend(judged.jumps().map(|join| told(join).fault));
    Ok(found)
}

/// That every join was judged.
fn all_seen(judged: &Judged) -> Result<(), Fatal> {
    let Some((place, reason)) = judged.unseen.first() else { return Ok(()) };
    let (before, after) = (place.before.path.clone(), place.after.path.clone());
    let unseen = Unseen { count: judged.unseen.len(), before, after, reason: reason.clone() };
    Err(Fatal::new(Exit::Unreadable, unseen))
}

/// The fault of a join that jumps.
fn told(join: &Join) -> Told {
    let Join { place, figures } = join;
    let (before, after) = (place.before.path.clone(), place.after.path.clone());
    let message = format!("at sheep `{}` clip `{before}` does not meet `{after}`: {}", place.sheep, figures.told());
    let fault = Fault {
        kind: FaultKind::Jump,
        sheep: Some(place.sheep.clone()),
        from: place.between.as_ref().map(|(from, _)| from.clone()),
        to: place.between.as_ref().map(|(_, to)| to.clone()),
        clip: Some(place.transition().path.clone()),
        message,
    };
    Told { fault, join: Some(Meeting { before, after, figures: *figures }) }
}

/// `kind: message`, the kind as in JSON.
pub(crate) fn line(fault: &Fault) -> String {
    let kind = serde_json::to_value(fault.kind).expect("a kind is a word");
    format!("{}: {}", kind.as_str().unwrap_or_default(), fault.message)
}

/// Where the flock's own shape makes the walk repeat itself. Not a fault, so it is said on stderr.
fn tell_forced_repeats(flock: &Flock) {
    let single = forced_repeats(flock.graph());
    if let Some(first) = single.first() {
        report::note(&format!(
            "note: {} of {} sheep have a single transition that leaves them, `{first}` first: what follows them is always \
             the same",
            single.len(),
            flock.graph().len()
        ));
    }
}
