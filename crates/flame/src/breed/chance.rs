//! Random numbers as breeding wants them.
//!
//! Owns the distributions. Never makes a genome.
//!
//! Start at [`normal`] and [`weighted`].

use species::Rng;

/// A whole number below `count` (> 0).
pub(super) fn below(rng: &mut Rng, count: usize) -> usize {
    ((rng.unit() * count as f64) as usize).min(count - 1)
}

/// One of several (at least one).
pub(super) fn pick<T: Copy>(rng: &mut Rng, of: &[T]) -> T {
    of[below(rng, of.len())]
}

/// A number in `from..to`.
pub(super) fn even(rng: &mut Rng, from: f64, to: f64) -> f64 {
    from + (to - from) * rng.unit()
}

/// A number with mean 0 and deviation 1, near enough to a normal one: the sum of twelve even ones.
pub(super) fn normal(rng: &mut Rng) -> f64 {
    (0..12).map(|_| rng.unit()).sum::<f64>() - 6.0
}

/// Whether something happens that has this chance.
pub(super) fn happens(rng: &mut Rng, chance: f64) -> bool {
    rng.unit() < chance
}

/// Which of several chance takes, by their shares, of which one at least is above 0.
pub(super) fn weighted(rng: &mut Rng, shares: &[f64]) -> usize {
    let mut left = rng.unit() * shares.iter().sum::<f64>();
    let taken = shares.iter().position(|share| {
        left -= share;
        left < 0.0
    });
    taken.unwrap_or_else(|| shares.iter().rposition(|share| *share > 0.0).unwrap_or(0))
}

/// The same with the digits that a person might write, which keeps files short: seven.
pub(super) fn short(number: f64) -> f64 {
    // As Rust prints it, so the same on every machine; what is printed is a number.
    format!("{number:.6e}").parse().unwrap_or(number)
}
