//! What the synthesiser computes, in `f64` and in other words.
//!
//! Owns its waves and modes a second time, and the claims about its blurs; `expected_probed.rs` compares its other modes.

use std::f64::consts::{PI, TAU};

use super::Kind::Synth;
use super::expected_probed::{are_near, with};
use species::Rng;

/// A synthesiser of three waves, then mode, power, mix and smooth.
pub(super) const fn synth(mode: f64, power: f64, smooth: f64) -> [f64; 35] {
    let mut q = [0.0; 35];
    let some = [0.8, 0.4, 0.0, 0.0, 3.0, 0.7, 0.0, 0.3, 3.0, -0.4, 2.0, 1.1, 1.0, 0.2, 5.0, 0.0, 4.0, 2.0, 2.0];
    let mut at = 0;
    while at < some.len() {
        q[at] = some[at];
        at += 1;
    }
    // A fourth and a fifth: the least of two, and one that no layer takes.
    let (fourth, fifth) = ([0.5, 6.0, 0.0, 1.0, 0.4, 3.0], [9.0, 0.0, 0.0, 1.0, 0.0, 5.0]);
    let mut at = 0;
    while at < 6 {
        (q[19 + at], q[25 + at]) = (fourth[at], fifth[at]);
        at += 1;
    }
    (q[31], q[32], q[33], q[34]) = (mode, power, 0.9, smooth);
    q
}

/// What the waves of [`synth`] add up to.
fn waves(q: &[f64], t: f64) -> f64 {
    let turn = |wave: &[f64]| (wave[4] + t * wave[3]).rem_euclid(TAU);
    let all: Vec<&[f64]> = q[1..31].chunks(6).collect();
    let skewed = {
        let (z, half) = (turn(all[1]), PI * (1.0 + all[1][2]));
        if z < half { z / half * PI } else { TAU - (TAU - z) / (TAU - half) * PI }
    };
    let mut sum = q[0] + all[0][0] * turn(all[0]).sin();
    sum += sum * all[1][0] * (1.0 - skewed / PI);
    sum = sum.max(q[0] + all[2][0] * (2.0 * (1.0 - turn(all[2]) / PI).powi(2) - 1.0));
    sum = sum.min(q[0] + all[3][0] * (2.0 * (turn(all[3]) / TAU).sqrt() - 1.0));
    1.0 - q[33] + q[33] * sum
}

/// The length `x`, bent by `m` where it is smooth.
fn bent(q: &[f64], x: f64, m: f64) -> f64 {
    if q[34] == 0.0 {
        return x * m;
    }
    let sign = x.signum() * m.signum();
    let (x, m) = (x.abs(), m.abs());
    let end = (2.0 - m).max(2.0 * m);
    if x > end {
        sign * x
    } else if x <= 1.0 {
        let k = m.min(1.0 / m);
        let t = ((k * k + (1.0 - 2.0 * k) * x).sqrt() - k) / (1.0 - 2.0 * k);
        sign * (x + (m - 1.0) * t * t)
    } else {
        let t = if m < 1.0 { ((x - 1.0) / (end - 1.0)).sqrt() } else { 1.0 - m + ((m - 1.0).powi(2) + x - 1.0).sqrt() };
        sign * (x + (m - 1.0) * (1.0 - t).powi(2))
    }
}

/// What the synthesiser makes of a point.
pub(super) fn synthesised(q: &[f64], x: f64, y: f64) -> [f64; 3] {
    let (r, theta, power) = (x.hypot(y), x.atan2(y), q[32]);
    let s = |t: f64| waves(q, t);
    let polar = |size: f64, angle: f64| (size * angle.sin(), size * angle.cos());
    let far = r.powf(power);
    let (x, y) = match q[31] as u32 {
        0 => polar(bent(q, r.powf(power + 1.0), s(theta)), theta),
        1 => polar(bent(q, r / (r * r / 4.0 + 1.0), s(theta)), theta),
        5 => polar(bent(q, r, s(theta)), theta),
        6 => (bent(q, x, s(y)), y),
        7 => (x, bent(q, y, s(x))),
        8 => (bent(q, x, s(y)), bent(q, y, s(x))),
        9 => (x + s(y) - 1.0, y),
        10 => (x, y + s(x) - 1.0),
        11 => (x + s(y) - 1.0, y + s(x) - 1.0),
        14 => polar(far, theta + s(far) - 1.0),
        15 => (x + (s(far) - 1.0) * y / r, y - (s(far) - 1.0) * x / r),
        16 => polar(r, theta + s(far) - 1.0),
        17 => (x, 2.0 * s(x) - 2.0 - y),
        18 => (2.0 * s(y) - 2.0 - x, 2.0 * s(x) - 2.0 - y),
        _ => polar(bent(q, r, s(theta)).abs().powf(power), theta),
    };
    [x, y, 0.0]
}

#[test]
fn blurs_of_a_synthesiser_follow_their_waves() {
    let mut random = Rng::stream(5, 5);
    for _ in 0..200 {
        let u = [(); 4].map(|()| Rng::unit(&mut random));
        for smooth in [0.0, 1.0] {
            let of = |mode: f64, power: f64, u: &[f64]| with(Synth, &synth(mode, power, smooth), [0.3, -0.7, 0.0], u);
            let angle = |u: f64| TAU * u - PI;
            let blurred = |mode: f64, power: f64, size: f64, turn: f64| {
                let q = synth(mode, power, smooth);
                let size = if mode == 13.0 { size + waves(&q, turn) } else { bent(&q, size, waves(&q, turn)) };
                [size * turn.sin(), size * turn.cos()]
            };
            let mean = (u[0] + u[1] + 0.002 * u[2]) / 2.002;
            assert!(are_near(
                &of(2.0, 0.7, &u),
                &blurred(2.0, 0.7, mean.powf(0.7), angle(u[3])).map(|axis| mean * axis)
            ));
            let mean = f64::midpoint(u[0], u[1]);
            assert!(are_near(&of(3.0, 0.7, &u), &blurred(3.0, 0.7, mean.powf(-0.7), angle(u[2]))));
            let ring = 1.0 - 0.2 * (u[0] + u[1] - 1.0);
            assert!(are_near(&of(12.0, -2.0, &u), &blurred(12.0, -2.0, ring, angle(u[2]))));
            assert!(are_near(&of(13.0, 0.7, &u), &blurred(13.0, 0.7, 0.1 * u[1].powf(0.7), angle(u[0]))));
            let (q, t) = (synth(4.0, -2.0, smooth), 2.0 * (2.0 * u[2] - 1.0).asin());
            assert!(are_near(&of(4.0, -2.0, &u), &[t / PI, bent(&q, ring, waves(&q, t)) - 1.0]));
        }
    }
}

#[test]
fn waves_have_their_shapes() {
    // Of one wave alone, seen by what it adds to x.
    let height = |shape: f64, skew: f64, frequency: f64, t: f64| {
        let mut q = [0.0; 35];
        q[..7].copy_from_slice(&[1.0, 0.5, shape, skew, frequency, 0.0, 0.0]);
        (q[31], q[33]) = (9.0, 1.0);
        (with(Synth, &q, [0.0, t, 0.0], &[])[0]) / 0.5
    };
    for t in [0.3, 1.0, 2.9, 3.5, 6.0] {
        let n_gon = ((t - PI) / 5.0).cos();
        for (shape, expected) in [
            (0.0, t.sin()),
            (1.0, t.cos()),
            (2.0, if t > PI { 1.0 } else { -1.0 }),
            (3.0, 1.0 - t / PI),
            (4.0, if t > PI { 3.0 - 2.0 * t / PI } else { t / PI - 1.0 }),
        ] {
            assert!(are_near(&[height(shape, 0.0, 1.0, t)], &[expected]), "{shape} at {t}");
            assert!(are_near(&[height(shape, 0.0, 1.0, t - TAU)], &[expected]), "{shape} a turn earlier");
        }
        assert!(are_near(&[height(7.0, 0.0, 5.0, t / 5.0)], &[1.0 / n_gon - 1.0]));
        assert!(are_near(&[height(8.0, 0.0, 5.0, t / 5.0)], &[n_gon / (1.0 - n_gon)]));
        // Half of the turn takes seven tenths of it.
        assert!(are_near(&[height(3.0, 0.4, 1.0, 1.4 * t.min(3.0))], &[1.0 - t.min(3.0) / PI]));
    }
    assert!(are_near(&[height(9.0, 0.0, 1.0, 1.0)], &[0.0]));
}
