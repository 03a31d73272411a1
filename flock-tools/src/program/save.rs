//! Saving a file whole or not at all.
//!
//! Owns the order of writes: into a file beside it, to the disk, then under its name. Never knows what it saves.

use std::fs::{self, File, Metadata};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, fchown};
use std::path::{Path, PathBuf};

/// Saves `bytes` at `path`: whatever happens, there are either the bytes from before or all of the new ones.
///
/// A link is followed; permissions and, where the system lets us, the owner stay. Two that save the same file at once
/// must be kept apart by the caller.
///
/// # Errors
/// What the kernel says; the file is then as it was.
pub(crate) fn whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let before = fs::metadata(&path).ok();
    put(&path, |part| write(part, bytes, before.as_ref()))
}

/// Copies the file `from` to `to`: whatever happens, there is nothing, what was there before, or all of it.
///
/// # Errors
/// What the kernel says.
pub(crate) fn copy(from: &Path, to: &Path) -> io::Result<()> {
    put(to, |part| {
        fs::copy(from, part)?;
        File::open(part)?.sync_all()
    })
}

/// Brings to the disk what the folder of `path` calls its files.
///
/// # Errors
/// What the kernel says.
pub(crate) fn names(path: &Path) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    File::open(folder.unwrap_or(Path::new(".")))?.sync_all()
}

/// Has `write` make a file beside `path`, and gives it that name.
fn put(path: &Path, write: impl FnOnce(&Path) -> io::Result<()>) -> io::Result<()> {
    let mut part = path.to_owned().into_os_string();
    part.push(".part");
    let part = PathBuf::from(part);
    // What a power cut left there, if anything.
    let _ = fs::remove_file(&part);
    let put = write(&part).and_then(|()| fs::rename(&part, path));
    if put.is_err() {
        let _ = fs::remove_file(&part);
    }
    put?;
    names(path)
}

fn write(part: &Path, bytes: &[u8], before: Option<&Metadata>) -> io::Result<()> {
    let mut file = File::create_new(part)?;
    if let Some(before) = before {
        file.set_permissions(before.permissions())?;
        let now = file.metadata()?;
        if (now.uid(), now.gid()) != (before.uid(), before.gid()) {
            // Only root may give files away; whoever else edits a file owns what they saved.
            let _ = fchown(&file, Some(before.uid()), Some(before.gid()));
        }
    }
    file.write_all(bytes)?;
    file.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};

    #[test]
    fn what_is_saved_is_there_with_the_permissions_of_before_and_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        fs::write(&path, "before").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        fs::write(folder.path().join("a.toml.part"), "torn").unwrap();
        whole(&path, b"after").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"after");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_file_that_is_a_link_stays_one() {
        let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let (path, real) = (folder.path().join("a.toml"), elsewhere.path().join("b.toml"));
        fs::write(&real, "before").unwrap();
        symlink(&real, &path).unwrap();
        whole(&path, b"after").unwrap();
        assert_eq!(fs::read(&real).unwrap(), b"after");
        assert!(fs::symlink_metadata(&path).unwrap().is_symlink());
    }

    #[test]
    fn what_cannot_be_saved_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        fs::write(&path, "before").unwrap();
        fs::create_dir(folder.path().join("a.toml.part")).unwrap();
        assert!(whole(&path, b"after").is_err());
        assert_eq!(fs::read(&path).unwrap(), b"before");
        assert!(whole(&folder.path().join("no/such"), b"after").is_err());
    }
}
