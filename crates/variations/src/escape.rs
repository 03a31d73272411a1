//! Escape-time fractals of other programs: points anywhere in a rectangle, kept by how long they stay near the origin.
//!
//! Owns the count of steps and the choice of a point. Orbits of the plane alone: the orbit of the flame is never looked at.
//!
//! # Source
//! What `JWildfire` gives for chosen random numbers: places, heights and colours.

use super::formulas::colours;
use crate::number::{Mask, Number};

/// The square of the distance from which on an orbit has escaped.
const ESCAPED: f64 = 4.0;

/// How many times as many points as in JWildfire are tried, which hides a point if all were refused.
const MORE: f64 = 4.0;

colours! {
    FractJuliaWf Makes(v, from, random) {
        let [most, x_min, x_max, y_min, y_max, _, _, seed_x, seed_y, direct, height, least, spare, tries, ..] = v.p;
        let [_, _, _, _, _, _, _, _, _, _, _, _, _, _, _, scale, offset_x, offset_y, offset_z, _, is_log, ..] = v.p;
        let none = from.point[0].like(0.0);
        // Those that stay too long or too short are refused.
        let longest = none.like(if spare < 0.0 { most + spare } else { f64::from(f32::MAX) });
        let shortest = none.like(if least > 0.0 { least } else { 0.0 });
        let (mut x, mut y, mut steps) = (none, none, none);
        let mut is_found = none.less(none);
        let mut tried = 0.0;
        while tried < tries * MORE && (!is_found).any() {
            let mut drawn = |low: f64, high: f64| random.unit() * (high - low) + low;
            let at = [drawn(x_min, x_max), drawn(y_min, y_max)];
            let its_steps = steps_until_escape(at, [seed_x, seed_y], most);
            let is_next = !is_found;
            x = N::select(is_next, at[0], x);
            y = N::select(is_next, at[1], y);
            steps = N::select(is_next, its_steps, steps);
            is_found = is_found | (steps.less(longest) & shortest.less(steps));
            tried += 1.0;
        }
        let part = steps / most;
        let high = if is_log == 0.0 { part } else { (part + 1.0).ln() * std::f64::consts::LOG10_E };
        let size = v.w * scale;
        let point = [(x + offset_x) * size, (y + offset_y) * size, (high * (height / 10.0) + offset_z) * size];
        let colour = from.colour + part;
        let colour = N::select(none.like(1.0).less(colour), colour - 1.0, colour);
        (point, if direct == 0.0 { from.colour } else { colour })
    }
}

/// How many steps of z² + `seed` a point takes until it has escaped, counted from 2; `most` + 1 if it does not.
#[inline(always)]
fn steps_until_escape<N: Number>([mut x, mut y]: [N; 2], [seed_x, seed_y]: [f64; 2], most: f64) -> N {
    let mut steps = x.like(2.0);
    let mut is_near = steps.less(x.like(3.0));
    let mut at = 2.0;
    while at <= most {
        is_near = is_near & (x * x + y * y).less(x.like(ESCAPED));
        if !is_near.any() {
            break;
        }
        steps = N::select(is_near, steps + 1.0, steps);
        (x, y) = (x * x - y * y + seed_x, x * y * 2.0 + seed_y);
        at += 1.0;
    }
    steps
}
