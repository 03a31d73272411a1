//! `flock publish`: bundles on their way to a stick, or to a web server's folder.
//!
//! Owns the command and its order: seals and lists are verified, and that all fits, before anything is written; then
//! content, checked on its way and all of it on the disk; then what keys say; seals last. Whoever reads there meanwhile,
//! or after the stick was pulled, finds the bundle of before or the new one. What is there is not written again.
//!
//! Start at [`run`].

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use bundle::{
    Addressees, Folder, ObjectId, PutMethod, Sequence, Source, Sweep, System, Trust, UnitId, VerifiedBundle, statements,
};
use indicatif::DecimalBytes;

use super::fleet::{self, Fleet, Row};
use super::{shelf, system, unmoved, unusable};
use crate::now;
use crate::progress;
use crate::report::{self, Exit, Fatal};

/// Lay bundles out on a stick, or in a folder for any web server: only what is new, safely in any order
///
/// Give the stick's mount point, or the server's folder: units look for bundles right there. Interrupted at any moment
/// it leaves the bundles of before; given again it goes on where it was. What each unit was given is written down in
/// `fleet.toml` beside the bundles.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  everything is there, on the disk; the stick may be pulled
  1  a bundle is refused or damaged, or a newer one of its key lies there for the same unit; what lay there still holds
  2  the command line, a key or `fleet.toml` is wrong
  3  a file could not be read or written, or there is no room; given again it goes on from there")]
pub(crate) struct Args {
    /// Folder of the bundles, as `flock pack` made it
    bundle: PathBuf,
    /// Where to: a folder that is there
    to: PathBuf,
    /// The public key to trust, or a folder of such keys
    #[arg(long, value_name = "PUB")]
    trust: PathBuf,
    /// Only what this unit would be given; may be repeated [default: all that lies in the folder]
    #[arg(long = "unit", value_name = "UNIT", value_parser = UnitId::new)]
    units: Vec<UnitId>,
    /// Read back what lies there already, and replace what is damaged
    #[arg(long)]
    check: bool,
    /// Afterwards remove content that no bundle there needs any more
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
    /// What they take.
    new_bytes: u64,
    /// Objects that were there, and stay.
    kept_objects: usize,
    /// Objects that were there and damaged, and were replaced.
    replaced_objects: usize,
    /// What `--prune` removed.
    pruned_files: usize,
    pruned_bytes: u64,
}

/// Why nothing is published.
#[derive(Debug, thiserror::Error)]
enum Unpublished {
    #[error("`{path}` has no room: {needed} needed, {room} free")]
    NoRoom { path: PathBuf, needed: DecimalBytes, room: DecimalBytes },
    #[error("for {unit} sequence {there} of the same key lies in `{path}`, this is {sequence}")]
    Older { path: PathBuf, unit: String, sequence: Sequence, there: Sequence },
    #[error("cannot tell what `{seal}` in `{path}` needs")]
    Unknown { path: PathBuf, seal: String },
}

/// What is to be published: each seal's place, and what it vouches for.
struct Cargo {
    bundles: Vec<(Option<UnitId>, VerifiedBundle)>,
    systems: Systems,
}

type Systems = Vec<(Option<UnitId>, System)>;
/// Objects, and how large they are.
type Objects = BTreeMap<ObjectId, u64>;

/// What is to be written.
struct Freight {
    /// Every object and every list that is not there, with its size.
    new: Vec<(ObjectId, u64)>,
    kept: usize,
    replaced: usize,
}

impl Cargo {
    /// Everything that is vouched for, and the lists that say so.
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
pub(crate) fn run(args: &Args) -> Result<Exit, Fatal> {
    let trust = Trust::read(&args.trust).map_err(unusable)?;
    let table = args.fleet.clone().unwrap_or_else(|| args.bundle.join(fleet::FILE_NAME));
    let mut fleet = Fleet::read(&table)?;
    let systems = systems(&args.bundle, system::read(&args.bundle, &trust, &args.units)?)?;
    let found = shelf::read_beside(&args.bundle, &trust, &args.units, !systems.is_empty())?;
    let cargo = Cargo { bundles: shelf::bundles(&args.bundle, found)?, systems };
    let to = Folder::open(&args.to).map_err(unmoved)?;
    // One writer at a time; where a file system knows no locks, that is the artist's to see to.
    let _lock = File::open(&args.to).ok().filter(|folder| folder.lock().is_ok());
    refuse_older(args, &trust, &cargo)?;
    to.sweep(|_| true).map_err(unmoved)?;
    let objects = cargo.objects();
    let freight = freight(args, &to, &objects)?;
    let mut pruned = make_room(args, &trust, &to, &objects, &freight)?;
    let sent = send(args, &to, &cargo, &freight)?;
    if args.prune {
        let Sweep { files, bytes } = prune(args, &trust, &to, &BTreeMap::new())?;
        pruned = Sweep { files: pruned.files + files, bytes: pruned.bytes + bytes };
    }
    let rows: Vec<Row> = cargo.bundles.iter().map(|(unit, bundle)| row(args, unit.as_ref(), bundle)).collect();
    for row in &rows {
        fleet.note(row.clone());
    }
    fleet.save(&table)?;
    let answer = Answer {
        units: rows,
        systems: cargo.systems.iter().map(|(unit, system)| system::line(unit.as_ref(), system)).collect(),
        new_objects: freight.new.len(),
        new_bytes: sent,
        kept_objects: freight.kept,
        replaced_objects: freight.replaced,
        pruned_files: pruned.files,
        pruned_bytes: pruned.bytes,
    };
    if args.json {
        report::json(&answer)?;
    } else {
        report::lines(told(&answer))?;
    }
    Ok(Exit::Fine)
}

/// The systems that were `found` in the folder at `path`, all of which must be good.
fn systems(path: &Path, found: Vec<system::Found>) -> Result<Systems, Fatal> {
    let good = |system::Found { unit, seal, system }: system::Found| match system {
        Ok(system) => Ok((unit, system)),
        Err(source) => Err(shelf::bad(path, seal, source)),
    };
    found.into_iter().map(good).collect()
}

/// Ends the command if a bundle of the same key that is no older, but another one, lies there for the same unit.
fn refuse_older(args: &Args, trust: &Trust, cargo: &Cargo) -> Result<(), Fatal> {
    let older = |unit: Option<&UnitId>, sequence, there| {
        let unit = addressee(unit);
        Err(Fatal::new(Exit::No, Unpublished::Older { path: args.to.clone(), unit, sequence, there }))
    };
    let there = shelf::read_all(&args.to, trust)?;
    for (unit, bundle) in &cargo.bundles {
        let twin = there.iter().filter(|found| found.unit == *unit).find_map(|found| found.bundle.as_ref().ok());
        let (seal, Some(twin)) = (bundle.seal(), twin.map(VerifiedBundle::seal)) else { continue };
        let (sequence, there) = (seal.letter().sequence, twin.letter().sequence);
        if twin.signer() == seal.signer() && there >= sequence && twin.id() != seal.id() {
            return older(unit.as_ref(), sequence, there);
        }
    }
    let there = system::read(&args.to, trust, &[])?;
    for (unit, system) in &cargo.systems {
        let twin = there.iter().filter(|found| found.unit == *unit).find_map(|found| found.system.as_ref().ok());
        let Some(twin) = twin.filter(|twin| twin.signer() == system.signer() && *twin != system) else { continue };
        let (sequence, there) = (system.release().sequence, twin.release().sequence);
        if there >= sequence {
            return older(unit.as_ref(), sequence, there);
        }
    }
    Ok(())
}

/// What has to be written.
fn freight(args: &Args, to: &Folder, objects: &Objects) -> Result<Freight, Fatal> {
    let objects = objects.iter().map(|(id, size)| (*id, *size));
    let (held, mut new): (Vec<_>, Vec<_>) = objects.partition(|(id, size)| to.holds(id, *size));
    let damaged = if args.check { shelf::damaged(&args.to, &held) } else { Vec::new() };
    for (id, _) in &damaged {
        to.discard(id).map_err(unmoved)?;
    }
    let (kept, replaced) = (held.len() - damaged.len(), damaged.len());
    new.extend(damaged);
    Ok(Freight { new, kept, replaced })
}

/// Sees to it that the freight fits, with `--prune` by removing what is needed neither by the bundles there nor by the
/// new ones.
fn make_room(args: &Args, trust: &Trust, to: &Folder, objects: &Objects, freight: &Freight) -> Result<Sweep, Fatal> {
    let needed = freight.new.iter().map(|(_, size)| size).sum::<u64>();
    let room = || to.free_bytes().map_err(unmoved);
    // A disk that shares or links needs less; only what must be copied has to fit.
    if needed <= room()? || shares(&args.bundle, &args.to) {
        return Ok(Sweep::default());
    }
    let pruned = if args.prune { prune(args, trust, to, objects)? } else { Sweep::default() };
    let room = room()?;
    if needed <= room {
        return Ok(pruned);
    }
    let (needed, room) = (DecimalBytes(needed), DecimalBytes(room));
    let fatal = Fatal::new(Exit::Unreadable, Unpublished::NoRoom { path: args.to.clone(), needed, room });
    Err(fatal.hint(if args.prune {
        "the bundles there stay until the new ones are; give an empty stick, or empty this one"
    } else {
        "--prune removes what no bundle there needs any more"
    }))
}

/// Whether two folders lie on the same disk.
fn shares(one: &Path, other: &Path) -> bool {
    let disk = |path: &Path| fs::metadata(path).map(|status| std::os::unix::fs::MetadataExt::dev(&status)).ok();
    disk(one).is_some() && disk(one) == disk(other)
}

/// Writes it all, seals last. Returns the bytes that were not there before. Shows its progress on a terminal.
fn send(args: &Args, to: &Folder, cargo: &Cargo, freight: &Freight) -> Result<u64, Fatal> {
    let mut from = Folder::open(&args.bundle).map_err(unmoved)?;
    let total = freight.new.iter().map(|(_, size)| size).sum();
    let bar = progress::bytes("publishing", total);
    for (id, size) in &freight.new {
        let before = bar.position();
        put(&mut from, to, id, *size, &mut |bytes| bar.inc(bytes))?;
        bar.set_position(before + size);
    }
    bar.finish_and_clear();
    let said = shelf::said(&mut from);
    let said: Vec<Vec<u8>> = statements(&said).into_iter().map(<[u8]>::to_vec).collect();
    to.add_statements(&said).map_err(unmoved)?;
    for (unit, system) in &cargo.systems {
        to.put_system(&Addressees::of(unit.clone()), system.bytes()).map_err(unmoved)?;
    }
    for (unit, bundle) in &cargo.bundles {
        to.put_seal(&Addressees::of(unit.clone()), bundle.seal().bytes()).map_err(unmoved)?;
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
        return to.put_file(id, size, &path, moved).map_err(unmoved);
    }
    let mut reader =
        from.object(id, size, 0).map_err(|source| unmoved(bundle::FolderError::Read { path: path.clone(), source }))?;
    to.put(id, size, &mut reader, &path, moved).map_err(unmoved)
}

/// Removes what no bundle there needs, and what is not among these `objects`.
fn prune(args: &Args, trust: &Trust, to: &Folder, objects: &Objects) -> Result<Sweep, Fatal> {
    let mut needed: BTreeSet<ObjectId> = BTreeSet::new();
    let unknown = |seal| {
        let unknown = Unpublished::Unknown { path: args.to.clone(), seal };
        Fatal::new(Exit::No, unknown).hint("what cannot be read may need anything: nothing was pruned")
    };
    for found in shelf::read_all(&args.to, trust)? {
        let bundle = found.bundle.map_err(|_| unknown(found.seal))?;
        let letter = bundle.seal().letter();
        needed.extend([Some(letter.contents), letter.statements.map(|(id, _)| id)].into_iter().flatten());
        needed.extend(bundle.contents().files().iter().map(|file| file.id));
    }
    for found in system::read(&args.to, trust, &[])? {
        let system = found.system.map_err(|_| unknown(found.seal))?;
        needed.extend(system.halves().map(|half| half.id));
        needed.extend(system.release().statements.map(|(id, _)| id));
    }
    to.sweep(|id| needed.contains(id) || objects.contains_key(id)).map_err(unmoved)
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

fn told(answer: &Answer) -> Vec<String> {
    let Answer { units, systems, new_objects, new_bytes, kept_objects, replaced_objects, pruned_files, pruned_bytes } =
        answer;
    let mut lines: Vec<String> =
        units.iter().map(|row| format!("{}: `{}`, sequence {}", row.id, row.flock, row.sequence)).collect();
    lines.extend(systems.iter().cloned());
    let written = report::count(*new_objects, "object");
    lines.push(format!("{written} written, {}; {kept_objects} there already", DecimalBytes(*new_bytes)));
    if *replaced_objects > 0 {
        lines.push(format!("{replaced_objects} of them in the place of what was damaged"));
    }
    if *pruned_files > 0 {
        lines.push(format!("{} removed, {}", report::count(*pruned_files, "file"), DecimalBytes(*pruned_bytes)));
    }
    lines
}
