//! The 21 genes of a plant.
//!
//! Owns the one table of genes: their names, what they do, and the quantity that 0 to 1 stands for. Never draws.
//!
//! Start at [`GENES`].
//!
//! # Source
//! Karl Sims, *Artificial Evolution for Computer Graphics* (1991), section 3: genes are numbers from 0 to 1, used with a
//! scale, an offset and sometimes a power.

/// How many genes a plant has.
pub const MANY: usize = 21;

/// A gene. Its number `g`, 0 to 1, stands for `low + (high - low) * g^power`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gene {
    /// Its key in a file.
    pub name: &'static str,
    /// What it does, and in which unit.
    pub meaning: &'static str,
    /// What 0 stands for.
    pub low: f64,
    /// What 1 stands for.
    pub high: f64,
    /// 1 is even; over 1, small quantities are likelier.
    pub power: f64,
    /// Its number in files that do not name it.
    pub default: f64,
    /// Whether 1 is 0 again.
    pub wraps: bool,
}

/// The place of `hue` in the table.
pub(crate) const HUE: usize = 17;

/// All genes, in the order of crossovers.
pub const GENES: [Gene; MANY] = [
    even("depth", "orders of branches, the stem included", 2.0, 3.8, 0.6),
    curved("segments", "nodes of a branch that have shoots", 4.0, 16.0, 1.4, 0.45),
    curved("branching", "shoots at a node", 1.0, 3.2, 1.6, 0.45),
    even("angle", "between a shoot and its branch, degrees", 18.0, 84.0, 0.45),
    even("angle_spread", "how far shoots stray from that, degrees", 0.0, 26.0, 0.35),
    even("divergence", "between one shoot and the next, around the branch, degrees", 90.0, 180.0, 0.53),
    even("length_ratio", "of a shoot to its branch", 0.44, 0.86, 0.5),
    even("radius_ratio", "of a shoot to its branch", 0.34, 0.8, 0.45),
    even("taper", "radius at the end of a branch, of that at its start", 0.4, 0.04, 0.6),
    even("gravity", "how far branches bend down, or up where it is negative", -0.9, 1.1, 0.4),
    even("curl", "how far branches bend to the side that looks up, radians", -1.1, 1.7, 0.5),
    even("bud_delay", "where on a branch the first shoot is", 0.03, 0.36, 0.35),
    even("tip_dominance", "1: shoots near the start are the longest; 0: those near the end", 0.0, 1.0, 0.55),
    even("chance", "how much is left to chance", 0.08, 1.0, 0.4),
    curved("leaf_size", "length of a leaf, of the stem's", 0.04, 0.17, 1.6, 0.5),
    even("leaf_shape", "width of a leaf, of its length", 0.14, 0.85, 0.4),
    even("leaf_density", "leaves of a twig", 4.0, 24.0, 0.5),
    Gene { wraps: true, ..even("hue", "hue of the leaves, turns", 0.0, 1.0, 0.36) },
    even("hue_range", "how far the hue goes from old to young leaves, turns", -0.24, 0.24, 0.3),
    even("sway", "how far wind bends a stem, radians", 0.13, 0.36, 0.5),
    even("sway_lag", "how late outer parts follow, radians", 0.3, 3.6, 0.5),
];

const fn even(name: &'static str, meaning: &'static str, low: f64, high: f64, default: f64) -> Gene {
    curved(name, meaning, low, high, 1.0, default)
}

const fn curved(name: &'static str, meaning: &'static str, low: f64, high: f64, power: f64, default: f64) -> Gene {
    Gene { name, meaning, low, high, power, default, wraps: false }
}

/// The quantities that the genes of a plant stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Habit {
    pub(crate) depth: f64,
    pub(crate) segments: f64,
    pub(crate) branching: f64,
    /// Radians.
    pub(crate) angle: f64,
    /// Radians.
    pub(crate) angle_spread: f64,
    /// Radians.
    pub(crate) divergence: f64,
    pub(crate) length_ratio: f64,
    pub(crate) radius_ratio: f64,
    pub(crate) taper: f64,
    pub(crate) gravity: f64,
    pub(crate) curl: f64,
    pub(crate) bud_delay: f64,
    pub(crate) tip_dominance: f64,
    pub(crate) chance: f64,
    pub(crate) leaf_size: f64,
    pub(crate) leaf_shape: f64,
    pub(crate) leaf_density: f64,
    /// Turns.
    pub(crate) hue: f64,
    /// Turns.
    pub(crate) hue_range: f64,
    pub(crate) sway: f64,
    pub(crate) sway_lag: f64,
}

impl Habit {
    pub(crate) fn of(genes: &[f64; MANY]) -> Habit {
        let quantities: [f64; MANY] = std::array::from_fn(|place| GENES[place].quantity(genes[place]));
        let [depth, segments, branching, angle, angle_spread, divergence, length_ratio, ..] = quantities;
        let [
            ..,
            radius_ratio,
            taper,
            gravity,
            curl,
            bud_delay,
            tip_dominance,
            chance,
            leaf_size,
            leaf_shape,
            leaf_density,
            hue,
            hue_range,
            sway,
            sway_lag,
        ] = quantities;
        Habit {
            depth,
            segments,
            branching,
            angle: angle.to_radians(),
            angle_spread: angle_spread.to_radians(),
            divergence: divergence.to_radians(),
            length_ratio,
            radius_ratio,
            taper,
            gravity,
            curl,
            bud_delay,
            tip_dominance,
            chance,
            leaf_size,
            leaf_shape,
            leaf_density,
            hue,
            hue_range,
            sway,
            sway_lag,
        }
    }
}

impl Gene {
    /// What its number `g` stands for.
    pub fn quantity(&self, g: f64) -> f64 {
        let part = if self.power == 1.0 { g } else { libm::pow(g.max(0.0), self.power) };
        self.low + (self.high - self.low) * part
    }
}
