//! What is wrong with a unit, and what to do.
//!
//! Owns the kinds of wrong things, their limits and their sentences. Pure rules: the time is an argument.
//!
//! | kind | it is wrong if |
//! |---|---|
//! | `silent` | the last report is older than the limit, or none ever came |
//! | `rolled-back` | the unit left a new system again |
//! | `update-failed` | the last look for updates ended with an error |
//! | `no-player` | the player did not answer |
//! | `too-slow` | the player calls the machine too slow for its flock |
//! | `disk-full` | less than 256 MiB, or less than 2 % of the disk, are free |
//! | `disk-worn` | 90 % of the writes that the disk is made for are used |
//! | `hot` | the processor has 85 °C or more |
//!
//! Start at [`findings`].

use std::fmt::Write as _;

use crate::facts::{Disk, Facts};

/// Bytes that must be free, and the part of the disk, in percent. The updater's own reserve is as many bytes.
const LEAST_FREE_BYTES: u64 = 256 << 20;
const LEAST_FREE_PERCENT: u64 = 2;
/// The most of a disk's life, in percent.
const MOST_WORN_PERCENT: u64 = 89;
/// The temperature from which processors slow down, in degrees Celsius.
const HOT_C: f64 = 85.0;
/// Seconds of an hour and of a day.
const HOUR_S: u64 = 3600;
const DAY_S: u64 = 86_400;

/// A kind of wrong thing. Its name is used in JSON, metrics and alarms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    Silent,
    RolledBack,
    UpdateFailed,
    NoPlayer,
    TooSlow,
    DiskFull,
    DiskWorn,
    Hot,
}

/// Something that is wrong with a unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Finding {
    pub(crate) kind: Kind,
    /// The fact, with its values.
    pub(crate) what: String,
}

impl Kind {
    /// All of them, in the order in which they are shown.
    pub(crate) const ALL: [Self; 8] = [
        Self::Silent,
        Self::RolledBack,
        Self::UpdateFailed,
        Self::NoPlayer,
        Self::TooSlow,
        Self::DiskFull,
        Self::DiskWorn,
        Self::Hot,
    ];

    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Silent => "silent",
            Self::RolledBack => "rolled-back",
            Self::UpdateFailed => "update-failed",
            Self::NoPlayer => "no-player",
            Self::TooSlow => "too-slow",
            Self::DiskFull => "disk-full",
            Self::DiskWorn => "disk-worn",
            Self::Hot => "hot",
        }
    }

    /// What to do about it.
    pub(crate) fn advice(self) -> &'static str {
        match self {
            Self::Silent => {
                "Check that the unit has power and a network, and that `report_to` in its `dreams.toml` is the address of \
                 this page."
            }
            Self::RolledBack => {
                "Do not send this system to other units. Find the reason in the unit's journal, and send a newer one."
            }
            Self::UpdateFailed => {
                "If it is still so after the next look, check the unit's network, and `url` in its `dreams.toml`."
            }
            Self::NoPlayer => "Switch the unit off and on. If it is still so, send it a newer system.",
            Self::TooSlow => "Send the unit a flock of a smaller size or a lower rate, or use a faster machine.",
            Self::DiskFull => "Send the unit a smaller flock, or use a larger disk.",
            Self::DiskWorn => "Replace the disk soon: write the image to a new one.",
            Self::Hot => "Give the unit more air, and clean its fan and vents.",
        }
    }
}

/// What is wrong with a unit that reported `facts` so many seconds ago, in the order of [`Kind::ALL`]. It may be silent for
/// `silent_after_s`.
pub(crate) fn findings(facts: &Facts, age_s: u64, silent_after_s: u64) -> Vec<Finding> {
    let about = |kind| what(kind, facts, age_s, silent_after_s).map(|what| Finding { kind, what });
    Kind::ALL.into_iter().filter_map(about).collect()
}

/// What is wrong with a unit that is named and has not reported.
pub(crate) fn never_reported() -> Vec<Finding> {
    vec![Finding { kind: Kind::Silent, what: "It has never reported.".to_owned() }]
}

/// The sentence of a wrong thing; `None` if nothing of this kind is wrong.
fn what(kind: Kind, facts: &Facts, age_s: u64, silent_after_s: u64) -> Option<String> {
    let machine = &facts.machine;
    let player = facts.player.as_ref();
    match kind {
        Kind::Silent => (age_s > silent_after_s).then(|| format!("Its last report came {} ago.", span(age_s))),
        Kind::RolledBack => machine.rolled_back.as_ref().map(|back| {
            let mut text = "It went back from a new system".to_owned();
            if let Some(from) = &back.from {
                write!(text, ", {from}").expect("a string takes everything");
            }
            back.why.as_ref().map_or_else(|| format!("{text}."), |why| format!("{text}: {why}."))
        }),
        Kind::UpdateFailed => facts.error.as_ref().map(|error| format!("Its last look for updates failed: {error}.")),
        Kind::NoPlayer => player.is_none().then(|| "Its player did not answer.".to_owned()),
        Kind::TooSlow => player
            .filter(|player| player.is_too_slow)
            .map(|_| "The machine is too slow for its flock: the picture stutters.".to_owned()),
        Kind::DiskFull => machine.disk.and_then(full),
        Kind::DiskWorn => {
            let worn = machine.disk.and_then(|disk| disk.worn_percent).filter(|worn| *worn > MOST_WORN_PERCENT);
            worn.map(|worn| format!("{worn} % of the writes that its disk is made for are used."))
        }
        Kind::Hot => {
            let hot = machine.temperature_c.filter(|degrees| *degrees >= HOT_C);
            hot.map(|degrees| format!("Its processor has {degrees:.0} °C."))
        }
    }
}

fn full(disk: Disk) -> Option<String> {
    let free = disk.free_bytes?;
    let least = disk.total_bytes.map_or(0, |total| total / 100 * LEAST_FREE_PERCENT).max(LEAST_FREE_BYTES);
    (free < least).then(|| format!("Only {} of its disk are free.", size(free)))
}

/// What is worth a look and not wrong, as sentences.
pub(crate) fn remarks(facts: &Facts) -> Vec<String> {
    let player = facts.player.as_ref();
    let faults = player.and_then(|player| player.faults).filter(|faults| *faults > 0);
    let latest = player.and_then(|player| player.latest_fault.as_deref());
    let is_dark = player.is_some_and(|player| !player.has_screen);
    [
        player.filter(|player| player.is_on_trial).map(|_| "Its flock is on trial.".to_owned()),
        is_dark.then(|| "No display is connected, or it is off.".to_owned()),
        faults.map(|faults| {
            let count = if faults == 1 { "One fault".to_owned() } else { format!("{faults} faults") };
            latest
                .map_or_else(|| format!("{count} since its start."), |latest| format!("{count}, the latest: {latest}"))
        }),
        (facts.machine.is_time_known == Some(false)).then(|| "It does not know the time.".to_owned()),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A time in its two largest units: `3 days 4 hours`.
pub(crate) fn span(seconds: u64) -> String {
    let count = |count: u64, thing: &str| format!("{count} {thing}{}", if count == 1 { "" } else { "s" });
    let two = |large: u64, of: &str, small: u64, rest: &str| match small {
        0 => count(large, of),
        _ => format!("{} {}", count(large, of), count(small, rest)),
    };
    match seconds {
        0..60 => count(seconds, "second"),
        60..HOUR_S => count(seconds / 60, "minute"),
        HOUR_S..DAY_S => two(seconds / HOUR_S, "hour", seconds % HOUR_S / 60, "minute"),
        _ => two(seconds / DAY_S, "day", seconds % DAY_S / HOUR_S, "hour"),
    }
}

/// Bytes in GB or MB, as disks are sold.
pub(crate) fn size(bytes: u64) -> String {
    if bytes >= 1_000_000_000 {
        format!("{:.1} GB", bytes as f64 / 1e9)
    } else {
        format!("{:.0} MB", bytes as f64 / 1e6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    const DAY: u64 = 26 * HOUR_S;

    fn kinds(change: &Value, age_s: u64) -> Vec<&'static str> {
        let mut report = json!({"unit": "lobby", "error": null, "status": {"screen": {}, "too_slow": false},
            "machine": {"rolled_back": null, "temperature_c": 50, "disk": {"total_bytes": 64_000_000_000_u64,
                "free_bytes": 9_000_000_000_u64, "worn_percent": 3}}});
        for (pointer, value) in change.as_object().unwrap() {
            *report.pointer_mut(pointer).unwrap() = value.clone();
        }
        let facts = Facts::parse(report.to_string().as_bytes()).unwrap().0;
        findings(&facts, age_s, DAY).iter().map(|finding| finding.kind.name()).collect()
    }

    #[test]
    fn each_kind_is_wrong_from_its_limit_on_and_not_before() {
        let disk = |free: u64| json!({"/machine/disk/free_bytes": free});
        let small = |free: u64| json!({"/machine/disk": {"total_bytes": 4_000_000_000_u64, "free_bytes": free}});
        let table: [(Value, u64, &[&str]); 19] = [
            (json!({}), 0, &[]),
            (json!({}), DAY, &[]),
            (json!({}), DAY + 1, &["silent"]),
            (json!({"/error": "no route"}), 0, &["update-failed"]),
            (json!({"/status": null}), 0, &["no-player"]),
            (json!({"/status/too_slow": true}), 0, &["too-slow"]),
            (json!({"/status/screen": null}), 0, &[]),
            (json!({"/machine/rolled_back": {}}), 0, &["rolled-back"]),
            (json!({"/machine/temperature_c": 84.9}), 0, &[]),
            (json!({"/machine/temperature_c": 85}), 0, &["hot"]),
            (json!({"/machine/disk/worn_percent": 89}), 0, &[]),
            (json!({"/machine/disk/worn_percent": 90}), 0, &["disk-worn"]),
            (disk(1_280_000_000), 0, &[]),
            (disk(1_279_999_999), 0, &["disk-full"]),
            (small(LEAST_FREE_BYTES), 0, &[]),
            (small(LEAST_FREE_BYTES - 1), 0, &["disk-full"]),
            (json!({"/machine/disk": null, "/machine/temperature_c": null}), 0, &[]),
            (json!({"/machine": null}), 0, &[]),
            (
                json!({"/error": "a", "/machine/rolled_back": {"from": "2", "why": "b"}}),
                DAY * 2,
                &["silent", "rolled-back", "update-failed"],
            ),
        ];
        for (change, age_s, expected) in table {
            assert_eq!(kinds(&change, age_s), expected, "{change} after {age_s} s");
        }
    }

    #[test]
    fn a_span_is_in_its_two_largest_units() {
        let spans =
            [(0, "0 seconds"), (1, "1 second"), (61, "1 minute"), (3600, "1 hour"), (7_380, "2 hours 3 minutes")];
        for (seconds, text) in spans.into_iter().chain([(86_400, "1 day"), (180_000, "2 days 2 hours")]) {
            assert_eq!(span(seconds), text);
        }
    }

    #[test]
    fn every_kind_says_what_to_do() {
        for kind in Kind::ALL {
            assert!(kind.advice().ends_with('.') && kind.advice().len() > 20, "{kind:?}");
        }
    }
}
