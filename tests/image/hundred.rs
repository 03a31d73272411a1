//! The power goes a hundred times.
//!
//! Owns how often, and in which lives: `cuts.rs` has the moments.

use crate::cuts::{Life, Moment};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

#[test]
fn a_hundred_power_cuts_end_in_art() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let (mut cuts, mut life) = (0, 0);
    while cuts < 100 {
        let first = [Moment::Play, Moment::Update, Moment::Start][random.next_u32() as usize % 3];
        let mut moments = vec![first];
        moments.extend((0..random.next_u32() % 3).map(|_| Moment::Start));
        println!("life {life}, {cuts} cuts so far: {moments:?}");
        match first {
            Moment::Start => Life::out_of_the_box(life).goes_on(&moments),
            Moment::Play | Moment::Update => Life::of_playing(life).goes_on(&moments),
        }
        cuts += moments.len();
        life += 1;
    }
}
