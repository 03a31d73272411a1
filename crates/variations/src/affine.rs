//! Affine maps of the plane.
//!
//! Owns their arithmetic. Never knows what is mapped: points of an orbit, of a picture, or a transform on its way.
//!
//! Start at [`Affine`].

/// `x' = a x + b y + c`, `y' = d x + e y + f`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the formula names them all")]
pub struct Affine {
    pub a: f64,
    pub b: f64,
    pub c: f64,
    pub d: f64,
    pub e: f64,
    pub f: f64,
}

impl Affine {
    /// Leaves every point where it is.
    pub const IDENTITY: Affine = Affine { a: 1.0, b: 0.0, c: 0.0, d: 0.0, e: 1.0, f: 0.0 };

    /// The image of `(x, y)`.
    #[inline]
    pub fn apply(&self, x: f64, y: f64) -> (f64, f64) {
        (self.a * x + self.b * y + self.c, self.d * x + self.e * y + self.f)
    }

    /// The sum of this one and `part` of `other`, number by number.
    pub fn plus(&self, other: &Affine, part: f64) -> Affine {
        Affine {
            a: self.a + part * other.a,
            b: self.b + part * other.b,
            c: self.c + part * other.c,
            d: self.d + part * other.d,
            e: self.e + part * other.e,
            f: self.f + part * other.f,
        }
    }

    /// The same with its 2x2 part turned by `turn` radians; the translation stays.
    #[must_use]
    pub fn turned(&self, turn: f64) -> Affine {
        let (sin, cos) = libm::sincos(turn);
        Affine {
            a: cos * self.a - sin * self.d,
            d: sin * self.a + cos * self.d,
            b: cos * self.b - sin * self.e,
            e: sin * self.b + cos * self.e,
            ..*self
        }
    }

    /// The six numbers in the order of flam3: column by column.
    pub fn columns(&self) -> [f64; 6] {
        [self.a, self.d, self.b, self.e, self.c, self.f]
    }
}
