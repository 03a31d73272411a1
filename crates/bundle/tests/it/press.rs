//! A press for bundles: small flocks, signed and laid into folders.

use crate::folders::{files_in, lay};
use bundle::{Folder, LocalDisk, SecretKey, Store, Trust, UnitId, UnverifiedSeal, VerifiedBundle};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::OnceLock;

/// The files of a flock, by path.
pub(crate) type Files = BTreeMap<String, Vec<u8>>;

/// The key named `who`, the same within a test run.
pub(crate) fn key(who: &'static str) -> &'static SecretKey {
    static KEYS: OnceLock<[(&str, SecretKey); 3]> = OnceLock::new();
    let make = |who| {
        let folder = tempfile::tempdir().unwrap();
        (who, SecretKey::create(&folder.path().join("key"), "").unwrap())
    };
    let keys = KEYS.get_or_init(|| ["artist", "spare", "stranger"].map(make));
    keys.iter().find(|(name, _)| *name == who).map(|(_, key)| key).unwrap()
}

pub(crate) fn unit(name: &str) -> UnitId {
    UnitId::new(name).unwrap()
}

/// Trusts the artist.
pub(crate) fn trust() -> Trust {
    Trust::of([key("artist").public()])
}

/// A flock of so many sheep; the clips that differ between editions are those whose number is below `edition`.
pub(crate) fn flock(sheep: usize, edition: usize) -> Files {
    let mut toml = "format = 1\nname = \"aurora\"\nsize = [64, 64]\nfps = [30, 1]\n".to_owned();
    let mut files = Files::new();
    for at in 0..sheep {
        let clip = format!("loops/{at}.mp4");
        write!(toml, "[[sheep]]\nid = \"{at}\"\nframes = 9\nclip = \"{clip}\"\n").unwrap();
        let fresh = if at < edition { edition } else { 0 };
        files.insert(clip, format!("clip {at} of edition {fresh} ").repeat(50 + 37 * at).into_bytes());
    }
    files.insert("flock.toml".to_owned(), toml.into_bytes());
    files
}

/// Presses a bundle of `files` into `folder`.
pub(crate) fn press(folder: &Path, files: &Files, units: &[&str], sequence: u64, who: &'static str) {
    lay(key(who), folder, files, units, sequence);
}

/// Opens what lies in `folder` for the unit `lobby`.
pub(crate) fn verified(folder: &Path, trust: &Trust) -> Result<VerifiedBundle, bundle::Refusal> {
    let mut folder = Folder::open(folder).unwrap();
    UnverifiedSeal::open(&mut folder, &unit("lobby"))?.verify(trust)?.fetch(&mut folder)
}

pub(crate) fn store(path: &Path) -> Store {
    Store::open(Box::new(LocalDisk::open(path).unwrap()), trust()).unwrap()
}

/// Fetches what the store lacks of the bundle; returns how many bytes that were.
pub(crate) fn fetch(store: &Store, folder: &Path, bundle: &VerifiedBundle) -> u64 {
    let mut source = Folder::open(folder).unwrap();
    let mut fetched = 0;
    for wanted in store.plan(bundle).unwrap().wanted {
        let mut intake = store.intake(&wanted).unwrap();
        let mut bytes = Vec::new();
        let mut from = bundle::Source::object(&mut source, &wanted.id, wanted.size, intake.have()).unwrap();
        std::io::Read::read_to_end(&mut from, &mut bytes).unwrap();
        fetched += bytes.len() as u64;
        intake.append(&bytes).unwrap();
        intake.finish().unwrap();
    }
    fetched
}

/// The flock that plays, as the player would find it.
pub(crate) fn playing(store: &Path) -> Option<Files> {
    let current = store.join(bundle::CURRENT);
    current.exists().then(|| files_in(&current).unwrap())
}
