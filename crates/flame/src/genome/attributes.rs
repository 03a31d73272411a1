//! Attributes and elements that no other module reads: which of them change the picture.
//!
//! Owns the tables: what is neutral, on which condition, and what a value that is not neutral asks for. An attribute that
//! becomes drawn loses its line here. `unsupported.rs` makes the list of a genome.
//!
//! Start at [`of_flame`] and [`of_xform`].
//!
//! # Source
//! Pictures of the programs that write them, with and without each attribute.

use super::motion_curve::AT_FRAME;
use super::origin::is_of_origin;
use super::parse::list;
use super::unsupported::Why;
use super::{Camera, Xform};
use variations::{PRIORITY, Spelling};

/// When an attribute changes nothing.
enum Neutral {
    /// A number such as this one.
    At(f64),
    /// Any numbers that are all 0.
    Dark,
    /// One of these words, or 0.
    Word(&'static [&'static str]),
}

use Neutral::{At, Dark, Word};

/// Attributes of `<flame>`, when they are neutral, and what they else ask for.
const FLAME: &[(&str, Neutral, Why)] = &[
    ("background_cc", Dark, Why::Background),
    ("background_ll", Dark, Why::Background),
    ("background_lr", Dark, Why::Background),
    ("background_ul", Dark, Why::Background),
    ("background_ur", Dark, Why::Background),
    ("balancing_blue", At(1.0), Why::Tone),
    ("balancing_green", At(1.0), Why::Tone),
    ("balancing_red", At(1.0), Why::Tone),
    ("contrast", At(1.0), Why::Tone),
    ("logscale_k2", At(0.0), Why::Tone),
    ("low_density_brightness", At(0.24), Why::Tone),
    ("mixer_mode", Word(&["OFF"]), Why::Effect),
    ("post_blur_radius", At(0.0), Why::Effect),
    ("post_symmetry_type", Word(&["NONE"]), Why::Effect),
    ("saturation", At(1.0), Why::Tone),
    ("sld_render_enabled", Word(&["false"]), Why::Solid),
    ("smooth_gradient", At(0.0), Why::Colour),
    ("white_level", At(220.0), Why::Tone),
];

/// The attribute of another blur by depth.
pub(super) const NEW_BLUR: &str = "new_dof";

/// Attributes of `<flame>` that change no still picture; a `*` stands for any end. Those that belong to an attribute of
/// [`FLAME`] mean nothing while that is neutral.
const NEUTRAL_OF_FLAME: &[&str] = &[
    "ai_*",
    "antialias_*",
    "background_type",
    "bg_transparency",
    "cam_dof_*",
    "cam_xfocus",
    "cam_yfocus",
    "cam_zfocus",
    "enable_de",
    "fg_opacity",
    "filter_indicator",
    "filter_kernel",
    "filter_low_density",
    "filter_sharpness",
    "filter_type",
    "flam3h_*",
    "fps",
    "frame",
    "frame_count",
    "fuse",
    "grad_edit_*",
    "mixer_*",
    // It shows what moves by curves, which are refused themselves.
    "motion_blur_*",
    "new_linear",
    "plugins",
    "post_blur_*",
    "post_optix_denoiser_blend",
    "post_symmetry_*",
    // `carry.rs` reads it.
    "preserve_z",
    "rand_range",
    "sld_render_*",
    "sub_batch_size",
    "zbuffer_*",
];

/// Attributes of a transform, as [`FLAME`].
const XFORM: &[(&str, Neutral, Why)] = &[
    (AT_FRAME, Word(&[]), Why::Frame),
    ("color_type", Word(&["DIFFUSION"]), Why::Colour),
    // What it says in older files is of no use to its program.
    ("heart_wf_scale_t", At(1.0), Why::Value),
    ("mod_contrast", At(0.0), Why::Colour),
    ("mod_contrast_speed", At(0.0), Why::Colour),
    ("mod_gamma", At(0.0), Why::Colour),
    ("mod_gamma_speed", At(0.0), Why::Colour),
    ("mod_hue", At(0.0), Why::Colour),
    ("mod_hue_speed", At(0.0), Why::Colour),
    ("mod_saturation", At(0.0), Why::Colour),
    ("mod_saturation_speed", At(0.0), Why::Colour),
    ("var_color", At(1.0), Why::Colour),
    ("wfield_type", Word(&["NONE"]), Why::WeightField),
];

/// Attributes of a transform that change no picture, as [`NEUTRAL_OF_FLAME`]. A material is for solid rendering;
/// Fractorium writes down half the scale of an auger, too.
const NEUTRAL_OF_XFORM: &[&str] =
    &["auger_half_scale", "material", "material_speed", "mirror_pre_post_translations", "name", "wfield_*"];

/// What a curve over time consists of, after its name.
const PARTS_OF_CURVE: [&str; 11] = [
    "enabled",
    "interpolation",
    "locked",
    "point_count",
    "selected_idx",
    "view_xmax",
    "view_xmin",
    "view_ymax",
    "view_ymin",
    "x",
    "y",
];

/// What an attribute means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// It changes no picture.
    Neutral,
    /// It asks for what is not drawn.
    Asks(Why),
    /// No table has it.
    Unknown,
}

/// What attribute `name` of a `<flame>` with such a camera means.
pub(super) fn of_flame(name: &str, value: &str, camera: &Camera) -> Meaning {
    if name == super::MARK || is_of_origin(name) || fits(NEUTRAL_OF_FLAME, name) {
        // A rule counts before a pattern that fits it, too.
        return by_rule(FLAME, name, value).unwrap_or(Meaning::Neutral);
    }
    // Apophysis' copy of `rotate` in radians.
    if name == "angle" && camera.rotate != 0.0 {
        return Meaning::Neutral;
    }
    // JWildfire's blur by the distance from a point. It is drawn as one by the distance from a plane.
    if name == NEW_BLUR && camera.pose.depth_blur == 0.0 {
        return Meaning::Neutral;
    }
    by_rule(FLAME, name, value).or_else(|| of_curve(name, value)).unwrap_or_else(|| unless_0(value))
}

/// What attribute `name` of a transform means. Of a variation that is unknown all attributes are.
pub(super) fn of_xform(xform: &Xform, name: &str, value: &str) -> Meaning {
    // How much of a colour comes from its variations; most give none.
    if name == "var_color" && !xform.variations.iter().any(|it| !it.is_absent() && it.changes_colour()) {
        return Meaning::Neutral;
    }
    if name.ends_with(PRIORITY) {
        // That of an unknown variation says no more than the variation does.
        let Some(Spelling { slot, .. }) = Spelling::of(name) else { return Meaning::Neutral };
        let is_drawn = xform.variations.iter().any(|it| it.weight != 0.0 && it.slot() == slot);
        // What moves a variation has done so: what is left is its own, or is none.
        let stages = list::<f64>(value).and_then(|given| Spelling::stages_of_priority(slot, *given.first()?));
        return if stages == Some((slot.stage, None)) || !is_drawn {
            Meaning::Neutral
        } else {
            Meaning::Asks(Why::Order)
        };
    }
    let rule = by_rule(XFORM, name, value).or_else(|| fits(NEUTRAL_OF_XFORM, name).then_some(Meaning::Neutral));
    rule.or_else(|| of_curve(name, value)).unwrap_or_else(|| unless_0(value))
}

fn by_rule(rules: &[(&str, Neutral, Why)], name: &str, value: &str) -> Option<Meaning> {
    let (_, neutral, why) = rules.iter().find(|(known, ..)| *known == name)?;
    Some(if neutral.holds(value.trim()) { Meaning::Neutral } else { Meaning::Asks(*why) })
}

/// What a part of a curve means: one that is not enabled changes nothing.
fn of_curve(name: &str, value: &str) -> Option<Meaning> {
    let (_, part) = name.rsplit_once("Curve_").or_else(|| name.rsplit_once("_curve_"))?;
    let digits = part.trim_start_matches(['x', 'y']);
    let is_point = digits.len() + 1 == part.len() && digits.bytes().all(|byte| byte.is_ascii_digit());
    if !is_point && !PARTS_OF_CURVE.contains(&part) {
        return None;
    }
    let is_enabled = part == "enabled" && value.trim().eq_ignore_ascii_case("true");
    Some(if is_enabled { Meaning::Asks(Why::Curve) } else { Meaning::Neutral })
}

/// Whether one of `patterns` is `name`, or its beginning before a `*`.
fn fits(patterns: &[&str], name: &str) -> bool {
    patterns.iter().any(|pattern| match pattern.strip_suffix('*') {
        Some(start) => name.starts_with(start),
        None => name == *pattern,
    })
}

/// What no table has is unknown, unless it is 0.
fn unless_0(value: &str) -> Meaning {
    if value.trim().parse::<f64>().is_ok_and(|number| number == 0.0) { Meaning::Neutral } else { Meaning::Unknown }
}

impl Neutral {
    fn holds(&self, value: &str) -> bool {
        let numbers = list::<f64>(value);
        let all = |holds: &dyn Fn(&[f64]) -> bool| numbers.as_deref().is_some_and(holds);
        match self {
            At(neutral) => all(&|numbers| numbers == [*neutral]),
            Dark => all(&|numbers| numbers.iter().all(|number| *number == 0.0)),
            Word(words) => words.contains(&value) || all(&|numbers| numbers == [0.0]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Genome;
    use super::*;
    use variations::{Kind, Variation};

    #[test]
    fn attributes_of_a_flame_are_neutral_at_their_own_values_only() {
        let straight = Genome::default().camera;
        let mut other = straight;
        (other.rotate, other.pose.depth_blur) = (57.3, 0.2);
        let is_drawn = |name, value| of_flame(name, value, &straight) == Meaning::Neutral;
        for (name, neutral, other) in [
            ("background_ul", "0.0 0.0 0.0", "0 0.1 0"),
            ("contrast", " 1 ", "0"),
            ("low_density_brightness", "0.24", "0"),
            ("mixer_mode", "OFF", "RGB"),
            ("post_symmetry_type", "NONE", "POINT"),
            ("sld_render_enabled", "0", "1"),
            ("white_level", "220.0", "NaN"),
        ] {
            assert!(is_drawn(name, neutral) && !is_drawn(name, other), "{name}");
        }
        for name in
            ["ai_post_denoiser", "post_symmetry_order", "mixer_rr_curve_x1", "grad_edit_hue_curve_enabled", "url"]
        {
            assert!(is_drawn(name, "true"), "{name}");
        }
        assert_eq!(of_flame("cam_pitchCurve_enabled", "true", &straight), Meaning::Asks(Why::Curve));
        assert!(is_drawn("cam_pitchCurve_enabled", "false") && is_drawn("cam_pitchCurve_x0", "7"));
        for (name, value, camera, meaning) in [
            ("angle", "1", &straight, Meaning::Unknown),
            ("angle", "1", &other, Meaning::Neutral),
            ("new_dof", "1", &straight, Meaning::Neutral),
            ("new_dof", "1", &other, Meaning::Unknown),
            ("new_dof", "0", &other, Meaning::Neutral),
            ("waltz", "3", &straight, Meaning::Unknown),
            ("waltz", "0", &straight, Meaning::Neutral),
        ] {
            assert_eq!(of_flame(name, value, camera), meaning, "{name}={value}");
        }
    }

    #[test]
    fn attributes_of_a_transform_are_neutral_on_their_conditions() {
        let variations = [("linear", 0.5), ("pre_blur", 1.0), ("swirl", 0.0)];
        let variations = variations.map(|(name, weight)| Variation::new(Kind::named(name).unwrap(), weight));
        let xform = Xform { variations: variations.to_vec(), ..Xform::default() };
        let of = |name, value| of_xform(&xform, name, value);
        for (name, value) in [
            ("var_color", "1"),
            ("var_color", "0.3"),
            ("linear_fx_priority", "0"),
            ("pre_blur_fx_priority", "-1"),
            ("swirl_fx_priority", "1"),
            ("waltz_fx_priority", "1"),
            ("color_type", "DIFFUSION"),
            ("material", "0.7"),
            ("mirror_pre_post_translations", "1"),
            ("wfield_type", "NONE"),
            ("wfield_input", "AFFINE"),
            ("xyCoeff20Curve_enabled", "false"),
            ("xyCoeff20Curve_x12", "5"),
            ("name", "left arm"),
            ("waltz", "0.0"),
        ] {
            assert_eq!(of(name, value), Meaning::Neutral, "{name}={value}");
        }
        for (name, value, why) in [
            ("linear_fx_priority", "2", Why::Order),
            ("pre_blur_fx_priority", "0.5", Why::Order),
            ("color_type", "CYCLIC", Why::Colour),
            ("mod_hue", "0.5", Why::Colour),
            ("wfield_type", "CELLULAR_NOISE", Why::WeightField),
            ("xyCoeff20Curve_enabled", "true", Why::Curve),
        ] {
            assert_eq!(of(name, value), Meaning::Asks(why), "{name}={value}");
        }
        for (name, value) in [("waltz", "0.5"), ("waltz", "on"), ("waltz_curve_sides", "3")] {
            assert_eq!(of(name, value), Meaning::Unknown, "{name}={value}");
        }
    }
}
