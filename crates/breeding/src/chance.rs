//! What is drawn by chance.
//!
//! Owns the streams of a brood. Never takes the system's entropy: seeds are arguments.
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
