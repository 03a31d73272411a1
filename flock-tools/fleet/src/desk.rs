//! Takes reports, and knows the newest of each unit.
//!
//! Owns which units may report, and how many: all that are named, or else any until there are as many as may be. A report
//! that is refused changes nothing. Never opens a socket: `server` does.
//!
//! Start at [`Desk::receive`].

use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use bundle::UnitId;

use crate::facts::{Facts, ReportError};
use crate::folder;
use crate::record::{Noted, Record, Records, UnitView, views};

/// What may come, and how long a unit may be silent.
#[derive(Clone, Debug)]
pub(crate) struct Rules {
    /// If there are any, only these units may report.
    pub(crate) named: Vec<UnitId>,
    /// The most units, if none are named.
    pub(crate) most: usize,
    pub(crate) silent_after_s: u64,
}

/// What happened since the start.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    pub(crate) taken: AtomicU64,
    pub(crate) refused: AtomicU64,
    pub(crate) alarms_sent: AtomicU64,
    pub(crate) alarms_failed: AtomicU64,
}

/// The newest reports, in memory and in their folder.
#[derive(Debug)]
pub(crate) struct Desk {
    folder: PathBuf,
    rules: Rules,
    records: Mutex<Records>,
    pub(crate) counts: Counts,
}

/// A report that is not taken.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Rejected {
    #[error("cannot keep the report")]
    Disk(#[source] io::Error),
    #[error("there are {most} units already: a new one must be named by --unit, or --most must be larger")]
    Many { most: usize },
    #[error(transparent)]
    Report(#[from] ReportError),
    #[error("the unit `{}` is not one that was named by --unit", .unit.as_str())]
    Unknown { unit: UnitId },
}

impl Desk {
    /// The desk of `folder`, which has these reports.
    pub(crate) fn new(folder: PathBuf, rules: Rules, records: Records) -> Self {
        Self { folder, rules, records: Mutex::new(records), counts: Counts::default() }
    }

    /// Takes the report in `bytes`, which came at `now_s` since 1970.
    /// Errors: [`Rejected`]; nothing is changed then.
    pub(crate) fn receive(&self, bytes: &[u8], now_s: u64) -> Result<(), Rejected> {
        let taken = self.take(bytes, now_s);
        let count = if taken.is_ok() { &self.counts.taken } else { &self.counts.refused };
        count.fetch_add(1, Ordering::Relaxed);
        taken
    }

    fn take(&self, bytes: &[u8], now_s: u64) -> Result<(), Rejected> {
        let (facts, document) = Facts::parse(bytes)?;
        let mut records = self.records();
        self.admit(&facts.unit, &records)?;
        let noted = Noted::after(records.get(&facts.unit), &facts, now_s);
        let kept = folder::kept(document, &noted)?;
        folder::save(&self.folder, &facts, &kept).map_err(Rejected::Disk)?;
        records.insert(facts.unit.clone(), Record { facts, noted });
        Ok(())
    }

    fn admit(&self, unit: &UnitId, records: &Records) -> Result<(), Rejected> {
        let Rules { named, most, .. } = &self.rules;
        if !named.is_empty() {
            let unknown = || Rejected::Unknown { unit: unit.clone() };
            return named.contains(unit).then_some(()).ok_or_else(unknown);
        }
        let is_full = records.len() >= *most && !records.contains_key(unit);
        if is_full { Err(Rejected::Many { most: *most }) } else { Ok(()) }
    }

    /// What is shown of all units at `now_s`.
    pub(crate) fn views(&self, now_s: u64) -> Vec<UnitView> {
        views(&self.records(), &self.rules.named, now_s, self.rules.silent_after_s)
    }

    /// The picture of the unit with this name.
    pub(crate) fn picture(&self, unit: &str) -> Option<Vec<u8>> {
        self.records().get(&UnitId::new(unit).ok()?)?.facts.picture.clone()
    }

    /// Nothing that may fail changes them halfway: they are whole whatever became of a thread that held them.
    fn records(&self) -> MutexGuard<'_, Records> {
        self.records.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn desk(named: &[&str], most: usize) -> (tempfile::TempDir, Desk) {
        let folder = tempfile::tempdir().unwrap();
        let named = named.iter().map(|name| UnitId::new(name).unwrap()).collect();
        let desk = Desk::new(folder.path().to_owned(), Rules { named, most, silent_after_s: 60 }, Records::new());
        (folder, desk)
    }

    fn said(desk: &Desk, unit: &str) -> Result<(), String> {
        let report = format!("{{\"unit\": \"{unit}\", \"status\": {{}}}}");
        desk.receive(report.as_bytes(), 100).map_err(|error| error.to_string())
    }

    #[test]
    fn only_named_units_report_or_as_many_as_may_be() {
        let (folder, open) = desk(&[], 2);
        assert_eq!((said(&open, "a"), said(&open, "b"), said(&open, "a")), (Ok(()), Ok(()), Ok(())));
        assert!(said(&open, "c").unwrap_err().contains("2 units already"));
        assert_eq!(open.views(100).len(), 2);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing is left of what was refused");
        let (_folder, closed) = desk(&["a", "b"], 1);
        assert_eq!((said(&closed, "a"), said(&closed, "b")), (Ok(()), Ok(())));
        assert!(said(&closed, "c").unwrap_err().contains("`c`"));
        let counts = [&closed.counts.taken, &closed.counts.refused].map(|count| count.load(Ordering::Relaxed));
        assert_eq!(counts, [2, 1]);
    }

    #[test]
    fn a_report_that_cannot_be_kept_is_refused() {
        let (folder, desk) = desk(&[], 2);
        drop(folder);
        assert_eq!(said(&desk, "a"), Err("cannot keep the report".to_owned()));
        assert!(desk.views(100).is_empty());
    }
}
