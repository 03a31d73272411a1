//! `dreams balance`: weights that give every sheep the share that is wanted.
//!
//! Owns the command and the form of its answer. The flock crate finds the weights, the bottleneck if no weights reach the
//! wants, and the suggestions. `write.rs` writes the weights into the manifest, `suggest.rs` has the suggestions.

mod suggest;
pub(crate) mod write;

use std::path::PathBuf;
use std::sync::Arc;

use flock::Draft;
use flock::{Balance, Bottleneck, Flock, Measure, SheepBalance, SheepId, Suggestions, Terms};
use operations::flock_folder::open;
use operations::program::{Exit, Fatal, print};

use crate::arguments;
use suggest::Advice;

/// Find weights that give every sheep the share that is wanted, or as near as the transitions allow
///
/// Weights that reach the wants exactly may silence transitions. So nearness to the wants is weighed against nearness
/// to the weights as written, and every transition is played a minimum of times. `--fairness inf --floor 0` counts the
/// wants alone. If no weights reach the wants, the answer is no, and names the sheep that are the bottleneck. Only the
/// manifest is read.
///
/// With --by time the wants are of the time in which loops are shown, not of the visits: a sheep whose loop takes twice
/// as long, or is repeated twice, is visited half as often for the same want. The time of transitions is nobody's, and of
/// a sheep without a loop nothing is wanted.
///
/// With --write the weights are written into the manifest, and nothing else in it changes. Nothing is written if the
/// worst ratio of visits (with --by time, of time) and want would be worse than it is. The same command again changes
/// nothing if the weights were equal before; if the flock had weights of its own, it comes a little nearer to
/// the wants each time. --afresh ignores those.
///
/// With --suggest, the transitions that would help most if added, or if removed, are listed, with the balance after
/// that and the cost. Each is the best one after those before it. Sheep that are not played are joined first.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  some weights reach the wants exactly; the nearest under these terms are printed
  1  no weights reach the wants; the nearest are printed, and written if asked, with the bottleneck
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// How much the wants count against the weights as written: above 0, or `inf`
    #[arg(long, value_name = "L", default_value_t = Terms::default().fairness, allow_negative_numbers = true, value_parser = fairness)]
    fairness: f64,
    /// The least plays of every transition in a year
    #[arg(long, value_name = "N", default_value_t = Terms::default().floor, allow_negative_numbers = true, value_parser = floor)]
    floor: f64,
    /// What is wanted: parts of the visits, or of the time on screen
    #[arg(long, value_name = "MEASURE", default_value = "visits")]
    by: arguments::By,
    /// Compare with equal weights, not with those as written
    #[arg(long)]
    afresh: bool,
    /// Write the weights into the manifest
    #[arg(long)]
    write: bool,
    /// List up to K transitions to add, and up to K to remove
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=1000))]
    suggest: Option<u16>,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct Answer<'a> {
    #[serde(flatten)]
    balance: &'a Balance,
    /// With `--write`: whether any weight changed.
    #[serde(skip_serializing_if = "Option::is_none")]
    changed: Option<bool>,
    /// With `--write`: whether the weights as written stay, because the worst ratio would be worse with these.
    #[serde(skip_serializing_if = "Option::is_none")]
    kept: Option<bool>,
    /// With `--suggest`.
    #[serde(flatten)]
    advice: Option<Advice>,
}

/// A flock whose time on screen belongs to no sheep.
#[derive(Debug, thiserror::Error)]
#[error("none of the {played} sheep that are played has a loop: there is no time to balance")]
struct NoLoop {
    played: usize,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let draft = args.write.then(|| Draft::lock(&args.dir)).transpose()?;
    let manifest = draft
        .as_ref()
        .map_or_else(|| open::manifest(&args.dir).map(Arc::new), |draft| Ok(draft.edit.shared_manifest()))?;
    let flock = Flock::new(manifest);
    let terms = Terms { fairness: args.fairness, floor: args.floor, afresh: args.afresh, by: args.by.into() };
    // Before the balance: a large flock has no memory for both at once.
    let was = draft.as_ref().and_then(|_| write::worst_ratio(&flock, terms.by));
    let Some(balance) = Balance::of(&flock, terms) else { return Err(open::no_cycle(&flock)) };
    if terms.by == Measure::Time && flock.graph().sheep().all(|at| flock.sheep(at).clip.is_none()) {
        return Err(Fatal::new(Exit::No, NoLoop { played: flock.graph().len() }));
    }
    let unplayed = flock.whole().len() - flock.graph().len();
    if unplayed > 0 {
        print::note(&format!("{unplayed} sheep are not played, whatever the weights: `dreams check` says why"));
    }
    let worse = was.and_then(|was| write::worse(was, &balance));
    let advice = |flock: &Flock| {
        let suggestions = Suggestions::of(flock, terms, args.suggest?.into())?;
        Some(Advice::new(&suggestions, flock, &args.dir, terms.by))
    };
    let (changed, advice) = if let Some(draft) = draft.filter(|_| worse.is_none()) {
        let (changed, manifest) = write::weights(draft, flock, &balance)?;
        (Some(changed), args.suggest.and_then(|_| advice(&Flock::new(manifest))))
    } else {
        (None, advice(&flock))
    };
    if args.json {
        let (changed, kept) = (changed.unwrap_or(0) > 0, worse.is_some());
        let written = |answer: bool| args.write.then_some(answer);
        print::json(&Answer { balance: &balance, changed: written(changed), kept: written(kept), advice })?;
    } else {
        print::lines(table(&balance).chain(advice.iter().flat_map(Advice::table)))?;
    }
    if let Some(ratios) = worse {
        print::note(&write::kept(ratios, terms.by));
    }
    if let Some(changed) = changed {
        print::note(&write::summary(changed, &balance, was));
    }
    if balance.least_plays < args.floor {
        print::note(&format!(
            "a year is too short for {} plays of each transition: the least played has {:.1}",
            args.floor, balance.least_plays
        ));
    }
    Ok(if balance.reachable { Exit::Fine } else { Exit::No })
}

fn fairness(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number > 0.0);
    number.ok_or_else(|| format!("wanted a number above 0 or `inf`, found `{text}`"))
}

fn floor(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number >= 0.0 && number.is_finite());
    number.ok_or_else(|| format!("wanted a number, 0 or more, found `{text}`"))
}

/// The bottleneck first, then the sheep, those furthest from their wants first, then the weights.
fn table(balance: &Balance) -> impl Iterator<Item = String> {
    let by = balance.by;
    let figure = format!("worst ratio of {by} and want");
    let worst = balance.worst().map_or("a sheep is never shown".to_owned(), |ratio| format!("{ratio:.3}"));
    let reach =
        if balance.reachable { "some weights reach them".to_owned() } else { "no weights reach them".to_owned() };
    let mut lines = vec![
        format!("{:<40} {reach}", "wants"),
        format!("{:<40} {:.3}%", "part of the wants that can't be carried", 100.0 * balance.deficiency),
        format!("{figure:<40} {worst}"),
        format!("{:<40} {:.1} a year", "least played transition", balance.least_plays),
    ];
    if let Some(bottleneck) = &balance.bottleneck {
        lines.extend(proof(balance, bottleneck));
    }
    let width = print::widest(balance.sheep.iter().map(|sheep| &sheep.id));
    lines.push(String::new());
    lines.push(format!("{:<width$} {by:>9} {:>9} {:>8}", "sheep", "want", "ratio"));
    let mut sheep: Vec<&SheepBalance> = balance.sheep.iter().collect();
    sheep.sort_by(|a, b| b.off(by).total_cmp(&a.off(by)));
    let sheep = sheep.into_iter().map(move |sheep| row(sheep, width, by));
    let heading = format!("{:<width$} {:<width$} {:>12} {:>9}", "from", "to", "weight", "visits");
    let weights = balance.weights.iter().map(move |t| {
        let (from, to, visits) = (t.from.as_str(), t.to.as_str(), 100.0 * t.visits);
        format!("{from:<width$} {to:<width$} {:>12} {visits:>8.3}%", t.weight)
    });
    lines.into_iter().chain(sheep).chain([String::new(), heading]).chain(weights)
}

/// The bottleneck in a form that can be checked by hand: first the sheep that are not played.
fn proof(balance: &Balance, bottleneck: &Bottleneck) -> Vec<String> {
    let list = |ids: &[&SheepId]| ids.iter().map(|id| id.as_str()).collect::<Vec<_>>().join(" ");
    let balanced =
        |id: &&SheepId| balance.sheep.binary_search_by(|sheep| sheep.id.cmp(id)).map(|at| &balance.sheep[at]);
    let want = |ids: &[&SheepId]| {
        100.0 * ids.iter().flat_map(balanced).map(|sheep| sheep.wanted_visits).fold(0.0, |all, want| all + want)
    };
    let played = |id: &&SheepId| balanced(id).is_ok_and(|sheep| sheep.visits > 0.0);
    let (stuck, unplayed): (Vec<&SheepId>, Vec<&SheepId>) = bottleneck.sheep.iter().partition(|id| played(id));
    let followers: Vec<&SheepId> = bottleneck.followers.iter().collect();
    let of = if balance.by == Measure::Time { " of all visits" } else { "" };
    let mut lines = Vec::new();
    if !unplayed.is_empty() {
        let (count, wanted) = (unplayed.len(), want(&unplayed));
        lines
            .extend([String::new(), format!("Not played: {count} sheep are wanted {wanted:.3}%{of} and get nothing.")]);
        lines.push(format!("these  {}", list(&unplayed)));
    }
    if !stuck.is_empty() {
        lines.push(String::new());
        lines.push(format!(
            "Bottleneck: {} sheep are wanted {:.3}%{of}, all {} sheep that they lead to only {:.3}%.",
            stuck.len(),
            want(&stuck),
            followers.len(),
            want(&followers)
        ));
        lines.push(format!("these  {}", list(&stuck)));
        lines.push(format!("lead to  {}", list(&followers)));
    }
    lines
}

fn row(sheep: &SheepBalance, width: usize, by: Measure) -> String {
    let (share, want) = sheep.share_and_want(by);
    let ratio = if want > 0.0 { format!("{:.3}", share / want) } else { "-".to_owned() };
    format!("{:<width$} {:>8.3}% {:>8.3}% {ratio:>8}", sheep.id.as_str(), 100.0 * share, 100.0 * want)
}
