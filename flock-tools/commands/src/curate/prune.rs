//! `dreams prune`: keeps the largest part in which every sheep can be reached.
//!
//! Owns the command, the form of its proposal, and what a bridge costs. The flock crate finds the parts.

use std::path::PathBuf;

use flock::{Bridge, EditError, Flock, Part, Parts, SheepId};
use operations::flock_folder::open;
use operations::program::{Exit, Fatal, print};
use operations::render::selection::usual_frames;

use super::{Answer, EditSession, balance};
use crate::ids;

/// The most parts that are printed; `--json` tells all.
const MOST_PARTS: usize = 20;

/// Keep the largest part of a flock in which every sheep can be reached, and drop the rest
///
/// Without --write it is only proposed: the sheep to keep, those to drop, and for every other part the fewest
/// transitions that would bring it in instead, with the frames to render: as many for each as the flock's transitions
/// have in the middle. One marked * cannot be rendered, because a genome is missing. Transitions that name unknown sheep
/// are dropped, and so are second definitions.
///
/// With --write the rest is dropped, in one edit; the files stay where they are, unless --delete-files is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  every sheep can be reached, or what to drop is printed, and dropped if asked
  1  no transitions lie on a cycle, so that no part can be walked; nothing was changed
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// Keep the part with this sheep, though it may not be the largest
    #[arg(long, value_name = "ID", value_parser = SheepId::new, add = ids::completer())]
    keep: Option<SheepId>,
    /// Drop the rest from the manifest
    #[arg(long)]
    write: bool,
    /// Delete the genomes and clips of what is dropped too, unless something else names them
    #[arg(long, requires = "write")]
    delete_files: bool,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct Proposal<'a> {
    #[serde(flatten)]
    edit: Answer<'a>,
    keep: &'a [SheepId],
    drop: Vec<&'a SheepId>,
    /// How many transitions are dropped.
    dropped_transitions: usize,
    /// The first sheep of every other part that has as many sheep as the one that is kept.
    ties: &'a [SheepId],
    /// The other parts, the largest first.
    parts: &'a [PartAnswer<'a>],
    /// The fewest transitions that would bring all of them in, and their frames.
    fewest_transitions: usize,
    fewest_frames: u64,
}

/// A part that is not kept.
#[derive(serde::Serialize)]
struct PartAnswer<'a> {
    sheep: &'a [SheepId],
    /// The transition from the kept part; `null` if a way leads from there already.
    entry: Option<BridgeAnswer<'a>>,
    /// The transition to the kept part; `null` if a way leads there already.
    exit: Option<BridgeAnswer<'a>>,
    /// The frames of both.
    frames: u64,
}

/// A transition that the flock lacks.
#[derive(serde::Serialize)]
struct BridgeAnswer<'a> {
    from: &'a SheepId,
    to: &'a SheepId,
    frames: u32,
    /// Whether both sheep have genomes.
    can_be_rendered: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let mut session = EditSession::start(&args.dir)?;
    let flock = Flock::new(session.manifest().clone());
    if let Some(id) = args.keep.clone().filter(|id| flock.whole().find(id).is_none()) {
        return Err(Fatal::new(Exit::Malformed, EditError::UnknownSheep { id }));
    }
    let Some(parts) = Parts::of(&flock, args.keep.as_ref()) else { return Err(open::no_cycle(&flock)) };
    session.edit(|edit| {
        edit.keep_only(&parts.kept.iter().cloned().collect());
        Ok(())
    })?;
    let dropped = flock.manifest().transitions.len() - session.manifest().transitions.len();
    let is_changed = flock.manifest() != session.manifest();
    let result = if args.write && is_changed { session.save()? } else { session.preview() };
    if args.delete_files && is_changed {
        result.delete_files()?;
    }
    let frames = usual_frames(flock.manifest());
    let answers: Vec<PartAnswer> = parts.others.iter().map(|part| PartAnswer::of(part, frames)).collect();
    let proposal = Proposal {
        edit: result.answer(),
        keep: &parts.kept,
        drop: parts.others.iter().flat_map(|part| &part.sheep).collect(),
        dropped_transitions: dropped,
        ties: &parts.ties,
        parts: &answers,
        fewest_transitions: parts.fewest,
        fewest_frames: parts.fewest as u64 * u64::from(frames),
    };
    if args.json {
        print::json(&proposal)?;
        return Ok(Exit::Fine);
    }
    print::lines(lines(&proposal, is_changed))?;
    for tie in &parts.ties {
        print::note(&format!("note: another part is as large; --keep {tie} keeps that one"));
    }
    if is_changed && !args.write {
        print::note("note: nothing was changed; --write drops the rest");
    }
    Ok(Exit::Fine)
}

/// The proposal for people.
fn lines(proposal: &Proposal, is_changed: bool) -> Vec<String> {
    let kept = proposal.keep.len();
    if !is_changed {
        return vec![format!("nothing to drop: each of {kept} sheep can be reached from every other")];
    }
    let verbs = if proposal.edit.changed { ["kept", "dropped"] } else { ["keep", "drop"] };
    let mut lines = vec![
        format!("{} {kept} sheep: each can be reached from every other", verbs[0]),
        format!(
            "{} {} sheep and {}",
            verbs[1],
            proposal.drop.len(),
            print::count(proposal.dropped_transitions, "transition")
        ),
        balance(proposal.edit.worst_ratio_before, proposal.edit.worst_ratio_after),
    ];
    if proposal.parts.is_empty() {
        return lines;
    }
    lines.push(String::new());
    let shown: Vec<&PartAnswer> = proposal.parts.iter().take(MOST_PARTS).collect();
    let told = |bridge: &Option<BridgeAnswer>| bridge.as_ref().map_or("-".to_owned(), BridgeAnswer::told);
    let rows: Vec<[String; 3]> =
        shown.iter().map(|part| [part.sheep[0].to_string(), told(&part.entry), told(&part.exit)]).collect();
    let wide = |column: usize, head: &str| rows.iter().map(|row| row[column].len()).chain([head.len()]).max();
    let [a, b, c] = [(0, "part with"), (1, "way in"), (2, "way out")].map(|(at, head)| wide(at, head).unwrap_or(0));
    lines.push(format!("{:<a$} {:>6} {:<b$} {:<c$} {:>8}", "part with", "sheep", "way in", "way out", "frames"));
    lines.extend(rows.iter().zip(&shown).map(|([first, entry, exit], part)| {
        format!("{first:<a$} {:>6} {entry:<b$} {exit:<c$} {:>8}", part.sheep.len(), part.frames)
    }));
    if let Some(more) = proposal.parts.len().checked_sub(MOST_PARTS).filter(|more| *more > 0) {
        lines.push(format!("and {more} more, which --json tells"));
    }
    lines.push(format!(
        "All of them together would come in by {}, {} frames.",
        print::count(proposal.fewest_transitions, "transition"),
        proposal.fewest_frames
    ));
    lines
}

impl<'a> PartAnswer<'a> {
    fn of(part: &'a Part, frames: u32) -> Self {
        let of = |bridge: &'a Bridge| {
            let Bridge { from, to, can_be_rendered } = bridge;
            BridgeAnswer { from, to, frames, can_be_rendered: *can_be_rendered }
        };
        let (entry, exit) = (part.entry.as_ref().map(of), part.exit.as_ref().map(of));
        let frames = [&entry, &exit].into_iter().flatten().map(|bridge| u64::from(bridge.frames)).sum();
        Self { sheep: &part.sheep, entry, exit, frames }
    }
}

impl BridgeAnswer<'_> {
    fn told(&self) -> String {
        format!("{} to {}{}", self.from, self.to, if self.can_be_rendered { "" } else { " *" })
    }
}
