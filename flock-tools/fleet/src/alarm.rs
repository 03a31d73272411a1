//! Which alarms are due.
//!
//! Owns what was sent last of each unit, and what must be sent next: one alarm when something becomes wrong, and one when
//! nothing is wrong any more. What began and ended before it could be sent is never sent. Pure rules: [`super::webhook`]
//! sends and saves.
//!
//! Start at [`Sent::due`].

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::record::{UnitView, WrongView};

/// What was sent last, of each unit.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Sent {
    units: BTreeMap<String, SentOfUnit>,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct SentOfUnit {
    /// The number of the last alarm.
    number: u64,
    /// What was wrong then, less what has ended.
    wrong: BTreeSet<String>,
}

/// An alarm, as it is sent.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Alarm {
    /// The same for each try to send it: a receiver can drop what it has already.
    pub(crate) id: String,
    pub(crate) unit: String,
    /// `wrong` or `right`.
    pub(crate) state: &'static str,
    /// The kinds that are wrong since the last alarm.
    pub(crate) began: Vec<&'static str>,
    /// All that is wrong.
    pub(crate) wrong: Vec<WrongView>,
    /// When the unit was last seen.
    pub(crate) last_seen: Option<String>,
    /// The same in one sentence, in the field that chat servers show.
    pub(crate) text: String,
    #[serde(skip)]
    number: u64,
}

impl Sent {
    /// Forgets what has ended where something else is still wrong, and the units that are gone; then what must be sent for
    /// `views`, by unit.
    pub(crate) fn due(&mut self, views: &[UnitView]) -> Vec<Alarm> {
        self.units.retain(|unit, _| views.iter().any(|view| view.unit == *unit));
        let mut due: Vec<_> = views.iter().filter_map(|view| self.due_of(view)).collect();
        due.sort_by(|one, other| one.unit.cmp(&other.unit));
        due
    }

    fn due_of(&mut self, view: &UnitView) -> Option<Alarm> {
        let before = self.units.get_mut(&view.unit);
        let number = before.as_ref().map_or(0, |before| before.number) + 1;
        let sent = before.as_ref().map(|before| before.wrong.clone()).unwrap_or_default();
        let kinds = || view.wrong.iter().map(|wrong| wrong.kind);
        let began: Vec<_> = kinds().filter(|kind| !sent.contains(*kind)).collect();
        if let Some(before) = before
            && !view.ok
        {
            before.wrong.retain(|kind| kinds().any(|wrong| wrong == kind));
        }
        if began.is_empty() && (!view.ok || sent.is_empty()) {
            return None;
        }
        let sentences: Vec<_> = view.wrong.iter().map(|wrong| format!("{} {}", wrong.what, wrong.advice)).collect();
        Some(Alarm {
            id: format!("{}-{number}", view.unit),
            unit: view.unit.clone(),
            state: if view.ok { "right" } else { "wrong" },
            text: match &sentences[..] {
                [] => format!("{}: everything is right again.", view.unit),
                all => format!("{}: {}", view.unit, all.join(" ")),
            },
            began,
            wrong: view.wrong.clone(),
            last_seen: view.last_seen.clone(),
            number,
        })
    }

    /// Notes that `alarm` was sent.
    pub(crate) fn note(&mut self, alarm: &Alarm) {
        let wrong = alarm.wrong.iter().map(|wrong| wrong.kind.to_owned()).collect();
        self.units.insert(alarm.unit.clone(), SentOfUnit { number: alarm.number, wrong });
    }
}

/// The seconds until the next try after so many failed ones in a row: 2, 4, 8 and so on, a quarter of an hour at most.
pub(crate) fn wait_s(failures: u32) -> u64 {
    2_u64.checked_pow(failures).unwrap_or(u64::MAX).min(15 * 60)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facts::Facts;
    use crate::record::{Noted, Record};
    use serde_json::json;

    /// A unit with which this is wrong.
    fn view(is_hot: bool, has_failed: bool) -> UnitView {
        let report = json!({"unit": "lobby", "status": {}, "error": has_failed.then_some("no route"),
            "machine": {"temperature_c": if is_hot { 90 } else { 40 }}});
        let facts = Facts::parse(report.to_string().as_bytes()).unwrap().0;
        let noted = Noted::after(None, &facts, 100);
        UnitView::of(&Record { facts, noted }, 100, 1_000)
    }

    #[test]
    fn one_alarm_is_due_when_something_becomes_wrong_and_one_when_all_is_right() {
        // What is wrong, whether sending works, and the alarm that is due: its id, and what began.
        type Due = Option<(&'static str, &'static str, &'static [&'static str])>;
        let table: [(bool, bool, bool, Due); 11] = [
            (false, false, true, None),
            (true, false, false, Some(("lobby-1", "wrong", &["hot"]))),
            (true, false, true, Some(("lobby-1", "wrong", &["hot"]))),
            (true, false, true, None),
            (true, true, true, Some(("lobby-2", "wrong", &["update-failed"]))),
            // One thing ends while another is wrong: that is no alarm, but when it comes again it is one.
            (false, true, true, None),
            (true, true, true, Some(("lobby-3", "wrong", &["hot"]))),
            (false, false, false, Some(("lobby-4", "right", &[]))),
            // Wrong and as before again, before the receiver had heard that it was right.
            (true, true, true, None),
            (false, false, true, Some(("lobby-4", "right", &[]))),
            (false, false, true, None),
        ];
        let mut sent = Sent::default();
        for (step, (is_hot, has_failed, works, expected)) in table.into_iter().enumerate() {
            // As after a restart.
            sent = serde_json::from_str(&serde_json::to_string(&sent).unwrap()).unwrap();
            let due = sent.due(&[view(is_hot, has_failed)]);
            let found = due.first().map(|alarm| (alarm.id.as_str(), alarm.state, alarm.began.as_slice()));
            assert_eq!(found, expected, "step {step}");
            for alarm in due.iter().filter(|_| works) {
                sent.note(alarm);
            }
        }
    }

    #[test]
    fn an_alarm_says_in_words_what_is_wrong_and_what_to_do() {
        let due = Sent::default().due(&[view(true, false)]);
        let alarm = serde_json::to_value(&due[0]).unwrap();
        let text = alarm["text"].as_str().unwrap();
        assert!(text.starts_with("lobby: Its processor has 90 °C. Give the unit more air"), "{text}");
        assert_eq!((&alarm["state"], &alarm["wrong"][0]["kind"]), (&"wrong".into(), &"hot".into()));
    }

    #[test]
    fn tries_come_less_and_less_often() {
        let waits: Vec<_> = [1, 2, 3, 9, 10, 64, u32::MAX].into_iter().map(wait_s).collect();
        assert_eq!(waits, [2, 4, 8, 512, 900, 900, 900]);
    }
}
