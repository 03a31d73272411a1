//! The units as lines of text.
//!
//! Owns the table for a terminal: a row for each unit, and below it what is wrong, with what to do.
//!
//! Start at [`lines`].

use crate::finding::span;
use crate::record::UnitView;

/// The heads of the columns.
const HEADS: [&str; 6] = ["unit", "state", "hangs there", "since", "system", "last seen"];

/// The table of `views`.
pub(crate) fn lines(views: &[UnitView]) -> Vec<String> {
    let rows: Vec<[String; 6]> = views.iter().map(cells).collect();
    let mut widths = HEADS.map(str::len);
    for (width, cell) in rows.iter().flat_map(|row| (0..).zip(row)) {
        widths[width] = widths[width].max(cell.chars().count());
    }
    let line = |cells: [&str; 6]| {
        let padded = cells.iter().zip(widths).map(|(cell, width)| format!("{cell:<width$}"));
        padded.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    let mut lines = vec![line(HEADS)];
    for (view, row) in views.iter().zip(&rows) {
        lines.push(line(row.each_ref().map(String::as_str)));
        lines.extend(view.wrong.iter().map(|wrong| format!("  {}: {} {}", wrong.kind, wrong.what, wrong.advice)));
        lines.extend(view.remarks.iter().map(|remark| format!("  note: {remark}")));
    }
    lines
}

/// The cells of a unit's row.
fn cells(view: &UnitView) -> [String; 6] {
    let ago = |age_s: Option<u64>| age_s.map_or_else(|| "never".to_owned(), |age_s| format!("{} ago", span(age_s)));
    let none = || "-".to_owned();
    [
        view.unit.clone(),
        if view.ok { "fine" } else { "wrong" }.to_owned(),
        hanging(view).unwrap_or_else(none),
        view.flock_age_s.map_or_else(none, |age_s| format!("{} ago", span(age_s))),
        view.system.clone().unwrap_or_else(none),
        ago(view.age_s),
    ]
}

/// The flock on the wall with its number: `aurora 7`.
fn hanging(view: &UnitView) -> Option<String> {
    let flock = view.flock.as_ref()?;
    Some(view.sequence.map_or_else(|| flock.clone(), |sequence| format!("{flock} {sequence}")))
}

#[cfg(test)]
mod tests {
    use super::lines;
    use crate::facts::Facts;
    use crate::record::{Noted, Record, Records, views};
    use bundle::UnitId;

    #[test]
    fn a_row_has_what_hangs_there_and_below_it_what_is_wrong() {
        let report = br#"{"unit": "attic", "error": "no route", "machine": {"system": "1.2", "time_known": false},
            "status": {"flock": "aurora", "generation": {"sequence": 7}, "screen": {}}}"#;
        let facts = Facts::parse(report).unwrap().0;
        let noted = Noted::after(None, &facts, 1_000);
        let records = Records::from([(facts.unit.clone(), Record { facts, noted })]);
        let said = lines(&views(&records, &[UnitId::new("lobby").unwrap()], 1_120, 3_600)).join("\n");
        let expected = "\
unit   state  hangs there  since          system  last seen
attic  wrong  aurora 7     2 minutes ago  1.2     2 minutes ago
  update-failed: Its last look for updates failed: no route. If it is still so after the next look, check the unit's \
network, and `url` in its `dreams.toml`.
  note: It does not know the time.
lobby  wrong  -            -              -       never
  silent: It has never reported. Check that the unit has power and a network, and that `report_to` in its `dreams.toml` \
is the address of this page.";
        assert_eq!(said, expected);
    }
}
