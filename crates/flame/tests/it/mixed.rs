//! Small genomes in each of which one variation plays the first part.
//!
//! Owns their text, as a file would have it, so that the names of variations and parameters are tested too. Never renders.
//!
//! Start at [`texts`].

use std::fmt::Write;

use flame::variations::Kind;

/// Two mixtures for each of flam3's variations that has parameters, one for each that has none: a name and a genome.
pub(crate) fn texts() -> Vec<(String, String)> {
    texts_of(&Kind::FLAM3)
}

/// A mixture for each variation of other programs, with its default parameters, seen by a camera that is tilted.
pub(crate) fn of_others() -> Vec<(String, String)> {
    let others: Vec<Kind> = Kind::ALL.into_iter().filter(|kind| !Kind::FLAM3.contains(kind)).collect();
    let tilted = |text: String| text.replacen("<flame", "<flame cam_pitch=\"0.5\" cam_yaw=\"0.3\"", 1);
    texts_of(&others).into_iter().map(|(name, text)| (name, tilted(text))).collect()
}

fn texts_of(kinds: &[Kind]) -> Vec<(String, String)> {
    let of_kind = |kind: Kind| {
        let sets = parameters(kind);
        let several = sets.len() > 1;
        (0..sets.len()).map(move |number| {
            let name = if several { format!("{}, {}", kind.name(), number + 1) } else { kind.name().to_owned() };
            (name, text(kind, sets[number], number))
        })
    };
    kinds.iter().copied().flat_map(of_kind).collect()
}

/// A genome of three transforms. The first has the variation and a little of the plain point, the others pull together.
fn text(kind: Kind, parameters: &[f64], number: usize) -> String {
    let name = kind.name();
    // What turns the variation on its side, or inside out, shows other mistakes.
    let (weight, coefs) =
        if number == 0 { (0.7, "0.78 0.31 -0.43 0.72 0.35 0.21") } else { (0.9, "-0.57 0.62 0.66 0.71 -0.28 0.43") };
    // What edisc makes is small.
    let weight = if kind == Kind::Edisc { 6.0 } else { weight };
    let mut of_kind = format!("{name}=\"{weight}\"");
    for (parameter, value) in kind.parameters().iter().zip(parameters) {
        write!(of_kind, " {name}_{}=\"{value}\"", parameter.name).unwrap();
    }
    let plain = if kind == Kind::Linear { "" } else { "linear=\"0.3\"" };
    format!(
        "<flame name=\"mixed\" time=\"0\" size=\"96 72\" scale=\"17\" filter=\"0.5\" quality=\"2000\" temporal_samples=\"1\" \
         estimator_radius=\"0\" brightness=\"4\" gamma=\"4\" gamma_threshold=\"0.01\" vibrancy=\"1\">\
         <xform weight=\"1.4\" color=\"0\" coefs=\"{coefs}\" {of_kind} {plain}/>\
         <xform weight=\"1\" color=\"0.6\" coefs=\"0.55 -0.32 0.27 0.61 -0.9 0.4\" linear=\"0.95\"/>\
         <xform weight=\"0.8\" color=\"1\" coefs=\"0.9 0.5 -0.6 0.7 0.3 -0.8\" sinusoidal=\"1.1\"/>\
         <color index=\"0\" rgb=\"250 90 40\"/><color index=\"110\" rgb=\"120 220 70\"/><color index=\"200\" rgb=\"60 80 240\"/>\
         </flame>"
    )
}

/// What the parameters are, in the order of [`Kind::parameters`]; without parameters, and with default ones, one empty set.
#[expect(clippy::wildcard_enum_match_arm, reason = "all others have no parameters, or default ones")]
fn parameters(kind: Kind) -> &'static [&'static [f64]] {
    match kind {
        Kind::Blob => &[&[0.3, 1.2, 4.0], &[-0.4, 0.9, 3.0]],
        Kind::Pdj => &[&[1.2, -0.7, 1.9, 0.6], &[-2.1, 1.4, -0.8, 1.7]],
        Kind::Fan2 => &[&[0.6, 0.4], &[0.9, -1.3]],
        Kind::Rings2 => &[&[0.6], &[-0.9]],
        Kind::Perspective => &[&[0.4, 3.2], &[-0.7, 2.6]],
        Kind::Julian => &[&[3.0, 1.1], &[-2.0, 0.8]],
        Kind::Juliascope => &[&[3.0, 1.1], &[-4.0, 0.8]],
        Kind::RadialBlur => &[&[0.5], &[-0.8]],
        Kind::Pie => &[&[5.0, 0.7, 0.4], &[3.0, -1.1, 0.8]],
        Kind::Ngon => &[&[2.1, 5.0, 1.2, 0.8], &[1.4, 4.0, -0.6, 1.3]],
        Kind::Curl => &[&[0.5, 0.3], &[-0.8, 0.6]],
        Kind::Rectangles => &[&[0.6, 0.9], &[0.0, 0.5]],
        Kind::Disc2 => &[&[0.7, 1.1], &[-1.3, 8.0], &[0.9, -7.5]],
        Kind::SuperShape => &[&[0.3, 5.0, 1.4, 1.8, 0.9, 0.2], &[0.0, 3.0, -2.2, 1.1, 2.3, -0.3]],
        Kind::Flower => &[&[0.4, 5.0], &[-0.3, 2.5]],
        Kind::Conic => &[&[0.3, 0.7], &[-0.2, 1.4]],
        Kind::Parabola => &[&[1.3, 0.8], &[-0.9, 1.6]],
        Kind::Bent2 => &[&[0.6, 1.4], &[-0.7, 0.3]],
        Kind::Bipolar => &[&[0.4], &[-1.3]],
        Kind::Cell => &[&[0.6], &[0.35]],
        Kind::Cpow => &[&[1.1, 0.3, 3.0], &[0.8, -0.6, 2.0]],
        Kind::Curve => &[&[0.7, -0.5, 0.8, 1.2], &[-1.1, 0.9, 0.4, 0.6]],
        Kind::Escher => &[&[0.5], &[-1.2]],
        Kind::Lazysusan => &[&[0.8, 0.4, 0.6, 0.2, -0.3], &[-1.4, -0.3, -0.9, -0.4, 0.1]],
        Kind::Modulus => &[&[0.5, 0.7], &[0.9, 0.3]],
        Kind::Oscilloscope => &[&[0.3, 0.8, 0.7, 0.0], &[0.6, 1.3, 0.9, 0.5]],
        Kind::Popcorn2 => &[&[0.4, -0.3, 1.6], &[-0.6, 0.5, 2.4]],
        Kind::Separation => &[&[0.5, 0.3, 0.7, -0.2], &[0.8, -0.6, 0.3, 0.9]],
        Kind::Split => &[&[0.7, 1.1], &[1.6, 0.5]],
        Kind::Splits => &[&[0.4, 0.6], &[-0.7, 0.3]],
        Kind::Stripes => &[&[0.4, 0.6], &[-0.5, 1.3]],
        Kind::Wedge => &[&[0.7, 0.2, 3.0, 0.4], &[1.3, -0.4, 2.0, -0.8]],
        Kind::WedgeJulia => &[&[0.6, 3.0, 2.0, 1.1], &[1.1, 2.0, -3.0, 0.7]],
        Kind::WedgeSph => &[&[0.9, -0.2, 2.0, 0.5], &[0.6, 0.4, 4.0, -0.3]],
        Kind::Whorl => &[&[0.5, 0.3], &[-0.9, 0.7]],
        Kind::Waves2 => &[&[0.6, -0.4, 1.7, 2.3], &[0.9, 0.7, -2.6, 1.2]],
        Kind::Auger => &[&[1.8, 0.6, 0.7, 0.4], &[2.9, -0.4, 0.3, 1.5]],
        Kind::Flux => &[&[0.2], &[-0.9]],
        // By itself it has none that is drawn.
        Kind::Juliac => &[&[3.0, 20.0, 0.8]],
        Kind::Mobius => &[&[0.9, 0.2, -0.3, 0.4, 0.5, -0.6, 1.1, 0.3], &[-0.4, 0.8, 0.6, -0.7, 0.3, 0.9, -0.5, 0.7]],
        _ => &[&[]],
    }
}
