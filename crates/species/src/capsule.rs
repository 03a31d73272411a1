//! The stroke that lines are drawn of.
//!
//! Owns the shape between two circles, how far a point is from it, and how much of a pixel it covers. Never adds light.
//!
//! Start at [`Capsule::coverage`].

/// All that lies within two circles and between their common tangents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// The middles of the circles, in pixels.
    pub ends: [[f32; 2]; 2],
    /// Their radii in pixels, >= 0.
    pub radii: [f32; 2],
}

impl Capsule {
    /// The distance of `point` from its edge in pixels, negative inside.
    ///
    /// # Source
    /// Inigo Quilez, *2D distance functions*: the uneven capsule.
    #[inline]
    pub fn distance(&self, point: [f32; 2]) -> f32 {
        let [from, to] = self.ends;
        let [first, last] = self.radii;
        let (along, across) = ([to[0] - from[0], to[1] - from[1]], [point[0] - from[0], point[1] - from[1]]);
        let square = along[0] * along[0] + along[1] * along[1];
        let length = square.sqrt();
        let slope = first - last;
        let to_first = || (across[0] * across[0] + across[1] * across[1]).sqrt() - first;
        // One circle holds the other.
        if length <= slope.abs() {
            let across = [point[0] - to[0], point[1] - to[1]];
            return if slope >= 0.0 {
                to_first()
            } else {
                (across[0] * across[0] + across[1] * across[1]).sqrt() - last
            };
        }
        let x = (across[0] * along[1] - across[1] * along[0]).abs() / length;
        let y = (across[0] * along[0] + across[1] * along[1]) / length;
        let sine = slope / length;
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        let place = y * cosine - x * sine;
        if place < 0.0 {
            (x * x + y * y).sqrt() - first
        } else if place > length * cosine {
            (x * x + (y - length) * (y - length)).sqrt() - last
        } else {
            x * cosine + y * sine - first
        }
    }

    /// The part of the pixel around `point` that it covers, `0.0..=1.0`, by a ramp of one pixel across its edge; thinner
    /// ones than a pixel cover as much less.
    #[inline]
    pub fn coverage(&self, point: [f32; 2]) -> f32 {
        let edge = (0.5 - self.distance(point)).clamp(0.0, 1.0);
        let widest = 2.0 * self.radii[0].max(self.radii[1]);
        edge.min(widest)
    }

    /// Its least and greatest coordinates, `margin` pixels wider: `[[left, top], [right, bottom]]`.
    pub fn bounds(&self, margin: f32) -> [[f32; 2]; 2] {
        let [from, to] = self.ends;
        let [first, last] = self.radii.map(|radius| radius + margin);
        [
            [0, 1].map(|axis| (from[axis] - first).min(to[axis] - last)),
            [0, 1].map(|axis| (from[axis] + first).max(to[axis] + last)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_is_that_to_the_nearest_of_all_circles_between_the_ends() {
        let capsules = [
            Capsule { ends: [[0.0, 0.0], [10.0, 0.0]], radii: [2.0, 2.0] },
            Capsule { ends: [[1.0, 2.0], [-7.0, 9.0]], radii: [3.0, 0.5] },
            Capsule { ends: [[1.0, 2.0], [1.5, 2.0]], radii: [3.0, 0.5] },
            Capsule { ends: [[1.0, 2.0], [1.5, 2.0]], radii: [0.5, 3.0] },
            Capsule { ends: [[4.0, 4.0], [4.0, 4.0]], radii: [1.0, 1.0] },
        ];
        for capsule in capsules {
            for at in 0..400 {
                let point = [(at % 20) as f32 - 9.7, (at / 20) as f32 - 7.3];
                let [from, to] = capsule.ends;
                let circle = |part: f32| {
                    let [x, y] = [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * part - point[axis]);
                    (x * x + y * y).sqrt() - (capsule.radii[0] + (capsule.radii[1] - capsule.radii[0]) * part)
                };
                let nearest = (0..=2000).map(|step| circle(step as f32 / 2000.0)).fold(f32::MAX, f32::min);
                let found = capsule.distance(point);
                assert!((found - nearest).abs() < 0.01, "{capsule:?} {point:?}: {found} {nearest}");
                let [low, high] = capsule.bounds(0.5);
                let is_within = (0..2).all(|axis| (low[axis]..=high[axis]).contains(&point[axis]));
                assert!(is_within || capsule.coverage(point) == 0.0, "{capsule:?} {point:?} is out of bounds");
            }
        }
    }

    #[test]
    fn a_thin_line_covers_as_much_as_it_is_wide() {
        for width in [0.1, 0.4, 1.0, 3.0] {
            let line = Capsule { ends: [[0.3, -100.0], [0.3, 100.0]], radii: [width / 2.0; 2] };
            let sum: f32 = (-20..20).map(|column| line.coverage([column as f32, 0.0])).sum();
            assert!((sum - width).abs() < 0.16 * width.max(0.6), "{width}: {sum}");
        }
    }
}
