//! An editor's turn: the folder is locked, and nothing that a kill leaves half-written stays for long.
//!
//! Owns the lock, and the list of the files that an editor writes beside the manifest. `durable` writes each of them under
//! its name with `.new` first. The list is there while an editor writes; what it names is removed by the next editor, if the
//! one before was killed. Never removes a file that no editor has listed.
//!
//! Start at [`Turn::begin`].

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use durable::Locked;

use crate::manifest::ClipPath;

/// The list, a path on each line.
const LIST: &str = ".flock-edit";
/// The most bytes of the list: a path of 100 bytes for each file of a flock of 100,000 sheep with four transitions each.
const MOST_BYTES: u64 = 64 << 20;

/// The right to edit a flock, until it is dropped: a second editor of this flock waits.
#[derive(Debug)]
pub struct Turn {
    folder: PathBuf,
    /// The folder, locked while it is open.
    lock: Option<Locked>,
    has_list: bool,
}

impl Turn {
    /// Waits for the turn at the flock in `folder`, and removes what a killed editor has left.
    pub(super) fn begin(folder: &Path) -> Self {
        // On a file system without locks the artist must not edit twice at once.
        let lock = File::open(folder).ok().filter(|folder| folder.lock().is_ok()).map(Locked::new);
        if lock.is_some() {
            sweep(folder);
        }
        Self { folder: folder.to_owned(), lock, has_list: false }
    }

    /// Lists `files`, which are about to be written.
    pub(super) fn list<'a>(&mut self, files: impl IntoIterator<Item = &'a str>) {
        // Without a lock another editor might write the same file just now.
        if self.lock.is_none() {
            return;
        }
        let lines: String =
            files.into_iter().filter(|file| !file.contains('\n')).flat_map(|file| [file, "\n"]).collect();
        if lines.is_empty() {
            return;
        }
        let (place, mut list) = (self.folder.join(LIST), File::options());
        let written = list.create(true).append(true).open(&place).and_then(|mut list| list.write_all(lines.as_bytes()));
        self.has_list = written.is_ok();
        if written.is_err() {
            // Such as a full disk, on which the files cannot be written either. No line may be torn.
            let _ = fs::remove_file(place);
        }
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        if self.has_list {
            // The next editor finds nothing to remove.
            let _ = fs::remove_file(self.folder.join(LIST));
        }
    }
}

/// Removes what a killed editor of the flock in `folder` has left. What cannot be removed stays.
fn sweep(folder: &Path) {
    let list = folder.join(LIST);
    let Ok(text) = durable::read_plain_text(&list, MOST_BYTES) else { return };
    // A line that is torn was never written after: its editor had not begun to.
    let lines = text.split_inclusive('\n').filter_map(|line| line.strip_suffix('\n'));
    for path in lines.filter_map(|line| ClipPath::new(line).ok()) {
        let mut new = path.inside(folder).into_os_string();
        new.push(".new");
        let _ = fs::remove_file(new);
    }
    let _ = fs::remove_file(list);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_killed_editor_listed_is_removed_and_no_other_file() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("loops")).unwrap();
        let mut turn = Turn::begin(folder.path());
        turn.list(["loops/a.mp4", "credits.toml", "odd\nloops/kept.mp4"]);
        assert!(at(LIST).exists());
        for name in ["loops/a.mp4", "loops/a.mp4.new", "credits.toml.new", "loops/kept.mp4.new", "notes.new"] {
            fs::write(at(name), name).unwrap();
        }
        // It is killed within a second list, of which one line is torn.
        fs::write(at("kept"), fs::read_to_string(at(LIST)).unwrap() + "../kept\nnotes").unwrap();
        drop(turn);
        assert!(!at(LIST).exists() && at("loops/a.mp4.new").exists());
        fs::rename(at("kept"), at(LIST)).unwrap();
        drop(Turn::begin(folder.path()));
        for (name, is_there) in [
            (LIST, false),
            ("loops/a.mp4", true),
            ("loops/a.mp4.new", false),
            ("credits.toml.new", false),
            ("loops/kept.mp4.new", true),
            ("notes.new", true),
        ] {
            assert_eq!(at(name).exists(), is_there, "{name}");
        }
    }
}
