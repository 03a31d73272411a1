//! What a unit gets of a pool.

use std::collections::{BTreeMap, BTreeSet};

use crate::meadow::Sheep;
use crate::simulation::World;
use breeding::{Ballot, Elected, Event, Id, Mark, elect};

fn elected(sheep: &mut Sheep<'_>, edition: &str, size: usize, unique: usize) -> Vec<Id> {
    let ballot = Ballot { edition: edition.to_owned(), sheep: size, unique };
    let chosen: Vec<Elected> = elect(&sheep.pool, &sheep.census(), &ballot);
    let ids: Vec<Id> = chosen.iter().map(|chosen| chosen.id).collect();
    assert_eq!(ids.iter().collect::<BTreeSet<_>>().len(), ids.len(), "a sheep was chosen twice");
    sheep.tell(vec![Event::Elected { edition: edition.to_owned(), ids: ids.clone(), unique }]);
    ids
}

#[test]
fn the_limits_of_an_edition_hold_in_200_pools_and_two_units_differ_by_their_own_sheep() {
    let world = World::new(1);
    let mut whole = 0;
    for seed in 0..200 {
        let mut sheep = Sheep::new(&world, seed, 30 + (seed % 4) as u32 * 10);
        (0..seed % 5).for_each(|_| sheep.step());
        let kept: Vec<Id> = sheep.pool.living().map(|sheep| sheep.born.id).step_by(11).take(3).collect();
        sheep.tell(kept.iter().map(|id| Event::Marked { id: *id, mark: Mark::Keep }).collect());
        let size = 10 + (seed % 3) as usize * 10;
        let hall = elected(&mut sheep, "hall", size, 4);
        // A larger one would have taken the hall's own sheep among the others.
        let stairs = elected(&mut sheep, "stairs", size + 6, 4);
        for (edition, size) in [(&hall, size), (&stairs, size + 6)] {
            assert!(edition.len() <= size);
            assert!(edition.starts_with(&kept) || kept.iter().all(|id| edition[..3].contains(id)), "{edition:?}");
            let census = sheep.census();
            let of = |id: &Id| sheep.pool.get(*id).unwrap();
            let (mut niches, mut families) = (BTreeMap::new(), BTreeMap::new());
            for id in edition.iter().filter(|id| !kept.contains(id)) {
                *niches.entry(census.niche(of(id))).or_insert(0) += 1;
                *families.entry(of(id).family).or_insert(0) += 1;
            }
            assert!(niches.values().all(|count| *count <= 4), "{niches:?}");
            assert!(families.values().all(|count| *count <= (size * 15 / 100).max(1)), "{families:?}");
            let is_new = |id: &Id| census.tally(of(id)).expected < 2.0;
            let newcomers = edition.iter().filter(|id| is_new(id)).count();
            let left = sheep.pool.living().filter(|sheep| is_new(&sheep.born.id) && !edition.contains(&sheep.born.id));
            assert!(newcomers * 10 >= edition.len() || left.count() == 0, "{newcomers} newcomers of {edition:?}");
        }
        if hall.len() == size && stairs.len() == size + 6 {
            whole += 1;
            let own = |edition: &[Id], other: &[Id]| edition[edition.len() - 4..].iter().all(|id| !other.contains(id));
            assert!(own(&hall, &stairs) && own(&stairs, &hall), "{hall:?} {stairs:?}");
        }
    }
    assert!(whole > 100, "only {whole} pools were large enough");
}
