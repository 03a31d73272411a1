//! `dreams credits`: who made a flock, and under which licences.
//!
//! Owns the command and its answer.
//!
//! Start at [`run`].

use std::collections::BTreeMap;
use std::path::PathBuf;

use flock::{Manifest, SheepId, excerpt};
use operations::credits::{Credit, FlockCredits, Licence, NotForSale, Sale};
use operations::flock_folder::open;
use operations::flock_folder::paths::CREDITS;
use operations::program::{Exit, Fatal, print};
use serde::Serialize;

/// Tell who made the sheep and transitions of a flock, and under which licences they are
///
/// From the file credits.toml in the flock's folder, which `dreams import` writes and you may edit; from the genomes, which
/// may name authors, parents and a licence; and for a transition without an entry from the two sheep at its ends.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  told
  1  with --for-sale: a clip may not be sold, or has no licence that is known to allow it
  2  the command line, the manifest or credits.toml is wrong
  3  a file could not be read")]
pub struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// Only name the clips that may not be sold, or are not known to be
    #[arg(long)]
    for_sale: bool,
    /// Only sheep and transitions under this licence, as cc-by-nc or CC-BY-NC-3.0; none for those without one
    #[arg(long, value_name = "LICENCE", conflicts_with = "for_sale")]
    licence: Option<String>,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// The answer with `--json`.
#[derive(Serialize)]
struct Answer<'a> {
    /// The licences, the most frequent first; `null` is what has none.
    licences: Vec<LicenceCount<'a>>,
    sheep: Vec<SheepAnswer<'a>>,
    transitions: Vec<TransitionAnswer<'a>>,
    /// What whoever shows the flock has to say, each sentence once.
    attributions: Vec<&'a str>,
    not_for_sale: Vec<NotForSale>,
    /// Entries of credits.toml for what is not in the flock.
    strangers: Vec<String>,
}

/// A licence, and how often it is in the flock.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct LicenceCount<'a> {
    pub(crate) licence: Option<&'a Licence>,
    pub(crate) sale: Sale,
    pub(crate) sheep: usize,
    pub(crate) transitions: usize,
}

#[derive(Serialize)]
struct SheepAnswer<'a> {
    id: &'a SheepId,
    #[serde(flatten)]
    credit: &'a Credit,
    sale: Sale,
}

#[derive(Serialize)]
struct TransitionAnswer<'a> {
    from: &'a SheepId,
    to: &'a SheepId,
    #[serde(flatten)]
    credit: &'a Credit,
    sale: Sale,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let manifest = open::manifest(&args.dir)?;
    let credits = FlockCredits::of(&args.dir, &manifest)?;
    let not_for_sale = credits.not_for_sale(&manifest);
    let exit = if args.for_sale && !not_for_sale.is_empty() { Exit::No } else { Exit::Fine };
    let shows = |credit: &Credit| args.licence.as_deref().is_none_or(|wanted| credit.is_under(wanted));
    if args.json {
        print::json(&Answer::of(&credits, &manifest, not_for_sale, shows))?;
        return Ok(exit);
    }
    if args.for_sale {
        print::lines(not_for_sale.iter().map(NotForSale::line))?;
    } else {
        print::lines(lines(&credits, &manifest, shows))?;
    }
    for stranger in &credits.strangers {
        print::note(&format!("note: `{CREDITS}` has an entry for {stranger}, which is not in the flock"));
    }
    // A sheep that is only passed through has nothing that could be under a licence.
    let has_files = manifest.sheep.iter().map(|sheep| sheep.clip.is_some() || sheep.genome.is_some());
    let sheep = credits.sheep.iter().zip(has_files).filter(|(_, has_files)| *has_files).map(|(credit, _)| credit);
    let unknown = sheep.chain(&credits.transitions).filter(|credit| credit.licence.is_none()).count();
    if unknown > 0 {
        print::note(&format!(
            "note: no licence is known of {unknown} sheep and transitions; `{CREDITS}` in the flock's folder takes it"
        ));
    }
    Ok(exit)
}

impl<'a> Answer<'a> {
    fn of(
        credits: &'a FlockCredits,
        manifest: &'a Manifest,
        not_for_sale: Vec<NotForSale>,
        shows: impl Fn(&Credit) -> bool,
    ) -> Self {
        let sale = |credit: &Credit| Sale::of(credit.licence.as_ref());
        let sheep = manifest.sheep.iter().zip(&credits.sheep).filter(|(_, credit)| shows(credit));
        let transitions = manifest.transitions.iter().zip(&credits.transitions).filter(|(_, credit)| shows(credit));
        Self {
            licences: counts(credits),
            sheep: sheep.map(|(sheep, credit)| SheepAnswer { id: &sheep.id, credit, sale: sale(credit) }).collect(),
            transitions: transitions
                .map(|(t, credit)| TransitionAnswer { from: &t.from, to: &t.to, credit, sale: sale(credit) })
                .collect(),
            attributions: attributions(credits),
            not_for_sale,
            strangers: credits.strangers.iter().map(ToString::to_string).collect(),
        }
    }
}

/// The licences in the flock, the most frequent first.
pub(crate) fn counts(credits: &FlockCredits) -> Vec<LicenceCount<'_>> {
    let mut counts: BTreeMap<Option<&Licence>, (usize, usize)> = BTreeMap::new();
    for credit in &credits.sheep {
        counts.entry(credit.licence.as_ref()).or_default().0 += 1;
    }
    for credit in &credits.transitions {
        counts.entry(credit.licence.as_ref()).or_default().1 += 1;
    }
    let count = |(licence, (sheep, transitions))| LicenceCount { licence, sale: Sale::of(licence), sheep, transitions };
    let mut counts: Vec<LicenceCount<'_>> = counts.into_iter().map(count).collect();
    counts.sort_by_key(|count| std::cmp::Reverse(count.sheep + count.transitions));
    counts
}

/// What whoever shows the flock has to say, each sentence once.
pub(crate) fn attributions(credits: &FlockCredits) -> Vec<&str> {
    let all = credits.sheep.iter().chain(&credits.transitions).filter_map(|credit| credit.attribution.as_deref());
    let mut found = Vec::new();
    for text in all {
        if !found.contains(&text) {
            found.push(text);
        }
    }
    found
}

fn lines(credits: &FlockCredits, manifest: &Manifest, shows: impl Fn(&Credit) -> bool) -> Vec<String> {
    let told = |licence: Option<&Licence>| licence.map_or("no licence".to_owned(), |own| excerpt(own.as_str()));
    let mut lines: Vec<String> = Vec::new();
    for LicenceCount { licence, sale, sheep, transitions } in counts(credits) {
        let transitions = print::count(transitions, "transition");
        lines.push(format!("{}: {sheep} sheep, {transitions}, {}", told(licence), sale.in_words()));
    }
    lines.extend(attributions(credits).into_iter().map(|text| format!("to be said: {}", excerpt(text))));
    lines.push(String::new());
    let sheep = manifest.sheep.iter().map(|sheep| sheep.id.to_string()).zip(&credits.sheep);
    let ends = manifest.transitions.iter().map(|t| format!("{} to {}", t.from, t.to));
    let rows: Vec<(String, String, String)> = sheep
        .chain(ends.zip(&credits.transitions))
        .filter(|(_, credit)| shows(credit))
        .map(|(name, credit)| (name, told(credit.licence.as_ref()), credit.line()))
        .collect();
    let width = |column: fn(&(String, String, String)) -> &String| {
        rows.iter().map(|row| column(row).chars().count()).max().unwrap_or_default()
    };
    let (names, licences) = (width(|row| &row.0), width(|row| &row.1));
    let row = |(name, licence, told): &(String, String, String)| {
        format!("{name:names$}  {licence:licences$}  {told}").trim_end().to_owned()
    };
    lines.extend(rows.iter().map(row));
    lines
}
