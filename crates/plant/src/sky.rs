//! The sky behind plants, and the haze over the ground before them.
//!
//! Owns the light of every pixel in which nothing grows. Pure arithmetic.
//!
//! Start at [`Sky::at`].

use crate::colour::{Light, light, mixed};

/// Where the glow of the sun is, in heights of the picture: from the middle, and from above.
const GLOW: [f32; 2] = [-0.46, 0.4];
/// How far the glow reaches, in heights of the picture.
const REACH: f32 = 1.25;

/// A sky over the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sky {
    above: Light,
    horizon: Light,
    size: [f32; 2],
}

impl Sky {
    pub(crate) fn new([above, horizon]: [[f64; 3]; 2], size: [u32; 2]) -> Sky {
        Sky { above: light(above), horizon: light(horizon), size: size.map(|side| side as f32) }
    }

    /// The sky at a pixel.
    pub(crate) fn at(&self, column: usize, row: usize) -> Light {
        let [x, y] = self.place(column, row);
        let high = smooth((y + 0.12) / 0.95);
        let sky = mixed(self.above, self.horizon, high);
        let glow = {
            let (right, down) = (x - GLOW[0], y - GLOW[1]);
            let near = (1.0 - (right * right + down * down) / (REACH * REACH)).max(0.0);
            near * near * near
        };
        // Light of the horizon, a little whiter.
        let warm = self.horizon.map(|light| 0.94 * light + 0.05);
        [0, 1, 2].map(|channel| sky[channel] + 0.5 * glow * warm[channel])
    }

    /// What is seen of a pixel's light through the haze over the ground, in a picture whose corners are a little darker.
    pub(crate) fn through(&self, seen: Light, column: usize, row: usize) -> Light {
        let [x, y] = self.place(column, row);
        let ground = mixed(self.horizon, self.above, 0.45).map(|light| 0.72 * light);
        let hazy = mixed(seen, ground, 0.55 * smooth((y - 0.74) / 0.3));
        let aspect = self.size[0] / self.size[1];
        let (right, down) = (2.0 * x / aspect, 2.0 * y - 1.0);
        let far = 0.55 * right * right + 0.45 * down * down;
        hazy.map(|light| light * (1.0 - 0.24 * far * far))
    }

    /// In heights of the picture: from the middle to the right, from above down.
    fn place(&self, column: usize, row: usize) -> [f32; 2] {
        let [width, height] = self.size;
        [(column as f32 + 0.5 - 0.5 * width) / height, (row as f32 + 0.5) / height]
    }
}

fn smooth(part: f32) -> f32 {
    let part = part.clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}
