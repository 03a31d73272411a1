//! Random numbers as breeding wants them.
//!
//! Owns the distributions. Never makes a genome.
//!
//! Start at [`normal`] and [`weighted`].

use species::Rng;

/// One of several (at least one).
pub(super) fn pick<T: Copy>(rng: &mut Rng, of: &[T]) -> T {
    of[rng.below(of.len())]
}

/// A number in `from..to`.
pub(super) fn even(rng: &mut Rng, from: f64, to: f64) -> f64 {
    from + (to - from) * rng.unit()
}

/// Whether something happens that has this chance.
pub(super) fn happens(rng: &mut Rng, chance: f64) -> bool {
    rng.unit() < chance
}

/// The same with the digits that a person might write, which keeps files short: seven.
pub(super) fn short(number: f64) -> f64 {
    // As Rust prints it, so the same on every machine; what is printed is a number.
    format!("{number:.6e}").parse().unwrap_or(number)
}
