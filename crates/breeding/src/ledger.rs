//! The file of all that happened in a pool.
//!
//! Owns its form: one event a line, in JSON, appended and never changed. After a cut in the middle of a write the last line
//! may be torn: it has no line feed, was never told to anybody, and is dropped; every other line that is not understood is
//! refused. Members of events that this version does not know stay in the file, and in what is merged from it. Never knows
//! what events mean: [`crate::Pool`] does.
//!
//! Start at [`Ledger::read`].

use std::collections::BTreeMap;
use std::io;

use durable::Storage;

use crate::error::BreedingError;
use crate::event::{Day, Entry, Event, Stamp};
use crate::id::Origin;

/// The name of the file.
pub const LEDGER: &str = "ledger.jsonl";

/// The largest ledger that is read: some ten million births.
const MOST_BYTES: u64 = 4 << 30;

/// All that happened.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    /// In the order of their stamps; with the line of each.
    entries: BTreeMap<Stamp, (Entry, String)>,
}

impl Ledger {
    /// The ledger in a folder; an empty one if there is none.
    ///
    /// # Errors
    /// [`BreedingError::BadEvent`] with the line; [`BreedingError::Clash`]; [`BreedingError::Io`].
    pub fn read(folder: &dyn Storage) -> Result<Ledger, BreedingError> {
        let bytes = stored(folder)?;
        let mut ledger = Ledger::default();
        let lines = whole_lines(&bytes).strip_suffix(b"\n").map(|whole| whole.split(|byte| *byte == b'\n'));
        for (number, line) in lines.into_iter().flatten().enumerate() {
            let bad = |reason: String| BreedingError::BadEvent { file: LEDGER.to_owned(), line: number + 1, reason };
            let text = str::from_utf8(line).map_err(|error| bad(error.to_string()))?;
            let entry: Entry = serde_json::from_str(text).map_err(|error| bad(error.to_string()))?;
            ledger.insert(entry, text)?;
        }
        Ok(ledger)
    }

    /// The events, none before one that it depends on.
    pub fn entries(&self) -> impl Iterator<Item = &Entry> {
        self.entries.values().map(|(entry, _)| entry)
    }

    /// These events with the stamps that they will have in this ledger, when they happen on `day` in the pool `origin`. No
    /// event is of an earlier day than one before it, whatever the clock says.
    pub fn stamped(&self, origin: Origin, day: Day, events: Vec<Event>) -> Vec<Entry> {
        let next = self.entries.keys().next_back().map_or(0, |stamp| stamp.number + 1);
        let day = self.entries().map(|entry| entry.day).max().map_or(day, |last| last.max(day));
        let stamped = |(number, event)| Entry { stamp: Stamp { number, pool: origin }, day, event };
        (next..).zip(events).map(stamped).collect()
    }

    /// Adds events, to the file too; returns when the disk has them.
    ///
    /// # Errors
    /// [`BreedingError::Io`]; the file has none, some or all of them then, each whole or to be dropped.
    pub fn append(&mut self, folder: &dyn Storage, entries: Vec<Entry>) -> Result<(), BreedingError> {
        let lines = entries.into_iter().map(|entry| (line(&entry), entry)).map(|(line, entry)| (entry, line));
        self.append_lines(folder, lines.collect())
    }

    /// Adds all events of `other` that are not here, to the file too.
    ///
    /// # Errors
    /// [`BreedingError::Clash`], and nothing is changed; [`BreedingError::Io`].
    pub fn merge(&mut self, folder: &dyn Storage, other: &Ledger) -> Result<(), BreedingError> {
        let new = self.missing(other)?;
        self.append_lines(folder, new)
    }

    /// The events of `other` that are not here, with their lines.
    ///
    /// # Errors
    /// [`BreedingError::Clash`] if one is here and is another.
    pub fn missing(&self, other: &Ledger) -> Result<Vec<(Entry, String)>, BreedingError> {
        let mut new = Vec::new();
        for (stamp, (entry, line)) in &other.entries {
            match self.entries.get(stamp) {
                None => new.push((entry.clone(), line.clone())),
                Some((same, _)) if same == entry => {}
                Some(_) => return Err(BreedingError::Clash { stamp: *stamp }),
            }
        }
        Ok(new)
    }

    fn append_lines(&mut self, folder: &dyn Storage, new: Vec<(Entry, String)>) -> Result<(), BreedingError> {
        if new.is_empty() {
            return Ok(());
        }
        cut_torn_tail(folder)?;
        let text: String = new.iter().flat_map(|(_, line)| [line, "\n"]).collect();
        let write = || {
            let mut file = folder.append(LEDGER)?;
            file.write_all(text.as_bytes())?;
            file.sync()?;
            folder.sync_folder("")
        };
        write().map_err(failed("write"))?;
        new.into_iter().try_for_each(|(entry, line)| self.insert(entry, &line))
    }

    fn insert(&mut self, entry: Entry, line: &str) -> Result<(), BreedingError> {
        let stamp = entry.stamp;
        match self.entries.get(&stamp) {
            Some((same, _)) if *same == entry => Ok(()),
            Some(_) => Err(BreedingError::Clash { stamp }),
            None => {
                self.entries.insert(stamp, (entry, line.to_owned()));
                Ok(())
            }
        }
    }
}

fn line(entry: &Entry) -> String {
    serde_json::to_string(entry).expect("every event can be written as JSON")
}

fn stored(folder: &dyn Storage) -> Result<Vec<u8>, BreedingError> {
    match folder.read(LEDGER, MOST_BYTES) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        read => read.map_err(failed("read")),
    }
}

/// All up to the last line feed.
fn whole_lines(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
    &bytes[..end]
}

/// Takes away what a cut left behind the last line feed: the next event would be written into the same line.
fn cut_torn_tail(folder: &dyn Storage) -> Result<(), BreedingError> {
    let bytes = stored(folder)?;
    let whole = whole_lines(&bytes);
    if whole.len() < bytes.len() {
        durable::replace(folder, LEDGER, whole).map_err(failed("cut the torn last line of"))?;
    }
    Ok(())
}

fn failed(action: &'static str) -> impl Fn(io::Error) -> BreedingError {
    move |source| BreedingError::Io { action, path: LEDGER.to_owned(), source }
}
