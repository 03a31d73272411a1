//! Loops and transitions.
//!
//! Owns how genes and clocks go on. In a loop the wind alone moves, and the frame number is taken modulo the loop's length
//! before anything else is done with it, so frame F is frame 0. In a transition all is eased by s = 3b^2 - 2b^3, whose
//! speed is 0 at both ends: genes go over into each other where the plants are alike, otherwise one plant withdraws into
//! its seed while the other unfolds. Never draws.
//!
//! Start at [`Loop`] and [`Transition`].
//!
//! # Source
//! Sims, *Artificial Evolution for Computer Graphics* (1991), section 3.3.

use species::{Demand, Drawn, Image, Motion, RenderError, Settings, Threads};

use crate::chance::Chance;
use crate::genes::{GENES, Habit, MANY};
use crate::genome::Plant;
use crate::picture::{demand, picture, sketch};
use crate::stand::Stand;
use crate::vector::between;
use crate::view::View;
use crate::wind::Clock;

/// Genes that differ by less than this on average go over into each other.
const ALIKE: f64 = 0.16;
/// The part of a transition in which a plant withdraws, or unfolds.
const WITHDRAWAL: f64 = 0.9;

/// A plant in the wind.
#[derive(Clone, Debug)]
pub(crate) struct Loop {
    plant: Plant,
    view: View,
    frames: f64,
}

/// The way from one loop to another.
#[derive(Clone, Debug)]
pub(crate) struct Transition {
    loops: [Loop; 2],
    frames: f64,
    is_alike: bool,
}

impl Loop {
    /// The loop of a genome, in `frames` frames (> 0).
    pub(crate) fn new(plant: &Plant, frames: f64) -> Loop {
        let stand = Stand::of(Habit::of(&plant.genes), Chance::of(plant.seed));
        Loop { plant: plant.clone(), view: View { stands: vec![stand], sky: plant.sky }, frames }
    }

    /// A small picture of a frame, without motion blur, by the caller's own thread.
    pub(crate) fn sketch(&self, frame: f64, size: [u32; 2]) -> Image {
        sketch(&self.view, &[self.clock(frame)], size)
    }

    /// Its plants, of which a loop has one stand.
    fn stand(&self) -> &Stand {
        &self.view.stands[0]
    }

    fn speed(&self) -> f64 {
        f64::from(self.plant.turns) / self.frames
    }

    fn clock(&self, frame: f64) -> Clock {
        let turns = f64::from(self.plant.turns) * (frame.rem_euclid(self.frames) / self.frames);
        Clock { turns, turns_per_frame: self.speed() }
    }
}

impl Motion for Loop {
    fn demand(&self, _frame: f64, settings: &Settings) -> Result<Demand, RenderError> {
        demand(settings)
    }

    fn frame(&self, frame: f64, settings: &Settings, threads: &Threads) -> Result<Drawn, RenderError> {
        picture(&self.view, &[self.clock(frame)], settings, threads)
    }
}

impl Transition {
    /// The way from `from` to `to` in `frames` frames (> 0).
    pub(crate) fn new(from: Loop, to: Loop, frames: f64) -> Transition {
        let is_alike = distance(&from.plant.genes, &to.plant.genes) < ALIKE;
        Transition { loops: [from, to], frames, is_alike }
    }

    /// How far it has come, `0.0..=1.0`, and how far as it is eased.
    fn progress(&self, frame: f64) -> [f64; 2] {
        let b = (frame / self.frames).clamp(0.0, 1.0);
        [b, b * b * (3.0 - 2.0 * b)]
    }

    /// A cubic from 0 to whole turns that starts and ends at the loops' speeds.
    fn shared_clock(&self, b: f64) -> Clock {
        let speeds = [0, 1].map(|side| self.loops[side].speed());
        let [first, last] = speeds.map(|speed| speed * self.frames);
        let whole = f64::midpoint(first, last).round();
        let turns =
            whole * (b * b * (3.0 - 2.0 * b)) + first * (b * (b - 1.0) * (b - 1.0)) + last * (b * b * (b - 1.0));
        let slope = whole * (6.0 * b * (1.0 - b)) / self.frames;
        let turns_per_frame = slope + speeds[0] * (1.0 - b * (4.0 - 3.0 * b)) + speeds[1] * (b * (3.0 * b - 2.0));
        Clock { turns, turns_per_frame }
    }

    /// What is seen at a frame, and its clocks.
    fn view(&self, frame: f64) -> (View, Vec<Clock>) {
        let [b, eased] = self.progress(frame);
        let [from, to] = [0, 1].map(|side| &self.loops[side].plant);
        let sky =
            [0, 1].map(|part| [0, 1, 2].map(|channel| between(from.sky[part][channel], to.sky[part][channel], eased)));
        if self.is_alike {
            let chance = Chance::between([from.seed, to.seed], eased);
            let habit = Habit::of(&blended(&from.genes, &to.genes, eased));
            let stands = [0, 1].map(|side| self.loops[side].stand());
            let stand = Stand::between(stands, eased, habit, chance);
            return (View { stands: vec![stand], sky }, vec![self.shared_clock(b)]);
        }
        let sides = [(0, frame, 1.0 - eased), (1, frame - self.frames, eased)];
        let there = sides.into_iter().filter(|(_, _, share)| *share > 1.0 - WITHDRAWAL);
        let mut view = View { stands: Vec::new(), sky };
        let mut clocks = Vec::new();
        for (side, frame, share) in there {
            let part = (share - (1.0 - WITHDRAWAL)) / WITHDRAWAL;
            // Faster near the seed, so that half-way both are more than half there.
            let vigour = if share == 1.0 { 1.0 } else { part * (1.5 - 0.5 * part) };
            let seed = self.loops[side].plant.seed;
            view.stands.push(self.loops[side].stand().withdrawn(Chance::of(seed), vigour, share));
            clocks.push(self.loops[side].clock(frame));
        }
        (view, clocks)
    }
}

impl Motion for Transition {
    fn demand(&self, _frame: f64, settings: &Settings) -> Result<Demand, RenderError> {
        demand(settings)
    }

    fn frame(&self, frame: f64, settings: &Settings, threads: &Threads) -> Result<Drawn, RenderError> {
        // What cannot be drawn is refused before anything grows.
        demand(settings)?;
        let (view, clocks) = self.view(frame);
        picture(&view, &clocks, settings, threads)
    }
}

/// How far two numbers of a gene are apart: hues the shorter way round.
fn step(place: usize, from: f64, to: f64) -> f64 {
    let way = to - from;
    if GENES[place].wraps { way - way.round() } else { way }
}

fn distance(a: &[f64; MANY], b: &[f64; MANY]) -> f64 {
    (0..MANY).map(|place| step(place, a[place], b[place]).abs()).sum::<f64>() / MANY as f64
}

/// The genes `eased` of the way from one plant to another.
pub(crate) fn blended(from: &[f64; MANY], to: &[f64; MANY], eased: f64) -> [f64; MANY] {
    std::array::from_fn(|place| {
        if eased == 1.0 { to[place] } else { from[place] + step(place, from[place], to[place]) * eased }
    })
}
