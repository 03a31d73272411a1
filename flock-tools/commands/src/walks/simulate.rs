//! `dreams simulate`: the figures of a long walk.
//!
//! Owns the answer's form. The figures are the flock crate's.

use flock::{Simulation, Visits};
use operations::flock_folder::open;
use operations::program::{Exit, Fatal, print};

use crate::arguments::WalkArgs;

/// Walk many steps and tell how even, how spaced and how varied they are
///
/// Visits are fractions of all, the first one included. Beside them are the prediction of `dreams share`, and the bound
/// of the difference by chance: four standard deviations, measured on the walk. Return times run from the start of one
/// visit to the start of the sheep's next; a repeat is a run of transitions that was walked before. Without a seed it is
/// a fresh walk, whose seed is told on stderr. Only the manifest is read.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the figures are printed
  1  the flock has no cycle of transitions to walk
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub struct Args {
    #[command(flatten)]
    walk: WalkArgs,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct Answer {
    seed: u64,
    #[serde(flatten)]
    figures: Simulation,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let WalkArgs { dir, steps, .. } = &args.walk;
    let flock = open::walkable(dir)?;
    let seed = args.walk.seed(args.json);
    let figures = Simulation::run(&flock, seed, *steps).expect("the flock can be walked");
    if args.json {
        print::json(&Answer { seed, figures })?;
    } else {
        print::lines(table(&figures, *steps))?;
    }
    Ok(Exit::Fine)
}

fn table(figures: &Simulation, steps: usize) -> Vec<String> {
    let minutes = |value: Option<f64>| value.map_or("-".to_owned(), |minutes| format!("{minutes:.1} min"));
    let after = |value: Option<usize>| value.map_or("never".to_owned(), |steps| format!("after {steps} steps"));
    let worst = figures.worst_ratio.map_or("a sheep was never shown".to_owned(), |ratio| format!("{ratio:.3}"));
    let rows = [
        ("steps", steps.to_string()),
        ("screen time", format!("{:.1} h", figures.minutes / 60.0)),
        ("worst ratio of visits and want", worst),
        ("sheep outside their bounds", format!("{} of {}", figures.outside, figures.sheep.len())),
        ("most visits off the due", format!("{:.1}", figures.most_off)),
        ("shortest return", minutes(figures.min_return_minutes)),
        ("5th percentile of returns", minutes(figures.p05_return_minutes)),
        ("mean return", minutes(figures.mean_return_minutes)),
        ("first repeat of 2 steps", after(figures.first_repeat.k2)),
        ("first repeat of 3 steps", after(figures.first_repeat.k3)),
        ("first repeat of 4 steps", after(figures.first_repeat.k4)),
        ("longest repeat", format!("{} steps", figures.longest_repeat)),
    ];
    let mut lines: Vec<String> = rows.into_iter().map(|(name, value)| format!("{name:<32} {value}")).collect();
    lines.push(String::new());
    let wide = print::widest(figures.sheep.iter().map(|sheep| &sheep.id));
    lines.push(format!("{:<wide$} {:>10} {:>8} {:>10} {:>9}", "sheep", "visits", "share", "predicted", "within"));
    let row = |sheep: &Visits| {
        let (share, predicted) = (100.0 * sheep.visits, 100.0 * sheep.predicted);
        let bound = sheep.bound.map_or("-".to_owned(), |bound| format!("{:.3}%", 100.0 * bound));
        let outside = if sheep.is_within() { "" } else { "  outside" };
        format!("{:<wide$} {:>10} {share:>7.3}% {predicted:>9.3}% {bound:>9}{outside}", sheep.id.as_str(), sheep.count)
    };
    lines.extend(figures.sheep.iter().map(row));
    lines
}
