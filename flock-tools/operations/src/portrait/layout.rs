//! The positions of sheep in the drawing of their flock.
//!
//! Owns the layout: neighbours near each other, the others apart, and little change when a transition is added or removed.
//! Weights, shares and the order of the manifest have no effect. Never draws.
//!
//! Every sheep is pulled to an anchor, a function of its id alone, smoothed over its neighbours. A stress layout lacks that:
//! without it one more transition turns or folds the whole picture.
//!
//! Start at [`places`].

use std::collections::VecDeque;

/// A point of the plane.
pub type Point = [f64; 2];

/// The weight of a sheep's own anchor in the smoothing, against one neighbour; and the size of flock in which it is twice
/// that, because there one transition is a large part of all.
const OWN: f64 = 0.5;
const FEW: f64 = 20.0;
/// Sweeps of the smoothing.
const SWEEPS: usize = 80;
/// The weight of the smoothed anchor, against all distances together.
const PULL: f64 = 0.5;
/// Rounds of the stress layout.
const ROUNDS: usize = 30;
/// The distance of the smoothed anchors from the middle, against the mean distance.
const SPREAD: f64 = 0.55;
/// Rounds of pushing sheep apart, and their distance then: 1 would fill the plane as a grid does.
const ROOM_ROUNDS: usize = 30;
const ROOM: f64 = 0.8;
/// The edge of the picture, in standard deviations from the middle.
const EDGE: f64 = 1.7;
/// The most that the drawing may be stretched in one direction against the other to fill the picture.
const STRETCH: f64 = 1.6;
/// The most sheep for which the distances between all pairs are computed: 8 MB, and a second.
const MOST_IN_PAIRS: usize = 2000;

/// The positions of the sheep `ids`, from -1 to 1 along each axis.
///
/// * `pairs`: those that a transition joins, in either direction.
///
/// # Source
/// Gansner, Koren & North, *Graph Drawing by Stress Majorization* (2004); the pull towards anchors is ours.
pub fn places(ids: &[&str], pairs: &[(usize, usize)]) -> Vec<Point> {
    let neighbours = neighbours(ids.len(), pairs);
    let own: Vec<Point> = ids.iter().map(|id| own_place(id)).collect();
    let mut at = smoothed(&neighbours, &own);
    rounded(&mut at);
    if ids.len() <= MOST_IN_PAIRS {
        let hops = Hops::of(&neighbours);
        at = stretched(&hops, &at);
        make_room(&mut at);
    }
    centred(&mut at);
    for p in &mut at {
        *p = inside(*p);
    }
    fill(&mut at);
    at
}

fn neighbours(n: usize, pairs: &[(usize, usize)]) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new(); n];
    for &(a, b) in pairs.iter().filter(|(a, b)| a != b) {
        all[a].push(b);
        all[b].push(a);
    }
    for list in &mut all {
        list.sort_unstable();
        list.dedup();
    }
    all
}

/// A point in the unit circle, a function of `id`.
pub fn own_place(id: &str) -> Point {
    let mut numbers = Numbers::of(id);
    loop {
        let at = [2.0 * numbers.next() - 1.0, 2.0 * numbers.next() - 1.0];
        if at[0] * at[0] + at[1] * at[1] < 1.0 {
            return at;
        }
    }
}

/// Random numbers from 0 up to 1, a function of a text: its FNV-1a hash seeds `SplitMix64`.
pub(super) struct Numbers(u64);

impl Numbers {
    pub(super) fn of(text: &str) -> Self {
        let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3);
        Self(text.bytes().fold(0xCBF2_9CE4_8422_2325, step))
    }

    pub(super) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// The `own` anchors, each moved between its own and those of its neighbours.
fn smoothed(neighbours: &[Vec<usize>], own: &[Point]) -> Vec<Point> {
    let mut at = own.to_vec();
    let keeps = OWN * (1.0 + FEW / own.len().max(1) as f64);
    for _ in 0..SWEEPS {
        for (sheep, near) in neighbours.iter().enumerate() {
            let weight = keeps + near.len() as f64;
            at[sheep] = [0, 1].map(|axis| {
                let pulled: f64 = near.iter().map(|&other| at[other][axis]).sum();
                (keeps * own[sheep][axis] + pulled) / weight
            });
        }
    }
    at
}

/// Moves the middle to the origin and stretches the cloud until it is as wide in every direction.
fn rounded(at: &mut [Point]) {
    centre(at);
    let moment = |a: usize, b: usize| at.iter().map(|p| p[a] * p[b]).sum::<f64>() / at.len().max(1) as f64;
    // One sheep, or sheep on a line, have no width in some direction: they stay.
    let (xx, xy, yy) = (moment(0, 0) + 1e-9, moment(0, 1), moment(1, 1) + 1e-9);
    // The square root of the 2x2 matrix of moments, by Cayley and Hamilton; what follows applies its inverse.
    let root = (xx * yy - xy * xy).max(1e-18).sqrt();
    let trace = (xx + yy + 2.0 * root).sqrt();
    let (a, b, d) = ((xx + root) / trace, xy / trace, (yy + root) / trace);
    let det = a * d - b * b;
    for p in at {
        *p = [(d * p[0] - b * p[1]) / det, (a * p[1] - b * p[0]) / det];
    }
}

fn centre(at: &mut [Point]) {
    let count = at.len().max(1) as f64;
    let mean = [0, 1].map(|axis| at.iter().map(|p| p[axis]).sum::<f64>() / count);
    for p in at {
        *p = [p[0] - mean[0], p[1] - mean[1]];
    }
}

/// Moves the middle to the origin and makes the mean square distance from it 1.
fn centred(at: &mut [Point]) {
    centre(at);
    let mean = at.iter().map(|p| p[0] * p[0] + p[1] * p[1]).sum::<f64>() / at.len().max(1) as f64;
    if mean > 0.0 {
        let scale = 1.0 / mean.sqrt();
        for p in at {
            *p = [scale * p[0], scale * p[1]];
        }
    }
}

/// The number of transitions between any two sheep, in either direction.
struct Hops {
    n: usize,
    between: Vec<u16>,
    most: u16,
}

impl Hops {
    fn of(neighbours: &[Vec<usize>]) -> Self {
        let n = neighbours.len();
        let mut between = vec![u16::MAX; n * n];
        let mut queue = VecDeque::new();
        for (from, row) in between.chunks_mut(n.max(1)).enumerate() {
            row[from] = 0;
            queue.push_back(from);
            while let Some(here) = queue.pop_front() {
                for &next in &neighbours[here] {
                    if row[next] == u16::MAX {
                        row[next] = row[here] + 1;
                        queue.push_back(next);
                    }
                }
            }
        }
        // Sheep that are not connected are one step further apart than any that are.
        let most = between.iter().copied().filter(|&hops| hops != u16::MAX).max().unwrap_or(0) + 1;
        for hops in &mut between {
            *hops = most.min(*hops);
        }
        Self { n, between, most }
    }

    fn mean(&self) -> f64 {
        self.between.iter().map(|&hops| f64::from(hops)).sum::<f64>() / self.between.len().max(1) as f64
    }
}

/// Positions whose distances are near to `hops`, pulled to `anchors`.
fn stretched(hops: &Hops, anchors: &[Point]) -> Vec<Point> {
    let spread = SPREAD * hops.mean();
    let anchors: Vec<Point> = anchors.iter().map(|p| [spread * p[0], spread * p[1]]).collect();
    let weights: Vec<f64> = (0..=hops.most).map(|hops| 1.0 / f64::from(hops.max(1)).powi(2)).collect();
    let total: Vec<f64> =
        hops.between.chunks(hops.n.max(1)).map(|row| row.iter().map(|&hops| weights[hops as usize]).sum()).collect();
    let mut at = anchors.clone();
    for _ in 0..ROUNDS {
        let mut sum: Vec<Point> = anchors.iter().zip(&total).map(|(p, w)| [PULL * w * p[0], PULL * w * p[1]]).collect();
        for a in 0..hops.n {
            for b in 0..a {
                let wished = hops.between[a * hops.n + b];
                let (dx, dy) = (at[a][0] - at[b][0], at[a][1] - at[b][1]);
                let longer = f64::from(wished) / (dx * dx + dy * dy).sqrt().max(1e-9);
                let weight = weights[wished as usize];
                sum[a] = [sum[a][0] + weight * (at[b][0] + longer * dx), sum[a][1] + weight * (at[b][1] + longer * dy)];
                sum[b] = [sum[b][0] + weight * (at[a][0] - longer * dx), sum[b][1] + weight * (at[a][1] - longer * dy)];
            }
        }
        // `total` has the weight of a sheep with itself, `sum` has not.
        at = sum.iter().zip(&total).map(|(s, w)| [s[0], s[1]].map(|s| s / (w - weights[0] + PULL * w))).collect();
    }
    at
}

/// Pushes sheep apart that are too close.
fn make_room(at: &mut [Point]) {
    centred(at);
    let room = ROOM * (std::f64::consts::PI * 2.0 / at.len().max(1) as f64).sqrt();
    for _ in 0..ROOM_ROUNDS {
        let mut push = vec![[0.0; 2]; at.len()];
        for a in 0..at.len() {
            for b in 0..a {
                let (dx, dy) = (at[a][0] - at[b][0], at[a][1] - at[b][1]);
                let squared = dx * dx + dy * dy;
                if squared < room * room {
                    let distance = squared.sqrt();
                    // Two sheep at one point are pushed sideways.
                    let (ux, uy) = if distance > 1e-6 { (dx / distance, dy / distance) } else { (1.0, 0.0) };
                    let part = 0.25 * (room - distance);
                    push[a] = [push[a][0] + part * ux, push[a][1] + part * uy];
                    push[b] = [push[b][0] - part * ux, push[b][1] - part * uy];
                }
            }
        }
        for (p, push) in at.iter_mut().zip(push) {
            *p = [p[0] + push[0], p[1] + push[1]];
        }
    }
}

/// Pulls in sheep that are far out, so that they do not make all the others small; the middle hardly changes.
fn inside(p: Point) -> Point {
    let far = (p[0] * p[0] + p[1] * p[1]) / (EDGE * EDGE);
    let shrunk = EDGE * (1.0 + far * far).sqrt().sqrt();
    [p[0] / shrunk, p[1] / shrunk]
}

/// Stretches the drawing until it touches all four sides, or as nearly as [`STRETCH`] allows.
fn fill(at: &mut [Point]) {
    let extent = |axis: usize| {
        let ends =
            at.iter().map(|p| p[axis]).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
        (f64::midpoint(ends.0, ends.1), (ends.1 - ends.0) / 2.0)
    };
    let (x, y) = (extent(0), extent(1));
    let scales = [x.1.max(y.1 / STRETCH), y.1.max(x.1 / STRETCH)];
    if scales[0] > 0.0 {
        for p in at {
            *p = [(p[0] - x.0) / scales[0], (p[1] - y.0) / scales[1]];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flock for the drawing: ids, and who leads to whom.
    struct Drawn {
        name: &'static str,
        ids: Vec<String>,
        pairs: Vec<(usize, usize)>,
    }

    impl Drawn {
        /// Every sheep leads to the next and to `more` that `chosen` picks, a function of the sheep and a random number.
        fn new(name: &'static str, n: usize, more: usize, chosen: impl Fn(usize, f64) -> usize) -> Self {
            let mut numbers = Numbers::of(name);
            let mut pairs = Vec::new();
            for sheep in 0..n {
                pairs.push((sheep, (sheep + 1) % n));
                pairs.extend((0..more).map(|_| (sheep, chosen(sheep, numbers.next()) % n)));
            }
            Self { name, ids: (0..n).map(|sheep| format!("{name}.{sheep:05}")).collect(), pairs }
        }

        fn places(&self) -> Vec<Point> {
            let ids: Vec<&str> = self.ids.iter().map(String::as_str).collect();
            places(&ids, &self.pairs)
        }
    }

    fn flocks() -> Vec<Drawn> {
        vec![
            Drawn::new("seven", 7, 1, |_, random| (random * 7.0) as usize),
            Drawn::new("fifty", 50, 3, |_, random| (random * 50.0) as usize),
            Drawn::new("large", 300, 3, |_, random| (random * 300.0) as usize),
            Drawn::new("parts", 160, 3, |sheep, random| sheep / 20 * 20 + (random * 20.0) as usize),
            Drawn::new("ring", 60, 1, |sheep, _| sheep + 2),
        ]
    }

    fn distance(a: Point, b: Point) -> f64 {
        ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).sqrt()
    }

    fn median(mut values: Vec<f64>) -> f64 {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    }

    fn diameter(at: &[Point]) -> f64 {
        at.iter().flat_map(|&a| at.iter().map(move |&b| distance(a, b))).fold(0.0, f64::max)
    }

    #[test]
    fn one_more_transition_leaves_the_drawing_as_it_was() {
        for flock in flocks() {
            let (before, n) = (flock.places(), flock.ids.len());
            let mut numbers = Numbers::of("more");
            let mut any = || ((numbers.next() * n as f64) as usize, (numbers.next() * n as f64) as usize);
            let strangers = std::iter::from_fn(|| Some(any()))
                .filter(|&(a, b)| a != b && !flock.pairs.contains(&(a, b)) && !flock.pairs.contains(&(b, a)));
            let moved = strangers.take(12).map(|pair| {
                let mut pairs = flock.pairs.clone();
                pairs.push(pair);
                let after = Drawn { name: flock.name, ids: flock.ids.clone(), pairs }.places();
                median(before.iter().zip(&after).map(|(&a, &b)| distance(a, b)).collect()) / diameter(&before)
            });
            let moved: Vec<f64> = moved.collect();
            let worst = moved.iter().copied().fold(0.0, f64::max);
            println!(
                "{}: the median sheep moves {:.2} %, {:.2} % at worst",
                flock.name,
                100.0 * median(moved.clone()),
                100.0 * worst
            );
            // In a flock of seven, one transition more is one in fifteen.
            let few = 0.5 / n as f64;
            assert!(median(moved) < 0.03 + few, "{}: the median sheep moves too far", flock.name);
            assert!(worst < 0.06 + few, "{}: the median sheep moves {worst} diameters", flock.name);
        }
    }

    #[test]
    fn one_more_sheep_leaves_the_others_where_they_were() {
        for mut flock in flocks().into_iter().skip(1) {
            let before = flock.places();
            let new = flock.ids.len();
            flock.ids.push("new".into());
            flock.pairs.extend([(3, new), (new, 9)]);
            let moved = median(before.iter().zip(flock.places()).map(|(&a, b)| distance(a, b)).collect());
            assert!(moved < 0.04 * diameter(&before), "{}: {moved}", flock.name);
        }
    }

    #[test]
    fn neighbours_are_nearer_than_the_others_and_nobody_stands_on_another() {
        for flock in flocks() {
            let at = flock.places();
            let joined =
                median(flock.pairs.iter().filter(|(a, b)| a != b).map(|&(a, b)| distance(at[a], at[b])).collect());
            let all: Vec<f64> =
                (0..at.len()).flat_map(|a| (0..a).map(move |b| (a, b))).map(|(a, b)| distance(at[a], at[b])).collect();
            let closest = all.iter().copied().fold(f64::INFINITY, f64::min);
            println!("{}: joined {joined:.3}, all {:.3}, closest {closest:.4}", flock.name, median(all.clone()));
            assert!(joined < 0.95 * median(all), "{}: {joined}", flock.name);
            assert!(closest > 0.3 / (at.len() as f64).sqrt(), "{}: {closest}", flock.name);
        }
    }

    #[test]
    fn every_place_is_in_the_picture_whatever_the_flock() {
        let lonely = Drawn { name: "one", ids: vec!["a".into()], pairs: vec![(0, 0)] };
        let twins = Drawn { name: "two", ids: vec!["a".into(), "b".into()], pairs: vec![(0, 1), (1, 0)] };
        let apart = Drawn { name: "apart", ids: (0..40).map(|n| format!("s{n}")).collect(), pairs: vec![] };
        let many = Drawn::new("many", 2001, 2, |_, random| (random * 2001.0) as usize);
        let none = Drawn { name: "none", ids: vec![], pairs: vec![] };
        for flock in flocks().into_iter().chain([lonely, twins, apart, many, none]) {
            for p in flock.places() {
                assert!(p.iter().all(|c| c.abs() <= 1.0 + 1e-9), "{}: {p:?}", flock.name);
            }
        }
    }
}
