//! The answer of `dreams balance --suggest`: transitions to add, and transitions to remove.
//!
//! Owns its form. The flock crate chooses them; `operations::render` estimates the cost.

use std::path::Path;

use flock::{Flock, Measure, SheepId, Suggestion, Suggestions};
use operations::program::print;
use operations::render::cost::{self, Cost};

/// The part of the answer that is asked for by `--suggest`.
#[derive(serde::Serialize)]
pub(super) struct Advice {
    /// Each is the best one after those before it.
    add: Vec<TransitionAdvice>,
    /// Each is the best one after those before it, with none added.
    remove: Vec<TransitionAdvice>,
    /// The measure of the worst ratio for people.
    #[serde(skip)]
    by: Measure,
}

/// A transition to add or to remove.
#[derive(serde::Serialize)]
struct TransitionAdvice {
    from: SheepId,
    to: SheepId,
    /// That of the balance after this change and those before it; `null` while a sheep is never shown.
    worst_ratio: Option<f64>,
    /// The same of time.
    worst_time_ratio: Option<f64>,
    /// Its weight, or the weight that the estimate gives it.
    weight: f64,
    #[serde(flatten)]
    cost: Cost,
}

impl Advice {
    /// `suggestions` for the `flock` in `folder`, for balances `by` a measure, with their costs.
    pub(super) fn new(suggestions: &Suggestions, flock: &Flock, folder: &Path, by: Measure) -> Self {
        let rendered = cost::of_rendering(&suggestions.add, flock, folder);
        let saved = cost::of_keeping(&suggestions.remove, flock, folder);
        let advised = |(suggestion, cost): (&Suggestion, Cost)| {
            let Suggestion { from, to, worst_ratio, worst_time_ratio, weight, .. } = suggestion.clone();
            TransitionAdvice { from, to, worst_ratio, worst_time_ratio, weight, cost }
        };
        Self {
            add: suggestions.add.iter().zip(rendered).map(advised).collect(),
            remove: suggestions.remove.iter().zip(saved).map(advised).collect(),
            by,
        }
    }

    /// The lines for people.
    pub(super) fn table(&self) -> Vec<String> {
        let all = self.add.iter().chain(&self.remove);
        let wide = print::widest(all.flat_map(|advised| [&advised.from, &advised.to]));
        let mut lines = Vec::new();
        for (word, advised, none) in [
            ("add", &self.add, "No transition more makes the balance better."),
            ("remove", &self.remove, "No transition less makes the balance better."),
        ] {
            lines.push(String::new());
            if advised.is_empty() {
                lines.push(none.to_owned());
                continue;
            }
            lines.push(format!(
                "{word:<6} {:<wide$} {:<wide$} {:>11} {:>8} {:>8} {:>10} {:>8}",
                "from", "to", "worst ratio", "frames", "seconds", "CPU hours", "MB"
            ));
            lines.extend(advised.iter().enumerate().map(|(at, advised)| advised.row(at + 1, wide, self.by)));
        }
        lines.push(String::new());
        lines.push(
            "Each is the best one after those above it; the worst ratio is that of the balance with all of them."
                .to_owned(),
        );
        lines
    }
}

impl TransitionAdvice {
    fn row(&self, place: usize, wide: usize, by: Measure) -> String {
        let Cost { frames, seconds, cpu_hours, bytes, .. } = self.cost;
        let worst = if by == Measure::Time { self.worst_time_ratio } else { self.worst_ratio };
        let worst = worst.map_or("never".to_owned(), |ratio| format!("{ratio:.3}"));
        let hours = cpu_hours.map_or("-".to_owned(), |hours| format!("{hours:.2}"));
        let megabytes = bytes.map_or("-".to_owned(), |bytes| format!("{:.1}", bytes / 1e6));
        let (from, to) = (self.from.as_str(), self.to.as_str());
        format!(
            "{place:<6} {from:<wide$} {to:<wide$} {worst:>11} {frames:>8} {seconds:>8.1} {hours:>10} {megabytes:>8}"
        )
    }
}
