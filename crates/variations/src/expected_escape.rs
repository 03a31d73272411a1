//! What the formulas whose points are chosen by how soon they escape compute: in `f64` and in other words.
//!
//! Owns their images and colours for known random numbers, and where the walk over the edge of the Mandelbrot set comes to
//! rest.

use super::Kind::{self, *};
use super::expected::{At, C, compiled};
use super::expected_chance::{drawn, misfit};
use super::expected_probed::{Known, are_near, coloured};
use species::Rng;

/// How many of the first `most` places of the orbit of z² + `seed` from `z` on are nearer than 2, and the place after them.
fn orbit(mut z: C, seed: C, most: usize) -> (usize, C) {
    for count in 0..most {
        if z.0.hypot(z.1) >= 2.0 {
            return (count, z);
        }
        z = z * z + seed;
    }
    (most, z)
}

#[test]
fn a_julia_set_has_its_points_by_the_steps_until_they_escape() {
    let q = |spare: f64, least: f64, is_log: f64| {
        let before = [60.0, -1.0, 1.0, -1.2, 1.2, 0.0, 2.0, 0.35, 0.09, 1.0, 1.5, least, spare, 1.0, 7.0];
        [&before[..], &[3.8, 0.1, -0.2, 0.05, 0.0, is_log, 0.0]].concat()
    };
    // The program counts from 2.
    let steps = |z: C| orbit(z, C(0.35, 0.09), 59).0 as f64 + 2.0;
    let mut random = Rng::stream(11, 7);
    let mut refused = [0; 4];
    for number in 0..400 {
        let (spare, least, is_log) = if number % 2 == 0 { (-5.0, 4.0, 0.0) } else { (5.0, -1.0, 1.0) };
        let drawn: Vec<f64> = (0..8).map(|_| Rng::unit(&mut random)).collect();
        let tries = drawn.chunks_exact(2).map(|u| C(2.0 * u[0] - 1.0, 2.4 * u[1] - 1.2));
        let is_kept = |z: &C| number % 2 == 1 || (4.0 < steps(*z) && steps(*z) < 55.0);
        // After four the last one is what there is.
        let kept = tries.clone().position(|z| is_kept(&z));
        refused[kept.unwrap_or(3)] += 1;
        let z = tries.clone().nth(kept.unwrap_or(3)).unwrap();
        let part = steps(z) / 60.0;
        let height = if is_log == 0.0 { part } else { (part + 1.0).log10() };
        let expected = [(z.0 + 0.1) * 2.66, (z.1 - 0.2) * 2.66, (height * 0.15 + 0.05) * 2.66];
        let colour = if part + 0.675 > 1.0 { part - 0.325 } else { part + 0.675 };
        let (found, its) = coloured(FractJuliaWf, 0.7, &q(spare, least, is_log), &drawn);
        assert!(are_near(&found, &expected) && (its - colour).abs() < 1e-9, "{number}: {found:?}, not {expected:?}");
    }
    assert!(refused.iter().all(|count| *count > 0), "{refused:?}");
    let mut quiet = q(-5.0, 4.0, 0.0);
    quiet[9] = 0.0;
    assert_eq!(coloured(FractJuliaWf, 0.7, &quiet, &[0.5; 8]).1, 0.675);
}

/// A walk over the edge of the set as JWildfire makes it, from call to call.
struct Walk {
    skin: f64,
    /// Where it is, unless the last call gave up.
    place: Option<C>,
    /// The end of the orbit there.
    end: C,
    /// Whether the last place was drawn from everywhere.
    is_anew: bool,
}

impl Walk {
    fn new(skin: f64) -> Walk {
        Walk { skin, place: None, end: C(0.0, 0.0), is_anew: false }
    }

    /// A call, with these random numbers.
    fn call(&mut self, u: &mut impl FnMut() -> f64) {
        let mut left = 10;
        while left > 0 {
            let beside = self.place.take();
            let next = match beside {
                Some(C(x, y)) => C(x + (u() - 0.5) * (self.skin + 0.001), y + (u() - 0.5) * (self.skin + 0.001)),
                None => C(3.2 * u() - 1.6, 2.4 * u() - 1.2),
            };
            let (count, end) = orbit(next, next, 100);
            (self.end, self.is_anew) = (end, beside.is_none());
            if count < 100 && count as f64 >= 10.0 * (1.0 - self.skin) {
                self.place = Some(next);
                return;
            }
            left -= if beside.is_some() { 3 } else { 1 };
        }
    }
}

fn parameters(skin: f64, along: [f64; 2]) -> [f64; 12] {
    [100.0, -1.6, 1.6, -1.2, 1.2, 0.0, skin, along[0], along[1], -1.0, 1234.0, 0.0]
}

#[test]
fn the_edge_of_the_mandelbrot_set_is_walked_over() {
    let mut gave_up = 0;
    for (skin, calls) in [(0.012, 32), (0.5, 32), (1.0, 1)] {
        for number in 0..60 {
            let mut random = Rng::stream(number, 5);
            let numbers: Vec<f64> = (0..=2 * 320).map(|_| Rng::unit(&mut random)).collect();
            let mut given = numbers.iter().copied();
            let mut walk = Walk::new(skin);
            (0..calls).for_each(|_| walk.call(&mut || given.next().unwrap()));
            let expected = if let Some(C(x, y)) = walk.place {
                [0.7 * (x + 0.5 * walk.end.0), 0.7 * (y + 0.25 * walk.end.1), 0.0]
            } else {
                gave_up += 1;
                let away = 0.7e5 * (0.5 - given.next().unwrap());
                [away, away, 0.0]
            };
            let compiled = compiled(Mandelbrot, 0.7, &parameters(skin, [0.5, 0.25]));
            let found = Kind::Mandelbrot.visit(At(&compiled, [0.3, -1.1, 0.4], &mut Known(numbers)));
            assert!(are_near(&found, &expected), "{skin} {number}: {found:?}, not {expected:?}");
        }
    }
    assert!(gave_up > 0);
}

#[test]
fn a_short_walk_ends_where_an_endless_one_is() {
    let mut random = Rng::stream(8, 5);
    let mut endless = Walk::new(0.012);
    let (mut places, mut even) = (Vec::new(), Vec::new());
    let calls = 1_500_000;
    for _ in 0..calls {
        endless.call(&mut || Rng::unit(&mut random));
        places.extend(endless.place);
        even.extend(endless.place.filter(|_| endless.is_anew));
    }
    let short = drawn(Mandelbrot, 1.0, &parameters(0.012, [0.0; 2]), [0.3, -1.1, 0.4], 10_000);
    let short: Vec<C> = short.iter().map(|p| C(p[0], p[1])).filter(|c| c.size() < 3.0).collect();
    let gave_up = [1.0 - short.len() as f64 / 1e4, 1.0 - places.len() as f64 / f64::from(calls)];
    // JWildfire: 0.0384.
    assert!(gave_up.iter().all(|part| (part - 0.0384).abs() < 0.006), "{gave_up:?}");
    let figures: [fn(&C) -> f64; 3] = [|c| c.0, |c| c.1.abs(), |c| c.size()];
    for (number, figure) in figures.iter().enumerate() {
        let mut reference: Vec<f64> = places.iter().map(figure).collect();
        reference.sort_by(f64::total_cmp);
        let share = |value: f64| reference.partition_point(|one| *one < value) as f64 / reference.len() as f64;
        let found = [&short, &even].map(|places| misfit(places.iter().map(figure).collect(), share));
        // Drawn evenly they would be elsewhere.
        assert!(found[0] < 0.08 && found[1] > 0.09, "{number}: {found:?}");
    }
}
