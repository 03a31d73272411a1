//! `dreams list`: the sheep of a flock, all or those that some filters keep.
//!
//! Owns the command, the filters and the form of its answer. The flock crate knows what is played and how often, the
//! credits know the licences; whether a loop is rendered is seen by its file. Never opens a clip.
//!
//! Start at [`Filters`].

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use flock::{ClipPath, Flock, FlockShares, Manifest, Measure, SheepId, SheepIx};
use operations::check::genomes::{self, UndrawnGenome};
use operations::credits::FlockCredits;
use operations::flock_folder::open;
use operations::program::{Exit, Fatal, print};

use super::selection::{Chosen, FORM, Selector};
use crate::arguments;
use crate::ids;

/// List the sheep of a flock: all, or those that the filters keep
///
/// Of several filters all must hold. With --ids only the ids are printed, one a line, as `dreams drop` and `dreams want`
/// take them: dreams list my-flock --loose --ids | xargs dreams drop my-flock
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the sheep are printed, however many they are
  1  does not occur
  2  the command line, the manifest or, with --licence, credits.toml is wrong
  3  a file could not be read or written")]
pub struct Args {
    /// Folder of the flock
    dir: PathBuf,
    #[arg(value_name = "ID", help = format!("Only these sheep: {FORM}"))]
    #[arg(value_parser = Selector::parse, add = ids::completer())]
    ids: Vec<Selector>,
    #[command(flatten)]
    filters: Filters,
    /// What shares and wants are compared in
    #[arg(long, value_name = "MEASURE", default_value = "visits")]
    by: arguments::By,
    /// Print only the ids, one a line
    #[arg(long = "ids", conflicts_with = "json")]
    ids_only: bool,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// Which sheep are listed.
#[derive(Debug, clap::Args)]
#[expect(clippy::struct_excessive_bools, reason = "independent switches")]
struct Filters {
    /// Sheep that cannot be reached from the part that is played
    #[arg(long)]
    unreachable: bool,
    /// Sheep that are never shown: unreachable, or without a way back
    #[arg(long)]
    unplayed: bool,
    /// Sheep without a transition that leads to them, or without one that leaves them
    #[arg(long)]
    loose: bool,
    /// Sheep whose loop is not there yet
    #[arg(long)]
    unrendered: bool,
    /// Sheep whose share is less than R times their want
    #[arg(long, value_name = "R", value_parser = arguments::positive)]
    below: Option<f64>,
    /// Sheep whose share is more than R times their want
    #[arg(long, value_name = "R", value_parser = arguments::positive)]
    above: Option<f64>,
    /// Sheep under this licence, as cc-by-nc or CC-BY-NC-3.0; none for those without one
    #[arg(long)]
    licence: Option<String>,
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct Answer<'f> {
    sheep: Vec<Row<'f>>,
    /// How many sheep the flock has.
    of: usize,
}

/// One sheep.
#[derive(serde::Serialize)]
struct Row<'f> {
    id: &'f SheepId,
    /// Its fractions of all visits, and of the time in which loops are shown; 0 if it is never shown.
    visits: f64,
    time: f64,
    /// Its part of the wants of all sheep, and of all with a loop.
    want: f64,
    time_want: f64,
    /// Its share divided by its want, in the measure that was asked for; `null` if it has no time to want.
    ratio: Option<f64>,
    repeat: u32,
    /// Those of its loop; `null` without one.
    frames: Option<u32>,
    clip: Option<&'f ClipPath>,
    genome: Option<&'f ClipPath>,
    /// What of its genome is not drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    undrawn: Option<UndrawnGenome>,
    /// Whether its loop is there; `null` without one.
    rendered: Option<bool>,
    /// How many transitions lead to it and leave it.
    entries: usize,
    exits: usize,
    /// Whether it can be reached from the part that is played, and whether it is played.
    reachable: bool,
    played: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let flock = Flock::new(open::manifest(&args.dir)?);
    let chosen = if args.ids.is_empty() { None } else { Some(Chosen::of(&args.ids, flock.manifest())?.sheep) };
    let is_chosen = |row: &Row| chosen.as_ref().is_none_or(|ids: &BTreeSet<SheepId>| ids.contains(row.id));
    let licensed = args.filters.licensed(&args.dir, flock.manifest())?;
    let is_licensed = |row: &Row| licensed.as_ref().is_none_or(|ids| ids.contains(row.id));
    let all = rows(&flock, &args.dir, args.by.into());
    let of = all.len();
    let sheep: Vec<Row> =
        all.into_iter().filter(|row| is_chosen(row) && is_licensed(row) && args.filters.keep(row)).collect();
    if args.json {
        print::json(&Answer { sheep, of })?;
    } else if args.ids_only {
        print::lines(sheep.iter().map(|row| row.id.to_string()))?;
    } else {
        let count = format!("{} of {of} sheep", sheep.len());
        print::lines(table(&sheep, args.by.into()))?;
        print::note(&count);
        for sentence in sheep.iter().filter_map(|row| row.undrawn.as_ref()).flat_map(UndrawnGenome::sentences) {
            print::note(&format!("note: {sentence}"));
        }
    }
    Ok(Exit::Fine)
}

impl Filters {
    /// The sheep under the licence that is asked for; `None` if none is.
    /// Errors: If `credits.toml` is malformed.
    fn licensed<'f>(&self, dir: &Path, manifest: &'f Manifest) -> Result<Option<BTreeSet<&'f SheepId>>, Fatal> {
        let Some(licence) = &self.licence else { return Ok(None) };
        let credits = FlockCredits::of_licences(dir, manifest)?;
        let sheep = manifest.sheep.iter().zip(&credits.sheep).filter(|(_, credit)| credit.is_under(licence));
        Ok(Some(sheep.map(|(sheep, _)| &sheep.id).collect()))
    }

    /// Whether `row` is listed, as far as its licence is not asked for.
    fn keep(&self, row: &Row) -> bool {
        let ratio = |holds: &dyn Fn(f64) -> bool| row.ratio.is_some_and(holds);
        (!self.unreachable || !row.reachable)
            && (!self.unplayed || !row.played)
            && (!self.loose || row.entries == 0 || row.exits == 0)
            && (!self.unrendered || row.rendered == Some(false))
            && self.below.is_none_or(|most| ratio(&|ratio| ratio < most))
            && self.above.is_none_or(|least| ratio(&|ratio| ratio > least))
    }
}

/// Every sheep of `flock`, whose folder is `folder`, in the order of their ids.
fn rows<'f>(flock: &'f Flock, folder: &Path, by: Measure) -> Vec<Row<'f>> {
    let (whole, manifest) = (flock.whole(), flock.manifest());
    let shares = FlockShares::of(flock);
    let reached = flock.reached();
    let mut entries = vec![0; whole.len()];
    whole.sheep().flat_map(|at| whole.exits(at)).for_each(|exit| entries[whole.target(exit).index()] += 1);
    let undrawn = genomes::undrawn(folder, manifest).into_iter().map(|genome| (genome.sheep.clone(), genome));
    let mut undrawn: HashMap<SheepId, UndrawnGenome> = undrawn.collect();
    let row = |at: SheepIx| {
        let written = &manifest.sheep[whole.sheep_in_manifest(at)];
        let share = shares.as_ref().map(|shares| &shares.sheep[at.index()]);
        let clip = written.clip.as_ref();
        let (part, want) = share.map_or((0.0, 0.0), |share| share.share_and_want(by));
        Row {
            id: whole.id(at),
            visits: share.map_or(0.0, |share| share.visits),
            time: share.map_or(0.0, |share| share.time),
            want: share.map_or(0.0, |share| share.want),
            time_want: share.map_or(0.0, |share| share.time_want),
            ratio: (want > 0.0).then(|| part / want),
            repeat: written.repeat,
            frames: clip.map(|clip| clip.frames.0),
            clip: clip.map(|clip| &clip.path),
            genome: written.genome.as_ref(),
            undrawn: undrawn.remove(whole.id(at)),
            rendered: clip.map(|clip| clip.path.inside(folder).is_file()),
            entries: entries[at.index()],
            exits: whole.exits(at).len(),
            reachable: reached[at.index()],
            played: flock.is_walkable() && flock.graph().find(whole.id(at)).is_some(),
        }
    };
    whole.sheep().map(row).collect()
}

fn table(sheep: &[Row], by: Measure) -> Vec<String> {
    let wide = print::widest(sheep.iter().map(|row| row.id));
    let share = if by == Measure::Time { "time" } else { "visits" };
    let mut lines = vec![format!(
        "{:<wide$} {share:>9} {:>9} {:>8} {:>4} {:>4} {:>7}  loop",
        "sheep", "want", "ratio", "in", "out", "repeat"
    )];
    let row = |row: &Row| {
        let (part, want) = if by == Measure::Time { (row.time, row.time_want) } else { (row.visits, row.want) };
        let ratio = row.ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.3}"));
        let own = match (row.rendered, row.frames) {
            (Some(true), Some(frames)) => format!("{frames} frames"),
            (Some(false), Some(frames)) => format!("{frames} frames, not rendered"),
            (None, _) | (_, None) => "none".to_owned(),
        };
        let drawn = match &row.undrawn {
            Some(genome) if genome.unusable.is_some() => "; its genome is unusable",
            Some(genome) if !genome.refused.is_empty() => "; its genome cannot be drawn",
            Some(_) => "; its genome is drawn in part",
            None => "",
        };
        let never = if row.played {
            ""
        } else if row.reachable {
            "; no way back"
        } else {
            "; unreachable"
        };
        format!(
            "{:<wide$} {:>8.3}% {:>8.3}% {ratio:>8} {:>4} {:>4} {:>7}  {own}{drawn}{never}",
            row.id.as_str(),
            100.0 * part,
            100.0 * want,
            row.entries,
            row.exits,
            row.repeat
        )
    };
    lines.extend(sheep.iter().map(row));
    lines
}
