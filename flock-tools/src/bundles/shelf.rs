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
    Addressees, FileEntry, Folder, NameError, ObjectId, Refused, STATEMENTS, Source, Trust, UnitId, Unverified,
    Verified, limits, seal_path, statements,
};
use flock::FILE_NAME;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::unmoved;
use crate::progress;
use crate::report::{Exit, Fatal, chain};

/// A seal, and what became of it.
pub(super) struct Found {
    /// Where it lies in the folder.
    pub(super) seal: String,
    /// What it vouches for, or why a unit would refuse it.
    pub(super) bundle: Result<Verified, Box<Refused>>,
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

/// Reads every seal in the folder at `path`, or those that `units` would be given, and what they vouch for. `pinned`
/// are the keys to trust; what they say there about others counts, as it would on a unit.
pub(super) fn read(path: &Path, pinned: &Trust, units: &[UnitId]) -> Result<Vec<Found>, Fatal> {
    let mut folder = Folder::open(path).map_err(unmoved)?;
    let trust = learned(&mut folder, pinned);
    let stems = folder.seals().map_err(unmoved)?;
    let everybody = Addressees::Anyone.stems()[0];
    let wanted: BTreeSet<String> = if units.is_empty() {
        stems.into_iter().collect()
    } else {
        let given = |unit: &UnitId| {
            let stem = [unit.as_str(), everybody].into_iter().find(|stem| stems.iter().any(|there| there == stem));
            let absent = || Absent::Unit { path: path.to_owned(), unit: unit.clone() };
            stem.map(str::to_owned).ok_or_else(|| Fatal::new(Exit::No, absent()))
        };
        units.iter().map(given).collect::<Result<_, _>>()?
    };
    if wanted.is_empty() {
        return Err(Fatal::new(Exit::No, Absent::Bundle { path: path.to_owned() }));
    }
    let found = |stem: String| {
        let unit = if stem == everybody { Ok(None) } else { UnitId::new(&stem).map(Some) };
        let seal = seal_path(&stem);
        let bundle = unit.map_err(misnamed).and_then(|unit| bundle(&mut folder, &trust, unit.as_ref()));
        Found { seal, bundle: bundle.map_err(Box::new) }
    };
    Ok(wanted.into_iter().map(found).collect())
}

/// Everything that is wrong with what was `found` in the folder at `path`, every byte of it looked at, on all cores.
/// Shows its progress on a terminal.
pub(super) fn faults(path: &Path, found: &[Found]) -> Vec<Fault> {
    let mut faults: Vec<Fault> = Vec::new();
    let mut objects: Vec<&FileEntry> = Vec::new();
    let mut seen: BTreeSet<ObjectId> = BTreeSet::new();
    for Found { seal, bundle, .. } in found {
        match bundle {
            Ok(bundle) => {
                objects.extend(bundle.contents().objects().into_iter().filter(|file| seen.insert(file.id)));
                faults.extend(flock_fault(path, seal, bundle));
            }
            Err(refused) => faults.push(refusal(seal, refused)),
        }
    }
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

/// Whom the keys in `pinned` have taken in or called back by what lies in the folder.
fn learned(folder: &mut Folder, pinned: &Trust) -> Trust {
    let mut trust = pinned.clone();
    let mut said = Vec::new();
    let reader = folder.small(STATEMENTS, limits::STATEMENTS);
    // Where there are none, nobody has said anything; what somebody said who may not is passed over.
    if reader.and_then(|reader| reader.take(limits::STATEMENTS).read_to_end(&mut said)).is_ok() {
        for statement in statements(&said) {
            trust.learn(statement).ok();
        }
    }
    trust
}

fn bundle(folder: &mut Folder, trust: &Trust, unit: Option<&UnitId>) -> Result<Verified, Refused> {
    let seal = Unverified::addressed(folder, &Addressees::of(unit.cloned()))?.verify(trust)?;
    let addressees = &seal.letter().addressees;
    match unit {
        Some(unit) if !addressees.include(unit) => {
            Err(Refused::ForOthers { addressees: addressees.clone(), unit: unit.clone() })
        }
        _ => seal.fetch(folder),
    }
}

fn misnamed(source: NameError) -> Refused {
    Refused::Read { part: bundle::Part::Seal, source: io::Error::new(io::ErrorKind::InvalidFilename, source) }
}

fn refusal(seal: &str, refused: &Refused) -> Fault {
    let is = |kind| matches!(refused, Refused::Read { source, .. } if source.kind() == kind);
    let kind = if is(io::ErrorKind::NotFound) {
        Kind::Missing
    } else if refused.is_of_the_world() && !is(io::ErrorKind::InvalidFilename) {
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
fn flock_fault(path: &Path, seal: &str, bundle: &Verified) -> Option<Fault> {
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
    let (kind, why) = match folder.map(|folder| hash(folder, file)) {
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

fn hash(folder: &mut Folder, file: &FileEntry) -> io::Result<(ObjectId, u64)> {
    ObjectId::of_reader(folder.object(&file.id, file.size, 0)?.take(file.size + 1))
}
