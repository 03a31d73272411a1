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
    /// Letters of a line on the picture, at most.
    pub const LINE: usize = 44;
    /// Letters of a line, at most, with which three lines have large letters on a display of 1280x720 pixels.
    pub const LARGE_LINE: usize = 36;
    /// Lines on the picture, at most.
    pub const LINES: usize = 3;

    /// Its words in lines of at most `most` letters of ASCII. What does not fit into the last line is left out; letters that
    /// cannot be drawn are question marks.
    pub fn lines(&self, most: usize) -> Vec<String> {
        let plain = |c: char| if c.is_ascii_graphic() { c } else { '?' };
        let mut lines: Vec<String> = Vec::new();
        for word in self.text.split_whitespace() {
            let word: String = word.chars().map(plain).take(most).collect();
            if let Some(line) = lines.last_mut().filter(|line| line.len() + 1 + word.len() <= most) {
                line.push(' ');
                line.push_str(&word);
            } else if lines.len() < Self::LINES {
                lines.push(word);
            } else {
                break;
            }
        }
        lines
    }

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
    fn words_are_wrapped_and_what_cannot_be_drawn_is_a_question_mark() {
        let wrapped = |text: &str, most| Notice { text: text.to_owned(), thousandths: None }.lines(most);
        assert_eq!(wrapped("one two\u{e9} three", 8), ["one two?", "three"]);
        assert_eq!(wrapped("abcdefghij", 4), ["abcd"]);
        assert_eq!(wrapped(&"word ".repeat(100), 9).len(), Notice::LINES);
    }

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
