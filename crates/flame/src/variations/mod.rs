//! The variations: their names, parameters and stages.
//!
//! Owns the table that the XML reader, the writer, the animation and the renderer share: V0 to V98 of flam3, and after
//! them those of other programs. `spelling.rs` has the spelling in files, `stage.rs` the order inside a transform,
//! `formulas.rs` says what a formula is; the other files have the mathematics, `render` calls it.
//!
//! Start at [`Kind`].
//!
//! # Source
//! Draves & Reckase, *The Fractal Flame Algorithm* (2008), appendix: catalogue of variations, V0 to V48. Names,
//! numbers and parameters of the others are those of flam3 3.1.1; where a genome does not give a parameter, its pictures say
//! what it is.

mod chance;
mod complex;
mod formulas;
mod later;
mod plain;
mod solid;
mod spelling;
mod stage;

use std::f64::consts::PI;

pub(crate) use formulas::{Compiled, Depth, Formula, Visitor};
pub(crate) use spelling::{Part, Spelling};
pub use stage::{Slot, Stage};

/// How many parameters a variation has at most.
pub const MAX_PARAMETERS: usize = 16;

/// One variation of a transform, with its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variation {
    /// Which formula.
    pub kind: Kind,
    /// How strongly it is mixed in; 0 leaves it out but keeps its parameters.
    pub weight: f64,
    /// Its parameters in the order of [`Kind::parameters`]; the rest is 0.
    pub params: [f64; MAX_PARAMETERS],
    /// When it is applied.
    pub stage: Stage,
    /// Which of several of its kind and stage it is, from 0.
    pub number: u8,
    /// How far it has come, `0.0..=1.0`, where its weight does not say that: in a transition, what replaces the point grows
    /// by it from 0. 1 elsewhere.
    pub presence: f64,
}

impl Variation {
    /// A variation of the given weight with its default parameters.
    pub fn new(kind: Kind, weight: f64) -> Variation {
        let mut params = [0.0; MAX_PARAMETERS];
        for (slot, parameter) in params.iter_mut().zip(kind.parameters()) {
            *slot = parameter.default;
        }
        Variation { kind, weight, params, stage: Stage::Sum, number: 0, presence: 1.0 }
    }

    /// Whether it changes nothing, whatever its parameters are.
    pub fn is_absent(&self) -> bool {
        self.weight == 0.0 || self.presence == 0.0
    }

    /// Its place among the variations of a transform: no two of a transform have the same.
    pub fn slot(&self) -> Slot {
        Slot { stage: self.stage, kind: self.kind, number: self.number }
    }

    /// The same variation with other parameters, in the order of [`Kind::parameters`].
    #[must_use]
    pub fn with(mut self, params: &[f64]) -> Variation {
        self.params[..params.len()].copy_from_slice(params);
        self
    }
}

/// A parameter of a variation.
#[derive(Debug, PartialEq)]
pub struct Parameter {
    /// Its name after the variation's and an underscore: `power` of `julian_power`.
    pub name: &'static str,
    /// Its value where a genome does not say.
    pub default: f64,
}

macro_rules! kinds {
    ($($module:ident::$kind:ident $name:literal [$($parameter:ident $default:expr),*];)*) => {
        /// A variation; the discriminant of the first 99 is its number in flam3, up to 48 that in the paper.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[expect(missing_docs, reason = "each name is the published one, its formula stands in the module that the table names")]
        pub enum Kind { $($kind),* }

        /// How many there are.
        const COUNT: usize = [$(Kind::$kind),*].len();

        impl Kind {
            /// All variations, by number.
            pub const ALL: [Kind; COUNT] = [$(Kind::$kind),*];

            /// The name in XML.
            pub fn name(self) -> &'static str {
                match self { $(Kind::$kind => $name),* }
            }

            /// The parameters, in the order of [`Variation::params`].
            pub fn parameters(self) -> &'static [Parameter] {
                match self {
                    $(Kind::$kind => &[$(Parameter { name: stringify!($parameter), default: $default }),*]),*
                }
            }

            /// Does what `visitor` does with the formula.
            #[inline(always)]
            pub(crate) fn visit<V: Visitor>(self, visitor: V) -> V::Out {
                match self { $(Kind::$kind => visitor.visit::<$module::$kind>()),* }
            }
        }
    };
}

kinds! {
    plain::Linear "linear" [];
    plain::Sinusoidal "sinusoidal" [];
    plain::Spherical "spherical" [];
    plain::Swirl "swirl" [];
    plain::Horseshoe "horseshoe" [];
    plain::Polar "polar" [];
    plain::Handkerchief "handkerchief" [];
    plain::Heart "heart" [];
    plain::Disc "disc" [];
    plain::Spiral "spiral" [];
    plain::Hyperbolic "hyperbolic" [];
    plain::Diamond "diamond" [];
    plain::Ex "ex" [];
    chance::Julia "julia" [];
    plain::Bent "bent" [];
    plain::Waves "waves" [];
    plain::Fisheye "fisheye" [];
    plain::Popcorn "popcorn" [];
    plain::Exponential "exponential" [];
    plain::Power "power" [];
    plain::Cosine "cosine" [];
    plain::Rings "rings" [];
    plain::Fan "fan" [];
    plain::Blob "blob" [low 0.0, high 1.0, waves 1.0];
    plain::Pdj "pdj" [a 0.0, b 0.0, c 0.0, d 0.0];
    plain::Fan2 "fan2" [x 0.0, y 0.0];
    plain::Rings2 "rings2" [val 0.0];
    plain::Eyefish "eyefish" [];
    solid::Bubble "bubble" [];
    solid::Cylinder "cylinder" [];
    plain::Perspective "perspective" [angle 0.0, dist 0.0];
    chance::Noise "noise" [];
    chance::Julian "julian" [power 1.0, dist 1.0];
    chance::Juliascope "juliascope" [power 1.0, dist 1.0];
    chance::Blur "blur" [];
    chance::GaussianBlur "gaussian_blur" [];
    chance::RadialBlur "radial_blur" [angle 0.0];
    chance::Pie "pie" [slices 6.0, rotation 0.0, thickness 0.5];
    plain::Ngon "ngon" [power 3.0, sides 5.0, corners 2.0, circle 1.0];
    plain::Curl "curl" [c1 1.0, c2 0.0];
    plain::Rectangles "rectangles" [x 1.0, y 1.0];
    chance::Arch "arch" [];
    plain::Tangent "tangent" [];
    chance::Square "square" [];
    chance::Rays "rays" [];
    chance::Blade "blade" [];
    plain::Secant2 "secant2" [];
    chance::Twintrian "twintrian" [];
    plain::Cross "cross" [];
    later::Disc2 "disc2" [rot 0.0, twist 0.0];
    chance::SuperShape "super_shape" [rnd 0.0, m 0.0, n1 1.0, n2 1.0, n3 1.0, holes 0.0];
    chance::Flower "flower" [holes 0.0, petals 0.0];
    chance::Conic "conic" [holes 0.0, eccentricity 1.0];
    chance::Parabola "parabola" [height 0.0, width 0.0];
    later::Bent2 "bent2" [x 1.0, y 1.0];
    complex::Bipolar "bipolar" [shift 0.0];
    chance::Boarders "boarders" [];
    later::Butterfly "butterfly" [];
    later::Cell "cell" [size 1.0];
    chance::Cpow "cpow" [r 1.0, i 0.0, power 1.0];
    later::Curve "curve" [xamp 0.0, yamp 0.0, xlength 1.0, ylength 1.0];
    complex::Edisc "edisc" [];
    complex::Elliptic "elliptic" [];
    complex::Escher "escher" [beta 0.0];
    complex::Foci "foci" [];
    later::Lazysusan "lazysusan" [spin 0.0, space 0.0, twist 0.0, x 0.0, y 0.0];
    later::Loonie "loonie" [];
    chance::PreBlur "pre_blur" [];
    later::Modulus "modulus" [x 0.0, y 0.0];
    later::Oscilloscope "oscilloscope" [separation 1.0, frequency PI, amplitude 1.0, damping 0.0];
    later::Polar2 "polar2" [];
    later::Popcorn2 "popcorn2" [x 0.0, y 0.0, c 0.0];
    later::Scry "scry" [];
    later::Separation "separation" [x 0.0, xinside 0.0, y 0.0, yinside 0.0];
    later::Split "split" [xsize 0.0, ysize 0.0];
    later::Splits "splits" [x 0.0, y 0.0];
    later::Stripes "stripes" [space 0.0, warp 0.0];
    later::Wedge "wedge" [angle 0.0, hole 0.0, count 1.0, swirl 0.0];
    chance::WedgeJulia "wedge_julia" [angle 0.0, count 1.0, power 1.0, dist 0.0];
    later::WedgeSph "wedge_sph" [angle 0.0, hole 0.0, count 1.0, swirl 0.0];
    later::Whorl "whorl" [inside 0.0, outside 0.0];
    later::Waves2 "waves2" [scalex 0.0, scaley 0.0, freqx 0.0, freqy 0.0];
    complex::Exp "exp" [];
    complex::Log "log" [];
    complex::Sin "sin" [];
    complex::Cos "cos" [];
    complex::Tan "tan" [];
    complex::Sec "sec" [];
    complex::Csc "csc" [];
    complex::Cot "cot" [];
    complex::Sinh "sinh" [];
    complex::Cosh "cosh" [];
    complex::Tanh "tanh" [];
    complex::Sech "sech" [];
    complex::Csch "csch" [];
    complex::Coth "coth" [];
    later::Auger "auger" [freq 1.0, weight 0.5, sym 0.0, scale 1.0];
    later::Flux "flux" [spread 0.0];
    complex::Mobius "mobius" [re_a 0.0, im_a 0.0, re_b 0.0, im_b 0.0, re_c 0.0, im_c 0.0, re_d 0.0, im_d 0.0];
    solid::Linear3D "linear3D" [];
    solid::Flatten "flatten" [];
    solid::Zscale "zscale" [];
    solid::Ztranslate "ztranslate" [];
    solid::Zcone "zcone" [];
    solid::Zblur "zblur" [];
}

impl Kind {
    /// The variations of flam3 3.1.1, by number: those that are bred.
    pub const FLAM3: [Kind; 99] = {
        let mut first = [Kind::Linear; 99];
        let mut number = 0;
        while number < first.len() {
            first[number] = Kind::ALL[number];
            number += 1;
        }
        first
    };

    /// The variation whose XML attribute is `name`.
    pub fn named(name: &str) -> Option<Kind> {
        Kind::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// What the formula does with z.
    pub(crate) fn depth(self) -> Depth {
        struct DepthOf;
        impl Visitor for DepthOf {
            type Out = Depth;
            fn visit<F: Formula>(self) -> Depth {
                F::DEPTH
            }
        }
        self.visit(DepthOf)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_variation_has_the_number_of_the_paper_and_of_flam3() {
        assert_eq!(Kind::Linear as usize, 0);
        assert_eq!(Kind::Blob as usize, 23);
        assert_eq!(Kind::Julian as usize, 32);
        assert_eq!(Kind::Cross as usize, 48);
        assert_eq!(Kind::PreBlur as usize, 67);
        assert_eq!(Kind::Mobius as usize, 98);
        assert_eq!(Kind::FLAM3.last(), Some(&Kind::Mobius));
        assert!(Kind::ALL.iter().enumerate().all(|(number, kind)| *kind as usize == number));
    }

    #[test]
    fn every_name_finds_its_variation() {
        for kind in Kind::ALL {
            assert_eq!(Kind::named(kind.name()), Some(kind));
            assert!(kind.parameters().len() <= MAX_PARAMETERS);
        }
        assert_eq!(Kind::named("waltz"), None);
    }
}
