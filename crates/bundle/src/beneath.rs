//! Access to files beneath a folder only.
//!
//! Opens files with `openat2`, so that no path can follow a symbolic link, cross a mount or leave the folder; where
//! `openat2` is not available, the folders of the path are opened one by one with the same effect. Only regular files
//! are opened, and reading is limited in size.
//!
//! Start at [`Root`].

use std::fs::File;
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::path::Path;

use durable::{Append, Storage, plain, read_all};
use rustix::fs::{AtFlags, CWD, Mode, OFlags, ResolveFlags};
use rustix::io::Errno;

/// A folder whose paths cannot lead out of it.
#[derive(Debug)]
pub(crate) struct Root(OwnedFd);

impl Root {
    /// The folder at `path`, which may itself be reached through symbolic links.
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC;
        Ok(Self(rustix::fs::openat(CWD, path, flags, Mode::empty())?))
    }

    /// Opens the plain file at `path` for reading.
    pub(crate) fn file(&self, path: &str) -> io::Result<File> {
        plain(File::from(self.at(path, OFlags::RDONLY | OFlags::NONBLOCK, 0)?))
    }

    /// Opens `path` with these flags.
    pub(crate) fn at(&self, path: &str, flags: OFlags, mode: u32) -> io::Result<OwnedFd> {
        let confined =
            ResolveFlags::BENEATH | ResolveFlags::NO_SYMLINKS | ResolveFlags::NO_MAGICLINKS | ResolveFlags::NO_XDEV;
        let flags = flags | OFlags::CLOEXEC | OFlags::NOFOLLOW;
        match rustix::fs::openat2(&self.0, path, flags, Mode::from_raw_mode(mode), confined) {
            // systemd's `RestrictSUIDSGID=` cannot check its arguments, and returns `ENOSYS`.
            Err(Errno::NOSYS) => self.open_stepwise(path, flags, mode),
            opened => Ok(opened?),
        }
    }

    /// The same without `openat2`: no part of the path may be a link, lead upwards or lie on another file system.
    fn open_stepwise(&self, path: &str, flags: OFlags, mode: u32) -> io::Result<OwnedFd> {
        if path.starts_with('/') || path.split('/').any(|part| part == "..") {
            return Err(Errno::XDEV.into());
        }
        let device = rustix::fs::fstat(&self.0)?.st_dev;
        let here = |opened: OwnedFd| {
            let is_here = rustix::fs::fstat(&opened)?.st_dev == device;
            if is_here { Ok(opened) } else { Err(io::Error::from(Errno::XDEV)) }
        };
        let (folders, name) = path.rsplit_once('/').unwrap_or(("", path));
        let way = OFlags::PATH | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        let mut folder: Option<OwnedFd> = None;
        for part in folders.split('/').filter(|part| !part.is_empty()) {
            let at = folder.as_ref().map_or(self.0.as_fd(), OwnedFd::as_fd);
            folder = Some(here(rustix::fs::openat(at, part, way, Mode::empty())?)?);
        }
        let at = folder.as_ref().map_or(self.0.as_fd(), OwnedFd::as_fd);
        here(rustix::fs::openat(at, name, flags, Mode::from_raw_mode(mode))?)
    }

    /// Opens the folder at `path`; the root itself if it is empty.
    pub(crate) fn folder(&self, path: &str) -> io::Result<OwnedFd> {
        self.at(if path.is_empty() { "." } else { path }, OFlags::RDONLY | OFlags::DIRECTORY, 0)
    }

    /// The open folder of `path`, and its file name: for calls without resolve flags.
    pub(crate) fn parent<'p>(&self, path: &'p str) -> io::Result<(OwnedFd, &'p str)> {
        let (folder, name) = path.rsplit_once('/').unwrap_or(("", path));
        if matches!(name, "" | "." | "..") {
            return Err(io::Error::from(Errno::INVAL));
        }
        Ok((self.folder(folder)?, name))
    }

    /// The size of the plain file at `path`; `None` if there is none.
    pub(crate) fn length(&self, path: &str) -> io::Result<Option<u64>> {
        match self.parent(path).and_then(|(folder, name)| length_at(&folder, name)) {
            Ok(length) => Ok(Some(length)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Whether the file at `path` has no other name: no hard link elsewhere.
    pub(crate) fn has_one_name(&self, path: &str) -> io::Result<bool> {
        let (folder, name) = self.parent(path)?;
        Ok(rustix::fs::statat(&folder, name, AtFlags::SYMLINK_NOFOLLOW)?.st_nlink <= 1)
    }
}

impl Storage for Root {
    fn read(&self, path: &str, limit: u64) -> io::Result<Vec<u8>> {
        read_all(self.file(path)?, limit)
    }

    fn append(&self, path: &str) -> io::Result<Box<dyn Append + '_>> {
        let flags = OFlags::WRONLY | OFlags::CREATE | OFlags::APPEND | OFlags::NONBLOCK;
        let file = File::from(self.at(path, flags, 0o644)?);
        Ok(Box::new(file))
    }

    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        let ((from, old), (to, new)) = (self.parent(from)?, self.parent(to)?);
        Ok(rustix::fs::renameat(from, old, to, new)?)
    }

    fn remove(&self, path: &str) -> io::Result<()> {
        let Some((folder, name)) = none_if_missing(self.parent(path))? else { return Ok(()) };
        ignore_error(rustix::fs::unlinkat(folder, name, AtFlags::empty()), io::ErrorKind::NotFound)
    }

    fn sync_folder(&self, path: &str) -> io::Result<()> {
        Ok(rustix::fs::fsync(self.folder(path)?)?)
    }
}

impl AsFd for Root {
    fn as_fd(&self) -> std::os::fd::BorrowedFd<'_> {
        self.0.as_fd()
    }
}

fn length_at(folder: &OwnedFd, name: &str) -> io::Result<u64> {
    let status = rustix::fs::statat(folder, name, AtFlags::SYMLINK_NOFOLLOW)?;
    if rustix::fs::FileType::from_raw_mode(status.st_mode).is_file() {
        Ok(u64::try_from(status.st_size).unwrap_or_default())
    } else {
        Err(io::Error::new(io::ErrorKind::InvalidData, "it is not a plain file"))
    }
}

/// What was found; `None` if a folder on the way is not there.
pub(crate) fn none_if_missing<T>(found: io::Result<T>) -> io::Result<Option<T>> {
    match found {
        Ok(found) => Ok(Some(found)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

/// Done; an error of this kind counts as done.
pub(crate) fn ignore_error(done: rustix::io::Result<()>, kind: io::ErrorKind) -> io::Result<()> {
    match done.map_err(io::Error::from) {
        Err(error) if error.kind() == kind => Ok(()),
        done => done,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::os::unix::fs::symlink;

    #[test]
    fn nothing_is_opened_outside_the_folder_nor_through_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let (inside, outside) = (folder.path().join("in"), folder.path().join("secret"));
        fs::create_dir_all(inside.join("sub")).unwrap();
        fs::write(&outside, "secret").unwrap();
        fs::write(inside.join("sub/fine"), "fine").unwrap();
        symlink(&outside, inside.join("link")).unwrap();
        symlink("sub/fine", inside.join("near")).unwrap();
        symlink("..", inside.join("up")).unwrap();
        rustix::fs::mkfifoat(CWD, inside.join("pipe"), Mode::RUSR).unwrap();
        let root = Root::open(&inside).unwrap();
        assert_eq!(read_all(root.file("sub/fine").unwrap(), 4).unwrap(), b"fine");
        let absolute = outside.to_str().unwrap();
        for path in
            ["link", "near", "up/secret", "../secret", "sub/../../secret", absolute, "pipe", "sub", "", ".", "no"]
        {
            assert!(root.file(path).is_err(), "{path}");
            let by_parts = root.open_stepwise(path, OFlags::RDONLY | OFlags::NONBLOCK | OFlags::NOFOLLOW, 0);
            assert!(by_parts.and_then(|file| plain(file.into())).is_err(), "{path}");
        }
        let by_parts = |path| root.open_stepwise(path, OFlags::RDONLY | OFlags::NOFOLLOW, 0).map(File::from);
        assert_eq!(read_all(by_parts("sub/fine").unwrap(), 4).unwrap(), b"fine");
        assert!(by_parts(".").unwrap().metadata().unwrap().is_dir());
        assert_eq!(by_parts("up/in/sub/fine").unwrap_err().raw_os_error(), Some(Errno::NOTDIR.raw_os_error()));
        for path in ["..", "sub/..", "", "up/x"] {
            assert!(root.parent(path).is_err(), "{path}");
        }
        assert_eq!(root.length("sub/fine").unwrap(), Some(4));
        assert_eq!(root.length("no").unwrap(), None);
        assert!(root.length("near").is_err());
    }
}
