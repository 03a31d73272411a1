//! `dreams report DIR`: a flock as one page to look at.
//!
//! Owns the command: its options, what is written where, and how it ends. `facts.rs` has the page's document, `html.rs` makes
//! the file, `sheet/` is the code in it; `dot.rs` and `graphml.rs` write the graph alone for other programs.
//!
//! Start at [`run`].

mod balance;
mod colour;
mod dot;
mod facts;
mod graphml;
mod html;
mod joins;
mod layout;
mod picture;
mod suggestions;
mod walk;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use flock::{Fault, Flock, Sheep, SheepIx};

use crate::decoder::{Decoder, DecoderHandle};
use crate::flock_folder::open;
use crate::program::{Exit, Fatal, print};
use balance::BalancedShares;
use facts::{Facts, Figures, PageSources, distinct_clips};
use joins::Joins;
use picture::Picture;
use suggestions::SuggestionList;
use walk::WalkSample;

/// The default name of the page.
const FILE_NAME: &str = "report.html";

/// Draw a flock as one page to look at: its graph, its shares, a day of its walk, its joins
///
/// One HTML file that needs nothing else, opens offline, and can be sent to anyone. Sheep stay where they were in the
/// last report, or close by: a transition added or removed hardly moves them, weights and wants do not. It works
/// without any clip, too. If there are clips, every join is judged as `dreams check --joins` does it, and the worst are
/// shown: for this the end and a few first frames of each clip are decoded.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the report is written
  1  the report is written, and the flock has faults, which are listed at its top
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
#[expect(clippy::struct_excessive_bools, reason = "independent switches")]
pub(crate) struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// The file to write; if not given, report.html in the folder, and stdout for --dot and --graphml
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Which of the endless walks to show a day of
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Do not judge the joins, which decodes the ends of all clips
    #[arg(long)]
    no_joins: bool,
    /// Only what the manifest tells; no clip is opened
    #[arg(long)]
    no_pictures: bool,
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(0..=1000))]
    #[arg(help = format!(
        "List up to K transitions that would help most if added [default: {}, or none above {} sheep: the search is slow]",
        suggestions::USUAL,
        suggestions::MOST_SHEEP
    ))]
    suggest: Option<u16>,
    /// Only the graph, for Graphviz
    #[arg(long, conflicts_with_all = ["graphml", "json"])]
    dot: bool,
    /// Only the graph, for Gephi and its like
    #[arg(long, conflicts_with = "json")]
    graphml: bool,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(serde::Serialize)]
struct Answer<'a> {
    file: &'a Path,
    bytes: usize,
    #[serde(flatten)]
    figures: Figures,
    /// The number of joins that jump; `null` if none was judged.
    jumps: Option<usize>,
    faults: &'a [Fault],
}

/// Runs the command.
pub(crate) fn run(args: &Args, decoder: DecoderHandle) -> Result<Exit, Fatal> {
    let flock = Arc::new(Flock::new(open::manifest(&args.dir)?));
    if args.dot || args.graphml {
        graph(args, &flock)?;
    } else {
        page(args, &flock, decoder)?;
    }
    Ok(if flock.faults().is_empty() { Exit::Fine } else { Exit::No })
}

/// Writes the graph alone.
fn graph(args: &Args, flock: &Flock) -> Result<(), Fatal> {
    let facts = Facts::of(PageSources {
        flock,
        seed: args.seed,
        walked: None,
        balanced: None,
        suggested: None,
        joins: None,
        pictures: &[],
        clips_there: None,
    });
    let lines = if args.dot { dot::lines(&facts) } else { graphml::lines(&facts) };
    match &args.out {
        Some(path) => write(path, &(lines.join("\n") + "\n")),
        None => print::lines(lines),
    }
}

fn page(args: &Args, flock: &Arc<Flock>, decoder: DecoderHandle) -> Result<(), Fatal> {
    let there = |path: &&&str| args.dir.join(path).is_file();
    let clips_there = (!args.no_pictures).then(|| distinct_clips(flock).keys().filter(there).count());
    // If no clip is there, no decoder is asked for.
    let decoder = clips_there.filter(|&clips| clips > 0).map(|_| decoder.get()).transpose()?;
    let pictures = if args.no_pictures { Vec::new() } else { pictures(&args.dir, flock, decoder) };
    let walked = WalkSample::of(flock, args.seed);
    let balanced = BalancedShares::of(flock);
    let folder = Some(args.dir.as_path()).filter(|_| !args.no_pictures);
    let suggested = SuggestionList::of(flock, folder, args.suggest.map(usize::from));
    let judging = decoder.filter(|_| !args.no_joins);
    let joins = judging.and_then(|decoder| Joins::of(&args.dir, flock, decoder));
    let jumps = joins.as_ref().map(|joins| joins.jumps);
    let facts = Facts::of(PageSources {
        flock,
        seed: args.seed,
        walked,
        balanced,
        suggested,
        joins,
        pictures: &pictures,
        clips_there,
    });
    let text = html::page(&facts).map_err(|error| Fatal::new(Exit::Unreadable, error))?;
    let path = args.out.clone().unwrap_or_else(|| args.dir.join(FILE_NAME));
    write(&path, &text)?;
    for fault in flock.faults() {
        print::note(&fault.message);
    }
    if args.json {
        return print::json(&Answer {
            file: &path,
            bytes: text.len(),
            figures: facts.figures,
            jumps,
            faults: flock.faults(),
        });
    }
    print::lines([path.display().to_string()])
}

/// A picture of every sheep of the whole flock; `None` for a sheep without clips and genome.
fn pictures(folder: &Path, flock: &Flock, decoder: Option<&dyn Decoder>) -> Vec<Option<Picture>> {
    let written = |sheep: SheepIx| &flock.manifest().sheep[flock.whole().sheep_in_manifest(sheep)];
    let sheep: Vec<&Sheep> = flock.whole().sheep().map(written).collect();
    picture::all(folder, flock.manifest(), &sheep, decoder)
}

fn write(path: &Path, text: &str) -> Result<(), Fatal> {
    durable::save(path, text.as_bytes()).map_err(|source| Fatal::write(path, source))
}
