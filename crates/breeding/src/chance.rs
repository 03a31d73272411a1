//! What is drawn by chance.
//!
//! Owns the streams of a brood, and draws from a stream that are the same on every machine. Never takes the system's
//! entropy: seeds are arguments.
//!
//! Start at [`brood_seed`].

use species::Rng;

/// The stream of a brood from which its parents are drawn; its births have streams of their own.
pub(crate) const PLAN: u64 = u64::MAX;

/// The seed of a brood of a pool.
pub(crate) fn brood_seed(seed: u64, brood: u32) -> u64 {
    Rng::stream(seed, u64::from(brood)).bits()
}

/// The seed of a birth, of 53 bits: as many as every reader of JSON keeps.
pub(crate) fn birth_seed(brood_seed: u64, index: usize) -> u64 {
    Rng::stream(brood_seed, index as u64).bits() >> 11
}

/// A whole number below `count`, which is at least 1.
pub(crate) fn below(count: usize, rng: &mut Rng) -> usize {
    ((rng.unit() * count as f64) as usize).min(count.saturating_sub(1))
}

/// A number of the normal distribution.
///
/// # Source
/// Box & Muller, *A Note on the Generation of Random Normal Deviates* (1958).
pub(crate) fn normal(rng: &mut Rng) -> f64 {
    let length = libm::sqrt(-2.0 * libm::log(1.0 - rng.unit()));
    length * libm::cos(std::f64::consts::TAU * rng.unit())
}

/// Puts values into an order by chance.
pub(crate) fn shuffle<T>(values: &mut [T], rng: &mut Rng) {
    for last in (1..values.len()).rev() {
        values.swap(last, below(last + 1, rng));
    }
}

/// The place of one of `weights` (>= 0), each as likely as it is large; `None` if none is above 0.
pub(crate) fn weighted(weights: &[f64], rng: &mut Rng) -> Option<usize> {
    let mut left = rng.unit() * weights.iter().sum::<f64>();
    let found = weights.iter().position(|weight| {
        left -= weight;
        left < 0.0
    });
    found.or_else(|| weights.iter().rposition(|weight| *weight > 0.0))
}
