//! The rules of Electric Sheep, for comparison.
//!
//! Owns a pool under them: votes are counted, what was counted before falls to a quarter at every step, the lowest count
//! dies, the oldest first among equals. Parents are drawn by tournaments of three, which is kind to them: how they were
//! chosen is not documented. Never uses the rules of this package.
//!
//! Start at [`course`].
//!
//! # Source
//! Ralph Abraham's research notes of May 2005, which quote Scott Draves on the server's rules.

use breeding::{Id, Origin, Traits};
use species::Rng;

use super::outcome::Course;
use super::world::{Genes, World, crossed, mutated};
use super::{BROODS, SHEEP, drawn_votes, vote_chance};

const TOURNAMENT: usize = 3;

/// Births of a brood: the same numbers as ours.
const CROSSINGS: usize = 10;
const MUTATIONS: usize = 8;
const STRANGERS: usize = 2;

struct Sheep {
    genes: Genes,
    figures: Traits,
    family: Id,
    count: u64,
}

/// What comes of a world. Sheep lie in the order of their births.
pub(super) fn course(world: &World, showings: u64, seed: u64) -> Course {
    let mut rng = Rng::stream(seed, 1);
    let mut course = Course::default();
    let mut births = 0;
    let mut sheep = |genes: Genes, family: Option<Id>| {
        births += 1;
        let family = family.unwrap_or(Id { brood: 0, serial: births, origin: Origin::of_bits(seed) });
        Sheep { figures: world.figures(&genes), genes, family, count: 0 }
    };
    let mut pool: Vec<Sheep> = (0..SHEEP).map(|_| sheep(World::random(&mut rng), None)).collect();
    for brood in 1..=BROODS {
        for one in &mut pool {
            one.count = one.count / 4 + drawn_votes(showings, vote_chance(world.taste(&one.genes)), &mut rng);
        }
        let mut born = Vec::new();
        for birth in 0..CROSSINGS + MUTATIONS + STRANGERS {
            let parent = parent(&pool, &mut rng);
            born.push(match birth {
                _ if birth < CROSSINGS => {
                    let other = self::parent(&pool, &mut rng);
                    sheep(crossed([&parent.genes, &other.genes], &mut rng), Some(parent.family))
                }
                _ if birth < CROSSINGS + MUTATIONS => sheep(mutated(&parent.genes, 1.0, &mut rng), Some(parent.family)),
                _ => sheep(World::random(&mut rng), None),
            });
        }
        while pool.len() + born.len() > SHEEP {
            let least = pool.iter().enumerate().min_by_key(|(_, sheep)| sheep.count).map(|(at, _)| at);
            let Some(least) = least else { break };
            pool.remove(least);
        }
        pool.extend(born);
        let living: Vec<_> = pool.iter().map(|sheep| (&sheep.genes, &sheep.figures, sheep.family)).collect();
        course.note(brood, world, &living);
    }
    course
}

fn parent<'a>(pool: &'a [Sheep], rng: &mut Rng) -> &'a Sheep {
    let drawn: [&Sheep; TOURNAMENT] = std::array::from_fn(|_| &pool[rng.below(pool.len())]);
    drawn.into_iter().reduce(|best, next| if next.count > best.count { next } else { best }).unwrap_or(&pool[0])
}
