//! What the formulas that change colours, and those found by probing JWildfire point by point, compute: in `f64` and in
//! other words.
//!
//! Owns their images and colours, and the claim that every formula is compared with another one somewhere. `expected.rs` and
//! `expected_chance.rs` try the cases here, too.

use std::f64::consts::{PI, TAU};

use super::Kind::{self, *};
use super::expected::{At, C, CASES, compiled, points};
use super::expected_chance::RANDOM;
use super::expected_synth::{synth, synthesised};
use crate::number::Random;
use crate::{Coloured, Compiled, Formula, Variation, Visitor};
use species::Rng;

const SWELLING: [f64; 26] = [
    0.3, 1.2, 0.9, 0.25, 0.1, 1.4, 0.8, 1.3, -0.3, 0.2, 0.5, 0.1, 0.3, 0.2, -0.4, 0.15, 0.2, 0.1, 0.1, 0.3, 0.2, 0.1,
    0.3, 0.2, 0.4, 0.1,
];

/// Parameters with which these formulas are tried.
pub(super) const PROBED: [(Kind, &[&[f64]]); 6] = [
    (DcLinear, &[&[0.1, 0.3, 0.8]]),
    (
        Truchet,
        &[
            &[0.0, 2.0, 0.5, 0.0, 1.0, 50.0, 0.0],
            &[0.0, 1.0, 0.9, 0.4, 1.3, 7.5, 0.0],
            &[0.0, 1.0, 0.9, 0.4, 1.3, 1.0, 0.0],
        ],
    ),
    // Both hexagons are as likely.
    (Xtrb, &[&[2.0, 1.0, std::f64::consts::FRAC_1_SQRT_2, 1.0, 1.0, 1.0]]),
    (Waves4, &[&[0.3, 0.2, 8.0, 7.3, 0.0, 0.18], &[0.3, 0.2, 8.0, 7.3, 1.0, 0.18]]),
    (Vibration2, &[&SWELLING, &[0.0, 1.57, 1.0, 0.25, 0.2, 1.57, 1.57, 1.5, 0.25, 0.3]]),
    (
        Synth,
        &[
            &synth(0.0, -0.2, 0.0),
            &synth(1.0, -1.0, 0.0),
            &synth(5.0, -1.0, 0.0),
            &synth(5.0, -1.0, 1.0),
            &synth(6.0, -1.0, 1.0),
            &synth(7.0, -1.0, 0.0),
            &synth(8.0, -1.0, 1.0),
            &synth(9.0, -1.0, 0.0),
            &synth(10.0, -1.0, 0.0),
            &synth(11.0, -1.0, 0.0),
            &synth(14.0, -0.2, 0.0),
            &synth(15.0, -0.2, 0.0),
            &synth(16.0, -0.2, 0.0),
            &synth(17.0, -1.0, 0.0),
            &synth(18.0, -1.0, 0.0),
            &synth(19.0, 1.5, 0.0),
        ],
    ),
];

/// All images of a point, each as likely as the others, before the weight.
#[expect(clippy::wildcard_enum_match_arm, reason = "all others are elsewhere")]
pub(super) fn images(kind: Kind, q: &[f64], w: f64, [x, y, _]: [f64; 3]) -> Vec<[f64; 3]> {
    match kind {
        DcLinear => vec![[x, y, 0.0]],
        Truchet => {
            let [x, y] = truchet(q, w, [x, y]);
            vec![[x / w, y / w, 0.0]]
        }
        Xtrb => [true, false].into_iter().flat_map(|is_inner| hexagons(q, w, C(x, y), is_inner)).collect(),
        Waves4 => {
            let strip = (y * q[2] / TAU).floor();
            let height = ((strip * (12.9898 + 78.233) + 1.0 + y * q[5] / 1000.0).sin() * 43_758.545_3).fract();
            let height = if q[4] == 0.0 { height } else { f64::from(height > 0.5) };
            vec![[x + q[0] * height.powi(2) * (y * q[2]).sin(), y + q[1] * (x * q[3]).sin(), 0.0]]
        }
        Vibration2 => {
            let moved = C(x, y) + vibrated(C(x, y), &q[..5], &q[10..18]) + vibrated(C(x, y), &q[5..10], &q[18..26]);
            vec![[moved.0, moved.1, 0.0]]
        }
        Synth => vec![synthesised(q, x, y)],
        _ => panic!("{kind:?} has no expected image"),
    }
}

fn vibrated(zeta: C, wave: &[f64], swells: &[f64]) -> C {
    let along = (zeta * C::polar(1.0, -wave[0])).0;
    let swell = |place: usize| swells[2 * place] * (TAU * swells[2 * place + 1] * along).cos();
    let direction = wave[0] + swell(0);
    let along = (zeta * C::polar(1.0, -direction)).0;
    let phase = TAU * (along * wave[2] + wave[4] / wave[2]) + swell(2) / wave[2];
    C::polar(wave[3] * (1.0 + swell(3)) * phase.sin(), direction + wave[1] + swell(1))
}

fn truchet(q: &[f64], w: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    let norm = q[1];
    let scale = (q[3].cos() + q[3].sin()) / w;
    let part = |value: f64| {
        let left = value * scale - (value * scale + 0.5).floor();
        if left < 0.0 { left + 1.0 } else { left }
    };
    let (part_x, part_y) = (part(x), part(y));
    let is_crossed = if q[5] == 1.0 {
        true
    } else {
        let g = (1.5 * q[5]).sqrt() / (2.0 * q[5]);
        let (i, j) = ((x + 0.5).floor() * g, (y + 0.5).floor() * g);
        let hash = ((q[5] + i + j + i * j) * g / 2.0 * 32_747.0 + 12_345.0) % 65_535.0;
        hash % 2.0 >= 1.0
    };
    let corners = if is_crossed { [[1.0, 0.0], [0.0, 1.0]] } else { [[0.0, 0.0], [1.0, 1.0]] };
    let is_in = |[at_x, at_y]: [f64; 2]| {
        let rho = ((part_x - at_x).abs().powf(norm) + (part_y - at_y).abs().powf(norm)).powf(1.0 / norm);
        (rho - 0.5).abs() < (2.0_f64.powf(1.0 / norm) - 1.0) / 2.0 * q[2]
    };
    let times = corners.into_iter().filter(|corner| is_in(*corner)).count() as f64 * q[4];
    [times * (part_x + x.floor()), times * (part_y + y.floor())]
}

/// The roots of a point that has gone to the inner hexagon of its triangle, or to the one at a corner.
fn hexagons(q: &[f64], w: f64, zeta: C, is_inner: bool) -> Vec<[f64; 3]> {
    let (r, width) = (q[1], q[2]);
    let (b, c) = (0.047 + q[4], 0.047 + q[5]);
    let halves = [PI - b - c, b, c].map(|angle| (angle / 2.0).tan());
    let sides = [0, 1, 2].map(|i| r * (halves[(i + 1) % 3] + halves[(i + 2) % 3]));
    let area = r * sides.iter().sum::<f64>();
    let high = sides.map(|side| area / side);
    let mut trilinear = [zeta.1 + r, zeta.0 * c.sin() - zeta.1 * c.cos() + r, 0.0];
    let cells = [0, 1].map(|i| (trilinear[i] / high[i]).floor() * high[i]);
    (0..2).for_each(|i| trilinear[i] -= cells[i]);
    trilinear[2] = (area - sides[0] * trilinear[0] - sides[1] * trilinear[1]) / sides[2];
    let is_turned = trilinear[2] <= 0.0;
    let turn = |all: [f64; 3]| if is_turned { [high[0] - all[0], high[1] - all[1], -all[2]] } else { all };
    let mut all = turn(trilinear);
    let mut order = [0, 1, 2];
    order.sort_by(|i, j| all[*j].total_cmp(&all[*i]));
    let [most, middle, least] = order;
    if is_inner {
        let ratio = all[least] / all[middle];
        all[least] = (1.0 - width) * all[least] + width * high[least] / 3.0 * ratio;
        let far = area / (sides[most] + sides[middle]);
        all[middle] = (1.0 - width) * all[middle] + width * far * (1.0 - ratio / 3.0);
    } else {
        all[least] *= width;
        all[middle] *= width;
    }
    all[most] = (area - sides[least] * all[least] - sides[middle] * all[middle]) / sides[most];
    let all = turn(all);
    let y = all[0] + cells[0] - r;
    let x = (all[1] + cells[1] - r + y * c.cos()) / c.sin();
    let root = |k: u32| {
        let size = w * x.hypot(y).powf(q[3] / q[0]);
        let C(x, y) = C::polar(size, (y.atan2(x) + TAU * f64::from(k)) / q[0]);
        [x, y, 0.0]
    };
    (0..q[0].abs() as u32).map(root).collect()
}

/// Random numbers that are known.
pub(super) struct Known(pub(super) Vec<f64>);

impl Random<f64> for Known {
    fn unit(&mut self) -> f64 {
        self.0.remove(0)
    }
    fn coin(&mut self) -> bool {
        self.0.remove(0) < 0.5
    }
}

pub(super) fn with(kind: Kind, q: &[f64], point: [f64; 3], random: &[f64]) -> [f64; 3] {
    kind.visit(At(&compiled(kind, 1.0, q), point, &mut Known(random.to_vec())))
}

pub(super) fn are_near(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9 * (1.0 + a.abs()))
}

#[test]
fn crackles_have_their_sites_at_the_corners_of_a_grid_unless_they_are_moved() {
    let mut random = Rng::stream(6, 6);
    let mut shifts: Vec<f64> = Vec::new();
    for _ in 0..400 {
        let u = [(); 4].map(|()| Rng::unit(&mut random));
        let start = C::polar(f64::midpoint(u[0], u[1]) + (u[2] - 0.5) / 4.0, TAU * u[3]);
        let [x, y] = [start.1, start.0];
        let near = [(x / 0.3).round() * 0.3, (y / 0.3).round() * 0.3];
        let off = [x - near[0], y - near[1]];
        let (most, least) = (off[0].abs().max(off[1].abs()), off[0].abs().min(off[1].abs()));
        // Next to a side of the square, or to its corner.
        let edge = (2.0 * most / 0.3).max((most + least) / 0.3);
        let k = 0.8 * edge.powf(-0.6);
        let expected = [near[0] + off[0] * k, near[1] + off[1] * k];
        assert!(are_near(&with(Crackle, &[0.6, 0.4, 0.0, 0.8, 0.3], [9.0; 3], &u), &expected), "{u:?}");
        let site = |distort: f64, z: f64| with(Crackle, &[0.6, 1.0, distort, 0.0, z], [9.0; 3], &u);
        // A little distortion leaves the nearest site the nearest one, if it is not at the edge.
        if edge < 0.8 {
            shifts.extend([0, 1].map(|axis| (site(0.1, 0.3)[axis] - near[axis]) / 0.03));
            let [a, b] = [0.32, 0.32 + 1e-7].map(|z| site(0.1, z));
            assert!((a[0] - b[0]).abs() < 1e-6 && (a[1] - b[1]).abs() < 1e-6, "{a:?} {b:?}");
            // Whole layers, too.
            let [a, b] = [0.4 - 1e-7, 0.4 + 1e-7].map(|z| site(0.1, z));
            assert!((a[0] - b[0]).abs() < 1e-6 && (a[1] - b[1]).abs() < 1e-6, "{a:?} {b:?}");
        }
    }
    let spread = (shifts.iter().map(|shift| shift * shift).sum::<f64>() / shifts.len() as f64).sqrt();
    assert!((0.2..0.4).contains(&spread), "{spread}");
}

/// A formula in colour as f64 sees it.
struct InColour<'a>(&'a Compiled, Coloured<f64>, &'a mut Known);

impl Visitor for InColour<'_> {
    type Out = ([f64; 3], f64);
    fn visit<F: Formula>(self) -> ([f64; 3], f64) {
        F::in_colour(self.0, self.1, self.2)
    }
}

/// The image of a point with the colour 0.675, after the sum (0.27, -0.99, 0), with these random numbers.
pub(super) fn coloured(kind: Kind, w: f64, q: &[f64], random: &[f64]) -> ([f64; 3], f64) {
    let compiled = compiled(kind, w, q);
    let point = [0.3, -1.1, 0.4];
    let from = Coloured { point, sum: [0.27, -0.99, 0.0], colour: 0.675 };
    let mut known = Known(random.to_vec());
    let found = kind.visit(InColour(&compiled, from, &mut known));
    // What it makes of the point does not depend on whether anyone asks for the colour.
    let flat = kind.visit(At(&compiled, point, &mut Known(random.to_vec())));
    assert_eq!(found.0, flat, "{kind:?}");
    found
}

#[test]
fn colours_are_those_of_jwildfire() {
    // Read off JWildfire's own transforms, with these random numbers.
    let colour = |kind: Kind, w: f64, q: &[f64], random: &[f64]| coloured(kind, w, q, random).1;
    let is = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
    is(colour(DcLinear, 0.5, &[0.1, 0.3, 0.8], &[]), 0.528_837_629_483_932_2);
    is(colour(PointSymmetryWf, 1.0, &[0.25, 0.5, 3.0, 0.4], &[0.5]), 0.075);
    is(colour(PointSymmetryWf, 1.0, &[0.25, 0.5, 3.0, -0.5], &[0.9]), -0.325);
    let shifts = |axis: f64, turn: f64| [axis, 0.25, 0.5, 0.0, turn, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06];
    for (axis, turn, heads, tails) in [
        (0.0, 0.0, 0.685, 0.715),
        (0.0, 20.0, 0.685, 0.715),
        (1.0, 0.0, 0.695, 0.675),
        (1.0, 20.0, 0.695, 0.725),
        (2.0, 0.0, 0.705, 0.735),
        (2.0, 20.0, 0.705, 0.735),
    ] {
        is(colour(AxisSymmetryWf, 1.0, &shifts(axis, turn), &[0.2]), heads);
        is(colour(AxisSymmetryWf, 1.0, &shifts(axis, turn), &[0.7]), tails);
    }
    let far = [10.0, 0.5, 0.6, 0.9, 0.7, 0.75, 0.2, -0.1, 0.3, 0.0, 0.0, 0.5];
    is(colour(Falloff2, 0.9, &far, &[0.9, 0.15, 0.35, 0.8]), 0.797_388_118_520_689_9);
    let (point, _) = coloured(Falloff2, 0.9, &far, &[0.9, 0.15, 0.35, 0.8]);
    assert!(
        are_near(&point, &[0.369_134_376_001_758_8, -0.965_216_405_999_560_6, 0.404_977_633_556_353_5]),
        "{point:?}"
    );
    // A colour that goes round.
    let strong = |mul_c: f64| far.iter().enumerate().map(|(at, value)| if at == 5 { mul_c } else { *value }).collect();
    let strong = |mul_c: f64| {
        colour(
            Falloff2,
            0.9,
            &{
                let all: Vec<f64> = strong(mul_c);
                all
            },
            &[0.9, 0.15, 0.35, 0.8],
        )
    };
    is(strong(-9.0), 0.793_657_422_248_279);
}

#[test]
fn falloff3_is_that_of_jwildfire() {
    let q = |form: f64, is_cube: f64, is_inverted: f64, twist: f64| {
        [form, is_cube, 2.0, 0.3, is_inverted, 0.6, 0.9, 0.7, 0.75, 0.2, -0.1, 0.3, twist]
    };
    for (form, is_cube, is_inverted, twist, expected) in [
        (
            0.0,
            0.0,
            0.0,
            0.0,
            [0.282_168_017_775_297, -0.990_488_623_102_430_1, 0.358_216_985_864_492_3, 0.687_779_108_889],
        ),
        (0.0, 1.0, 0.0, 0.0, [0.282_000_212_040_487, -0.990_475_127_500_586_1, 0.358_266_490_610_915_26, 0.687_6]),
        (0.0, 0.0, 1.0, 0.0, [0.27, -0.99, 0.36, 0.675]),
        (
            1.0,
            0.0,
            0.0,
            0.0,
            [0.255_620_664_790_123_2, -1.007_979_432_497_034, 0.357_866_157_469_841_24, 0.687_779_108_889],
        ),
        (
            1.0,
            0.0,
            0.0,
            0.35,
            [0.230_751_020_741_910_26, -1.013_961_748_307_772, 0.357_866_157_469_841_24, 0.687_779_108_889],
        ),
        (1.0, 1.0, 0.0, -0.4, [0.283_657_011_0, -1.000_251_392_153_930_2, 0.357_897_108_350_969_16, 0.687_6]),
    ] {
        let ([x, y, z], colour) =
            coloured(Falloff3, 0.9, &q(form, is_cube, is_inverted, twist), &[0.9, 0.15, 0.35, 0.8]);
        assert!(
            are_near(&[x, y, z, colour], &expected),
            "{form} {is_cube} {is_inverted} {twist}: {x} {y} {z} {colour}"
        );
    }
}

#[test]
fn only_shifts_of_colours_make_a_variation_one_in_colour() {
    for kind in Kind::ALL {
        let variation = Variation::new(kind, 1.0);
        assert_eq!(variation.changes_colour(), matches!(kind, DcLinear | FractJuliaWf), "{kind:?}");
    }
    for (kind, parameter) in [(Falloff2, 5), (Falloff3, 8), (PointSymmetryWf, 3), (AxisSymmetryWf, 10)] {
        let mut variation = Variation::new(kind, 1.0);
        variation.params[parameter] = -0.3;
        assert!(variation.changes_colour(), "{kind:?}");
    }
}

/// Formulas that touch z alone: what each makes of a point, before the weight.
#[expect(clippy::wildcard_enum_match_arm, reason = "all others are elsewhere")]
fn of_height(kind: Kind, point: [f64; 3]) -> Option<[f64; 3]> {
    let [x, y, z] = point;
    match kind {
        Linear3D => Some(point),
        Zscale => Some([0.0, 0.0, z]),
        Ztranslate => Some([0.0, 0.0, 1.0]),
        Zcone => Some([0.0, 0.0, x.hypot(y)]),
        _ => None,
    }
}

#[test]
fn every_formula_is_compared_with_another_one() {
    let tried: Vec<Kind> = CASES.iter().chain(&RANDOM).chain(&PROBED).map(|(kind, _)| *kind).collect();
    for kind in Kind::ALL.into_iter().filter(|kind| !Kind::FLAM3.contains(kind)) {
        let is_of_height = of_height(kind, [0.0; 3]).is_some() || matches!(kind, Flatten | Zblur);
        assert!(is_of_height != tried.contains(&kind), "{kind:?}");
    }
    for point in points() {
        for (kind, w) in Kind::ALL.into_iter().flat_map(|kind| [(kind, 0.7), (kind, -1.3)]) {
            let Some(expected) = of_height(kind, point) else { continue };
            let found = kind.visit(At(&compiled(kind, w, &[]), point, &mut Known(Vec::new())));
            assert!(are_near(&found, &expected.map(|axis| axis * w)), "{kind:?}: {found:?}");
        }
        let flat = Flatten.visit(At(&compiled(Flatten, 0.4, &[]), point, &mut Known(Vec::new())));
        assert_eq!(flat, [point[0], point[1], 0.0]);
        let blurred = Zblur.visit(At(&compiled(Zblur, 0.5, &[]), point, &mut Known(vec![0.9, 0.8, 0.3, 0.4])));
        assert!(are_near(&blurred, &[0.0, 0.0, 0.2]), "{blurred:?}");
    }
}

#[test]
fn a_weight_of_0_gives_nothing() {
    let sets = CASES.iter().chain(&RANDOM).chain(&PROBED).flat_map(|(kind, sets)| sets.iter().map(|q| (*kind, *q)));
    let by_weight = |(kind, _): &(Kind, &[f64])| !Variation::new(*kind, 1.0).slot().comes_by_presence();
    let gives = |(kind, q): &(Kind, &[f64])| {
        let compiled = compiled(*kind, 0.0, q);
        let found = points().take(40).map(|point| kind.visit(At(&compiled, point, &mut Rng::stream(8, *kind as u64))));
        found.flatten().any(|axis| axis.abs() > 1e-12)
    };
    assert_eq!(sets.filter(by_weight).filter(gives).map(|(kind, _)| kind).collect::<Vec<_>>(), []);
}
