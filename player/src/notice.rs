//! A notice for the people in front of the picture: one sentence, and the progress of a work.
//!
//! Owns the small files through which a notice reaches the player, written whole or not at all: one for short notices,
//! and one for each cause whose notice is shown until the cause is gone. They need not outlive a power cut. Never draws:
//! the player does.

use serde::{Deserialize, Serialize};
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Bytes of the file that are read, at most.
const LARGEST: u64 = 4 << 10;

/// A cause whose notice stays until somebody removes the cause. Each has a file of its own, so that a notice that is
/// shown for a moment replaces none of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lasting {
    /// The owner's file is wrong.
    Settings,
    /// The Wi-Fi does not take what stands there.
    Wifi,
}

impl Lasting {
    /// All causes, the most urgent first: only one notice has room on the picture.
    pub const ALL: [Self; 2] = [Self::Settings, Self::Wifi];

    /// The file of this cause, where short notices are written to `notice`.
    pub fn path(self, notice: &Path) -> PathBuf {
        let cause = match self {
            Self::Settings => "settings",
            Self::Wifi => "wifi",
        };
        PathBuf::from(format!("{}.{cause}", notice.display()))
    }

    /// Removes the notice of this cause from beside `notice`, if there is one.
    pub fn take_back(self, notice: &Path) -> io::Result<()> {
        match fs::remove_file(self.path(notice)) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
            Ok(()) | Err(_) => Ok(()),
        }
    }
}

/// A notice.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Notice {
    /// One plain sentence, or two.
    pub text: String,
    /// How far a work in progress is, in thousandths; `None` when it has ended, well or not.
    pub thousandths: Option<u16>,
}

impl Notice {
    /// Puts it where the player looks.
    /// Errors: What the file system says; the notice before it stays.
    pub fn tell(&self, path: &Path) -> io::Result<()> {
        durable::write(path, &serde_json::to_vec(self).map_err(io::Error::other)?)
    }

    /// The notice at `path`; `None` if there is none, or it cannot be read.
    pub fn read(path: &Path) -> Option<Self> {
        serde_json::from_slice(&durable::read_plain(path, LARGEST).ok()?).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::Notice;
    use std::fs;

    #[test]
    fn what_is_told_is_read_and_rubbish_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notice");
        assert_eq!(Notice::read(&path), None);
        let notice = Notice { text: "The new flock is coming in.".to_owned(), thousandths: Some(371) };
        notice.tell(&path).unwrap();
        assert_eq!(Notice::read(&path), Some(notice));
        for rubbish in [&b"\xff"[..], b"{}", b"", &[b' '; 9000]] {
            fs::write(&path, rubbish).unwrap();
            assert_eq!(Notice::read(&path), None);
        }
    }
}
