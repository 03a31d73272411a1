//! Globes at random.
//!
//! Owns their colours, how many agents there are, and which of them are good enough to be shown. Never mates: `breed.rs`
//! does.
//!
//! Start at [`random`].

use std::f64::consts::TAU;

use species::Rng;

use crate::colour::Colour;
use crate::globe::{Globe, Kept};
use crate::pfeiffer::Pfeiffer;
use crate::shape::{Middle, Shape};
use crate::strings::{Family, string};
use crate::turtle::walk;

/// The fewest and the most agents of a globe that is bred.
pub(crate) const AGENTS: [usize; 2] = [8, 20];
/// The fewest and the most segments of an agent that is bred.
const SEGMENTS: [usize; 2] = [12, 4000];
/// How bright the bottom and the top of a background are on a screen.
const GROUND: [[f64; 2]; 2] = [[0.06, 0.10], [0.13, 0.18]];
/// How fast swaying may make an agent of a globe that is bred: faster ones flicker.
const CALMEST: f64 = 3.0;
/// Attempts until what is known to be good is taken.
const ATTEMPTS: usize = 60;

/// A globe at random.
pub(crate) fn random(rng: &mut Rng) -> Globe {
    let (background, palette) = colours(rng);
    let drift = rng.bits() as u32;
    let mut globe = Globe {
        name: None,
        background,
        palette,
        drift,
        glow: tenths(0.7 + 0.7 * rng.unit()),
        dust: 60 + rng.below(140) as u32,
        flock: Vec::new(),
        shapes: Vec::new(),
        kept: Kept::default(),
    };
    let families = [Family::random(rng), Family::random(rng)];
    let agents = AGENTS[0] + 2 + rng.below(AGENTS[1] - AGENTS[0] - 2);
    for _ in 0..agents * ATTEMPTS {
        let text = string(families[rng.below(2)], rng);
        if globe.flock.len() < agents {
            globe.take(text);
        }
    }
    fill(&mut globe, rng);
    globe
}

/// Adds agents at random until there are enough.
pub(crate) fn fill(globe: &mut Globe, rng: &mut Rng) {
    while globe.flock.len() < AGENTS[0] {
        let text = string(Family::random(rng), rng);
        globe.take(text);
    }
}

/// A number with one digit after the point.
pub(crate) fn tenths(number: f64) -> f64 {
    (number * 10.0).round() / 10.0
}

impl Globe {
    /// Takes in another agent, if it may be shown: it is seen, whole, no twin, and neither poor nor endless.
    pub(crate) fn take(&mut self, text: String) -> bool {
        let good = shape(&text).filter(|shape| self.shapes.iter().all(|other| other.hash != shape.hash));
        let is_good = good.is_some() && self.flock.len() < AGENTS[1];
        if let Some(shape) = good.filter(|_| is_good) {
            self.flock.push(text);
            self.shapes.push(shape);
        }
        is_good
    }
}

/// An agent that may be shown where nobody but chance has chosen it.
pub(crate) fn shape(text: &str) -> Option<Shape> {
    let shape = Shape::of(Pfeiffer::read(text)).ok()?;
    let is_rich = (SEGMENTS[0]..=SEGMENTS[1]).contains(&shape.strokes);
    // What is all edge and no body is a line or a speck.
    let is_spread = shape.spread > 0.2 * shape.reach && shape.aspect > 0.5;
    let is_good = shape.is_whole && is_rich && is_spread && shape.size > 0.17 && text.len() <= 400;
    (is_good && swaying(&shape) < CALMEST).then_some(shape)
}

/// How fast the strokes of an agent go because it sways, on average and at most: in reaches a loop.
fn swaying(shape: &Shape) -> f64 {
    const DEGREES: f64 = 0.02;
    if shape.agent.sw == 0.0 {
        return 0.0;
    }
    let strokes = [0.0, DEGREES].map(|more| {
        let mut strokes = Vec::new();
        walk(&shape.agent, shape.agent.v + more, |stroke| strokes.push(stroke));
        let middle = Middle::of(&strokes);
        strokes.iter().map(|stroke| [0, 1].map(|axis| (stroke.to[axis] - middle.at[axis]) / middle.reach)).collect()
    });
    let [still, moved]: [Vec<[f64; 2]>; 2] = strokes;
    let ways = still.iter().zip(&moved).map(|(from, to)| {
        let [x, y] = [0, 1].map(|axis| to[axis] - from[axis]);
        (x * x + y * y).sqrt()
    });
    ways.sum::<f64>() / still.len() as f64 / DEGREES * shape.agent.sw.abs() * TAU
}

/// Nights: the hue of the ground in turns, and the hues of the agents.
const NIGHTS: [(f64, [f64; 3]); 8] = [
    (0.61, [0.55, 0.58, 0.63]),
    (0.56, [0.42, 0.50, 0.74]),
    (0.68, [0.08, 0.12, 0.58]),
    (0.78, [0.92, 0.84, 0.60]),
    (0.63, [0.11, 0.57, 0.60]),
    (0.72, [0.03, 0.90, 0.54]),
    (0.49, [0.14, 0.46, 0.53]),
    (0.90, [0.09, 0.01, 0.90]),
];

/// A background and a palette that go together.
fn colours(rng: &mut Rng) -> ([Colour; 2], Vec<Colour>) {
    let (ground, hues) = NIGHTS[rng.below(NIGHTS.len())];
    let (ground, shift) = (ground + 0.03 * rng.signed(), 0.02 * rng.signed());
    let background = [0, 1].map(|end| {
        let [least, most] = GROUND[end];
        let luma = least + (most - least) * rng.unit();
        of_luma(ground + 0.04 * rng.signed(), 0.5 + 0.2 * rng.unit(), luma)
    });
    let first = rng.below(3);
    let palette = (0..3 + rng.below(4)).map(|number| {
        let hue = hues[(first + number) % 3] + shift + 0.02 * rng.signed();
        // Every third is nearly white: ice among the colours.
        let saturation = if number % 3 == 1 { 0.12 } else { 0.35 + 0.35 * rng.unit() };
        Colour::of_hue(hue, saturation, 0.9 + 0.1 * rng.unit())
    });
    (background, palette.collect())
}

/// A colour of a hue that is so bright on a screen.
pub(crate) fn of_luma(hue: f64, saturation: f64, luma: f64) -> Colour {
    let full = Colour::of_hue(hue, saturation, 1.0).luma();
    Colour::of_hue(hue, saturation, (luma / full).min(1.0))
}
