//! The noise that a home may add to its totals.
//!
//! Owns the two-sided geometric distribution with epsilon 1: a number `k` has a probability proportional to `exp(-|k|)`.
//! It is drawn once for each ledger, sheep and total, and kept, so that what is sent again reveals nothing more.
//! The random source comes in as an argument.
//!
//! # Source
//! Ghosh, Roughgarden, Sundararajan, *Universally Utility-Maximizing Privacy Mechanisms*, STOC 2009.

use crate::totals::SheepTotals;
use serde::{Deserialize, Serialize};

/// `exp(-1)` of the whole range of 64 bits.
const GOES_ON: u64 = 6_786_177_901_268_885_274;
/// One draw is at most this: larger ones have a probability below 1e-27.
const LARGEST: i32 = 64;
/// Seconds of one unit of noise on the time in which somebody was near: one stay of a person.
const NEAR_S: i32 = 30;

/// The noise of one sheep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Noise {
    up: i32,
    down: i32,
    near: i32,
}

impl Noise {
    /// Draws from `random`, which gives 64 random bits a call.
    pub(crate) fn draw(random: &mut dyn FnMut() -> u64) -> Self {
        let mut one = || two_sided_geometric(random);
        Self { up: one(), down: one(), near: one() }
    }

    /// `totals` with this noise. Each number still grows only, and no vote is without its showing. How often a sheep was
    /// shown is the walk's and tells nothing of people: it stays exact.
    pub(crate) fn on(self, totals: SheepTotals) -> SheepTotals {
        let near = self.near * NEAR_S;
        let noisy = |total: u32, noise: i32| total.saturating_add_signed(noise);
        let SheepTotals { shown, up, down, near_s } = totals;
        SheepTotals { shown, up: noisy(up, self.up), down: noisy(down, self.down), near_s: noisy(near_s, near) }
            .capped()
    }
}

fn two_sided_geometric(random: &mut dyn FnMut() -> u64) -> i32 {
    let mut one_sided = || (0..LARGEST).find(|_| random() >= GOES_ON).unwrap_or(LARGEST);
    one_sided() - one_sided()
}

#[cfg(test)]
mod tests {
    use super::{GOES_ON, Noise, two_sided_geometric};
    use crate::totals::SheepTotals;
    use crate::totals::tests_random::random;

    #[test]
    fn the_noise_has_the_distribution_of_epsilon_one() {
        assert!((GOES_ON as f64 / 2f64.powi(64) - (-1f64).exp()).abs() < 1e-12);
        let mut random = random(3);
        let draws: Vec<i32> = (0..40_000).map(|_| two_sided_geometric(&mut random)).collect();
        let share = |k: i32| draws.iter().filter(|draw| **draw == k).count() as f64 / draws.len() as f64;
        // tanh(1/2) of all draws are 0, and each step away from it has a factor of exp(-1).
        for k in -3..=3_i32 {
            let expected = 0.5f64.tanh() * f64::from(-k.abs()).exp();
            assert!((share(k) - expected).abs() < 0.01, "{k}: {} is not {expected}", share(k));
        }
    }

    #[test]
    fn noisy_totals_only_grow_and_no_vote_is_without_its_showing() {
        let mut random = random(4);
        for _ in 0..200 {
            let noise = Noise::draw(&mut random);
            let mut before = SheepTotals::default();
            for shown in 0..40 {
                let now = noise.on(SheepTotals { shown, up: shown / 3, down: shown / 9, near_s: shown * 7 });
                assert!(now.up <= shown && now.down <= shown && now == now.larger(before), "{before:?} {now:?}");
                before = now;
            }
        }
    }
}
