//! Random numbers that are the same in every run.
//!
//! Owns the moments and places that claims choose by chance; what a mutant gets is in `mutator/dice.rs`.

/// A repeatable stream of random numbers (Knuth's MMIX constants).
pub struct Random(pub u64);

impl Random {
    /// The next number below `bound`.
    pub fn below(&mut self, bound: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % bound
    }
}
