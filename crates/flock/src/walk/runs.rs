//! The runs of steps that were walked recently.
//!
//! Owns the last [`WINDOW`] exits and the set of runs of [`RUN`] among them. `mod.rs` raises the cost of a step that
//! repeats a run.

use std::collections::{HashMap, VecDeque};

use crate::graph::Exit;

/// Length of a run: 16 steps and the one that follows.
pub(crate) const RUN: usize = 17;
/// How many steps back a run is remembered: nine days of 50-second steps.
pub(crate) const WINDOW: usize = 16_384;

/// The last exits, oldest first, at most [`WINDOW`].
pub(crate) type Recent = VecDeque<Exit>;

/// The runs among the last exits. A function of them alone, so it is rebuilt and never saved.
#[derive(Clone, Debug)]
pub(crate) struct Runs {
    /// How often each run's fingerprint occurs in the window.
    walked: HashMap<u64, u32>,
}

impl Runs {
    /// The runs of `recent`.
    pub(crate) fn of(recent: &Recent) -> Self {
        // Allocated at once: memory that grows for nine days looks like a leak.
        let mut runs = Self { walked: HashMap::with_capacity(WINDOW) };
        for start in 0..(recent.len() + 1).saturating_sub(RUN) {
            runs.add(fingerprint(recent.range(start..start + RUN)));
        }
        runs
    }

    /// Appends `exit` to `recent` and lets the oldest go.
    pub(crate) fn push(&mut self, recent: &mut Recent, exit: Exit) {
        recent.push_back(exit);
        if recent.len() >= RUN {
            self.add(fingerprint(recent.range(recent.len() - RUN..)));
        }
        if recent.len() > WINDOW {
            self.remove(fingerprint(recent.range(..RUN)));
            recent.pop_front();
        }
    }

    /// The fingerprint of the last steps, for [`Self::walked`].
    pub(crate) fn tail(recent: &Recent) -> Option<u64> {
        let start = (recent.len() + 1).checked_sub(RUN)?;
        Some(fingerprint(recent.range(start..)))
    }

    /// Whether the steps of `tail` followed by `exit` were walked.
    pub(crate) fn walked(&self, tail: u64, exit: Exit) -> bool {
        self.walked.contains_key(&followed(tail, exit))
    }

    fn add(&mut self, run: u64) {
        *self.walked.entry(run).or_insert(0) += 1;
    }

    fn remove(&mut self, run: u64) {
        if let Some(count) = self.walked.get_mut(&run) {
            *count -= 1;
            if *count == 0 {
                self.walked.remove(&run);
            }
        }
    }
}

fn fingerprint<'a>(exits: impl Iterator<Item = &'a Exit>) -> u64 {
    exits.fold(0, |tail, &exit| followed(tail, exit))
}

/// One more exit. The finalizer of `splitmix64`, so that 64 bits tell 16,384 runs apart.
fn followed(tail: u64, exit: Exit) -> u64 {
    let mut z = tail.wrapping_mul(0xD134_2543_DE82_EF95).wrapping_add(u64::from(exit.0) + 0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rebuilt_set_is_the_kept_one() {
        let (mut recent, mut runs) = (Recent::new(), Runs::of(&Recent::new()));
        for step in 0..(WINDOW as u32 + 5000) {
            runs.push(&mut recent, Exit(step.wrapping_mul(step) / 7 % 23));
        }
        assert_eq!(recent.len(), WINDOW);
        assert_eq!(runs.walked, Runs::of(&recent).walked);
    }

    #[test]
    fn only_a_run_of_the_window_was_walked() {
        let (mut recent, mut runs) = (Recent::new(), Runs::of(&Recent::new()));
        let lap = |at: u32| Exit(at % 20);
        for at in 0..20 + 16 {
            runs.push(&mut recent, lap(at));
        }
        let tail = Runs::tail(&recent).unwrap();
        assert!(runs.walked(tail, lap(36)));
        assert!(!runs.walked(tail, lap(37)));
        for at in 0..WINDOW as u32 {
            runs.push(&mut recent, Exit(100 + at));
        }
        assert!(!runs.walked(tail, lap(36)));
    }
}
