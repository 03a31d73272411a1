//! The folder of reports.
//!
//! Owns the file of each unit, `UNIT.json`: the newest report as it came, with the key `fleet` besides, which has the
//! times. `dreams votes` reads the same files. Reports that something else put there are read, too, under any name that ends
//! in `.json`: they came when their file was written. A name of a file is made only of a unit's name that was checked.
//!
//! Start at [`read`] and [`save`].

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use durable::Locked;
use operations::program::{Exit, Fatal, print};
use serde_json::{Map, Value};

use crate::facts::{Facts, MOST_BYTES, ReportError};
use crate::record::{Noted, Record, Records};

/// The most units, and the most reports that are read.
pub(crate) const MOST_UNITS: usize = 1_000;
/// The most bytes of a kept report besides those of the report.
const MOST_NOTED_BYTES: usize = 4 << 10;
/// What keeps two servers from the same folder.
const LOCK: &str = "lock";

/// A file that is no report.
#[derive(Debug, serde::Serialize)]
pub(crate) struct Refused {
    file: String,
    why: String,
}

impl Refused {
    /// Which file, and why, in one line.
    pub(crate) fn line(&self) -> String {
        format!("`{}`: {}", self.file, self.why)
    }
}

#[derive(Debug, thiserror::Error)]
enum FolderError {
    #[error("`{path}` has more than {MOST_UNITS} reports")]
    Many { path: PathBuf },
    #[error("another `dreams fleet` works with `{path}`")]
    Taken { path: PathBuf },
}

/// The newest report of each unit in the folder, and the files that are none.
/// Errors: If the folder cannot be read, or has too many.
pub(crate) fn read(folder: &Path) -> Result<(Records, Vec<Refused>), Fatal> {
    let unread = |source| Fatal::read(folder, source);
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(unread)? {
        let path = entry.map_err(unread)?.path();
        if path.extension().is_some_and(|ending| ending == "json") {
            files.push(path);
        }
        if files.len() > MOST_UNITS {
            return Err(Fatal::new(Exit::Malformed, FolderError::Many { path: folder.to_owned() }));
        }
    }
    files.sort();
    let (mut records, mut refused) = (Records::new(), Vec::new());
    for file in files {
        match read_one(&file) {
            Ok(record) => {
                let unit = record.facts.unit.clone();
                let is_newer = |known: &Record| known.noted.arrived_s <= record.noted.arrived_s;
                if records.get(&unit).is_none_or(is_newer) {
                    records.insert(unit, record);
                }
            }
            Err(why) => refused.push(Refused { file: print::path(&file), why }),
        }
    }
    Ok((records, refused))
}

fn read_one(file: &Path) -> Result<Record, String> {
    let most = (MOST_BYTES + MOST_NOTED_BYTES) as u64;
    let bytes = durable::read_plain(file, most).map_err(|error| error.to_string())?;
    let (facts, document) = Facts::parse(&bytes).map_err(|error| print::visible(&error.to_string()).into_owned())?;
    let noted = document.get("fleet").and_then(|noted| serde_json::from_value(noted.clone()).ok());
    let noted = noted.unwrap_or_else(|| Noted::after(None, &facts, written_s(file)));
    Ok(Record { facts, noted })
}

/// When the file was written, in seconds since 1970.
fn written_s(file: &Path) -> u64 {
    let written = fs::metadata(file).and_then(|of| of.modified()).unwrap_or(SystemTime::UNIX_EPOCH);
    written.duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_secs()
}

/// The bytes of the file that keeps `document` with its notes.
/// Errors: [`ReportError::Long`], if they are too many.
pub(crate) fn kept(mut document: Map<String, Value>, noted: &Noted) -> Result<Vec<u8>, ReportError> {
    let noted = serde_json::to_value(noted).expect("names and numbers are JSON");
    document.insert("fleet".to_owned(), noted);
    let bytes = serde_json::to_vec(&document).expect("what was read as JSON is JSON");
    if bytes.len() > MOST_BYTES + MOST_NOTED_BYTES / 2 { Err(ReportError::Long) } else { Ok(bytes) }
}

/// Keeps the report of `facts`, as [`kept`] gave its `bytes`.
/// Errors: What the disk says; the one before is still there.
pub(crate) fn save(folder: &Path, facts: &Facts, bytes: &[u8]) -> io::Result<()> {
    durable::write_with_mode(&folder.join(format!("{}.json", facts.unit.as_str())), bytes, 0o600)
}

/// Takes the folder for this process alone; makes it if it is not there.
/// Errors: If another process has it, or the disk refuses.
pub(crate) fn take(folder: &Path) -> Result<Locked, Fatal> {
    fs::create_dir_all(folder).map_err(|source| Fatal::write(folder, source))?;
    let path = folder.join(LOCK);
    let opened = File::options().create(true).truncate(false).write(true).open(&path);
    let file = opened.map_err(|source| Fatal::write(&path, source))?;
    match file.try_lock() {
        Ok(()) => Ok(Locked::new(file)),
        Err(fs::TryLockError::WouldBlock) => {
            let taken = Fatal::new(Exit::No, FolderError::Taken { path: folder.to_owned() });
            Err(taken.hint("end the other one, or use the page that it shows"))
        }
        Err(fs::TryLockError::Error(source)) => Err(Fatal::write(&path, source)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> (Facts, Map<String, Value>) {
        Facts::parse(text.as_bytes()).unwrap()
    }

    #[test]
    fn a_kept_report_comes_back_with_its_times_whatever_it_said_of_them() {
        let folder = tempfile::tempdir().unwrap();
        let (facts, document) = parsed("{\"unit\": \"lobby\", \"fleet\": {\"arrived_s\": 1}, \"votes\": {\"a\": 1}}");
        let noted = Noted::after(None, &facts, 4_000);
        save(folder.path(), &facts, &kept(document, &noted).unwrap()).unwrap();
        let (records, refused) = read(folder.path()).unwrap();
        assert!(refused.is_empty());
        assert_eq!(records.into_values().collect::<Vec<_>>(), [Record { facts, noted }]);
        let text = fs::read_to_string(folder.path().join("lobby.json")).unwrap();
        assert!(text.contains("\"votes\":{\"a\":1}"), "{text}");
    }

    #[test]
    fn the_newest_of_two_reports_of_a_unit_counts_and_what_is_no_report_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        write("a.json", "{\"unit\": \"lobby\", \"error\": \"new\", \"fleet\": {\"arrived_s\": 9}}");
        write("b.json", "{\"unit\": \"lobby\", \"error\": \"old\", \"fleet\": {\"arrived_s\": 8}}");
        write("c.json", "{\"unit\": \"attic\"}");
        write("d.json", "{}");
        write("e.json", &" ".repeat(MOST_BYTES * 2));
        write("f.txt", "notes");
        fs::create_dir(folder.path().join("g.json")).unwrap();
        let (records, refused) = read(folder.path()).unwrap();
        let said: Vec<_> = records.values().map(|record| record.facts.error.as_deref()).collect();
        assert_eq!(said, [None, Some("new")]);
        let attic = &records.values().next().unwrap().noted;
        assert!(attic.arrived_s > 1_700_000_000 && attic.flock_since_s == attic.arrived_s, "{attic:?}");
        let lines: Vec<_> = refused.iter().map(Refused::line).collect();
        assert!(lines.len() == 3 && lines[0].contains("`unit`") && lines[1].contains("larger"), "{lines:?}");
    }

    #[test]
    fn a_folder_is_taken_once() {
        let folder = tempfile::tempdir().unwrap();
        let held = take(folder.path()).unwrap();
        assert!(take(folder.path()).unwrap_err().in_words().contains("another"));
        drop(held);
        take(folder.path()).unwrap();
    }
}
