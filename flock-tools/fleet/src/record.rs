//! The newest report of a unit with its times, and what is shown of it.
//!
//! Owns since when a unit has its flock and its system, and since when something is wrong with it. Pure rules: time comes
//! in as an argument, in seconds since 1970.
//!
//! Start at [`Noted::after`] and [`UnitView::of`].

use std::collections::BTreeMap;
use std::time::{Duration, SystemTime};

use bundle::UnitId;
use serde::{Deserialize, Serialize};

use crate::facts::{Disk, Facts};
use crate::finding::{Finding, Kind, findings, never_reported, remarks};

/// The last second that has four digits of year.
const LAST_S: u64 = 253_402_300_799;

/// What is noted beside a report: the key `fleet` of a kept one. Times are in seconds since 1970.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
#[expect(clippy::struct_field_names, reason = "the unit comes last in a name")]
pub(crate) struct Noted {
    /// When the report came.
    pub(crate) arrived_s: u64,
    /// When the first report came that had this flock with this number, and this system.
    pub(crate) flock_since_s: u64,
    pub(crate) system_since_s: u64,
    /// When the first report came of those in a row with which something was wrong, by its kind.
    pub(crate) wrong_since_s: BTreeMap<String, u64>,
}

/// The newest report of a unit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Record {
    pub(crate) facts: Facts,
    pub(crate) noted: Noted,
}

/// The newest report of each unit.
pub(crate) type Records = BTreeMap<UnitId, Record>;

impl Noted {
    /// The notes on the report with `facts` that came at `now_s` after the one in `before`.
    pub(crate) fn after(before: Option<&Record>, facts: &Facts, now_s: u64) -> Self {
        let kept = |is_same: fn(&Facts, &Facts) -> bool, since: fn(&Self) -> u64| {
            before
                .filter(|before| is_same(&before.facts, facts))
                .map_or(now_s, |before| since(&before.noted).min(now_s))
        };
        let was_wrong = |kind: Kind| before.and_then(|before| before.noted.wrong_since_s.get(kind.name()).copied());
        let wrong = findings(facts, 0, u64::MAX).into_iter().map(|finding| finding.kind);
        Self {
            arrived_s: now_s,
            flock_since_s: kept(
                |one, other| (&one.flock, one.sequence) == (&other.flock, other.sequence),
                |noted| noted.flock_since_s,
            ),
            system_since_s: kept(|one, other| one.machine.system == other.machine.system, |noted| noted.system_since_s),
            wrong_since_s: wrong
                .map(|kind| (kind.name().to_owned(), was_wrong(kind).unwrap_or(now_s).min(now_s)))
                .collect(),
        }
    }
}

/// What is shown of a unit, at one moment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct UnitView {
    pub(crate) unit: String,
    pub(crate) ok: bool,
    pub(crate) wrong: Vec<WrongView>,
    /// What is worth a look and not wrong.
    pub(crate) remarks: Vec<String>,
    /// When its last report came, and how many seconds ago; `None` if none ever came.
    pub(crate) last_seen: Option<String>,
    pub(crate) age_s: Option<u64>,
    pub(crate) flock: Option<String>,
    pub(crate) sequence: Option<u64>,
    pub(crate) flock_since: Option<String>,
    pub(crate) system: Option<String>,
    pub(crate) system_since: Option<String>,
    pub(crate) slot: Option<String>,
    pub(crate) programs: Option<String>,
    pub(crate) address: Option<String>,
    pub(crate) uptime_s: Option<u64>,
    pub(crate) temperature_c: Option<f64>,
    pub(crate) disk: Option<Disk>,
    pub(crate) late: Option<u64>,
    pub(crate) faults: Option<u64>,
    pub(crate) has_picture: bool,
    /// How many seconds ago the flock came.
    #[serde(skip)]
    pub(crate) flock_age_s: Option<u64>,
    #[serde(skip)]
    pub(crate) arrived_s: Option<u64>,
}

/// Something wrong, as it is shown.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct WrongView {
    pub(crate) kind: &'static str,
    /// Since when it is known; `None` for a unit that has never reported.
    pub(crate) since: Option<String>,
    pub(crate) what: String,
    pub(crate) advice: &'static str,
}

impl UnitView {
    /// What is shown of `record` at `now_s`, if its unit may be silent for `silent_after_s`.
    pub(crate) fn of(record: &Record, now_s: u64, silent_after_s: u64) -> Self {
        let Record { facts, noted } = record;
        let age_s = now_s.saturating_sub(noted.arrived_s);
        let since = |kind: Kind| {
            let noted_s = noted.wrong_since_s.get(kind.name()).copied();
            if kind == Kind::Silent { Some(noted.arrived_s.saturating_add(silent_after_s)) } else { noted_s }
        };
        let wrong = findings(facts, age_s, silent_after_s).into_iter();
        let wrong: Vec<_> = wrong.map(|found| WrongView::of(found, since)).collect();
        let machine = &facts.machine;
        let player = facts.player.as_ref();
        let has_flock = facts.flock.is_some();
        Self {
            ok: wrong.is_empty(),
            wrong,
            remarks: remarks(facts),
            last_seen: Some(date(noted.arrived_s)),
            age_s: Some(age_s),
            flock: facts.flock.clone(),
            sequence: facts.sequence,
            flock_since: has_flock.then(|| date(noted.flock_since_s)),
            system: machine.system.clone(),
            system_since: machine.system.as_ref().map(|_| date(noted.system_since_s)),
            slot: machine.slot.clone(),
            programs: machine.programs.clone(),
            address: machine.address.clone(),
            uptime_s: machine.uptime_s,
            temperature_c: machine.temperature_c,
            disk: machine.disk,
            late: player.and_then(|player| player.late),
            faults: player.and_then(|player| player.faults),
            has_picture: facts.picture.is_some(),
            flock_age_s: has_flock.then(|| now_s.saturating_sub(noted.flock_since_s)),
            arrived_s: Some(noted.arrived_s),
            ..Self::never(&facts.unit)
        }
    }

    /// What is shown of `unit`, which has never reported.
    fn never(unit: &UnitId) -> Self {
        Self {
            unit: unit.as_str().to_owned(),
            ok: false,
            wrong: never_reported().into_iter().map(|found| WrongView::of(found, |_| None)).collect(),
            remarks: Vec::new(),
            last_seen: None,
            age_s: None,
            flock: None,
            sequence: None,
            flock_since: None,
            system: None,
            system_since: None,
            slot: None,
            programs: None,
            address: None,
            uptime_s: None,
            temperature_c: None,
            disk: None,
            late: None,
            faults: None,
            has_picture: false,
            flock_age_s: None,
            arrived_s: None,
        }
    }
}

impl WrongView {
    fn of(found: Finding, since: impl Fn(Kind) -> Option<u64>) -> Self {
        let Finding { kind, what } = found;
        Self { kind: kind.name(), since: since(kind).map(date), what, advice: kind.advice() }
    }
}

/// What is shown of all units at `now_s`: those of `records`, and those of `named` that have never reported. Those with
/// which something is wrong come first, each part by name.
pub(crate) fn views(records: &Records, named: &[UnitId], now_s: u64, silent_after_s: u64) -> Vec<UnitView> {
    let missing = named.iter().filter(|unit| !records.contains_key(*unit)).map(UnitView::never);
    let seen = records.values().map(|record| UnitView::of(record, now_s, silent_after_s));
    let mut all: Vec<_> = seen.chain(missing).collect();
    all.sort_by(|one, other| (one.ok, &one.unit).cmp(&(other.ok, &other.unit)));
    all.dedup_by(|one, other| one.unit == other.unit);
    all
}

/// A time as `2026-03-01T12:00:00Z`.
pub(crate) fn date(s: u64) -> String {
    humantime::format_rfc3339_seconds(SystemTime::UNIX_EPOCH + Duration::from_secs(s.min(LAST_S))).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn facts(report: &Value) -> Facts {
        Facts::parse(report.to_string().as_bytes()).unwrap().0
    }

    /// A report with this flock, number and system, which ends with an error or not.
    fn report(flock: &str, sequence: u64, system: &str, error: Option<&str>) -> Facts {
        facts(&json!({"unit": "lobby", "status": {"flock": flock, "generation": {"sequence": sequence}},
            "error": error, "machine": {"system": system}}))
    }

    #[test]
    fn since_when_is_the_first_report_in_a_row_that_says_the_same() {
        // Each report with the time at which it comes, and since when flock, system and error are then.
        let table = [
            (report("aurora", 1, "1.0", None), 100, (100, 100, None)),
            (report("aurora", 1, "1.0", Some("a")), 200, (100, 100, Some(200))),
            (report("aurora", 2, "1.0", Some("b")), 300, (300, 100, Some(200))),
            (report("dawn", 2, "1.1", None), 400, (400, 400, None)),
            (report("dawn", 2, "1.1", Some("a")), 500, (400, 400, Some(500))),
            // The clock was set back.
            (report("dawn", 2, "1.1", Some("a")), 50, (50, 50, Some(50))),
        ];
        let mut before: Option<Record> = None;
        for (facts, now_s, expected) in table {
            let noted = Noted::after(before.as_ref(), &facts, now_s);
            let error = noted.wrong_since_s.get("update-failed").copied();
            assert_eq!((noted.flock_since_s, noted.system_since_s, error), expected, "at {now_s}");
            assert_eq!(noted.arrived_s, now_s);
            before = Some(Record { facts, noted });
        }
    }

    #[test]
    fn wrong_units_come_first_and_named_ones_are_not_forgotten() {
        let record = |unit: &str, error: Option<&str>| {
            let facts = facts(&json!({"unit": unit, "status": {}, "error": error}));
            let noted = Noted::after(None, &facts, 1_000);
            (facts.unit.clone(), Record { facts, noted })
        };
        let records = Records::from([record("a", None), record("b", Some("x")), record("c", None)]);
        let named = ["a", "z", "z"].map(|name| UnitId::new(name).unwrap());
        let shown = views(&records, &named, 1_060, 3_600);
        let order: Vec<_> = shown.iter().map(|view| (view.unit.as_str(), view.ok)).collect();
        assert_eq!(order, [("b", false), ("z", false), ("a", true), ("c", true)]);
        assert_eq!(shown[0].wrong[0].since.as_deref(), Some("1970-01-01T00:16:40Z"));
        assert_eq!((shown[1].last_seen.as_deref(), shown[1].wrong[0].kind), (None, "silent"));
        let later = views(&records, &[], 1_000 + 3_601, 3_600);
        assert!(later.iter().all(|view| !view.ok && view.wrong[0].since.as_deref() == Some("1970-01-01T01:16:40Z")));
        let before = views(&records, &[], 10, 3_600);
        assert_eq!(before[1].age_s, Some(0), "a clock that was set back makes nobody silent");
    }
}
