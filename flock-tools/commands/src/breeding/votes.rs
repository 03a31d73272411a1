//! `dreams votes POOL FILE...`: takes in what units report of their votes.
//!
//! Owns the command: which documents there are, the file of each unit in the pool, and what the ledger is told: those of
//! its totals that have grown. Both can be repeated: a kill between them loses nothing and counts nothing twice. Which
//! reports are accepted is known to the package `votes`.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use ::breeding::{Count, Event, Pool};
use operations::breeding::{open, open_for_changes, today};
use operations::program::{Exit, Fatal, print};
use serde::de::IgnoredAny;
use votes::{Received, SheepTotals, Totals, UnitLimits, VotesError};

/// The folder of a pool with a file for each unit.
const FOLDER: &str = "votes";
/// Seconds of somebody near that count as one vote: many stand there for other reasons.
const NEAR_S: u32 = 300;
/// The most bytes of a file with documents.
const MOST_BYTES: u64 = 4 << 20;

/// Take in the votes that units report
///
/// Files are status reports, as units send them, or the `votes.json` of a unit's owner partition; `-` is the standard input,
/// with one document after the other. Totals only grow: it does no harm if reports are lost, repeated or in another order.
/// Only units count that were named once with --unit.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  everything is taken in, or was known already
  1  some documents were refused: those of unknown units, or with totals that cannot be; or another program changes the pool
  2  the command line or the pool is wrong
  3  a file could not be read or written")]
pub struct Args {
    /// Folder of the pool
    pool: PathBuf,
    /// Reports, folders with reports, or - for the standard input
    files: Vec<PathBuf>,
    /// Know this unit from now on; documents that name no unit are its
    #[arg(long, value_name = "NAME", value_parser = unit_name)]
    unit: Option<String>,
    /// Seconds of the shortest loop of the units: totals with more showings than that allows are refused
    #[arg(long = "loop", value_name = "S", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=3600))]
    loop_s: u32,
    /// Only tell what would be taken in
    #[arg(long)]
    dry_run: bool,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// What is read of a status report.
#[derive(serde::Deserialize)]
struct Report {
    unit: Option<String>,
    status: Option<IgnoredAny>,
    votes: Option<Totals>,
}

/// What is wrong with a document.
#[derive(Debug, thiserror::Error)]
enum DocumentError {
    #[error("it has no document")]
    Empty,
    #[error("it is no JSON document: {0}")]
    Json(serde_json::Error),
    #[error("it has more than {MOST_BYTES} bytes, the most that are read of a file")]
    Long,
    #[error("it names no unit")]
    Nameless,
    #[error(transparent)]
    Votes(#[from] VotesError),
}

/// What is new of a unit.
#[derive(Debug, Default, serde::Serialize)]
struct News {
    showings: u64,
    up: u64,
    down: u64,
    /// Sheep of which something is new.
    sheep: usize,
}

/// A document that was refused.
#[derive(serde::Serialize)]
struct Refused {
    file: String,
    #[serde(serialize_with = "as_text")]
    why: DocumentError,
}

/// Writes an error as what it says.
fn as_text<S: serde::Serializer>(why: &DocumentError, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(why)
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct Answer {
    changed: bool,
    units: BTreeMap<String, News>,
    refused: Vec<Refused>,
    /// Whether enough was heard since the last brood for another.
    due: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let mut folder = if args.dry_run { open(&args.pool)? } else { open_for_changes(&args.pool)? };
    let mut received = args.known()?;
    let mut refused = Vec::new();
    for (file, text) in args.texts()? {
        for document in documents(&text) {
            if let Err(why) = document.and_then(|document| args.take(document, &mut received)) {
                refused.push(Refused { file: file.clone(), why });
            }
        }
    }
    let mut units = BTreeMap::new();
    let mut events = Vec::new();
    for unit in received.units() {
        let sheep = grown(folder.pool(), unit, &received.totals(unit));
        units.insert(unit.to_owned(), news(folder.pool(), unit, &sheep));
        if !sheep.is_empty() {
            events.push(Event::Votes { unit: unit.to_owned(), sheep });
        }
    }
    if !args.dry_run {
        args.save(&received)?;
        if !events.is_empty() {
            folder.tell(today(), events)?;
        }
    }
    args.tell(&Answer { changed: !args.dry_run, units, refused, due: folder.pool().is_due() })
}

impl Args {
    /// The units that the pool knows, with what they have reported.
    fn known(&self) -> Result<Received, Fatal> {
        let limits = UnitLimits { loop_s: self.loop_s };
        let mut received = Received::default();
        let path = self.pool.join(FOLDER);
        let entries = match fs::read_dir(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            found => Some(found.map_err(|source| Fatal::read(&path, source))?),
        };
        for entry in entries.into_iter().flatten() {
            let file = entry.map_err(|source| Fatal::read(&path, source))?.path();
            let stem = file.file_stem().and_then(|stem| stem.to_str());
            let Some(unit) = stem.filter(|_| file.extension().is_some_and(|ending| ending == "json")) else { continue };
            let kept = fs::read_to_string(&file).map_err(|source| Fatal::read(&file, source))?;
            received.know(unit, limits, Some(&kept)).map_err(|error| Fatal::new(Exit::Malformed, error))?;
        }
        if let Some(unit) = self.unit.as_ref().filter(|unit| !received.units().any(|known| known == *unit)) {
            received.know(unit, limits, None).map_err(|error| Fatal::new(Exit::Malformed, error))?;
        }
        Ok(received)
    }

    /// What is to be read, with its name.
    fn texts(&self) -> Result<Vec<(String, Vec<u8>)>, Fatal> {
        let mut texts = Vec::new();
        for path in &self.files {
            if path == Path::new("-") {
                let mut text = Vec::new();
                let read = io::stdin().lock().take(MOST_BYTES + 1).read_to_end(&mut text);
                read.map_err(|source| Fatal::read(path, source))?;
                texts.push(("-".to_owned(), text));
                continue;
            }
            let mut files = vec![path.clone()];
            if path.is_dir() {
                let entries = fs::read_dir(path).map_err(|source| Fatal::read(path, source))?;
                let is_report =
                    |file: &PathBuf| file.extension().is_some_and(|ending| ending == "json") && file.is_file();
                files = entries.filter_map(|entry| Some(entry.ok()?.path())).filter(is_report).collect();
                files.sort();
            }
            for file in files {
                let text = fs::File::open(&file).and_then(|open| {
                    let mut text = Vec::new();
                    open.take(MOST_BYTES + 1).read_to_end(&mut text).map(|_| text)
                });
                texts.push((print::path(&file), text.map_err(|source| Fatal::read(&file, source))?));
            }
        }
        Ok(texts)
    }

    /// Takes in a status report, or the totals alone.
    fn take(&self, document: &[u8], received: &mut Received) -> Result<(), DocumentError> {
        let malformed = |error: serde_json::Error| VotesError::Malformed { message: error.to_string() };
        let report: Report = serde_json::from_slice(document).map_err(malformed)?;
        let is_report = report.unit.is_some() || report.status.is_some();
        let totals = match report.votes.filter(|_| is_report) {
            Some(totals) => totals.to_json().into_bytes(),
            // A unit that does not send its votes says so by leaving them out.
            None if is_report => return Ok(()),
            None => document.to_owned(),
        };
        let unit = report.unit.as_deref().or(self.unit.as_deref()).ok_or(DocumentError::Nameless)?;
        received.take(unit, &totals, today().0)?;
        Ok(())
    }

    /// Writes the file of each unit.
    fn save(&self, received: &Received) -> Result<(), Fatal> {
        let folder = self.pool.join(FOLDER);
        fs::create_dir_all(&folder).map_err(|source| Fatal::write(&folder, source))?;
        for unit in received.units() {
            let Some(text) = received.to_json(unit) else { continue };
            let path = folder.join(format!("{unit}.json"));
            durable::write(&path, text.as_bytes()).map_err(|source| Fatal::write(&path, source))?;
        }
        Ok(())
    }

    fn tell(&self, answer: &Answer) -> Result<Exit, Fatal> {
        let exit = if answer.refused.is_empty() { Exit::Fine } else { Exit::No };
        if self.json {
            print::json(answer)?;
            return Ok(exit);
        }
        let line = |(unit, News { showings, up, down, sheep }): (&String, &News)| {
            format!("{unit}: {showings} showings, {up} votes for and {down} against are new, of {sheep} sheep")
        };
        print::lines(answer.units.iter().map(line))?;
        for Refused { file, why } in &answer.refused {
            print::note(&format!("`{file}` was refused: {why}"));
        }
        let is_unknown = |why: &DocumentError| matches!(why, DocumentError::Votes(VotesError::Unknown { .. }));
        if answer.refused.iter().any(|refused| is_unknown(&refused.why)) {
            print::note("note: `dreams votes POOL --unit NAME` makes a unit known");
        }
        if answer.due {
            print::note("note: enough was heard from units; `dreams breed` makes the next brood");
        }
        Ok(exit)
    }
}

/// The name of a unit, which is that of a file, too.
fn unit_name(text: &str) -> Result<String, String> {
    let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "._-".contains(c);
    let fits = (1..=64).contains(&text.len()) && text.chars().all(is_plain) && !text.starts_with('.');
    if fits { Ok(text.to_owned()) } else { Err("wanted 1 to 64 of a-z 0-9 . _ -, without a dot at the start".into()) }
}

/// The documents of a text, one after the other. They are not read here: a reader that knows their members refuses those
/// that are there twice.
fn documents(text: &[u8]) -> Vec<Result<&[u8], DocumentError>> {
    if text.len() as u64 > MOST_BYTES {
        return vec![Err(DocumentError::Long)];
    }
    let mut stream = serde_json::Deserializer::from_slice(text).into_iter::<IgnoredAny>();
    let (mut found, mut begin) = (Vec::new(), 0);
    while let Some(document) = stream.next() {
        let end = stream.byte_offset();
        found.push(document.map(|_| &text[begin..end]).map_err(DocumentError::Json));
        begin = end;
    }
    if found.is_empty() {
        found.push(Err(DocumentError::Empty));
    }
    found
}

/// The totals of a unit that are larger than those the pool heard of before.
fn grown(pool: &Pool, unit: &str, totals: &BTreeMap<String, SheepTotals>) -> BTreeMap<String, Count> {
    let count = |totals: &SheepTotals| {
        let up = totals.up.saturating_add(totals.near_s / NEAR_S).min(totals.shown);
        Count { shown: totals.shown.into(), up: up.into(), down: totals.down.into() }
    };
    let all = totals.iter().map(|(id, totals)| (id.clone(), count(totals)));
    all.filter(|(id, count)| count.since(pool.total(unit, id)) != Count::default()).collect()
}

/// How much is new in totals that have grown.
fn news(pool: &Pool, unit: &str, sheep: &BTreeMap<String, Count>) -> News {
    let new = || sheep.iter().map(|(id, count)| count.since(pool.total(unit, id)));
    let sum = |of: fn(Count) -> u64| new().map(of).fold(0, u64::saturating_add);
    News {
        showings: sum(|count| count.shown),
        up: sum(|count| count.up),
        down: sum(|count| count.down),
        sheep: sheep.len(),
    }
}
