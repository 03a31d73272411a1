//! Random numbers for sixteen orbits.
//!
//! Owns sixteen generators that take their steps together. Streams are numbered as those of [`Rng`](species::Rng) are.

use fearless_simd::{Simd, SimdBase, SimdInt, u32x16};

use super::lanes::{LaneMask, Lanes};
use super::{LANES, Random};
use species::Rng;

/// Sixteen generators xoshiro128++ 1.0.
///
/// # Source
/// Blackman & Vigna, *Scrambled linear pseudorandom number generators* (2018); public domain.
#[derive(Clone, Copy, Debug)]
pub struct LaneRng<S: Simd> {
    state: [u32x16<S>; 4],
}

impl<S: Simd> LaneRng<S> {
    /// The stream numbered `stream` of `seed`.
    #[inline(always)]
    pub fn stream(simd: S, seed: u64, stream: u64) -> LaneRng<S> {
        let mut mix = Rng::stream(seed, stream);
        let state = [[(); LANES]; 4].map(|lanes| u32x16::load_array(simd, lanes.map(|()| (mix.bits() >> 32) as u32)));
        LaneRng { state }
    }

    /// The next 32 random bits of each.
    #[inline(always)]
    pub fn bits(&mut self) -> u32x16<S> {
        let [mut s0, mut s1, mut s2, mut s3] = self.state;
        let out = rotated(s0 + s3, 7) + s0;
        let shifted = s1 << 9;
        s2 ^= s0;
        s3 ^= s1;
        s1 ^= s2;
        s0 ^= s3;
        s2 ^= shifted;
        s3 = rotated(s3, 11);
        self.state = [s0, s1, s2, s3];
        out
    }
}

#[inline(always)]
fn rotated<S: Simd>(bits: u32x16<S>, by: u32) -> u32x16<S> {
    (bits << by) | (bits >> (32 - by))
}

impl<S: Simd> Random<Lanes<S>> for LaneRng<S> {
    #[inline(always)]
    fn unit(&mut self) -> Lanes<S> {
        // 24 bits are what an f32 tells apart below 1.
        let fraction: fearless_simd::f32x16<S> = (self.bits() >> 8).to_float();
        Lanes(fraction * (1.0 / 16_777_216.0))
    }

    #[inline(always)]
    fn coin(&mut self) -> LaneMask<S> {
        LaneMask((self.bits() >> 31).simd_eq(1))
    }
}
