//! The atomic write.
//!
//! Owns [`replace`]: after a power cut a file has the bytes from before or all of the new ones.
#![allow(clippy::missing_errors_doc, reason = "every operation fails with the error of the disk")]

use std::fs::{self, File, Metadata};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use rustix::fs::syncfs;

use crate::storage::{LocalFolder, Storage, parent};

/// Has the file at `path` in `folder` hold `bytes`, as a whole or not at all; returns when the disk has them. Two that
/// replace the same file at once must be kept apart by the caller.
///
/// # Errors
/// What the disk says. The file is as it was, unless the last step failed: to sync the folder.
pub fn replace(folder: &dyn Storage, path: &str, bytes: &[u8]) -> io::Result<()> {
    let new = format!("{path}.new");
    // A power cut may have left it, with other permissions.
    folder.remove(&new)?;
    let write = || -> io::Result<()> {
        let mut file = folder.create(&new)?;
        file.write_all(bytes)?;
        file.sync()
    };
    let renamed = write().and_then(|()| folder.rename(&new, path));
    if renamed.is_err() {
        // The disk may be full.
        let _ = folder.remove(&new);
    }
    renamed?;
    folder.sync_folder(parent(path))
}

/// Has the file at `path` hold `bytes`, as a whole or not at all; returns when the disk has them.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_with_mode(path, bytes, 0o666)
}

/// The same, with the permissions `mode`, less the process's umask.
pub fn write_with_mode(path: &Path, bytes: &[u8], mode: u32) -> io::Result<()> {
    replace(&LocalFolder::beside(path, mode, None), "", bytes)
}

/// The same for a file that a person keeps: a link is followed; permissions and, where the system lets us, the owner
/// stay.
pub fn save(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let before: Option<Metadata> = fs::metadata(&path).ok();
    replace(&LocalFolder::beside(&path, 0o666, before), "", bytes)
}

/// Syncs the finished file `new` and renames it to `path`, in the same folder; returns when the disk has both.
pub fn persist(new: &Path, path: &Path) -> io::Result<()> {
    File::open(new)?.sync_all()?;
    fs::rename(new, path)?;
    sync_names(path)
}

/// Copies the file `from` to `to`, as a whole or not at all; returns when the disk has it.
pub fn copy(from: &Path, to: &Path) -> io::Result<()> {
    let mut new = to.as_os_str().to_owned();
    new.push(".new");
    let new = Path::new(&new);
    // A power cut may have left it.
    let _ = fs::remove_file(new);
    let copied = fs::copy(from, new).and_then(|_| persist(new, to));
    if copied.is_err() {
        // The disk may be full.
        let _ = fs::remove_file(new);
    }
    copied
}

/// Returns when the disk has all names in the folder that `path` lies in.
pub fn sync_names(path: &Path) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    sync_folder(folder.unwrap_or(Path::new(".")))
}

/// Returns when the disk has all names in `folder`.
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

/// Returns when the disks have all files and names on the file systems of these folders: one call for each file system,
/// however many files were written.
pub fn sync_file_systems<'a>(folders: impl IntoIterator<Item = &'a Path>) -> io::Result<()> {
    let mut synced = Vec::new();
    for folder in folders {
        let open = File::open(folder)?;
        let disk = open.metadata()?.dev();
        if !synced.contains(&disk) {
            syncfs(&open)?;
            synced.push(disk);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::Append;
    use std::os::unix::fs::{PermissionsExt, symlink};
    use std::path::PathBuf;

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().permissions().mode() & 0o777
    }

    #[test]
    fn a_saved_file_keeps_its_permissions_and_nothing_lies_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        fs::write(&path, "before").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        fs::write(folder.path().join("a.toml.new"), "torn").unwrap();
        save(&path, b"after").unwrap();
        assert_eq!((fs::read(&path).unwrap(), mode(&path)), (b"after".to_vec(), 0o640));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_saved_file_that_is_a_link_stays_one() {
        let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let (path, real) = (folder.path().join("a.toml"), elsewhere.path().join("b.toml"));
        fs::write(&real, "before").unwrap();
        symlink(&real, &path).unwrap();
        save(&path, b"after").unwrap();
        assert_eq!(fs::read(&real).unwrap(), b"after");
        assert!(fs::symlink_metadata(&path).unwrap().is_symlink());
    }

    /// A folder in which another user puts a link at every name that is removed.
    struct Shared {
        folder: LocalFolder,
        path: PathBuf,
        elsewhere: PathBuf,
    }

    impl Storage for Shared {
        fn read(&self, path: &str, limit: u64) -> io::Result<Vec<u8>> {
            self.folder.read(path, limit)
        }

        fn append(&self, path: &str) -> io::Result<Box<dyn Append + '_>> {
            self.folder.append(path)
        }

        fn create(&self, path: &str) -> io::Result<Box<dyn Append + '_>> {
            self.folder.create(path)
        }

        fn rename(&self, from: &str, to: &str) -> io::Result<()> {
            self.folder.rename(from, to)
        }

        fn remove(&self, path: &str) -> io::Result<()> {
            self.folder.remove(path)?;
            symlink(&self.elsewhere, self.path.join(path))
        }

        fn sync_folder(&self, path: &str) -> io::Result<()> {
            self.folder.sync_folder(path)
        }
    }

    #[test]
    fn nothing_is_written_through_a_link_that_another_user_of_the_folder_puts_there_in_time() {
        let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let other = elsewhere.path().join("b");
        fs::write(&other, "before").unwrap();
        let path = folder.path().to_owned();
        let shared = Shared { folder: LocalFolder::new(&path), path, elsewhere: other.clone() };
        assert_eq!(replace(&shared, "a", b"after").unwrap_err().kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(fs::read(&other).unwrap(), b"before");
        assert!(!folder.path().join("a").exists());
    }

    #[test]
    fn a_write_that_fails_leaves_the_file_and_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        fs::write(&path, "before").unwrap();
        fs::create_dir(folder.path().join("a.toml.new")).unwrap();
        assert!(write(&path, b"after").is_err());
        assert_eq!(fs::read(&path).unwrap(), b"before");
        assert!(write(&folder.path().join("no/such"), b"after").is_err());
        let taken = folder.path().join("taken");
        fs::create_dir(&taken).unwrap();
        assert!(write(&taken, b"after").is_err() && !folder.path().join("taken.new").exists());
    }

    #[test]
    fn a_secret_is_never_readable_by_others_whatever_an_attempt_before_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("secret");
        fs::write(folder.path().join("secret.new"), "torn, and for all to read").unwrap();
        write_with_mode(&path, b"secret", 0o600).unwrap();
        assert_eq!((fs::read(&path).unwrap(), mode(&path)), (b"secret".to_vec(), 0o600));
    }
}
