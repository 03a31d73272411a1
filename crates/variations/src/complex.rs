//! Formulas of the complex plane: the point is x + iy.
//!
//! Owns the elementary functions of a complex number, the Möbius transformation, and the coordinates that circles,
//! ellipses and hyperbolas span. The letters are those of `plain.rs`.
//!
//! # Source
//! Abramowitz & Stegun, *Handbook of Mathematical Functions* (1964), 4.3.55 to 4.3.58 and 4.5.49 to 4.5.54. They are
//! arranged so that nothing is lost near poles: cosh 2y - cos 2x, for one, is 2 (sinh² y + sin² x). Which sign the conjugate
//! gets, and what scales the coordinates, the pictures of `flam3-render` decide.

use std::f64::consts::{FRAC_1_PI, FRAC_2_PI, PI};

use super::formulas::{at_angle, formulas, over, radius, square_of_radius};
use crate::number::Number;

/// Beyond this, hyperbolic functions differ from their limits by less than numbers do.
const FAR: f64 = 40.0;

/// From here on a hyperbolic cosine is infinite in `f64`.
const COSH_END: f64 = 710.475_860_073_943_9;

formulas! {
    Bipolar(v, x, y) {
        let ratio = square_of_radius(x + 1.0, y) / square_of_radius(x - 1.0, y);
        let half = (y * 2.0).atan2(square_of_radius(x, y) - 1.0) * 0.5 - v.p[0] * (PI / 2.0);
        let folded = half - (half * FRAC_1_PI).round() * PI;
        (ratio.ln() * (v.w * FRAC_1_PI / 2.0), folded * (v.w * FRAC_2_PI))
    }

    Edisc(v, x, y) {
        let Ellipse { longest, beyond, across } = Ellipse::of(x, y);
        let (s, c) = (longest + beyond.sqrt()).ln().sin_cos();
        let (sinh, cosh) = across.atan2(x).sinh_cosh();
        let w = v.w / 11.570_346_32;
        (cosh * c * w, sinh * s * y.like(1.0).copysign(y) * w)
    }

    Elliptic(v, x, y) {
        let Ellipse { longest, beyond, across } = Ellipse::of(x, y);
        (x.atan2(across) * (v.w * FRAC_2_PI), (longest + beyond.sqrt()).ln().copysign(y) * (v.w * FRAC_2_PI))
    }

    EllipticMirrored(v, x, y, random) {
        let Ellipse { longest, beyond, across } = Ellipse::of(x, y);
        let rise = (longest + beyond.sqrt()).ln();
        (x.atan2(across) * (v.w * FRAC_2_PI), N::select(random.coin(), rise, -rise) * (v.w * FRAC_2_PI))
    }

    Escher(v, x, y) {
        let (phi, ln_r) = (y.atan2(x), square_of_radius(x, y).ln() * 0.5);
        at_angle(phi * v.p[0] + ln_r * v.p[1], (ln_r * v.p[0] - phi * v.p[1]).exp() * v.w)
    }

    Foci(v, x, y) {
        let (s, c) = (y * 0.5).sin_cos();
        let (sinh, cosh) = near(x * 0.5).sinh_cosh();
        let k = over(v.w, square_of_radius(sinh, s));
        (k * sinh * cosh, k * s * c)
    }

    Exp(v, x, y) {
        at_angle(y, x.exp() * v.w)
    }

    Log(v, x, y) {
        (square_of_radius(x, y).ln() * (0.5 * v.w * v.p[0]), y.atan2(x) * v.w)
    }

    Acoth(v, x, y) {
        let ratio = square_of_radius(x + 1.0, y) / square_of_radius(x - 1.0, y);
        let turn = (y * -2.0).atan2(square_of_radius(x, y) - 1.0);
        (turn * (v.w * FRAC_1_PI), ratio.ln() * (v.w * FRAC_1_PI / 2.0))
    }

    Sin(v, x, y) {
        let ((s, c), (sinh, cosh)) = (x.sin_cos(), y.sinh_cosh());
        (s * cosh * v.w, c * sinh * v.w)
    }

    Cos(v, x, y) {
        let ((s, c), (sinh, cosh)) = (x.sin_cos(), y.sinh_cosh());
        (c * cosh * v.w, s * sinh * -v.w)
    }

    Tan(v, x, y) {
        let ((s, c), (sinh, cosh)) = (x.sin_cos(), near(y).sinh_cosh());
        let k = over(v.w, square_of_radius(c, sinh));
        (k * s * c, k * sinh * cosh)
    }

    Sec(v, x, y) {
        let ((s, c), (sinh, cosh)) = (x.sin_cos(), near(y).sinh_cosh());
        let k = over(v.w, square_of_radius(c, sinh));
        (k * c * cosh, k * s * sinh)
    }

    Csc(v, x, y) {
        let ((s, c), (sinh, cosh)) = (x.sin_cos(), near(y).sinh_cosh());
        let k = over(v.w, square_of_radius(s, sinh));
        (k * s * cosh, -(k * c * sinh))
    }

    Cot(v, x, y) {
        let ((s, c), (sinh, cosh)) = (x.sin_cos(), near(y).sinh_cosh());
        let k = over(v.w, square_of_radius(s, sinh));
        (k * s * c, -(k * sinh * cosh))
    }

    Sinh(v, x, y) {
        let ((s, c), (sinh, cosh)) = (y.sin_cos(), x.sinh_cosh());
        (sinh * c * v.w, cosh * s * v.w)
    }

    Cosh(v, x, y) {
        let ((s, c), (sinh, cosh)) = (y.sin_cos(), x.sinh_cosh());
        (cosh * c * v.w, sinh * s * v.w)
    }

    Tanh(v, x, y) {
        let ((s, c), (sinh, cosh)) = (y.sin_cos(), near(x).sinh_cosh());
        let k = over(v.w, square_of_radius(c, sinh));
        (k * sinh * cosh, k * s * c)
    }

    Sech(v, x, y) {
        let ((s, c), (sinh, cosh)) = (y.sin_cos(), near(x).sinh_cosh());
        let k = over(v.w, square_of_radius(c, sinh));
        (k * c * cosh, -(k * s * sinh))
    }

    Csch(v, x, y) {
        let ((s, c), (sinh, cosh)) = (y.sin_cos(), near(x).sinh_cosh());
        let k = over(v.w, square_of_radius(s, sinh));
        (k * sinh * c, -(k * cosh * s))
    }

    Coth(v, x, y) {
        let ((s, c), (sinh, cosh)) = (y.sin_cos(), near(x).sinh_cosh());
        let k = over(v.w, square_of_radius(s, sinh));
        (k * sinh * cosh, k * s * c)
    }

    Sec2Bs(v, x, y) {
        let [x1, x2, y1, y2, ..] = v.p;
        // From here on the numerator is infinite in `f64`.
        let end = COSH_END / y1.abs().max(y2.abs());
        let y = N::select(y.abs().less(y.like(end)), y, y.like(f64::NAN));
        let (c, sinh) = (x.cos(), y.sinh_cosh().0);
        let k = over(v.w, square_of_radius(c, sinh));
        (k * (x * x2).cos() * (y * y2).sinh_cosh().1, k * (x * x1).sin() * (y * y1).sinh_cosh().0)
    }

    Joukowski(v, x, y) {
        let [square, shift, is_inverse, ..] = v.p;
        if is_inverse == 0.0 {
            let (x, y) = (x - shift, y + 0.2);
            let k = over(square, square_of_radius(x, y));
            ((x + k * x) * v.w, (y - k * y) * v.w)
        } else {
            let (half_x, half_y) = (x * 0.5, y * 0.5);
            let (re, im) = square_root((half_x - half_y) * (half_x + half_y) - square, half_x * half_y * 2.0);
            let (x, y) = (half_x + shift, half_y - 0.2);
            let is_first = square_of_radius(x - re, y - im).less(square_of_radius(x + re, y + im));
            (N::select(is_first, x + re, x - re) * v.w, N::select(is_first, y + im, y - im) * v.w)
        }
    }

    Mobius(v, x, y) {
        let [re_a, im_a, re_b, im_b, re_c, im_c, re_d, im_d, ..] = v.p;
        let (re_over, im_over) = (x * re_a - y * im_a + re_b, x * im_a + y * re_a + im_b);
        let (re_under, im_under) = (x * re_c - y * im_c + re_d, x * im_c + y * re_c + im_d);
        let k = over(v.w, square_of_radius(re_under, im_under));
        (k * (re_over * re_under + im_over * im_under), k * (im_over * re_under - re_over * im_under))
    }
}

/// The ellipse with foci at ±1 through a point.
pub(super) struct Ellipse<N> {
    /// The half of its longer axis, 1 or more.
    pub(super) longest: N,
    /// How much that is more than 1.
    pub(super) beyond: N,
    /// √(longest² - x²).
    pub(super) across: N,
}

impl<N: Number> Ellipse<N> {
    #[inline(always)]
    pub(super) fn of(x: N, y: N) -> Ellipse<N> {
        let (zero, x) = (x.like(0.0), x.abs());
        let (far, near) = (square_of_radius(x + 1.0, y).sqrt(), square_of_radius(x - 1.0, y).sqrt());
        // By how much each distance to a focus is more than its part along the axis, without a difference of neighbours.
        let smallest = x.like(1e-30);
        let excess = (y * y / (far + x + 1.0) + y * (y / (near + (x - 1.0).abs()).max(smallest))) * 0.5;
        let beyond = (x - 1.0).max(zero) + excess;
        let longest = beyond + 1.0;
        let left = (-(x - 1.0)).max(zero) + excess;
        Ellipse { longest, beyond, across: (left * (longest + x)).sqrt() }
    }
}

/// `value`, not beyond [`FAR`]; no number stays none.
#[inline(always)]
pub(super) fn near<N: Number>(value: N) -> N {
    value.like(FAR).min(value.like(-FAR).max(value))
}

/// The square root of re + i im whose real part is not negative.
#[inline(always)]
pub(super) fn square_root<N: Number>(re: N, im: N) -> (N, N) {
    let size = radius(re, im);
    let half = |value: N| (value * 0.5).max(value.like(0.0)).sqrt();
    (half(size + re), half(size - re).copysign(im))
}
