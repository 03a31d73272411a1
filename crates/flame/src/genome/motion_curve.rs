//! Curves over time of a transform's affine parts: their values at the frame of the genome.
//!
//! Owns the spelling of JWildfire's motion curves in the plane of x and y, and their interpolation. What they say at the
//! frame becomes the transform's; which frame that was stays as an attribute, since the motion itself is not drawn. Never
//! reads a curve of another kind: `attributes.rs` refuses those.
//!
//! Start at [`settle`].
//!
//! # Source
//! What JWildfire makes of coefficients by curves of chosen points, at frames between, before and after them.

use std::collections::HashMap;

use super::parse::list;
use super::value::integer;
use super::{Affine, Xform};

/// The attribute of a transform whose curves were replaced by their values at a frame, which is its value.
pub(super) const AT_FRAME: &str = "drawn_at_frame";

/// The names of the curves of coefficients after that of the affine part, column by column.
const COEFFICIENTS: [&str; 6] = ["Coeff00", "Coeff01", "Coeff10", "Coeff11", "Coeff20", "Coeff21"];

/// Replaces curves of `xform` by their values at `frame`, a whole number. A curve that cannot be read stays, and is refused.
pub(super) fn settle(xform: &mut Xform, frame: Option<&str>) {
    let Some(frame) = frame.and_then(integer::<i32>) else { return };
    let Xform { affine, post, extra, .. } = xform;
    let said: HashMap<&str, &str> = extra.iter().map(|(name, value)| (&**name, &**value)).collect();
    let mut settled = Vec::new();
    for (part, prefix) in [(affine, "xy"), (post, "xyPost")] {
        let before = settled.len();
        let mut value = |name: &str| {
            let curve = format!("{prefix}{name}Curve_");
            let value = Curve::read(&said, &curve)?.at(f64::from(frame))?;
            settled.push(curve);
            Some(value)
        };
        let mut columns = part.columns();
        for (column, name) in columns.iter_mut().zip(COEFFICIENTS) {
            *column = value(name).unwrap_or(*column);
        }
        let [a, d, b, e, c, f] = columns;
        let turned = Affine { a, b, c, d, e, f }.turned(-value("Rotate").unwrap_or(0.0).to_radians());
        let size = value("Scale").unwrap_or(1.0);
        if settled.len() > before {
            *part = Affine { a: turned.a * size, b: turned.b * size, d: turned.d * size, e: turned.e * size, ..turned };
        }
    }
    if !settled.is_empty() {
        extra.retain(|(name, _)| !settled.iter().any(|curve| name.starts_with(curve)));
        extra.push((AT_FRAME.into(), frame.to_string()));
    }
}

/// A curve over time.
struct Curve {
    /// Frames, which increase, and values.
    points: Vec<[f64; 2]>,
    is_smooth: bool,
}

impl Curve {
    /// The curve whose attributes begin with `prefix`, if it is enabled and in order.
    fn read(said: &HashMap<&str, &str>, prefix: &str) -> Option<Curve> {
        let of = |part: &str| said.get(&*format!("{prefix}{part}")).map(|value| value.trim());
        let number = |part: String| match *list::<f64>(of(&part)?)? {
            [number] if number.is_finite() => Some(number),
            _ => None,
        };
        let is_smooth = match of("interpolation")? {
            "SPLINE" => true,
            "LINEAR" => false,
            _ => return None,
        };
        let count = of("point_count")?.parse().ok().filter(|count| (1..=said.len()).contains(count))?;
        let point = |at| Some([number(format!("x{at}"))?, number(format!("y{at}"))?]);
        let points = (0..count).map(point).collect::<Option<Vec<_>>>()?;
        let is_in_order =
            of("enabled")?.eq_ignore_ascii_case("true") && points.windows(2).all(|it| it[0][0] < it[1][0]);
        is_in_order.then_some(Curve { points, is_smooth })
    }

    /// Its value at `frame`: that of the nearest point outside of the points. `None` where it goes back in time.
    fn at(&self, frame: f64) -> Option<f64> {
        let points = &self.points;
        let (first, last) = (points[0], points[points.len() - 1]);
        if frame <= first[0] || frame >= last[0] {
            return Some(if frame <= first[0] { first[1] } else { last[1] });
        }
        let after = points.iter().position(|point| frame < point[0])?;
        let (from, to) = (points[after - 1], points[after]);
        if !self.is_smooth {
            return Some(from[1] + (to[1] - from[1]) * (frame - from[0]) / (to[0] - from[0]));
        }
        // The first and the last point count twice.
        let around = [points[after.saturating_sub(2)], from, to, points[(after + 1).min(points.len() - 1)]];
        let [times, values] = [0, 1].map(|axis| around.map(|point| point[axis]));
        increases(times).then(|| mixture(values, part_at(times, frame)))
    }
}

/// How much of each of four points is in one between the second and the third (Catmull and Rom).
pub(crate) fn catmull_rom(part: f64) -> [f64; 4] {
    let (square, cube) = (part * part, part * part * part);
    [-part + 2.0 * square - cube, 2.0 - 5.0 * square + 3.0 * cube, part + 4.0 * square - 3.0 * cube, cube - square]
        .map(|doubled| doubled / 2.0)
}

fn mixture(numbers: [f64; 4], part: f64) -> f64 {
    numbers.iter().zip(catmull_rom(part)).map(|(number, weight)| number * weight).sum()
}

/// Whether a mixture of `times`, which increase, grows with its part everywhere.
fn increases([a, b, c, d]: [f64; 4]) -> bool {
    // The slope is a parabola, and not below 0 at both ends.
    let (first, bend, third) = ((c - a) / 2.0, a - 2.5 * b + 2.0 * c - d / 2.0, (3.0 * (b - c) + d - a) / 2.0);
    let is_lowest_within = third > 0.0 && -bend > 0.0 && -bend < 3.0 * third;
    !is_lowest_within || first - bend * bend / (3.0 * third) >= 0.0
}

/// The part at which a mixture of `times` that increases is `time`, by halving.
fn part_at(times: [f64; 4], time: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..f64::MANTISSA_DIGITS {
        let middle = f64::midpoint(low, high);
        *(if mixture(times, middle) < time { &mut low } else { &mut high }) = middle;
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Genome;
    use crate::genome::unsupported::Why;

    /// `points` as attributes of a curve.
    fn attributes(curve: &str, interpolation: &str, points: &[(i32, f64)]) -> String {
        let point =
            |(at, (x, y)): (usize, &(i32, f64))| format!(" {curve}Curve_x{at}=\"{x}\" {curve}Curve_y{at}=\"{y}\"");
        let points: String = points.iter().enumerate().map(point).collect::<String>()
            + &format!(" {curve}Curve_point_count=\"{}\"", points.len());
        format!(" {curve}Curve_enabled=\"true\" {curve}Curve_interpolation=\"{interpolation}\"{points}")
    }

    fn genome(frame: &str, curves: &str) -> Genome {
        let text = format!(
            "<flame version=\"JWILDFIRE 9.00\" size=\"8 8\"{frame}><xform weight=\"1\" linear=\"1\" color=\"0\" \
             coefs=\"1 0.25 -0.5 2 0.3 0.4\" post=\"1 0.25 -0.5 2 0.3 0.4\"{curves}/></flame>"
        );
        Genome::parse(&text).unwrap()
    }

    #[track_caller]
    fn assert_near(found: [f64; 6], expected: [f64; 6]) {
        let error = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 2e-6, "{found:?} instead of {expected:?}");
    }

    #[test]
    fn values_at_frames_are_those_of_its_program() {
        type Points = &'static [(i32, f64)];
        let cases: [(Points, Points); 4] = [
            (&[(-300, 0.7)], &[(-301, 0.7), (5, 0.7)]),
            (&[(-100, 0.2), (900, -1.5)], &[(-200, 0.2), (250, -0.395), (900, -1.5)]),
            (
                &[(-4000, 0.3), (1000, 1.5), (3000, -0.4)],
                &[(-3777, 0.359_740_8), (123, 1.441_029_1), (2222, 0.742_208_2)],
            ),
            (
                &[(-3000, -1.5), (2000, 2.25), (5000, -0.25), (9000, 1.75), (17000, 0.5)],
                &[
                    (-2500, -1.079_331_7),
                    (-1, 1.095_327_8),
                    (3456, 1.263_512_9),
                    (7000, 0.919_858_8),
                    (12345, 1.415_505_8),
                ],
            ),
        ];
        let at = |points: &[(i32, f64)], frame| {
            let points = points.iter().map(|(x, y)| [f64::from(*x), *y]).collect();
            Curve { points, is_smooth: true }.at(f64::from(frame)).unwrap()
        };
        for (points, values) in cases {
            for (frame, value) in values {
                assert!((at(points, *frame) - value).abs() < 2e-6, "{points:?} at {frame}: {}", at(points, *frame));
            }
        }
    }

    #[test]
    fn curves_change_coefficients_then_turn_and_scale() {
        let to = |curve: &str, value| attributes(curve, "SPLINE", &[(0, 0.0), (10, value)]);
        let part = |curves: &str| genome(" frame=\"5\"", curves).xforms[0].affine.columns();
        let turned = [0.991_025_404, -0.283_493_649, 0.566_987_298, 1.982_050_808, 0.3, 0.4];
        assert_near(part(&to("xyRotate", 60.0)), turned);
        assert_near(part(&to("xyScale", 3.0)), [1.5, 0.375, -0.75, 3.0, 0.3, 0.4]);
        let both = [1.486_538_106, -0.425_240_474, 0.850_480_947, 2.973_076_211, 0.3, 0.4];
        assert_near(part(&(to("xyRotate", 60.0) + &to("xyScale", 3.0))), both);
        let by_one = [1.424_038_106, -0.533_493_649, 0.566_987_298, 1.982_050_808, 0.3, 0.4];
        assert_near(part(&(to("xyRotate", 60.0) + &to("xyCoeff00", 3.0))), by_one);
        let others = to("xyCoeff01", 9.0) + &to("xyCoeff10", 11.0) + &to("xyCoeff20", 12.0);
        assert_near(part(&others), [1.0, 4.5, 5.5, 2.0, 6.0, 0.4]);
        let post = genome(" frame=\"5\"", &to("xyPostRotate", 60.0)).xforms[0].clone();
        assert_near(post.post.columns(), turned);
        assert_near(post.affine.columns(), [1.0, 0.25, -0.5, 2.0, 0.3, 0.4]);
    }

    #[test]
    fn the_frame_is_named_and_a_written_genome_reads_back() {
        let curves = attributes("xyCoeff20", "LINEAR", &[(-3, 1.0), (7, 2.0)]);
        let found = genome(" frame=\"2\"", &curves);
        let [reason] = &*found.unsupported().without.0 else { panic!("{:?}", found.unsupported()) };
        assert_eq!((&*reason.name, &*reason.value, reason.why), (AT_FRAME, "2", Why::Frame));
        assert!(found.unsupported().refused.is_empty());
        assert_near(found.xforms[0].affine.columns(), [1.0, 0.25, -0.5, 2.0, 1.5, 0.4]);
        let again = Genome::parse(&found.to_xml()).unwrap();
        assert_eq!((&again.xforms, again.unsupported()), (&found.xforms, found.unsupported()));
    }

    #[test]
    fn other_curves_are_refused() {
        let points = [(0, 1.0), (10, 2.0)];
        let fine = attributes("xyCoeff20", "SPLINE", &points);
        for (frame, curves) in [
            ("", fine.clone()),
            (" frame=\"2.5\"", fine.clone()),
            (" frame=\"2\"", attributes("xyCoeff20", "BEZIER", &points)),
            (" frame=\"2\"", attributes("xyCoeff20", "SPLINE", &[(0, 1.0), (0, 2.0)])),
            (" frame=\"50\"", attributes("xyCoeff20", "SPLINE", &[(0, 1.0), (48, 2.0), (52, 1.0), (100, 2.0)])),
            (" frame=\"2\"", attributes("xyCoeff20", "SPLINE", &[])),
            (" frame=\"2\"", fine.replace("x1=\"10\"", "x1=\"inf\"")),
            (" frame=\"2\"", fine.replace("point_count=\"2\"", "point_count=\"900000000\"")),
            (" frame=\"2\"", attributes("yzCoeff20", "SPLINE", &points)),
        ] {
            let found = genome(frame, &curves);
            let whys: Vec<Why> = found.unsupported().refused.0.iter().map(|reason| reason.why).collect();
            assert_eq!(whys, [Why::Curve], "{frame}{curves}");
            assert_near(found.xforms[0].affine.columns(), [1.0, 0.25, -0.5, 2.0, 0.3, 0.4]);
        }
    }
}
