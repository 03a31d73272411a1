//! `dreams share`: how often everything is shown.
//!
//! Owns the answer's form. The figures are the flock crate's.

use std::path::PathBuf;

use flock::{Fault, Flock, FlockShares, Measure, Shares, SheepShare};
use operations::flock_folder::open;
use operations::program::{Exit, Fatal, print};

use crate::arguments;

/// Tell how often every sheep is shown in the long run, against how often it should be
///
/// Exact figures of the walk that a unit plays, by visits and by the time that loops are shown, with a proof of their
/// error; without a proof, a note says so. With --by time, the worst ratio and each sheep's are those of the time. A
/// sheep's mean return runs from the start of one visit to the start of its
/// next. Sheep that are never shown have no share, and are named as faults. Only the manifest is read.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the shares are printed, and everything in the flock is shown
  1  the flock has faults, each named: the shares are those of the part that is played; or they could not be proved
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// What wants are compared with
    #[arg(long, value_name = "MEASURE", default_value = "visits")]
    by: arguments::By,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(serde::Serialize)]
struct Answer<'f> {
    #[serde(flatten)]
    shares: FlockShares<'f>,
    /// Those of the manifest: clips are not opened.
    faults: &'f [Fault],
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let flock = Flock::new(open::manifest(&args.dir)?);
    let faults = flock.faults();
    let Some(shares) = FlockShares::of(&flock) else { return Err(open::no_cycle(&flock)) };
    for fault in faults {
        print::note(&fault.message);
    }
    let is_proved = shares.off_by.is_some_and(|part| part <= Shares::PROVED);
    if !is_proved {
        print::note(&unproved(shares.off_by));
    }
    if args.json {
        print::json(&Answer { shares, faults })?;
    } else {
        print::lines(table(&shares, args.by.into()))?;
    }
    Ok(if faults.is_empty() && is_proved { Exit::Fine } else { Exit::No })
}

/// The note on shares that are an estimate.
fn unproved(off_by: Option<f64>) -> String {
    match off_by {
        Some(part) => format!("the shares are an estimate: each may be off by {:.3}% of itself", 100.0 * part),
        None => {
            "the shares are an estimate without a bound: they differ by more than floating-point numbers can resolve"
                .to_owned()
        }
    }
}

/// The sheep, those furthest from their wants first.
fn table(shares: &FlockShares, by: Measure) -> Vec<String> {
    let worst = shares.worst(by).map_or("a sheep is never shown".to_owned(), |ratio| format!("{ratio:.3}"));
    let figure = format!("worst ratio of {by} and want");
    let most = (shares.sheep.len() as f64).log2();
    let wide = print::widest(shares.sheep.iter().map(|sheep| sheep.id));
    let mut lines = vec![
        format!("{figure:<32} {worst}"),
        format!("{:<32} {:.3} of {most:.3} bits", "entropy of the visits", shares.entropy_bits),
        format!("{:<32} {:.1} s", "mean step", 60.0 * shares.step_minutes),
        String::new(),
        format!("{:<wide$} {:>9} {:>9} {:>9} {:>8} {:>12}", "sheep", "visits", "want", "time", "ratio", "return, min"),
    ];
    let mut sheep: Vec<&SheepShare> = shares.sheep.iter().collect();
    sheep.sort_by(|a, b| b.off(by).total_cmp(&a.off(by)));
    lines.extend(sheep.into_iter().map(|sheep| row(sheep, wide, by)));
    lines
}

fn row(sheep: &SheepShare, wide: usize, by: Measure) -> String {
    let (share, want) = sheep.share_and_want(by);
    let ratio = if want > 0.0 { format!("{:.3}", share / want) } else { "-".to_owned() };
    let minutes = sheep.return_minutes.map_or("never".to_owned(), |minutes| format!("{minutes:.1}"));
    format!(
        "{:<wide$} {:>8.3}% {:>8.3}% {:>8.3}% {ratio:>8} {minutes:>12}",
        sheep.id.as_str(),
        100.0 * sheep.visits,
        100.0 * want,
        100.0 * sheep.time,
    )
}
