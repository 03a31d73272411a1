//! The seals in a folder of bundles, and signed settings beside them.
//!
//! Lists them, and replaces them by a rename after all objects that they refer to. They are not parsed here.
#![allow(clippy::missing_errors_doc, reason = "every operation fails with `FolderError`")]

use std::collections::BTreeSet;
use std::fs;
use std::io;

use super::{Folder, FolderError};
use crate::limits;
use crate::names::{Addressees, UnitId};
use crate::{seal, settings, system};

impl Folder {
    /// The addressees of the flocks' seals here; `None` stands for all units.
    pub fn seals(&self) -> Result<BTreeSet<Option<UnitId>>, FolderError> {
        self.addressed("seals", ".seal")
    }

    /// The addressees of the systems' seals here.
    pub fn systems(&self) -> Result<BTreeSet<Option<UnitId>>, FolderError> {
        match self.addressed("systems", ".seal") {
            Err(FolderError::Read { source, .. }) if source.kind() == io::ErrorKind::NotFound => Ok(BTreeSet::new()),
            addressed => addressed,
        }
    }

    /// The addressees of the signed settings here; none if `settings` is no folder.
    pub fn settings(&self) -> Result<BTreeSet<Option<UnitId>>, FolderError> {
        let is_folder = fs::symlink_metadata(self.path.join("settings")).is_ok_and(|found| found.is_dir());
        if is_folder { self.addressed("settings", ".settings") } else { Ok(BTreeSet::new()) }
    }

    /// File names on a stick are untrusted: names that are not valid for a unit are ignored.
    fn addressed(&self, folder: &str, ending: &str) -> Result<BTreeSet<Option<UnitId>>, FolderError> {
        let path = self.path.join(folder);
        let unread = |source| FolderError::Read { path: path.clone(), source };
        let everybody = Addressees::Anyone;
        let (mut seals, mut addressed) = (0, BTreeSet::new());
        for entry in fs::read_dir(&path).map_err(unread)? {
            let name = entry.map_err(unread)?.file_name();
            let Some(stem) = name.to_str().and_then(|name| name.strip_suffix(ending)) else { continue };
            match UnitId::new(stem) {
                Ok(unit) => drop(addressed.insert(Some(unit))),
                Err(_) if everybody.file_stems().contains(&stem) => drop(addressed.insert(None)),
                Err(_) => {}
            }
            seals += 1;
            if seals > limits::SEALS {
                let many = io::Error::other(format!("there are more than {} seals", limits::SEALS));
                return Err(unread(many));
            }
        }
        Ok(addressed)
    }

    /// Writes the seal for each of its addressees, by a rename each. All objects that it refers to must be there.
    pub fn put_seal(&self, addressees: &Addressees, bytes: &[u8]) -> Result<(), FolderError> {
        self.lay_out(addressees, bytes, seal::path)
    }

    /// The same for a system's seal.
    pub fn put_system(&self, addressees: &Addressees, bytes: &[u8]) -> Result<(), FolderError> {
        self.lay_out(addressees, bytes, system::path)
    }

    /// The same for signed settings, which refer to no objects.
    pub fn put_settings(&self, addressees: &Addressees, bytes: &[u8]) -> Result<(), FolderError> {
        self.lay_out(addressees, bytes, settings::path)
    }

    fn lay_out(&self, addressees: &Addressees, bytes: &[u8], path: fn(&str) -> String) -> Result<(), FolderError> {
        self.sync()?;
        for stem in addressees.file_stems() {
            self.replace(&path(stem), bytes)?;
        }
        self.sync()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

    #[test]
    fn what_no_unit_could_be_called_is_nobodys_seal() {
        let scratch = tempfile::tempdir().unwrap();
        fs::create_dir(scratch.path().join("seals")).unwrap();
        let unit = |name| Some(UnitId::new(name).unwrap());
        let strange = ["a\nb", "\u{1b}[2J", "Lobby", "", "..", "a b", "ä", "\u{202e}attic"];
        for stem in ["lobby", "all", "attic"].iter().chain(&strange) {
            File::create(scratch.path().join(format!("seals/{stem}.seal"))).unwrap();
        }
        File::create(scratch.path().join("seals/stairs.seal.new")).unwrap();
        let folder = Folder::open(scratch.path()).unwrap();
        assert_eq!(folder.seals().unwrap(), [None, unit("attic"), unit("lobby")].into());
        assert!(folder.systems().unwrap().is_empty());
    }

    #[test]
    fn a_folder_with_more_seals_than_units_could_have_is_refused() {
        let scratch = tempfile::tempdir().unwrap();
        let folder = Folder::open(scratch.path()).unwrap();
        assert!(
            matches!(folder.seals(), Err(FolderError::Read { source, .. }) if source.kind() == io::ErrorKind::NotFound)
        );
        fs::create_dir(scratch.path().join("seals")).unwrap();
        let lay = |number: usize| File::create(scratch.path().join(format!("seals/{number}.seal"))).map(drop).unwrap();
        (0..limits::SEALS).for_each(lay);
        assert_eq!(folder.seals().unwrap().len(), limits::SEALS);
        lay(limits::SEALS);
        assert!(folder.seals().unwrap_err().to_string().contains("seals"));
    }
}
