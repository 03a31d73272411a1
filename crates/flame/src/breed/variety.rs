//! Variations by chance.
//!
//! Owns which variations go together, and in which range a parameter makes pictures. Never makes a transform.
//!
//! Start at [`Family`] and [`drawn`].

use species::Rng;

use super::chance::{even, happens, pick};
use variations::{Kind, Variation};

/// How often a transform has one variation alone; else it has two.
const ALONE: f64 = 0.62;
/// How far a parameter moves, of its size or of a part of its range.
const STRIDE: f64 = 0.2;
const PART_OF_RANGE: f64 = 0.1;

/// Variations that make pictures of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Family {
    /// Everything that is soft.
    Any,
    /// Roots: large forms that repeat around a centre.
    Roots,
    /// Spheres and lenses.
    Spheres,
    /// Silk.
    Silk,
    /// Whirls.
    Whirls,
    /// Webs and lattices.
    Webs,
}

/// Where the values of a parameter are.
#[derive(Clone, Copy, Debug)]
enum Range {
    /// Anywhere between.
    Even(f64, f64),
    /// Whole numbers, both ends included.
    Whole(i32, i32),
    /// One of these, all of them whole, and none is 0.
    Of(&'static [f64]),
    /// Mostly 1.
    One(f64, f64),
}

impl Family {
    /// One of them.
    pub(super) fn random(rng: &mut Rng) -> Family {
        pick(rng, &[Family::Any, Family::Roots, Family::Spheres, Family::Silk, Family::Whirls, Family::Webs])
    }

    /// Its variations.
    pub(super) fn kinds(self) -> &'static [Kind] {
        match self {
            Family::Any => &SOFT,
            Family::Roots => &[Kind::Julian, Kind::Juliascope, Kind::Julian, Kind::Julia, Kind::WedgeJulia, Kind::Cpow],
            Family::Spheres => &[
                Kind::Loonie,
                Kind::Bubble,
                Kind::Fisheye,
                Kind::Spherical,
                Kind::Julian,
                Kind::Mobius,
                Kind::Edisc,
                Kind::Eyefish,
            ],
            Family::Silk => &[
                Kind::Elliptic,
                Kind::Splits,
                Kind::Bipolar,
                Kind::Foci,
                Kind::Edisc,
                Kind::Curl,
                Kind::Escher,
                Kind::Log,
                Kind::Polar2,
                Kind::Disc2,
            ],
            Family::Whirls => &[
                Kind::Swirl,
                Kind::Spherical,
                Kind::Whorl,
                Kind::Lazysusan,
                Kind::Curl,
                Kind::Escher,
                Kind::Spiral,
                Kind::Cpow,
                Kind::Handkerchief,
                Kind::Flux,
                Kind::Auger,
            ],
            Family::Webs => &[
                Kind::Spherical,
                Kind::Mobius,
                Kind::WedgeSph,
                Kind::Curl,
                Kind::Bent2,
                Kind::Popcorn2,
                Kind::Waves2,
                Kind::Hyperbolic,
                Kind::Cross,
                Kind::Scry,
            ],
        }
    }
}

/// Variations that leave something to see beside others. Those that blur, and those that put all points on one line, are
/// not among them.
#[rustfmt::skip]
pub(super) const SOFT: [Kind; 72] = [
    Kind::Linear, Kind::Linear, Kind::Linear, Kind::Sinusoidal, Kind::Spherical, Kind::Swirl, Kind::Horseshoe,
    Kind::Handkerchief, Kind::Julia, Kind::Bent2, Kind::Waves, Kind::Fisheye, Kind::Popcorn, Kind::Exponential,
    Kind::Eyefish, Kind::Bubble, Kind::Julian, Kind::Juliascope, Kind::Curl, Kind::Disc2, Kind::Elliptic, Kind::Edisc,
    Kind::Loonie, Kind::Bipolar, Kind::Escher, Kind::Foci, Kind::Lazysusan, Kind::Popcorn2, Kind::Polar2, Kind::Scry,
    Kind::Splits, Kind::Stripes, Kind::Wedge, Kind::Whorl, Kind::Waves2, Kind::Log, Kind::Auger, Kind::Flux,
    Kind::Mobius, Kind::Cpow, Kind::Ex, Kind::Heart, Kind::Disc, Kind::Spiral, Kind::Hyperbolic, Kind::Diamond,
    Kind::Polar, Kind::Power, Kind::Cosine, Kind::Rings2, Kind::Fan2, Kind::Blob, Kind::Pdj, Kind::Cylinder,
    Kind::Curve, Kind::Butterfly, Kind::Separation, Kind::WedgeJulia, Kind::WedgeSph, Kind::Sin, Kind::Cos, Kind::Tan,
    Kind::Sinh, Kind::Tanh, Kind::Sech, Kind::Csch, Kind::Coth, Kind::Cross, Kind::Ngon, Kind::Exp, Kind::Bent,
    Kind::Split,
];

/// Variations that a whole flame can be seen through.
#[rustfmt::skip]
pub(super) const LENSES: [Kind; 24] = [
    Kind::Julian, Kind::Julian, Kind::Juliascope, Kind::Spherical, Kind::Bubble, Kind::Eyefish, Kind::Fisheye,
    Kind::Polar2, Kind::Elliptic, Kind::Edisc, Kind::Scry, Kind::Foci, Kind::Bipolar, Kind::Curl, Kind::Mobius,
    Kind::Loonie, Kind::Swirl, Kind::Disc2, Kind::Lazysusan, Kind::Wedge, Kind::Log, Kind::Escher, Kind::Linear,
    Kind::Whorl,
];

/// Whether a variation spreads points so far that its transform may be large and heavy.
pub(super) fn is_root(kind: Kind) -> bool {
    matches!(kind, Kind::Julian | Kind::Juliascope | Kind::Julia | Kind::WedgeJulia | Kind::Cpow)
}

/// One or two variations among `kinds`, with parameters, of a weight of 1 together, more or less.
pub(super) fn drawn(kinds: &[Kind], rng: &mut Rng) -> Vec<Variation> {
    let first = if happens(rng, ALONE) { 1.0 } else { even(rng, 0.25, 0.75) };
    let mut variations: Vec<Variation> = Vec::new();
    for share in [first, 1.0 - first].into_iter().filter(|share| *share > 0.0) {
        let variation = of_kind(pick(rng, kinds), share * even(rng, 0.85, 1.15), rng);
        if variations.iter().all(|other| other.kind != variation.kind) {
            variations.push(variation);
        }
    }
    variations
}

/// A variation with parameters by chance.
pub(super) fn of_kind(kind: Kind, weight: f64, rng: &mut Rng) -> Variation {
    let params: Vec<f64> = ranges(kind).iter().map(|range| range.drawn(rng)).collect();
    Variation::new(kind, weight).with(&params)
}

/// The same variation with parameters and a weight that are a little different, `strength` times the usual amount.
pub(super) fn changed(variation: &Variation, strength: f64, rng: &mut Rng) -> Variation {
    let mut changed = *variation;
    for (value, range) in changed.params.iter_mut().zip(ranges(variation.kind)) {
        *value = range.moved(*value, strength, rng);
    }
    if ranges(variation.kind).is_empty() {
        // Of other programs' parameters nothing is known but that those that are whole are often numbers of things.
        for value in changed.params.iter_mut().filter(|value| value.fract() != 0.0) {
            *value = Range::Even(-1.0, 1.0).moved(*value, strength, rng);
        }
    }
    changed.weight *= 1.0 + STRIDE * (strength * rng.normal()).clamp(-3.0, 3.0);
    changed
}

impl Range {
    fn drawn(self, rng: &mut Rng) -> f64 {
        match self {
            Range::Even(from, to) => even(rng, from, to),
            Range::Whole(from, to) => f64::from(from + rng.below((to - from + 1) as usize) as i32),
            Range::Of(values) => pick(rng, values),
            Range::One(from, to) => {
                if happens(rng, 0.6) {
                    1.0
                } else {
                    even(rng, from, to)
                }
            }
        }
    }

    /// `value` moved; whole numbers stay whole and never become 0.
    fn moved(self, value: f64, strength: f64, rng: &mut Rng) -> f64 {
        let by = strength * rng.normal();
        match self {
            Range::Even(from, to) | Range::One(from, to) => {
                value + STRIDE * by * value.abs().max(PART_OF_RANGE * (to - from).abs())
            }
            Range::Whole(..) | Range::Of(_) => {
                let moved = value.round() + by.round().clamp(-2.0, 2.0);
                if moved == 0.0 { value } else { moved }
            }
        }
    }
}

/// The ranges of a variation's parameters, in their order.
#[expect(clippy::wildcard_enum_match_arm, reason = "most variations have no parameters")]
#[rustfmt::skip]
fn ranges(kind: Kind) -> &'static [Range] {
    use Range::{Even, Of, One, Whole};
    const POWERS: Range = Of(&[2.0, 2.0, 3.0, 3.0, -2.0, -3.0, 4.0, -4.0, 5.0, 6.0, -6.0, 8.0, -8.0, 12.0, -12.0]);
    const HALF: Range = Even(-0.5, 0.5);
    const ONE: Range = Even(-1.0, 1.0);
    match kind {
        Kind::Blob => &[Even(0.2, 0.7), Even(0.8, 1.3), Whole(2, 9)],
        Kind::Pdj => &[Even(-2.5, 2.5), Even(-2.5, 2.5), Even(-2.5, 2.5), Even(-2.5, 2.5)],
        Kind::Fan2 => &[ONE, Even(-2.0, 2.0)],
        Kind::Rings2 => &[Even(0.2, 1.3)],
        Kind::Perspective => &[Even(0.1, 0.9), Even(1.0, 3.0)],
        Kind::Julian | Kind::Juliascope => &[POWERS, One(0.5, 1.4)],
        Kind::RadialBlur => &[Even(0.0, 1.0)],
        Kind::Pie => &[Whole(3, 9), Even(0.0, 6.0), Even(0.2, 0.7)],
        Kind::Ngon => &[Even(1.0, 4.0), Whole(3, 8), Even(0.3, 2.0), Even(0.3, 1.5)],
        Kind::Curl => &[Even(-0.6, 0.6), HALF],
        Kind::Rectangles => &[Even(0.2, 1.0), Even(0.2, 1.0)],
        Kind::Disc2 => &[Even(-2.0, 2.0), Even(-3.0, 3.0)],
        Kind::SuperShape => {
            &[Even(0.0, 0.6), Whole(2, 9), Even(0.5, 4.0), Even(0.5, 4.0), Even(0.5, 4.0), Even(-0.5, 0.3)]
        }
        Kind::Flower => &[Even(-0.3, 0.4), Whole(3, 9)],
        Kind::Conic => &[Even(-0.2, 0.2), Even(0.3, 1.5)],
        Kind::Parabola => &[Even(0.3, 1.0), Even(0.3, 1.0)],
        Kind::Bent2 => &[Even(0.4, 1.5), Even(0.4, 1.5)],
        Kind::Bipolar | Kind::Flux => &[ONE],
        Kind::Cell => &[Even(0.2, 0.8)],
        Kind::Cpow => &[Even(0.4, 1.2), HALF, Whole(1, 6)],
        Kind::Curve => &[ONE, ONE, Even(0.3, 1.5), Even(0.3, 1.5)],
        Kind::Escher => &[Even(-1.2, 1.2)],
        Kind::Lazysusan => &[Even(-3.0, 3.0), Even(-0.6, 0.6), Even(-1.2, 1.2), Even(-0.3, 0.3), Even(-0.3, 0.3)],
        Kind::Modulus => &[Even(0.5, 1.5), Even(0.5, 1.5)],
        Kind::Oscilloscope => &[Even(0.2, 1.0), Even(2.0, 6.0), Even(0.3, 1.0), Even(0.0, 1.0)],
        Kind::Popcorn2 => &[Even(-0.4, 0.4), Even(-0.4, 0.4), Even(1.0, 5.0)],
        Kind::Separation => &[Even(0.0, 0.6), HALF, Even(0.0, 0.6), HALF],
        Kind::Split => &[Even(0.3, 1.2), Even(0.3, 1.2)],
        Kind::Splits => &[Even(-0.7, 0.7), Even(-0.7, 0.7)],
        Kind::Stripes => &[HALF, Even(-0.6, 0.6)],
        Kind::Wedge | Kind::WedgeSph => &[Even(0.0, 2.0), Even(-0.3, 0.3), Whole(1, 6), Even(-0.6, 0.6)],
        Kind::WedgeJulia => {
            &[Even(0.0, 1.2), Whole(1, 6), Of(&[2.0, 3.0, -2.0, -3.0, 4.0, 6.0, -5.0]), Even(0.6, 1.2)]
        }
        Kind::Whorl => &[Even(-1.5, 1.5), ONE],
        Kind::Waves2 => &[Even(-0.3, 0.3), Even(-0.3, 0.3), Even(1.0, 5.0), Even(1.0, 5.0)],
        Kind::Auger => &[Even(1.0, 5.0), Even(0.1, 0.6), Even(0.0, 1.0), Even(0.1, 1.0)],
        Kind::Mobius => &[ONE, ONE, ONE, ONE, ONE, ONE, ONE, ONE],
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_has_a_range_and_whole_numbers_stay_whole() {
        let mut rng = Rng::stream(1, 0);
        for kind in Kind::FLAM3 {
            // The base of a logarithm is not flam3's.
            let bred = kind.parameters().len() - usize::from(kind == Kind::Log);
            assert_eq!(ranges(kind).len(), bred, "{kind:?}");
            for _ in 0..50 {
                let drawn = of_kind(kind, 1.0, &mut rng);
                let changed = changed(&drawn, 2.0, &mut rng);
                for (at, range) in ranges(kind).iter().enumerate() {
                    let (old, new) = (drawn.params[at], changed.params[at]);
                    assert!(new.is_finite());
                    if matches!(range, Range::Whole(..) | Range::Of(_)) {
                        assert!(old.fract() == 0.0 && new.fract() == 0.0 && old != 0.0 && new != 0.0, "{kind:?} {new}");
                    }
                }
            }
        }
    }
}
