//! A world of voters with a hidden taste.
//!
//! Owns genomes of 40 genes, the six figures that a fixed network makes of them, and how much they are liked. Never knows
//! the rules that breed them.
//!
//! Start at [`World::new`].

use std::collections::BTreeMap;

use breeding::{Birth, Id, Made, Nursery, Operation, Traits};
use species::Rng;

const GENES: usize = 40;
const GROUP: usize = 8;
const UNITS: usize = 24;
const FIGURES: usize = 6;
const PEAKS: usize = 3;
/// How far the peaks are from the middle, in standard deviations of a figure. With this and the median below, a tenth of
/// random genomes is liked more than 0.45, and a hundredth more than 0.68.
const REACH: f64 = 1.5;
/// The taste of the median random genome; the widths of the peaks follow.
const MEDIAN: f64 = 0.2;
/// Random genomes that percentiles are told by.
const RANDOM: usize = 2000;
/// The chance that a gene mutates, and by how much.
///
/// # Source
/// Sims, *Artificial Evolution for Computer Graphics*, SIGGRAPH 1991, section 3.2.
const MUTATIONS: f64 = 0.2;
const AMOUNT: f64 = 0.4;
/// The part of crossings that lie between both parents; in the others each group of genes is from one of them.
const BETWEEN: f64 = 0.15;

/// The genes of a sheep, each -1 to 1.
pub(crate) type Genes = [f64; GENES];

/// A world: a network and a taste, both by chance.
#[derive(Clone, Debug)]
pub(crate) struct World {
    hidden: Vec<Genes>,
    outputs: Vec<[f64; UNITS]>,
    peaks: [[f64; FIGURES]; PEAKS],
    width: f64,
    /// Tastes of random genomes, from the least.
    tastes: Vec<f64>,
    /// The mean distance of two random genomes' figures.
    distance: f64,
}

impl World {
    /// The world of a seed.
    pub(crate) fn new(seed: u64) -> World {
        let mut rng = Rng::stream(seed, 0);
        // Of genes that are evenly spread a unit then gets a sum of standard deviation 1.
        let scale = libm::sqrt(3.0 / GENES as f64);
        let hidden = (0..UNITS).map(|_| std::array::from_fn(|_| scale * rng.gaussian())).collect();
        let scale = libm::sqrt(1.0 / UNITS as f64);
        let outputs = (0..FIGURES).map(|_| std::array::from_fn(|_| scale * rng.gaussian())).collect();
        let mut world =
            World { hidden, outputs, peaks: Default::default(), width: 1.0, tastes: Vec::new(), distance: 1.0 };
        let random: Vec<[f64; FIGURES]> = (0..RANDOM).map(|_| world.figures_of(&World::random(&mut rng))).collect();
        let squares: f64 = random.iter().flatten().map(|figure| figure * figure).sum();
        let deviation = libm::sqrt(squares / (RANDOM * FIGURES) as f64);
        world.peaks = std::array::from_fn(|_| {
            let direction: [f64; FIGURES] = std::array::from_fn(|_| rng.gaussian());
            direction.map(|part| part * REACH * deviation)
        });
        let mut squares: Vec<f64> = random.iter().map(|figures| world.nearest(figures)).collect();
        squares.sort_unstable_by(|a, b| b.total_cmp(a));
        world.width = libm::sqrt(squares[RANDOM / 2] / (-2.0 * libm::log(MEDIAN)));
        world.tastes = squares.iter().map(|square| world.liking(*square)).collect();
        let traits: Vec<Traits> = random.iter().take(200).map(|figures| Traits::new(figures)).collect();
        world.distance = mean_distance(&traits.iter().collect::<Vec<_>>());
        world
    }

    /// Genes by chance.
    pub(crate) fn random(rng: &mut Rng) -> Genes {
        std::array::from_fn(|_| rng.signed())
    }

    /// How much a sheep is liked, 0 to 1.
    pub(crate) fn taste(&self, genes: &Genes) -> f64 {
        self.liking(self.nearest(&self.figures_of(genes)))
    }

    /// The part of random genomes that are liked less.
    pub(crate) fn percentile(&self, genes: &Genes) -> f64 {
        let taste = self.taste(genes);
        self.tastes.partition_point(|other| *other < taste) as f64 / self.tastes.len() as f64
    }

    /// The mean distance of sheep from each other, as a part of that of random ones.
    pub(crate) fn diversity(&self, sheep: &[&Traits]) -> f64 {
        mean_distance(sheep) / self.distance
    }

    /// The figures.
    pub(crate) fn figures(&self, genes: &Genes) -> Traits {
        Traits::new(&self.figures_of(genes))
    }

    fn figures_of(&self, genes: &Genes) -> [f64; FIGURES] {
        let sum = |weights: &[f64], values: &[f64]| weights.iter().zip(values).map(|(a, b)| a * b).sum::<f64>();
        let units: [f64; UNITS] = std::array::from_fn(|unit| libm::tanh(sum(&self.hidden[unit], genes)));
        std::array::from_fn(|figure| sum(&self.outputs[figure], &units))
    }

    /// The square of the distance to the nearest peak.
    fn nearest(&self, figures: &[f64; FIGURES]) -> f64 {
        let square = |peak: &[f64; FIGURES]| peak.iter().zip(figures).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        self.peaks.iter().map(square).fold(f64::MAX, f64::min)
    }

    fn liking(&self, square: f64) -> f64 {
        libm::exp(-square / (2.0 * self.width * self.width))
    }
}

fn mean_distance(sheep: &[&Traits]) -> f64 {
    let distance = |a: &Traits, b: &Traits| {
        libm::sqrt(a.values().iter().zip(b.values()).map(|(a, b)| (a - b) * (a - b)).sum::<f64>())
    };
    let pairs = sheep.iter().enumerate().flat_map(|(at, a)| sheep[..at].iter().map(move |b| distance(a, b)));
    let count = (sheep.len() * sheep.len().saturating_sub(1) / 2).max(1);
    pairs.sum::<f64>() / count as f64
}

/// A child of one parent.
pub(crate) fn mutated(parent: &Genes, strength: f64, rng: &mut Rng) -> Genes {
    parent.map(|gene| {
        let changes = rng.unit() < MUTATIONS;
        if changes { (gene + AMOUNT * strength * rng.gaussian()).clamp(-1.0, 1.0) } else { gene }
    })
}

/// A child of two parents.
pub(crate) fn crossed(parents: [&Genes; 2], rng: &mut Rng) -> Genes {
    if rng.unit() < BETWEEN {
        let part = 0.25 + 0.5 * rng.unit();
        return std::array::from_fn(|gene| parents[0][gene] * (1.0 - part) + parents[1][gene] * part);
    }
    let from: [usize; GENES / GROUP] = std::array::from_fn(|_| rng.below(2));
    std::array::from_fn(|gene| parents[from[gene / GROUP]][gene])
}

/// A world's sheep with their genes.
#[derive(Clone, Debug)]
pub(crate) struct Meadow<'a> {
    /// The world.
    pub(crate) world: &'a World,
    /// The genes of all sheep of the pool.
    pub(crate) genes: BTreeMap<Id, Genes>,
}

impl Nursery for Meadow<'_> {
    type Candidate = Genes;

    fn candidate(&self, birth: &Birth, rng: &mut Rng) -> Option<Made<Genes>> {
        let parents: Vec<&Genes> = birth.parents.iter().filter_map(|id| self.genes.get(id)).collect();
        let candidate = match (birth.operation, parents.as_slice()) {
            (Operation::Cross, [first, second]) => crossed([first, second], rng),
            (Operation::Mutation, [parent, ..]) => mutated(parent, birth.amount, rng),
            _ => World::random(rng),
        };
        Some(Made {
            candidate,
            operator: format!("{:?}", birth.operation).to_lowercase(),
            licence: "CC0-1.0".to_owned(),
        })
    }

    fn figures(&self, genes: &Genes) -> Result<Traits, Vec<String>> {
        Ok(self.world.figures(genes))
    }
}
