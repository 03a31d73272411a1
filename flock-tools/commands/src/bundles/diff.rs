//! `dreams diff`: what a unit would have to fetch.
//!
//! Owns the command and its answer. The bundle crate makes the plan, here as on the unit: each content is fetched once, by
//! its hash.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use bundle::{Contents, ObjectId, Presence, Trust, UnitId, plan};
use indicatif::DecimalBytes;
use operations::flock_folder::{file_list, open};
use operations::program::{Exit, Fatal, print};

use super::{bundle_folder, key_fatal};

/// Tell what differs between two flocks or bundles, and how much a unit with the one would fetch for the other
///
/// Each is the folder of a flock or of bundles, in any mixture. A unit fetches content by its hash: a clip that was
/// only renamed is not fetched.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the answer is printed, whether they differ or not
  1  a bundle is refused, or there is none for the unit
  2  the command line, a manifest or a key is wrong
  3  a file could not be read")]
pub struct Args {
    /// What a unit has: the folder of a flock or of bundles
    old: PathBuf,
    /// What it would be given: the folder of a flock or of bundles
    new: PathBuf,
    /// The public key to trust, or a folder of such keys; needed for bundles
    #[arg(long, value_name = "PUB")]
    trust: Option<PathBuf>,
    /// In folders with several bundles, the bundle of this unit
    #[arg(long, value_name = "UNIT", value_parser = UnitId::new)]
    unit: Option<UnitId>,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct Answer {
    /// Files that only the new one has.
    added: Vec<String>,
    /// Files that both have, with other content.
    changed: Vec<String>,
    /// Files that only the old one has.
    removed: Vec<String>,
    /// Files of the new one.
    files: usize,
    /// Their bytes, each content once.
    bytes: u64,
    /// The number of objects that would be fetched.
    fetch_objects: usize,
    /// Their bytes.
    fetch_bytes: u64,
    /// The bytes of the list of files, which is fetched too.
    list_bytes: usize,
}

/// Why the two folders cannot be compared.
#[derive(Debug, thiserror::Error)]
enum DiffError {
    #[error("there are {count} bundles in `{path}`")]
    Several { path: PathBuf, count: usize },
    #[error("the bundles in `{path}` cannot be read without a key to trust")]
    Untrusted { path: PathBuf },
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let answer = compare(&contents(args, &args.old)?, &contents(args, &args.new)?);
    if args.json {
        print::json(&answer)?;
    } else {
        print::lines(lines(&answer))?;
    }
    Ok(Exit::Fine)
}

/// The files of the flock, or of the bundle, in `folder`.
fn contents(args: &Args, folder: &Path) -> Result<Contents, Fatal> {
    if !bundle_folder::is_bundle_folder(folder) {
        return file_list::contents(folder, &open::manifest(folder)?);
    }
    let Some(trust) = &args.trust else {
        let untrusted = DiffError::Untrusted { path: folder.to_owned() };
        return Err(Fatal::new(Exit::Malformed, untrusted).hint("--trust names the key"));
    };
    let trust = Trust::read(trust).map_err(key_fatal)?;
    let entries = bundle_folder::read(folder, &trust, args.unit.as_slice())?;
    let mut bundles = bundle_folder::good_bundles(folder, entries)?;
    bundles.dedup_by(|(_, a), (_, b)| a.contents() == b.contents());
    match bundles.pop() {
        Some((_, bundle)) if bundles.is_empty() => Ok(bundle.contents().clone()),
        _ => {
            let several = DiffError::Several { path: folder.to_owned(), count: bundles.len() + 1 };
            Err(Fatal::new(Exit::Malformed, several).hint("--unit names the unit"))
        }
    }
}

fn compare(old: &Contents, new: &Contents) -> Answer {
    let there: BTreeSet<ObjectId> = old.files().iter().map(|file| file.id).collect();
    let held = |id: &ObjectId| if there.contains(id) { Presence::Whole } else { Presence::Nothing };
    let Ok(plan) = plan(new, |file| Ok::<_, std::convert::Infallible>(held(&file.id)));
    let id = |contents: &Contents, path: &str| contents.file(path).map(|file| file.id);
    let mut answer = Answer {
        added: Vec::new(),
        changed: Vec::new(),
        removed: Vec::new(),
        files: new.files().len(),
        bytes: plan.bytes,
        fetch_objects: plan.wanted.len(),
        fetch_bytes: plan.to_fetch(),
        list_bytes: new.to_text().len(),
    };
    for file in new.files() {
        match id(old, file.path.as_str()) {
            None => answer.added.push(file.path.to_string()),
            Some(other) if other != file.id => answer.changed.push(file.path.to_string()),
            Some(_) => {}
        }
    }
    let gone = old.files().iter().filter(|file| id(new, file.path.as_str()).is_none());
    answer.removed = gone.map(|file| file.path.to_string()).collect();
    answer
}

fn lines(answer: &Answer) -> Vec<String> {
    let Answer { added, changed, removed, files, bytes, fetch_objects, fetch_bytes, list_bytes } = answer;
    let marked = [('+', added), ('~', changed), ('-', removed)];
    let mut lines: Vec<String> =
        marked.iter().flat_map(|(mark, paths)| paths.iter().map(move |path| format!("{mark} {path}"))).collect();
    let (objects, files) = (print::count(*fetch_objects, "object"), print::count(*files, "file"));
    lines.push(format!(
        "a unit would fetch {objects}, {}, of {files}, {}; and the list of files, {}",
        DecimalBytes(*fetch_bytes),
        DecimalBytes(*bytes),
        DecimalBytes(*list_bytes as u64)
    ));
    lines
}
