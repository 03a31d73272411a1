//! A store in which something of another kind is in the place of a file or a folder.
//!
//! Owns the claim that the next stick is installed all the same, and that nothing outside the store is read or changed:
//! an unclean file system or another program may leave a pipe, a link or a folder where a file was.
//!
//! Start at [`a_store_with_any_entry_replaced_installs_the_next_stick`].

use claims::bundle_maker::rubbish;
use claims::programs::output;
use claims::unit::Unit;
use rustix::fs::{CWD, FileType, Mode, mknodat};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The kinds of entries that replace others.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Pipe,
    Link,
    Folder,
    File,
}

impl Kind {
    const ALL: [Self; 4] = [Self::Pipe, Self::Link, Self::Folder, Self::File];

    /// Puts one in the place of what is at `path`; a link leads to `outside`.
    fn replace(self, path: &Path, outside: &Path) {
        let is_folder = fs::symlink_metadata(path).unwrap().is_dir();
        (if is_folder { fs::remove_dir_all(path) } else { fs::remove_file(path) }).unwrap();
        match self {
            Self::Pipe => mknodat(CWD, path, FileType::Fifo, Mode::from_raw_mode(0o644), 0).unwrap(),
            Self::Link => symlink(outside, path).unwrap(),
            Self::Folder => {
                fs::create_dir(path).unwrap();
                fs::write(path.join("of another program"), "7").unwrap();
            }
            Self::File => fs::write(path, "of another program").unwrap(),
        }
    }
}

/// All entries below `folder`, each before those in it, by their path from `folder`.
fn entries(folder: &Path) -> Vec<PathBuf> {
    fn walk(root: &Path, folder: &Path, found: &mut Vec<PathBuf>) {
        let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        names.sort();
        for path in names {
            found.push(path.strip_prefix(root).unwrap().to_owned());
            if fs::symlink_metadata(&path).unwrap().is_dir() {
                walk(root, &path, found);
            }
        }
    }
    let mut found = Vec::new();
    walk(folder, folder, &mut found);
    found
}

#[test]
fn a_store_with_any_entry_replaced_installs_the_next_stick() {
    let (one, two) = (rubbish(1, 300, 0), rubbish(1, 300, 1));
    let unit = Unit::new();
    let (store, stored) = (unit.path("store"), unit.path("stored"));
    unit.maker.bundle(&unit.stick(), &one, &[], 1);
    unit.updated(&[]);
    fs::rename(&store, &stored).unwrap();
    unit.maker.bundle(&unit.stick(), &two, &[], 2);
    let places = entries(&stored);
    assert!(places.len() > 15, "{places:?}");
    let mut refused = Vec::new();
    for (place, kind) in places.iter().flat_map(|place| Kind::ALL.map(|kind| (place, kind))) {
        let outside = tempfile::tempdir().unwrap();
        fs::write(outside.path().join("file"), "outside").unwrap();
        assert!(output(Command::new("cp").arg("--archive").args([&stored, &store])).status.success());
        kind.replace(&store.join(place), outside.path());
        let said = output(&mut unit.update_from(Some(&unit.stick())));
        if said.status.code() != Some(0) || unit.playing().as_ref() != Some(&two) {
            refused.push(format!("{kind:?} at {}: {}", place.display(), String::from_utf8_lossy(&said.stderr)));
        }
        fs::remove_dir_all(&store).unwrap();
        let left: Vec<_> = entries(outside.path());
        assert_eq!(left, [Path::new("file")], "{kind:?} at {}", place.display());
        assert_eq!(fs::read_to_string(outside.path().join("file")).unwrap(), "outside");
    }
    assert!(refused.is_empty(), "{} of {}:\n{}", refused.len(), places.len() * Kind::ALL.len(), refused.concat());
}
