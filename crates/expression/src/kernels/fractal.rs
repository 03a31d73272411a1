//! Fractals: iterated function systems and Julia sets.
//!
//! Owns both iterations. They go step by step over a few samples at once, so that each step becomes vector instructions.
//!
//! Start at [`ifs`].
//!
//! # Source
//! Distance by inverse maps after Hart, *Computer Rendering of Fractal Curves and Surfaces* (1989); the smooth count is the
//! usual one of Vepstas.

use std::f32::consts::LOG2_E;

use crate::math::{ln, settled};

/// Samples that go through the steps together.
const LANES: usize = 16;
const IFS_STEPS: usize = 12;
const ESCAPE_STEPS: usize = 32;
/// A point that is so far away, squared, does not come back.
const ESCAPED: f32 = 64.0;

/// Reads a few samples of an array, 0 after its end.
#[inline(always)]
fn few(array: &[f32], from: usize) -> [f32; LANES] {
    let mut few = [0.0; LANES];
    let end = array.len().min(from + LANES);
    few[..end - from].copy_from_slice(&array[from..end]);
    few
}

/// One of the two maps, inverted, for each of a few samples: its matrix, and by how much lengths shrink.
struct Inverse {
    matrix: [[f32; LANES]; 4],
    from: [[f32; LANES]; 2],
    shrinks: [f32; LANES],
}

impl Inverse {
    #[inline(always)]
    fn of([a, b, c, d, e, f]: [[f32; LANES]; 6]) -> Inverse {
        let mut inverse = Inverse { matrix: [[0.0; LANES]; 4], from: [e, f], shrinks: [0.0; LANES] };
        for lane in 0..LANES {
            let determinant = a[lane] * d[lane] - b[lane] * c[lane];
            let by = settled(1.0 / determinant);
            inverse.matrix[0][lane] = d[lane] * by;
            inverse.matrix[1][lane] = -b[lane] * by;
            inverse.matrix[2][lane] = -c[lane] * by;
            inverse.matrix[3][lane] = a[lane] * by;
            inverse.shrinks[lane] = determinant.abs().sqrt();
        }
        inverse
    }

    #[inline(always)]
    fn point(&self, lane: usize, x: f32, y: f32) -> [f32; 2] {
        let (x, y) = (x - self.from[0][lane], y - self.from[1][lane]);
        let [a, b, c, d] = [0, 1, 2, 3].map(|number| self.matrix[number][lane]);
        [settled(a * x + b * y), settled(c * x + d * y)]
    }
}

/// How near a sample is to the attractor of two maps, 1 on it and towards 0 away from it; of u, v, twice a b c d e f, the
/// centre, the size and how fast it darkens.
///
/// Each step goes back by the map that leads nearer to the origin; the distance is that of the last point, shrunk by all
/// maps on the way.
#[inline(always)]
pub(super) fn ifs(arguments: &[&[f32]], out: &mut [f32]) {
    for from in (0..out.len()).step_by(LANES) {
        let of = |number: usize| few(arguments[number], from);
        let (center_x, center_y, size, darkens) = (of(14), of(15), of(16), of(17));
        let maps = [2, 8].map(|first| Inverse::of([0, 1, 2, 3, 4, 5].map(|number| of(first + number))));
        let (mut x, mut y, mut scale) = (of(0), of(1), [1.0_f32; LANES]);
        for lane in 0..LANES {
            x[lane] = settled((x[lane] - center_x[lane]) / size[lane]);
            y[lane] = settled((y[lane] - center_y[lane]) / size[lane]);
        }
        for _ in 0..IFS_STEPS {
            for lane in 0..LANES {
                let [first, second] = [0, 1].map(|map: usize| maps[map].point(lane, x[lane], y[lane]));
                let is_second =
                    second[0] * second[0] + second[1] * second[1] < first[0] * first[0] + first[1] * first[1];
                x[lane] = if is_second { second[0] } else { first[0] };
                y[lane] = if is_second { second[1] } else { first[1] };
                scale[lane] *= if is_second { maps[1].shrinks[lane] } else { maps[0].shrinks[lane] };
            }
        }
        for (lane, out) in out[from..].iter_mut().take(LANES).enumerate() {
            let distance = settled((x[lane] * x[lane] + y[lane] * y[lane]).sqrt() * scale[lane]);
            *out = settled(1.0 / (1.0 + distance * darkens[lane].abs()));
        }
    }
}

/// How long a point stays near the origin under z^2 + c, from 0 to 1 for those that stay 32 steps, without steps between;
/// of u, v and both parts of c.
#[inline(always)]
pub(super) fn escape(arguments: [&[f32]; 4], out: &mut [f32]) {
    for from in (0..out.len()).step_by(LANES) {
        let [mut x, mut y, re, im] = arguments.map(|argument| few(argument, from));
        let mut count = [0.0_f32; LANES];
        for _ in 0..ESCAPE_STEPS {
            for lane in 0..LANES {
                let is_near = x[lane] * x[lane] + y[lane] * y[lane] < ESCAPED;
                let next = [x[lane] * x[lane] - y[lane] * y[lane] + re[lane], 2.0 * x[lane] * y[lane] + im[lane]];
                x[lane] = if is_near { next[0] } else { x[lane] };
                y[lane] = if is_near { next[1] } else { y[lane] };
                count[lane] += if is_near { 1.0 } else { 0.0 };
            }
        }
        for (lane, out) in out[from..].iter_mut().take(LANES).enumerate() {
            let square = (x[lane] * x[lane] + y[lane] * y[lane]).max(ESCAPED);
            // 0 where it has just escaped, 1 where the next step would have escaped as well.
            let beyond = ln(ln(square) / ln(ESCAPED)) * LOG2_E;
            *out = settled((count[lane] - beyond).max(0.0) / ESCAPE_STEPS as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_is_the_julia_set_of_zero_and_the_count_has_no_steps() {
        let u: Vec<f32> = (0..1000).map(|at| 0.5 + at as f32 * 0.0015).collect();
        let zero = vec![0.0; u.len()];
        let mut out = vec![0.0; u.len()];
        escape([&u, &zero, &zero, &zero], &mut out);
        assert!(u.iter().zip(&out).all(|(u, count)| (*u < 1.0) == (*count >= 1.0)));
        assert!(u.windows(2).zip(out.windows(2)).all(|(u, pair)| u[0] < 1.1 || (pair[1] - pair[0]).abs() < 0.01));
    }

    #[test]
    fn two_maps_that_halve_towards_two_points_have_the_line_between_as_attractor() {
        let line = |u: f32, v: f32| {
            let numbers = [u, v, 0.5, 0.0, 0.0, 0.5, -0.5, 0.0, 0.5, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 0.0, 1.0, 10.0];
            let arrays = numbers.map(|number| [number]);
            let arguments: Vec<&[f32]> = arrays.iter().map(|array| &array[..]).collect();
            let mut out = [0.0];
            ifs(&arguments, &mut out);
            out[0]
        };
        for u in [-0.9, -0.3, 0.0, 0.21, 0.7] {
            assert!(line(u, 0.0) > 0.98, "{u}: {}", line(u, 0.0));
            assert!((line(u, 0.5) - 1.0 / 6.0).abs() < 0.02, "{u}: {}", line(u, 0.5));
        }
    }
}
