//! `dreams report DIR`: a flock as one page to look at.
//!
//! Owns the command: its options, what is written where, and how it ends. `facts.rs` has the page's document,
//! `large_facts.rs` that of a large flock, `html.rs` makes the file, `sheet/` is the code in it; `dot.rs` and `graphml.rs`
//! write the graph alone for other programs.
//!
//! Start at [`run`].

mod balance;
mod credits;
mod dot;
mod facts;
mod graphml;
mod html;
mod joins;
mod large_facts;
mod packed;
mod suggestions;
mod walk;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use flock::{Fault, Flock, FlockShares, Measure, Sheep, Terms};
use operations::decoder::{Decoder, DecoderHandle};
use operations::flock_folder::open;
use operations::portrait::picture::{self, Picture};
use operations::program::{Exit, Fatal, print};

use crate::arguments;
use balance::BalancedShares;
use credits::CreditFacts;
use facts::{Facts, Figures, PageSources, distinct_clips};
use joins::Joins;
use large_facts::{LargeFacts, LargeSources, MOST_DRAWN, worst};
use suggestions::SuggestionList;
use walk::WalkSample;

/// The default name of the page.
const FILE_NAME: &str = "report.html";

/// Draw a flock as one page to look at: its graph, its shares, a day of its walk, its joins, its credits
///
/// One HTML file that needs nothing else, opens offline, and can be sent to anyone. Sheep stay where they were in the
/// last report, or close by: a transition added or removed hardly moves them, weights and wants do not. It works
/// without any clip, too. If there are clips, every join is judged as `dreams check --joins` does it, and the worst are
/// shown: for this the end and a few first frames of each clip are decoded.
///
/// Of more than 2,000 sheep there is no graph: the page counts how many are shown how often, lists the 50 that are
/// furthest from their wants, and finds any other by its id.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the report is written
  1  the report is written, and the flock has faults, which are listed at its top
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
#[expect(clippy::struct_excessive_bools, reason = "independent switches")]
pub struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// The file to write; if not given, report.html in the folder, and stdout for --dot and --graphml
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// What wants are compared with on the page
    #[arg(long, value_name = "MEASURE", default_value = "visits", conflicts_with_all = ["dot", "graphml"])]
    by: arguments::By,
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
pub fn run(args: &Args, decoder: DecoderHandle) -> Result<Exit, Fatal> {
    let flock = Arc::new(Flock::new(open::unfinished(&args.dir)?));
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
        by: Measure::Visits,
        seed: args.seed,
        walked: None,
        balanced: None,
        suggested: None,
        joins: None,
        credits: None,
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
    let credits = if args.no_pictures { None } else { CreditFacts::of(&args.dir, flock)? };
    let terms = terms(args);
    let folder = Some(args.dir.as_path()).filter(|_| !args.no_pictures);
    let suggested = SuggestionList::of(flock, folder, terms, args.suggest.map(usize::from));
    let judging = decoder.filter(|_| !args.no_joins);
    let joins = judging.and_then(|decoder| Joins::of(&args.dir, flock, decoder));
    let jumps = joins.as_ref().map(|joins| joins.jumps);
    let parts = PageParts { clips_there, decoder, suggested, joins, credits };
    let is_large = flock.whole().len() > MOST_DRAWN;
    let (figures, text) = if is_large { large(args, flock, parts) } else { drawn(args, flock, parts) }?;
    let path = args.out.clone().unwrap_or_else(|| args.dir.join(FILE_NAME));
    write(&path, &text)?;
    for fault in flock.faults() {
        print::note(&fault.message);
    }
    if args.json {
        return print::json(&Answer { file: &path, bytes: text.len(), figures, jumps, faults: flock.faults() });
    }
    print::lines([path.display().to_string()])
}

/// The terms of the balance that a page shows.
fn terms(args: &Args) -> Terms {
    Terms { by: args.by.into(), ..Terms::default() }
}

/// What a page has, however large its flock is.
struct PageParts<'d> {
    clips_there: Option<usize>,
    decoder: Option<&'d dyn Decoder>,
    suggested: Option<SuggestionList>,
    joins: Option<Joins>,
    credits: Option<CreditFacts>,
}

/// The page that shows every sheep, and its figures.
fn drawn(args: &Args, flock: &Arc<Flock>, parts: PageParts<'_>) -> Result<(Figures, String), Fatal> {
    let PageParts { clips_there, decoder, suggested, joins, credits } = parts;
    let all: Vec<usize> = (0..flock.whole().len()).collect();
    let pictures = pictures(args, flock, &all, decoder);
    let facts = Facts::of(PageSources {
        flock,
        by: args.by.into(),
        seed: args.seed,
        walked: WalkSample::of(flock, args.seed),
        balanced: BalancedShares::of(flock, terms(args)),
        suggested,
        joins,
        credits,
        pictures: &pictures,
        clips_there,
    });
    Ok((facts.figures, html::page(&facts).map_err(|error| Fatal::new(Exit::Unreadable, error))?))
}

/// The page of a large flock, and its figures.
fn large(args: &Args, flock: &Flock, parts: PageParts<'_>) -> Result<(Figures, String), Fatal> {
    let PageParts { clips_there, decoder, suggested, joins, credits } = parts;
    let shares = FlockShares::of(flock);
    let furthest = shares.as_ref().map(|shares| worst(&shares.sheep, args.by.into())).unwrap_or_default();
    let pictures = pictures(args, flock, &furthest, decoder);
    let facts = LargeFacts::of(LargeSources {
        flock,
        terms: terms(args),
        shares: shares.as_ref(),
        suggested,
        joins,
        credits,
        pictures: &pictures,
        clips_there,
    });
    Ok((facts.figures, html::large_page(&facts).map_err(|error| Fatal::new(Exit::Unreadable, error))?))
}

/// A picture of each sheep at these `places` of the whole flock, `None` for one without clips and genome; none at all if no
/// clip is to be opened.
fn pictures(args: &Args, flock: &Flock, places: &[usize], decoder: Option<&dyn Decoder>) -> Vec<Option<Picture>> {
    if args.no_pictures {
        return Vec::new();
    }
    let (manifest, whole) = (flock.manifest(), flock.whole());
    let written: Vec<&Sheep> = whole.sheep().map(|sheep| &manifest.sheep[whole.sheep_in_manifest(sheep)]).collect();
    let sheep: Vec<&Sheep> = places.iter().map(|&at| written[at]).collect();
    picture::all(&args.dir, manifest, &sheep, decoder)
}

fn write(path: &Path, text: &str) -> Result<(), Fatal> {
    durable::save(path, text.as_bytes()).map_err(|source| Fatal::write(path, source))
}
