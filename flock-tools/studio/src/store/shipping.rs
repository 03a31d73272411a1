//! The keys that may sign the flock, the folder of its bundles, and where they may go.
//!
//! Owns which there are: the page names one of them and never a path. Never packs and never publishes.
//!
//! Start at [`Shipping`].

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::{fs, io};

use bundle::{Addressees, Folder, KeyId, PublicKey, UnitId, seal_path};

/// The ending of secret keys, and of public ones.
const SECRET: &str = "key";
const PUBLIC: &str = "pub";
/// The folder, in the studio's own, of the keys that bundles of this artist are signed with.
const TRUST: &str = "trust";
/// Where sticks are mounted.
const MOUNTS: [&str; 2] = ["/media", "/run/media"];

/// Where bundles come from and go to.
#[derive(Debug)]
pub(crate) struct Shipping {
    /// Secret keys, by their names.
    pub(crate) keys: BTreeMap<String, PathBuf>,
    /// The folder of the bundles.
    pub(crate) outbox: PathBuf,
    /// Folders to publish to that were named on the command line.
    pub(crate) targets: Vec<PathBuf>,
    /// The file with the passphrase, if it is not asked for.
    pub(crate) passphrase_file: Option<PathBuf>,
}

impl Shipping {
    /// For the flock in `folder`: the `keys` and those that lie beside the flock's folder, and an outbox there.
    pub(crate) fn new(
        folder: &Path,
        keys: &[PathBuf],
        outbox: Option<PathBuf>,
        targets: Vec<PathBuf>,
        passphrase_file: Option<PathBuf>,
    ) -> Self {
        let beside = fs::canonicalize(folder).ok().and_then(|folder| folder.parent().map(Path::to_owned));
        let beside = beside.unwrap_or_else(|| PathBuf::from(".."));
        let found = fs::read_dir(&beside).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
        let is_key = |path: &PathBuf| path.extension().is_some_and(|ending| ending == SECRET);
        let all = found.filter(is_key).chain(keys.iter().cloned());
        let name = |path: &Path| Some(path.file_stem()?.to_str()?.to_owned());
        Self {
            keys: all.filter_map(|path| Some((name(&path)?, path))).collect(),
            outbox: outbox.unwrap_or_else(|| beside.join("outbox")),
            targets,
            passphrase_file,
        }
    }

    /// The public keys beside the secret ones.
    pub(crate) fn public_keys(&self) -> Vec<PathBuf> {
        self.keys.values().map(|key| key.with_extension(PUBLIC)).filter(|key| key.is_file()).collect()
    }

    /// What the commands trust that read bundles of this artist: the public key beside the secret one; of several keys a
    /// folder in the studio's `own`, since bundles may be signed by any of them. `None` if there is none.
    /// Errors: If that folder cannot be written.
    pub(crate) fn trust(&self, own: &Path) -> io::Result<Option<PathBuf>> {
        let read = |path: PathBuf| PublicKey::read(&path).ok().map(|key| (key.id(), (path, key)));
        let keys: BTreeMap<KeyId, (PathBuf, PublicKey)> = self.public_keys().into_iter().filter_map(read).collect();
        if keys.len() < 2 {
            return Ok(keys.into_values().next().map(|(path, _)| path));
        }
        let folder = own.join(TRUST);
        fs::create_dir_all(&folder)?;
        let file = |id: &KeyId| folder.join(format!("{id}.{PUBLIC}"));
        for (id, (_, key)) in &keys {
            durable::write(&file(id), key.to_text().as_bytes())?;
        }
        let known: BTreeSet<PathBuf> = keys.keys().map(file).collect();
        for entry in fs::read_dir(&folder)? {
            let path = entry?.path();
            if !known.contains(&path) {
                fs::remove_file(path)?;
            }
        }
        Ok(Some(folder))
    }

    /// For whom bundles were packed; `None` stands for every unit.
    fn addressees(&self) -> BTreeSet<Option<UnitId>> {
        Folder::open(&self.outbox).and_then(|folder| folder.seals()).unwrap_or_default()
    }

    /// Whether something was packed.
    pub(crate) fn has_bundle(&self) -> bool {
        !self.addressees().is_empty()
    }

    /// Whom the bundle is for that was packed last: `None` stands for every unit.
    pub(crate) fn last_addressee(&self) -> Option<UnitId> {
        let packed = |unit: &Option<UnitId>| {
            let addressees = Addressees::of(unit.clone());
            let seal = self.outbox.join(seal_path(addressees.file_stems().first()?));
            fs::metadata(seal).and_then(|status| status.modified()).ok()
        };
        self.addressees().into_iter().max_by_key(packed).flatten()
    }

    /// The folders that bundles may be published to: those of the command line, and mounted sticks.
    pub(crate) fn targets(&self) -> Vec<PathBuf> {
        let inside = |folder: &Path| -> Vec<PathBuf> {
            let entries = fs::read_dir(folder).into_iter().flatten();
            entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| path.is_dir()).collect()
        };
        let users = MOUNTS.iter().flat_map(|mount| inside(Path::new(mount)));
        let sticks = users.flat_map(|user| inside(&user));
        self.targets.iter().cloned().chain(sticks).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_beside_the_flock_are_found_and_the_page_is_told_their_names_only() {
        let scratch = tempfile::tempdir().unwrap();
        let folder = scratch.path().join("aurora");
        fs::create_dir(&folder).unwrap();
        for name in ["artist.key", "artist.pub", "spare.key", "notes.txt"] {
            fs::write(scratch.path().join(name), "").unwrap();
        }
        let shipping = Shipping::new(&folder, &[PathBuf::from("/keys/other.key")], None, Vec::new(), None);
        assert_eq!(shipping.keys.keys().collect::<Vec<_>>(), ["artist", "other", "spare"]);
        let beside = fs::canonicalize(scratch.path()).unwrap();
        assert_eq!(shipping.public_keys(), [beside.join("artist.pub")]);
        assert_eq!(shipping.outbox, beside.join("outbox"));
        fs::create_dir_all(beside.join("outbox/seals")).unwrap();
        assert!(!shipping.has_bundle());
        fs::write(beside.join("outbox/seals/all.seal"), "").unwrap();
        assert!(shipping.has_bundle());
    }

    #[test]
    fn of_several_keys_each_may_have_signed_what_is_published_and_compared() {
        let scratch = tempfile::tempdir().unwrap();
        let (folder, own) = (scratch.path().join("aurora"), scratch.path().join("own"));
        fs::create_dir(&folder).unwrap();
        let line = "RWSpVEofUHtvf6QQ/+CMtwchrNTFksocWtP8tj5ACUKCL1JLSYWWj//W";
        let keep = |name: &str, line: &str| {
            fs::write(scratch.path().join(name).with_extension(SECRET), "").unwrap();
            let text = format!("untrusted comment: minisign public key\n{line}\n");
            fs::write(scratch.path().join(name).with_extension(PUBLIC), text).unwrap();
        };
        let trust = || Shipping::new(&folder, &[], None, Vec::new(), None).trust(&own).unwrap();
        assert_eq!(trust(), None);
        keep("bard", line);
        assert_eq!(trust(), Some(fs::canonicalize(scratch.path()).unwrap().join("bard.pub")));
        // The one before it in the alphabet is another key; the one after it is the same, under another name.
        keep("anna", &line.replace("SpVE", "SpVF"));
        keep("copy", line);
        let trusted = bundle::Trust::read(&trust().unwrap()).unwrap();
        let known: Vec<&str> = trusted.keys().map(PublicKey::line).collect();
        assert!(known.len() == 2 && known.contains(&line), "{known:?}");
        // A key that is gone is trusted no more.
        fs::remove_file(scratch.path().join("anna.key")).unwrap();
        keep("dora", &line.replace("SpVE", "SpVG"));
        let trusted = bundle::Trust::read(&trust().unwrap()).unwrap();
        assert_eq!(trusted.keys().count(), 2);
    }
}
