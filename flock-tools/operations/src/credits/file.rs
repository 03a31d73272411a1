//! `credits.toml`: who made what in a flock, and under which licences, where no genome says so.
//!
//! Owns the file: its keys, its errors, and edits that keep every other byte of it, as `flock.toml`'s do. The artist may
//! write into it at any time. It lies beside the manifest because the manifest's keys are fixed: units refuse others.
//!
//! ```toml
//! [default]                             # what has neither authors nor a licence
//! authors = ["Ada"]
//! licence = "CC-BY-4.0"                 # SPDX
//!
//! [[sheep]]
//! id = "247.505"
//! authors = ["cqfd93 <example.org>"]    # these five may be left out
//! licence = "CC-BY-NC-3.0"
//! source = "electricsheep.247.00505"
//! parents = ["247.387"]
//! attribution = "artwork by Scott Draves and the Electric Sheep"
//!
//! [[transition]]
//! from = "247.505"
//! to = "247.387"
//! source = "electricsheep.247.12345"
//! ```
//!
//! Start at [`CreditsFile::read`].

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use flock::{Manifest, SheepId, excerpt};
use toml::Spanned;

use super::entry::{Entry, Said, Subject, quoted};
use super::licence::Licence;
use crate::flock_folder::paths::CREDITS;
use crate::program::{Exit, Fatal};

/// The top of a new file.
const HEADING: &str = "\
# Who made the sheep and transitions of this flock, and under which licences (SPDX). `dreams import` adds an entry for what
# has none, and changes no other. An entry goes before the genome, which may name authors, parents and a licence, too.
";

/// The file, as read or as edited.
#[derive(Debug)]
pub struct CreditsFile {
    path: PathBuf,
    text: String,
    default: Said,
    entries: BTreeMap<Subject, Entry>,
    is_edited: bool,
}

/// Why the file is refused.
#[derive(Debug, thiserror::Error)]
enum CreditsError {
    #[error("`{path}`, line {line}, key `{key}`: {message}")]
    Key { path: PathBuf, line: usize, key: String, message: String },
    #[error("cannot read `{path}`")]
    Read { path: PathBuf, source: io::Error },
    #[error("`{path}`, line {line}: {subject} has an entry already, in line {first}")]
    Twice { path: PathBuf, line: usize, subject: String, first: usize },
    #[error("`{path}` was not saved: the edited text does not read back")]
    Unsaved { path: PathBuf, source: Box<CreditsError> },
}

/// The file's tables.
#[derive(Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    default: Option<Spanned<DefaultTable>>,
    #[serde(default)]
    sheep: Vec<Spanned<SheepTable>>,
    #[serde(default)]
    transition: Vec<Spanned<TransitionTable>>,
}

#[derive(Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct DefaultTable {
    authors: Option<Vec<String>>,
    licence: Option<Spanned<String>>,
    attribution: Option<String>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct SheepTable {
    id: Spanned<String>,
    authors: Option<Vec<String>>,
    licence: Option<Spanned<String>>,
    source: Option<String>,
    parents: Option<Vec<String>>,
    attribution: Option<String>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct TransitionTable {
    from: Spanned<String>,
    to: Spanned<String>,
    authors: Option<Vec<String>>,
    licence: Option<Spanned<String>>,
    source: Option<String>,
    attribution: Option<String>,
}

impl CreditsFile {
    /// Reads the file of the flock in `folder`; an empty one if there is none.
    /// Errors: If it is malformed; file, line and key are named.
    pub fn read(folder: &Path) -> Result<Self, Fatal> {
        let path = folder.join(CREDITS);
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            Err(source) => {
                // A file that was read and is no text is malformed.
                let is_read = source.kind() == io::ErrorKind::InvalidData;
                let exit = if is_read { Exit::Malformed } else { Exit::Unreadable };
                return Err(Fatal::new(exit, CreditsError::Read { path, source }));
            }
        };
        Self::parse(&path, text).map_err(|error| Fatal::new(Exit::Malformed, error))
    }

    /// The file with this text, which is not read from the disk.
    /// Errors: If it is malformed; line and key are named.
    pub fn of_text(text: &str) -> Result<Self, Fatal> {
        Self::parse(Path::new(CREDITS), text.to_owned()).map_err(|error| Fatal::new(Exit::Malformed, error))
    }

    /// The text, as edited.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// What holds for everything that has neither authors nor a licence.
    pub fn default(&self) -> &Said {
        &self.default
    }

    /// What the file says of `subject`.
    pub fn said(&self, subject: &Subject) -> Option<&Said> {
        self.entries.get(subject).map(|entry| &entry.said)
    }

    /// Everything that has an entry.
    pub fn subjects(&self) -> impl Iterator<Item = &Subject> {
        self.entries.keys()
    }

    /// Adds an entry for each of `notes` that has none; of several for the same, the first counts.
    pub fn add(&mut self, notes: impl IntoIterator<Item = (Subject, Said)>) -> Result<(), Fatal> {
        let mut there: BTreeSet<Subject> = self.entries.keys().cloned().collect();
        let mut text = if self.text.is_empty() { HEADING.to_owned() } else { self.text.clone() };
        let end = if text.contains("\r\n") { "\r\n" } else { "\n" };
        let before = there.len();
        for (subject, said) in notes {
            if !said.is_empty() && there.insert(subject.clone()) {
                let newline = if text.ends_with('\n') { "" } else { end };
                text.extend([newline, end, &subject.table(&said).join(end), end]);
            }
        }
        if there.len() == before { Ok(()) } else { self.replace(text) }
    }

    /// Gives the entries of the sheep `old` the id `new`.
    /// Errors: If `new` has an entry already.
    pub fn rename(&mut self, old: &SheepId, new: &SheepId) -> Result<(), Fatal> {
        let named = |(subject, entry): (&Subject, &Entry)| {
            let ids = subject.ids().into_iter().zip(&entry.ids).filter(|(id, _)| *id == old);
            ids.map(|(_, place)| place.clone()).collect::<Vec<_>>()
        };
        let places = self.entries.iter().flat_map(named).collect();
        self.put(places, &quoted(new.as_str()))
    }

    /// Removes the entries of `subjects`, each with its lines and a blank one above; comments between entries stay.
    pub fn remove(&mut self, subjects: &BTreeSet<Subject>) -> Result<(), Fatal> {
        let gone = self.entries.iter().filter(|(subject, _)| subjects.contains(subject));
        let place = |entry: &Entry| {
            let above = &self.text[..entry.lines.start];
            let blank = ["\n\r\n", "\n\n"].into_iter().find(|end| above.ends_with(end));
            entry.lines.start - blank.map_or(0, |end| end.len() - 1)..entry.lines.end
        };
        let places = gone.map(|(_, entry)| place(entry)).collect();
        self.put(places, "")
    }

    /// Saves the file if it was edited.
    pub fn save(&self) -> Result<(), Fatal> {
        if !self.is_edited {
            return Ok(());
        }
        durable::save(&self.path, self.text.as_bytes()).map_err(|source| Fatal::file("save", &self.path, source))
    }

    /// The entries of what `manifest` has.
    pub fn named_in(&self, manifest: &Manifest) -> BTreeSet<Subject> {
        if self.entries.is_empty() {
            return BTreeSet::new();
        }
        let sheep = manifest.sheep.iter().map(|sheep| Subject::Sheep(sheep.id.clone()));
        let transitions = manifest.transitions.iter().map(|t| Subject::Transition(t.from.clone(), t.to.clone()));
        sheep.chain(transitions).filter(|subject| self.entries.contains_key(subject)).collect()
    }

    /// Puts `new` at each of `places`.
    fn put(&mut self, mut places: Vec<Range<usize>>, new: &str) -> Result<(), Fatal> {
        places.sort_by_key(|place| place.start);
        let (mut text, mut at) = (String::with_capacity(self.text.len()), 0);
        for place in &places {
            text += &self.text[at..place.start];
            text += new;
            at = place.end;
        }
        text += &self.text[at..];
        if places.is_empty() { Ok(()) } else { self.replace(text) }
    }

    /// Takes an edited text, which must read back.
    fn replace(&mut self, text: String) -> Result<(), Fatal> {
        match Self::parse(&self.path, text) {
            Ok(edited) => {
                *self = Self { is_edited: true, ..edited };
                Ok(())
            }
            // Two entries of one sheep are the artist's to decide; all else would be a bug of ours.
            Err(twice @ CreditsError::Twice { .. }) => Err(Fatal::new(Exit::No, twice).hint("keep one of the two")),
            Err(error) => {
                let unsaved = CreditsError::Unsaved { path: self.path.clone(), source: Box::new(error) };
                Err(Fatal::new(Exit::Unreadable, unsaved))
            }
        }
    }

    fn parse(path: &Path, text: String) -> Result<Self, CreditsError> {
        let source = Source { path, text: &text };
        let document: Document = toml::from_str(&text).map_err(|error| source.syntax(&error))?;
        let licence = |licence: Option<Spanned<String>>| licence.map(|text| source.licence(&text)).transpose();
        let mut headers: BTreeSet<usize> = document.default.iter().map(|table| table.span().start).collect();
        headers.extend(document.sheep.iter().map(|table| table.span().start));
        headers.extend(document.transition.iter().map(|table| table.span().start));
        let DefaultTable { authors, licence: text_of_default, attribution } =
            document.default.map(Spanned::into_inner).unwrap_or_default();
        let default = Said { authors, licence: licence(text_of_default)?, attribution, ..Said::default() };
        let mut read = Vec::new();
        for table in document.sheep {
            let start = table.span().start;
            let SheepTable { id, authors, licence: text, source: file, parents, attribution } = table.into_inner();
            let said = Said { authors, licence: licence(text)?, source: file, parents, attribution };
            read.push((start, Subject::Sheep(source.id("id", &id)?), said, vec![id.span()]));
        }
        for table in document.transition {
            let start = table.span().start;
            let TransitionTable { from, to, authors, licence: text, source: file, attribution } = table.into_inner();
            let said = Said { authors, licence: licence(text)?, source: file, parents: None, attribution };
            let subject = Subject::Transition(source.id("from", &from)?, source.id("to", &to)?);
            read.push((start, subject, said, vec![from.span(), to.span()]));
        }
        let mut entries: BTreeMap<Subject, Entry> = BTreeMap::new();
        for (start, subject, said, ids) in read {
            let lines = source.lines_of_table(start, &headers)?;
            if let Some(first) = entries.get(&subject) {
                let lines = [first.lines.start, lines.start].map(|at| source.line(at));
                let (first, line) = (lines[0].min(lines[1]), lines[0].max(lines[1]));
                return Err(CreditsError::Twice { path: path.to_owned(), line, subject: subject.to_string(), first });
            }
            entries.insert(subject, Entry { said, lines, ids });
        }
        Ok(Self { path: path.to_owned(), text, default, entries, is_edited: false })
    }
}

/// The text, for errors and places.
#[derive(Clone, Copy)]
struct Source<'a> {
    path: &'a Path,
    text: &'a str,
}

impl<'a> Source<'a> {
    fn line(self, at: usize) -> usize {
        1 + self.text.get(..at).unwrap_or(self.text).matches('\n').count()
    }

    /// Where the line with the byte `at` starts.
    fn line_start(self, at: usize) -> usize {
        self.text[..at].rfind('\n').map_or(0, |newline| newline + 1)
    }

    /// The key of that line, or the whole line where there is no `=`.
    fn key(self, at: usize) -> &'a str {
        let line = self.text[self.line_start(at)..].lines().next().unwrap_or_default();
        line.split('=').next().unwrap_or_default().trim()
    }

    fn error(self, at: usize, key: &str, message: String) -> CreditsError {
        CreditsError::Key { path: self.path.to_owned(), line: self.line(at), key: key.to_owned(), message }
    }

    fn syntax(self, error: &toml::de::Error) -> CreditsError {
        let at = error.span().map_or(0, |span| span.start.min(self.text.len()));
        let message = error.message().chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        self.error(at, &excerpt(self.key(at)), message)
    }

    fn id(self, key: &str, id: &Spanned<String>) -> Result<SheepId, CreditsError> {
        SheepId::new(id.get_ref()).map_err(|error| self.error(id.span().start, key, excerpt(&error.to_string())))
    }

    fn licence(self, text: &Spanned<String>) -> Result<Licence, CreditsError> {
        Licence::read(text.get_ref()).ok_or_else(|| {
            let found = excerpt(text.get_ref());
            let message =
                format!("wanted an SPDX expression, such as `CC-BY-4.0` or `LicenseRef-mine`, found `{found}`");
            self.error(text.span().start, "licence", message)
        })
    }

    /// The lines of the table whose header is at `start`, up to its last key: below it are blank lines and comments until
    /// the next of `headers`.
    /// Errors: If it has no header, as in `sheep = [{ id = "a" }]`.
    fn lines_of_table(self, start: usize, headers: &BTreeSet<usize>) -> Result<Range<usize>, CreditsError> {
        let first = self.line_start(start);
        if !self.text[first..].trim_start().starts_with("[[") {
            let message = "wanted `[[sheep]]` or `[[transition]]` above each entry, found a list".to_owned();
            return Err(self.error(start, self.key(start), message));
        }
        let next = headers.range(start + 1..).next().map_or(self.text.len(), |next| self.line_start(*next));
        let (mut at, mut end) = (first, first);
        for line in self.text[first..next].split_inclusive('\n') {
            at += line.len();
            if !line.trim().is_empty() && !line.trim().starts_with('#') {
                end = at;
            }
        }
        Ok(first..end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheep(id: &str) -> Subject {
        Subject::Sheep(SheepId::new(id).unwrap())
    }

    fn parse(text: &str) -> Result<CreditsFile, String> {
        CreditsFile::parse(Path::new("credits.toml"), text.to_owned()).map_err(|error| error.to_string())
    }

    /// By hand: comments everywhere, keys in any order, values of several lines, line ends of two kinds.
    const BY_HAND: &str = "# mine\n[default]\nlicence = 'CC BY 4.0'\n\n# the best\r\n[[ sheep ]] # here\r\nlicence = \
        \"CC-BY-NC-3.0\" # sure?\r\nauthors = [\n  # first\n  \"a\",\n  \"b [[sheep]]\",\n]\nid='ram'\n\n# between\n\n\
        [[transition]]\nfrom = \"ram\"\nto = \"ewe\"\nattribution = \"\"\"\n[[sheep]]\nid = 'kid'\n\"\"\"\n# below\n\n\
        [[sheep]]\nid = \"ewe\"\nparents = [\"1\"]\n# the end";

    #[test]
    fn edits_keep_every_byte_that_they_do_not_concern() {
        let mut file = parse(BY_HAND).unwrap();
        assert_eq!(file.default().licence.as_ref().map(Licence::as_str), Some("CC-BY-4.0"));
        assert_eq!(file.said(&sheep("ram")).unwrap().authors.as_ref().unwrap().len(), 2);
        file.rename(&SheepId::new("ram").unwrap(), &SheepId::new("tup").unwrap()).unwrap();
        assert_eq!(file.text, BY_HAND.replace("id='ram'", "id=\"tup\"").replace("from = \"ram\"", "from = \"tup\""));
        file.rename(&SheepId::new("tup").unwrap(), &SheepId::new("ram").unwrap()).unwrap();
        file.remove(&BTreeSet::from([sheep("ram")])).unwrap();
        let (before, rest) = BY_HAND.split_once("[[ sheep ]]").unwrap();
        let after = rest.split_once("id='ram'\n").unwrap().1;
        assert_eq!(file.text, format!("{before}{after}"));
        file.remove(&BTreeSet::from([sheep("ewe")])).unwrap();
        assert_eq!(file.text, format!("{before}{after}").replace("\n[[sheep]]\nid = \"ewe\"\nparents = [\"1\"]\n", ""));
    }

    #[test]
    fn what_is_added_reads_back_and_what_is_there_stays() {
        let mut file = parse("").unwrap();
        let said = Said {
            authors: Some(vec!["\u{1b}[2J \"Ram\" \\".to_owned()]),
            licence: Licence::read("CC-BY-4.0"),
            source: Some("a\nb".to_owned()),
            parents: Some(vec!["9.1".to_owned()]),
            attribution: Some("by 'Ram'".to_owned()),
        };
        file.add([(sheep("ram"), said.clone()), (sheep("ram"), Said::default()), (sheep("ewe"), Said::default())])
            .unwrap();
        assert_eq!((file.said(&sheep("ram")), file.said(&sheep("ewe"))), (Some(&said), None));
        let text = file.text.clone();
        file.add([(sheep("ram"), Said { licence: None, ..said })]).unwrap();
        assert_eq!(file.text, text);
        let mut odd = parse(BY_HAND).unwrap();
        odd.add([(sheep("kid"), Said { source: Some("x".to_owned()), ..Said::default() })]).unwrap();
        assert!(odd.text.starts_with(BY_HAND) && odd.said(&sheep("kid")).is_some());
    }

    #[test]
    fn whatever_is_wrong_is_named_with_its_line_and_its_key() {
        for (text, wanted) in [
            ("[[sheep]]\nid = \"a b\"\n", "line 2, key `id`: wanted 1 to 64 of"),
            (
                "[[sheep]]\nid = \"a\"\nlicense = \"MIT\"\n",
                "line 3, key `license`: unknown field `license`, expected one of",
            ),
            ("[[sheep]]\nid = \"a\"\nlicence = \"ours\"\n", "line 3, key `licence`: wanted an SPDX expression"),
            ("[[sheep]]\nid = \"a\"\nauthors = \"b\"\n", "line 3, key `authors`: invalid type: string"),
            ("\n[[sheep]]\nlicence = \"MIT\"\n", "line 2, key `[[sheep]]`: missing field `id`"),
            ("[[shep]]\nid = \"a\"\n", "line 1, key `[[shep]]`: unknown field `shep`"),
            ("sheep = [{ id = \"a\" }]\n", "line 1, key `sheep`: wanted `[[sheep]]`"),
            ("[[sheep]]\nid = \"a\n", "line 2, key `id`: "),
            ("[[sheep]]\nid = \"a\"\n[[sheep]]\nid = \"a\"\n", "line 3: sheep `a` has an entry already, in line 1"),
            ("[[transition]]\nfrom = \"a\"\nto = \"b\"\nparents = [\"c\"]\n", "line 4, key `parents`: unknown field"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.starts_with(&format!("`credits.toml`, {wanted}")), "{error}");
        }
    }
}
