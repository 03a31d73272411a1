//! `dreams link`: adds transitions.
//!
//! Owns the command. The clips may be there already, or `dreams render` makes them later.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use flame::Backend;
use flock::{MAX_FRAMES, SheepId, Transition};
use operations::decoder::DecoderHandle;
use operations::flock_folder::paths;
use operations::program::{Exit, Fatal, print};
use operations::render::plan::{Look, SheepMotion};
use operations::render::selection::usual_turn;
use operations::species;
use video::Form;

use super::EditSession;
use super::files::{self, FileCopy};
use super::selection::{Chosen, FORM, Pairs, Selector};
use crate::arguments;
use crate::ids;

/// Frames of a transition that is yet to be rendered, by default.
pub(crate) const FRAMES: u32 = flock::paths::TRANSITION_FRAMES;

/// Add transitions from sheep to sheep
///
/// With --clip, the clip is copied into the flock's folder if it is in the flock's form, and its hash is written into
/// the manifest. Without, the manifest names its path, and `dreams render` makes it from both genomes; where these have
/// no good transition, as two of different species never have, it dissolves the pictures of both loops. Of several sheep,
/// every one of the first word is linked to every one of the others; of globs, pairs that have a transition, and those of
/// a sheep with itself, are passed over.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the transitions are in the flock
  1  the clip is not in the flock's form, or another file is in its place; nothing was changed
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub struct Args {
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
pub fn run(args: &Args, decoder: DecoderHandle) -> Result<Exit, Fatal> {
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
    FileCopy::run_all(copies.into_iter(), &mut session, args.force)?;
    session.save()?.print(&done, args.json)
}

/// Tells which of `pairs` are dissolves of both loops' pictures, as `dreams render` will make them.
fn tell_dissolves(session: &EditSession, pairs: &BTreeSet<(SheepId, SheepId)>) {
    match &dissolves(session, pairs)[..] {
        [] => {}
        [Transition { from, to, .. }] => print::note(&format!(
            "note: from `{from}` to `{to}` the pictures of both loops are dissolved: their genomes have no better transition"
        )),
        several => print::note(&format!(
            "note: in {} the pictures of both loops are dissolved: their genomes have no better transitions",
            print::count(several.len(), "transition")
        )),
    }
}

/// The transitions of `pairs` that are dissolves of both loops' pictures. Genomes that are missing or cannot be read tell
/// nothing: `dreams render` names them.
fn dissolves<'s>(session: &'s EditSession, pairs: &BTreeSet<(SheepId, SheepId)>) -> Vec<&'s Transition> {
    let manifest = session.manifest();
    let (look, usual) = (Look::of_genomes(Form { size: manifest.size, fps: manifest.fps }), usual_turn(manifest));
    let read = |id: &SheepId| {
        let sheep = manifest.sheep.iter().find(|sheep| sheep.id == *id)?;
        let genome = species::read(&sheep.genome.as_ref()?.inside(&session.folder), &Backend::default()).ok()?;
        Some(SheepMotion::new(genome, sheep.clip.as_ref().map_or(usual, |clip| clip.frames)))
    };
    let mut sheep: BTreeMap<&SheepId, Option<SheepMotion>> = BTreeMap::new();
    for id in pairs.iter().flat_map(|(from, to)| [from, to]) {
        sheep.entry(id).or_insert_with(|| read(id));
    }
    let is_dissolve = |pair: &&Transition| {
        let [Some(from), Some(to)] = [&pair.from, &pair.to].map(|id| sheep.get(id).and_then(Option::as_ref)) else {
            return false;
        };
        from.is_dissolved_to(to, pair.clip.frames, &look)
    };
    let added = manifest.transitions.iter().filter(|it| pairs.contains(&(it.from.clone(), it.to.clone())));
    added.filter(is_dissolve).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use operations::flock_folder::open;
    use operations::render::selection::{Request, Scope, Selection};
    use std::fmt::Write;
    use std::fs;

    /// Whether a genetic dissolve of these two keeps its contrast depends on how far both loops turn meanwhile.
    const PAIR: [(&str, &str); 2] = [("a", "0.837"), ("b", "1.084")];

    #[test]
    fn what_is_told_of_a_new_transition_is_what_is_rendered() {
        let mut told = Vec::new();
        for (turn, frames) in [(384, 384), (30, 45)] {
            let folder = tempfile::tempdir().unwrap();
            let mut text = "format = 1\nname = \"two\"\nsize = [64, 36]\nfps = [30, 1]\n".to_owned();
            for (id, far) in PAIR {
                let picture = format!("(+ (warp-abs (wave 1 .081) {far} (wave 3 .655)) y)");
                fs::write(folder.path().join(format!("{id}.expr")), format!("(expression 1 (picture {picture}))"))
                    .unwrap();
                write!(
                    text,
                    "[[sheep]]\nid = \"{id}\"\nframes = {turn}\nclip = \"{id}.mp4\"\ngenome = \"{id}.expr\"\n"
                )
                .unwrap();
            }
            write!(text, "[[transition]]\nfrom = \"a\"\nto = \"b\"\nframes = {frames}\nclip = \"t.mp4\"\n").unwrap();
            fs::write(folder.path().join(flock::FILE_NAME), text).unwrap();
            let pairs = BTreeSet::from([(SheepId::new("a").unwrap(), SheepId::new("b").unwrap())]);
            let session = EditSession::start(folder.path()).unwrap();
            let manifest = open::manifest(folder.path()).unwrap();
            let look = Look::of_genomes(Form { size: manifest.size, fps: manifest.fps });
            let request = Request { sheep: &[], scope: Scope::All };
            let selection = Selection::new(folder.path(), &manifest, &request, &look, &Backend::default()).unwrap();
            let rendered = selection.clips.iter().filter(|clip| clip.is_dissolve).count();
            assert_eq!(dissolves(&session, &pairs).len(), rendered, "{frames} frames");
            told.push(rendered);
        }
        assert_eq!(told, [0, 1]);
    }
}
