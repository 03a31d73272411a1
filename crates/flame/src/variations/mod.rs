//! The published variations V0 to V48: their names, numbers and parameters.
//!
//! Owns the table that the XML reader, the writer, the animation and the renderer share. `formulas.rs` has the
//! mathematics, `render` calls it.
//!
//! Start at [`Kind`].
//!
//! # Source
//! Draves & Reckase, *The Fractal Flame Algorithm* (2008), appendix: catalogue of variations.

mod chance;
mod formulas;
mod plain;

pub(crate) use formulas::{Compiled, Needs, Point, is_out_of_range, needs};

/// How many parameters a variation has at most.
pub const MAX_PARAMETERS: usize = 4;

/// One variation of a transform, with its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variation {
    /// Which formula.
    pub kind: Kind,
    /// How strongly it is mixed in; 0 leaves it out but keeps its parameters.
    pub weight: f64,
    /// Its parameters in the order of [`Kind::parameters`]; the rest is 0.
    pub params: [f64; MAX_PARAMETERS],
}

impl Variation {
    /// A variation of the given weight with its default parameters.
    pub fn new(kind: Kind, weight: f64) -> Variation {
        let mut params = [0.0; MAX_PARAMETERS];
        for (slot, parameter) in params.iter_mut().zip(kind.parameters()) {
            *slot = parameter.default;
        }
        Variation { kind, weight, params }
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
    ($($kind:ident $name:literal [$($parameter:ident $default:literal),*];)*) => {
        /// A published variation; the discriminant is its number in the paper and in flam3.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[expect(missing_docs, reason = "each name is the published one, its formula stands in `formulas.rs`")]
        pub enum Kind { $($kind),* }

        impl Kind {
            /// All variations, by number.
            pub const ALL: [Kind; 49] = [$(Kind::$kind),*];

            /// The name in flam3 XML.
            pub fn name(self) -> &'static str {
                match self { $(Kind::$kind => $name),* }
            }

            /// The parameters, in the order of [`Variation::params`].
            pub fn parameters(self) -> &'static [Parameter] {
                match self {
                    $(Kind::$kind => &[$(Parameter { name: stringify!($parameter), default: $default }),*]),*
                }
            }
        }
    };
}

kinds! {
    Linear "linear" [];
    Sinusoidal "sinusoidal" [];
    Spherical "spherical" [];
    Swirl "swirl" [];
    Horseshoe "horseshoe" [];
    Polar "polar" [];
    Handkerchief "handkerchief" [];
    Heart "heart" [];
    Disc "disc" [];
    Spiral "spiral" [];
    Hyperbolic "hyperbolic" [];
    Diamond "diamond" [];
    Ex "ex" [];
    Julia "julia" [];
    Bent "bent" [];
    Waves "waves" [];
    Fisheye "fisheye" [];
    Popcorn "popcorn" [];
    Exponential "exponential" [];
    Power "power" [];
    Cosine "cosine" [];
    Rings "rings" [];
    Fan "fan" [];
    Blob "blob" [low 0.0, high 1.0, waves 1.0];
    Pdj "pdj" [a 0.0, b 0.0, c 0.0, d 0.0];
    Fan2 "fan2" [x 0.0, y 0.0];
    Rings2 "rings2" [val 0.0];
    Eyefish "eyefish" [];
    Bubble "bubble" [];
    Cylinder "cylinder" [];
    Perspective "perspective" [angle 0.0, dist 0.0];
    Noise "noise" [];
    Julian "julian" [power 1.0, dist 1.0];
    Juliascope "juliascope" [power 1.0, dist 1.0];
    Blur "blur" [];
    GaussianBlur "gaussian_blur" [];
    RadialBlur "radial_blur" [angle 0.0];
    Pie "pie" [slices 6.0, rotation 0.0, thickness 0.5];
    Ngon "ngon" [power 3.0, sides 5.0, corners 2.0, circle 1.0];
    Curl "curl" [c1 1.0, c2 0.0];
    Rectangles "rectangles" [x 1.0, y 1.0];
    Arch "arch" [];
    Tangent "tangent" [];
    Square "square" [];
    Rays "rays" [];
    Blade "blade" [];
    Secant2 "secant2" [];
    Twintrian "twintrian" [];
    Cross "cross" [];
}

impl Kind {
    /// The variation whose XML attribute is `name`.
    pub fn named(name: &str) -> Option<Kind> {
        Kind::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The variation and the index of its parameter whose XML attribute is `name`, as `julian_power`.
    pub fn parameter_named(name: &str) -> Option<(Kind, usize)> {
        Kind::ALL.into_iter().find_map(|kind| {
            let parameter = name.strip_prefix(kind.name())?.strip_prefix('_')?;
            let index = kind.parameters().iter().position(|known| known.name == parameter)?;
            Some((kind, index))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_variation_has_the_number_of_the_paper() {
        assert_eq!(Kind::Linear as usize, 0);
        assert_eq!(Kind::Blob as usize, 23);
        assert_eq!(Kind::Julian as usize, 32);
        assert_eq!(Kind::Cross as usize, 48);
        assert!(Kind::ALL.iter().enumerate().all(|(number, kind)| *kind as usize == number));
    }

    #[test]
    fn every_name_finds_its_variation_and_parameter() {
        for kind in Kind::ALL {
            assert_eq!(Kind::named(kind.name()), Some(kind));
            assert!(kind.parameters().len() <= MAX_PARAMETERS);
            for (index, parameter) in kind.parameters().iter().enumerate() {
                let attribute = format!("{}_{}", kind.name(), parameter.name);
                assert_eq!(Kind::parameter_named(&attribute), Some((kind, index)));
            }
        }
        assert_eq!(Kind::named("bipolar"), None);
    }
}
