//! Agents at random.
//!
//! Owns the families that a string may be of: crystals, closed curves, curves that fill, rosettes. Never judges them.
//!
//! Start at [`string`].
//!
//! # Source
//! Prusinkiewicz & Lindenmayer, *The Algorithmic Beauty of Plants* (1990), chapter 1, for the curves that fill.

use species::Rng;

/// One of several.
pub(crate) fn one<'a, T: ?Sized>(rng: &mut Rng, of: &[&'a T]) -> &'a T {
    of[rng.below(of.len())]
}

/// A kind of agent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Family {
    Crystal,
    Curve,
    Filling,
    Rosette,
}

impl Family {
    /// Crystals are the most usual.
    pub(crate) fn random(rng: &mut Rng) -> Family {
        use Family::{Crystal, Curve, Filling, Rosette};
        [Crystal, Crystal, Crystal, Crystal, Curve, Curve, Filling, Rosette, Rosette, Rosette][rng.below(10)]
    }
}

/// An agent of a family.
pub(crate) fn string(family: Family, rng: &mut Rng) -> String {
    match family {
        Family::Crystal => crystal(rng),
        Family::Curve => curve(rng),
        Family::Filling => filling(rng),
        Family::Rosette => rosette(rng),
    }
}

/// Arms around a middle, each with twigs in pairs, as snow grows.
fn crystal(rng: &mut Rng) -> String {
    let arms = [6, 6, 6, 6, 8, 5][rng.below(6)];
    let start = vec!["[X]"; arms].join("+");
    let twig = |rng: &mut Rng| one(rng, &["Y", "FY", "FFY", "F", "FF"]).to_owned();
    let mut arm = String::new();
    for pair in 0..=rng.below(3) {
        arm.push_str(one(rng, &["F", "FF"]));
        if pair == 0 || rng.unit() < 0.8 {
            let twig = twig(rng);
            arm.extend(["[+", &twig, "][-", &twig, "]"]);
        }
    }
    arm.push_str(one(rng, &["FX", "X", "FX"]));
    let twigs = ["F[+F][-F]Y", "FY", "F[+Y][-Y]F", "FF[+F][-F]", "F[+F][-F]F[+F][-F]"];
    let (it, sway) = (2 + rng.below(3), rng.signed() * 7.0);
    let turn = 360.0 / arms as f64;
    let scale = 2.0 + 5.0 * rng.unit();
    let twig = one(rng, &twigs);
    format!("v={turn}&str={start}&it={it}&sc={scale:.1}&rules=('X','{arm}'),('Y','{twig}')&sw={sway:.1}")
}

/// A regular figure whose sides are replaced, as in Koch's snowflake.
fn curve(rng: &mut Rng) -> String {
    let (turn, start) = [
        (60, "F++F++F"),
        (60, "F+F+F+F+F+F"),
        (90, "F+F+F+F"),
        (72, "F+F+F+F+F"),
        (45, "F++F++F++F"),
        (36, "F++F++F++F++F"),
    ][rng.below(6)];
    let rule = match turn {
        60 => one(rng, &["F-F++F-F", "F+F--F+F", "F-F++F-F+F--F+F", "F[-F]+F-F", "F-FF++FF-F"]),
        90 => one(rng, &["F-F+F+FF-F-F+F", "FF+F+F+F+F+F-F", "F+F-F-F+F", "FF+F-F+F+FF", "FF+F++F+F"]),
        72 => one(rng, &["F+F-F-F+F", "F-F+F", "F+F+F-F-F-F+F"]),
        45 => one(rng, &["F-F++F-F", "F+F--F+F", "F--F++F"]),
        _ => one(rng, &["F++F----F++F", "F-F++F-F", "F+F--F+F"]),
    };
    let (it, sway, scale) = (2 + rng.below(3), rng.signed() * 3.0, 3.0 + 4.0 * rng.unit());
    format!("v={turn}&str={start}&it={it}&sc={scale:.1}&rules=('F','{rule}')&sw={sway:.1}")
}

/// A curve that fills an area, or nearly.
fn filling(rng: &mut Rng) -> String {
    let (turn, start, most, rules) = [
        (90, "FX", 9, "('X','X+YF+'),('Y','-FX-Y')"),
        (60, "XF", 5, "('X','YF+XF+Y'),('Y','XF-YF-X')"),
        (60, "XF", 3, "('X','X+YF++YF-FX--FXFX-YF+'),('Y','-FX+YFYF++YF+FX--FX-YF')"),
        (90, "X", 4, "('X','-YF+XFX+FY-'),('Y','+XF-YFY-FX+')"),
        (120, "F-X-X", 4, "('F','F-X+F+X-F'),('X','FF')"),
        (45, "F--X--F--X", 3, "('X','XF+F+XF--F--XF+F+X')"),
        (45, "X--F--X--F", 3, "('X','X+F+X--F--X+F+X')"),
    ][rng.below(7)];
    let (it, sway, scale) = (most - rng.below(2), rng.signed() * 2.5, 2.0 + 4.0 * rng.unit());
    format!("v={turn}&str={start}&it={it}&sc={scale:.1}&rules={rules}&sw={sway:.1}")
}

/// Ferns or spirals around a middle.
fn rosette(rng: &mut Rng) -> String {
    let (turn, between, arms) =
        [(30.0, 2, 6), (22.5, 2, 8), (20.0, 3, 6), (24.0, 3, 5), (18.0, 4, 5), (30.0, 4, 3)][rng.below(6)];
    let start = vec!["[X]"; arms].join(&"+".repeat(between));
    let rules = [
        ("('X','F[+X]F[-X]+X'),('F','FF')", 4),
        ("('X','F-[[X]+X]+F[+FX]-X'),('F','FF')", 3),
        ("('X','F+FX')", 14),
        ("('X','F[++F][--F]+X')", 9),
        ("('X','F[+Y]FX'),('Y','F+FY')", 7),
        ("('X','F[+FX][-FX]')", 4),
        ("('X','F[-Y][+Y]FX'),('Y','F[-F][+F]Y')", 5),
    ];
    let (rules, most) = rules[rng.below(rules.len())];
    let (it, sway, scale) = (most - rng.below(2), rng.signed() * 5.0, 2.0 + 4.0 * rng.unit());
    format!("v={turn}&str={start}&it={it}&sc={scale:.1}&rules={rules}&sw={sway:.1}")
}
