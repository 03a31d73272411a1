//! A folder of bundles, read as its units would read it.
//!
//! Owns which seals lie there, what each vouches for, and whether all of that is there and as it was signed. Never
//! changes anything, and stops at no fault: whoever asks wants to know them all.
//!
//! Start at [`read`].

use std::collections::BTreeSet;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use bundle::{
    Addressees, FileEntry, Folder, ObjectId, Refusal, STATEMENTS, Seal, Source, Trust, UnitId, UnverifiedSeal,
    VerifiedBundle, limits, seal_path,
};
use flock::FILE_NAME;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::fleet::Fleet;
use super::{system, unmoved};
use crate::progress;
use crate::report::{Exit, Fatal, chain};

/// Where all seals lie.
const SEALS: &str = "seals";

/// A seal, and what became of it.
pub(super) struct Found {
    /// The unit that it lies there for; `None` for every unit.
    pub(super) unit: Option<UnitId>,
    /// Where it lies in the folder.
    pub(super) seal: String,
    /// What it vouches for, or why a unit would refuse it.
    pub(super) bundle: Result<VerifiedBundle, Box<Refusal>>,
}

/// What is wrong with a folder of bundles.
#[derive(Clone, Debug, serde::Serialize)]
pub(super) struct Fault {
    pub(super) kind: Kind,
    /// Where the seal lies, if it is that seal's fault.
    #[serde(skip_serializing_if = "Option::is_none")]
    seal: Option<String>,
    /// The file of the flock.
    #[serde(skip_serializing_if = "Option::is_none")]
    path: Option<String>,
    /// Where its content lies in the folder.
    #[serde(skip_serializing_if = "Option::is_none")]
    object: Option<String>,
    /// A sentence for people.
    pub(super) message: String,
}

/// What kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Kind {
    /// Other bytes than were signed.
    Damaged,
    /// More bytes than were signed.
    Long,
    /// Not there.
    Missing,
    /// No flock that a player could play.
    NotAFlock,
    /// A seal, or its list of files, that a unit would refuse.
    Refused,
    /// Fewer bytes than were signed.
    Short,
    /// The disk fails.
    Unreadable,
}

/// A folder without what was looked for.
#[derive(Debug, thiserror::Error)]
enum Absent {
    #[error("there is no bundle in `{path}`")]
    Bundle { path: PathBuf },
    #[error("there is no bundle for unit `{unit}` in `{path}`")]
    Unit { path: PathBuf, unit: UnitId },
}

/// A bundle that has to be good and is not.
#[derive(Debug, thiserror::Error)]
#[error("`{seal}` in `{path}` is refused")]
struct Bad {
    path: PathBuf,
    seal: String,
    source: Box<Refusal>,
}

/// Whether the folder at `path` is one of bundles.
pub(super) fn is_one(path: &Path) -> bool {
    path.join(SEALS).is_dir()
}

/// Reads every seal in the folder at `path`, or those that `units` would be given, and what they vouch for. `pinned`
/// are the keys to trust; what they say there about others counts, as it would on a unit. There must be one.
pub(super) fn read(path: &Path, pinned: &Trust, units: &[UnitId]) -> Result<Vec<Found>, Fatal> {
    let mut folder = Folder::open(path).map_err(unmoved)?;
    let there = folder.seals().map_err(unmoved)?;
    let wanted: BTreeSet<Option<UnitId>> = if units.is_empty() {
        there
    } else {
        let given = |unit: &UnitId| {
            let found = [Some(unit.clone()), None].into_iter().find(|addressee| there.contains(addressee));
            found.ok_or_else(|| Fatal::new(Exit::No, Absent::Unit { path: path.to_owned(), unit: unit.clone() }))
        };
        units.iter().map(given).collect::<Result<_, _>>()?
    };
    if wanted.is_empty() {
        return Err(Fatal::new(Exit::No, Absent::Bundle { path: path.to_owned() }));
    }
    Ok(find(&mut folder, pinned, wanted))
}

/// The same; there need be none if `there_are_systems` for these units.
pub(super) fn read_beside(
    path: &Path,
    pinned: &Trust,
    units: &[UnitId],
    there_are_systems: bool,
) -> Result<Vec<Found>, Fatal> {
    if there_are_systems && !is_one(path) { Ok(Vec::new()) } else { read(path, pinned, units) }
}

/// The same, of whatever lies there, if anything does.
pub(super) fn read_all(path: &Path, pinned: &Trust) -> Result<Vec<Found>, Fatal> {
    let mut folder = Folder::open(path).map_err(unmoved)?;
    let wanted = if is_one(path) { folder.seals().map_err(unmoved)? } else { BTreeSet::new() };
    Ok(find(&mut folder, pinned, wanted))
}

/// What each of `units` makes of what was `found` for it: what is for every unit is refused by whom it is not for, and by
/// those who, by `fleet`, have their own.
pub(super) fn admitted(mut found: Vec<Found>, units: &[UnitId], fleet: &Fleet) -> Vec<Found> {
    let is_given = |unit: &&UnitId| !found.iter().any(|found| found.unit.as_ref() == Some(unit));
    let given: Vec<&UnitId> = units.iter().filter(is_given).collect();
    for found in found.iter_mut().filter(|found| found.unit.is_none()) {
        let Ok(bundle) = &found.bundle else { continue };
        let addressees = &bundle.seal().letter().addressees;
        let refused = given.iter().find_map(|unit| addressees.admit(unit, fleet.last(unit).as_ref()).err());
        if let Some(refused) = refused {
            found.bundle = Err(Box::new(refused));
        }
    }
    found
}

/// What was `found` in the folder at `path`, all of which must be good.
pub(super) fn bundles(path: &Path, found: Vec<Found>) -> Result<Vec<(Option<UnitId>, VerifiedBundle)>, Fatal> {
    let good = |Found { unit, seal, bundle }: Found| match bundle {
        Ok(bundle) => Ok((unit, bundle)),
        Err(source) => Err(bad(path, seal, source)),
    };
    found.into_iter().map(good).collect()
}

/// The end of a command that needs what the `seal` in the folder at `path` vouches for.
pub(super) fn bad(path: &Path, seal: String, source: Box<Refusal>) -> Fatal {
    let exit = if source.is_io() { Exit::Unreadable } else { Exit::No };
    Fatal::new(exit, Bad { path: path.to_owned(), seal, source })
}

/// Those of `objects` in the folder at `path` that are not what they are called, every byte looked at, on all cores.
/// Shows its progress on a terminal.
pub(super) fn damaged(path: &Path, objects: &[(ObjectId, u64)]) -> Vec<(ObjectId, u64)> {
    let bar = progress::bytes("reading back", objects.iter().map(|(_, size)| size).sum());
    let look = |folder: &mut Option<Folder>, (id, size): &(ObjectId, u64)| {
        let found = folder.as_mut().and_then(|folder| hash(folder, id, *size).ok());
        bar.inc(*size);
        (found != Some((*id, *size))).then_some((*id, *size))
    };
    let damaged = objects.par_iter().map_init(|| Folder::open(path).ok(), look).flatten_iter().collect();
    bar.finish_and_clear();
    damaged
}

/// Everything that is wrong with what was `found` in the folder at `path`, every byte of it looked at, on all cores.
/// Shows its progress on a terminal.
pub(super) fn faults(path: &Path, found: &[Found], systems: &[system::Found]) -> Vec<Fault> {
    let mut halves: Vec<FileEntry> = Vec::new();
    let mut faults: Vec<Fault> = Vec::new();
    let mut objects: Vec<&FileEntry> = Vec::new();
    let mut seen: BTreeSet<ObjectId> = BTreeSet::new();
    for (seal, system) in systems.iter().map(|found| (&found.seal, &found.system)) {
        match system {
            Ok(system) => halves.extend(system.halves()),
            Err(refused) => faults.push(refusal(seal, refused)),
        }
    }
    for Found { seal, bundle, .. } in found {
        match bundle {
            Ok(bundle) => {
                objects.extend(bundle.contents().objects().into_iter().filter(|file| seen.insert(file.id)));
                faults.extend(flock_fault(path, seal, bundle));
            }
            Err(refused) => faults.push(refusal(seal, refused)),
        }
    }
    objects.extend(halves.iter().filter(|half| seen.insert(half.id)));
    let bar = progress::bytes("verifying", objects.iter().map(|file| file.size).sum());
    let look = |folder: &mut Option<Folder>, file: &FileEntry| {
        let fault = object_fault(folder.as_mut(), file);
        bar.inc(file.size);
        fault
    };
    let of_objects = objects.into_par_iter().map_init(|| Folder::open(path).ok(), look);
    faults.extend(of_objects.flatten_iter().collect::<Vec<Fault>>());
    bar.finish_and_clear();
    faults
}

/// Reads the seals for these units, and what they vouch for.
fn find(folder: &mut Folder, pinned: &Trust, wanted: BTreeSet<Option<UnitId>>) -> Vec<Found> {
    let trust = learned(folder, pinned);
    let found = |unit: Option<UnitId>| {
        let addressees = Addressees::of(unit.clone());
        let seal = seal_path(addressees.file_stems().first().copied().unwrap_or_default());
        Found { bundle: bundle(folder, &trust, unit.as_ref()).map_err(Box::new), seal, unit }
    };
    wanted.into_iter().map(found).collect()
}

/// What keys say in the folder about keys; nothing where there are no statements.
pub(super) fn said(folder: &mut Folder) -> Vec<u8> {
    let mut said = Vec::new();
    let reader = folder.small(STATEMENTS, limits::STATEMENTS);
    let read = reader.and_then(|reader| reader.take(limits::STATEMENTS).read_to_end(&mut said));
    if read.is_ok() { said } else { Vec::new() }
}

/// Whom the keys in `pinned` have taken in or called back by what lies in the folder.
pub(super) fn learned(folder: &mut Folder, pinned: &Trust) -> Trust {
    let mut trust = pinned.clone();
    // What somebody said who may not say it is passed over.
    trust.learn_all(&said(folder));
    trust
}

/// What `verify` opens, once what is `expected` by it was learned, as a unit does.
pub(super) fn heeded<S>(
    folder: &mut Folder,
    trust: &Trust,
    verify: impl Fn(&Trust) -> Result<S, Refusal>,
    expected: impl Fn(&S, &mut dyn Source) -> Result<Vec<u8>, Refusal>,
) -> Result<S, Refusal> {
    let opened = verify(trust)?;
    let mut trust = trust.clone();
    trust.learn_all(&expected(&opened, folder)?);
    verify(&trust)
}

fn bundle(folder: &mut Folder, trust: &Trust, unit: Option<&UnitId>) -> Result<VerifiedBundle, Refusal> {
    let unverified = UnverifiedSeal::addressed(folder, &Addressees::of(unit.cloned()))?;
    let seal = heeded(folder, trust, |trust| unverified.clone().verify(trust), Seal::expected_statements)?;
    unit.map_or(Ok(()), |unit| seal.letter().addressees.admit(unit, None))?;
    seal.fetch(folder)
}

fn refusal(seal: &str, refused: &Refusal) -> Fault {
    let is = |kind| matches!(refused, Refusal::Read { source, .. } if source.kind() == kind);
    let is_withheld = matches!(refused, Refusal::Withheld { found: None, .. });
    let kind = if is(io::ErrorKind::NotFound) || is_withheld {
        Kind::Missing
    } else if refused.is_io() {
        Kind::Unreadable
    } else {
        Kind::Refused
    };
    Fault {
        kind,
        seal: Some(seal.to_owned()),
        path: None,
        object: None,
        message: format!("`{seal}`: {}", chain(refused)),
    }
}

/// How the bundle is no flock, if its `flock.toml` is as signed.
fn flock_fault(path: &Path, seal: &str, bundle: &VerifiedBundle) -> Option<Fault> {
    let listed = bundle.contents().file(FILE_NAME)?;
    let mut bytes = Vec::new();
    let mut folder = Folder::open(path).ok()?;
    folder.object(&listed.id, listed.size, 0).ok()?.take(listed.size).read_to_end(&mut bytes).ok()?;
    let refused = bundle.flock(&bytes).err().filter(|_| ObjectId::of(&bytes) == listed.id)?;
    let message = format!("`{seal}`: {}", chain(&refused));
    Some(Fault {
        kind: Kind::NotAFlock,
        seal: Some(seal.to_owned()),
        path: Some(FILE_NAME.into()),
        object: None,
        message,
    })
}

/// How the content of `file` is not there as it was signed.
fn object_fault(folder: Option<&mut Folder>, file: &FileEntry) -> Option<Fault> {
    let (kind, why) = match folder.map(|folder| hash(folder, &file.id, file.size)) {
        Some(Ok((found, size))) if size == file.size && found == file.id => return None,
        Some(Ok((found, size))) if size == file.size => {
            (Kind::Damaged, format!("is damaged (expected {}, found {found})", file.id))
        }
        Some(Ok((_, size))) if size < file.size => (Kind::Short, format!("ends after {size} of {} bytes", file.size)),
        Some(Ok(_)) => (Kind::Long, format!("is longer than its {} bytes", file.size)),
        Some(Err(error)) if error.kind() == io::ErrorKind::NotFound => (Kind::Missing, "is missing".to_owned()),
        Some(Err(error)) => (Kind::Unreadable, format!("cannot be read: {error}")),
        None => (Kind::Unreadable, "cannot be read: its folder does not open".to_owned()),
    };
    let object = file.id.path();
    let message = format!("`{}` (`{object}`) {why}", file.path);
    Some(Fault { kind, seal: None, path: Some(file.path.to_string()), object: Some(object), message })
}

/// The digest and the size of what is there of an object; no more than a byte beyond its end is read.
fn hash(folder: &mut Folder, id: &ObjectId, size: u64) -> io::Result<(ObjectId, u64)> {
    ObjectId::of_reader(folder.object(id, size, 0)?.take(size + 1))
}
