//! How a picture is composed, in figures by which sheep are compared.
//!
//! Owns the figures of one picture that say nothing of its quality. Never judges.
//!
//! Start at [`Composition::of`].

use super::BLACK;
use crate::image::Image;
use crate::luma::spread;

const HUES: usize = 12;
const LUMAS: usize = 32;
/// What Sobel's masks find at a step of a fifth of the range of luma.
const STRONG_EDGE: f64 = 0.8;
/// The sides of boxes, in pixels.
const BOXES: [usize; 6] = [1, 2, 4, 8, 16, 32];

/// The figures; see those of [`super::Figures`] with the same names.
#[derive(Debug, Default)]
pub(super) struct Composition {
    pub(super) hue_entropy: f64,
    pub(super) luma_entropy: f64,
    pub(super) edges: f64,
    pub(super) dimension: f64,
    pub(super) compressed: f64,
    pub(super) symmetry: f64,
    pub(super) offset: f64,
}

impl Composition {
    /// The figures of a picture with these lumas.
    pub(super) fn of(image: &Image, lumas: &[f64]) -> Composition {
        let plane = Plane { width: image.width, height: image.height, lumas };
        Composition {
            hue_entropy: hue_entropy(image),
            luma_entropy: luma_entropy(lumas),
            edges: plane.edges(),
            dimension: plane.dimension(),
            compressed: compressed(image),
            symmetry: plane.symmetry(),
            offset: plane.offset(),
        }
    }

    /// Adds those of another picture.
    pub(super) fn add(&mut self, other: &Composition) {
        self.hue_entropy += other.hue_entropy;
        self.luma_entropy += other.luma_entropy;
        self.edges += other.edges;
        self.dimension += other.dimension;
        self.compressed += other.compressed;
        self.symmetry += other.symmetry;
        self.offset += other.offset;
    }
}

/// The entropy of bins as a part of the largest that so many can have.
fn entropy(bins: &[f64]) -> f64 {
    let sum: f64 = bins.iter().sum();
    let bits = |bin: &f64| if *bin > 0.0 { bin / sum * libm::log(sum / bin) } else { 0.0 };
    bins.iter().map(bits).sum::<f64>() / libm::log(bins.len() as f64)
}

fn hue_entropy(image: &Image) -> f64 {
    let mut bins = [0.0; HUES];
    for [red, green, blue] in image.pixels.iter().map(|pixel| pixel.map(f64::from)) {
        let most = red.max(green).max(blue);
        let chroma = most - red.min(green).min(blue);
        if chroma <= 0.0 {
            continue;
        }
        // The hue in sixths of a turn.
        let sixths = if red >= most {
            (green - blue) / chroma + 6.0
        } else if green >= most {
            (blue - red) / chroma + 2.0
        } else {
            (red - green) / chroma + 4.0
        };
        bins[(sixths / 6.0 * HUES as f64) as usize % HUES] += chroma;
    }
    entropy(&bins)
}

fn luma_entropy(lumas: &[f64]) -> f64 {
    let mut bins = [0.0; LUMAS];
    for luma in lumas {
        bins[((luma * LUMAS as f64) as usize).min(LUMAS - 1)] += 1.0;
    }
    entropy(&bins)
}

/// Bytes of the picture as a PNG per byte of its pixels; 1 if it cannot be written, which no picture in memory is known for.
fn compressed(image: &Image) -> f64 {
    let byte = |light: &f32| (light.clamp(0.0, 1.0) * 255.0).round() as u8;
    let pixels: Vec<u8> = image.pixels.iter().flatten().map(byte).collect();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, image.width as u32, image.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&pixels));
    if written.is_ok() { file.len() as f64 / pixels.len().max(1) as f64 } else { 1.0 }
}

/// The lumas of a picture, row by row.
struct Plane<'a> {
    width: usize,
    height: usize,
    lumas: &'a [f64],
}

impl Plane<'_> {
    fn at(&self, x: usize, y: usize) -> f64 {
        self.lumas[y * self.width + x]
    }

    /// The part of pixels with eight neighbours at which both of Sobel's masks together find a strong edge.
    fn edges(&self) -> f64 {
        let (mut strong, mut count) = (0.0, 0.0_f64);
        for y in 1..self.height.saturating_sub(1) {
            for x in 1..self.width.saturating_sub(1) {
                let column = |x: usize| self.at(x, y - 1) + 2.0 * self.at(x, y) + self.at(x, y + 1);
                let row = |y: usize| self.at(x - 1, y) + 2.0 * self.at(x, y) + self.at(x + 1, y);
                let [across, down] = [column(x + 1) - column(x - 1), row(y + 1) - row(y - 1)];
                strong += f64::from(u8::from((across * across + down * down).sqrt() > STRONG_EDGE));
                count += 1.0;
            }
        }
        strong / count.max(1.0)
    }

    /// The slope of the number of boxes with something in them over their size, both as logarithms: a line through all sizes.
    fn dimension(&self) -> f64 {
        let mut lit: Vec<f64> = self.lumas.iter().copied().filter(|luma| *luma >= BLACK).collect();
        if lit.is_empty() {
            return 0.0;
        }
        let middle = lit.len() / 2;
        let median = *lit.select_nth_unstable_by(middle, f64::total_cmp).1;
        let points = BOXES.map(|side| {
            let columns = self.width.div_ceil(side);
            let mut boxes = vec![false; columns * self.height.div_ceil(side)];
            for (at, _) in self.lumas.iter().enumerate().filter(|(_, luma)| **luma > median) {
                boxes[at / self.width / side * columns + at % self.width / side] = true;
            }
            let full = boxes.iter().filter(|is_full| **is_full).count().max(1);
            [-libm::log(side as f64), libm::log(full as f64)]
        });
        let [x, y] = [0, 1].map(|at| points.iter().map(|point| point[at]).sum::<f64>() / points.len() as f64);
        let along: f64 = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
        along / points.iter().map(|point| (point[0] - x) * (point[0] - x)).sum::<f64>()
    }

    /// 0 for a plain picture.
    fn symmetry(&self) -> f64 {
        let [mean, deviation] = spread(self.lumas.iter().copied());
        if deviation < 1e-6 {
            return 0.0;
        }
        let correlation = |other: &dyn Fn(usize, usize) -> [usize; 2]| {
            let mut sum = 0.0;
            for y in 0..self.height {
                for x in 0..self.width {
                    let [u, v] = other(x, y);
                    sum += (self.at(x, y) - mean) * (self.at(u, v) - mean);
                }
            }
            sum / self.lumas.len() as f64 / (deviation * deviation)
        };
        let (right, bottom) = (self.width - 1, self.height - 1);
        let mirrored = correlation(&|x, y| [right - x, y]).max(correlation(&|x, y| [x, bottom - y]));
        mirrored.max(correlation(&|x, y| [right - x, bottom - y]))
    }

    fn offset(&self) -> f64 {
        let light: f64 = self.lumas.iter().sum();
        if light <= 0.0 {
            return 0.0;
        }
        let [half_width, half_height] = [self.width, self.height].map(|pixels| pixels as f64 / 2.0);
        let (mut x, mut y) = (0.0, 0.0);
        for (at, luma) in self.lumas.iter().enumerate() {
            x += luma * ((at % self.width) as f64 + 0.5 - half_width);
            y += luma * ((at / self.width) as f64 + 0.5 - half_height);
        }
        let corner = (half_width * half_width + half_height * half_height).sqrt();
        (x * x + y * y).sqrt() / light / corner
    }
}
