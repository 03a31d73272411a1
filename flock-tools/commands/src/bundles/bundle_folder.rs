//! A folder of bundles, read as its units would read it.
//!
//! Owns the list of its seals, what each vouches for, and whether all of that is there and as it was signed. Never changes
//! anything, and does not stop at the first fault.
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
use operations::program::{Exit, Fatal, chain, progress};
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::fleet::Fleet;
use super::{folder_fatal, system};

/// The folder of all seals.
const SEALS: &str = "seals";

/// A seal in the folder, with its bundle if that is good.
pub(super) struct BundleEntry {
    /// The unit that it is for; `None` for every unit.
    pub(super) unit: Option<UnitId>,
    /// Its path in the folder.
    pub(super) seal: String,
    /// The bundle, or why a unit would refuse it.
    pub(super) bundle: Result<VerifiedBundle, Box<Refusal>>,
}

/// A fault of a folder of bundles.
#[derive(Clone, Debug, serde::Serialize)]
pub(super) struct Fault {
    pub(super) kind: Kind,
    /// The path of the seal, if it is a fault of that seal.
    #[serde(skip_serializing_if = "Option::is_none")]
    seal: Option<String>,
    /// The file of the flock.
    #[serde(skip_serializing_if = "Option::is_none")]
    path: Option<String>,
    /// The path of its content in the folder.
    #[serde(skip_serializing_if = "Option::is_none")]
    object: Option<String>,
    /// A sentence for people.
    pub(super) message: String,
}

/// The kind of a fault.
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

/// A folder without the bundle that was asked for.
#[derive(Debug, thiserror::Error)]
enum NoBundle {
    #[error("there is no bundle in `{path}`")]
    ForAny { path: PathBuf },
    #[error("there is no bundle for unit `{unit}` in `{path}`")]
    ForUnit { path: PathBuf, unit: UnitId },
}

/// A bundle that must be good and is refused.
#[derive(Debug, thiserror::Error)]
#[error("`{seal}` in `{path}` is refused")]
struct RefusedSeal {
    path: PathBuf,
    seal: String,
    source: Box<Refusal>,
}

/// Whether the folder at `path` has bundles in it.
pub(super) fn is_bundle_folder(path: &Path) -> bool {
    path.join(SEALS).is_dir()
}

/// Reads every seal in the folder at `path`, or those that `units` would be given, and their lists of files. `pinned` are
/// the keys to trust; their statements in the folder count, as on a unit.
/// Errors: If there is no seal, or none for one of `units`.
pub(super) fn read(path: &Path, pinned: &Trust, units: &[UnitId]) -> Result<Vec<BundleEntry>, Fatal> {
    let mut folder = Folder::open(path).map_err(folder_fatal)?;
    let there = folder.seals().map_err(folder_fatal)?;
    let wanted: BTreeSet<Option<UnitId>> = if units.is_empty() {
        there
    } else {
        let given = |unit: &UnitId| {
            let found = [Some(unit.clone()), None].into_iter().find(|addressee| there.contains(addressee));
            found.ok_or_else(|| Fatal::new(Exit::No, NoBundle::ForUnit { path: path.to_owned(), unit: unit.clone() }))
        };
        units.iter().map(given).collect::<Result<_, _>>()?
    };
    if wanted.is_empty() {
        return Err(Fatal::new(Exit::No, NoBundle::ForAny { path: path.to_owned() }));
    }
    Ok(read_seals(&mut folder, pinned, wanted))
}

/// As [`read`], but without bundles there is no error if `there_are_others` for these units: systems or settings.
pub(super) fn read_beside_others(
    path: &Path,
    pinned: &Trust,
    units: &[UnitId],
    there_are_others: bool,
) -> Result<Vec<BundleEntry>, Fatal> {
    if there_are_others && !is_bundle_folder(path) { Ok(Vec::new()) } else { read(path, pinned, units) }
}

/// As [`read`], of all bundles, and without an error if there are none.
pub(super) fn read_all(path: &Path, pinned: &Trust) -> Result<Vec<BundleEntry>, Fatal> {
    let mut folder = Folder::open(path).map_err(folder_fatal)?;
    let wanted = if is_bundle_folder(path) { folder.seals().map_err(folder_fatal)? } else { BTreeSet::new() };
    Ok(read_seals(&mut folder, pinned, wanted))
}

/// The same `entries`, where a bundle for every unit is refused if one of `units` would not take it: it is not for that
/// unit, or the unit has bundles of its own by `fleet`.
pub(super) fn admit(mut entries: Vec<BundleEntry>, units: &[UnitId], fleet: &Fleet) -> Vec<BundleEntry> {
    let is_given = |unit: &&UnitId| !entries.iter().any(|entry| entry.unit.as_ref() == Some(unit));
    let given: Vec<&UnitId> = units.iter().filter(is_given).collect();
    for entry in entries.iter_mut().filter(|entry| entry.unit.is_none()) {
        let Ok(bundle) = &entry.bundle else { continue };
        let addressees = &bundle.seal().letter().addressees;
        let refused = given.iter().find_map(|unit| addressees.admit(unit, fleet.last_addressees(unit).as_ref()).err());
        if let Some(refused) = refused {
            entry.bundle = Err(Box::new(refused));
        }
    }
    entries
}

/// The bundles of `entries` in the folder at `path`, all of which must be good.
pub(super) fn good_bundles(
    path: &Path,
    entries: Vec<BundleEntry>,
) -> Result<Vec<(Option<UnitId>, VerifiedBundle)>, Fatal> {
    let good = |BundleEntry { unit, seal, bundle }: BundleEntry| match bundle {
        Ok(bundle) => Ok((unit, bundle)),
        Err(source) => Err(refused_seal(path, seal, source)),
    };
    entries.into_iter().map(good).collect()
}

/// Ends a command that needs the bundle or system of the `seal` in the folder at `path`.
pub(super) fn refused_seal(path: &Path, seal: String, source: Box<Refusal>) -> Fatal {
    let exit = if source.is_io() { Exit::Unreadable } else { Exit::No };
    Fatal::new(exit, RefusedSeal { path: path.to_owned(), seal, source })
}

/// Those of `objects` in the folder at `path` whose bytes do not have the hash and size in their names. Reads every byte, on
/// all cores. Shows its progress on a terminal.
pub(super) fn damaged(path: &Path, objects: &[(ObjectId, u64)]) -> Vec<(ObjectId, u64)> {
    let bar = progress::bytes("reading back", objects.iter().map(|(_, size)| size).sum());
    let check = |folder: &mut Option<Folder>, (id, size): &(ObjectId, u64)| {
        let found = folder.as_mut().and_then(|folder| hash(folder, id, *size).ok());
        bar.inc(*size);
        (found != Some((*id, *size))).then_some((*id, *size))
    };
    let damaged = objects.par_iter().map_init(|| Folder::open(path).ok(), check).flatten_iter().collect();
    bar.finish_and_clear();
    damaged
}

/// Every fault of these entries of the folder at `path`. Reads every byte, on all cores. Shows its progress on a terminal.
pub(super) fn faults(path: &Path, bundles: &[BundleEntry], systems: &[system::SystemEntry]) -> Vec<Fault> {
    let mut halves: Vec<FileEntry> = Vec::new();
    let mut faults: Vec<Fault> = Vec::new();
    let mut objects: Vec<&FileEntry> = Vec::new();
    let mut seen: BTreeSet<ObjectId> = BTreeSet::new();
    for (seal, system) in systems.iter().map(|entry| (&entry.seal, &entry.system)) {
        match system {
            Ok(system) => halves.extend(system.halves()),
            Err(refused) => faults.push(refusal(seal, refused)),
        }
    }
    for BundleEntry { seal, bundle, .. } in bundles {
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
    let check = |folder: &mut Option<Folder>, file: &FileEntry| {
        let fault = object_fault(folder.as_mut(), file);
        bar.inc(file.size);
        fault
    };
    let of_objects = objects.into_par_iter().map_init(|| Folder::open(path).ok(), check);
    faults.extend(of_objects.flatten_iter().collect::<Vec<Fault>>());
    bar.finish_and_clear();
    faults
}

/// Reads the seals for these units, and their lists of files.
fn read_seals(folder: &mut Folder, pinned: &Trust, wanted: BTreeSet<Option<UnitId>>) -> Vec<BundleEntry> {
    let trust = trust_with_statements(folder, pinned);
    let entry = |unit: Option<UnitId>| {
        let addressees = Addressees::of(unit.clone());
        let seal = seal_path(addressees.file_stems().first().copied().unwrap_or_default());
        BundleEntry { bundle: bundle(folder, &trust, unit.as_ref()).map_err(Box::new), seal, unit }
    };
    wanted.into_iter().map(entry).collect()
}

/// The statements of keys about keys in the folder; empty where there are none.
pub(super) fn statements(folder: &mut Folder) -> Vec<u8> {
    let mut statements = Vec::new();
    let reader = folder.small(STATEMENTS, limits::STATEMENTS);
    let read = reader.and_then(|reader| reader.take(limits::STATEMENTS).read_to_end(&mut statements));
    if read.is_ok() { statements } else { Vec::new() }
}

/// The keys in `pinned`, with those that they take in and without those that they call back by statements in the folder.
pub(super) fn trust_with_statements(folder: &mut Folder, pinned: &Trust) -> Trust {
    let mut trust = pinned.clone();
    // A statement by a key that is not trusted has no effect.
    trust.learn_all(&statements(folder));
    trust
}

/// Verifies twice, as a unit does: the second time with the statements that the seal expects to be `expected`.
pub(super) fn verify_with_statements<S>(
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
    let seal =
        verify_with_statements(folder, trust, |trust| unverified.clone().verify(trust), Seal::expected_statements)?;
    unit.map_or(Ok(()), |unit| seal.letter().addressees.admit(unit, None))?;
    seal.fetch(folder)
}

pub(super) fn refusal(seal: &str, refused: &Refusal) -> Fault {
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

/// The fault of a bundle that is no flock although its `flock.toml` is as signed.
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

/// The fault of the content of `file`, if it is not there as it was signed.
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

/// The hash and the size of an object on the disk; at most one byte beyond its end is read.
fn hash(folder: &mut Folder, id: &ObjectId, size: u64) -> io::Result<(ObjectId, u64)> {
    ObjectId::of_reader(folder.object(id, size, 0)?.take(size + 1))
}
