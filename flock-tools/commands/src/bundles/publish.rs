//! `dreams publish`: copies bundles to a stick, or to a web server's folder.
//!
//! Owns the command and its order. Seals, lists and free space are checked before anything is written. Then the content is
//! copied, checked and synced to the disk; then the statements of keys; the seals last. A unit that reads meanwhile, or
//! after the stick was pulled, finds either the old bundle or the new one. Content that is there is not written again.
//!
//! Start at [`run`].

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use bundle::{
    Addressees, Folder, ObjectId, PutMethod, Sequence, Source, Sweep, System, Trust, UnitId, VerifiedBundle, statements,
};
use indicatif::DecimalBytes;
use operations::program::{Exit, Fatal, now, print, progress};

use super::fleet::{self, Fleet, Row};
use super::{bundle_folder, folder_fatal, key_fatal, system};

/// Lay bundles out on a stick, or in a folder for any web server: only what is new, safely in any order
///
/// Give the mount point of the stick, or the folder of the server: units look for bundles right there. If it is
/// interrupted, the old bundles are still there, and the same command continues. The bundle of each unit is noted in
/// `fleet.toml` beside the bundles.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  everything is there, on the disk; the stick may be pulled
  1  a bundle is refused or damaged, or a newer one of its key is there for the same unit; the old bundles are still there
  2  the command line, a key or `fleet.toml` is wrong
  3  a file could not be read or written, or there is no room; the same command continues")]
pub struct Args {
    /// Folder of the bundles, as `dreams pack` made it
    bundle: PathBuf,
    /// The target: a folder that exists
    to: PathBuf,
    /// The public key to trust, or a folder of such keys
    #[arg(long, value_name = "PUB")]
    trust: PathBuf,
    /// Only the bundle of this unit; may be repeated [default: all in the folder]
    #[arg(long = "unit", value_name = "UNIT", value_parser = UnitId::new)]
    units: Vec<UnitId>,
    /// Read back the content that is there, and replace what is damaged
    #[arg(long)]
    check: bool,
    /// Remove content that no bundle there needs any more
    #[arg(long)]
    prune: bool,
    /// The table of units [default: fleet.toml beside the bundles]
    #[arg(long, value_name = "FILE")]
    fleet: Option<PathBuf>,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct Answer {
    units: Vec<Row>,
    systems: Vec<String>,
    /// Objects that were not there.
    new_objects: usize,
    /// Their bytes.
    new_bytes: u64,
    /// Objects that were there, and stay.
    kept_objects: usize,
    /// Objects that were there and damaged, and were replaced.
    replaced_objects: usize,
    /// Removed by `--prune`.
    pruned_files: usize,
    pruned_bytes: u64,
}

/// Why nothing is published.
#[derive(Debug, thiserror::Error)]
enum PublishError {
    #[error("`{path}` has no room: {needed} needed, {room} free")]
    NoRoom { path: PathBuf, needed: DecimalBytes, room: DecimalBytes },
    #[error("`{path}` has sequence {there} of the same key for {unit}, this is {sequence}")]
    Older { path: PathBuf, unit: String, sequence: Sequence, there: Sequence },
    #[error("cannot tell what `{seal}` in `{path}` needs")]
    Unknown { path: PathBuf, seal: String },
}

/// The bundles and systems to publish, each with the unit that it is for.
struct Publication {
    bundles: Vec<(Option<UnitId>, VerifiedBundle)>,
    systems: Systems,
}

type Systems = Vec<(Option<UnitId>, System)>;
/// Objects and their sizes.
type Objects = BTreeMap<ObjectId, u64>;

/// The content to write.
struct WritePlan {
    /// Every object and every list that is missing, with its size.
    new: Vec<(ObjectId, u64)>,
    kept: usize,
    replaced: usize,
}

impl Publication {
    /// All objects, the lists of files among them.
    fn objects(&self) -> Objects {
        let mut objects = Objects::new();
        for (_, bundle) in &self.bundles {
            let letter = bundle.seal().letter();
            objects.insert(letter.contents, letter.contents_size);
            objects.extend(letter.statements);
            objects.extend(bundle.contents().files().iter().map(|file| (file.id, file.size)));
        }
        let halves = self.systems.iter().flat_map(|(_, system)| system.halves());
        objects.extend(halves.map(|half| (half.id, half.size)));
        objects.extend(self.systems.iter().filter_map(|(_, system)| system.release().statements));
        objects
    }
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let trust = Trust::read(&args.trust).map_err(key_fatal)?;
    let table = args.fleet.clone().unwrap_or_else(|| args.bundle.join(fleet::FILE_NAME));
    let mut fleet = Fleet::read(&table)?;
    let systems = good_systems(&args.bundle, system::read(&args.bundle, &trust, &args.units)?)?;
    let entries = bundle_folder::read_beside_others(&args.bundle, &trust, &args.units, !systems.is_empty())?;
    let publication = Publication { bundles: bundle_folder::good_bundles(&args.bundle, entries)?, systems };
    let to = Folder::open(&args.to).map_err(folder_fatal)?;
    // One writer at a time. On a file system without locks the artist must not publish twice at once.
    let _lock = File::open(&args.to).ok().filter(|folder| folder.lock().is_ok());
    refuse_older(args, &trust, &publication)?;
    to.sweep(|_| true).map_err(folder_fatal)?;
    let objects = publication.objects();
    let plan = write_plan(args, &to, &objects)?;
    let mut pruned = make_room(args, &trust, &to, &objects, &plan)?;
    let written = write_all(args, &to, &publication, &plan)?;
    if args.prune {
        let Sweep { files, bytes } = prune(args, &trust, &to, &BTreeMap::new())?;
        pruned = Sweep { files: pruned.files + files, bytes: pruned.bytes + bytes };
    }
    let rows: Vec<Row> = publication.bundles.iter().map(|(unit, bundle)| row(args, unit.as_ref(), bundle)).collect();
    for row in &rows {
        fleet.set(row.clone());
    }
    fleet.save(&table)?;
    let answer = Answer {
        units: rows,
        systems: publication.systems.iter().map(|(unit, system)| system::line(unit.as_ref(), system)).collect(),
        new_objects: plan.new.len(),
        new_bytes: written,
        kept_objects: plan.kept,
        replaced_objects: plan.replaced,
        pruned_files: pruned.files,
        pruned_bytes: pruned.bytes,
    };
    if args.json {
        print::json(&answer)?;
    } else {
        print::lines(lines(&answer))?;
    }
    Ok(Exit::Fine)
}

/// The systems of `entries` in the folder at `path`, all of which must be good.
fn good_systems(path: &Path, entries: Vec<system::SystemEntry>) -> Result<Systems, Fatal> {
    let good = |system::SystemEntry { unit, seal, system }: system::SystemEntry| match system {
        Ok(system) => Ok((unit, system)),
        Err(source) => Err(bundle_folder::refused_seal(path, seal, source)),
    };
    entries.into_iter().map(good).collect()
}

/// Ends the command if another bundle of the same key for the same unit is there that is as new or newer.
fn refuse_older(args: &Args, trust: &Trust, publication: &Publication) -> Result<(), Fatal> {
    let older = |unit: Option<&UnitId>, sequence, there| {
        let unit = addressee(unit);
        Err(Fatal::new(Exit::No, PublishError::Older { path: args.to.clone(), unit, sequence, there }))
    };
    let there = bundle_folder::read_all(&args.to, trust)?;
    for (unit, bundle) in &publication.bundles {
        let twin = there.iter().filter(|entry| entry.unit == *unit).find_map(|entry| entry.bundle.as_ref().ok());
        let (seal, Some(twin)) = (bundle.seal(), twin.map(VerifiedBundle::seal)) else { continue };
        let (sequence, there) = (seal.letter().sequence, twin.letter().sequence);
        if twin.signer() == seal.signer() && there >= sequence && twin.id() != seal.id() {
            return older(unit.as_ref(), sequence, there);
        }
    }
    let there = system::read(&args.to, trust, &[])?;
    for (unit, system) in &publication.systems {
        let twin = there.iter().filter(|entry| entry.unit == *unit).find_map(|entry| entry.system.as_ref().ok());
        let Some(twin) = twin.filter(|twin| twin.signer() == system.signer() && *twin != system) else { continue };
        let (sequence, there) = (system.release().sequence, twin.release().sequence);
        if there >= sequence {
            return older(unit.as_ref(), sequence, there);
        }
    }
    Ok(())
}

/// The content to write; with `--check`, damaged objects in the folder are removed first.
fn write_plan(args: &Args, to: &Folder, objects: &Objects) -> Result<WritePlan, Fatal> {
    let objects = objects.iter().map(|(id, size)| (*id, *size));
    let (held, mut new): (Vec<_>, Vec<_>) = objects.partition(|(id, size)| to.holds(id, *size));
    let damaged = if args.check { bundle_folder::damaged(&args.to, &held) } else { Vec::new() };
    for (id, _) in &damaged {
        to.discard(id).map_err(folder_fatal)?;
    }
    let (kept, replaced) = (held.len() - damaged.len(), damaged.len());
    new.extend(damaged);
    Ok(WritePlan { new, kept, replaced })
}

/// Ends the command if there is no room. With `--prune` content is removed before that which neither the bundles there nor
/// the new ones need.
fn make_room(args: &Args, trust: &Trust, to: &Folder, objects: &Objects, plan: &WritePlan) -> Result<Sweep, Fatal> {
    let needed = plan.new.iter().map(|(_, size)| size).sum::<u64>();
    let room = || to.free_bytes().map_err(folder_fatal);
    if needed <= room()? || is_cloned(args, to, plan) {
        return Ok(Sweep::default());
    }
    let pruned = if args.prune { prune(args, trust, to, objects)? } else { Sweep::default() };
    let room = room()?;
    if needed <= room {
        return Ok(pruned);
    }
    let (needed, room) = (DecimalBytes(needed), DecimalBytes(room));
    let fatal = Fatal::new(Exit::Unreadable, PublishError::NoRoom { path: args.to.clone(), needed, room });
    Err(fatal.hint(if args.prune {
        "the bundles there stay until the new ones are; give an empty stick, or empty this one"
    } else {
        "--prune removes what no bundle there needs any more"
    }))
}

/// Whether the content of `plan` is cloned, and needs no room.
fn is_cloned(args: &Args, to: &Folder, plan: &WritePlan) -> bool {
    let mut whole = plan.new.iter().filter_map(|(id, _)| File::open(args.bundle.join(id.path())).ok());
    whole.next().is_some_and(|file| to.clones(&file))
}

/// Writes all of `plan`, then the statements, the seals last. Returns the bytes of the new content. Shows its progress on a
/// terminal.
fn write_all(args: &Args, to: &Folder, publication: &Publication, plan: &WritePlan) -> Result<u64, Fatal> {
    let mut from = Folder::open(&args.bundle).map_err(folder_fatal)?;
    let total = plan.new.iter().map(|(_, size)| size).sum();
    let bar = progress::bytes("publishing", total);
    for (id, size) in &plan.new {
        let before = bar.position();
        put(&mut from, to, id, *size, &mut |bytes| bar.inc(bytes))?;
        bar.set_position(before + size);
    }
    bar.finish_and_clear();
    let bytes = bundle_folder::statements(&mut from);
    let all: Vec<Vec<u8>> = statements(&bytes).into_iter().map(<[u8]>::to_vec).collect();
    to.add_statements(&all).map_err(folder_fatal)?;
    for (unit, system) in &publication.systems {
        to.put_system(&Addressees::of(unit.clone()), system.bytes()).map_err(folder_fatal)?;
    }
    for (unit, bundle) in &publication.bundles {
        to.put_seal(&Addressees::of(unit.clone()), bundle.seal().bytes()).map_err(folder_fatal)?;
    }
    Ok(total)
}

/// Puts one object into `to`.
fn put(
    from: &mut Folder,
    to: &Folder,
    id: &ObjectId,
    size: u64,
    moved: &mut dyn FnMut(u64),
) -> Result<PutMethod, Fatal> {
    let path = from.path().join(id.path());
    if path.exists() {
        return to.put_file(id, size, &path, moved).map_err(folder_fatal);
    }
    let mut reader = from
        .object(id, size, 0)
        .map_err(|source| folder_fatal(bundle::FolderError::Read { path: path.clone(), source }))?;
    to.put(id, size, &mut reader, &path, moved).map_err(folder_fatal)
}

/// Removes content that no bundle there needs and that is not among these `objects`.
fn prune(args: &Args, trust: &Trust, to: &Folder, objects: &Objects) -> Result<Sweep, Fatal> {
    let mut needed: BTreeSet<ObjectId> = BTreeSet::new();
    let unknown = |seal| {
        let unknown = PublishError::Unknown { path: args.to.clone(), seal };
        Fatal::new(Exit::No, unknown).hint("a bundle that cannot be read may need any content: nothing was pruned")
    };
    for entry in bundle_folder::read_all(&args.to, trust)? {
        let bundle = entry.bundle.map_err(|_| unknown(entry.seal))?;
        let letter = bundle.seal().letter();
        needed.extend([Some(letter.contents), letter.statements.map(|(id, _)| id)].into_iter().flatten());
        needed.extend(bundle.contents().files().iter().map(|file| file.id));
    }
    for entry in system::read(&args.to, trust, &[])? {
        let system = entry.system.map_err(|_| unknown(entry.seal))?;
        needed.extend(system.halves().map(|half| half.id));
        needed.extend(system.release().statements.map(|(id, _)| id));
    }
    to.sweep(|id| needed.contains(id) || objects.contains_key(id)).map_err(folder_fatal)
}

fn row(args: &Args, unit: Option<&UnitId>, bundle: &VerifiedBundle) -> Row {
    let (seal, to) = (bundle.seal(), fs::canonicalize(&args.to).unwrap_or_else(|_| args.to.clone()));
    Row {
        id: unit.map_or_else(|| Addressees::Anyone.to_string(), ToString::to_string),
        flock: seal.letter().flock.clone(),
        sequence: seal.letter().sequence.0,
        key: seal.signer().to_string(),
        to: to.display().to_string(),
        published: now::date(),
        place: None,
    }
}

fn addressee(unit: Option<&UnitId>) -> String {
    unit.map_or_else(|| "every unit".to_owned(), |unit| format!("unit `{unit}`"))
}

fn lines(answer: &Answer) -> Vec<String> {
    let Answer { units, systems, new_objects, new_bytes, kept_objects, replaced_objects, pruned_files, pruned_bytes } =
        answer;
    let mut lines: Vec<String> =
        units.iter().map(|row| format!("{}: `{}`, sequence {}", row.id, row.flock, row.sequence)).collect();
    lines.extend(systems.iter().cloned());
    let written = print::count(*new_objects, "object");
    lines.push(format!("{written} written, {}; {kept_objects} there already", DecimalBytes(*new_bytes)));
    if *replaced_objects > 0 {
        lines.push(format!("{replaced_objects} of them in the place of what was damaged"));
    }
    if *pruned_files > 0 {
        lines.push(format!("{} removed, {}", print::count(*pruned_files, "file"), DecimalBytes(*pruned_bytes)));
    }
    lines
}
