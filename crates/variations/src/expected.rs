//! The formulas of other programs than flam3, written a second time: by complex numbers, vectors and branches in `f64`.
//!
//! Owns the expected images of a point. Where a formula draws among several images these are all of them. Blurs and crops
//! are in `expected_chance.rs`. Never uses what a formula uses.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_8, PI, TAU};
use std::ops::{Add, Div, Mul, Sub};

use super::Kind::{self, *};
use super::expected_probed::PROBED;
use super::{MAX_PARAMETERS, Variation};
use crate::Affine;
use crate::number::Random;
use crate::{Compiled, Formula, Visitor};
use species::Rng;

/// A complex number.
#[derive(Clone, Copy)]
pub(super) struct C(pub(super) f64, pub(super) f64);

impl Add for C {
    type Output = C;
    fn add(self, C(re, im): C) -> C {
        C(self.0 + re, self.1 + im)
    }
}

impl Sub for C {
    type Output = C;
    fn sub(self, C(re, im): C) -> C {
        C(self.0 - re, self.1 - im)
    }
}

impl Mul for C {
    type Output = C;
    fn mul(self, C(re, im): C) -> C {
        C(self.0 * re - self.1 * im, self.0 * im + self.1 * re)
    }
}

impl Div for C {
    type Output = C;
    fn div(self, C(re, im): C) -> C {
        let size = re * re + im * im;
        self * C(re / size, -im / size)
    }
}

impl C {
    pub(super) fn polar(size: f64, angle: f64) -> C {
        C(size * angle.cos(), size * angle.sin())
    }
    pub(super) fn size(self) -> f64 {
        self.0.hypot(self.1)
    }
    pub(super) fn angle(self) -> f64 {
        self.1.atan2(self.0)
    }
    pub(super) fn ln(self) -> C {
        C(self.size().ln(), self.angle())
    }
    fn exp(self) -> C {
        C::polar(self.0.exp(), self.1)
    }
    pub(super) fn sqrt(self) -> C {
        C::polar(self.size().sqrt(), self.angle() / 2.0)
    }
    fn flat(self) -> [f64; 3] {
        [self.0, self.1, 0.0]
    }
}

/// A formula as f64 sees it.
pub(super) struct At<'a, R>(pub(super) &'a Compiled, pub(super) [f64; 3], pub(super) &'a mut R);

impl<R: Random<f64>> Visitor for At<'_, R> {
    type Out = [f64; 3];

    #[inline(never)]
    fn visit<F: Formula>(self) -> [f64; 3] {
        F::in_space(self.0, self.1, self.2)
    }
}

pub(super) fn compiled(kind: Kind, weight: f64, parameters: &[f64]) -> Compiled {
    Compiled::new(&Variation::new(kind, weight).with(parameters), &Affine::IDENTITY)
}

/// 200 points.
pub(super) fn points() -> impl Iterator<Item = [f64; 3]> {
    let mut random = Rng::stream(41, 0);
    (0..200).map(move |_| [(); 3].map(|()| random.signed() * 2.3))
}

/// Parameters with which formulas are tried.
pub(super) const CASES: [(Kind, &[&[f64]]); 74] = [
    (Spherical3D, &[&[]]),
    (Spherical3DWf, &[&[0.0, 1.3], &[1.0, 2.0]]),
    (Hemisphere, &[&[]]),
    (Julia3D, &[&[3.0], &[-2.0]]),
    (Julia3Dz, &[&[3.0], &[-4.0]]),
    (Julian3Dx, &[&[0.8, 3.0, 0.9, 0.2, -0.4, 1.1, 0.3, -0.2], &[1.0, -2.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0]]),
    (Curl3D, &[&[0.4, -0.7, 0.3]]),
    (Blob3D, &[&[0.3, 1.2, 4.0]]),
    (LinearT3D, &[&[0.6, 1.4, -0.3]]),
    (Poincare3D, &[&[0.6, 0.4, -0.7]]),
    (Bubble2, &[&[0.7, 1.3, -0.9]]),
    (RotateX, &[&[]]),
    (RotateY, &[&[]]),
    (RotateZ, &[&[]]),
    (Waves2In3D, &[&[1.7, 0.6]]),
    (
        AxisSymmetryWf,
        &[
            &[0.0, 0.3, -0.2, 0.5],
            &[1.0, 0.3, -0.2, 0.5],
            &[2.0, 0.3, -0.2, 0.5],
            &[0.0, 0.3, -0.2, 0.5, 26.0],
            &[1.0, 0.3, -0.2, 0.5, -14.0],
            &[2.0, 0.3, -0.2, 0.5, 70.0],
        ],
    ),
    (EllipticMirrored, &[&[]]),
    (Affine3D, &[&[0.3, -0.2, 0.5, 1.2, 0.7, -0.9, 20.0, -35.0, 70.0, 0.2, -0.3, 0.4, 0.1, -0.5, 0.6]]),
    (Butterfly3D, &[&[]]),
    (Waves4Wf, &[&[0.4, -0.7, 1.6, 2.3, 1.0, 0.0, -0.3, 0.2]]),
    (CannabiscurveWf, &[&[0.0]]),
    (Target, &[&[0.3, -1.2, 0.7]]),
    (Kaleidoscope, &[&[0.3, 1.2, -0.4, 0.6, 0.7]]),
    (
        Smartcrop,
        &[
            &[4.0, 1.2, 0.0, 1.0, 1.0, 0.0, 0.0, 0.1, 0.0, 1.0, 2.0],
            &[3.0, -0.9, 0.4, 1.0, 0.6, 0.0, 0.0, 0.1, 0.3, 1.0, 2.0],
            &[-5.0, 1.1, -0.7, 2.2, 1.0, 0.0, 0.0, 0.0, 0.3, -1.0, 2.0],
            &[6.0, 1.4, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0],
        ],
    ),
    (Juliac, &[&[3.0, 20.0, 0.8], &[-4.0, -35.0, 1.1]]),
    (Juliaq, &[&[3.0, 2.0], &[-2.0, 3.0]]),
    (EJulia, &[&[3.0], &[-2.0]]),
    (BTransform, &[&[0.4, 3.0, 0.3, 0.0], &[-0.1, 1.0, 0.05, 0.0]]),
    (Acosech, &[&[]]),
    (Hypertile, &[&[3.0, 7.0, 1.0], &[5.0, 4.0, 3.0]]),
    (Hypertile1, &[&[3.0, 7.0], &[5.0, 4.0]]),
    (Hypertile2, &[&[3.0, 7.0], &[4.0, 6.0]]),
    (Waves2b, &[&[2.1, 1.3, 1.4, -0.6, 0.8, 0.3, -0.4, 0.9, 0.7]]),
    (Waves2Wf, &[&[0.4, -0.7, 1.6, 2.3, 1.0, 0.0, -0.3, 0.2]]),
    (Waves3Wf, &[&[0.4, -0.7, 1.6, 2.3, 0.0, 1.0, 0.0, 0.2]]),
    (Bwraps, &[&[0.8, 0.2, 1.7, 0.9, -0.6], &[4.0, -0.5, 3.0, 0.0, 1.2], &[0.0, 0.2, 1.7, 0.9, -0.6]]),
    (Shredlin, &[&[0.7, 0.4, 1.3, -0.8]]),
    (PointSymmetryWf, &[&[0.25, -0.5, 5.0]]),
    (YinYang, &[&[0.4, 0.3, -0.6, 1.0, 1.0], &[0.7, 0.2, 0.0, 0.0, 0.0]]),
    (Glynnia, &[&[]]),
    (EpispiralWf, &[&[4.0]]),
    (Epispiral, &[&[5.0, 0.0, 0.4]]),
    (Fdisc, &[&[]]),
    (Unpolar, &[&[]]),
    (Twoface, &[&[]]),
    (Xheart, &[&[0.6, -0.4]]),
    (Log, &[&[std::f64::consts::E], &[1.8983]]),
    (Acosh, &[&[]]),
    (Acoth, &[&[]]),
    (Cone, &[&[0.5, 0.7, 0.4, 1.7, 1.2, 0.9, 0.8, 1.3, 3.0]]),
    (Idisc, &[&[]]),
    (Cardioid, &[&[1.0], &[3.0]]),
    (Asteria, &[&[0.0], &[0.3]]),
    (Circlize, &[&[0.4]]),
    (Eclipse, &[&[0.1], &[-3.0]]),
    (Ennepers2, &[&[0.9, 0.4, 0.1]]),
    (Joukowski, &[&[0.8, 0.3, 0.0], &[0.8, 0.3, 1.0]]),
    (Petal, &[&[]]),
    (Julian2, &[&[3.0, 0.8, 0.9, 0.2, -0.4, 1.1, 0.3, -0.2], &[-2.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0]]),
    (HeartWf, &[&[1.2, 0.0, 1.0, 1.0], &[0.8, 3.0, 1.4, 0.7]]),
    (Waves3, &[&[0.3, -0.4, 1.7, 2.3, 0.8, 1.9]]),
    (Waves22, &[&[0.3, -0.4, 1.7, 2.3, 0.0, 0.0, 3.7, 2.0], &[0.3, -0.4, 1.7, 2.3, 1.0, 1.0, 7.5, 0.0]]),
    (RoseWf, &[&[0.5, 4.0, 0.0]]),
    (Sph3D, &[&[0.75, 1.1, 0.5]]),
    (Tancos, &[&[]]),
    (Tanhq, &[&[]]),
    (Taurus, &[&[1.4, 3.0, 1.5, 0.7]]),
    (TargetSp, &[&[0.3, 1.0, 0.9, 0.6]]),
    (WhitneyUmbrella, &[&[]]),
    (Sec2Bs, &[&[1.25, 0.75, 1.1, 0.5]]),
    (Stwin, &[&[1.0, 0.4, 3.0, 2.0]]),
    (Hypertile3D, &[&[3.0, 7.0, 1.0], &[5.0, 4.0, 3.0]]),
    (Gnarly, &[&[0.8, 0.6], &[-0.3, 0.2], &[0.0, 1.0]]),
    (PowBlock, &[&[4.0, 3.0, 1.0, 1.0, 1.0], &[3.0, 2.0, 1.0, 0.9, 1.2]]),
];

/// All images of a point, each as likely as the others, before the weight.
#[expect(clippy::wildcard_enum_match_arm, reason = "all others are elsewhere")]
fn images(kind: Kind, q: &[f64], w: f64, [x, y, z]: [f64; 3]) -> Vec<[f64; 3]> {
    let zeta = C(x, y);
    let (r, theta) = (zeta.size(), x.atan2(y));
    let one = |point: [f64; 3]| vec![point];
    match kind {
        YinYang => yin_yang(q, zeta),
        Epispiral => one(C::polar(1.0 / (q[0] * zeta.angle()).cos() - q[2], zeta.angle()).flat()),
        EpispiralWf => one(C::polar(0.5 / (q[0] * theta).cos(), FRAC_PI_2 - theta).flat()),
        Fdisc => one(C::polar(f64::midpoint(zeta.angle() / PI, 1.0), TAU / (1.0 + r)).flat()),
        Unpolar => {
            let e = C(y, x).exp();
            one([e.1 / TAU, e.0 / TAU, 0.0])
        }
        Twoface => one(if x > 0.0 { (C(1.0, 0.0) / C(x, -y)).flat() } else { [x, y, 0.0] }),
        Xheart => {
            let k = 1.0 / (r * r + 4.0);
            let turned = C(4.0 * x * k, (6.0 + 2.0 * q[1]) * y * k) * C::polar(1.0, FRAC_PI_4 + q[0] * FRAC_PI_8);
            one(if turned.0 > 0.0 { turned.flat() } else { [turned.0, -turned.1, 0.0] })
        }
        Waves2b | Waves2Wf | Waves3Wf => one(waves(kind, q, [x, y])),
        Bwraps => one(wrapped(q, zeta).flat()),
        Shredlin => one([shredded(x, q[0], q[1]), shredded(y, q[2], q[3]), 0.0]),
        _ => among_several(kind, q, w, [x, y, z]),
    }
}

/// The same of those that choose among several.
#[expect(clippy::wildcard_enum_match_arm, reason = "all others are elsewhere")]
fn among_several(kind: Kind, q: &[f64], w: f64, [x, y, z]: [f64; 3]) -> Vec<[f64; 3]> {
    let (zeta, r) = (C(x, y), x.hypot(y));
    let whole = |count: f64| (0..count.abs() as u32).map(f64::from);
    match kind {
        Juliac => whole(q[0])
            .map(|k| (C(q[2] * r.ln(), zeta.angle() + TAU * k) * C(1.0 / q[0], q[1] / 100.0)).exp().flat())
            .collect(),
        Juliaq => {
            let main = (zeta.ln() * C(q[1] / q[0], 0.0)).exp();
            whole(q[0]).map(|k| (main * C::polar(1.0, TAU * k / q[0])).flat()).collect()
        }
        EJulia => {
            let zeta = if q[0] < 0.0 { C(1.0, 0.0) / C(x, -y) } else { zeta };
            let area = (zeta + (zeta - C(1.0, 0.0)).sqrt() * (zeta + C(1.0, 0.0)).sqrt()).ln();
            let back = |k: f64| {
                let part = (area + C(0.0, TAU * k)) * C(1.0 / q[0], 0.0);
                ((part.exp() + (C(0.0, 0.0) - part).exp()) * C(0.5, 0.0)).flat()
            };
            whole(q[0]).map(back).collect()
        }
        BTransform => {
            let bipolar = ((zeta + C(1.0, 0.0)) / (zeta - C(1.0, 0.0))).ln();
            let back = |k: f64| {
                let sigma = (-bipolar.1 + q[0] + TAU * k) / q[1];
                let e = C(bipolar.0 / q[1] + q[2], -sigma).exp();
                ((e + C(1.0, 0.0)) / (e - C(1.0, 0.0))).flat()
            };
            whole(q[1]).map(back).collect()
        }
        Acosech => {
            let u = C(1.0, 0.0) / zeta;
            let C(re, im) = (u + (u - C(1.0, 0.0)).sqrt() * (u + C(1.0, 0.0)).sqrt()).ln();
            [1.0, -1.0].map(|sign| [sign * im / FRAC_PI_2, sign * re / FRAC_PI_2, 0.0]).to_vec()
        }
        Hypertile => vec![tiled(zeta, tile(q) * C::polar(1.0, TAU * q[2] / q[0])).flat()],
        Hypertile1 => whole(q[0]).map(|k| tiled(zeta, tile(q) * C::polar(1.0, TAU * k / q[0])).flat()).collect(),
        Hypertile2 => whole(q[0]).map(|k| (tiled(zeta, tile(q)) * C::polar(1.0, TAU * k / q[0])).flat()).collect(),
        PointSymmetryWf => {
            let centre = C(q[0], q[1]);
            let turned = |k: f64| centre + (zeta - centre) * C::polar(w, -TAU * k / q[2]);
            whole(q[2]).map(|k| (turned(k) * C(1.0 / w, 0.0)).flat()).collect()
        }
        AxisSymmetryWf => {
            // The second direction of the plane in which it turns, and where its centre is after that.
            let (axis, second) = (q[0] as usize, if q[0] == 2.0 { 2 } else { 1 });
            let base = if q[0] == 2.0 && q[4] == 0.0 { q[3] } else { q[2] };
            let moved = |sign: f64| {
                let mut point = [x, y, z];
                point[axis] = q[1 + axis] + sign * (point[axis] - q[1 + axis] + w / 2.0);
                let off = C(point[0] - q[1], point[second] - q[1 + second]);
                let turned = off * C::polar(1.0, -sign * q[4].to_radians());
                (point[0], point[second]) = (q[1] + turned.0, base + turned.1);
                point.map(|part| part / w)
            };
            vec![moved(1.0), moved(-1.0)]
        }
        EllipticMirrored => {
            // Half the sum of the distances from the foci at -1 and 1.
            let mu = f64::midpoint((zeta + C(1.0, 0.0)).size(), (zeta + C(-1.0, 0.0)).size());
            let rise = (mu + (mu - 1.0).sqrt()).ln() / FRAC_PI_2;
            [1.0, -1.0].map(|sign| [(x / mu).asin() / FRAC_PI_2, sign * rise, 0.0]).to_vec()
        }
        Glynnia => {
            let side = if r > 1.0 { 1.0 } else { -1.0 };
            let d = (r + x).sqrt();
            let direction = C(r + x, y) * C(1.0 / (r.sqrt() * C(r + x, y).size()), 0.0);
            vec![[side * d / 2.0_f64.sqrt(), -y / d / 2.0_f64.sqrt(), 0.0], [side * direction.0, direction.1, 0.0]]
        }
        _ => in_space(kind, q, w, [x, y, z]),
    }
}

/// The same of those that know z.
#[expect(clippy::wildcard_enum_match_arm, reason = "all others are elsewhere")]
fn in_space(kind: Kind, q: &[f64], w: f64, point: [f64; 3]) -> Vec<[f64; 3]> {
    let [x, y, z] = point;
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let size = dot(point, point).sqrt();
    let inverted = |p: [f64; 3]| p.map(|part| part / dot(p, p));
    let (zeta, theta) = (C(x, y), x.atan2(y));
    let one = |point: [f64; 3]| vec![point];
    match kind {
        Spherical3D => one(inverted(point)),
        Spherical3DWf => one(point.map(|part| part * (1.0 - 2.0 * q[0]) / size.powf(q[1]))),
        Hemisphere => one([x, y, 1.0].map(|part| part / (x * x + y * y + 1.0).sqrt())),
        // Move by the centre, seen inside out.
        Curl3D => {
            let p = inverted(point);
            one(inverted([p[0] + q[0], p[1] - q[1], p[2] + q[2]]))
        }
        Blob3D => {
            let wave = (q[2] * theta).sin();
            let rho = zeta.size() * (q[0] + (q[1] - q[0]) * (1.0 + wave) / 2.0);
            one([rho * theta.sin(), rho * theta.cos(), rho * wave])
        }
        LinearT3D => {
            let part = |value: f64, power: f64| value.signum() * (power * value.abs().ln()).exp();
            one([part(x, q[0]), part(y, q[1]), part(z, q[2])])
        }
        // Möbius addition in the ball.
        Poincare3D => {
            let (a, b) = (q[1] * FRAC_PI_2, q[2] * FRAC_PI_2);
            let c = [-q[0] * a.cos() * b.cos(), q[0] * a.sin() * b.cos(), -q[0] * b.sin()];
            let (along, c2, p2) = (dot(c, point), dot(c, c), size * size);
            let under = 1.0 - 2.0 * along + c2 * p2;
            one([0, 1, 2].map(|i| ((1.0 - c2) * point[i] - (1.0 - 2.0 * along + p2) * c[i]) / under))
        }
        Bubble2 => {
            let t = 4.0 / (size * size + 4.0);
            let side = if z < 0.0 { -1.0 } else { 1.0 };
            one([q[0] * x * t, q[1] * y * t, z + side * q[2] + q[2] * z * t])
        }
        RotateY => {
            let turned = C(x, z) * C::polar(1.0, w * FRAC_PI_2);
            one([turned.0 / w, y / w, turned.1 / w])
        }
        Waves2In3D => one([
            x + q[1] * (y * q[0]).sin(),
            y + q[1] * (x * q[0]).sin(),
            z + q[1] * (f64::midpoint(x, y) * q[0]).sin(),
        ]),
        _ => roots_in_space(kind, q, w, point),
    }
}

/// The same of roots.
#[expect(clippy::wildcard_enum_match_arm, reason = "all others are elsewhere")]
fn roots_in_space(kind: Kind, q: &[f64], w: f64, [x, y, z]: [f64; 3]) -> Vec<[f64; 3]> {
    let zeta = C(x, y);
    let roots = |power: f64, zeta: C| {
        let angle = zeta.angle();
        (0..power.abs() as u32).map(move |k| C::polar(1.0, (angle + TAU * f64::from(k)) / power))
    };
    match kind {
        Julia3D => {
            let z = z / q[0].abs();
            let s = zeta.size().hypot(z);
            let grown = s.powf(1.0 / q[0]) / s;
            roots(q[0], zeta)
                .map(|C(c, s)| [c, s, 0.0].map(|p| p * grown * zeta.size()))
                .map(|[x, y, _]| [x, y, grown * z])
                .collect()
        }
        Julia3Dz => {
            let rho = zeta.size().powf(1.0 / q[0]);
            roots(q[0], zeta).map(|C(c, s)| [rho * c, rho * s, rho * z / q[0].abs() / zeta.size()]).collect()
        }
        Julian3Dx => {
            let z = z / q[1].abs();
            let s = zeta.size().hypot(z);
            let grown = s.powf(q[0] / q[1]) / s;
            let seen = C(q[2] * x + q[3] * y + q[6], q[4] * x + q[5] * y + q[7]);
            let rho = grown * zeta.size();
            roots(q[1], seen).map(|C(c, s)| [rho * c, rho * s, grown * z]).collect()
        }
        _ => super::expected_later::images(kind, q, w, [x, y, z]),
    }
}

fn waves(kind: Kind, q: &[f64], [x, y]: [f64; 2]) -> [f64; 3] {
    if kind == Waves2b {
        let height = |at: f64, near: f64, far: f64| far + (near - far) * q[8] / (q[8] + at.powi(2));
        let wave = |at: f64, power: f64, frequency: f64| (frequency * at.abs().powf(power) * at.signum()).sin();
        let moved_x = x + height(x, q[4], q[5]) * wave(y, q[2], q[0]);
        return [moved_x, y + height(y, q[6], q[7]) * wave(x, q[3], q[1]), 0.0];
    }
    let power = if kind == Waves3Wf { 2 } else { 1 };
    let moved = |at: f64, by: f64, scale: f64, frequency: f64, is_cos: f64, damp: f64| {
        let angle = by * frequency + is_cos * FRAC_PI_2;
        (at + damp.exp() * scale * angle.sin().powi(power)) * damp.exp()
    };
    [moved(x, y, q[0], q[2], q[4], q[6]), moved(y, x, q[1], q[3], q[5], q[7]), 0.0]
}

fn tile(q: &[f64]) -> C {
    let (p, q) = ((TAU / q[0]).cos(), (TAU / q[1]).cos());
    C((1.0 - (p - 1.0) / (p + q)).powf(-0.5), 0.0)
}

fn tiled(zeta: C, s: C) -> C {
    (zeta + C(s.0, -s.1)) / (s * zeta + C(1.0, 0.0))
}

fn wrapped(q: &[f64], zeta: C) -> C {
    if q[0] == 0.0 {
        return zeta;
    }
    let middle = |value: f64| (value / q[0]).floor() * q[0] + q[0] / 2.0;
    let centre = C(middle(zeta.0), middle(zeta.1));
    let off = zeta - centre;
    let rho = q[0] / 2.0 / (1.0 + q[1].powi(2));
    if off.size() > rho {
        return zeta;
    }
    let gain = q[2].powi(2) + 1e-6;
    let border = if gain * rho > 2.0 { 1.0 } else { gain * rho / ((gain * rho).powi(2) / 4.0 + 1.0) };
    let far = gain * off.size() * (rho / border) / ((gain * off.size()).powi(2) / 4.0 + 1.0);
    let t = (far / rho).powi(2);
    centre + C::polar(far, off.angle() - (q[3] * (1.0 - t) + q[4] * t))
}

fn shredded(value: f64, distance: f64, width: f64) -> f64 {
    let cells = value / distance;
    let side = if value < 0.0 { -0.5 } else { 0.5 };
    distance * (cells.fract() * width + cells.trunc() + side * (1.0 - width))
}

fn yin_yang(q: &[f64], zeta: C) -> Vec<[f64; 3]> {
    if zeta.size() >= 1.0 {
        return vec![if q[4] == 0.0 { [0.0; 3] } else { zeta.flat() }];
    }
    let half = |rho: f64, turn: f64, sign: f64| {
        let C(x, y) = zeta * C::polar(1.0, PI * turn);
        let (x, y) = if y <= 0.0 {
            (x * (1.0 - rho) + rho, y * (1.0 - rho))
        } else {
            let t = (1.0 - y * y).sqrt();
            let (high, alpha) = (2.0 * t - 1.0, (1.0 - x / t) / 2.0);
            let m = alpha * rho + 1.0 - alpha;
            (high * m + alpha * (rho - 1.0), (1.0 - high * high).sqrt() * m)
        };
        [sign * x, sign * y, 0.0]
    };
    let first = half(q[0], q[1], 1.0);
    if q[3] == 0.0 { vec![first] } else { vec![first, half(1.0 - q[0], q[2], -1.0)] }
}

#[test]
fn foreign_formulas_give_the_images_that_are_expected() {
    for (kind, sets) in CASES.into_iter().chain(PROBED) {
        for (q, w) in sets.iter().flat_map(|q| [(q, 0.7), (q, -1.3)]) {
            let compiled = compiled(kind, w, q);
            let mut padded = [0.0; MAX_PARAMETERS];
            padded[..q.len()].copy_from_slice(q);
            let mut random = Rng::stream(7, kind as u64);
            for point in points() {
                let expected = images(kind, &padded, w, point);
                let mut drawn = vec![0_u32; expected.len()];
                let times = if expected.len() == 1 { 1 } else { 60 * expected.len() };
                for _ in 0..times {
                    let found = kind.visit(At(&compiled, point, &mut random));
                    let error = |image: &[f64; 3]| {
                        let far = (0..3).map(|i| (image[i] * w - found[i]).abs()).fold(0.0, f64::max);
                        far / (1.0 + found.iter().fold(0.0, |most: f64, part| most.max(part.abs())))
                    };
                    let which =
                        (0..expected.len()).min_by(|a, b| error(&expected[*a]).total_cmp(&error(&expected[*b])));
                    let which = which.unwrap();
                    assert!(error(&expected[which]) < 1e-7, "{kind:?} {q:?} of {point:?}: {found:?}, not {expected:?}");
                    drawn[which] += 1;
                }
                // Images that lie on each other are counted as one.
                let is_fair = |count: &u32| (20..=120).contains(count);
                let distinct = drawn.iter().filter(|count| **count > 0).count() == drawn.len();
                assert!(expected.len() == 1 || distinct && drawn.iter().all(is_fair), "{kind:?} {q:?}: {drawn:?}");
            }
        }
    }
}
