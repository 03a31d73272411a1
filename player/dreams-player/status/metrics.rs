//! The facts as `OpenMetrics` text.
//!
//! Owns the metrics' names, which dashboards rely on. Has nothing that is not on the page.
//!
//! # Source
//! `OpenMetrics` 1.0, <https://prometheus.io/docs/specs/om/open_metrics_spec/>.

use super::facts::Facts;
use std::fmt::{Display, Write};

/// The content type of the text.
pub(crate) const KIND: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";

/// The metrics, closed with `# EOF`.
pub(crate) fn text(facts: &Facts) -> String {
    let mut text = String::new();
    let tally = &facts.tally;
    let counters = [
        ("flips", "Pictures that arrived on the glass.", tally.flips),
        ("late", "Vblanks at which a frame was due and was not there.", tally.late),
        ("repeated", "Flips that lit the same frame once more.", tally.repeated),
        ("skipped", "Frames that were decoded and never lit.", tally.skipped),
        ("joins", "Flips at which a clip followed another.", tally.joins),
        ("faults", "Things that went wrong while the picture went on.", facts.faults),
    ];
    for (name, help, value) in counters {
        family(&mut text, name, "counter", help);
        line(&mut text, &format!("{name}_total"), &[], value);
    }
    family(&mut text, "uptime_seconds", "gauge", "How long the run has lasted.");
    line(&mut text, "uptime_seconds", &[], facts.uptime_s);
    family(&mut text, "screen_lit", "gauge", "1 while there is a screen, 0 while it is away.");
    line(&mut text, "screen_lit", &[], u8::from(facts.screen.is_some()));
    family(&mut text, "too_slow", "gauge", "1 while frames are late all the time, else 0.");
    line(&mut text, "too_slow", &[], u8::from(facts.too_slow));
    family(&mut text, "clip", "info", "The clip on the glass.");
    if let Some(glass) = &facts.showing.glass {
        line(&mut text, "clip_info", &[("clip", &glass.clip)], 1);
    }
    family(&mut text, "visits_share", "gauge", "A sheep's share of the visits so far.");
    for sheep in &facts.sheep {
        line(&mut text, "visits_share", &[("sheep", &sheep.id)], sheep.share);
    }
    family(&mut text, "due_share", "gauge", "The share of visits that a sheep gets in the long run.");
    for sheep in &facts.sheep {
        line(&mut text, "due_share", &[("sheep", &sheep.id)], sheep.due);
    }
    text += "# EOF\n";
    text
}

fn family(text: &mut String, name: &str, kind: &str, help: &str) {
    writeln!(text, "# TYPE dreams_{name} {kind}\n# HELP dreams_{name} {help}").expect("a string takes everything");
}

fn line(text: &mut String, name: &str, labels: &[(&str, &str)], value: impl Display) {
    let escaped = |value: &str| value.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
    let labels: Vec<_> = labels.iter().map(|(label, value)| format!("{label}=\"{}\"", escaped(value))).collect();
    let labels = if labels.is_empty() { String::new() } else { format!("{{{}}}", labels.join(",")) };
    writeln!(text, "dreams_{name}{labels} {value}").expect("a string takes everything");
}

#[cfg(test)]
mod tests {
    use super::text;
    use crate::recording::Tally;
    use crate::status::facts::{Facts, GlassFacts, SheepFacts, Showing};

    #[test]
    fn every_family_is_declared_and_the_text_is_closed() {
        let glass = GlassFacts { clip: "a \"b\".mp4".to_owned(), frame: 3, frames: 9, is_lit: true, of: None };
        let sheep = SheepFacts { id: "a".to_owned(), visits: 2, share: 0.25, due: 0.5 };
        let facts = Facts {
            flock: "aurora".to_owned(),
            fps: [30, 1],
            screen: None,
            showing: Showing { glass: Some(glass), before: None },
            next: None,
            uptime_s: 60,
            tally: Tally { flips: 1_800, late: 2, repeated: 0, skipped: 0, joins: 4 },
            too_slow: true,
            faults: 1,
            latest_faults: Vec::new(),
            path: None,
            generation: None,
            contact: None,
            settings: None,
            display_power: None,
            sheep: vec![sheep],
        };
        let text = text(&facts);
        assert!(text.ends_with("# EOF\n"));
        for line in [
            "# TYPE dreams_flips counter",
            "dreams_flips_total 1800",
            "dreams_late_total 2",
            "dreams_screen_lit 0",
            "dreams_too_slow 1",
            "dreams_clip_info{clip=\"a \\\"b\\\".mp4\"} 1",
            "dreams_visits_share{sheep=\"a\"} 0.25",
            "dreams_due_share{sheep=\"a\"} 0.5",
        ] {
            assert!(text.lines().any(|found| found == line), "`{line}` is missing:\n{text}");
        }
    }
}
