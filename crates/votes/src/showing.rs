//! What was lit when, and so what a press counts for.
//!
//! Owns the rule: a press counts for what was lit [`SEEN_MS`] before it: the sheep of a loop; in a transition the sheep of
//! the nearer end in time. A pure function of what was shown. Never reads a clock.
//!
//! Start at [`seen`].

use serde::{Deserialize, Serialize};

/// How long before a press that was lit which it counts for: the time from seeing to pressing.
pub const SEEN_MS: u64 = 700;

/// A vote.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Vote {
    /// For.
    Up,
    /// Against.
    Down,
}

/// One visit of a sheep in the walk: what a showing is of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Visit {
    /// The seed of the walk.
    pub seed: u64,
    /// The steps that the walk took before.
    pub step: u64,
    /// The sheep.
    pub sheep: String,
}

/// What a clip shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Shows {
    /// A sheep.
    Loop(Visit),
    /// The way from one sheep to the next.
    Transition {
        /// The visit that ends.
        from: Visit,
        /// The visit that begins.
        to: Visit,
    },
}

/// A clip that is lit, or was.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lit {
    /// What it shows.
    pub shows: Shows,
    /// How long ago its first frame was lit.
    pub since_ms: u64,
    /// How long it lasts as a whole.
    pub lasts_ms: u64,
}

impl Lit {
    /// The visit that is seen `at_ms` after its first frame.
    fn visit(&self, at_ms: u64) -> &Visit {
        match &self.shows {
            Shows::Loop(visit) => visit,
            Shows::Transition { from, .. } if at_ms * 2 < self.lasts_ms => from,
            Shows::Transition { to, .. } => to,
        }
    }
}

/// The visit that was seen `ago_ms` ago, by the clips that were lit, the newest first. What was lit before all of these
/// counts as the first moment of the oldest; `None` if nothing was lit.
pub fn seen(lit: &[Lit], ago_ms: u64) -> Option<&Visit> {
    let found = lit.iter().find(|lit| lit.since_ms >= ago_ms).or(lit.last())?;
    Some(found.visit(found.since_ms.saturating_sub(ago_ms)))
}

#[cfg(test)]
mod tests {
    use super::{Lit, SEEN_MS, Shows, Visit, seen};

    /// A loop of 8 s and a transition of 4 s, again and again: clip `k` begins at its half 12 s or 8 s after that.
    const LOOP_MS: u64 = 8_000;
    const ROUND_MS: u64 = 12_000;

    fn visit(step: u64) -> Visit {
        Visit { seed: 7, step, sheep: format!("s{}", step % 5) }
    }

    /// The clip that is lit at `at_ms`, and when it began.
    fn clip(at_ms: u64) -> (Shows, u64, u64) {
        let (step, within) = (at_ms / ROUND_MS, at_ms % ROUND_MS);
        if within < LOOP_MS {
            (Shows::Loop(visit(step)), at_ms - within, LOOP_MS)
        } else {
            let shows = Shows::Transition { from: visit(step), to: visit(step + 1) };
            (shows, step * ROUND_MS + LOOP_MS, ROUND_MS - LOOP_MS)
        }
    }

    /// What the player says at `at_ms`: the clip that is lit and the one before.
    fn told(at_ms: u64) -> Vec<Lit> {
        let (shows, began_ms, lasts_ms) = clip(at_ms);
        let lit = Lit { shows, since_ms: at_ms - began_ms, lasts_ms };
        let before = began_ms.checked_sub(1).map(|end_ms| {
            let (shows, began_ms, lasts_ms) = clip(end_ms);
            Lit { shows, since_ms: at_ms - began_ms, lasts_ms }
        });
        [Some(lit), before].into_iter().flatten().collect()
    }

    #[test]
    fn two_hundred_presses_around_joins_count_for_what_was_seen() {
        // The visit of step `n` is the nearest from 2 s before its loop until 2 s after it.
        let nearest = |at_ms: u64| (at_ms + 2_000) / ROUND_MS;
        let mut credited = Vec::new();
        for round in 1..=5 {
            // Around the loop's begin, its end, and the middles of both transitions.
            for join_ms in [0, LOOP_MS, LOOP_MS + 2_000, ROUND_MS] {
                for press in 0..10 {
                    let at_ms = round * ROUND_MS + join_ms + press * 170 - 400;
                    // The player is asked up to 90 ms after the press.
                    let asked_ms = at_ms + (press * 37) % 91;
                    let found = seen(&told(asked_ms), SEEN_MS + asked_ms - at_ms).unwrap().step;
                    assert_eq!(found, nearest(at_ms - SEEN_MS), "a press at {at_ms} ms");
                    credited.push(found);
                }
            }
        }
        assert_eq!(credited.len(), 200);
        let nearest_now = (1..=5).flat_map(|round| (0..10).map(move |press| round * ROUND_MS + 9_600 + press * 170));
        let differ = nearest_now.filter(|at_ms| nearest(*at_ms) != nearest(at_ms - SEEN_MS)).count();
        assert!(differ >= 15, "only {differ} of these presses tell the rule from what is lit");
    }

    #[test]
    fn what_was_lit_before_all_that_is_known_is_the_begin_of_the_oldest() {
        assert_eq!(seen(&[], 0), None);
        let young = [Lit { shows: Shows::Loop(visit(3)), since_ms: 100, lasts_ms: 8_000 }];
        assert_eq!(seen(&young, SEEN_MS), Some(&visit(3)));
    }
}
