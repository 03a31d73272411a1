//! The crossings of two flames.
//!
//! Owns how often chance takes each, and what a child takes from which parent. Never looks at a picture.
//!
//! Start at [`Genome::crossed`].

use species::{Operator, Rng};

use super::chance::{even, happens};
use super::limits::{LEAST_XFORMS, MOST_XFORMS, bred, in_bytes, within_limits};
use super::palette;
use crate::animate::{Loop, Motion, Transition};
use crate::genome::{Genome, Palette, Xform};

/// How far a child by interpolation is on its way from one parent to the other.
const PART: [f64; 2] = [0.25, 0.75];
/// How often the palettes are crossed; else a child has that of its first parent.
const PALETTES_CROSSED: f64 = 0.4;
/// Frames of a loop so slow that nothing turns while a transition of one frame leads from one parent to the other.
const SLOW: f64 = 1e9;

/// How a child is made of two parents.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Crossing {
    /// Each transform from either.
    Alternation,
    /// Between both.
    Interpolation,
    /// All transforms of both, as far as there is room.
    Union,
    /// The one in the colours of the other.
    Recolouring,
}

/// Each with how often of 100 chance takes it, and what it says of itself. The alias is flam3-genome's name.
pub(super) const TABLE: [(Crossing, u32, Operator); 4] = [
    (
        Crossing::Alternation,
        70,
        Operator::crossing("alternation", &["alternate"], "takes each transform from either parent, some from both"),
    ),
    (
        Crossing::Interpolation,
        15,
        Operator::crossing("interpolation", &["interpolate"], "takes a flame between both, as the transition has it"),
    ),
    (
        Crossing::Union,
        10,
        Operator::crossing("union", &["unite"], "takes all transforms of both; of more than eight the lightest go"),
    ),
    (
        Crossing::Recolouring,
        5,
        Operator::crossing("recolouring", &["recolor"], "gives the first parent the colours of the second"),
    ),
];

impl Crossing {
    /// What it is called.
    pub fn name(self) -> &'static str {
        TABLE[self as usize].2.name
    }

    /// The one that is called `name`.
    pub(super) fn named(name: &str) -> Option<Crossing> {
        TABLE.iter().find(|(_, _, operator)| operator.name == name).map(|(crossing, ..)| *crossing)
    }

    /// Whether it leaves every point of the first parent where it is, so that the camera may stay.
    pub fn is_of_colours(self) -> bool {
        self == Crossing::Recolouring
    }

    /// One by chance.
    pub(super) fn drawn(rng: &mut Rng) -> Crossing {
        TABLE[rng.weighted(&TABLE.map(|(_, share, _)| f64::from(share))).unwrap_or(0)].0
    }
}

impl Genome {
    /// A child of two parents by a crossing that chance takes, and which it is. Its camera stands where this one's does.
    pub fn crossed(&self, with: &Genome, rng: &mut Rng) -> (Genome, Crossing) {
        let crossing = Crossing::drawn(rng);
        (self.crossed_by(crossing, with, rng), crossing)
    }

    /// A child of two parents by this crossing.
    #[must_use]
    pub fn crossed_by(&self, crossing: Crossing, with: &Genome, rng: &mut Rng) -> Genome {
        let (a, b) = (bred(self, rng), bred(with, rng));
        let mut child = match crossing {
            Crossing::Alternation => alternated(&a, &b, rng),
            Crossing::Interpolation => interpolated(&a, &b, even(rng, PART[0], PART[1]), rng),
            Crossing::Union => united(&a, &b, rng),
            Crossing::Recolouring => return within_limits(recoloured(&a, &b)),
        };
        if let (Some(own), Some(other)) = (&a.palette, &b.palette)
            && crossing != Crossing::Interpolation
            && happens(rng, PALETTES_CROSSED)
        {
            child.palette = Some(palette::crossed(own, other, rng));
        }
        within_limits(child)
    }
}

/// Each transform from either parent, both giving at least one; as many as one of them has, or a number between.
fn alternated(a: &Genome, b: &Genome, rng: &mut Rng) -> Genome {
    let counts = [a.xforms.len(), b.xforms.len()];
    let (few, many) = (counts[0].min(counts[1]), counts[0].max(counts[1]));
    let count = (few + rng.below(many - few + 1)).clamp(LEAST_XFORMS, MOST_XFORMS);
    let mut from_b: Vec<bool> = (0..count).map(|_| happens(rng, 0.5)).collect();
    // A place that one parent lacks is the other's.
    for (place, from_b) in from_b.iter_mut().enumerate() {
        *from_b = if place >= counts[0] { true } else { *from_b && place < counts[1] };
    }
    // Both have the first two places: a parent that has given nothing gives one of them.
    if from_b.iter().all(|place| *place == from_b[0]) {
        let place = rng.below(LEAST_XFORMS);
        from_b[place] ^= true;
    }
    let of = |(place, from_b): (usize, &bool)| if *from_b { &b.xforms[place] } else { &a.xforms[place] };
    let xforms: Vec<Xform> = from_b.iter().enumerate().map(of).cloned().collect();
    // Chaos of either was about other transforms; what there is of it is kept by place.
    let most = xforms.len();
    let cut = |xform: Xform| {
        let mut chaos = xform.chaos.clone();
        chaos.truncate(most);
        let is_dead_end = chaos.len() == most && chaos.iter().all(|weight| *weight <= 0.0);
        Xform { chaos: if is_dead_end { Vec::new() } else { chaos }, ..xform }
    };
    with_parts_of_either(a, b, xforms.into_iter().map(cut).collect(), rng)
}

/// A flame between both: transforms by the partners that a transition gives them, the symmetry of either.
fn interpolated(a: &Genome, b: &Genome, part: f64, rng: &mut Rng) -> Genome {
    let [from, to] = [a, b].map(|end| Loop::new(&Genome { symmetries: Vec::new(), ..end.clone() }, SLOW));
    // A transition sets out and arrives slowly: at this part of its time it has come so far.
    let time = 0.5 - libm::sin(libm::asin(1.0 - 2.0 * part) / 3.0);
    let between = Transition::new(&from, &to, 1.0).at(time);
    let symmetries = if happens(rng, 0.5) { &a.symmetries } else { &b.symmetries };
    let whole = |xform: &Xform| Xform { animate: if xform.animate == 0.0 { 0.0 } else { 1.0 }, ..xform.clone() };
    Genome {
        camera: a.camera,
        sampling: a.sampling,
        xforms: between.xforms.iter().map(whole).collect(),
        finals: between.finals.iter().map(whole).collect(),
        palette: between.palette.as_ref().map(in_bytes),
        palette_mode: between.palette_mode,
        tone: between.tone,
        symmetries: symmetries.clone(),
        ..a.clone()
    }
}

/// All transforms of both, those of each as often as those of the other together.
fn united(a: &Genome, b: &Genome, rng: &mut Rng) -> Genome {
    let sum = |genome: &Genome| genome.xforms.iter().map(|xform| xform.weight.max(0.0)).sum::<f64>();
    let ratio = if sum(b) > 0.0 && sum(a) > 0.0 { sum(a) / sum(b) } else { 1.0 };
    let own = a.xforms.iter().map(|xform| Xform { chaos: Vec::new(), ..xform.clone() });
    let others =
        b.xforms.iter().map(|xform| Xform { chaos: Vec::new(), weight: ratio * xform.weight, ..xform.clone() });
    with_parts_of_either(a, b, own.chain(others).collect(), rng)
}

/// The first parent with these transforms, and with the symmetry and the final transform of either.
fn with_parts_of_either(a: &Genome, b: &Genome, xforms: Vec<Xform>, rng: &mut Rng) -> Genome {
    let symmetries = if happens(rng, 0.5) { &a.symmetries } else { &b.symmetries };
    let finals = if happens(rng, 0.5) { &a.finals } else { &b.finals };
    Genome { xforms, symmetries: symmetries.clone(), finals: finals.clone(), ..a.clone() }
}

/// The first parent in the colours of the second.
fn recoloured(a: &Genome, b: &Genome) -> Genome {
    let colours = b.xforms.iter().cycle();
    let of = |(own, other): (&Xform, &Xform)| Xform {
        color: other.color,
        color2: other.color2,
        color_speed: other.color_speed,
        ..own.clone()
    };
    let xforms = a.xforms.iter().zip(colours).map(of).collect();
    let palette: Option<Palette> = b.palette.clone().or_else(|| a.palette.clone());
    Genome { xforms, palette, palette_mode: b.palette_mode, ..a.clone() }
}
