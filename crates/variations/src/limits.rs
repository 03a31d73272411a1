//! Which values of parameters cannot be drawn, and from which program a variation comes.
//!
//! Owns the list of limits. Where no exact formula is known for some values of a parameter, these are refused. Formulas have
//! no state from point to point. Never draws.
//!
//! Start at [`Variation::undrawn`].

use super::escape::MOST_STEPS;
use super::{Kind, Variation};

/// Which values of a parameter are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// Only these.
    Only(&'static [f64]),
    /// Whole numbers, but not 0.
    Whole,
    /// 0 and more.
    NotNegative,
    /// Those at least as far from 0 as this.
    Beyond(f64),
    /// From the one to the other.
    Between(f64, f64),
}

/// A parameter with a value that is not drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Undrawn {
    /// Its name after the variation's and an underscore.
    pub parameter: &'static str,
    /// Its value.
    pub value: f64,
    /// What would be drawn.
    pub limit: Limit,
}

impl Limit {
    /// Whether `value` is drawn.
    pub fn holds(self, value: f64) -> bool {
        match self {
            Limit::Only(values) => values.contains(&value),
            Limit::Whole => value != 0.0 && value.fract() == 0.0,
            Limit::NotNegative => value >= 0.0,
            Limit::Beyond(least) => value.abs() >= least,
            Limit::Between(least, most) => (least..=most).contains(&value),
        }
    }
}

/// In words, as after *expected*.
impl std::fmt::Display for Limit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Limit::Only([first @ .., last]) if !first.is_empty() => {
                let first: Vec<String> = first.iter().map(ToString::to_string).collect();
                write!(f, "{} or {last}", first.join(", "))
            }
            Limit::Only(values) => write!(f, "{}", values.first().copied().unwrap_or_default()),
            Limit::Whole => f.write_str("a whole number, not 0"),
            Limit::NotNegative => f.write_str("0 or more"),
            Limit::Beyond(least) => write!(f, "{least} or more, or -{least} or less"),
            Limit::Between(least, most) => write!(f, "{least} to {most}"),
        }
    }
}

impl Kind {
    /// The parameters of which not all values are drawn.
    #[expect(clippy::wildcard_enum_match_arm, reason = "all others are drawn with any parameters")]
    pub fn limits(self) -> &'static [(&'static str, Limit)] {
        match self {
            Kind::AxisSymmetryWf => &[("axis", Limit::Only(&[0.0, 1.0, 2.0]))],
            Kind::PointSymmetryWf => &[("order", Limit::Whole)],
            Kind::Falloff2 => &[("type", Limit::Only(&[0.0, 1.0, 2.0]))],
            Kind::Falloff3 => &[("blur_type", Limit::Only(&[0.0, 1.0]))],
            Kind::DcLinear => &[("scale", Limit::Beyond(1e-4))],
            Kind::BTransform
            | Kind::EJulia
            | Kind::Julia3D
            | Kind::Julia3Dz
            | Kind::Julian2
            | Kind::Julian3Dx
            | Kind::Juliaq
            | Kind::Xtrb => &[("power", Limit::Whole)],
            Kind::Smartcrop => &[
                ("power", Limit::Beyond(2.0)),
                ("cropmode", Limit::Only(&[-1.0, 0.0, 1.0])),
                ("static", Limit::Only(&[2.0])),
            ],
            Kind::FractJuliaWf => &[
                ("max_iter", Limit::Between(2.0, 1000.0)),
                ("max_clip_iter", Limit::Between(1.0, 20.0)),
                ("buddhabrot_mode", Limit::Only(&[0.0])),
                ("power", Limit::Only(&[2.0])),
                ("z_fill", Limit::Only(&[0.0])),
                ("color_only", Limit::Only(&[0.0])),
            ],
            Kind::Mandelbrot => &[
                ("iter", Limit::Between(2.0, MOST_STEPS)),
                ("invert", Limit::Only(&[0.0])),
                ("skin", Limit::Between(0.0, 1.0)),
                ("max_points", Limit::Only(&[-1.0])),
                ("rnd_z_range", Limit::Only(&[0.0])),
            ],
            Kind::Target | Kind::TargetSp => &[("size", Limit::Beyond(1e-4))],
            Kind::TileHlp => &[("width", Limit::Beyond(1e-4))],
            Kind::Juliac => &[("re", Limit::Beyond(1e-4))],
            Kind::Hypertile1 | Kind::Hypertile2 => &[("p", Limit::Whole)],
            Kind::Waves2b => &[("pwx", Limit::Beyond(1e-4)), ("pwy", Limit::Beyond(1e-4))],
            Kind::Bwraps => &[("cellsize", Limit::NotNegative)],
            Kind::Log => &[("base", Limit::NotNegative)],
            Kind::Waffle => &[("slices", Limit::Whole)],
            Kind::Hypertile3D => &[("p", Limit::Whole), ("q", Limit::Whole)],
            Kind::PowBlock => &[
                ("denominator", Limit::Beyond(1e-4)),
                ("correctn", Limit::Beyond(1e-4)),
                ("correctd", Limit::Beyond(1e-4)),
            ],
            Kind::GlynnSim2 => &[("radius", Limit::Beyond(1e-4))],
            Kind::Truchet => &[("extended", Limit::Only(&[0.0])), ("direct_color", Limit::Only(&[0.0]))],
            Kind::Vibration2 => &[("freq", Limit::Beyond(1e-4)), ("freq2", Limit::Beyond(1e-4))],
            _ => &[],
        }
    }

    /// The program whose pictures say what it is: where several have it, the one in which it came first.
    #[expect(clippy::wildcard_enum_match_arm, reason = "all others are of Apophysis and its plugins")]
    pub fn program(self) -> &'static str {
        match self {
            _ if Kind::FLAM3.contains(&self) => "flam3",
            Kind::Affine3D
            | Kind::AxisSymmetryWf
            | Kind::Butterfly3D
            | Kind::CannabiscurveWf
            | Kind::CloverleafWf
            | Kind::EllipticMirrored
            | Kind::EpispiralWf
            | Kind::FractJuliaWf
            | Kind::Juliac
            | Kind::Mandelbrot
            | Kind::PointSymmetryWf
            | Kind::Spherical3D
            | Kind::Spherical3DWf
            | Kind::Spirograph
            | Kind::TileLog
            | Kind::Waves2In3D
            | Kind::Waves2Wf
            | Kind::Waves2b
            | Kind::Waves3Wf
            | Kind::Waves4Wf
            | Kind::YinYang
            | Kind::Boarders2
            | Kind::Acosech
            | Kind::Acosh
            | Kind::Acoth
            | Kind::Asteria
            | Kind::Cone
            | Kind::Ennepers2
            | Kind::HeartWf
            | Kind::Joukowski
            | Kind::RoseWf
            | Kind::Seashell3D
            | Kind::Sec2Bs
            | Kind::Sph3D
            | Kind::Stwin
            | Kind::Tanhq
            | Kind::TargetSp
            | Kind::Taurus
            | Kind::Truchet
            | Kind::Vibration2
            | Kind::Xtrb
            | Kind::Waves22
            | Kind::Waves3
            | Kind::Waves4
            | Kind::WhitneyUmbrella => "JWildfire",
            Kind::Gaussian | Kind::Rblur => "Fractorium",
            _ => "Apophysis",
        }
    }
}

impl Variation {
    /// Its parameters whose values are not drawn; none of a variation that changes nothing.
    pub fn undrawn(&self) -> Vec<Undrawn> {
        if self.is_absent() {
            return Vec::new();
        }
        let value_of = |name: &str| {
            let parameters = self.kind.parameters().iter().zip(self.params);
            parameters.into_iter().find(|(parameter, _)| parameter.name == name).map(|(_, value)| value)
        };
        let undrawn = |(parameter, limit): &(&'static str, Limit)| {
            let value = value_of(parameter).filter(|value| !limit.holds(*value))?;
            Some(Undrawn { parameter, value, limit: *limit })
        };
        self.kind.limits().iter().filter_map(undrawn).collect()
    }

    /// The parameter, with its value, that puts what is drawn at other places than the variation's program does; see
    /// `cells.rs`.
    pub fn placed_otherwise(&self) -> Option<(&'static str, f64)> {
        let distortion = self.params[2];
        let is_moved = self.kind == Kind::Crackle && !self.is_absent() && distortion != 0.0;
        is_moved.then_some((Kind::Crackle.parameters()[2].name, distortion))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parameter_that_is_not_drawn_is_named() {
        for kind in Kind::ALL {
            let names: Vec<&str> = kind.parameters().iter().map(|parameter| parameter.name).collect();
            assert!(kind.limits().iter().all(|(name, _)| names.contains(name)), "{kind:?}");
        }
        let coloured = Variation::new(Kind::Falloff2, 0.5);
        assert_eq!(coloured.undrawn(), []);
        let mut coloured = coloured;
        coloured.params[10] = 3.0;
        let found: Vec<String> =
            coloured.undrawn().iter().map(|one| format!("{} {}: {}", one.parameter, one.value, one.limit)).collect();
        assert_eq!(found, ["type 3: 0, 1 or 2"]);
        assert_eq!(Variation { weight: 0.0, ..coloured }.undrawn(), []);
        assert!(!Limit::Whole.holds(2.5) && !Limit::Whole.holds(0.0) && Limit::Whole.holds(-3.0));
        assert!(!Limit::NotNegative.holds(-0.1) && Limit::NotNegative.holds(0.0));
        assert!(!Limit::Beyond(1e-4).holds(-5e-5) && Limit::Beyond(1e-4).holds(-1.5));
        let few = Limit::Between(1.0, 20.0);
        assert!(few.holds(1.0) && few.holds(20.0) && !few.holds(0.9) && !few.holds(21.0) && !few.holds(f64::NAN));
        assert_eq!(few.to_string(), "1 to 20");
    }
}
