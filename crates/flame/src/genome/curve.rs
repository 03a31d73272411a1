//! Tone curves: one for all channels, then one for each.
//!
//! Owns both forms in which programs write them, the value of a curve, and what lies between two. Never touches a pixel:
//! `render` makes tables of them.
//!
//! Start at [`Curves::value`].

/// Places at which curves of two forms are compared.
const PLACES: usize = 257;

/// Halvings by which a place of a Bezier curve is found: to 1e-12 of it.
const HALVINGS: usize = 40;

/// Curves from 0 to 1, of all channels together, of red, of green and of blue.
#[derive(Clone, Debug, PartialEq)]
pub enum Curves {
    /// Rational cubic Bezier curves: each has four points `x y weight`.
    Bezier(Box<[[[f64; 3]; 4]; 4]>),
    /// Natural cubic splines through two points `x y` or more, whose x rise.
    Splines([Vec<[f64; 2]>; 4]),
}

impl Curves {
    /// Most points of a spline.
    pub(super) const MOST_POINTS: usize = 1000;

    /// Splines that change nothing.
    pub(super) fn straight() -> [Vec<[f64; 2]>; 4] {
        std::array::from_fn(|_| vec![[0.0; 2], [1.0; 2]])
    }

    /// Whether they change nothing: all points have equal coordinates.
    pub(super) fn is_straight(&self) -> bool {
        match self {
            Curves::Bezier(curves) => curves.as_flattened().iter().all(|[x, y, _]| x == y),
            Curves::Splines(curves) => curves.iter().flatten().all(|[x, y]| x == y),
        }
    }

    /// The values of curve `number` at `count` places from 0 to 1, each in `0.0..=1.0`.
    ///
    /// Before its first point and after its last one a curve is level.
    pub(crate) fn table(&self, number: usize, count: usize) -> Vec<f64> {
        let spline = match self {
            Curves::Bezier(_) => None,
            Curves::Splines(curves) => Some(Spline::new(&curves[number])),
        };
        let value = |place: usize| {
            let x = place as f64 / (count - 1) as f64;
            let y = match (self, &spline) {
                (Curves::Bezier(curves), _) => bezier(&curves[number], x),
                (Curves::Splines(_), Some(spline)) => spline.value(x),
                (Curves::Splines(_), None) => x,
            };
            if y > 0.0 { y.min(1.0) } else { 0.0 }
        };
        (0..count).map(value).collect()
    }

    /// What lies between two sets, linearly by `part`; `None` is straight.
    pub(super) fn mixed(from: Option<&Curves>, to: Option<&Curves>, part: f64) -> Option<Curves> {
        if from == to {
            return from.cloned();
        }
        let straight = Curves::Splines(Curves::straight());
        let [from, to] = [from, to].map(|curves| curves.unwrap_or(&straight));
        let mix = |number| {
            let [a, b] = [from, to].map(|curves| curves.points(number));
            let share_places = a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| a[0] == b[0]);
            let sampled = |curves: &Curves| {
                let place = |(place, y)| [place as f64 / (PLACES - 1) as f64, y];
                curves.table(number, PLACES).into_iter().enumerate().map(place).collect()
            };
            let [a, b]: [Vec<[f64; 2]>; 2] =
                if share_places && !a.is_empty() { [a, b] } else { [sampled(from), sampled(to)] };
            a.iter().zip(&b).map(|([x, a], [_, b])| [*x, a + (b - a) * part]).collect()
        };
        Some(Curves::Splines(std::array::from_fn(mix)))
    }

    /// The points of a spline; none of a Bezier curve.
    fn points(&self, number: usize) -> Vec<[f64; 2]> {
        match self {
            Curves::Bezier(_) => Vec::new(),
            Curves::Splines(curves) => curves[number].clone(),
        }
    }

    /// The memory that they take.
    pub(super) fn bytes(&self) -> usize {
        let points = match self {
            Curves::Bezier(_) => 0,
            Curves::Splines(curves) => curves.iter().map(|points| size_of_val(&points[..])).sum(),
        };
        size_of::<Curves>() + points
    }
}

/// The height of a Bezier curve at `x`: the point of the curve there is found by halving.
fn bezier(points: &[[f64; 3]; 4], x: f64) -> f64 {
    let at = |t: f64| {
        let s = 1.0 - t;
        let parts = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
        let sum = |of: &dyn Fn(&[f64; 3]) -> f64| points.iter().zip(parts).map(|(p, part)| of(p) * part).sum::<f64>();
        let weight = sum(&|point| point[2]);
        [sum(&|point| point[0] * point[2]) / weight, sum(&|point| point[1] * point[2]) / weight]
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if at(middle)[0] < x { low = middle } else { high = middle }
    }
    at(f64::midpoint(low, high))[1]
}

/// A natural cubic spline: its second derivative is 0 at both ends.
struct Spline<'a> {
    points: &'a [[f64; 2]],
    /// The second derivative at each point.
    bends: Vec<f64>,
}

impl Spline<'_> {
    fn new(points: &[[f64; 2]]) -> Spline<'_> {
        let count = points.len();
        let (mut bends, mut sweep) = (vec![0.0; count], vec![0.0; count]);
        let slope = |at: usize| (points[at + 1][1] - points[at][1]) / (points[at + 1][0] - points[at][0]);
        for at in 1..count.saturating_sub(1) {
            let [before, here, after] = [at - 1, at, at + 1].map(|at| points[at][0]);
            let part = (here - before) / (after - before);
            let divisor = part * sweep[at - 1] + 2.0;
            sweep[at] = (part - 1.0) / divisor;
            let bend = 6.0 * (slope(at) - slope(at - 1)) / (after - before);
            bends[at] = (bend - part * bends[at - 1]) / divisor;
        }
        for at in (0..count.saturating_sub(1)).rev() {
            bends[at] += sweep[at] * bends[at + 1];
        }
        Spline { points, bends }
    }

    fn value(&self, x: f64) -> f64 {
        let next = self.points.partition_point(|point| point[0] <= x);
        let (Some(before), Some(after)) = (next.checked_sub(1), self.points.get(next)) else {
            return self.points[next.saturating_sub(1).min(self.points.len() - 1)][1];
        };
        let [start, from] = self.points[before];
        let [end, to] = *after;
        let width = end - start;
        let (a, b) = ((end - x) / width, (x - start) / width);
        let bent = (a * a * a - a) * self.bends[before] + (b * b * b - b) * self.bends[next];
        a * from + b * to + bent * width * width / 6.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn splines(points: &[[f64; 2]]) -> Curves {
        let mut curves = Curves::straight();
        curves[0] = points.to_vec();
        Curves::Splines(curves)
    }

    fn bezier_of(points: [[f64; 3]; 4]) -> Curves {
        Curves::Bezier(Box::new([points; 4]))
    }

    #[test]
    fn a_spline_goes_through_its_points_and_bends_as_a_natural_one() {
        let curves = splines(&[[0.0, 0.0], [0.5, 0.8], [1.0, 1.0]]);
        let table = curves.table(0, 1001);
        assert!([(0, 0.0), (500, 0.8), (1000, 1.0)].iter().all(|(at, y)| (table[*at] - y).abs() < 1e-12));
        // By hand: the bend at the middle is 3 (0.2 - 0.8) / 0.25 / 2 = -3.6.
        let due = 0.4 + (0.125 - 0.5) * -3.6 * 0.25 / 6.0;
        assert!((table[250] - due).abs() < 1e-12, "{} is not {due}", table[250]);
        let level = splines(&[[0.2, 0.3], [0.6, 0.9]]).table(0, 11);
        assert!((level[0] - 0.3).abs() < 1e-12 && (level[10] - 0.9).abs() < 1e-12, "{level:?}");
        assert!(splines(&[[0.0, 0.0], [0.1, 1.0], [0.2, 0.0], [1.0, 1.0]]).table(0, 99).iter().all(|y| *y >= 0.0));
    }

    #[test]
    fn a_bezier_curve_gives_the_height_over_a_place_not_that_of_its_parameter() {
        let straight = bezier_of([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 1.0]]);
        assert!(straight.is_straight());
        for (at, y) in straight.table(2, 101).iter().enumerate() {
            assert!((y - at as f64 / 100.0).abs() < 1e-9, "{at}: {y}");
        }
        // With x = t it is the polynomial itself, here 3 s t² + t³.
        let bent = bezier_of([[0.0, 0.0, 1.0], [1.0 / 3.0, 0.0, 1.0], [2.0 / 3.0, 1.0, 1.0], [1.0, 1.0, 1.0]]);
        assert!((bent.table(1, 5)[1] - (3.0 * 0.75 * 0.0625 + 0.015_625)).abs() < 1e-9);
        let heavy = bezier_of([[0.0, 0.0, 1.0], [0.0, 1.0, 9.0], [0.0, 1.0, 9.0], [1.0, 1.0, 1.0]]);
        assert!(heavy.table(0, 11)[1] > 0.9);
    }

    #[test]
    fn between_two_sets_of_curves_every_value_is_between_theirs() {
        let a = splines(&[[0.0, 0.0], [0.5, 0.8], [1.0, 1.0]]);
        let b = bezier_of([[0.0, 0.2, 1.0], [0.5, 0.0, 1.0], [0.5, 0.3, 2.0], [1.0, 0.7, 1.0]]);
        for (from, to) in [(Some(&a), Some(&b)), (None, Some(&a)), (Some(&b), None)] {
            for part in [0.0, 0.25, 1.0] {
                let found = Curves::mixed(from, to, part).unwrap().table(0, 64);
                let straight = Curves::Splines(Curves::straight());
                let [from, to] = [from, to].map(|curves| curves.unwrap_or(&straight).table(0, 64));
                for (at, y) in found.iter().enumerate() {
                    let due = from[at] + (to[at] - from[at]) * part;
                    assert!((y - due).abs() < 2e-4, "{part}, {at}: {y} is not {due}");
                }
            }
        }
        assert_eq!(Curves::mixed(Some(&b), Some(&b), 0.3), Some(b));
        assert_eq!(Curves::mixed(None, None, 0.3), None);
    }
}
