//! Ratings, broods and deaths: what a sheep may count on.

use std::collections::{BTreeMap, BTreeSet};

use crate::meadow::{self, Sheep, waiting};
use crate::simulation::World;
use breeding::{
    Birth, Brood, Census, Count, Day, Entry, Event, Id, Lookalikes, Made, Mark, Nursery, Operation, Order, Origin,
    Pool, Stamp, Traits, Votes, breed, deaths, plan,
};
use species::{Rng, Threads};

fn id(serial: u32) -> Id {
    Id { brood: 0, serial, origin: Origin::of_bits(1) }
}

fn drawn(shown: u64, chance: f64, rng: &mut Rng) -> Count {
    Count { shown, up: (0..shown).filter(|_| rng.unit() < chance).count() as u64, down: 0 }
}

/// The ratings of sheep 0, 1, 2..., after what units counted.
fn ratings(units: &[(&str, Vec<Count>)], sheep: u32) -> Vec<f64> {
    let mut votes = Votes::new(180.0);
    for (unit, counts) in units {
        let ids: Vec<String> = (0..counts.len() as u32).map(|serial| id(serial).to_string()).collect();
        votes.add(unit, Day(20_000), ids.iter().map(String::as_str).zip(counts.iter().copied()));
    }
    let tallies = votes.tallies(Day(20_000));
    (0..sheep).map(|serial| tallies.get(&id(serial)).copied().unwrap_or_default().rating()).collect()
}

#[test]
fn being_shown_more_is_no_merit() {
    let mut rng = Rng::stream(5, 0);
    let mut sum = [0.0; 3];
    for _ in 0..1000 {
        // One that is liked less than the others, one as much, one more.
        for (at, chance) in [0.02, 0.04, 0.06].into_iter().enumerate() {
            let mut counts: Vec<Count> = (0..40).map(|_| drawn(200, 0.04, &mut rng)).collect();
            counts[0] = drawn(200, chance, &mut rng);
            let before = ratings(&[("wall", counts.clone())], 1)[0];
            let more = drawn(200, chance, &mut rng);
            counts[0] = Count { shown: 400, up: counts[0].up + more.up, down: 0 };
            sum[at] += ratings(&[("wall", counts)], 1)[0] - before;
        }
    }
    assert!(sum.iter().all(|sum| (sum / 1000.0).abs() < 0.1), "{sum:?} in 1000 draws");
}

#[test]
fn a_unit_where_somebody_presses_all_day_changes_few_ranks() {
    let mut rng = Rng::stream(6, 0);
    let chances: Vec<f64> = (0..100).map(|_| 0.01 + 0.05 * rng.unit()).collect();
    // The kitchen shows every second sheep a third as often.
    let mut unit = |rarely: u64| -> Vec<Count> {
        let shown = [3000, rarely].into_iter().cycle();
        chances.iter().zip(shown).map(|(chance, shown)| drawn(shown, *chance, &mut rng)).collect()
    };
    let (hall, stairs, kitchen) = (unit(3000), unit(3000), unit(1000));
    // The same presses, ten times: nobody likes anything else.
    let eager: Vec<Count> = kitchen.iter().map(|count| Count { up: 10 * count.up, ..*count }).collect();
    let others = [("hall", hall), ("stairs", stairs)];
    let before = ratings(&[&others[..], &[("kitchen", kitchen)]].concat(), 100);
    let after = ratings(&[&others[..], &[("kitchen", eager)]].concat(), 100);
    let found = spearman(&before, &after);
    assert!((0.95..1.0).contains(&found), "{found}");
}

/// The correlation of ranks.
fn spearman(a: &[f64], b: &[f64]) -> f64 {
    let ranks = |values: &[f64]| -> Vec<f64> {
        let below = |value: &f64| values.iter().filter(|other| *other < value).count() as f64;
        let same = |value: &f64| values.iter().filter(|other| other.total_cmp(value).is_eq()).count() as f64;
        values.iter().map(|value| below(value) + same(value) / 2.0).collect()
    };
    let (a, b) = (ranks(a), ranks(b));
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let of = |x: &[f64], y: &[f64]| {
        let (x0, y0) = (mean(x), mean(y));
        x.iter().zip(y).map(|(x, y)| (x - x0) * (y - y0)).sum::<f64>()
    };
    of(&a, &b) / (of(&a, &a) * of(&b, &b)).sqrt()
}

#[test]
fn a_rating_is_votes_over_expected_votes_and_fades_to_average() {
    let mut votes = Votes::new(180.0);
    let counts = [(id(0).to_string(), 100, 9, 1), (id(1).to_string(), 100, 1, 0), ("191.21054".to_owned(), 299, 19, 0)];
    let counts: Vec<(&str, Count)> =
        counts.iter().map(|(id, shown, up, down)| (&**id, Count { shown: *shown, up: *up, down: *down })).collect();
    votes.add("wall", Day(0), counts);
    // (29 + 1/2) votes in (499 + 1) showings: 5.9 are expected of 100, of a sheep of no pool too.
    let tally = votes.tallies(Day(0))[&id(0)];
    assert!((tally.expected - 5.9).abs() < 1e-9 && (tally.got - 8.0).abs() < 1e-9, "{tally:?}");
    assert!((tally.rating() - 9.0 / 6.9).abs() < 1e-9 && (tally.uncertainty() - 3.0 / 6.9).abs() < 1e-9);
    let later = votes.tallies(Day(180));
    assert!((later[&id(0)].got - 4.0).abs() < 1e-9, "{later:?}");
    let faded = votes.tallies(Day(18_000));
    assert!(faded.values().all(|tally| (tally.rating() - 1.0).abs() < 1e-9), "{faded:?}");
}

fn told<C>(brood: &Brood<C>) -> String {
    format!("{:?} {} {:?}", brood.events(), brood.missing, brood.faults())
}

#[test]
fn the_same_ledger_and_seed_give_the_same_brood_on_any_number_of_threads() {
    let world = World::new(3);
    let mut sheep = Sheep::new(&world, 3, 80);
    for _ in 0..4 {
        sheep.step();
    }
    sheep.vote();
    let broods = [1, 2, 7].map(|threads| Threads::new(threads).unwrap().run(|| told(&sheep.brood(&Order::default()))));
    assert!(broods[0] == broods[1] && broods[1] == broods[2]);
    let other = told(&sheep.brood(&Order { seed: Some(4), ..Order::default() }));
    assert_ne!(broods[0], other);
}

#[test]
fn a_brood_is_crossed_mutated_and_strange_as_planned_and_no_parent_has_more_than_its_part() {
    let world = World::new(4);
    let mut sheep = Sheep::new(&world, 4, 100);
    for _ in 0..6 {
        sheep.step();
        let plan = plan(&sheep.pool, &sheep.census(), &Order::default());
        let count = |operation| plan.births.iter().filter(|birth| birth.operation == operation).count();
        let counts = [Operation::Cross, Operation::Mutation, Operation::Stranger].map(count);
        assert_eq!(counts.iter().sum::<usize>() + plan.reborn.len(), 20, "{counts:?}");
        assert!((9..=10).contains(&counts[0]) && (7..=8).contains(&counts[1]) && counts[2] <= 2, "{counts:?}");
        assert_eq!(plan.births.iter().filter(|birth| birth.candidates == 8).count(), 10);
        let mut children: BTreeMap<Id, usize> = BTreeMap::new();
        for parent in plan.births.iter().flat_map(|birth| &birth.parents) {
            assert!(sheep.pool.get(*parent).unwrap().is_alive());
            *children.entry(*parent).or_default() += 1;
        }
        assert!(children.values().all(|children| *children <= 4), "{children:?}");
    }
}

#[test]
fn no_sheep_dies_that_is_kept_elected_young_or_hardly_seen_and_the_rejected_never_come_back() {
    let world = World::new(5);
    let mut sheep = Sheep::new(&world, 5, 60);
    sheep.pool.settings.limit = 40;
    let ids: Vec<Id> = sheep.pool.living().map(|sheep| sheep.born.id).collect();
    let marked = |id: Id, mark| Event::Marked { id, mark };
    sheep.tell((0..5).map(|at| marked(ids[at], Mark::Keep)).collect());
    sheep.tell((5..10).map(|at| marked(ids[at], Mark::Reject)).collect());
    sheep.tell(vec![Event::Elected { edition: "hall".to_owned(), ids: ids[10..15].to_vec(), unique: 0 }]);
    let mut died = BTreeSet::new();
    for _ in 0..12 {
        let before: BTreeSet<Id> = sheep.pool.living().map(|sheep| sheep.born.id).collect();
        sheep.step();
        let is_alive = |id: &Id| sheep.pool.get(*id).unwrap().is_alive();
        let dead: Vec<Id> = before.into_iter().filter(|id| !is_alive(id)).collect();
        let census = Census::of(&sheep.pool, sheep.pool.last_day());
        for id in &dead {
            let sheep = sheep.pool.get(*id).unwrap();
            assert!(census.is_judged(sheep), "{id} was hardly seen");
        }
        died.extend(dead);
        let alive: Vec<usize> = (0..15).filter(|at| is_alive(&ids[*at])).collect();
        assert_eq!(alive, [0, 1, 2, 3, 4, 10, 11, 12, 13, 14]);
    }
    assert!(died.len() > 100, "only {} died", died.len());
    let last = sheep.pool.next_brood() - 1;
    assert!(died.iter().all(|id| id.brood + 1 < last || last - id.brood >= 1), "{died:?}");
}

#[test]
fn a_brood_without_judged_sheep_is_strangers_and_an_order_is_kept() {
    let world = World::new(6);
    let sheep = Sheep::new(&world, 6, 30);
    let strangers = sheep.brood(&Order::default());
    assert!(strangers.born.len() == 20 && strangers.born.iter().all(|(born, _)| born.parents.is_empty()));
    let parents: Vec<Id> = sheep.pool.living().take(2).map(|sheep| sheep.born.id).collect();
    let ordered = sheep.brood(&Order { births: Some(7), parents: parents.clone(), ..Order::default() });
    assert!(ordered.born.len() == 7 && ordered.born.iter().all(|(born, _)| born.parents == parents));
    // Without any strength a child is its parent again, and twenty tries do not help.
    let nothing = Order { parents: parents[..1].to_vec(), strength: Some(0.0), ..Order::default() };
    let clones = sheep.brood(&nothing);
    let refused = BTreeMap::from([("clone".to_owned(), 400)]);
    assert_eq!((clones.born.len(), clones.missing, clones.faults()), (0, 20, refused));
}

#[test]
fn genomes_that_wait_are_the_first_strangers_in_their_order_and_change_no_other_birth() {
    let world = World::new(8);
    let mut sheep = Sheep::new(&world, 8, 100);
    sheep.step();
    let before = plan(&sheep.pool, &sheep.census(), &Order::default());
    let is_stranger = |birth: &&Birth| birth.operation == Operation::Stranger;
    let strangers = before.births.iter().filter(is_stranger).count();
    assert!((1..=2).contains(&strangers), "{strangers}");
    // One is a copy of a living sheep: the artist has chosen it all the same.
    let copy = sheep.pool.living().next().unwrap().born.figures.clone();
    let genes: Vec<_> = (0..5).map(|_| World::random(&mut sheep.rng)).collect();
    let all: Vec<_> = genes.iter().map(|genes| waiting(world.figures(genes))).chain([waiting(copy)]).collect();
    sheep.tell(all.iter().cloned().map(Event::Waits).collect());
    // What waits in another pool is born there.
    let stamp = Stamp { number: 1_000_000, pool: Origin::of_bits(99) };
    sheep.pool.apply(&Entry { stamp, day: Day(0), event: Event::Waits(waiting(all[0].figures.clone())) }).unwrap();
    let after = plan(&sheep.pool, &sheep.census(), &Order::default());
    for (now, was) in after.births.iter().zip(&before.births) {
        let same = Birth { waited: None, species: was.species.clone(), candidates: was.candidates, ..now.clone() };
        assert_eq!((&same, now.waited.is_some()), (was, is_stranger(&was)));
    }
    let mut born = Vec::new();
    for _ in 0..all.len() {
        let broods = [1, 3].map(|threads| Threads::new(threads).unwrap().run(|| sheep.brood(&Order::default())));
        assert_eq!(told(&broods[0]), told(&broods[1]));
        let [brood, _] = broods;
        let brought = brood.born.iter().filter(|(born, _)| born.waited.is_some());
        born.extend(brought.map(|(born, _)| born.figures.clone()));
        sheep.tell(brood.events());
        sheep.meadow.genes.extend(brood.born.iter().map(|(born, genes)| (born.id, *genes)));
        assert_eq!(sheep.pool.waiting().count(), all.len() - born.len(), "each is born once");
    }
    assert_eq!(born, all.iter().map(|waiting| waiting.figures.clone()).collect::<Vec<_>>());
}

/// Makes sheep whose figures differ by less than this part of 1.
struct Alike(f64);

impl Nursery for Alike {
    type Candidate = f64;

    fn candidate(&self, _: &Birth, rng: &mut Rng) -> Option<Made<f64>> {
        let candidate = 0.4 + self.0 * rng.unit();
        Some(Made { candidate, operator: "random".to_owned(), licence: String::new() })
    }

    fn figures(&self, candidate: &f64) -> Result<Traits, Vec<String>> {
        Ok(Traits::new(&[*candidate; 15]))
    }
}

#[test]
fn a_clone_is_refused_from_the_first_brood_on() {
    let mut pool = Pool::new(meadow::settings(1));
    let order = Order { births: Some(4), ..Order::default() };
    let brood = |pool: &Pool, differ: f64| breed(pool, &Census::of(pool, Day(0)), &order, &Alike(differ));
    let told = |brood: &Brood<f64>| (brood.born.len(), brood.missing, brood.faults());
    let clones = |count: usize| BTreeMap::from([("clone".to_owned(), count)]);
    let first = brood(&pool, 1e-4);
    assert_eq!(told(&first), (1, 3, clones(60)), "of siblings that are alike, one is born");
    assert_eq!(told(&brood(&pool, 0.5)).0, 4, "what differs is born");
    let stamp = Stamp { number: 1, pool: pool.settings.origin };
    for event in first.events() {
        pool.apply(&Entry { stamp, day: Day(0), event }).unwrap();
    }
    assert_eq!(told(&brood(&pool, 1e-4)), (0, 4, clones(80)), "nor is what is like the only sheep");
}

/// Makes sheep of two species: those of one differ by a hundredth of what those of the other do.
struct TwoSpecies;

impl Nursery for TwoSpecies {
    type Candidate = Vec<f64>;

    fn candidate(&self, birth: &Birth, rng: &mut Rng) -> Option<Made<Vec<f64>>> {
        let width = if birth.species == "narrow" { 0.1 } else { 10.0 };
        let candidate = (0..15).map(|_| width * rng.unit()).collect();
        Some(Made { candidate, operator: "random".to_owned(), licence: String::new() })
    }

    fn figures(&self, candidate: &Vec<f64>) -> Result<Traits, Vec<String>> {
        Ok(Traits::new(candidate))
    }
}

#[test]
fn clones_are_told_by_the_spread_of_their_own_species() {
    let mut settings = meadow::settings(1);
    settings.species = ["narrow", "wide"].map(str::to_owned).to_vec();
    let mut pool = Pool::new(settings);
    let order = Order { births: Some(40), ..Order::default() };
    let stamp = Stamp { number: 1, pool: pool.settings.origin };
    for _ in 0..2 {
        let brood = breed(&pool, &Census::of(&pool, Day(0)), &order, &TwoSpecies);
        assert_eq!((brood.missing, brood.faults()), (0, BTreeMap::new()));
        for event in brood.events() {
            pool.apply(&Entry { stamp, day: Day(0), event }).unwrap();
        }
    }
    let known = Lookalikes::of(&pool);
    let narrow: Vec<_> = pool.living().filter(|sheep| sheep.born.species == "narrow").collect();
    assert!((20..60).contains(&narrow.len()), "{} of 80", narrow.len());
    for sheep in narrow {
        assert!(known.have("narrow", &sheep.born.figures), "a copy is a clone");
        assert!(!known.have("wide", &sheep.born.figures), "of another species it is none");
    }
}

#[test]
fn rebirths_are_of_every_brood_whose_parents_and_operator_are_left_open() {
    let world = World::new(9);
    let mut sheep = Sheep::new(&world, 9, 60);
    let ids: Vec<Id> = sheep.pool.living().map(|sheep| sheep.born.id).collect();
    sheep.tell(ids[..20].iter().map(|id| Event::Died { id: *id }).collect());
    let reborn = |order: Order| {
        let plan = plan(&sheep.pool, &sheep.census(), &order);
        assert_eq!(plan.births.len() + plan.reborn.len(), order.births.unwrap_or(20));
        plan.reborn.len()
    };
    let open = Order { births: Some(40), seed: Some(5), screening: Some(2), strength: Some(2.0), ..Order::default() };
    assert_eq!((reborn(Order::default()), reborn(open)), (1, 2), "one in twenty");
    let named = Order { parents: ids[30..32].to_vec(), ..Order::default() };
    assert_eq!(reborn(named), 0);
    assert_eq!(reborn(Order { operation: Some(Operation::Mutation), ..Order::default() }), 0);
}

/// A pool of six strangers that were born so many broods ago and were all shown as often; only those in `liked` got votes.
fn six(liked: &[usize], ago: u32, world: &World) -> (Pool, Vec<Id>) {
    let mut sheep = Sheep::new(world, 10, 6);
    sheep.pool.settings.limit = 2;
    let ids: Vec<Id> = sheep.pool.living().map(|sheep| sheep.born.id).collect();
    let count = |at: usize| Count { shown: 100, up: if liked.contains(&at) { 30 } else { 0 }, down: 0 };
    let counts = ids.iter().enumerate().map(|(at, id)| (id.to_string(), count(at))).collect();
    sheep.tell(vec![Event::Votes { unit: "wall".to_owned(), sheep: counts }]);
    sheep.tell((0..ago).map(|brood| Event::Brood { brood: brood + 1, seed: 1 }).collect());
    (sheep.pool, ids)
}

fn dying(pool: &Pool) -> BTreeSet<Id> {
    deaths(pool, &Census::of(pool, pool.last_day())).ids.into_iter().collect()
}

#[test]
fn a_sheep_is_safe_until_the_second_brood_after_its_own() {
    let world = World::new(10);
    let deaths = [0, 1, 2].map(|ago| dying(&six(&[0], ago, &world).0).len());
    assert_eq!(deaths, [0, 0, 4]);
}

#[test]
fn the_best_of_a_niche_is_safe_while_it_is_liked_and_only_where_there_are_niches() {
    let world = World::new(10);
    let (mut pool, ids) = six(&[0, 1, 2], 2, &world);
    // Each of six is alone in its niche: those that are liked are safe, whatever the limit.
    assert_eq!(dying(&pool), ids[3..].iter().copied().collect());
    pool.settings.bins = 1;
    assert_eq!(dying(&pool).len(), 4);
}
