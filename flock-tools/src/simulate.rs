//! `flock simulate`: what a long walk amounts to.
//!
//! Owns the answer's form. The figures are the flock crate's.

use std::path::PathBuf;

use flock::{Simulation, Visits};

use crate::open;
use crate::report::{self, Exit, Fatal};

/// Most steps: 158 years of them. Each is remembered in a dozen bytes.
const MOST_STEPS: usize = 100_000_000;

/// Walk many steps and tell how even, how spaced and how varied they are
///
/// Visits are fractions of all, the first one included. Return times run from the start of one visit to the start of the sheep's next;
/// a repeat is a run of transitions that was walked before. Only the manifest is read.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the figures are printed
  1  the flock has no cycle of transitions to walk
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub(crate) struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// Which of the endless walks: the same seed and flock give the same walk
    #[arg(long)]
    seed: u64,
    /// Transitions to take; a year of 50-second steps has 630000
    #[arg(long)]
    #[arg(value_parser = steps)]
    steps: usize,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Fatal> {
    let flock = open::walkable(&args.dir)?;
    let figures = Simulation::run(&flock, args.seed, args.steps).expect("the flock can be walked");
    if args.json {
        report::json(&figures)?;
    } else {
        report::lines(table(&figures, args.steps))?;
    }
    Ok(Exit::Fine)
}

/// Steps that fit into memory.
fn steps(text: &str) -> Result<usize, String> {
    let steps = text.parse().ok().filter(|steps| *steps <= MOST_STEPS);
    steps.ok_or_else(|| format!("wanted a whole number up to {MOST_STEPS}"))
}

fn table(figures: &Simulation, steps: usize) -> Vec<String> {
    let minutes = |value: Option<f64>| value.map_or("-".to_owned(), |minutes| format!("{minutes:.1} min"));
    let after = |value: Option<usize>| value.map_or("never".to_owned(), |steps| format!("after {steps} steps"));
    let worst = figures.worst_ratio.map_or("a sheep was never shown".to_owned(), |ratio| format!("{ratio:.3}"));
    let rows = [
        ("steps", steps.to_string()),
        ("screen time", format!("{:.1} h", figures.minutes / 60.0)),
        ("worst ratio of visits and want", worst),
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
    let wide = report::widest(figures.sheep.iter().map(|sheep| &sheep.id));
    lines.push(format!("{:<wide$} {:>10} {:>8}", "sheep", "visits", "share"));
    let row =
        |sheep: &Visits| format!("{:<wide$} {:>10} {:>7.3}%", sheep.id.as_str(), sheep.count, 100.0 * sheep.visits);
    lines.extend(figures.sheep.iter().map(row));
    lines
}
