//! Transitions from one sheep to another meet both, and are worth seeing.
//!
//! Owns claims on pairs, within a species and between two.

use std::collections::BTreeSet;

use species::{Dissolve, Genome, Image, Light, Middle, Motion, Threads, expected};

use super::joins::{FRAMES, allowed, severity};
use super::sheep::{LOOP, SIZE, TRANSITION, genome, picture, turning};
use super::{SPECIES, genomes, many, tried};

/// Less contrast, as a part of what is expected, is dull; and the part of transitions that may be dull.
const LEAST_CONTRAST: f64 = 0.6;
const DULL: f64 = 0.1;

/// What is found on many transitions.
#[derive(Debug, Default)]
struct Found {
    transitions: u32,
    /// By what is expected at each moment between what both loops have then.
    dull_on_the_way: u32,
    /// By the mean of the ends.
    dull_half_way: u32,
    worst_join: f64,
}

fn dissolved(pair: [&dyn Genome; 2]) -> Box<dyn Motion> {
    Box::new(Dissolve::new(pair.map(turning), TRANSITION))
}

/// The least contrast on a transition, as a part of what is expected between what both loops have at that moment.
fn contrast(transition: &dyn Motion, sides: [&dyn Motion; 2], threads: &Threads) -> f64 {
    let of = |motion: &dyn Motion, frame: f64| Light::of_motion(motion, frame, SIZE, threads).unwrap().contrast;
    let at = |moment: u32| {
        let frame = (TRANSITION * f64::from(moment) / 9.0).floor();
        let ends = [of(sides[0], frame), of(sides[1], frame - TRANSITION)];
        of(transition, frame) / expected(ends, frame / TRANSITION).max(1e-6)
    };
    (1..9).map(at).fold(f64::INFINITY, f64::min)
}

impl Found {
    /// Looks at the transition between two genomes, and at both its joins.
    fn add(&mut self, pair: [&dyn Genome; 2], transition: &dyn Motion, threads: &Threads) {
        let sides = pair.map(turning);
        for (side, at, frames) in [(0, 0.0, "leaves"), (1, TRANSITION, "reaches")] {
            let [end, own] = [picture(transition, at, threads), picture(&*sides[side], 0.0, threads)];
            assert!(end == own, "the transition {frames} something else than {}", pair[side].text());
            let inside = |frame: f64| picture(transition, frame, threads);
            let outside = |frame: f64| picture(&*sides[side], frame, threads);
            let count = FRAMES as u32;
            let around: Vec<Image> = if side == 0 {
                let before = (1..=count).rev().map(|frame| outside(LOOP - f64::from(frame)));
                before.chain((0..count).map(|frame| inside(f64::from(frame)))).collect()
            } else {
                let before = (1..=count).rev().map(|frame| inside(TRANSITION - f64::from(frame)));
                before.chain((0..count).map(|frame| outside(f64::from(frame)))).collect()
            };
            let mut found = severity(&around);
            if found >= 1.0 {
                found /= allowed(&*sides[side], threads);
            }
            assert!(found < 1.0, "{found} of what is allowed where the transition {frames} {}", pair[side].text());
            self.worst_join = self.worst_join.max(found);
        }
        self.transitions += 1;
        self.dull_on_the_way += u32::from(contrast(transition, [&*sides[0], &*sides[1]], threads) < LEAST_CONTRAST);
        let middle = Middle::of(transition, TRANSITION, SIZE, threads).unwrap();
        self.dull_half_way += u32::from(middle.contrast < LEAST_CONTRAST);
    }

    fn judge(&self, what: &str) {
        println!("{what}: {self:?}");
        let most = DULL * f64::from(self.transitions);
        assert!(f64::from(self.dull_on_the_way.max(self.dull_half_way)) <= most, "{what}: {self:?}");
    }
}

#[test]
fn a_transition_within_a_species_meets_both_loops_in_value_and_in_speed() {
    let threads = Threads::new(0).unwrap();
    for species in tried() {
        let (mut found, mut own) = (Found::default(), 0);
        for seed in 0..many("PAIRS", genomes(species).min(4)) {
            let from = genome(species, 2 * seed);
            // Every second pair is of one family.
            let to = if seed.is_multiple_of(2) {
                species.mutate(&*from, 1.0, &mut species::Rng::stream(seed, 32)).unwrap().0
            } else {
                genome(species, 2 * seed + 1)
            };
            let transition = from.transition(&*to, SIZE, [LOOP; 2], TRANSITION);
            own += u32::from(transition.is_some());
            found.add([&*from, &*to], &*transition.unwrap_or_else(|| dissolved([&*from, &*to])), &threads);
        }
        found.judge(&format!("{}, of which {own} are made of genomes", species.name()));
    }
}

#[test]
fn any_two_species_join_without_a_jump() {
    let threads = Threads::new(0).unwrap();
    let (mut found, mut seen) = (Found::default(), BTreeSet::new());
    let kinds = SPECIES.len();
    let pairs: Vec<[usize; 2]> =
        (0..kinds).flat_map(|from| (0..kinds).filter(move |to| *to != from).map(move |to| [from, to])).collect();
    for seed in 0..many("PAIRS", pairs.len() as u64) {
        let [from, to] = pairs[seed as usize % pairs.len()];
        // Other genomes in every round of the pairs of species: no pair comes twice.
        let round = seed / pairs.len() as u64;
        let pair = [genome(SPECIES[from], 500 + round), genome(SPECIES[to], 900 + round)];
        assert!(seen.insert(pair.each_ref().map(|genome| genome.text())), "the same pair twice, {seed}");
        assert!(pair[0].transition(&*pair[1], SIZE, [LOOP; 2], TRANSITION).is_none());
        let pair = [&*pair[0], &*pair[1]];
        found.add(pair, &*dissolved(pair), &threads);
    }
    found.judge("between species");
}
