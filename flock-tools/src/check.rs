//! `flock check`: is this flock fit to be shown?
//!
//! Owns the command and its answer. What the graph lacks is found by the flock crate, what the clips lack by
//! `clips.rs`.

use std::path::PathBuf;

use flock::{Fault, Flock, forced_repeats};

use crate::clips;
use crate::open;
use crate::report::{self, Exit, Fatal};

/// Tell every fault of a flock: names, graph and clips
///
/// Every clip is opened, compared with the manifest and decoded from end to end.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the flock has no fault
  1  faults were found; each is named with its kind
  2  the command line or the manifest is wrong
  3  the manifest could not be read, or the answer not written")]
pub(crate) struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// Answer with one JSON document: {"ok": ..., "faults": [...]}
    #[arg(long)]
    json: bool,
}

#[derive(serde::Serialize)]
struct Answer {
    ok: bool,
    faults: Vec<Fault>,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Fatal> {
    let flock = Flock::new(open::manifest(&args.dir)?);
    let mut found = flock.faults().to_vec();
    found.extend(clips::faults(&args.dir, flock.manifest()));
    tell_forced_repeats(&flock);
    let exit = if found.is_empty() { Exit::Fine } else { Exit::No };
    if args.json {
        report::json(&Answer { ok: found.is_empty(), faults: found })?;
    } else {
        report::lines(found.iter().map(line))?;
        report::note(&match found.len() {
            0 => "no faults".to_owned(),
            1 => "1 fault".to_owned(),
            count => format!("{count} faults"),
        });
    }
    Ok(exit)
}

/// `kind: message`, the kind as in JSON.
fn line(fault: &Fault) -> String {
    let kind = serde_json::to_value(fault.kind).expect("a kind is a word");
    format!("{}: {}", kind.as_str().unwrap_or_default(), fault.message)
}

/// Where the flock's own shape makes the walk repeat itself. Not a fault, so it is said on stderr.
fn tell_forced_repeats(flock: &Flock) {
    let single = forced_repeats(flock.graph());
    if let Some(first) = single.first() {
        report::note(&format!(
            "note: {} of {} sheep have a single transition that leaves them, `{first}` first: what follows them is always \
             the same",
            single.len(),
            flock.graph().len()
        ));
    }
}
