//! Random numbers: a specified generator with numbered streams.
//!
//! Owns the one generator of all species, so that a seed means the same genomes and the same pixels on every machine and for
//! any number of threads. Seeds are arguments; the system's entropy is not used.
//!
//! Start at [`Rng::stream`].

/// xoshiro256++ 1.0, seeded through splitmix64.
///
/// # Source
/// Blackman & Vigna, *Scrambled linear pseudorandom number generators* (2018); both are public domain.
#[derive(Clone, Debug)]
pub struct Rng {
    state: [u64; 4],
}

impl Rng {
    /// The stream numbered `stream` of `seed`. Different numbers give independent streams.
    pub fn stream(seed: u64, stream: u64) -> Rng {
        let mut mix = splitmix(&mut seed.clone()) ^ stream.wrapping_mul(0xd134_2543_de82_ef95);
        Rng { state: std::array::from_fn(|_| splitmix(&mut mix)) }
    }

    /// The next 64 random bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        let s = &mut self.state;
        let out = s[0].wrapping_add(s[3]).rotate_left(23).wrapping_add(s[0]);
        let t = s[1] << 17;
        s[2] ^= s[0];
        s[3] ^= s[1];
        s[1] ^= s[2];
        s[0] ^= s[3];
        s[2] ^= t;
        s[3] = s[3].rotate_left(45);
        out
    }

    /// A number in `0.0..1.0`, 53 bits fine.
    #[inline]
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// A whole number below `count`, which is at least 1.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// A number with mean 0 and deviation 1, near enough to a normal one: the sum of twelve even ones.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }

    /// A number of the normal distribution, the same on every machine.
    ///
    /// # Source
    /// Box & Muller, *A Note on the Generation of Random Normal Deviates* (1958).
    pub fn gaussian(&mut self) -> f64 {
        let length = libm::sqrt(-2.0 * libm::log(1.0 - self.unit()));
        length * libm::cos(std::f64::consts::TAU * self.unit())
    }

    /// Puts values into an order by chance.
    pub fn shuffle<T>(&mut self, values: &mut [T]) {
        for last in (1..values.len()).rev() {
            values.swap(last, self.below(last + 1));
        }
    }

    /// The place of one of `weights` (>= 0), each as likely as it is large; `None` if none is above 0.
    pub fn weighted(&mut self, weights: &[f64]) -> Option<usize> {
        let mut left = self.unit() * weights.iter().sum::<f64>();
        let found = weights.iter().position(|weight| {
            left -= weight;
            left < 0.0
        });
        found.or_else(|| weights.iter().rposition(|weight| *weight > 0.0))
    }

    /// A number in `-1.0..1.0`.
    #[inline]
    pub fn signed(&mut self) -> f64 {
        self.unit() * 2.0 - 1.0
    }
}

fn splitmix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_generator_is_the_published_one() {
        let mut rng = Rng { state: [1, 2, 3, 4] };
        let first: Vec<u64> = (0..4).map(|_| rng.bits()).collect();
        assert_eq!(first, [41_943_041, 58_720_359, 3_588_806_011_781_223, 3_591_011_842_654_386]);
    }

    #[test]
    fn streams_of_one_seed_differ_and_are_repeatable() {
        assert_eq!(Rng::stream(7, 3).bits(), Rng::stream(7, 3).bits());
        assert_ne!(Rng::stream(7, 3).bits(), Rng::stream(7, 4).bits());
        assert_ne!(Rng::stream(7, 3).bits(), Rng::stream(8, 3).bits());
    }
}
