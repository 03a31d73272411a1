//! What comes of breeding.

use std::collections::BTreeMap;

use crate::bred;
use expression::{FUNCTIONS, Genome, Mating, Mutation, Node};
use species::Rng;

/// Random genomes of 8 to 60 nodes.
fn parents() -> impl Iterator<Item = Genome> {
    (0..)
        .map(|seed| Genome::random(&mut Rng::stream(seed, 3)))
        .filter(|genome| (8..=60).contains(&genome.picture.size()))
}

#[test]
fn growing_is_no_likelier_than_shrinking() {
    const CHILDREN: usize = 20_000;
    let mut rng = Rng::stream(9, 0);
    let (mut grown, mut shrunk, mut untouched) = (0, 0, 0);
    for parent in parents().take(CHILDREN) {
        let (child, mutations) = parent.mutated(1.0, &mut rng);
        let (before, after) = (parent.picture.size(), child.picture.size());
        grown += usize::from(after > before);
        shrunk += usize::from(after < before);
        untouched += usize::from(mutations.is_empty());
    }
    let part = |of: usize| of as f64 / CHILDREN as f64;
    let (grown, shrunk, untouched) = (part(grown), part(shrunk), part(untouched));
    println!("{grown} grow, {shrunk} shrink, {untouched} untouched");
    assert!((0.20..=0.26).contains(&grown) && (grown..=0.30).contains(&shrunk), "{grown} grow, {shrunk} shrink");
    assert!((0.19..=0.25).contains(&untouched), "{untouched} have no mutation");
}

#[test]
fn sixty_generations_without_selection_do_not_grow() {
    let parents: Vec<Genome> = parents().take(300).collect();
    let mean = |genomes: &[Genome]| genomes.iter().map(|genome| genome.picture.size()).sum::<usize>() as f64 / 300.0;
    let mut rng = Rng::stream(4, 0);
    let mut children = parents.clone();
    for _ in 0..60 {
        children = children.iter().map(|parent| parent.mutated(1.0, &mut rng).0).collect();
    }
    println!("{} {}", mean(&parents), mean(&children));
    assert!(mean(&children) <= mean(&parents), "{} {}", mean(&parents), mean(&children));
}

#[test]
fn every_mutation_and_every_function_comes_up() {
    let mut rng = Rng::stream(2, 0);
    let mut seen: BTreeMap<String, u32> = BTreeMap::new();
    for parent in parents().take(4000) {
        for mutation in parent.mutated(1.0, &mut rng).1 {
            *seen.entry(format!("{mutation:?}")).or_default() += 1;
        }
        for node in parent.picture.all() {
            if let Node::Call(function, _) = node {
                *seen.entry(function.name.to_owned()).or_default() += 1;
            }
        }
    }
    let all = [
        Mutation::New,
        Mutation::Adjusted,
        Mutation::AdjustedVector,
        Mutation::OtherFunction,
        Mutation::Wrapped,
        Mutation::Unwrapped,
        Mutation::Copied,
    ];
    assert!(all.iter().all(|mutation| seen[&format!("{mutation:?}")] > 100), "{seen:?}");
    assert!(FUNCTIONS.iter().all(|function| seen.get(function.name).is_some_and(|count| *count > 20)), "{seen:?}");
}

#[test]
fn what_is_bred_may_be_read_and_is_the_same_for_the_same_seed() {
    for seed in 0..400 {
        let genome = bred::genome(seed);
        assert_eq!(genome, bred::genome(seed));
        assert_eq!(Genome::parse(&genome.to_string()).as_ref(), Ok(&genome), "{genome}");
    }
}

#[test]
fn relatives_are_walked_together_and_strangers_grafted() {
    let mut rng = Rng::stream(6, 0);
    let parent = Genome::from(Node::parse("(+ (sin (* x 3)) (cos (- y z)))").unwrap());
    let sibling = Genome::from(Node::parse("(+ (sin (* x 5)) (cos (- y x)))").unwrap());
    let stranger = Genome::from(Node::parse("(vector x y (abs x))").unwrap());
    let walked = |with: &Genome, rng: &mut Rng| {
        let matings = (0..2000).map(|_| parent.crossed(with, rng).unwrap().1);
        matings.filter(|mating| *mating == Mating::Walked).count()
    };
    assert!((700..900).contains(&walked(&sibling, &mut rng)));
    assert_eq!(walked(&stranger, &mut rng), 0);
}
