//! The file that keeps what was done, over a restart and a kill.
//!
//! Owns its form: entries one after the other, each with a checksum, the first one with the whole state before the others.
//! An entry is written before what it says is done; so at most the last one may say what was not done, which
//! [`Journal::open`] finds out by the text of the manifest. What is torn at the end is dropped.
//!
//! Start at [`Journal::open`], then [`Journal::write`].

use std::io;
use std::path::Path;

use super::disk::Disk;
use super::history::{History, Record};
use super::notes::Notes;

/// Names the kind of file and its version.
const MAGIC: [u8; 8] = *b"d-undo\x00\x01";
/// The bytes of an entry beside the entry itself.
const FRAME: usize = 8 + 8 + 4 + 4;
/// The journal is written anew, without what is no longer of use, when it has so many entries, or bytes.
const MOST_RECORDS: u64 = 4_000;
const MOST_BYTES: usize = 128 << 20;

/// The journal and the state that it leads to.
pub(super) struct Journal {
    history: History,
    disk: Box<dyn Disk>,
    records: u64,
    bytes: usize,
    /// Whether the file is as it should be: not after a write that failed.
    is_whole: bool,
}

/// Whether the last entry says what was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Last {
    Done,
    NotDone,
}

impl Journal {
    /// Reads the journal at `path`, or begins one at the manifest `text`. `last` is given the state before the last entry
    /// and with it, and says whether what the entry says was done.
    /// Errors: What the disk says.
    pub(super) fn open(
        path: &Path,
        disk: Box<dyn Disk>,
        text: &str,
        last: impl FnOnce(&History, &History) -> Last,
    ) -> io::Result<Self> {
        let bytes = match std::fs::read(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
            read => read?,
        };
        let (records, whole) = records(&bytes);
        let count = records.len() as u64;
        let (history, is_whole) = if let Some((history, is_done)) = replayed(records, last) {
            (history, is_done == Last::Done && whole == bytes.len())
        } else {
            if !bytes.is_empty() {
                // The notes in it may be of use to somebody.
                std::fs::rename(path, path.with_extension("unreadable"))?;
            }
            (History::new(text, Notes::default()), false)
        };
        let mut journal = Self { history, disk, records: count, bytes: whole, is_whole };
        if !journal.is_whole {
            journal.write_anew()?;
        }
        Ok(journal)
    }

    /// What was done.
    pub(super) fn history(&self) -> &History {
        &self.history
    }

    /// The disk, for the files that an entry speaks of.
    pub(super) fn disk(&self) -> &dyn Disk {
        &*self.disk
    }

    /// Writes an entry and takes it. Then `act` does what it says; if that fails, the entry is taken out again.
    /// Errors: What the disk says; nothing was done then.
    ///
    /// # Panics
    /// If the entry does not fit what was done, which is a bug.
    pub(super) fn write<E: From<io::Error>>(
        &mut self,
        record: Record,
        act: impl FnOnce(&dyn Disk, &History) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut history = self.history.clone();
        if !self.is_whole || self.records >= MOST_RECORDS || self.bytes > MOST_BYTES {
            self.write_anew()?;
        }
        let bytes = framed(self.records, &record)?;
        history.take(record).expect("an entry is made for the state as it is");
        // Until all is done, the file may hold a part of the entry, or an entry that is not true.
        self.is_whole = false;
        self.disk.append(&bytes)?;
        if let Err(error) = act(&*self.disk, &history) {
            // If this fails, too, the next entry or the next start makes up for it.
            let _ = self.write_anew();
            return Err(error);
        }
        self.is_whole = true;
        (self.records, self.bytes, self.history) = (self.records + 1, self.bytes + bytes.len(), history);
        Ok(())
    }

    fn write_anew(&mut self) -> io::Result<()> {
        let records = self.history.records();
        let framed: Vec<Vec<u8>> =
            records.iter().enumerate().map(|(at, record)| framed(at as u64, record)).collect::<io::Result<_>>()?;
        let bytes = framed.concat();
        self.disk.replace(&bytes)?;
        (self.records, self.bytes, self.is_whole) = (records.len() as u64, bytes.len(), true);
        Ok(())
    }
}

fn framed(number: u64, record: &Record) -> io::Result<Vec<u8>> {
    durable::framed(MAGIC, number, &postcard::to_allocvec(record).map_err(io::Error::other)?)
}

/// The entries in `bytes`, and how many bytes they take.
fn records(bytes: &[u8]) -> (Vec<Record>, usize) {
    let (mut records, mut at) = (Vec::new(), 0);
    while let Some((length, record)) = first(&bytes[at..], records.len() as u64) {
        records.push(record);
        at += length;
    }
    (records, at)
}

/// The entry at the start of `bytes`, which has the `number`, and its length.
fn first(bytes: &[u8], number: u64) -> Option<(usize, Record)> {
    let length = bytes.get(16..20).map(|four| u32::from_le_bytes(four.try_into().expect("four bytes")) as usize)?;
    let end = length.checked_add(FRAME)?;
    let (found, state) = durable::unframed(MAGIC, bytes.get(..end)?)?;
    let record = postcard::from_bytes(state).ok().filter(|_| found == number)?;
    Some((end, record))
}

/// The state that `records` lead to, and whether the last one counts. `None` if they do not fit together.
fn replayed(mut records: Vec<Record>, last: impl FnOnce(&History, &History) -> Last) -> Option<(History, Last)> {
    let newest = if records.len() > 1 { records.pop() } else { None };
    let mut records = records.into_iter();
    let Some(Record::Base { text, notes }) = records.next() else { return None };
    let mut history = History::new(&text, notes);
    records.try_for_each(|record| history.take(record))?;
    let Some(newest) = newest else { return Some((history, Last::Done)) };
    let mut after = history.clone();
    after.take(newest)?;
    match last(&history, &after) {
        Last::Done => Some((after, Last::Done)),
        Last::NotDone => Some((history, Last::NotDone)),
    }
}

impl std::fmt::Debug for Journal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Journal").field("records", &self.records).finish_non_exhaustive()
    }
}
