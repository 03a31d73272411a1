//! Breeding keeps the paper's numbers, and breeds nothing that is black, still or strobing.

#![allow(clippy::float_cmp, reason = "genes are inherited to the bit")]

use crate::grove::many;
use plant::{GENES, Look, MANY, Plant, Plants};
use species::{Breed, Genome, Rng};

fn with(number: f64) -> Plant {
    Plant { genes: [number; MANY], ..Plant::default() }
}

#[test]
fn a_fifth_of_the_genes_mutates_by_normal_amounts() {
    let (mut rng, parent) = (Rng::stream(1, 0), with(0.5));
    let (mut hit, mut sum, mut squares, children) = (0.0, 0.0, 0.0, 2000);
    for _ in 0..children {
        for number in parent.mutated(1.0, &mut rng).genes {
            let moved = number - 0.5;
            assert!(moved.abs() <= 0.4 && (0.0..=1.0).contains(&number));
            if moved != 0.0 {
                (hit, sum, squares) = (hit + 1.0, sum + moved, squares + moved * moved);
            }
        }
    }
    let rate = hit / f64::from(children * MANY as u32);
    let (mean, deviation) = (sum / hit, (squares / hit).sqrt());
    assert!((rate - 0.2).abs() < 0.01, "{rate}");
    assert!(mean.abs() < 0.01 && (deviation - 0.19).abs() < 0.012, "{mean} {deviation}");
    assert_eq!(parent.mutated(0.0, &mut rng).genes, parent.genes);
}

#[test]
fn genes_stop_at_their_ends_and_hues_go_round() {
    let mut rng = Rng::stream(2, 0);
    let children: Vec<Plant> = (0..600).map(|_| with(0.98).mutated(3.0, &mut rng)).collect();
    for (place, gene) in GENES.iter().enumerate() {
        let any = |wanted: &dyn Fn(f64) -> bool| children.iter().any(|child| wanted(child.genes[place]));
        assert_eq!(any(&|number| number == 1.0), !gene.wraps, "{}", gene.name);
        assert_eq!(any(&|number| number < 0.3), gene.wraps, "{}", gene.name);
    }
}

#[test]
fn the_four_matings_come_as_often_as_they_should_and_do_what_they_say() {
    let mut rng = Rng::stream(3, 0);
    let [a, b] = [with(0.2), with(0.6)];
    let mut counts = [0.0; 4];
    let tries = 4000;
    for _ in 0..tries {
        let (child, how) = a.crossed(&b, &mut rng);
        let genes = child.genes;
        let (is_pure, is_one) = (
            genes.iter().all(|gene| [0.2, 0.6].contains(gene)),
            genes.iter().all(|gene| (gene - genes[0]).abs() < 1e-12),
        );
        let changes = genes.windows(2).filter(|two| two[0] != two[1]).count();
        assert!(genes.iter().all(|gene| (0.2..=0.6).contains(gene)));
        let way = ["either", "crossover", "dissolve", "fractions"].iter().position(|name| *name == how).unwrap();
        counts[way] += 1.0 / f64::from(tries);
        match way {
            0 => assert!(is_pure),
            1 => assert!(is_pure && changes <= 2),
            2 => assert!(is_one),
            _ => assert!(!is_pure && !is_one),
        }
    }
    for (found, wanted) in counts.iter().zip([0.6, 0.15, 0.1, 0.15]) {
        assert!((found - wanted).abs() < 0.025, "{counts:?}");
    }
}

#[test]
fn what_is_bred_is_never_black_still_or_strobing() {
    let mut rng = Rng::stream(4, 0);
    let mut parents: Vec<Box<dyn Genome>> = Vec::new();
    for number in 0..many("GENOMES", 12) {
        let child = match (number % 3, parents.as_slice()) {
            (1, [.., parent]) => Plants.mutate(&**parent, 1.0, &mut rng).unwrap().0,
            (2, [.., a, b]) => Plants.cross([&**a, &**b], &mut rng).unwrap().0,
            _ => Plants.random(&mut rng),
        };
        let look = Look::of(child.as_any().downcast_ref().unwrap());
        assert!(look.is_fair(), "child {number}: {look:?}");
        parents.push(child);
    }
}

#[test]
fn the_same_numbers_breed_the_same_plant() {
    let breed = || {
        let mut rng = Rng::stream(5, 0);
        let [a, b] = [0, 1].map(|_| Plants.random(&mut rng));
        Plants.cross([&*a, &*b], &mut rng).unwrap().0.text()
    };
    assert_eq!(breed(), breed());
}
