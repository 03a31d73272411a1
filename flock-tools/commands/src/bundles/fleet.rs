//! `fleet.toml`: what was published for which unit, and where.
//!
//! Owns the table: a row for each unit, written by `dreams publish`, so that the artist knows which unit has which flock.
//! Without the file `dreams verify` does not know which units have bundles of their own. It lies on a stick that anybody may
//! have had, so that it is read within the memory of `bundle::limits`.
//!
//! ```toml
//! [[unit]]
//! id = "lobby"                          # or `all`, for the bundle for every unit
//! flock = "aurora"
//! sequence = 7
//! key = "8A1F5C9E0D2B4371"
//! to = "/media/stick"
//! published = "2026-03-01T12:00:00Z"
//! place = "Hotel Adler, by the stairs"  # the artist's own words, kept
//! ```
//!
//! Start at [`Fleet::read`].

use std::io;
use std::path::{Path, PathBuf};

use bundle::{Addressees, UnitId};
use operations::program::{Exit, Fatal};

/// The file's name, beside the bundles.
pub(super) const FILE_NAME: &str = "fleet.toml";
/// Most bytes of the table: 400 for each of as many units as a folder has seals.
const MOST_BYTES: u64 = 4 << 20;
/// Most bytes of it that are parsed at once. Dotted keys, the worst case, take 560 times their bytes.
const MOST_PARSED_BYTES: usize = 128 << 10;
/// The comment at its top.
const HEADING: &str = "# What was published for which unit, and where. `dreams publish` keeps it; `place` is yours.\n";

/// The table.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Fleet {
    #[serde(default, rename = "unit")]
    pub(super) rows: Vec<Row>,
}

/// The last bundle that was published for a unit.
#[derive(Clone, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Row {
    pub(super) id: String,
    pub(super) flock: String,
    pub(super) sequence: u64,
    pub(super) key: String,
    pub(super) to: String,
    pub(super) published: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) place: Option<String>,
}

/// A table that cannot be parsed.
#[derive(Debug, thiserror::Error)]
#[error("`{path}` is not a table of units: line {line}: {message}")]
struct FleetError {
    path: PathBuf,
    /// From 1.
    line: usize,
    message: String,
}

impl Fleet {
    /// Reads the table at `path`; an empty one if there is none.
    pub(super) fn read(path: &Path) -> Result<Self, Fatal> {
        match durable::read_plain_text(path, MOST_BYTES) {
            Ok(text) => Self::parse(&text).map_err(|(at, message)| {
                let line = 1 + text[..at].matches('\n').count();
                Fatal::new(Exit::Malformed, FleetError { path: path.to_owned(), line, message })
            }),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Self::default()),
            Err(source) => Err(Fatal::read(path, source)),
        }
    }

    /// The table in `text`, of which whole rows are parsed at once.
    /// Errors: The byte that is wrong, and why.
    fn parse(text: &str) -> Result<Self, (usize, String)> {
        let (mut fleet, mut at) = (Self::default(), 0);
        while let Some(part) = first_rows(&text[at..]) {
            let read: Self = toml::from_str(part).map_err(|error: toml::de::Error| {
                (at + error.span().map_or(0, |span| span.start), error.message().replace('\n', ", "))
            })?;
            fleet.rows.extend(read.rows);
            at += part.len();
        }
        if at < text.len() { Err((at, format!("a row has at most {MOST_PARSED_BYTES} bytes"))) } else { Ok(fleet) }
    }

    /// The addressees of the last bundle of `unit`, by the table.
    pub(super) fn last_addressees(&self, unit: &UnitId) -> Option<Addressees> {
        self.rows.iter().find(|row| row.id == unit.as_str()).map(|_| Addressees::of([unit.clone()]))
    }

    /// Sets the row of a unit; its place stays.
    pub(super) fn set(&mut self, row: Row) {
        match self.rows.iter_mut().find(|there| there.id == row.id) {
            Some(there) => *there = Row { place: there.place.take(), ..row },
            None => self.rows.push(row),
        }
        self.rows.sort_by(|a, b| a.id.cmp(&b.id));
    }

    /// Saves the table at `path`.
    pub(super) fn save(&self, path: &Path) -> Result<(), Fatal> {
        let unsaved = |source| Fatal::write(path, source);
        let text = toml::to_string(self).map_err(|error| unsaved(io::Error::other(error)))?;
        durable::save(path, format!("{HEADING}\n{text}").as_bytes()).map_err(unsaved)
    }
}

/// The first rows of `text`, as many as are parsed at once; `None` if there are none, or the first one is larger.
fn first_rows(text: &str) -> Option<&str> {
    if text.len() <= MOST_PARSED_BYTES {
        return Some(text).filter(|rest| !rest.is_empty());
    }
    let begins = |three: &[u8]| three == b"\n[[";
    let last = text.as_bytes()[..MOST_PARSED_BYTES].windows(3).rposition(begins)?;
    Some(&text[..=last])
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn row(id: &str, sequence: u64) -> Row {
        let text = |text: &str| text.to_owned();
        Row {
            id: text(id),
            flock: text("it's \"so\""),
            sequence,
            key: text("8A1F5C9E0D2B4371"),
            to: text("/media/stick"),
            published: text("2026-03-01T12:00:00Z"),
            place: None,
        }
    }

    #[test]
    fn a_table_reads_back_as_it_was_saved_and_places_stay() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(FILE_NAME);
        let mut fleet = Fleet::read(&path).unwrap();
        assert_eq!(fleet, Fleet::default());
        fleet.set(row("stairs", 1));
        fleet.set(Row { place: Some("Hotel Adler".into()), ..row("lobby", 2) });
        fleet.set(row("lobby", 3));
        fleet.save(&path).unwrap();
        let read = Fleet::read(&path).unwrap();
        assert_eq!(read, fleet);
        let rows: Vec<_> = read.rows.iter().map(|row| (&*row.id, row.sequence, row.place.as_deref())).collect();
        let last = |name| read.last_addressees(&UnitId::new(name).unwrap());
        assert_eq!((last("lobby"), last("attic")), (Some(Addressees::of([UnitId::new("lobby").unwrap()])), None));
        assert_eq!(rows, [("lobby", 3, Some("Hotel Adler")), ("stairs", 1, None)]);
        for bad in ["unit = 3", "[[unit]]\nid = \"lobby\"\n", "[[units]]\n"] {
            fs::write(&path, bad).unwrap();
            assert!(Fleet::read(&path).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_table_of_ten_thousand_units_reads_back_and_a_fault_in_it_is_named_by_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(FILE_NAME);
        let place = Some("Hotel Adler, by the stairs, where everybody comes by twice a day, and some stay".to_owned());
        let rows = (0..10_000).map(|at| Row { place: place.clone(), ..row(&format!("unit-{at:05}"), at) }).collect();
        let fleet = Fleet { rows };
        fleet.save(&path).unwrap();
        assert_eq!(Fleet::read(&path).unwrap(), fleet);
        let text = fs::read_to_string(&path).unwrap();
        let broken = text.replace("sequence = 9876\n", "sequences = 9876\n");
        let line = 1 + broken[..broken.find("sequences").unwrap()].matches('\n').count();
        fs::write(&path, broken).unwrap();
        let said = Fleet::read(&path).unwrap_err().in_words();
        assert!(said.contains(&format!("line {line}: unknown field `sequences`")), "{said}");
        fs::write(&path, format!("{text}[[unit]]\nid = \"{}\"\n", "a".repeat(MOST_PARSED_BYTES))).unwrap();
        let said = Fleet::read(&path).unwrap_err().in_words();
        assert!(said.contains(&format!("line {}: a row has at most", 1 + text.matches('\n').count())), "{said}");
    }
}
