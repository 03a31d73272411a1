//! Loops and transitions.
//!
//! Owns what is in the globe at a moment: bodies with places, sizes and colours. A frame number is taken modulo the loop's
//! length before anything else is done with it, so frame F is frame 0. Never draws.
//!
//! Start at [`Turning`] and [`Transition`].

use std::f64::consts::TAU;

use crate::colour::{Colour, mixed};
use crate::globe::Globe;
use crate::path::{Kind, Path, Place, apart, cubic, unwound};
use crate::shape::Shape;

/// How bright a line is that nothing makes darker.
const BRIGHTNESS: f32 = 2.1;
/// During which part of a transition the first globe's agents shrink, and the other's grow: in the middle both are large.
const SHRINKS: [f64; 2] = [0.3, 0.9];
const GROWS: [f64; 2] = [0.1, 0.7];

/// Everything that is seen at a moment.
#[derive(Debug)]
pub(crate) struct Scene<'g> {
    /// Linear light of top and bottom.
    pub(crate) background: [[f32; 3]; 2],
    pub(crate) glow: f32,
    pub(crate) bodies: Vec<Body<'g>>,
}

/// An agent or a mote.
#[derive(Debug)]
pub(crate) struct Body<'g> {
    /// None: a mote.
    pub(crate) shape: Option<&'g Shape>,
    /// Degrees of a turn of its string.
    pub(crate) degrees: f64,
    pub(crate) place: Place,
    /// How far above and below the picture it goes, in heights.
    pub(crate) margin: f64,
    /// 0 is far, 1 near.
    pub(crate) depth: f64,
    /// How much of it is grown.
    pub(crate) grown: f64,
    /// Linear light of its middle and its tips.
    pub(crate) light: [[f32; 3]; 2],
}

/// What has bodies at every frame.
pub(crate) trait Course: Send + Sync {
    /// The frame that is meant by `frame`, before the shutter opens.
    fn wrapped(&self, frame: f64) -> f64;
    /// What is seen `shutter` frames from the wrapped `frame`.
    fn scene(&self, frame: f64, shutter: f64) -> Scene<'_>;
}

/// A globe that turns.
#[derive(Clone, Debug)]
pub(crate) struct Turning {
    globe: Globe,
    agents: Vec<Path>,
    dust: Vec<Path>,
    frames: f64,
}

impl Turning {
    pub(crate) fn new(globe: &Globe, frames: f64) -> Turning {
        let paths = |kind, many| {
            let starts = apart(globe.drift, kind, many).into_iter().enumerate();
            starts.map(|(number, start)| Path::of(globe.drift, kind, number, start)).collect()
        };
        let (agents, dust) = (paths(Kind::Agent, globe.shapes.len()), paths(Kind::Mote, globe.dust as usize));
        Turning { globe: globe.clone(), agents, dust, frames }
    }

    /// Agent `number` at `phase`, at `place`.
    fn agent(&self, number: usize, phase: f64, place: Place, grown: f64) -> Body<'_> {
        let shape = &self.globe.shapes[number];
        let degrees = shape.agent.v + shape.agent.sw * libm::sin(TAU * phase);
        let depth = self.agents[number].depth;
        let light = self.globe.colours(number).map(|light| light.map(|light| light * BRIGHTNESS));
        Body { shape: Some(shape), degrees, place, margin: self.margin(number), depth, grown, light }
    }

    fn margin(&self, number: usize) -> f64 {
        0.65 * self.globe.shapes[number].size * nearness(self.agents[number].depth) + 0.02
    }

    /// All motes at `phase`.
    fn dust(&self, phase: f64, grown: f64) -> impl Iterator<Item = Body<'_>> {
        self.dust.iter().enumerate().map(move |(number, path)| {
            let light = self.globe.palette[number % self.globe.palette.len()].light();
            let light = [mixed(light, [1.0; 3], 0.35); 2];
            Body { shape: None, degrees: 0.0, place: path.at(phase), margin: 0.03, depth: path.depth, grown, light }
        })
    }

    /// All agents from `first` on, each on its own path.
    fn agents(&self, first: usize, phase: f64, grown: f64) -> impl Iterator<Item = Body<'_>> {
        let paths = self.agents.iter().enumerate().skip(first);
        paths.map(move |(number, path)| self.agent(number, phase, path.at(phase), grown))
    }

    fn background(&self) -> [[f32; 3]; 2] {
        self.globe.background.map(Colour::light)
    }
}

impl Course for Turning {
    fn wrapped(&self, frame: f64) -> f64 {
        frame.rem_euclid(self.frames)
    }

    fn scene(&self, frame: f64, shutter: f64) -> Scene<'_> {
        let phase = (frame + shutter) / self.frames;
        let bodies = self.dust(phase, 1.0).chain(self.agents(0, phase, 1.0)).collect();
        Scene { background: self.background(), glow: self.globe.glow as f32, bodies }
    }
}

/// From one loop to another.
#[derive(Clone, Debug)]
pub(crate) struct Transition {
    from: Turning,
    to: Turning,
    frames: f64,
}

impl Transition {
    pub(crate) fn new(from: Turning, to: Turning, frames: f64) -> Transition {
        Transition { from, to, frames }
    }

    /// The way that agent `number` of both globes takes together. Agents are paired by number and not by place: both globes
    /// spread theirs over the whole picture, a cubic joins any two places evenly, and clips that are rendered keep their
    /// pictures.
    fn joined(&self, number: usize, part: f64) -> Place {
        let sides = [&self.from, &self.to].map(|side| {
            let (path, turns) = (&side.agents[number], self.frames / side.frames);
            let speed = path.speed(0.0);
            (path.at(0.0), [speed.x, speed.fallen, speed.turned].map(|speed| speed * turns))
        });
        let [(from, away), (to, home)] = sides;
        let speeds = |axis: usize| [away[axis], home[axis]];
        // Snow may wait for its partner, but does not rise.
        let fallen = unwound([from.fallen, to.fallen], speeds(1), 0.2);
        let turned = unwound([from.turned, to.turned], speeds(2), 0.0);
        Place {
            x: cubic([from.x, to.x], speeds(0), part),
            fallen: cubic([from.fallen, fallen], speeds(1), part),
            turned: cubic([from.turned, turned], speeds(2), part),
        }
    }
}

impl Course for Transition {
    fn wrapped(&self, frame: f64) -> f64 {
        frame
    }

    fn scene(&self, frame: f64, shutter: f64) -> Scene<'_> {
        // The ends are frames of the loops, and so is all around them.
        if frame <= 0.0 || frame + shutter <= 0.0 {
            return self.from.scene(self.from.wrapped(frame), shutter);
        }
        if frame >= self.frames || frame + shutter >= self.frames {
            return self.to.scene(self.to.wrapped(frame - self.frames), shutter);
        }
        let part = (frame + shutter) / self.frames;
        let grown = [1.0 - eased(part, SHRINKS), eased(part, GROWS)];
        let phases = [(frame + shutter) / self.from.frames, (frame + shutter - self.frames) / self.to.frames];
        let share = (part * part * (3.0 - 2.0 * part)) as f32;
        let together = self.from.agents.len().min(self.to.agents.len());
        let mut bodies = Vec::with_capacity(2 * together + self.from.dust.len() + self.to.dust.len());
        let sides = [&self.from, &self.to];
        for ((side, phase), grown) in sides.into_iter().zip(phases).zip(grown) {
            bodies.extend(side.dust(phase, grown));
            for number in 0..together {
                let lights = sides.map(|side| side.agent(number, 0.0, side.agents[number].at(0.0), 1.0).light);
                let light = [0, 1].map(|end| mixed(lights[0][end], lights[1][end], share));
                let body = side.agent(number, phase, self.joined(number, part), grown);
                let margins = sides.map(|side| side.margin(number));
                bodies.push(Body { light, margin: margins[0] + (margins[1] - margins[0]) * f64::from(share), ..body });
            }
            bodies.extend(side.agents(together, phase, grown));
        }
        let (from, to) = (self.from.background(), self.to.background());
        Scene {
            background: [0, 1].map(|end| mixed(from[end], to[end], share)),
            glow: (self.from.globe.glow + (self.to.globe.glow - self.from.globe.glow) * f64::from(share)) as f32,
            bodies,
        }
    }
}

/// From 0 to 1 between two moments, flat at both.
fn eased(part: f64, [from, to]: [f64; 2]) -> f64 {
    let part = ((part - from) / (to - from)).clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}

/// How large something looks at a depth, of what it is at the front.
pub(crate) fn nearness(depth: f64) -> f64 {
    0.32 + 0.68 * depth
}
