//! `dreams check`: the faults of a flock.
//!
//! Owns the command and its answer. `operations::check` finds the faults.

use std::collections::HashSet;
use std::path::PathBuf;

use flock::{ClipPath, Fault, Flock, forced_repeats};
use operations::check::genomes::{self, UndrawnGenome};
use operations::check::{fault_of_jump, faults_but_jumps, line, require_all_judged};
use operations::decoder::DecoderHandle;
use operations::flock_folder::open;
use operations::joins::{self, Figures, JudgedJoin};
use operations::program::{Exit, Fatal, print};

/// Tell every fault of a flock: names, graph and clips
///
/// Every clip is opened, compared with the manifest and decoded from end to end. With --joins, the end of every clip is
/// played into every clip that may follow it, and every join that does not meet, in value or in velocity, is named with
/// figures. Genomes that ask for what is not drawn are named with all reasons; one is a fault while a clip of it is
/// missing. A flock is `large` if its manifest, or the list of its files, is more than a unit has the memory for.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the flock has no fault
  1  faults were found; each is named with its kind
  2  the command line or the manifest is wrong
  3  the manifest could not be read, or the answer or the contact sheet not written")]
pub struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// Judge every join too
    #[arg(long)]
    joins: bool,
    /// Draw the frames around the worst joins, side by side, into this PNG file
    #[arg(long, value_name = "FILE", requires = "joins")]
    contact_sheet: Option<PathBuf>,
    /// Answer with one JSON document: {"ok": ..., "faults": [...], "genomes": [...]}
    #[arg(long)]
    json: bool,
}

#[derive(serde::Serialize)]
struct Answer<'a> {
    ok: bool,
    faults: FaultList<'a>,
    /// Of which something is not drawn.
    genomes: &'a [UndrawnGenome],
}

/// The faults in the answer: those that are no jumps, and the jumps. Each is put into its form as it is written: a large
/// flock may have a million.
struct FaultList<'a>(&'a [Fault], &'a [(Fault, JoinAnswer)]);

/// A fault in the answer: with the figures of its join, if it is a jump.
#[derive(serde::Serialize)]
struct FaultAnswer<'a> {
    #[serde(flatten)]
    fault: &'a Fault,
    #[serde(flatten)]
    join: Option<&'a JoinAnswer>,
}

/// The part of the answer that only a `jump` has.
#[derive(serde::Serialize)]
struct JoinAnswer {
    /// The clip that ends.
    before: ClipPath,
    /// The clip that begins.
    after: ClipPath,
    #[serde(flatten)]
    figures: Figures,
}

impl JoinAnswer {
    fn of(JudgedJoin { join, figures }: &JudgedJoin) -> Self {
        Self { before: join.before.path.clone(), after: join.after.path.clone(), figures: *figures }
    }
}

impl serde::Serialize for FaultList<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let others = self.0.iter().map(|fault| FaultAnswer { fault, join: None });
        serializer.collect_seq(others.chain(self.1.iter().map(|(fault, join)| FaultAnswer { fault, join: Some(join) })))
    }
}

/// Runs the command.
pub fn run(args: &Args, decoder: DecoderHandle) -> Result<Exit, Fatal> {
    let flock = Flock::new(open::manifest(&args.dir)?);
    let manifest = flock.manifest();
    let genomes = genomes::undrawn(&args.dir, manifest);
    let mut faults = faults_but_jumps(&args.dir, &flock, decoder)?;
    faults.extend(genomes::faults(&args.dir, manifest, &genomes));
    let mut jumps = Vec::new();
    if args.joins {
        let decoder = decoder.get()?;
        let judgement = joins::judge_with_bar(&args.dir, manifest, decoder);
        if faults.is_empty() {
            require_all_judged(&judgement)?;
        }
        jumps.extend(judgement.jumps().map(|join| (fault_of_jump(join), JoinAnswer::of(join))));
        if let Some(sheet) = &args.contact_sheet {
            let drawn = joins::draw(&args.dir, manifest, &judgement, sheet, decoder);
            drawn.map_err(|error| Fatal::new(Exit::Unreadable, error))?;
        }
    }
    note_genomes(&genomes, &faults);
    note_forced_repeats(&flock);
    let count = faults.len() + jumps.len();
    if args.json {
        print::json(&Answer { ok: count == 0, faults: FaultList(&faults, &jumps), genomes: &genomes })?;
    } else {
        print::lines(faults.iter().chain(jumps.iter().map(|(fault, _)| fault)).map(line))?;
        print::note(&print::count(count, "fault"));
    }
    Ok(if count == 0 { Exit::Fine } else { Exit::No })
}

/// Notes on stderr what of genomes is not drawn, but for `faults`.
fn note_genomes(genomes: &[UndrawnGenome], faults: &[Fault]) {
    let told: HashSet<&str> = faults.iter().map(|fault| &*fault.message).collect();
    for sentence in genomes.iter().flat_map(UndrawnGenome::sentences).filter(|sentence| !told.contains(&**sentence)) {
        print::note(&format!("note: {sentence}"));
    }
}

/// Notes on stderr where the graph makes the walk repeat itself. That is no fault.
fn note_forced_repeats(flock: &Flock) {
    let single = forced_repeats(flock.graph());
    if let Some(first) = single.first() {
        print::note(&format!(
            "note: {} of {} sheep have a single transition that leaves them, `{first}` first: what follows them is always \
             the same",
            single.len(),
            flock.graph().len()
        ));
    }
}
