//! What formulas that came last compute, in `f64` and in other words.
//!
//! Owns the images of a point; `expected.rs` compares them with the formulas. Those of `expected_later.rs` go on here.

use std::f64::consts::{E, FRAC_PI_2, FRAC_PI_4, PI, TAU};

use super::Kind::{self, *};
use super::expected::C;

const ONE: C = C(1.0, 0.0);

/// All images of a point, each as likely as the others, before the weight.
#[expect(clippy::wildcard_enum_match_arm, reason = "all others are elsewhere")]
pub(super) fn images(kind: Kind, q: &[f64], w: f64, point: [f64; 3]) -> Vec<[f64; 3]> {
    let [x, y, _] = point;
    let zeta = C(x, y);
    let (r, phi) = (zeta.size(), zeta.angle());
    let one = match kind {
        Log => C(zeta.ln().0 / q[0].log(E), phi),
        Acoth => {
            let C(re, im) = ((zeta + ONE) / (zeta - ONE)).ln();
            C(im / PI, re / PI)
        }
        Idisc => C::polar(phi / PI, PI / (r + 1.0)),
        Cardioid => C::polar((r * r + 1.0 + (q[0] * phi).sin()).sqrt(), phi),
        // Between the sides of a square of one turn, from the middle of the right one.
        Circlize => {
            let half = x.abs().max(y.abs());
            let far = if half == x.abs() {
                if x > 0.0 { y } else { 4.0 * half - y }
            } else if y > 0.0 {
                2.0 * half - x
            } else {
                6.0 * half + x
            };
            C::polar(half / FRAC_PI_4 + q[0] / w, far / half * FRAC_PI_4)
        }
        Eclipse => {
            let is_in = |x: f64| w > 0.0 && x.hypot(y) < w;
            let moved = x + q[0] * w;
            C(
                if !is_in(x) {
                    x
                } else if is_in(moved) {
                    moved
                } else {
                    -x
                },
                y,
            )
        }
        Joukowski => {
            let (centre, square) = (C(-q[1], 0.2), C(q[0] * q[0], 0.0));
            if q[2] == 0.0 {
                zeta + centre + square / (zeta + centre)
            } else {
                let half = zeta / C(2.0, 0.0);
                let root = (half * half - square).sqrt();
                let both = [half + root - centre, half - root - centre];
                if both[0].size() > both[1].size() { both[0] } else { both[1] }
            }
        }
        _ => return waves_and_figures(kind, q, w, point),
    };
    vec![[one.0, one.1, 0.0]]
}

/// The same of waves, and of figures by a formula.
#[expect(clippy::wildcard_enum_match_arm, reason = "all others are elsewhere")]
fn waves_and_figures(kind: Kind, q: &[f64], w: f64, point: [f64; 3]) -> Vec<[f64; 3]> {
    let [x, y, _] = point;
    let (zeta, theta) = (C(x, y), x.atan2(y));
    let (r, phi) = (zeta.size(), zeta.angle());
    let one = match kind {
        Petal => C(x.cos().powi(4) * y.cos().powi(3), x.cos() * (x.sin() * y.cos()).powi(3)),
        HeartWf => {
            let side = if theta < 0.0 { -1.0 } else { 1.0 };
            let scale = if theta < 0.0 { q[2] } else { q[3] };
            let t = (theta.abs() / PI * 60.0 * scale - q[1]).min(60.0);
            let heart = |rest: f64| r * (rest + 40.0 * t - t * t) / 1000.0;
            let angle = t.to_radians();
            C(side * q[0] * heart(1200.0) * angle.sin(), -heart(400.0) * angle.cos())
        }
        Waves3 => {
            let swell = |at: f64, frequency: f64| f64::midpoint(1.0, (at * frequency).sin());
            C(x + q[0] * swell(y, q[4]) * (y * q[2]).sin(), y + q[1] * swell(x, q[5]) * (x * q[3]).sin())
        }
        Waves22 => {
            let wave = |angle: f64, mode: f64, power: f64| {
                let sin = if mode == 1.0 { f64::midpoint(1.0, angle.sin()) } else { angle.sin() };
                sin.powi(power as i32)
            };
            C(x + q[0] * wave(y * q[2], q[4], q[6]), y + q[1] * wave(x * q[3], q[5], q[7]))
        }
        RoseWf => C::polar(q[0] * (q[1] * theta).cos(), FRAC_PI_2 - theta),
        Tancos => C(2.0 * x * (r * r).tanh() / (r * r), 2.0 * y * (r * r).cos() / (r * r)),
        TargetSp => {
            let depth = q[3] * r.ln() + q[1] * (phi + PI) / PI;
            let depth = if depth < 0.0 { q[2] / 2.0 - depth } else { depth };
            let turn = if depth.rem_euclid(q[2]) < q[2] / 2.0 { PI * q[0] } else { PI * (q[0] - 1.0) };
            C::polar(r / w, phi + turn)
        }
        Sec2Bs => {
            let k = 2.0 / ((2.0 * x).cos() + (2.0 * y).cosh());
            C(k * (x * q[1]).cos() * (y * q[3]).cosh(), k * (x * q[0]).sin() * (y * q[2]).sinh())
        }
        Stwin => {
            let (x1, y1) = (0.05 * w * x, 0.05 * w * y);
            let (x2, y2) = (x1 * x1 + q[2] * 1e-4, y1 * y1 + q[3] * 1e-4);
            let wave = (x2 - y2) / (x2 + y2) * (TAU * q[0] * (x1 + y1 + 0.1 * q[1])).sin();
            C(x + wave / w, y + wave / w)
        }
        Gnarly => {
            let middle = |value: f64| if q[0] == 0.0 { value } else { ((value / q[0]).floor() + 0.5) * q[0] };
            let centre = C(middle(x), middle(y));
            let off = zeta - centre;
            let share = off.size() / (q[0] / 2.0).abs();
            if q[0] == 0.0 || share > 1.0 { zeta } else { centre + off * C::polar(1.0, -q[1] * 2.0 * share.ln()) }
        }
        _ => return among_several(kind, q, w, point),
    };
    vec![[one.0, one.1, 0.0]]
}

/// The same of those that choose among several.
#[expect(clippy::wildcard_enum_match_arm, reason = "all others are elsewhere")]
fn among_several(kind: Kind, q: &[f64], w: f64, point: [f64; 3]) -> Vec<[f64; 3]> {
    let [x, y, _] = point;
    let (zeta, r) = (C(x, y), x.hypot(y));
    let whole = |count: f64| (0..count.abs() as u32).map(f64::from);
    match kind {
        Acosh => {
            let C(re, im) = (zeta + (zeta - ONE).sqrt() * (zeta + ONE).sqrt()).ln();
            [1.0, -1.0].map(|sign| [sign * re / FRAC_PI_2, sign * im / FRAC_PI_2, 0.0]).to_vec()
        }
        Julian2 => {
            let C(re, im) = C(q[2] * x + q[3] * y + q[6], q[4] * x + q[5] * y + q[7]).ln();
            let root = |k: f64| C::polar((re * q[1] / q[0]).exp(), (im + TAU * k) / q[0]);
            whole(q[0]).map(|k| [root(k).0, root(k).1, 0.0]).collect()
        }
        PowBlock => {
            let size = r.powf(q[0] / (q[1] * q[3] / q[4]));
            let power = |k: f64| C::polar(size, (zeta.angle() + q[2] * TAU * k) / q[1] * q[0]);
            whole(q[1]).map(|k| [power(k).0, power(k).1, 0.0]).collect()
        }
        Cone => {
            let far = q[3] / (q[7] * x * x + y * y + q[2]).sqrt();
            let angle = |k: f64| x.atan2(y) * q[0] + PI * k * q[1];
            let image = |k: f64| [far * (angle(k) * q[5]).cos(), far * (angle(k) * q[4]).sin(), far * q[6]];
            whole(q[8]).map(image).collect()
        }
        // What is in the circle is bent; near a corner of the square around it, seven of twenty times.
        Asteria => {
            let (C(x0, y0), turn) = (C(w * x, w * y), C::polar(1.0, PI * q[0]));
            let C(across, along) = C(x0, y0) * turn;
            let lens = across / (1.0 - along * along).sqrt() * (1.0 - (1.0 - (1.0 - along.abs()).powi(2)).sqrt());
            let C(bent_x, bent_y) = C(lens, along) / turn;
            let (kept, bent) = ([x, y, 0.0], [bent_x / w, bent_y / w, 0.0]);
            let is_near = |x: f64, y: f64| x.hypot(y) < 1.0;
            match (is_near(x0, y0), is_near(x0.abs() - 1.0, y0.abs() - 1.0)) {
                (false, _) => vec![kept],
                (true, false) => vec![bent],
                (true, true) => vec![kept, bent],
            }
        }
        DcLinear | Truchet | Xtrb | Waves4 | Vibration2 | Synth => super::expected_probed::images(kind, q, w, point),
        _ => vec![in_space(kind, q, w, point)],
    }
}

/// The same of those that know z.
#[expect(clippy::wildcard_enum_match_arm, reason = "all others are elsewhere")]
fn in_space(kind: Kind, q: &[f64], w: f64, point: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = point;
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    match kind {
        Ennepers2 => {
            let slope = (q[0] * x).powi(2) - (q[1] * y).powi(2);
            let part = |value: f64, a: f64| value * (a * a - slope / (x * x + y * y) - q[2] * value.abs().sqrt());
            [part(x, q[0]), part(y, q[1]), slope / 2.0 / x.hypot(y)]
        }
        Sph3D => {
            let k = 1.0 / ((q[0] * x).powi(2) + (q[1] * y).powi(2) + (q[0] * z).powi(2));
            point.map(|part| part * k)
        }
        // The quotient of a quaternion's hyperbolic functions, whose divisor is that of the quaternion itself.
        Tanhq => {
            let side = y.hypot(z);
            let (sin, cos) = side.sin_cos();
            let (sinh, cosh) = (C(x.sinh() * cos, x.cosh() * sin), C(x.cosh() * cos, -x.sinh() * sin));
            let C(re, im) = sinh * cosh;
            let k = 1.0 / dot(point, point);
            [k * re, k * im * y / side, k * im * z / side]
        }
        Taurus => {
            let far = q[2] * q[0] + (1.0 - q[2]) * q[0] * (q[1] * x).cos() + y.sin();
            [x.cos() * far, x.sin() * far, q[3] * y.cos() + (1.0 - q[3]) * y / w]
        }
        WhitneyUmbrella => [x * y, x, y * y],
        // Möbius addition in the ball.
        Hypertile3D => {
            let (p, other) = ((TAU / q[0]).cos(), (TAU / q[1]).cos());
            let C(re, im) = C::polar((1.0 + (1.0 - p) / (p + other)).powf(-0.5), TAU * q[2] / q[0]);
            let c = [re, -im, 0.0];
            let (along, c2, p2) = (dot(c, point), dot(c, c), dot(point, point));
            let under = 1.0 + 2.0 * along + c2 * p2;
            [0, 1, 2].map(|i| ((1.0 + 2.0 * along + p2) * c[i] + (1.0 - c2) * point[i]) / under)
        }
        _ => panic!("{kind:?} has no expected image"),
    }
}
