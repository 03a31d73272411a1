//! Shapes into pixels.
//!
//! Owns how much of a pixel a shape covers, by its distance from the edge, and which of its colours is there. Works on one
//! band of rows at a time. Never knows what a shape means.
//!
//! Start at [`Band::draw`].

use crate::view::{Form, Shape};

/// Pixels from the inside of a leaf to its outside.
const RAMP: f32 = 1.25;

/// Rows of linear light: `[rows][width][3]`.
#[derive(Debug)]
pub(crate) struct Band<'a> {
    /// The first of its rows in the picture.
    pub(crate) top: usize,
    pub(crate) width: usize,
    pub(crate) pixels: &'a mut [[f32; 3]],
}

/// What of a shape is the same for all its pixels.
struct Inked<'a> {
    shape: &'a Shape,
    /// The direction from the start to the end, and the distance.
    along: [f32; 2],
    length: f32,
    /// How strongly the sides of a branch differ: how far across it the light comes from.
    lit_side: f32,
    /// How much of a leaf's veins is seen, for it must be large enough.
    veins: f32,
}

impl Band<'_> {
    /// Draws a shape over what is there.
    pub(crate) fn draw(&mut self, shape: &Shape) {
        let [[left, top], [right, bottom]] = shape.capsule.bounds(1.0);
        let rows = self.pixels.len() / self.width;
        let (first, last) = (self.top as f32, (self.top + rows) as f32);
        if bottom < first || top > last || right < 0.0 || left > self.width as f32 {
            return;
        }
        let inked = Inked::of(shape);
        // A float as a whole number is cut to its range.
        let columns = (left.max(0.0) as usize)..((right + 1.0).max(0.0) as usize).min(self.width);
        for row in ((top - first).max(0.0) as usize)..((bottom - first + 1.0).max(0.0) as usize).min(rows) {
            let y = (self.top + row) as f32 + 0.5;
            let line = &mut self.pixels[row * self.width..][..self.width];
            for (column, pixel) in line.iter_mut().enumerate().take(columns.end).skip(columns.start) {
                let (covers, tone) = inked.at([column as f32 + 0.5, y]);
                if covers > 0.0 {
                    for (channel, light) in pixel.iter_mut().enumerate() {
                        let (dark, lit) = (shape.dark[channel], shape.lit[channel]);
                        *light += (dark + (lit - dark) * tone - *light) * covers;
                    }
                }
            }
        }
    }
}

impl Inked<'_> {
    fn of(shape: &Shape) -> Inked<'_> {
        let [from, to] = shape.capsule.ends;
        let way = [to[0] - from[0], to[1] - from[1]];
        let length = (way[0] * way[0] + way[1] * way[1]).sqrt();
        let along = if length > 1e-6 { way.map(|part| part / length) } else { [0.0, -1.0] };
        let radius = shape.capsule.radii[0];
        Inked {
            shape,
            along,
            length: length.max(1e-6),
            // The light comes from the left and from above.
            lit_side: -0.66 * -along[1] - 0.75 * along[0],
            veins: ((radius - 1.2) / 4.0).clamp(0.0, 1.0),
        }
    }

    /// How much is covered, and the tone there.
    #[inline]
    fn at(&self, point: [f32; 2]) -> (f32, f32) {
        let from = self.shape.capsule.ends[0];
        let there = [point[0] - from[0], point[1] - from[1]];
        let along = there[0] * self.along[0] + there[1] * self.along[1];
        // To the right of the way, on a screen whose rows go down.
        let across = there[1] * self.along[0] - there[0] * self.along[1];
        match self.shape.form {
            Form::Branch => {
                let covers = self.shape.capsule.coverage(point) * self.shape.opacity;
                if covers <= 0.0 { (0.0, 0.0) } else { (covers, self.bark(along, across)) }
            }
            Form::Leaf(roundness) => self.blade(along / self.length, across, roundness),
        }
    }

    /// Round: the side towards the light is lit, and a little light comes around the other.
    fn bark(&self, along: f32, across: f32) -> f32 {
        let [first, last] = self.shape.capsule.radii;
        let radius = first + (last - first) * (along / self.length).clamp(0.0, 1.0);
        let side = (across / radius.max(0.5)).clamp(-1.0, 1.0);
        let front = (1.0 - side * side).max(0.0).sqrt();
        let light = (0.62 * front + 0.68 * side * self.lit_side).max(0.0) + 0.16 * side * side;
        // Thin twigs have no sides.
        let thick = ((radius - 0.5) / 2.0).clamp(0.0, 1.0);
        (self.shape.tone * (0.62 + (light - 0.62) * thick) * 1.25).clamp(0.0, 1.0)
    }

    fn blade(&self, part: f32, across: f32, roundness: f32) -> (f32, f32) {
        if !(0.0..=1.0).contains(&part) {
            return (0.0, 0.0);
        }
        let lens = 4.0 * part * (1.0 - part);
        // The widest place is nearer to the stalk.
        let skewed = lens * (1.22 - 0.44 * part);
        let wide = self.shape.capsule.radii[0];
        let half = wide * (skewed + (lens.sqrt() - skewed) * roundness);
        let slope = wide * (4.0 - 8.0 * part) / self.length;
        let edge = (half - across.abs()) / (1.0 + slope * slope).sqrt() / RAMP + 0.5;
        // Its ends are edges too.
        let ends = (part * self.length / RAMP).min(1.0) * ((1.0 - part) * self.length / RAMP).min(1.0);
        let covers = edge.clamp(0.0, 1.0).min(2.0 * half) * ends * self.shape.opacity;
        if covers <= 0.0 {
            return (0.0, 0.0);
        }
        let side = (across / half.max(0.3)).clamp(-1.0, 1.0);
        // Its halves are folded along the middle, so that one of them is lighter.
        let fold = (across * 1.5).clamp(-1.0, 1.0) * self.lit_side;
        let rib = (1.0 - across.abs() / (0.09 * wide).max(0.7)).max(0.0);
        let waves = part * 7.0 - side.abs() * 1.6;
        let vein = (1.0 - ((waves - waves.floor()) * 2.0 - 1.0).abs() * 5.0).max(0.0) * (1.0 - side.abs());
        let rim = side * side * side * side;
        let tone = self.shape.tone * (0.78 + 0.34 * part + 0.13 * fold + 0.08 * rim)
            + self.veins * (0.2 * rib + 0.06 * vein) * (0.3 + self.shape.tone);
        (covers, tone.clamp(0.0, 1.0))
    }
}
