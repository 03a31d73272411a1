//! Which transform of one genome becomes which of another.
//!
//! Owns the distance between two transforms and the choice of the pairs that are nearest on the whole. Never interpolates.
//!
//! Start at [`Pairing::new`].

use pathfinding::kuhn_munkres::kuhn_munkres_min;
use pathfinding::matrix::Matrix;

use crate::genome::{Affine, Genome, Xform};
use variations::Variation;

/// How much each difference counts; each is from 0 to 1.
const BY_VARIATIONS: f64 = 1.0;
const BY_AFFINE: f64 = 0.7;
const BY_TURNING: f64 = 0.5;
const BY_COLOUR: f64 = 0.4;
const BY_WEIGHT: f64 = 0.3;

/// Steps of a distance of 1: distances are compared as whole numbers.
const STEPS: f64 = 1e6;

/// Pairs of transforms, and the order of those of each genome.
#[derive(Clone, Debug)]
pub(super) struct Pairing {
    /// The numbers of all pairs as the one genome has its transforms, and as the other has: those that it lacks at the end.
    orders: [Vec<usize>; 2],
}

impl Pairing {
    /// Pairs the transforms of two genomes, and returns them so ordered that partners have the same number.
    pub(super) fn new([from, to]: [Genome; 2]) -> ([Genome; 2], Pairing) {
        let places = partners(&from.xforms, &to.xforms);
        let mut partner_of = vec![None; from.xforms.len()];
        for (number, place) in places.iter().enumerate().filter(|(_, place)| **place < from.xforms.len()) {
            partner_of[*place] = Some(number);
        }
        let mut ends: Vec<[Option<usize>; 2]> =
            partner_of.iter().enumerate().map(|(number, partner)| [Some(number), *partner]).collect();
        ends.sort_by_key(|[_, partner]| partner.is_none());
        let alone = places.iter().enumerate().filter(|(_, place)| **place >= from.xforms.len());
        ends.extend(alone.map(|(number, _)| [None, Some(number)]));
        let order = |side: usize| {
            let mut order: Vec<usize> = (0..ends.len()).collect();
            order.sort_by_key(|pair| (ends[*pair][side].is_none(), ends[*pair][side]));
            order
        };
        let numbers = |side: usize| ends.iter().filter_map(|pair| pair[side]).collect::<Vec<_>>();
        let sorted = |genome: Genome, numbers: &[usize]| Genome { xforms: reordered(genome.xforms, numbers), ..genome };
        let pair = [sorted(from, &numbers(0)), sorted(to, &numbers(1))];
        (pair, Pairing { orders: [order(0), order(1)] })
    }

    /// All pairs in the order of the one genome, or `late` in that of the other.
    pub(super) fn ordered(&self, xforms: Vec<Xform>, late: bool) -> Vec<Xform> {
        reordered(xforms, &self.orders[usize::from(late)])
    }
}

/// `xforms` in another order: number `numbers[i]` becomes number `i`.
fn reordered(xforms: Vec<Xform>, numbers: &[usize]) -> Vec<Xform> {
    if numbers.iter().enumerate().all(|(new, old)| new == *old) {
        return xforms;
    }
    let moved = |number: &usize| {
        let xform = xforms[*number].clone();
        let chaos = |after: &usize| xform.chaos.get(*after).copied().unwrap_or(1.0);
        let chaos = if xform.chaos.is_empty() { Vec::new() } else { numbers.iter().map(chaos).collect() };
        Xform { chaos, ..xform }
    };
    numbers.iter().map(moved).collect()
}

/// For each transform of `to`, the place of its partner among those of `from`, or a place after them: each place once,
/// so that the sum of distances is least. Genomes of more transforms than can be rendered are paired by their order.
pub(super) fn partners(from: &[Xform], to: &[Xform]) -> Vec<usize> {
    let most = from.len().max(to.len());
    if from.is_empty() || to.is_empty() || most > Genome::MAX_XFORMS {
        return (0..to.len()).collect();
    }
    let (few, many) = if from.len() <= to.len() { (from, to) } else { (to, from) };
    let (few_sum, many_sum) = (weights(few), weights(many));
    let distances = Matrix::from_fn(few.len(), many.len(), |(row, column)| {
        let share = (few[row].weight / few_sum - many[column].weight / many_sum).abs();
        // Equals are paired by their order.
        (distance(&few[row], &many[column], share) * STEPS) as i64 + row.abs_diff(column) as i64
    });
    let (_, columns) = kuhn_munkres_min(&distances);
    if from.len() > to.len() {
        return columns;
    }
    let mut places: Vec<Option<usize>> = vec![None; to.len()];
    for (place, column) in columns.into_iter().enumerate() {
        places[column] = Some(place);
    }
    let mut next = from.len();
    let mut new_place = || {
        next += 1;
        next - 1
    };
    places.into_iter().map(|place| place.unwrap_or_else(&mut new_place)).collect()
}

/// The sum of the weights, at least a little.
fn weights(xforms: &[Xform]) -> f64 {
    xforms.iter().map(|xform| xform.weight.max(0.0)).sum::<f64>().max(f64::MIN_POSITIVE)
}

/// How unlike two transforms are, whose weights are apart by `share` of all.
fn distance(a: &Xform, b: &Xform, share: f64) -> f64 {
    let turning = if (a.animate == 0.0) == (b.animate == 0.0) { 0.0 } else { 1.0 };
    let affine = apart(&a.affine, &b.affine) + 0.5 * apart(&a.post, &b.post);
    BY_VARIATIONS * variations_apart(a, b)
        + BY_AFFINE * affine / (1.0 + affine)
        + BY_TURNING * turning
        + BY_COLOUR * (a.color - b.color).abs().min(1.0)
        + BY_WEIGHT * share.min(1.0)
}

/// The distance of the images of a unit square, per corner.
fn apart(a: &Affine, b: &Affine) -> f64 {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
    let between = corners.map(|(x, y)| {
        let ((ax, ay), (bx, by)) = (a.apply(x, y), b.apply(x, y));
        libm::hypot(ax - bx, ay - by)
    });
    between.iter().sum::<f64>() / 4.0
}

/// The part of the weights of variations that only one of both has.
fn variations_apart(a: &Xform, b: &Xform) -> f64 {
    let weight = |xform: &Xform, slot| {
        let of_kind = xform.variations.iter().filter(|variation| variation.slot() == slot);
        of_kind.map(|variation| variation.weight).sum::<f64>()
    };
    let sum = |xform: &Xform| xform.variations.iter().map(|variation| variation.weight.abs()).sum::<f64>();
    let mut slots: Vec<_> = a.variations.iter().chain(&b.variations).map(Variation::slot).collect();
    slots.sort();
    slots.dedup();
    let unlike: f64 = slots.into_iter().map(|slot| (weight(a, slot) - weight(b, slot)).abs()).sum();
    let all = sum(a) + sum(b);
    if all > 0.0 { (unlike / all).min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn xforms(text: &str) -> Vec<Xform> {
        Genome::parse(&format!("<flame>{text}</flame>")).unwrap().xforms
    }

    #[test]
    fn like_is_paired_with_like() {
        let swirl = r#"<xform weight="1" color="0" coefs="0.5 0 0 0.5 0.4 0" swirl="1"/>"#;
        let julia = r#"<xform weight="1" color="1" coefs="0.9 0.1 -0.1 0.9 0 0" julia="1"/>"#;
        let linear = r#"<xform weight="0.3" color="0.5" animate="0" coefs="-1 0 0 1 0 0" linear="1"/>"#;
        let from = xforms(&[swirl, julia, linear].concat());
        assert_eq!(partners(&from, &xforms(&[linear, swirl, julia].concat())), [2, 0, 1]);
        assert_eq!(partners(&from, &xforms(&[julia, linear].concat())), [1, 2]);
        assert_eq!(partners(&xforms(julia), &from), [1, 0, 2], "what has no partner comes after the others");
        assert_eq!(partners(&xforms(&[swirl, swirl].concat()), &xforms(&[swirl, swirl].concat())), [0, 1]);
    }

    #[test]
    fn odd_numbers_and_many_transforms_are_paired_somehow() {
        let odd = xforms(r#"<xform weight="1e308" coefs="1e308 1e308 1e308 1e308 0 0" linear="1e308"/><xform/>"#);
        let mut places = partners(&odd, &xforms("<xform/><xform/><xform weight=\"-1\"/>"));
        places.sort_unstable();
        assert_eq!(places, [0, 1, 2]);
        let many = vec![Xform::default(); 20_000];
        assert_eq!(partners(&many, &many).len(), 20_000);
    }
}
