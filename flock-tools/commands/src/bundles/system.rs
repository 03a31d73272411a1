//! `dreams pack --system`: from the output of `make image` to a bundle of a system.
//!
//! Owns the order, and the check that the two halves belong to each other: the start file names the root that it was made
//! with, and its version. Owns also the reading of systems in a folder of bundles, as their units read them. Never builds a
//! system.
//!
//! Start at [`pack`].

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use bundle::{
    Addressees, Folder, KeyError, KeyId, ObjectId, PublicKey, Refusal, Release, SecretKey, Sequence, StartFile,
    StartFileError, System, Trust, UnitId, UnverifiedSystem, Version, limits, system_path,
};
use indicatif::DecimalBytes;
use operations::program::{Exit, Fatal, now, print, progress};

use super::counter::Counter;
use super::pack::Args;
use super::{bundle_folder, folder_fatal, passphrase, refusal_fatal, sign_fatal};

/// The output of `make image`: the start file, the verified root, and the public keys in the root.
const START: &str = "dreams.start";
const ROOT: &str = "root.img";
const KEYS: &str = "keys";
/// The size of a block of the root. The superblock of the hash tree follows the last one, and has the slot at `SLOT_AT`.
const BLOCK: u64 = 4096;
const SLOT_AT: u64 = 16;

/// A seal of a system in the folder, with the system if that is good.
pub(super) struct SystemEntry {
    /// The unit that it is for; `None` for every unit.
    pub(super) unit: Option<UnitId>,
    /// Its path in the folder.
    pub(super) seal: String,
    /// The system, or why a unit would refuse it.
    pub(super) system: Result<System, Box<Refusal>>,
}

/// Why a folder is no system that can be packed.
#[derive(Debug, thiserror::Error)]
enum SystemError {
    #[error("cannot read the keys that system `{path}` trusts", path = .path.display())]
    Keys { path: PathBuf, source: KeyError },
    #[error("`{root}` is not the root that `{start}` was made with", root = .root.display(), start = .start.display())]
    Mismatch { start: PathBuf, root: PathBuf },
    #[error("`{path}` is not a start file", path = .path.display())]
    NoStartFile { path: PathBuf, source: StartFileError },
    #[error("cannot read `{path}`", path = .path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("`{path}` has {bytes} bytes, more than the {} of a slot", limits::SYSTEM, path = .path.display())]
    TooLarge { path: PathBuf, bytes: u64 },
    #[error("system `{path}` does not trust key {key} that signs it, it trusts {trusted}", path = .path.display())]
    Untrusted { path: PathBuf, key: KeyId, trusted: String },
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct SystemSummary {
    #[serde(rename = "packed")]
    is_done: bool,
    version: Version,
    /// Empty if it is for every unit.
    units: Vec<String>,
    sequence: Sequence,
    signer: KeyId,
    bytes: u64,
}

/// Signs the system in the folder that `args` name.
pub fn pack(args: &Args) -> Result<Exit, Fatal> {
    let statements = super::pack::statements(args)?;
    let key = passphrase::open_key(&args.key, args.passphrase_file.as_deref())?;
    let (start, root) = (args.dir.join(START), args.dir.join(ROOT));
    let version = version(&start, &root).map_err(system_fatal)?;
    if !args.allow_untrusted {
        require_trust(&args.dir, key.public().id())?;
    }
    let folder = Folder::create(&args.bundle).map_err(folder_fatal)?;
    let halves = [put(&folder, &start)?, put(&folder, &root)?];
    let mut counter = Counter::lock(&args.key)?;
    for sequence in sequences(&args.bundle, &Trust::of([key.public()])) {
        counter.raise_to(sequence);
    }
    let release = Release {
        version,
        addressees: Addressees::of(args.units.iter().cloned()),
        sequence: counter.advance(args.sequence)?,
        created: now::date(),
        start: halves[0],
        root: halves[1],
        statements: folder.put_statements(&statements).map_err(folder_fatal)?,
    };
    seal(&folder, &release, &key, &statements)?;
    let summary = SystemSummary {
        is_done: true,
        version: release.version,
        units: args.units.iter().map(ToString::to_string).collect(),
        sequence: release.sequence,
        signer: key.public().id(),
        bytes: release.start.1 + release.root.1,
    };
    if args.json {
        print::json(&summary)?;
    } else {
        let SystemSummary { version, sequence, signer, bytes, .. } = &summary;
        let units = if summary.units.is_empty() { "every unit".to_owned() } else { summary.units.join(", ") };
        let size = DecimalBytes(*bytes);
        print::lines([format!("packed system {version} for {units}: sequence {sequence}, key {signer}, {size}")])?;
    }
    Ok(Exit::Fine)
}

/// Signs the system, verifies it as a unit does, and writes the statements, then the seal.
fn seal(folder: &Folder, release: &Release, key: &SecretKey, statements: &[Vec<u8>]) -> Result<(), Fatal> {
    let bytes = release.sign(key).map_err(sign_fatal)?;
    UnverifiedSystem::new(bytes.clone()).verify(&Trust::of([key.public()])).map_err(refusal_fatal)?;
    folder.add_statements(statements).map_err(folder_fatal)?;
    folder.put_system(&release.addressees, &bytes).map_err(folder_fatal)
}

/// Ends the command if the system in the folder `dir` does not trust the key: units that start it would take nothing more
/// that this key signs.
fn require_trust(dir: &Path, key: KeyId) -> Result<(), Fatal> {
    let path = dir.join(KEYS);
    let trust = if path.exists() { Trust::read(&path) } else { Ok(Trust::default()) };
    let trust = trust.map_err(|source| system_fatal(SystemError::Keys { path: dir.to_owned(), source }))?;
    let known: Vec<_> = trust.keys().map(PublicKey::id).collect();
    if known.contains(&key) {
        return Ok(());
    }
    let trusted = if known.is_empty() { "nobody".to_owned() } else { key_list(&known) };
    let hint = "give `make image` its public key: keys=NAME.pub; or pack it with --allow-untrusted if the units trust it otherwise";
    Err(system_fatal(SystemError::Untrusted { path: dir.to_owned(), key, trusted }).hint(hint))
}

fn key_list(keys: &[KeyId]) -> String {
    keys.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

/// The numbers of all flocks and systems in the folder at `path`.
fn sequences(path: &Path, trust: &Trust) -> Vec<Sequence> {
    let flocks = bundle_folder::read_all(path, trust).unwrap_or_default();
    let flocks = flocks.iter().filter_map(|entry| entry.bundle.as_ref().ok());
    let flocks: Vec<_> = flocks.map(|bundle| bundle.seal().letter().sequence).collect();
    let systems = read(path, trust, &[]).unwrap_or_default();
    let systems = systems.iter().filter_map(|entry| entry.system.as_ref().ok());
    flocks.into_iter().chain(systems.map(|system| system.release().sequence)).collect()
}

/// The version that the file `start` names, if `root` is the root that it was made with.
fn version(start: &Path, root: &Path) -> Result<Version, SystemError> {
    let unread = |path: &Path| {
        let path = path.to_owned();
        |source| SystemError::Read { path, source }
    };
    let bytes = fs::metadata(start).map_err(unread(start))?.len();
    if bytes > limits::SYSTEM {
        return Err(SystemError::TooLarge { path: start.to_owned(), bytes });
    }
    let start_bytes = fs::read(start).map_err(unread(start))?;
    let no_start_file = |source| SystemError::NoStartFile { path: start.to_owned(), source };
    let StartFile { version, slot, blocks, .. } = StartFile::read(&start_bytes).map_err(no_start_file)?;
    let mut found = [0; 16];
    let at = blocks.saturating_mul(BLOCK).saturating_add(SLOT_AT);
    let read = File::open(root).and_then(|file| file.read_exact_at(&mut found, at));
    read.or_else(|error| if error.kind() == io::ErrorKind::UnexpectedEof { Ok(()) } else { Err(error) })
        .map_err(unread(root))?;
    if !slot.bytes().eq(found.iter().flat_map(|byte| format!("{byte:02x}").into_bytes())) {
        return Err(SystemError::Mismatch { start: start.to_owned(), root: root.to_owned() });
    }
    Ok(version)
}

/// Puts the file at `path` into `folder`; returns its id and its size. Shows its progress on a terminal.
fn put(folder: &Folder, path: &Path) -> Result<(ObjectId, u64), Fatal> {
    let unread = |source| system_fatal(SystemError::Read { path: path.to_owned(), source });
    let (id, size) = File::open(path).and_then(ObjectId::of_reader).map_err(unread)?;
    if size > limits::SYSTEM {
        return Err(system_fatal(SystemError::TooLarge { path: path.to_owned(), bytes: size }));
    }
    let bar = progress::bytes("packing", size);
    folder.put_file(&id, size, path, &mut |bytes| bar.inc(bytes)).map_err(folder_fatal)?;
    bar.finish_and_clear();
    Ok((id, size))
}

fn system_fatal(error: SystemError) -> Fatal {
    let is_io = matches!(error, SystemError::Read { .. });
    Fatal::new(if is_io { Exit::Unreadable } else { Exit::Malformed }, error)
}

/// Reads every system's seal in the folder at `path`, or those that `units` would be given.
pub(super) fn read(path: &Path, pinned: &Trust, units: &[UnitId]) -> Result<Vec<SystemEntry>, Fatal> {
    let mut folder = Folder::open(path).map_err(folder_fatal)?;
    let there = folder.systems().map_err(folder_fatal)?;
    let given = |unit: &UnitId| [Some(unit.clone()), None].into_iter().find(|addressee| there.contains(addressee));
    let wanted: BTreeSet<_> = if units.is_empty() { there.clone() } else { units.iter().filter_map(given).collect() };
    let trust = bundle_folder::trust_with_statements(&mut folder, pinned);
    let entry = |unit: Option<UnitId>| {
        let addressees = Addressees::of(unit.clone());
        let seal = system_path(addressees.file_stems().first().copied().unwrap_or_default());
        let missing = || Refusal::Read { part: bundle::Part::Seal, source: io::ErrorKind::NotFound.into() };
        let read = UnverifiedSystem::addressed(&mut folder, &addressees).and_then(|read| read.ok_or_else(missing));
        let verified = |unverified: UnverifiedSystem| {
            let verify = |trust: &Trust| unverified.clone().verify(trust);
            bundle_folder::verify_with_statements(&mut folder, &trust, verify, System::expected_statements)
        };
        let system = read.and_then(verified).and_then(|system| {
            let is_given = |asked: &&UnitId| match &unit {
                Some(unit) => unit == *asked,
                None => !there.contains(&Some((*asked).clone())),
            };
            let mut given = units.iter().filter(is_given).chain(&unit);
            given.try_for_each(|unit| system.release().addressees.admit(unit, None))?;
            Ok(system)
        });
        SystemEntry { unit, seal, system: system.map_err(Box::new) }
    };
    Ok(wanted.into_iter().map(entry).collect())
}

/// A system in an answer.
pub(super) fn line(unit: Option<&UnitId>, system: &System) -> String {
    let Release { version, sequence, created, start, root, .. } = system.release();
    let (unit, size) = (unit.map_or("every unit", UnitId::as_str), DecimalBytes(start.1 + root.1));
    format!("system {version} for {unit}, sequence {sequence} of {created}, key {}, {size}", system.signer())
}

#[cfg(test)]
mod tests {
    use super::{BLOCK, ROOT, START, SystemError, version};
    use std::error::Error;
    use std::fs;
    use std::path::Path;

    fn lay(folder: &Path, says: &str, slot: u8) {
        fs::write(folder.join(START), format!("MZ\0{says}\0")).unwrap();
        let mut root = vec![1; 2 * BLOCK as usize];
        root.extend([0; 16]);
        root.extend([slot; 16]);
        fs::write(folder.join(ROOT), root).unwrap();
    }

    #[test]
    fn only_halves_that_were_made_with_each_other_are_a_system() {
        let folder = tempfile::tempdir().unwrap();
        let text =
            |error: SystemError| format!("{error}: {}", error.source().map(ToString::to_string).unwrap_or_default());
        let found = || version(&folder.path().join(START), &folder.path().join(ROOT)).map_err(text);
        let slot = "07".repeat(16);
        lay(folder.path(), &format!("quiet dreams.version=0.2.0 dreams.root={slot}:2:salt:hash rw"), 7);
        assert_eq!(found().unwrap().to_string(), "0.2.0");
        lay(folder.path(), &format!("quiet dreams.version=0.2.0 dreams.root={slot}:2:salt:hash rw"), 8);
        assert!(found().unwrap_err().contains("is not the root that"));
        lay(folder.path(), &format!("dreams.version=0.2.0 dreams.root={slot}:9999:salt:hash "), 7);
        assert!(found().unwrap_err().contains("is not the root that"));
        lay(folder.path(), "dreams.version=next dreams.root=a:2:b:c ", 7);
        assert!(found().unwrap_err().contains("no valid system version"));
        lay(folder.path(), "a kernel of somebody else", 7);
        assert!(found().unwrap_err().contains("does not name its system"));
    }
}
