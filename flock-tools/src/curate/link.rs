//! `dreams link`: adds transitions.
//!
//! Owns the command. The clips may be there already, or `dreams render` makes them later.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use ::species::Genome;
use flame::Backend;
use flock::{MAX_FRAMES, SheepId, Transition};

use super::EditSession;
use super::files::{self, FileCopy};
use super::selection::{Chosen, FORM, Pairs, Selector};
use crate::decoder::DecoderHandle;
use crate::flock_folder::{ids, paths};
use crate::program::{Exit, Fatal, arguments, print};
use crate::species;

/// Frames of a transition that is yet to be rendered, by default.
pub(crate) const FRAMES: u32 = flock::paths::TRANSITION_FRAMES;

/// Add transitions from sheep to sheep
///
/// With --clip, the clip is copied into the flock's folder if it is in the flock's form, and its hash is written into
/// the manifest. Without, the manifest names its path, and `dreams render` makes it from both genomes; where these have too
/// little in common, as two of different species have, it dissolves the pictures of both loops. Of several sheep,
/// every one of the first word is linked to every one of the others; of globs, pairs that have a transition, and those of
/// a sheep with itself, are passed over.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the transitions are in the flock
  1  the clip is not in the flock's form, or another file is in its place; nothing was changed
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub(crate) struct Args {
    /// Folder of the flock
    dir: PathBuf,
    #[arg(help = format!("The sheep where they start: {FORM}"), value_parser = Selector::parse, add = ids::completer())]
    from: Selector,
    #[arg(required = true, help = "The sheep where they end, in the same form; the same one is allowed")]
    #[arg(value_parser = Selector::parse, add = ids::completer())]
    to: Vec<Selector>,
    /// The clip of a single transition, in the flock's form
    #[arg(long, value_name = "FILE")]
    clip: Option<PathBuf>,
    #[arg(long, value_name = "N", conflicts_with = "clip")]
    #[arg(help = format!("Frames of a clip that is yet to be rendered [default: {FRAMES}]"))]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_FRAMES)))]
    frames: Option<u32>,
    /// How readily the walk takes them, relative to the others from the same sheep
    #[arg(long, value_name = "W", default_value_t = 1.0, allow_negative_numbers = true, value_parser = arguments::positive)]
    weight: f64,
    /// Replace another file that is in the clip's place
    #[arg(long)]
    force: bool,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// A clip for more than one transition.
#[derive(Debug, thiserror::Error)]
#[error("clip `{clip}` is for one transition, found {found}")]
struct SeveralPairs {
    clip: PathBuf,
    found: usize,
}

/// Runs the command.
pub(crate) fn run(args: &Args, decoder: DecoderHandle) -> Result<Exit, Fatal> {
    let mut session = EditSession::start(&args.dir)?;
    let from = Chosen::of([&args.from], session.manifest())?;
    let to = Chosen::of(&args.to, session.manifest())?;
    let chosen = Pairs::unlinked(&from, &to, session.manifest())?;
    if let Some(clip) = args.clip.clone().filter(|_| chosen.pairs.len() > 1) {
        return Err(Fatal::new(Exit::Malformed, SeveralPairs { clip, found: chosen.pairs.len() }));
    }
    let request = files::ClipRequest { file: args.clip.as_deref(), frames: args.frames, default_frames: FRAMES };
    let (mut done, mut copies) = (String::new(), Vec::new());
    for (from, to) in &chosen.pairs {
        let place = |ending: &str| paths::of_transition(from, to, ending);
        let (clip, copy) = files::clip(&session, &request, place, decoder)?;
        done = format!("linked `{from}` to `{to}`: `{}`, {} frames", clip.path, clip.frames);
        let transition = Transition { from: from.clone(), to: to.clone(), clip, weight: args.weight };
        session.edit(|edit| edit.add_transition(transition))?;
        copies.extend(copy);
    }
    if chosen.single().is_none() {
        done = format!("linked {}", print::count(chosen.pairs.len(), "pair"));
    }
    if chosen.passed_over > 0 {
        let pairs = print::count(chosen.passed_over, "pair");
        print::note(&format!("note: {pairs} passed over: linked already, or a sheep with itself"));
    }
    if args.clip.is_none() {
        tell_dissolves(&session, &chosen.pairs);
    }
    FileCopy::run_all(copies.into_iter(), &args.dir, args.force)?;
    session.save()?.print(&done, args.json)
}

/// Tells which of `pairs` have so little in common that their pictures are dissolved. Genomes that are missing or cannot be
/// read tell nothing: `dreams render` names them.
fn tell_dissolves(session: &EditSession, pairs: &BTreeSet<(SheepId, SheepId)>) {
    let manifest = session.manifest();
    let read = |id: &SheepId| {
        let sheep = manifest.sheep.iter().find(|sheep| sheep.id == *id)?;
        species::read(&sheep.genome.as_ref()?.inside(&session.folder), &Backend::default()).ok()
    };
    let mut genomes: BTreeMap<&SheepId, Option<Box<dyn Genome>>> = BTreeMap::new();
    for id in pairs.iter().flat_map(|(from, to)| [from, to]) {
        genomes.entry(id).or_insert_with(|| read(id));
    }
    let size = [manifest.size.0, manifest.size.1];
    let is_dissolve = |(from, to): &&(SheepId, SheepId)| {
        let (Some(from), Some(to)) = (&genomes[from], &genomes[to]) else { return false };
        from.transition(&**to, size, [f64::from(FRAMES); 2], f64::from(FRAMES)).is_none()
    };
    let dissolves: Vec<_> = pairs.iter().filter(is_dissolve).collect();
    match dissolves[..] {
        [] => {}
        [(from, to)] => print::note(&format!(
            "note: the genomes of `{from}` and `{to}` have too little in common: their pictures are dissolved"
        )),
        _ => print::note(&format!(
            "note: {} have too little in common: their pictures are dissolved",
            print::count(dissolves.len(), "pair")
        )),
    }
}
