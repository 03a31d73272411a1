//! The seals in a folder of bundles.
//!
//! Owns which ones lie there, and that a new one takes its place in one step, behind all that it vouches for. Never
//! reads what they say.

use std::fs;
use std::io;

use super::{Folder, FolderError};
use crate::limits;
use crate::names::Addressees;
use crate::{seal, system};

impl Folder {
    /// The stems of all seals of flocks that lie here, sorted.
    ///
    /// # Errors
    /// [`FolderError::Read`].
    pub fn seals(&self) -> Result<Vec<String>, FolderError> {
        self.stems("seals")
    }

    /// The stems of all seals of systems that lie here, sorted; none if nobody ever laid one out here.
    ///
    /// # Errors
    /// [`FolderError::Read`].
    pub fn systems(&self) -> Result<Vec<String>, FolderError> {
        match self.stems("systems") {
            Err(FolderError::Read { source, .. }) if source.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
            stems => stems,
        }
    }

    fn stems(&self, folder: &str) -> Result<Vec<String>, FolderError> {
        let path = self.path.join(folder);
        let unread = |source| FolderError::Read { path: path.clone(), source };
        let mut stems = Vec::new();
        for entry in fs::read_dir(&path).map_err(unread)? {
            let name = entry.map_err(unread)?.file_name();
            stems.extend(name.to_str().and_then(|name| name.strip_suffix(".seal")).map(str::to_owned));
            if stems.len() > limits::SEALS {
                let many = io::Error::other(format!("there are more than {} seals", limits::SEALS));
                return Err(unread(many));
            }
        }
        stems.sort();
        Ok(stems)
    }

    /// Lays the seal out for each of its addressees, in one step each. Everything that it vouches for must be there:
    /// this is what readers look for.
    ///
    /// # Errors
    /// [`FolderError::Write`].
    pub fn put_seal(&self, addressees: &Addressees, bytes: &[u8]) -> Result<(), FolderError> {
        self.lay_out(addressees, bytes, seal::path)
    }

    /// The same for a system's seal.
    ///
    /// # Errors
    /// [`FolderError::Write`].
    pub fn put_system(&self, addressees: &Addressees, bytes: &[u8]) -> Result<(), FolderError> {
        self.lay_out(addressees, bytes, system::path)
    }

    fn lay_out(&self, addressees: &Addressees, bytes: &[u8], path: fn(&str) -> String) -> Result<(), FolderError> {
        self.sync()?;
        for stem in addressees.stems() {
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
