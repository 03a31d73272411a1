//! Escape-time fractals of other programs: points anywhere in a rectangle, kept by how long they stay near the origin.
//!
//! Owns the count of steps and the choice of a point. Orbits of the plane alone: the orbit of the flame is never looked at.
//!
//! # Source
//! What `JWildfire` gives for chosen random numbers: places, heights and colours.

use super::formulas::{colours, formulas};
use crate::number::{Mask, Number};

/// The square of the distance from which on an orbit has escaped.
const ESCAPED: f64 = 4.0;

/// How many times as many points as in JWildfire are tried, which hides a point if all were refused.
const MORE: f64 = 4.0;

/// Calls of JWildfire's endless walk, of which the last one counts: from nowhere to where the walk would be after many (a total
/// variation of 0.09 for its own parameters, 0.28 if places were drawn evenly).
const CALLS: f64 = 32.0;
/// The places that a call of it tries until it gives up; one that is refused beside the last place counts as three.
const TRIES: f64 = 10.0;
const REFUSED_BESIDE: f64 = 3.0;
/// The most steps of an orbit that are counted. Where every try is refused, a point takes 320 orbits.
pub(super) const MOST_STEPS: f64 = 200.0;
/// How far away a point goes, to either side, if its call gave up.
const AWAY: f64 = 1e5;

formulas! {
    // A walk over the places that escape neither too soon nor too late. In JWildfire it goes on from call to call; here it
    // begins at each.
    Mandelbrot(v, x, _, random) {
        let [most, x_min, x_max, y_min, y_max, _, skin, along_x, along_y, ..] = v.p;
        let none = x.like(0.0);
        let most = most.min(MOST_STEPS);
        let least = none.like(0.1 * most * (1.0 - skin));
        // With this, every try leads anywhere: no call depends on the one before.
        let calls = if skin == 1.0 { 1.0 } else { CALLS };
        let mut place = [none; 2];
        let (mut last, mut called, mut tried) = (place, none, none);
        let mut is_kept = none.less(none);
        loop {
            let walks = called.less(none.like(calls));
            if !walks.any() {
                break;
            }
            let drawn = [random.unit(), random.unit()];
            let anew = [drawn[0] * (x_max - x_min) + x_min, drawn[1] * (y_max - y_min) + y_min];
            let beside = [0, 1].map(|axis| place[axis] + (drawn[axis] - 0.5) * (skin + 0.001));
            let next = [0, 1].map(|axis| N::select(is_kept, beside[axis], anew[axis]));
            let (steps, end) = escape(next, next, most);
            let is_good = steps.less(none.like(most)) & !steps.less(least);
            tried = tried + N::select(is_kept, none.like(REFUSED_BESIDE), none.like(1.0));
            let is_over = is_good | !tried.less(none.like(TRIES));
            place = [0, 1].map(|axis| N::select(walks, next[axis], place[axis]));
            last = [0, 1].map(|axis| N::select(walks, end[axis], last[axis]));
            is_kept = (walks & is_good) | (!walks & is_kept);
            called = N::select(walks & is_over, called + 1.0, called);
            tried = N::select(is_over, none, tried);
        }
        let away = (none - random.unit() + 0.5) * AWAY;
        let [x, y] = [place[0] + last[0] * along_x, place[1] + last[1] * along_y];
        let [x, y] = [x, y].map(|found| N::select(is_kept, found, away));
        (x * v.w, y * v.w)
    }
}

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
            let its_steps = escape(at, [seed_x, seed_y].map(|seed| none.like(seed)), most - 1.0).0 + 2.0;
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

/// How many of the first `most` places of an orbit of z² + `seed` are near the origin, its beginning among them; and the place
/// after them, which has escaped if they are fewer than `most`.
#[inline(always)]
fn escape<N: Number>([mut x, mut y]: [N; 2], seed: [N; 2], most: f64) -> (N, [N; 2]) {
    let mut steps = x.like(0.0);
    let mut is_near = steps.less(x.like(1.0));
    let mut at = 0.0;
    while at < most {
        is_near = is_near & (x * x + y * y).less(x.like(ESCAPED));
        if !is_near.any() {
            break;
        }
        steps = N::select(is_near, steps + 1.0, steps);
        let next = [x * x - y * y + seed[0], x * y * 2.0 + seed[1]];
        (x, y) = (N::select(is_near, next[0], x), N::select(is_near, next[1], y));
        at += 1.0;
    }
    (steps, [x, y])
}
