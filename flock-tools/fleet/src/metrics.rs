//! The units as `OpenMetrics` text.
//!
//! Owns the metrics' names, which dashboards rely on. Has nothing that is not on the page.
//!
//! # Source
//! `OpenMetrics` 1.0, <https://prometheus.io/docs/specs/om/open_metrics_spec/>.
//!
//! Start at [`text`].

use std::fmt::{Display, Write};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::desk::Counts;
use crate::facts::Disk;
use crate::finding::Kind;
use crate::record::UnitView;

/// The content type of the text.
pub(crate) const KIND: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";

/// A gauge of a unit: its name, its unit of measure if it has one, what it is, and its value.
type Gauge = (&'static str, &'static str, &'static str, fn(&UnitView) -> Option<f64>);

/// The gauges, each with a sample for every unit that has reported it.
const GAUGES: [Gauge; 8] = [
    ("unit_ok", "", "1 while nothing is wrong with the unit, else 0.", |view| Some(f64::from(u8::from(view.ok)))),
    ("unit_last_report_timestamp_seconds", "seconds", "When the last report came, since 1970.", |view| {
        view.arrived_s.map(|s| s as f64)
    }),
    ("unit_uptime_seconds", "seconds", "How long the machine has run.", |view| view.uptime_s.map(|s| s as f64)),
    ("unit_temperature_celsius", "celsius", "The temperature of the processor.", |view| view.temperature_c),
    ("unit_disk_total_bytes", "bytes", "The size of the disk.", |view| disk(view, |disk| disk.total_bytes)),
    ("unit_disk_free_bytes", "bytes", "What is free of the disk.", |view| disk(view, |disk| disk.free_bytes)),
    ("unit_disk_worn_ratio", "ratio", "The part of the disk's life that is used.", |view| {
        disk(view, |disk| disk.worn_percent).map(|percent| percent / 100.0)
    }),
    ("unit_flock_sequence", "", "The number of the flock among those of its key.", |view| {
        view.sequence.map(|number| number as f64)
    }),
];

fn disk(view: &UnitView, of: fn(Disk) -> Option<u64>) -> Option<f64> {
    view.disk.and_then(of).map(|number| number as f64)
}

/// The metrics of `views`, and what happened since the start, closed with `# EOF`.
pub(crate) fn text(views: &[UnitView], counts: &Counts) -> String {
    let mut text = String::new();
    family(&mut text, "fleet_units", "gauge", "", "The units, seen or named.");
    line(&mut text, "fleet_units", &[], views.len());
    results(
        &mut text,
        "fleet_reports",
        "Reports since the start.",
        &[("taken", &counts.taken), ("refused", &counts.refused)],
    );
    results(
        &mut text,
        "fleet_alarms",
        "Alarms to the webhook since the start; a failed one is tried again.",
        &[("sent", &counts.alarms_sent), ("failed", &counts.alarms_failed)],
    );
    for (name, measure, help, value) in GAUGES {
        family(&mut text, name, "gauge", measure, help);
        for view in views {
            if let Some(value) = value(view) {
                line(&mut text, name, &[("unit", &view.unit)], value);
            }
        }
    }
    family(&mut text, "unit_wrong", "gauge", "", "1 while something of this kind is wrong with the unit, else 0.");
    for view in views {
        for kind in Kind::ALL {
            let is_wrong = view.wrong.iter().any(|wrong| wrong.kind == kind.name());
            line(&mut text, "unit_wrong", &[("unit", &view.unit), ("kind", kind.name())], u8::from(is_wrong));
        }
    }
    family(&mut text, "unit_hanging", "info", "", "The flock on the wall, and the system that plays it.");
    for view in views {
        let of = |value: &'_ Option<String>| value.clone().unwrap_or_default();
        let (flock, system, programs) = (of(&view.flock), of(&view.system), of(&view.programs));
        let labels = [("unit", &*view.unit), ("flock", &flock), ("system", &system), ("programs", &programs)];
        line(&mut text, "unit_hanging_info", &labels, 1);
    }
    text += "# EOF\n";
    text
}

/// A counter with the label `result`.
fn results(text: &mut String, name: &str, help: &str, counts: &[(&str, &AtomicU64)]) {
    family(text, name, "counter", "", help);
    for (result, count) in counts {
        line(text, &format!("{name}_total"), &[("result", result)], count.load(Ordering::Relaxed));
    }
}

fn family(text: &mut String, name: &str, kind: &str, measure: &str, help: &str) {
    writeln!(text, "# TYPE dreams_{name} {kind}").expect("a string takes everything");
    if !measure.is_empty() {
        writeln!(text, "# UNIT dreams_{name} {measure}").expect("a string takes everything");
    }
    writeln!(text, "# HELP dreams_{name} {help}").expect("a string takes everything");
}

fn line(text: &mut String, name: &str, labels: &[(&str, &str)], value: impl Display) {
    let escaped = |value: &str| value.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
    let labels: Vec<_> = labels.iter().map(|(label, value)| format!("{label}=\"{}\"", escaped(value))).collect();
    let labels = if labels.is_empty() { String::new() } else { format!("{{{}}}", labels.join(",")) };
    writeln!(text, "dreams_{name}{labels} {value}").expect("a string takes everything");
}

#[cfg(test)]
mod tests {
    use super::{Counts, text};
    use crate::facts::Facts;
    use crate::record::{Noted, Record, UnitView};
    use std::sync::atomic::Ordering;

    #[test]
    fn every_unit_has_its_samples_and_any_name_is_a_label() {
        let report = br#"{"unit": "lobby", "status": {"flock": "a\"b\\c\nd", "too_slow": true, "screen": {}},
            "machine": {"temperature_c": 61.5, "disk": {"free_bytes": 900000000000, "worn_percent": 3}}}"#;
        let facts = Facts::parse(report).unwrap().0;
        let noted = Noted::after(None, &facts, 1_700_000_000);
        let counts = Counts::default();
        counts.taken.store(5, Ordering::Relaxed);
        let text = text(&[UnitView::of(&Record { facts, noted }, 1_700_000_000, 60)], &counts);
        for expected in [
            "dreams_fleet_units 1",
            "dreams_fleet_reports_total{result=\"taken\"} 5",
            "dreams_fleet_alarms_total{result=\"failed\"} 0",
            "dreams_unit_ok{unit=\"lobby\"} 0",
            "dreams_unit_last_report_timestamp_seconds{unit=\"lobby\"} 1700000000",
            "dreams_unit_temperature_celsius{unit=\"lobby\"} 61.5",
            "dreams_unit_disk_free_bytes{unit=\"lobby\"} 900000000000",
            "dreams_unit_disk_worn_ratio{unit=\"lobby\"} 0.03",
            "dreams_unit_wrong{unit=\"lobby\",kind=\"too-slow\"} 1",
            "dreams_unit_wrong{unit=\"lobby\",kind=\"silent\"} 0",
        ] {
            assert!(text.lines().any(|line| line == expected), "`{expected}` is missing:\n{text}");
        }
        let info = text.lines().find(|line| line.starts_with("dreams_unit_hanging_info{")).unwrap();
        assert!(info.contains("flock=\"a\\\"b\\\\c\\\\u{a}d\""), "{info}");
        assert!(text.ends_with("\n# EOF\n") && !text.contains("uptime_seconds{"));
    }
}
