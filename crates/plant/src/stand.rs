//! A stand of plants: one genome, grown eleven times, from the front to the haze.
//!
//! Owns the composition: where stems are, how far away, how large, and in which order parts are drawn. Never knows pixels.
//!
//! Start at [`Stand::of`].

use crate::chance::Chance;
use crate::genes::Habit;
use crate::growth::{Seedling, grown};
use crate::skeleton::{MOST_PARTS, Skeleton};
use crate::vector::between;

/// A place for a stem.
struct Site {
    /// From the left edge to the right one, `-1.0..=1.0`.
    across: f64,
    /// Of the tallest stem's.
    height: f64,
    lean: f64,
    /// How much of it is lost in the haze.
    haze: f64,
    /// Where its foot is, in heights of the picture.
    foot: f64,
    /// Of all parts.
    budget: f64,
}

/// From the back to the front.
const SITES: [Site; 11] = [
    Site { across: -1.04, height: 0.66, lean: -0.06, haze: 0.66, foot: -0.03, budget: 0.035 },
    Site { across: 1.02, height: 0.70, lean: 0.06, haze: 0.62, foot: -0.03, budget: 0.035 },
    Site { across: 0.30, height: 0.80, lean: 0.05, haze: 0.55, foot: -0.04, budget: 0.05 },
    Site { across: -0.44, height: 0.74, lean: -0.05, haze: 0.5, foot: -0.04, budget: 0.05 },
    Site { across: 0.70, height: 0.80, lean: 0.16, haze: 0.2, foot: -0.08, budget: 0.16 },
    Site { across: -0.76, height: 0.88, lean: -0.14, haze: 0.12, foot: -0.1, budget: 0.18 },
    Site { across: -0.06, height: 1.08, lean: 0.02, haze: 0.0, foot: -0.14, budget: 0.34 },
    Site { across: 0.34, height: 0.44, lean: 0.22, haze: 0.05, foot: -0.08, budget: 0.04 },
    Site { across: -0.36, height: 0.40, lean: -0.2, haze: 0.03, foot: -0.08, budget: 0.04 },
    Site { across: 1.0, height: 0.42, lean: 0.05, haze: 0.0, foot: -0.09, budget: 0.035 },
    Site { across: -1.02, height: 0.38, lean: -0.05, haze: 0.0, foot: -0.09, budget: 0.035 },
];
/// How high the tallest plant is, in heights of the picture.
const TALL: f64 = 0.93;
/// How wide all may be, in widths of the picture.
const WIDE: f64 = 1.0;

/// Where a stem is, in heights of the picture: x from the middle, y from the lower edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foot {
    pub(crate) x: f64,
    pub(crate) y: f64,
    /// Of a length of the skeleton.
    pub(crate) scale: f64,
}

/// A part of the skeleton.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Part {
    Bone(u32),
    Leaf(u32),
}

/// One genome's plants.
#[derive(Clone, Debug)]
pub(crate) struct Stand {
    pub(crate) habit: Habit,
    pub(crate) skeleton: Skeleton,
    /// The box of every stem when it is grown up: left, bottom, right, top.
    whole: Vec<[f64; 4]>,
    /// What is drawn, and how near it is; the nearest last.
    pub(crate) order: Vec<(f64, Part)>,
}

impl Stand {
    /// The plants of a habit, grown up.
    pub(crate) fn of(habit: Habit, chance: Chance) -> Stand {
        Stand::grown(habit, chance, [1.0; 2], None)
    }

    /// The same plants `vigour` of the way from the seed, with `budget` of all parts that may be; they stand where these do.
    pub(crate) fn withdrawn(&self, chance: Chance, vigour: f64, budget: f64) -> Stand {
        Stand::grown(self.habit, chance, [vigour, budget], Some(&self.whole))
    }

    /// The plants of a habit between two others; they stand between where those do, `part` of the way.
    pub(crate) fn between([from, to]: [&Stand; 2], part: f64, habit: Habit, chance: Chance) -> Stand {
        let boxes = from.whole.iter().zip(&to.whole);
        let whole: Vec<[f64; 4]> =
            boxes.map(|(a, b)| std::array::from_fn(|side| between(a[side], b[side], part))).collect();
        Stand::grown(habit, chance, [1.0; 2], Some(&whole))
    }

    fn grown(habit: Habit, chance: Chance, [vigour, budget]: [f64; 2], whole: Option<&[[f64; 4]]>) -> Stand {
        let seedlings = SITES.each_ref().map(|site| Seedling {
            place: (site.across * 64.0) as i64 as u64 ^ 0x5eed,
            length: site.height,
            lean: site.lean,
            budget: site.budget * budget * MOST_PARTS as f64,
        });
        let skeleton = grown(&habit, chance, &seedlings, vigour);
        let whole = whole.map_or_else(|| skeleton.boxes.clone(), <[_]>::to_vec);
        let mut order = Vec::with_capacity(skeleton.parts());
        // Plants lie behind each other, parts of one plant are sorted.
        let near = |stem: u8, z: f64| 8.0 * f64::from(stem) + z.clamp(-3.9, 3.9);
        for (number, bone) in skeleton.bones.iter().enumerate() {
            let z = bone.start[2] + 0.5 * bone.length * bone.direction[2];
            order.push((near(bone.stem, z), Part::Bone(number as u32)));
        }
        for (number, leaf) in skeleton.leaves.iter().enumerate() {
            let z = leaf.start[2] + 0.5 * leaf.length * leaf.direction[2];
            // A leaf is in front of the twig that it grows on.
            order.push((near(leaf.stem, z + 0.004), Part::Leaf(number as u32)));
        }
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        Stand { habit, skeleton, whole, order }
    }

    /// How much of a stem is lost in the haze.
    pub(crate) fn haze(stem: u8) -> f64 {
        SITES[stem as usize].haze
    }

    /// Where the stems are in a picture of this width, in heights: so that all that may be seen is.
    pub(crate) fn feet(&self, aspect: f64) -> Vec<Foot> {
        let tallest = self.whole.iter().zip(&SITES).map(|(bounds, site)| bounds[3] / (TALL - site.foot));
        let tallest = tallest.fold(0.0, f64::max);
        let widest = self.whole.iter().map(|bounds| bounds[2] - bounds[0]).fold(0.0, f64::max);
        // The lesser of both scales, without a bend where they are equal.
        let steep = |scale: f64| scale * scale * scale * scale;
        let inverse = steep(tallest) + steep(widest / (WIDE * aspect));
        let scale = 1.0 / inverse.sqrt().sqrt();
        let room = (0.5 * WIDE * aspect - 0.32 * scale * widest).max(0.2 * aspect);
        self.whole
            .iter()
            .zip(&SITES)
            .map(|(bounds, site)| {
                let middle = 0.5 * (bounds[0] + bounds[2]);
                Foot {
                    x: site.across * room - 0.6 * scale * middle,
                    y: site.foot - (scale * bounds[1]).min(0.0),
                    scale,
                }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::genes::MANY;
    use species::Rng;

    #[test]
    fn no_genes_whatever_grow_more_parts_than_may_be() {
        let mut rng = Rng::stream(1, 0);
        let mut most = 0;
        for _ in 0..60 {
            // Every gene at one of its ends.
            let genes: [f64; MANY] = std::array::from_fn(|_| f64::from(u8::from(rng.unit() < 0.5)));
            let chance = Chance::of(rng.bits());
            let stand = Stand::of(Habit::of(&genes), chance);
            let share = rng.unit();
            let withdrawn = stand.withdrawn(chance, share, share);
            assert!(stand.skeleton.parts() <= MOST_PARTS && !stand.skeleton.leaves.is_empty());
            assert!(withdrawn.skeleton.parts() as f64 <= share * MOST_PARTS as f64);
            most = most.max(stand.skeleton.parts());
        }
        assert!(most > MOST_PARTS / 4, "only {most} of them are ever used");
    }
}
