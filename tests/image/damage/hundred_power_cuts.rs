//! A hundred power cuts.
//!
//! Owns their number and their scenarios; the moments are in `power_cuts.rs`. `CUTS` in the environment sets another
//! number, and `SEED` other scenarios, so that the hundred can be run in parts.

use crate::damage::power_cuts::{Life, Moment};
use crate::machine::clock::now;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::env;

/// A number from the environment, or `otherwise`.
fn number(name: &str, otherwise: u64) -> u64 {
    env::var(name).map_or(otherwise, |number| number.parse().unwrap())
}

#[test]
fn a_hundred_power_cuts_end_in_art() {
    let (wanted, seed) = (number("CUTS", 100), number("SEED", 11));
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut cuts = 0;
    while cuts < wanted {
        let life = random.next_u64();
        let kinds = [
            Moment::Play,
            Moment::Update,
            Moment::Start,
            Moment::Fetch,
            Moment::Write,
            Moment::Start,
            Moment::Scrub,
            Moment::Edit,
        ];
        let kind = random.next_u32() as usize % kinds.len();
        let more = u64::from(random.next_u32() % 3).min(wanted - cuts - 1);
        let moments: Vec<_> = [kinds[kind]].into_iter().chain((0..more).map(|_| Moment::Start)).collect();
        let unit = match (kind, kinds[kind]) {
            (2, _) => Life::out_of_the_box(life),
            (_, moment @ (Moment::Fetch | Moment::Write | Moment::Start)) => Life::of_a_new_system(moment, life),
            (_, Moment::Play | Moment::Update | Moment::Scrub | Moment::Edit) => Life::of_playing(life),
        };
        let began = now();
        unit.goes_on(&moments);
        cuts += 1 + more;
        let time = now().saturating_sub(began).as_secs_f64() / (1 + more) as f64;
        println!("{cuts} of {wanted} cuts with seed {seed} ended in art; {time:.1} s for each of {moments:?}");
    }
}
