//! From bodies to strokes in pixels.
//!
//! Owns how large, how wide, how bright and how sharp a body is, and where it wraps from the bottom to the top. Never adds
//! light: `raster.rs` does.
//!
//! Start at [`Sprites::of`].

use std::f64::consts::TAU;
use std::ops::Range;

use species::Capsule;

use crate::motion::{Body, Scene, nearness};
use crate::shape::{Middle, Shape};
use crate::turtle::{Stroke, WALK_BYTES, walk};

/// Where the light comes from that strokes glint in.
const LIGHT: [f64; 2] = [0.5, -0.866];
/// A line's least and greatest radius, in heights of the picture, and in lengths of a step between them.
const RADII: [f64; 2] = [0.0011, 0.0036];
const OF_STEP: f64 = 0.17;

/// How wide an edge is at least, in pixels: narrower ones flicker as they fall. In small pictures lines are thinner than
/// pixels, and need more: so much in one that is a pixel high.
const SOFTEST: [f64; 2] = [2.0, 185.0];

/// A stroke in pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Streak {
    pub(crate) capsule: Capsule,
    pub(crate) light: f32,
}

/// A body in pixels.
#[derive(Clone, Debug)]
pub(crate) struct Sprite {
    /// Its streaks.
    pub(crate) streaks: Range<usize>,
    /// Where its copies are: pixels down.
    pub(crate) copies: [Option<f32>; 3],
    /// How wide the edge of a line is in pixels.
    pub(crate) soft: f32,
    pub(crate) centre: [f32; 2],
    pub(crate) reach: f32,
    /// Linear light of its middle and its tips.
    pub(crate) light: [[f32; 3]; 2],
    /// All pixels that it touches: left, top, right and bottom.
    bounds: [f32; 4],
}

/// All that is drawn at a moment.
pub(crate) struct Sprites {
    size: [u32; 2],
    pub(crate) streaks: Vec<Streak>,
    pub(crate) bodies: Vec<Sprite>,
    strokes: Vec<Stroke>,
}

/// Columns and rows of pixels.
pub(crate) type Cells = [Range<usize>; 2];

impl Sprites {
    /// Room for what is in `scene`.
    pub(crate) fn room(scene: &Scene, size: [u32; 2]) -> Sprites {
        let [streaks, strokes] = room(scene);
        Sprites {
            size,
            streaks: Vec::with_capacity(streaks),
            bodies: Vec::with_capacity(scene.bodies.len()),
            strokes: Vec::with_capacity(strokes),
        }
    }

    /// Bytes that it takes for `scene`.
    pub(crate) fn bytes(scene: &Scene) -> u64 {
        let [streaks, strokes] = room(scene);
        let sprites = scene.bodies.len();
        let bytes = streaks * size_of::<Streak>() + strokes * size_of::<Stroke>() + sprites * size_of::<Sprite>();
        bytes as u64 + WALK_BYTES
    }

    /// Takes in another moment.
    pub(crate) fn fill(&mut self, scene: &Scene) {
        self.streaks.clear();
        self.bodies.clear();
        for body in &scene.bodies {
            let first = self.streaks.len();
            let mut sprite = match body.shape {
                Some(shape) => self.agent(body, shape),
                None => self.mote(body),
            };
            sprite.streaks = first..self.streaks.len();
            let margin = sprite.soft + 0.5;
            for streak in &self.streaks[first..] {
                let [low, high] = streak.capsule.bounds(margin);
                let [left, top, right, bottom] = sprite.bounds;
                sprite.bounds = [left.min(low[0]), top.min(low[1]), right.max(high[0]), bottom.max(high[1])];
            }
            let [width, height] = self.size.map(|side| side as f32);
            let period = height * (1.0 + 2.0 * body.margin as f32);
            let [left, top, right, bottom] = sprite.bounds;
            let is_seen = |down: &f32| left < width && right > 0.0 && top + down < height && bottom + down > 0.0;
            sprite.copies = [-period, 0.0, period].map(|down| Some(down).filter(is_seen));
            if sprite.copies == [None; 3] {
                self.streaks.truncate(first);
            } else {
                self.bodies.push(sprite);
            }
        }
    }

    /// The middle of a body in pixels.
    fn centre(&self, body: &Body) -> [f64; 2] {
        let [width, height] = self.size.map(f64::from);
        let down = body.place.fallen.rem_euclid(1.0) * (1.0 + 2.0 * body.margin) - body.margin;
        [body.place.x * width, down * height]
    }

    fn agent(&mut self, body: &Body, shape: &Shape) -> Sprite {
        let height = f64::from(self.size[1]);
        let strokes = &mut self.strokes;
        strokes.clear();
        walk(&shape.agent, body.degrees, |stroke| strokes.push(stroke));
        let middle = Middle::of(strokes);
        let near = nearness(body.depth);
        let reach = 0.5 * shape.size * height * near * body.grown;
        // While it sways, an agent is as large as at rest; what folds up altogether does not explode.
        let spread = (middle.spread * middle.spread + 0.01 * shape.spread * shape.spread).sqrt();
        let step = reach / shape.reach * (1.01_f64.sqrt() * shape.spread / spread);
        let [thin, thick] = RADII.map(|radius| radius * height * near.sqrt() * body.grown);
        let radius = shape.agent.w * (OF_STEP * step).clamp(thin, thick.max(thin));
        let centre = self.centre(body);
        let (sine, cosine) = libm::sincos(TAU * body.place.turned);
        let placed = |point: [f64; 2]| {
            let [x, y] = [0, 1].map(|axis| (point[axis] - middle.at[axis]) * step);
            [(centre[0] + x * cosine - y * sine) as f32, (centre[1] + x * sine + y * cosine) as f32]
        };
        for stroke in &self.strokes {
            let [x, y] = [0, 1].map(|axis| stroke.to[axis] - stroke.from[axis]);
            let glint = LIGHT[0] * (x * cosine - y * sine) + LIGHT[1] * (x * sine + y * cosine);
            let slender = (1.0 - 0.12 * stroke.depth.min(5) as f64) * radius;
            let capsule = Capsule { ends: [placed(stroke.from), placed(stroke.to)], radii: [slender as f32; 2] };
            self.streaks.push(Streak { capsule, light: (0.55 + 0.75 * glint * glint) as f32 });
        }
        let blur = 9.0 * (0.5 - body.depth).max(0.0).powi(2) + 400.0 * (body.depth - 0.88).max(0.0).powi(2);
        self.sprite(body, centre, reach.max(1e-3), 1.0 + blur, 0.12 + 0.88 * body.depth * body.depth.sqrt())
    }

    fn mote(&mut self, body: &Body) -> Sprite {
        let height = f64::from(self.size[1]);
        let centre = self.centre(body);
        // Near motes are large discs out of focus, and as much dimmer.
        let close = body.depth * body.depth * body.depth;
        let radius = (0.0010 + 0.0075 * close) * height * body.grown;
        let at = centre.map(|part| part as f32);
        self.streaks.push(Streak { capsule: Capsule { ends: [at; 2], radii: [radius as f32; 2] }, light: 1.0 });
        self.sprite(
            body,
            centre,
            radius.max(1e-3),
            1.0 + 5.0 * close,
            (0.12 + 0.45 * body.depth) * (1.0 - 0.88 * close),
        )
    }

    /// A sprite without streaks yet. `soft` is in pixels of a picture that is 720 high.
    fn sprite(&self, body: &Body, centre: [f64; 2], reach: f64, soft: f64, bright: f64) -> Sprite {
        let scale = f64::from(self.size[1]) / 720.0;
        Sprite {
            streaks: 0..0,
            copies: [None; 3],
            soft: (soft * scale).max(SOFTEST[0] + (SOFTEST[1] / f64::from(self.size[1])).min(4.0)) as f32,
            centre: centre.map(|part| part as f32),
            reach: reach as f32,
            light: body.light.map(|light| light.map(|light| light * bright as f32)),
            bounds: [f32::MAX, f32::MAX, f32::MIN, f32::MIN],
        }
    }

    /// How often a streak is evaluated for this moment.
    pub(crate) fn evaluations(&self) -> u64 {
        let screen = [0..self.size[0] as usize, 0..self.size[1] as usize];
        let area = |[columns, rows]: Cells| (columns.len() * rows.len()) as u64;
        let of_copy = |sprite: &Sprite, down: f32| -> u64 {
            self.streaks[sprite.streaks.clone()].iter().map(|streak| area(streak.cells(sprite, down, &screen))).sum()
        };
        let of_sprite =
            |sprite: &Sprite| -> u64 { sprite.copies.into_iter().flatten().map(|down| of_copy(sprite, down)).sum() };
        self.bodies.iter().map(of_sprite).sum()
    }
}

impl Streak {
    /// The cells of `screen` that it may touch in the copy that is `down` pixels down.
    pub(crate) fn cells(&self, sprite: &Sprite, down: f32, screen: &Cells) -> Cells {
        let [low, high] = self.capsule.bounds(sprite.soft + 0.5);
        clipped([low[0], low[1] + down, high[0], high[1] + down], screen)
    }
}

impl Sprite {
    /// The cells of `screen` that its copy may touch.
    pub(crate) fn cells(&self, down: f32, screen: &Cells) -> Cells {
        let [left, top, right, bottom] = self.bounds;
        clipped([left, top + down, right, bottom + down], screen)
    }
}

fn clipped([left, top, right, bottom]: [f32; 4], screen: &Cells) -> Cells {
    let range = |low: f32, high: f32, range: &Range<usize>| {
        let low = (low.floor() as usize).clamp(range.start, range.end);
        let high = (high.ceil() as usize).min(range.end);
        low..high.max(low)
    };
    [range(left, right, &screen[0]), range(top, bottom, &screen[1])]
}

/// Most streaks and most strokes of an agent.
fn room(scene: &Scene) -> [usize; 2] {
    let strokes = || scene.bodies.iter().map(|body| body.shape.map_or(1, |shape| shape.strokes));
    [strokes().sum(), strokes().max().unwrap_or(0)]
}
