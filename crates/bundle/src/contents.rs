//! The list of files of a bundle.
//!
//! Owns its one spelling: a heading, then a line for each file, sorted by path: digest, size, path. It is parsed only
//! after its digest was compared with a seal. `flock.toml` is a file like the others; [`VerifiedBundle::flock`] checks
//! that the two agree.
//!
//! ```text
//! dreams contents 1
//! 3fa91c... 5120 flock.toml
//! 9f86d0... 4194304 loops/191.21054.mp4
//! ```
//!
//! Start at [`VerifiedBundle`].

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::limits;
use crate::lines::Lines;
use crate::names::{FilePath, ObjectId, parse_plain};
use crate::refusal::{Part, Refusal};
use crate::seal::Seal;

/// The first line of a list.
const HEADING: &str = "dreams contents 1";
/// What a line holds.
const WANTED: &str = "a digest, a size and a path";

/// A file of a flock.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileEntry {
    /// Where it lies in the flock.
    pub path: FilePath,
    /// What it holds.
    pub id: ObjectId,
    /// How much that is, in bytes.
    pub size: u64,
}

/// The files of a flock, sorted by path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contents(Vec<FileEntry>);

/// A bundle whose list of files is verified. Only this type has files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VerifiedBundle {
    seal: Seal,
    contents: Contents,
    bytes: Vec<u8>,
}

impl Contents {
    /// The list of `files`, in any order.
    ///
    /// # Errors
    /// [`Refusal`] if it is invalid: a path twice, too many files, no `flock.toml`.
    pub fn new(mut files: Vec<FileEntry>) -> Result<Self, Refusal> {
        files.sort_by(|a, b| a.path.cmp(&b.path));
        let contents = Self(files);
        let text = contents.to_text();
        if text.len() as u64 > limits::CONTENTS {
            return Err(Refusal::TooLarge { part: Part::Contents, limit: limits::CONTENTS });
        }
        Self::parse(text.as_bytes())
    }

    /// The files, sorted by path.
    pub fn files(&self) -> &[FileEntry] {
        &self.0
    }

    /// The bytes of the list.
    pub fn to_text(&self) -> String {
        let lines = self.0.iter().map(|file| format!("{} {} {}\n", file.id, file.size, file.path));
        std::iter::once(format!("{HEADING}\n")).chain(lines).collect()
    }

    /// Every object once, with its size, in the order of its first path; `flock.toml` first.
    pub fn objects(&self) -> Vec<&FileEntry> {
        let mut seen = BTreeSet::new();
        let flock = self.0.iter().filter(|file| file.path.as_str() == flock::FILE_NAME);
        flock.chain(&self.0).filter(|file| seen.insert(file.id)).collect()
    }

    /// Parses a list. Memory is limited to a few times its size.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, Refusal> {
        let part = Part::Contents;
        if bytes.len() as u64 > limits::CONTENTS {
            return Err(Refusal::TooLarge { part, limit: limits::CONTENTS });
        }
        let text = std::str::from_utf8(bytes).map_err(|_| Refusal::NotSigned { part, why: "it is not text" })?;
        let mut lines = Lines::new(Part::Contents, text);
        lines.expect_line(HEADING)?;
        let mut files: Vec<FileEntry> = Vec::new();
        let mut sizes: BTreeMap<ObjectId, u64> = BTreeMap::new();
        let mut total: u64 = 0;
        while let Some(line) = lines.next(WANTED)? {
            if files.len() == limits::FILES {
                return Err(Refusal::TooMany { part: Part::Contents, limit: limits::FILES, things: "files" });
            }
            let file = entry(line, &lines)?;
            total = total.saturating_add(file.size);
            if file.size > limits::FILE {
                return Err(Refusal::TooLarge { part: Part::Object(file.id), limit: limits::FILE });
            }
            let out_of_order = files.last().is_some_and(|last| last.path >= file.path);
            if out_of_order || *sizes.entry(file.id).or_insert(file.size) != file.size {
                return Err(Refusal::Order { part: Part::Contents, line: lines.line(), path: file.path });
            }
            files.push(file);
        }
        if total > limits::TOTAL {
            return Err(Refusal::TooLarge { part: Part::Contents, limit: limits::TOTAL });
        }
        let contents = Self(files);
        contents.has_no_file_as_folder()?;
        match contents.file(flock::FILE_NAME) {
            None => Err(Refusal::MissingFile { path: flock::FILE_NAME.to_owned() }),
            Some(toml) if toml.size > limits::FLOCK_TOML => {
                Err(Refusal::TooLarge { part: Part::Flock, limit: limits::FLOCK_TOML })
            }
            Some(_) => Ok(contents),
        }
    }

    /// The file at `path`.
    pub fn file(&self, path: &str) -> Option<&FileEntry> {
        self.0.binary_search_by(|file| file.path.as_str().cmp(path)).ok().map(|at| &self.0[at])
    }

    fn has_no_file_as_folder(&self) -> Result<(), Refusal> {
        for (index, file) in self.0.iter().enumerate() {
            if file.path.folders().any(|folder| self.file(folder).is_some()) {
                return Err(Refusal::Order { part: Part::Contents, line: index + 2, path: file.path.clone() });
            }
        }
        Ok(())
    }
}

impl VerifiedBundle {
    pub(crate) fn new(seal: Seal, contents: Contents, bytes: Vec<u8>) -> Self {
        Self { seal, contents, bytes }
    }

    /// The seal that vouches for it.
    pub fn seal(&self) -> &Seal {
        &self.seal
    }

    /// Its files.
    pub fn contents(&self) -> &Contents {
        &self.contents
    }

    /// The bytes of the list of files, as signed.
    pub fn contents_bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Reads the flock from the bytes of its `flock.toml`, which must be those that were signed, and checks that the
    /// bundle carries every clip that it names.
    ///
    /// # Errors
    /// [`Refusal`] if the bytes differ, are not a flock, or name a file that the bundle lacks.
    pub fn flock(&self, toml: &[u8]) -> Result<flock::Manifest, Refusal> {
        let missing = |path: &str| Refusal::MissingFile { path: path.to_owned() };
        let listed = self.contents.file(flock::FILE_NAME).ok_or_else(|| missing(flock::FILE_NAME))?;
        let found = ObjectId::of(toml);
        if found != listed.id {
            return Err(Refusal::Damaged { part: Part::Flock, expected: listed.id, found });
        }
        let path = Path::new(flock::FILE_NAME);
        let text =
            std::str::from_utf8(toml).map_err(|_| Refusal::NotSigned { part: Part::Flock, why: "it is not text" })?;
        let manifest = flock::Manifest::parse_on_unit(text, path).map_err(|source| Refusal::NotAFlock { source })?;
        let genomes = manifest.sheep.iter().filter_map(|sheep| sheep.genome.as_ref());
        let named = manifest.clips().map(|clip| &clip.path).chain(genomes);
        for path in named.map(flock::ClipPath::as_str) {
            self.contents.file(path).ok_or_else(|| missing(path))?;
        }
        Ok(manifest)
    }
}

fn entry(line: &str, lines: &Lines<'_>) -> Result<FileEntry, Refusal> {
    let mut words = line.splitn(3, ' ');
    let (Some(id), Some(size), Some(path)) = (words.next(), words.next(), words.next()) else {
        return Err(lines.wrong_line(WANTED, line));
    };
    let id = ObjectId::parse(id).map_err(|error| lines.bad_name(error))?;
    let size = parse_plain(size).ok_or_else(|| lines.wrong_line(WANTED, line))?;
    let path = FilePath::new(path).map_err(|error| lines.bad_name(error))?;
    Ok(FileEntry { path, id, size })
}
