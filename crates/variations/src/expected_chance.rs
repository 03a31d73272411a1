//! Claims about the formulas of other programs that blur and crop, and about all of them in lanes of `f32`.
//!
//! Owns what must hold of their images: where they lie, and how often where. Those that draw among few images are in
//! `expected.rs`.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use fearless_simd::{Level, Simd, SimdBase, dispatch, f32x16};

use super::Kind::{self, *};
use super::expected::{At, C, CASES, compiled, points};
use super::expected_probed::PROBED;
use crate::number::{LANES, Lanes, Number, Random};
use crate::{Compiled, Formula, Visitor};
use species::Rng;

/// Parameters with which those that are not in [`CASES`] are tried.
pub(super) const RANDOM: [(Kind, &[&[f64]]); 25] = [
    (Blur3D, &[&[]]),
    (
        Falloff2,
        &[
            &[20.0, 0.5, 0.6, 0.9, -0.7, 0.0, 0.2, -0.1, 0.3, 0.0, 0.0],
            &[20.0, 0.5, 0.6, 0.9, -0.7, 0.0, 0.2, -0.1, 0.3, 0.0, 1.0],
            &[20.0, 0.1, 0.6, 0.9, -0.7, 0.0, 0.2, -0.1, 0.3, 1.0, 2.0],
        ],
    ),
    (Sineblur, &[&[0.7], &[2.0]]),
    (BlurCircle, &[&[]]),
    (BlurLinear, &[&[0.8, 0.6]]),
    (BlurZoom, &[&[0.8, 0.3, -0.4]]),
    (Spirograph, &[&[3.0, 2.0, 0.4, -1.0, 1.5, -0.3, 0.6, 0.7, -0.2]]),
    (Crop, &[&[-0.9, -0.6, 0.7, 1.1, 0.4, 0.0], &[0.7, -0.6, -0.9, 1.1, 0.4, 1.0]]),
    (Circlecrop, &[&[0.8, 0.0, 0.0, 0.5, 0.0], &[0.8, 0.0, 0.0, 0.5, 1.0]]),
    (Boarders2, &[&[0.4, 0.65, 0.35]]),
    (TileLog, &[&[1.7]]),
    (TileHlp, &[&[0.8]]),
    (CannabiscurveWf, &[&[1.0]]),
    (Smartcrop, &[&[4.0, 0.6, 0.0, 1.0, 1.0, 0.3, 0.5, 0.1, 0.0, 1.0, 2.0]]),
    (CloverleafWf, &[&[0.85]]),
    (RoseWf, &[&[0.5, 4.0, 0.85]]),
    (Gaussian, &[&[]]),
    (Rblur, &[&[0.8, 0.6, 0.2, -0.3]]),
    (GlynnSim2, &[&[1.0, 0.1, 0.5, 1.5, 110.0, 150.0]]),
    (Waffle, &[&[6.0, 0.3, 0.6, 0.4]]),
    (Seashell3D, &[&[0.25, 3.5, 0.4, 3.0]]),
    (Crackle, &[&[0.6, 0.4, 0.7, 0.8, 0.3], &[0.5, 0.2, 1.5, 0.9, 0.0]]),
    (
        Falloff3,
        &[
            &[0.0, 0.0, 2.0, 0.3, 0.0, 0.6, 0.9, 0.7, 0.75, 0.2, -0.1, 0.3, 0.0],
            &[1.0, 1.0, 2.0, 0.3, 0.0, 0.6, 0.9, 0.7, 0.75, 0.2, -0.1, 0.3, 0.4],
        ],
    ),
    (FractJuliaWf, &[&[100.0, -1.0, 1.0, -1.2, 1.2, 0.0, 2.0, 0.35, 0.09, 1.0, 1.0, 4.0, -5.0, 3.0, 7.0, 3.8]]),
    (Mandelbrot, &[&[100.0, -1.6, 1.6, -1.2, 1.2, 0.0, 0.012, 0.0, 0.0, -1.0, 1234.0, 0.0]]),
];

/// Images of `point`, as many as `count`.
pub(super) fn drawn(kind: Kind, w: f64, q: &[f64], point: [f64; 3], count: usize) -> Vec<[f64; 3]> {
    let (compiled, mut random) = (compiled(kind, w, q), Rng::stream(3, kind as u64));
    (0..count).map(|_| kind.visit(At(&compiled, point, &mut random))).collect()
}

/// How far the values' distribution is from `share`, the part of them that is below a value: 0..1.
pub(super) fn misfit(mut values: Vec<f64>, share: impl Fn(f64) -> f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let count = values.len() as f64;
    values.iter().enumerate().map(|(i, value)| (share(*value) - (i as f64 + 0.5) / count).abs()).fold(0.0, f64::max)
}

/// Kolmogorov's bound for 10,000 values: passed by chance once in a million.
const FIT: f64 = 0.027;

fn even(low: f64, high: f64) -> impl Fn(f64) -> f64 {
    move |value| ((value - low) / (high - low)).clamp(0.0, 1.0)
}

#[test]
fn blurs_that_ignore_the_point_have_their_shapes() {
    let of = |kind, q: &[f64]| drawn(kind, 0.7, q, [0.4, -1.1, 0.9], 10_000);
    let radius = |p: &[f64; 3]| p[0].hypot(p[1]) / 0.7;
    let angle = |p: &[f64; 3]| p[1].atan2(p[0]);
    let disc = of(BlurCircle, &[]);
    assert!(misfit(disc.iter().map(radius).collect(), |r| r * r) < FIT);
    assert!(misfit(disc.iter().map(angle).collect(), even(-PI, PI)) < FIT);
    for power in [0.7, 2.0] {
        let blur = of(Sineblur, &[power]);
        // acos(2 U^p - 1) / π < ρ where U > ((1 + cos πρ) / 2)^(1/p).
        let share = |rho: f64| 1.0 - f64::midpoint(1.0, (PI * rho).cos()).powf(1.0 / power);
        assert!(misfit(blur.iter().map(radius).collect(), share) < FIT);
        assert!(misfit(blur.iter().map(angle).collect(), even(-PI, PI)) < FIT);
    }
    let ball = of(Blur3D, &[]);
    // The angle from the axis is even, not the surface: what is nearer to the axis is denser.
    let tilt = |p: &[f64; 3]| p[0].hypot(p[1]).atan2(p[2]);
    assert!(misfit(ball.iter().map(tilt).collect(), even(0.0, PI)) < FIT);
    let size = |p: &[f64; 3]| (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) / 0.49;
    let spread = ball.iter().map(size).sum::<f64>() / 10_000.0;
    assert!((spread - 4.0 / 12.0).abs() < 0.02 && ball.iter().all(|p| size(p) <= 4.0), "{spread}");
    assert!(misfit(ball.iter().map(angle).collect(), even(-PI, PI)) < FIT);
    let [a, b, d, tmin, tmax, ymin, ymax, c1, c2] = [3.0, 2.0, 0.4, -1.0, 1.5, -0.3, 0.6, 0.7, -0.2];
    let spirograph = of(Spirograph, &[a, b, d, tmin, tmax, ymin, ymax, c1, c2]);
    // The height is the same in both: x - y depends on t alone, and t is even.
    let lag = |t: f64| {
        let wheel = (a + b) * t / b;
        (a + b + d) * (t.cos() - t.sin()) - c1 * wheel.cos() + c2 * wheel.sin()
    };
    let of_curve = (0..10_000).map(|i| lag(tmin + (tmax - tmin) * (f64::from(i) + 0.5) / 1e4));
    let mut of_curve: Vec<f64> = of_curve.collect();
    of_curve.sort_by(f64::total_cmp);
    let share = |value: f64| of_curve.partition_point(|one| *one < value) as f64 / 1e4;
    assert!(misfit(spirograph.iter().map(|p| (p[0] - p[1]) / 0.7).collect(), share) < FIT);
    let mean = spirograph.iter().map(|p| p[0] / 0.7).sum::<f64>() / 1e4;
    let along = |t: f64| (a + b + d) * t.cos() - c1 * ((a + b) * t / b).cos();
    let expected = (0..1000).map(|i| along(tmin + 2.5 * (f64::from(i) + 0.5) / 1e3)).sum::<f64>() / 1e3 + 0.15;
    assert!((mean - expected).abs() < 0.1, "{mean}, not {expected}");
}

#[test]
fn blurs_along_a_line_spread_the_point_evenly() {
    for point in points().take(20) {
        let [x, y, _] = point;
        let far = |p: &[f64; 3]| {
            let (dx, dy) = (p[0] / 0.7 - x, p[1] / 0.7 - y);
            assert!((dx * 0.6_f64.sin() - dy * 0.6_f64.cos()).abs() < 1e-9);
            dx * 0.6_f64.cos() + dy * 0.6_f64.sin()
        };
        let line = drawn(BlurLinear, 0.7, &[0.8, 0.6], point, 10_000);
        assert!(misfit(line.iter().map(far).collect(), even(0.0, 0.8)) < FIT);
        let zoom = |p: &[f64; 3]| {
            let (x_grown, y_grown) = ((p[0] / 0.7 - 0.3) / (x - 0.3), (p[1] / 0.7 - 0.4) / (y - 0.4));
            assert!((x_grown - y_grown).abs() < 1e-6);
            x_grown
        };
        let zoomed = drawn(BlurZoom, 0.7, &[0.8, 0.3, -0.4], point, 10_000);
        assert!(misfit(zoomed.iter().map(zoom).collect(), even(1.0, 1.8)) < FIT);
    }
}

#[test]
fn crops_keep_the_inside_and_move_the_outside_to_its_border() {
    for point in points() {
        let [x, y, _] = point;
        let is_inside = (-0.9..=0.7).contains(&x) && (-0.6..=1.1).contains(&y);
        for [x1, y1, _] in drawn(Crop, 1.5, RANDOM[7].1[0], point, 50) {
            let part = |value: f64, low: f64, high: f64| {
                let deep = (high - low) * 0.2;
                if value < low {
                    (low, low + deep)
                } else if value > high {
                    (high - deep, high)
                } else {
                    (value, value)
                }
            };
            for (moved, (low, high)) in [(x1 / 1.5, part(x, -0.9, 0.7)), (y1 / 1.5, part(y, -0.6, 1.1))] {
                assert!((low - 1e-12..=high + 1e-12).contains(&moved), "{point:?} became {x1}, {y1}");
            }
        }
        let whole = if is_inside { [1.5 * x, 1.5 * y, 0.0] } else { [0.0; 3] };
        assert_eq!(drawn(Crop, 1.5, RANDOM[7].1[1], point, 1), [whole]);
        let r = x.hypot(y);
        for p in drawn(Circlecrop, 1.5, RANDOM[8].1[0], point, 50) {
            let [x1, y1, _] = p.map(|part| part / 1.5);
            let range = if r > 0.8 { (0.8, 1.05) } else { (r, r) };
            assert!((x1 * y - y1 * x).abs() < 1e-9 && x1 * x + y1 * y >= 0.0);
            assert!((range.0 - 1e-9..=range.1 + 1e-9).contains(&x1.hypot(y1)), "{point:?} became {p:?}");
        }
        let whole = if r > 0.8 { [0.0; 3] } else { [1.5 * x, 1.5 * y, 0.0] };
        assert_eq!(drawn(Circlecrop, 1.5, RANDOM[8].1[1], point, 1), [whole]);
        let middle = drawn(Circlecrop, 1.5, &[0.8, 0.0, 0.0, 0.0, 0.0], point, 1)[0];
        let beside = drawn(Circlecrop, 1.5, &[0.8, 0.3, -0.2, 0.0, 0.0], [x + 0.3, y - 0.2, 0.0], 1)[0];
        assert!((beside[0] - 0.3 - middle[0]).abs() < 1e-9 && (beside[1] + 0.2 - middle[1]).abs() < 1e-9);
    }
    // As much at each depth.
    let deep = drawn(Crop, 1.0, RANDOM[7].1[0], [-3.0, 5.0, 0.0], 10_000);
    assert!(misfit(deep.iter().map(|p| p[0]).collect(), even(-0.9, -0.9 + 0.32)) < FIT);
    assert!(misfit(deep.iter().map(|p| p[1]).collect(), even(1.1 - 0.34, 1.1)) < FIT);
    let far = drawn(Circlecrop, 1.0, RANDOM[8].1[0], [-3.0, 5.0, 0.0], 10_000);
    assert!(misfit(far.iter().map(|p| p[0].hypot(p[1])).collect(), even(0.8, 1.05)) < FIT);
}

#[test]
fn a_ragged_crop_scatters_what_goes_and_keeps_the_rest() {
    // The right side of a square: it begins 0.45 to 0.75 from the middle.
    let images = |x: f64, scatter: f64| {
        let q = [4.0, 0.6, 0.0, 1.0, 1.0, 0.3, scatter, 0.1, 0.0, 1.0, 2.0];
        drawn(Smartcrop, 0.7, &q, [x, 0.0, 0.4], 10_000)
    };
    assert!(images(0.44, 0.5).iter().all(|p| *p == [0.7 * 0.44, 0.0, 0.7 * 0.4]));
    let edge: Vec<f64> = images(0.8, 0.0).iter().map(|p| p[0] / 0.7).collect();
    assert!(misfit(edge, even(0.45 + 0.1, 0.75 + 0.1)) < FIT);
    let middle = images(0.6, 0.0).iter().filter(|p| p[0] == 0.7 * 0.6).count() as f64 / 1e4;
    assert!((middle - 0.5).abs() < 0.025, "{middle}");
    let far: Vec<f64> = images(0.8, 0.5).iter().map(|p| p[0] / 0.7).collect();
    // The sum of two even numbers.
    let mean = far.iter().sum::<f64>() / far.len() as f64;
    assert!((mean - (0.6 + 0.1 + 0.25)).abs() < 0.01, "{mean}");
}

#[test]
fn a_leaf_is_filled_and_a_tile_steps_by_its_width() {
    for point in points().take(20) {
        let [x, y, _] = point;
        let border = drawn(CannabiscurveWf, 0.7, &[0.0], point, 1)[0];
        let filled = drawn(CannabiscurveWf, 0.7, &[1.0], point, 10_000);
        assert!(misfit(filled.iter().map(|p| p[0] / border[0]).collect(), even(0.0, 1.0)) < FIT);
        let steps: Vec<f64> = drawn(TileHlp, 0.7, &[0.8], point, 10_000).iter().map(|p| p[0] / 0.7 - x).collect();
        let is_near = |value: f64, other: f64| (value - other).abs() < 1e-9;
        assert!(steps.iter().all(|step| is_near(*step, 0.0) || is_near(*step, -0.8 * x.signum())));
        let share = steps.iter().filter(|step| !is_near(**step, 0.0)).count() as f64 / 1e4;
        let expected = (PI * (x.abs() / 0.8).fract() / 2.0).sin().powi(2);
        assert!((share - expected).abs() < 0.025, "{x}: {share}, not {expected}");
        assert!(drawn(TileHlp, 0.7, &[0.8], point, 9).iter().all(|p| p[1] == 0.7 * y));
    }
}

#[test]
fn tiles_by_chance_move_by_their_distances() {
    for point in points().take(40) {
        let [x, y, _] = point;
        let (n, o) = ([x.round_ties_even(), y.round_ties_even()], [x - x.round_ties_even(), y - y.round_ties_even()]);
        let longest = o[0].abs().max(o[1].abs());
        let images = drawn(Boarders2, 0.7, &[0.4, 0.65, 0.35], point, 10_000);
        let kept = [0, 1].map(|i| 0.7 * (n[i] + 0.4 * o[i]));
        let pushed = [0, 1].map(|i| 0.7 * (n[i] + 0.4 * o[i] + 0.4 * 0.65 * o[i] / longest));
        let is = |p: &[f64; 3], at: [f64; 2]| (p[0] - at[0]).abs() < 1e-9 && (p[1] - at[1]).abs() < 1e-9;
        assert!(images.iter().all(|p| is(p, kept) || is(p, pushed)));
        let share = images.iter().filter(|p| is(p, kept)).count() as f64 / 1e4;
        assert!((share - (1.0 - (0.4 + 0.4 * 0.35))).abs() < 0.025, "{share}");
        let steps: Vec<f64> = drawn(TileLog, 0.7, &[1.7], point, 10_000).iter().map(|p| p[0] / 0.7 - x).collect();
        assert!(steps.iter().all(|step| (step - step.round()).abs() < 1e-9));
        for least in 0..4 {
            let share = steps.iter().filter(|step| **step > f64::from(least) + 0.5).count() as f64 / 1e4;
            // spread · -ln U beyond a half more than `least`, on one of two sides.
            let expected = 0.5 * (-(f64::from(least) + 0.5) / 1.7).exp();
            assert!((share - expected).abs() < 0.025, "{least}: {share}, not {expected}");
        }
        assert!(drawn(TileLog, 0.7, &[1.7], point, 9).iter().all(|p| p[1] == 0.7 * y));
    }
}

#[test]
fn leaves_are_filled_as_often_as_asked() {
    for point in points().take(20) {
        let theta = point[0].atan2(point[1]);
        let border = 0.7 * ((2.0 * theta).sin() + 0.25 * (6.0 * theta).sin());
        let far = |p: &[f64; 3]| {
            assert!((p[0] * theta.cos() - p[1] * theta.sin()).abs() < 1e-9);
            (p[0] * theta.sin() + p[1] * theta.cos()) / border
        };
        let images = drawn(CloverleafWf, 0.7, &[0.85], point, 10_000);
        assert!(misfit(images.iter().map(far).filter(|far| *far < 1.0 - 1e-12).collect(), even(0.0, 1.0)) < 0.03);
        let filled = images.iter().filter(|p| far(p) < 1.0 - 1e-12).count() as f64 / 1e4;
        assert!((filled - 0.85).abs() < 0.02, "{filled}");
        // A spiral with a thickness reaches up to that many times of the one without.
        let phi = point[1].atan2(point[0]);
        let along = |p: &[f64; 3]| ((p[0] * phi.cos() + p[1] * phi.sin()) / 0.7 + 0.4) * (5.0 * phi).cos();
        let spiral = drawn(Epispiral, 0.7, &[5.0, 0.3, 0.4], point, 10_000);
        assert!(misfit(spiral.iter().map(along).collect(), even(0.0, 0.3)) < FIT);
    }
}

#[test]
fn what_scatters_a_point_does_so_evenly_about_it() {
    for point in points().take(20) {
        let [x, y, _] = point;
        let around = drawn(Gaussian, 0.7, &[], point, 10_000);
        let off = |p: &[f64; 3]| C(p[0] - x, p[1] - y);
        assert!(misfit(around.iter().map(|p| off(p).angle()).collect(), even(-PI, PI)) < FIT);
        let spread = around.iter().map(|p| off(p).size().powi(2)).sum::<f64>() / 1e4;
        assert!((spread - 0.49 / 3.0).abs() < 0.01, "{spread}");
        let reach = 0.8 * (C(x - 0.2, y + 0.3).size() - 0.6).max(0.0);
        let scattered = drawn(Rblur, 0.7, &[0.8, 0.6, 0.2, -0.3], point, 10_000);
        for axis in [0, 1] {
            let moved = scattered.iter().map(|p| p[axis] / 0.7 - point[axis]);
            if reach == 0.0 {
                assert!(moved.into_iter().all(|step| step.abs() < 1e-12));
            } else {
                assert!(misfit(moved.collect(), even(-reach, reach)) < FIT);
            }
        }
        let theta = x.atan2(y);
        let petal = 0.7 * 0.5 * (4.0 * theta).cos();
        let far = |p: &[f64; 3]| (p[0] * theta.sin() + p[1] * theta.cos()) / petal;
        let rose = drawn(RoseWf, 0.7, &[0.5, 4.0, 0.85], point, 10_000);
        assert!(misfit(rose.iter().map(far).filter(|far| *far < 1.0 - 1e-12).collect(), even(0.0, 1.0)) < 0.03);
        let filled = rose.iter().filter(|p| far(p) < 1.0 - 1e-12).count() as f64 / 1e4;
        assert!((filled - 0.85).abs() < 0.02, "{filled}");
    }
}

#[test]
fn a_ring_is_an_arc_inside_and_a_mirror_outside() {
    let q = RANDOM[18].1[0];
    for point in points().take(40) {
        let r = C(point[0], point[1]).size();
        let images = drawn(GlynnSim2, 0.7, q, point, 10_000);
        if r < 1.0 {
            let angle = |p: &[f64; 3]| p[1].atan2(p[0]).to_degrees();
            assert!(misfit(images.iter().map(angle).collect(), even(110.0, 150.0)) < FIT);
            // From the inner border, where the outer one is the circle's inverse.
            let inner = 1.1 - 0.1 * 2.1 / 1.1;
            let size = |p: &[f64; 3]| C(p[0], p[1]).size() / 0.7;
            assert!(misfit(images.iter().map(size).collect(), even(inner, 1.1)) < FIT);
        } else {
            let times = |p: &[f64; 3]| p[0] / 0.7 / point[0];
            let is_near = |value: f64, other: f64| (value - other).abs() < 1e-9;
            assert!(images.iter().all(|p| is_near(times(p), 1.0) || is_near(times(p), r.powi(-2))));
            let share = images.iter().filter(|p| !is_near(times(p), 1.0)).count() as f64 / 1e4;
            assert!((share - 0.5 * r.powf(-1.5)).abs() < 0.025, "{share}");
        }
    }
}

#[test]
fn a_waffle_has_its_bars_and_a_shell_its_windings() {
    let turned = C::polar(1.0 / 0.7, 0.4);
    let waffle = drawn(Waffle, 0.7, RANDOM[19].1[0], [0.4, -1.1, 0.9], 50_000);
    let places: Vec<C> = waffle.iter().map(|p| C(p[0], p[1]) * turned).collect();
    assert!(places.iter().all(|C(a, r)| (0.0..1.0).contains(a) && (0.0..1.0).contains(r)));
    let in_slice = |value: f64| (value * 6.0).fract();
    let share = |holds: &dyn Fn(f64, f64) -> bool| {
        places.iter().filter(|C(a, r)| holds(in_slice(*a), in_slice(*r))).count() as f64 / 5e4
    };
    // A fifth are on each edge; a fifth fill the small rectangle.
    let on = |value: f64, edge: f64| (value - edge).abs() < 1e-9;
    assert!((share(&|_, r| on(r, 0.6)) - 0.2).abs() < 0.01);
    assert!((share(&|a, _| on(a, 0.3)) - 0.2).abs() < 0.01);
    // Of those between bars, 0.3 of the fourth set and 0.6 of the fifth are within the other's.
    let within = share(&|a, r| a < 0.3 - 1e-9 && r < 0.6 - 1e-9);
    assert!((within - 0.2).abs() < 0.01, "{within}");
    let beyond = share(&|a, r| a > 0.3 + 1e-9 && r > 0.6 + 1e-9);
    assert!((beyond - 0.2 * (0.7 + 0.4)).abs() < 0.01, "{beyond}");
    let shell = drawn(Seashell3D, 0.7, RANDOM[20].1[0], [0.4, -1.1, 0.9], 10_000);
    for [x, y, z] in shell.iter().map(|p| p.map(|part| part / 0.7)) {
        // The tube around its middle: as far up as out.
        let is_on = |wound: f64| {
            let rim = 0.25 * (1.0 - wound);
            let (out, up) = (C(x, y).size() - 0.4 - rim, z - 3.5 * wound);
            C(out, up).size() - rim
        };
        let turn = C(x, y).angle().rem_euclid(TAU) / TAU;
        assert!((0..3).any(|winding| is_on((f64::from(winding) + turn) / 3.0).abs() < 1e-9), "{x} {y} {z}");
    }
}

#[test]
fn falloff_scatters_more_the_farther_a_point_is() {
    for point in points().take(40) {
        let q = RANDOM[1].1;
        let [x, y, z] = point;
        let off = ((x - 0.2).powi(2) + (y + 0.1).powi(2) + (z - 0.3).powi(2)).sqrt();
        let far = (off - 0.5).max(0.0) * 0.04 * 20.0;
        let images = drawn(Falloff2, 1.5, q[0], point, 10_000);
        for (axis, reach) in [(0, 0.6 * far / 2.0), (1, 0.9 * far / 2.0), (2, 0.7 * far / 2.0)] {
            let moved = |p: &[f64; 3]| p[axis] / 1.5 - point[axis];
            if far == 0.0 {
                assert!(images.iter().all(|p| moved(p).abs() < 1e-12));
            } else {
                assert!(misfit(images.iter().map(moved).collect(), even(-reach, reach)) < FIT);
            }
        }
        // Small steps only, so that angles do not go round.
        let soft: Vec<f64> = q[1].iter().enumerate().map(|(i, value)| if i == 0 { 1.0 } else { *value }).collect();
        let far = far / 20.0;
        let size = (x * x + y * y + z * z).sqrt();
        for p in drawn(Falloff2, 1.5, &soft, point, 300).iter().map(|p| p.map(|part| part / 1.5)) {
            let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
            let turned = (p[1].atan2(p[0]) - y.atan2(x) + 3.0 * PI).rem_euclid(TAU) - PI;
            let raised = (p[2] / length).asin() - (z / size).asin();
            assert!((length - size).abs() <= 0.3 * far + 1e-9 && turned.abs() <= 0.45 * far + 1e-9);
            assert!(raised.abs() <= 0.35 * far + 1e-9 || (z / size).asin().abs() > 1.3);
        }
        // Near rather than far, in a ball that the three factors stretch.
        let near = point.map(|part| part * 0.1);
        let off = ((near[0] - 0.2).powi(2) + (near[1] + 0.1).powi(2) + (near[2] - 0.3).powi(2)).sqrt();
        let far = ((1.0 - off).max(0.0) - 0.1).max(0.0) * 0.04 * 20.0;
        let moved = |p: &[f64; 3]| {
            let [dx, dy, dz] = [0, 1, 2].map(|i| (p[i] / 1.5 - near[i]) / [0.6, 0.9, 0.7][i]);
            (dx * dx + dy * dy + dz * dz).sqrt()
        };
        let images = drawn(Falloff2, 1.5, q[2], near, 10_000);
        assert!(far > 0.0 && misfit(images.iter().map(moved).collect(), even(0.0, far / 2.0)) < FIT, "{near:?}");
        // The angle in the plane is at most a quarter turn times the distance, to either side.
        let turned = |p: &[f64; 3]| ((p[1] / 1.5 - near[1]) / 0.9 / ((p[0] / 1.5 - near[0]) / 0.6)).atan();
        assert!(misfit(images.iter().map(turned).collect(), even(-far * FRAC_PI_2, far * FRAC_PI_2)) < FIT);
    }
}

/// The same numbers for one point and for sixteen.
struct Given(Rng);

impl Random<f64> for Given {
    fn unit(&mut self) -> f64 {
        (self.0.bits() >> 40) as f64 / f64::from(1 << 24)
    }
    fn coin(&mut self) -> bool {
        self.0.bits() >> 63 == 1
    }
}

struct GivenLanes<S: Simd>(Given, S);

impl<S: Simd> Random<Lanes<S>> for GivenLanes<S> {
    fn unit(&mut self) -> Lanes<S> {
        Lanes(f32x16::splat(self.1, Random::<f64>::unit(&mut self.0) as f32))
    }
    fn coin(&mut self) -> <Lanes<S> as Number>::Mask {
        let zero = Lanes(f32x16::splat(self.1, 0.0));
        if self.0.coin() { zero.less(zero + 1.0) } else { zero.less(zero) }
    }
}

struct AtLanes<'a, S: Simd>(S, &'a Compiled, [[f32; LANES]; 3], u64);

impl<S: Simd> Visitor for AtLanes<'_, S> {
    type Out = [[f32; LANES]; 3];

    // A function of its own for each formula: otherwise all of them would be one, which takes minutes to compile.
    #[inline(never)]
    fn visit<F: Formula>(self) -> [[f32; LANES]; 3] {
        let AtLanes(simd, compiled, points, seed) = self;
        simd.vectorize(
            #[inline(always)]
            || {
                let points = points.map(|places| Lanes(f32x16::load_array(simd, places)));
                let mut random = GivenLanes(Given(Rng::stream(seed, 1)), simd);
                F::in_space(compiled, points, &mut random).map(|lanes| {
                    let mut out = [0.0; LANES];
                    lanes.0.store_array(&mut out);
                    out
                })
            },
        )
    }
}

/// The images of sixteen points.
fn sixteen(kind: Kind, compiled: &Compiled, points: [[f32; LANES]; 3], seed: u64) -> [[f32; LANES]; 3] {
    // In one place: the compiler makes all formulas anew for each.
    dispatch!(Level::new(), simd => kind.visit(AtLanes(simd, compiled, points, seed)))
}

#[test]
fn foreign_formulas_give_the_same_in_lanes() {
    for (kind, q) in
        CASES.iter().chain(&RANDOM).chain(&PROBED).flat_map(|(kind, sets)| sets.iter().map(move |q| (*kind, *q)))
    {
        let compiled = compiled(kind, 0.7, q);
        let points: Vec<[f64; 3]> = points().collect();
        let (mut off, mut all) = (0, 0);
        // The height of each of its strips is what 43,758 times a sine has after the point.
        let most = if kind == Waves4 { 0.05 } else { 1e-4 };
        for (number, points) in points.chunks_exact(LANES).enumerate() {
            let lanes: [[f32; LANES]; 3] = std::array::from_fn(|axis| std::array::from_fn(|i| points[i][axis] as f32));
            let found = sixteen(kind, &compiled, lanes, number as u64);
            for (i, point) in points.iter().enumerate() {
                let near = point.map(|part| f64::from(part as f32));
                let mut random = Given(Rng::stream(number as u64, 1));
                let expected = kind.visit(At(&compiled, near, &mut random));
                let is_off = |axis: usize| {
                    let error = (f64::from(found[axis][i]) - expected[axis]).abs();
                    error.is_nan() || error > most * (1.0 + expected[axis].abs())
                };
                off += usize::from((0..3).any(is_off));
                all += 1;
            }
        }
        // A few lie at an edge that f32 sees elsewhere.
        assert!(off * 100 <= all, "{kind:?} {q:?}: {off} of {all}");
    }
}

#[test]
fn foreign_formulas_are_finite_at_the_origin() {
    for (kind, q) in
        CASES.iter().chain(&RANDOM).chain(&PROBED).flat_map(|(kind, sets)| sets.iter().map(move |q| (*kind, *q)))
    {
        // Unguarded in their programs, too.
        if matches!(kind, Acosech | Glynnia | LinearT3D | Log | Target | Waves2b | Circlecrop)
            || kind == EJulia && q[0] < 0.0
        {
            continue;
        }
        let compiled = compiled(kind, 0.7, q);
        let mut random = Given(Rng::stream(5, 0));
        for _ in 0..20 {
            let found = kind.visit(At(&compiled, [0.0; 3], &mut random));
            assert!(found.iter().all(|part| part.is_finite()), "{kind:?} {q:?}: {found:?}");
        }
        let found = sixteen(kind, &compiled, [[0.0; LANES]; 3], 5);
        assert!(found.as_flattened().iter().all(|part| part.is_finite()), "{kind:?} {q:?}: {found:?}");
    }
}
