//! From stands in the wind to shapes on the screen.
//!
//! Owns the light: what is lit, what is in the shade of the crown, what is lost in the haze. Shapes are in pixels and
//! sorted from the back to the front. Never touches a pixel (`raster.rs`).
//!
//! Start at [`View::shapes`].

use species::Capsule;

use crate::colour::{Light, light, mixed, of_hue};
use crate::skeleton::{Bone, Leaf};
use crate::stand::{Foot, Part, Stand};
use crate::vector::{Vector, added, cross, dot, smooth, unit};
use crate::wind::{Clock, Posed};

/// Where the light comes from: left, above, and from the front.
const SUN: Vector = [-0.577_35, 0.659_83, 0.481_13];
/// How much larger what is near is.
const NEARER: f64 = 0.24;
/// The least radius that is drawn, in pixels: what is thinner would come and go between pixels as it moves.
const LEAST: f32 = 0.7;
/// How far a leaf turns when it flutters, of how far a stem bends.
const FLUTTER: f64 = 1.4;

/// All that is seen at a frame, besides the wind.
#[derive(Clone, Debug)]
pub(crate) struct View {
    pub(crate) stands: Vec<Stand>,
    /// The sky above and at the horizon, as a screen shows them.
    pub(crate) sky: [[f64; 3]; 2],
}

/// What a shape is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Form {
    /// A round piece of a branch.
    Branch,
    /// A leaf with the form between a lens, 0, and an ellipse, 1.
    Leaf(f32),
}

/// A shape on the screen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    pub(crate) form: Form,
    /// From the stalk to the tip, with half the width of a leaf as both radii.
    pub(crate) capsule: Capsule,
    /// How much it covers.
    pub(crate) opacity: f32,
    /// Where between its colours its middle is.
    pub(crate) tone: f32,
    pub(crate) dark: Light,
    pub(crate) lit: Light,
}

/// A stand at a moment, with what its shapes need.
struct Seen<'a> {
    stand: &'a Stand,
    posed: Posed,
    feet: Vec<Foot>,
    moment: f64,
    size: [f64; 2],
    haze: Light,
}

impl View {
    /// The shapes while the shutter is open, `shutter` frames from the middle; a clock for each stand.
    pub(crate) fn shapes(&self, clocks: &[Clock], shutter: f64, size: [u32; 2]) -> Vec<Shape> {
        let size = size.map(f64::from);
        let [above, horizon] = self.sky.map(light);
        let haze = mixed(horizon, above, 0.3);
        let seen: Vec<Seen> = self
            .stands
            .iter()
            .zip(clocks)
            .map(|(stand, clock)| {
                let moment = clock.at(shutter);
                let posed = Posed::of(&stand.skeleton, moment);
                Seen { stand, posed, feet: stand.feet(size[0] / size[1]), moment, size, haze }
            })
            .collect();
        let mut places = vec![0; seen.len()];
        let mut shapes = Vec::with_capacity(self.stands.iter().map(|stand| stand.order.len()).sum());
        // The stands are sorted each; the one whose next part is the furthest goes first.
        loop {
            let nexts = seen
                .iter()
                .enumerate()
                .filter_map(|(number, seen)| Some((number, seen.stand.order.get(places[number])?)));
            let Some((number, (_, part))) = nexts.min_by(|(_, a), (_, b)| a.0.total_cmp(&b.0)) else { break };
            places[number] += 1;
            shapes.push(match part {
                Part::Bone(bone) => seen[number].branch(*bone),
                Part::Leaf(leaf) => seen[number].leaf(*leaf),
            });
        }
        shapes
    }
}

impl Seen<'_> {
    /// A place of the skeleton on the screen, and the pixels of its unit there.
    fn on_screen(&self, place: Vector, stem: u8) -> ([f32; 2], f64) {
        let foot = &self.feet[stem as usize];
        let nearer = 1.0 + NEARER * (place[2] * foot.scale).clamp(-1.5, 1.5);
        let [x, y] = [foot.x + place[0] * foot.scale, foot.y + place[1] * foot.scale];
        let middle = 0.4;
        let [width, height] = self.size;
        let column = 0.5 * width + height * x * nearer;
        let row = height * (1.0 - (middle + (y - middle) * nearer));
        ([column as f32, row as f32], height * foot.scale * nearer)
    }

    /// How much light reaches a place within its crown, `0.0..=1.0`, and how much of it there is lost in haze.
    fn reached(&self, place: Vector, stem: u8) -> (f64, f64) {
        let crown = self.stand.skeleton.crowns[stem as usize];
        let bounds = self.stand.skeleton.boxes[stem as usize];
        let radius = 0.25 * (bounds[2] - bounds[0] + bounds[3] - crown[1].min(bounds[3] - 0.1)) + 0.05;
        let out = added(place, crown, -1.0);
        let far = dot(out, out).sqrt() / radius;
        let towards = dot(out, SUN) / (radius * (0.6 + far));
        let open = 0.28 + 0.72 * smooth(0.25 + 0.6 * far);
        let lit = (0.5 + 0.55 * towards).clamp(0.0, 1.0) * open;
        let behind = smooth(0.5 - 0.6 * place[2] / radius.max(0.1));
        (lit, (Stand::haze(stem) + 0.2 * behind).min(0.9))
    }

    fn branch(&self, number: u32) -> Shape {
        let bone: &Bone = &self.stand.skeleton.bones[number as usize];
        let ends = self.posed.bones[number as usize].ends;
        let [(from, unit), (to, _)] = ends.map(|end| self.on_screen(end, bone.stem));
        let habit = &self.stand.habit;
        let (reached, haze) = self.reached(bone.start, bone.stem);
        // Bark is brown with a touch of the leaves, young shoots have more of it.
        let young = bone.youth * bone.youth;
        let bark = |lightness: f64, chroma: f64| {
            let brown = of_hue(lightness, chroma, 0.16);
            let green = of_hue(lightness + 0.08, 0.03 + chroma, habit.hue);
            mixed(mixed(brown, green, (0.12 + 0.6 * young) as f32), self.haze, haze as f32)
        };
        let thin = bone.radii.map(|radius| (radius * unit) as f32);
        let radii = thin.map(|radius| radius.max(LEAST));
        Shape {
            form: Form::Branch,
            capsule: Capsule { ends: [from, to], radii },
            // What is thinner than a pixel is drawn as wide as one, and fainter.
            opacity: (thin[0] + thin[1]) / (radii[0] + radii[1]),
            tone: (0.12 + 0.75 * reached) as f32,
            dark: bark(0.17, 0.022),
            lit: bark(0.66, 0.05),
        }
    }

    fn leaf(&self, number: u32) -> Shape {
        let leaf: &Leaf = &self.stand.skeleton.leaves[number as usize];
        let habit = &self.stand.habit;
        let flutter = FLUTTER * habit.sway;
        let [stalk, direction, normal] = self.posed.leaf(&self.stand.skeleton, number as usize, self.moment, flutter);
        let (from, unit_px) = self.on_screen(stalk, leaf.stem);
        let (to, _) = self.on_screen(added(stalk, direction, leaf.length), leaf.stem);
        let side = unit(cross(direction, normal), [1.0, 0.0, 0.0]);
        // The width as it is seen across the leaf on the screen.
        let flat = unit([direction[0], direction[1], 0.0], [1.0, 0.0, 0.0]);
        let facing = (side[0] * flat[1] - side[1] * flat[0]).abs();
        let half = leaf.length * leaf.width * (0.3 + 0.7 * facing) * unit_px;
        let wide = half.max(f64::from(LEAST));
        let seen = (direction[0] * direction[0] + direction[1] * direction[1]).sqrt();
        let (reached, haze) = self.reached(leaf.start, leaf.stem);
        let lambert = dot(normal, SUN);
        // Light falls on one side, and shines through from the other.
        let shine = if lambert > 0.0 { lambert } else { -0.55 * lambert };
        let tone = 0.08 + 0.92 * reached * (0.35 + 0.65 * shine);
        let high = (leaf.start[1] * 0.9).clamp(0.0, 1.2);
        let hue = habit.hue + habit.hue_range * (0.75 * leaf.age + 0.5 * high - 0.35 + 0.3 * leaf.own);
        let colour = |lightness: f64, chroma: f64, towards: f64| {
            mixed(of_hue(lightness + 0.03 * leaf.own, chroma, hue + towards), self.haze, haze as f32)
        };
        Shape {
            form: Form::Leaf(smooth((habit.leaf_shape - 0.2) / 0.6) as f32),
            capsule: Capsule { ends: [from, to], radii: [wide as f32; 2] },
            opacity: (smooth(seen * 4.0) * half / wide) as f32,
            tone: tone as f32,
            dark: colour(0.2, 0.07, 0.03),
            lit: colour(0.84, 0.14, -0.025),
        }
    }
}
