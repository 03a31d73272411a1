//! Breeding.
//!
//! Owns random plants, mutation and the four matings. What is bred is looked at, and made again if it is black, still or
//! strobing: up to 24 times; where all are, the one with the most contrast is taken, and who takes it into a pool looks
//! again.
//!
//! Start at [`Plant::mutated`] and [`Plant::crossed`].
//!
//! # Source
//! Sims, *Artificial Evolution for Computer Graphics* (1991), sections 3.2 and 3.3.

use species::{Breed, Child, Genome, Operator, Rng, Threads, UNCHANGED, descended};

use crate::colour::{of_hue, shown};
use crate::genes::{GENES, HUE, MANY};
use crate::genome::Plant;
use crate::look::{Look, has_no_fault};
use crate::motion::blended;
use crate::species::Plants;

/// How likely a gene mutates, at strength 1.
const MUTATES: f64 = 0.2;
/// How far, at most: twice the standard deviation.
const DISTANCE: f64 = 0.4;
/// How often what is not fair is made again.
const TRIES: usize = 24;
/// Names of mutations, and of matings.
const GENES_CHANGED: &str = "genes";
const SKY_CHANGED: &str = "sky";
const CHANCES_CHANGED: &str = "chances";
const EITHER: &str = "either";
const CROSSOVER: &str = "crossover";
const DISSOLVE: &str = "dissolve";
const FRACTIONS: &str = "fractions";

/// Mated this often.
const MATINGS: [(&str, f64); 4] = [(EITHER, 0.6), (CROSSOVER, 0.15), (DISSOLVE, 0.1), (FRACTIONS, 0.15)];

/// All operators.
const OPERATORS: &[Operator] = &[
    Operator::mutation(GENES_CHANGED, &["mutation"], "changes genes, and rarely the sky and the chances"),
    Operator::mutation(SKY_CHANGED, &[], "takes another sky"),
    Operator::mutation(CHANCES_CHANGED, &[], "takes other chances: the same genes grow into another plant"),
    Operator::crossing(EITHER, &[], "takes each gene from either parent"),
    Operator::crossing(CROSSOVER, &[], "takes the genes between two places from the other parent"),
    Operator::crossing(DISSOLVE, &[], "takes a plant between both, all genes by one fraction"),
    Operator::crossing(FRACTIONS, &[], "takes a plant between both, each gene by a fraction of its own"),
];

impl Plant {
    /// A plant at random. It may be black or still.
    pub fn random(rng: &mut Rng) -> Plant {
        // Means of two are rarely at the ends, where plants are odd.
        let mut genes: [f64; MANY] = std::array::from_fn(|_| 0.35 * (rng.unit() + rng.unit()) + 0.3 * rng.unit());
        // Leaves are red to green more often than blue.
        let (is_usual, hue) = (rng.unit() < 0.6, rng.unit());
        genes[HUE] = if is_usual { 0.04 + 0.4 * hue } else { hue };
        Plant { seed: rng.bits() >> 12, sky: random_sky(rng), genes, ..Plant::default() }
    }

    /// A mutant: every gene with the probability 0.2 times `strength` by a normal amount, clamped at 0 and 1, where hues
    /// go round; rarely the sky and the chances too.
    #[must_use]
    pub fn mutated(&self, strength: f64, rng: &mut Rng) -> Plant {
        let mut child = Plant { name: None, ..self.clone() };
        for (gene, number) in GENES.iter().zip(&mut child.genes) {
            let (is_hit, amount) = (rng.unit() < MUTATES * strength, 0.5 * DISTANCE * rng.normal());
            if is_hit {
                let moved = *number + amount.clamp(-DISTANCE, DISTANCE);
                *number = if gene.wraps { moved.rem_euclid(1.0) } else { moved.clamp(0.0, 1.0) };
            }
        }
        let (is_other_sky, sky) = (rng.unit() < 0.1 * strength, random_sky(rng));
        let (is_other_seed, seed) = (rng.unit() < 0.1 * strength, rng.bits() >> 12);
        if is_other_sky {
            child.sky = sky;
        }
        if is_other_seed {
            child.seed = seed;
        }
        child
    }

    /// A child by the mutation `name`; `None` if there is none of this name.
    fn mutated_by(&self, name: &str, strength: f64, rng: &mut Rng) -> Option<Plant> {
        let own = Plant { name: None, ..self.clone() };
        match name {
            GENES_CHANGED => Some(self.mutated(strength, rng)),
            SKY_CHANGED => Some(Plant { sky: random_sky(rng), ..own }),
            CHANCES_CHANGED => Some(Plant { seed: rng.bits() >> 12, ..own }),
            _ => None,
        }
    }

    /// A child of two plants, and which of the four matings made it.
    pub fn crossed(&self, other: &Plant, rng: &mut Rng) -> (Plant, &'static str) {
        let mut left = rng.unit();
        let way = MATINGS.iter().find(|(_, share)| {
            left -= share;
            left < 0.0
        });
        let (name, _) = way.unwrap_or(&MATINGS[0]);
        (self.crossed_by(name, other, rng), name)
    }

    /// A child of two plants by a mating of this name.
    fn crossed_by(&self, name: &str, other: &Plant, rng: &mut Rng) -> Plant {
        let [a, b] = [&self.genes, &other.genes];
        let genes: [f64; MANY] = match name {
            CROSSOVER => {
                // Two points of the sequence: from one to the other, genes are the second parent's.
                let [from, to] = [0, 1].map(|_| (rng.unit() * MANY as f64) as usize);
                let is_within = |place: usize| (from.min(to)..=from.max(to)).contains(&place);
                std::array::from_fn(|place| if is_within(place) { b[place] } else { a[place] })
            }
            DISSOLVE => wrapped(blended(a, b, rng.unit())),
            FRACTIONS => {
                let parts: [f64; MANY] = std::array::from_fn(|_| rng.unit());
                wrapped(std::array::from_fn(|place| blended(a, b, parts[place])[place]))
            }
            _ => std::array::from_fn(|place| if rng.unit() < 0.5 { a[place] } else { b[place] }),
        };
        let [sky, seed] = [0, 1].map(|_| if rng.unit() < 0.5 { self } else { other });
        Plant { name: None, seed: seed.seed, sky: sky.sky, genes, ..self.clone() }
    }
}

fn wrapped(mut genes: [f64; MANY]) -> [f64; MANY] {
    for (gene, number) in GENES.iter().zip(&mut genes) {
        if gene.wraps {
            *number = number.rem_euclid(1.0);
        }
    }
    genes
}

/// Skies: lightness, chroma and hue above, then at the horizon.
const SKIES: [[[f64; 3]; 2]; 8] = [
    // A warm dusk.
    [[0.25, 0.060, 0.73], [0.70, 0.095, 0.16]],
    // Before sunrise.
    [[0.21, 0.055, 0.74], [0.56, 0.055, 0.08]],
    // A clear night with a moon.
    [[0.15, 0.045, 0.72], [0.42, 0.060, 0.66]],
    // Green after rain.
    [[0.24, 0.040, 0.50], [0.62, 0.060, 0.33]],
    // Mist in the morning.
    [[0.46, 0.030, 0.65], [0.80, 0.035, 0.22]],
    // Gold.
    [[0.28, 0.055, 0.12], [0.70, 0.105, 0.21]],
    // The last violet.
    [[0.20, 0.060, 0.80], [0.52, 0.060, 0.92]],
    // Deep water.
    [[0.16, 0.045, 0.60], [0.48, 0.070, 0.53]],
];

fn random_sky(rng: &mut Rng) -> [[f64; 3]; 2] {
    let sky = SKIES[(rng.unit() * SKIES.len() as f64) as usize];
    let [light, hue] = [0.05 * rng.signed(), 0.04 * rng.signed()];
    sky.map(|[lightness, chroma, of]| of_hue(lightness + light, chroma, of + hue).map(|light| rounded(shown(light))))
}

/// A number as a person would write it.
fn rounded(light: f32) -> f64 {
    (f64::from(light) * 1000.0).round() / 1000.0
}

/// The first that is fair, or the one with the most contrast.
fn fair<T>(mut make: impl FnMut() -> (Plant, T)) -> (Plant, T) {
    // Without a thread what is seen at a few places must do.
    let threads = Threads::new(1).ok();
    let is_fair = |plant: &Plant, look: Look| {
        look.is_fair() && threads.as_ref().is_none_or(|threads| has_no_fault(plant, threads))
    };
    let mut best = make();
    let mut look = Look::of(&best.0);
    let mut found = is_fair(&best.0, look);
    for _ in 1..TRIES {
        if found {
            break;
        }
        let other = make();
        let seen = Look::of(&other.0);
        found = is_fair(&other.0, seen);
        if found || seen.contrast > look.contrast {
            (best, look) = (other, seen);
        }
    }
    best
}

impl Breed for Plants {
    fn operators(&self) -> &'static [Operator] {
        OPERATORS
    }

    fn random(&self, rng: &mut Rng) -> Box<dyn Genome> {
        Box::new(fair(|| (Plant::random(rng), ())).0)
    }

    fn mutate(&self, parent: &dyn Genome, strength: f64, rng: &mut Rng) -> Option<Child> {
        let own: &Plant = parent.as_any().downcast_ref()?;
        if strength <= 0.0 {
            return Some((Box::new(own.clone()), UNCHANGED));
        }
        self.apply(GENES_CHANGED, &[parent], strength, rng)
    }

    fn cross(&self, parents: [&dyn Genome; 2], rng: &mut Rng) -> Option<Child> {
        let [a, b] = parents.map(|parent| parent.as_any().downcast_ref::<Plant>());
        let (a, b) = (a?, b?);
        let (child, how) = fair(|| a.crossed(b, rng));
        Some(descended(&child, how, &parents))
    }

    fn apply(&self, name: &str, parents: &[&dyn Genome], strength: f64, rng: &mut Rng) -> Option<Child> {
        let operator = self.operator(name).filter(|operator| operator.parents == parents.len())?;
        let own: Option<Vec<&Plant>> = parents.iter().map(|parent| parent.as_any().downcast_ref()).collect();
        let child = match own?[..] {
            [a, b] => fair(|| (a.crossed_by(operator.name, b, rng), ())).0,
            [parent] => fair(|| (parent.mutated_by(operator.name, strength, rng).unwrap_or_default(), ())).0,
            _ => return None,
        };
        Some(descended(&child, operator.name, parents))
    }
}
