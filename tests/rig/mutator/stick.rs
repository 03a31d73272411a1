//! The content of a stick, and a good one to begin with.
//!
//! Owns writing a stick to a folder, also with what no bundle has: folders, links, pipes and files without end in place
//! of files. The texts of a bundle are written by hand here, so that they can be wrong.
//!
//! Start at [`Good::new`] and [`Stick::lay`].

use super::keys::{KeyHolder, Keys};
use crate::bundle_maker::Files;
use bundle::ObjectId;
use rustix::fs::{CWD, Mode, mkfifoat};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::path::Path;

/// The size of a huge file: 100 GiB of holes.
const HUGE: u64 = 100 << 30;

/// What is in the place of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Item {
    /// A file.
    Bytes(Vec<u8>),
    /// An empty folder.
    Folder,
    /// A symbolic link.
    Link(String),
    /// A pipe without a writer.
    Pipe,
    /// A file that begins with these bytes and has no end.
    Huge(Vec<u8>),
}

/// The content of a stick, by path.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stick(pub BTreeMap<String, Item>);

/// A good stick.
#[derive(Clone, Debug)]
pub struct Good {
    /// Its content.
    pub stick: Stick,
    /// The files of its flock.
    pub files: Files,
    /// The number of its bundle.
    pub sequence: u64,
    /// Who has signed it.
    pub who: KeyHolder,
    /// For which unit.
    pub unit: String,
}

impl Stick {
    /// The bytes at `path`; none if there is no file.
    pub fn bytes(&self, path: &str) -> &[u8] {
        match self.0.get(path) {
            Some(Item::Bytes(bytes)) => bytes,
            Some(Item::Folder | Item::Link(_) | Item::Pipe | Item::Huge(_)) | None => &[],
        }
    }

    /// Puts `bytes` at `path`.
    pub fn put(&mut self, path: &str, bytes: impl Into<Vec<u8>>) {
        self.0.insert(path.to_owned(), Item::Bytes(bytes.into()));
    }

    /// Puts an object in its place; returns where.
    pub fn put_object(&mut self, bytes: &[u8]) -> String {
        let path = ObjectId::of(bytes).path();
        self.put(&path, bytes);
        path
    }

    /// Whether all of it are plain files, as a web server has them.
    pub fn is_plain(&self) -> bool {
        self.0.values().all(|item| matches!(item, Item::Bytes(_)))
    }

    /// Makes `folder` hold this and nothing else.
    pub fn lay(&self, folder: &Path) {
        fs::remove_dir_all(folder).ok();
        fs::create_dir_all(folder).unwrap();
        for (path, item) in &self.0 {
            let path = folder.join(path);
            let parent = path.parent().expect("it lies in the folder");
            // A file in place of a folder hides the files in it.
            if fs::create_dir_all(parent).is_err() {
                continue;
            }
            match item {
                Item::Bytes(bytes) => fs::write(&path, bytes).unwrap(),
                Item::Folder => fs::create_dir_all(&path).unwrap(),
                Item::Link(to) => symlink(to, &path).unwrap(),
                Item::Pipe => mkfifoat(CWD, &path, Mode::RUSR | Mode::WUSR).unwrap(),
                Item::Huge(bytes) => {
                    fs::write(&path, bytes).unwrap();
                    File::options().write(true).open(&path).unwrap().set_len(HUGE).unwrap();
                }
            }
        }
    }
}

impl Good {
    /// The bundle of `files` for `unit`, signed by `who`.
    pub fn new(keys: &Keys, files: &Files, who: KeyHolder, unit: &str, sequence: u64) -> Self {
        let mut stick = Stick::default();
        for bytes in files.values() {
            stick.put_object(bytes);
        }
        let mut good = Self { stick, files: files.clone(), sequence, who, unit: unit.to_owned() };
        let list = good.list();
        good.stick.put_object(list.as_bytes());
        let seal = keys.sign(who, good.letter(&list).as_bytes());
        good.stick.put(&good.seal(), seal);
        good
    }

    /// The path of its seal.
    pub fn seal(&self) -> String {
        format!("seals/{}.seal", self.unit)
    }

    /// Its list of files.
    pub fn list(&self) -> String {
        let line = |(path, bytes): (&String, &Vec<u8>)| format!("{} {} {path}\n", ObjectId::of(bytes), bytes.len());
        std::iter::once("dreams contents 1\n".to_owned()).chain(self.files.iter().map(line)).collect()
    }

    /// The letter that names `list`.
    pub fn letter(&self, list: &str) -> String {
        self.letter_of(list.as_bytes())
    }

    /// The same of any bytes.
    pub fn letter_of(&self, list: &[u8]) -> String {
        let (unit, sequence) = (&self.unit, self.sequence);
        format!(
            "dreams seal 1\nflock aurora\nunits {unit}\nsequence {sequence}\ncreated 2026-03-01T12:00:00Z\ncontents {} {}\n",
            list.len(),
            ObjectId::of(list)
        )
    }

    /// Adds statements.
    pub fn say(&mut self, statements: &[Vec<u8>]) {
        self.stick.put("statements", statements.concat());
    }

    /// Adds the system of the fixtures, signed by the artist.
    pub fn add_system(&mut self, keys: &Keys, fixtures: &Path) {
        let from = fixtures.join("format-1/stick");
        let signed = fs::read_to_string(from.join("systems/all.seal")).unwrap();
        let text: String = signed.split_inclusive('\n').skip(4).collect();
        for line in text.lines().filter(|line| line.starts_with("start ") || line.starts_with("root ")) {
            let id = ObjectId::parse(line.rsplit(' ').next().unwrap()).unwrap();
            self.stick.put(&id.path(), fs::read(from.join(id.path())).unwrap());
        }
        self.stick.put("systems/all.seal", keys.sign(KeyHolder::Artist, text.as_bytes()));
    }

    /// The text of its system's seal, without the signature; empty if it has none.
    pub fn release(&self) -> String {
        let signed = String::from_utf8(self.stick.bytes("systems/all.seal").to_vec()).unwrap();
        signed.split_inclusive('\n').skip(4).collect()
    }
}
