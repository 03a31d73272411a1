//! What is read of a report.
//!
//! Owns the fields that are looked at, their limits, and which documents are refused. Every field but the unit's name may
//! be missing or of any type: what is not as it should be is as if it were missing. Texts are cut, and nothing of them has
//! an effect on a terminal. Never reads a file or a clock.
//!
//! Start at [`Facts::parse`].

use bundle::{NameError, UnitId};
use ct_codecs::{Base64, Decoder};
use operations::program::print::visible;
use serde_json::{Map, Value};

use crate::picture::{self, PictureError};

/// The most bytes of a report, as it is sent and as it is kept.
pub(crate) const MOST_BYTES: usize = 1 << 20;
/// The most lists and objects in a report: one for each sheep of the largest flock whose report has so few bytes. Each takes
/// up to 700 bytes of memory.
const MOST_PARTS: usize = 20_000;
/// The most characters of a name or a version.
const LONGEST_NAME: usize = 80;
/// The most characters of a sentence.
const LONGEST_SENTENCE: usize = 400;
/// Degrees that a processor may report.
const DEGREES: std::ops::RangeInclusive<f64> = -100.0..=300.0;

/// A document that is no report.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ReportError {
    #[error("the report is not JSON: {0}")]
    Json(serde_json::Error),
    #[error("the report has more than {MOST_BYTES} bytes")]
    Long,
    #[error("the report has more than {MOST_PARTS} lists and objects")]
    Many,
    #[error("the report has no text `unit`, expected the name of the unit that sends it")]
    Nameless,
    #[error("the report is not of a unit: {0}")]
    Name(NameError),
    #[error("{0}")]
    Picture(PictureError),
}

/// What a report says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Facts {
    pub(crate) unit: UnitId,
    /// The flock on the wall, and its number among those of its key.
    pub(crate) flock: Option<String>,
    pub(crate) sequence: Option<u64>,
    /// Why the last look for updates failed.
    pub(crate) error: Option<String>,
    /// `None` if the player did not answer.
    pub(crate) player: Option<PlayerFacts>,
    pub(crate) machine: MachineFacts,
    /// A JPEG within the limits.
    pub(crate) picture: Option<Vec<u8>>,
}

/// What the player says.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PlayerFacts {
    pub(crate) has_screen: bool,
    pub(crate) is_too_slow: bool,
    pub(crate) is_on_trial: bool,
    /// Vblanks at which a frame was due and was not there, and things that went wrong, since the player's start.
    pub(crate) late: Option<u64>,
    pub(crate) faults: Option<u64>,
    pub(crate) latest_fault: Option<String>,
}

/// What the machine says.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MachineFacts {
    pub(crate) system: Option<String>,
    pub(crate) programs: Option<String>,
    pub(crate) slot: Option<String>,
    pub(crate) rolled_back: Option<RolledBack>,
    pub(crate) uptime_s: Option<u64>,
    pub(crate) temperature_c: Option<f64>,
    pub(crate) disk: Option<Disk>,
    pub(crate) address: Option<String>,
    pub(crate) is_time_known: Option<bool>,
}

/// A system that the unit left again.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RolledBack {
    pub(crate) from: Option<String>,
    pub(crate) why: Option<String>,
}

/// The disk of the flocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub(crate) struct Disk {
    pub(crate) total_bytes: Option<u64>,
    pub(crate) free_bytes: Option<u64>,
    pub(crate) worn_percent: Option<u64>,
}

impl Facts {
    /// What the report in `bytes` says, and the whole document.
    /// Errors: [`ReportError`], if it is none.
    pub(crate) fn parse(bytes: &[u8]) -> Result<(Self, Map<String, Value>), ReportError> {
        if parts(bytes) > MOST_PARTS {
            return Err(ReportError::Many);
        }
        let document: Map<String, Value> = serde_json::from_slice(bytes).map_err(ReportError::Json)?;
        let unit = document.get("unit").and_then(Value::as_str).ok_or(ReportError::Nameless)?;
        let unit = UnitId::new(unit).map_err(ReportError::Name)?;
        let picture = document.get("picture").filter(|picture| !picture.is_null());
        let picture = picture.map(decoded).transpose().map_err(ReportError::Picture)?;
        let (status, update) = (document.get("status"), document.get("update"));
        let playing = status.and_then(|status| status.get("generation"));
        let facts = Self {
            unit,
            flock: name(status, "flock").or_else(|| name(update, "flock")),
            sequence: number(playing, "sequence").or_else(|| number(update, "sequence")),
            error: document.get("error").and_then(Value::as_str).map(|text| cut(text, LONGEST_SENTENCE)),
            player: status.filter(|status| status.is_object()).map(PlayerFacts::read),
            machine: document.get("machine").map(MachineFacts::read).unwrap_or_default(),
            picture,
        };
        Ok((facts, document))
    }
}

impl PlayerFacts {
    fn read(status: &Value) -> Self {
        let latest = status.get("latest_faults").and_then(Value::as_array).and_then(|faults| faults.last());
        Self {
            has_screen: status.get("screen").is_some_and(Value::is_object),
            is_too_slow: flag(Some(status), "too_slow").unwrap_or_default(),
            is_on_trial: flag(status.get("generation"), "is_on_trial").unwrap_or_default(),
            late: number(Some(status), "late"),
            faults: number(Some(status), "faults"),
            latest_fault: sentence(latest, "message"),
        }
    }
}

impl MachineFacts {
    fn read(machine: &Value) -> Self {
        let all = Some(machine);
        let back = machine.get("rolled_back").filter(|back| back.is_object());
        let temperature = machine.get("temperature_c").and_then(Value::as_f64);
        let disk = machine.get("disk").filter(|disk| disk.is_object());
        Self {
            system: name(all, "system"),
            programs: name(all, "programs"),
            slot: name(all, "slot"),
            rolled_back: back.map(|_| RolledBack { from: name(back, "from"), why: sentence(back, "why") }),
            uptime_s: number(all, "uptime_s"),
            temperature_c: temperature.filter(|degrees| DEGREES.contains(degrees)),
            disk: disk.map(|_| Disk {
                total_bytes: number(disk, "total_bytes"),
                free_bytes: number(disk, "free_bytes"),
                worn_percent: number(disk, "worn_percent"),
            }),
            address: name(all, "address"),
            is_time_known: flag(all, "time_known"),
        }
    }
}

/// How many lists and objects begin in the JSON text `bytes`: as many as there are brackets and braces outside of texts.
fn parts(bytes: &[u8]) -> usize {
    let (mut parts, mut is_text, mut is_escaped) = (0, false, false);
    for byte in bytes {
        match byte {
            _ if is_escaped => is_escaped = false,
            b'\\' => is_escaped = is_text,
            b'"' => is_text = !is_text,
            b'[' | b'{' if !is_text => parts += 1,
            _ => {}
        }
    }
    parts
}

fn decoded(picture: &Value) -> Result<Vec<u8>, PictureError> {
    let text = picture.as_str().ok_or(PictureError::Base64)?;
    if text.len() > picture::MOST_BYTES.div_ceil(3) * 4 {
        return Err(PictureError::Long);
    }
    let bytes = Base64::decode_to_vec(text, None).map_err(|_| PictureError::Base64)?;
    picture::check(&bytes).map(|()| bytes)
}

fn name(of: Option<&Value>, key: &str) -> Option<String> {
    of?.get(key)?.as_str().filter(|text| !text.is_empty()).map(|text| cut(text, LONGEST_NAME))
}

fn sentence(of: Option<&Value>, key: &str) -> Option<String> {
    of?.get(key)?.as_str().filter(|text| !text.is_empty()).map(|text| cut(text, LONGEST_SENTENCE))
}

/// A whole number from 0; what is written as `3.0` is one, too.
fn number(of: Option<&Value>, key: &str) -> Option<u64> {
    let value = of?.get(key)?;
    let rounded = || value.as_f64().filter(|number| (0.0..1e15).contains(number)).map(|number| number as u64);
    value.as_u64().or_else(rounded)
}

fn flag(of: Option<&Value>, key: &str) -> Option<bool> {
    of?.get(key)?.as_bool()
}

/// The first characters of `text`, visible ones only.
fn cut(text: &str, most: usize) -> String {
    let start: String = text.chars().take(most).collect();
    let seen = visible(&start);
    if start.len() < text.len() || seen.chars().count() > most {
        seen.chars().take(most - 1).chain(['…']).collect()
    } else {
        seen.into_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn read(document: &Value) -> Facts {
        Facts::parse(document.to_string().as_bytes()).unwrap().0
    }

    #[test]
    fn a_report_of_today_and_one_of_an_older_unit_are_both_read() {
        let older = read(&json!({"unit": "lobby", "update": {"flock": "aurora", "sequence": 7}, "error": null,
            "status": null}));
        assert_eq!((older.flock.as_deref(), older.sequence, older.player), (Some("aurora"), Some(7), None));
        let newer = read(&json!({"unit": "lobby", "update": null, "error": "no route",
            "status": {"flock": "dawn", "screen": {"name": "HDMI"}, "too_slow": true, "late": 3, "faults": 1,
                "latest_faults": [{"kind": "clip", "message": "torn"}],
                "generation": {"sequence": 9, "is_on_trial": true}},
            "machine": {"system": "1.2", "programs": "0.1.0", "slot": "b", "rolled_back": {"from": "1.3", "why": "dark"},
                "uptime_s": 60, "temperature_c": 61.5, "address": "10.0.0.7", "time_known": true,
                "disk": {"total_bytes": 100, "free_bytes": 40, "worn_percent": null}}}));
        let player = newer.player.unwrap();
        assert_eq!((newer.flock.as_deref(), newer.sequence), (Some("dawn"), Some(9)));
        assert!(player.has_screen && player.is_too_slow && player.is_on_trial);
        assert_eq!((player.late, player.faults, player.latest_fault.as_deref()), (Some(3), Some(1), Some("torn")));
        let disk = Disk { total_bytes: Some(100), free_bytes: Some(40), worn_percent: None };
        assert_eq!((newer.machine.disk, newer.machine.temperature_c), (Some(disk), Some(61.5)));
        assert_eq!(newer.machine.rolled_back.unwrap().why.as_deref(), Some("dark"));
    }

    #[test]
    fn fields_of_any_other_type_or_size_are_as_if_they_were_missing() {
        for odd in
            [json!(3), json!(-1.5e308), json!("x"), json!([[]]), json!({"flock": [1], "sequence": -4}), json!(true)]
        {
            let facts =
                read(&json!({"unit": "lobby", "update": odd, "error": {"a": odd}, "status": odd, "machine": odd}));
            assert_eq!((facts.flock, facts.sequence, facts.error), (None, None, None), "{odd}");
            let inside = json!({"system": odd, "slot": [odd], "rolled_back": 7, "uptime_s": -1, "disk": [odd],
                "temperature_c": 1e99, "time_known": "yes"});
            let machine = read(&json!({"unit": "lobby", "machine": inside})).machine;
            assert_eq!((machine.disk, machine.temperature_c, machine.uptime_s), (None, None, None), "{odd}");
        }
        let long = read(&json!({"unit": "lobby", "error": "\u{1b}[2J\u{202e}".repeat(900)})).error.unwrap();
        assert!(long.chars().count() <= LONGEST_SENTENCE && long.chars().all(|c| !c.is_control()), "{long}");
        assert!(!long.contains('\u{202e}') && long.ends_with('…'));
    }

    #[test]
    fn only_lists_and_objects_outside_of_texts_count() {
        for (text, expected) in
            [(r#"{"a": [1, {}]}"#, 3), (r#"{"[[{": "\"[{\\"}"#, 1), (r#"{"a\\": ["\\\"[", [] ]}"#, 3), ("", 0)]
        {
            assert_eq!(parts(text.as_bytes()), expected, "{text}");
        }
    }

    #[test]
    fn a_document_that_is_no_report_is_refused_in_words() {
        let refused = |text: &str| Facts::parse(text.as_bytes()).unwrap_err().to_string();
        assert!(refused("{\"unit\": \"lobby\"").contains("not JSON"));
        assert!(refused(&"[".repeat(MOST_PARTS)).contains("not JSON"));
        assert!(refused(&"[".repeat(MOST_PARTS + 1)).contains("more than 20000 lists"));
        assert!(refused("{}").contains("`unit`") && refused("{\"unit\": 4}").contains("`unit`"));
        for name in ["../lobby", "Lobby", "", ".x", "a/b", "all", &"a".repeat(65), "a\n"] {
            assert!(refused(&json!({"unit": name}).to_string()).contains("not of a unit"), "{name}");
        }
        assert!(refused("{\"unit\": \"lobby\", \"picture\": \"####\"}").contains("base64"));
        assert!(refused("{\"unit\": \"lobby\", \"picture\": \"AAAA\"}").contains("JPEG"));
        assert!(refused("{\"unit\": \"lobby\", \"picture\": 4}").contains("base64"));
    }
}
