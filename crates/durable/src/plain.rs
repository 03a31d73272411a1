//! Reads files whose place somebody else may have taken.
//!
//! Owns the one way to open them: a pipe, a device or a socket under the name of a file would hold up its reader for ever.
#![allow(clippy::missing_errors_doc, reason = "every operation fails with the error of the disk")]

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use rustix::fs::{CWD, Mode, OFlags, openat};

/// Opens the file at `path` for reading; never waits for a writer.
///
/// # Errors
/// What the disk says; those of [`plain`].
pub fn open_plain(path: &Path) -> io::Result<File> {
    let flags = OFlags::RDONLY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    plain(File::from(openat(CWD, path, flags, Mode::empty())?))
}

/// `file`, if it is a plain one.
///
/// # Errors
/// [`io::ErrorKind::InvalidData`] if it is a folder, a pipe, a device or a socket.
pub fn plain(file: File) -> io::Result<File> {
    if file.metadata()?.is_file() {
        Ok(file)
    } else {
        Err(io::Error::new(io::ErrorKind::InvalidData, "it is not a plain file"))
    }
}

/// Everything in the plain file at `path`, if that is at most `limit` bytes.
///
/// # Errors
/// Those of [`open_plain`] and [`read_all`].
pub fn read_plain(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    read_all(open_plain(path)?, limit)
}

/// The text of the plain file at `path`, if that is at most `limit` bytes.
///
/// # Errors
/// Those of [`read_plain`]; [`io::ErrorKind::InvalidData`] if it is not UTF-8.
pub fn read_plain_text(path: &Path, limit: u64) -> io::Result<String> {
    let text = String::from_utf8(read_plain(path, limit)?);
    text.map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "stream did not contain valid UTF-8"))
}

/// Everything that `reader` yields, if that is at most `limit` bytes; at most one byte more is read.
///
/// # Errors
/// Those of `reader`; that of [`too_large`].
pub fn read_all(reader: impl Read, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    reader.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit { Err(too_large(limit)) } else { Ok(bytes) }
}

/// The error for more than `limit` bytes, of the kind [`io::ErrorKind::FileTooLarge`].
pub fn too_large(limit: u64) -> io::Error {
    io::Error::new(io::ErrorKind::FileTooLarge, format!("it is larger than {limit} bytes"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::fs::mkfifoat;
    use std::fs;
    use std::os::unix::net::UnixListener;

    #[test]
    fn what_is_no_plain_file_is_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("file"), "four").unwrap();
        assert_eq!(read_plain_text(&at("file"), 4).unwrap(), "four");
        fs::create_dir(at("folder")).unwrap();
        mkfifoat(CWD, at("pipe"), Mode::RUSR | Mode::WUSR).unwrap();
        let _socket = UnixListener::bind(at("socket")).unwrap();
        for path in [at("folder"), at("pipe"), at("socket"), "/dev/zero".into(), at("missing")] {
            assert!(read_plain(&path, 4).is_err(), "{}", path.display());
        }
    }

    #[test]
    fn no_more_is_read_than_may_be() {
        assert_eq!(read_all(&b"four"[..], 4).unwrap(), b"four");
        assert_eq!(read_all(&b"five5"[..], 4).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert!(read_all(io::repeat(7), 1000).is_err());
    }
}
