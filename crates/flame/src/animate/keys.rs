//! Key frames: the flames of one file, each with its time, and what lies between them.
//!
//! Owns flam3's interpolation: `linear` and `smooth` in time, the spaces of affine parts, the padding. Never turns or waves
//! a transform: loops do, and so does `flam3-genome` before it writes key frames.
//!
//! Start at [`KeyFrames::new`].
//!
//! # Source
//! What `flam3-genome` prints for files with key frames. The key at the start of a stretch says how it is interpolated.

use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use super::Motion;
use super::align::{Padding, align};
use super::palette::{blend, blend_smoothly};
use super::transition::{between, mixed};
use crate::genome::{Affine, Genome, GenomeError, Interpolation, Space, Xform, catmull_rom};

/// Columns shorter than this are interpolated linearly in their length: its logarithm is too large.
const SHORT: f64 = 4.54e-5;

/// The flames of a file over the time that they name.
#[derive(Clone, Debug)]
pub struct KeyFrames {
    /// At least one, in the order of their times.
    keys: Vec<Genome>,
    /// What lies between each and the next, once it has been looked at: a file may have thousands.
    stretches: Vec<OnceLock<Stretch>>,
}

/// The time between two key frames.
#[derive(Clone, Debug)]
struct Stretch {
    /// The one before, both ends, and the one after; an end where there is none. With the same parts.
    keys: [Genome; 4],
    is_smooth: bool,
    /// For each transform, the final one last: its affine part and its post part.
    paths: Vec<[Path; 2]>,
}

/// The affine parts of four keys.
#[derive(Clone, Debug)]
enum Path {
    /// Entry by entry.
    Straight([Affine; 4]),
    /// By the lengths and angles of the columns: logarithms of lengths if `is_log`.
    Polar { is_log: [bool; 2], lengths: [[f64; 4]; 2], angles: [[f64; 4]; 2], offsets: [[f64; 4]; 2] },
}

impl KeyFrames {
    /// The key frames of a file.
    ///
    /// # Errors
    /// [`GenomeError::Count`] if there are none, [`GenomeError::Order`] if one is not later than the one before.
    pub fn new(keys: Vec<Genome>) -> Result<KeyFrames, GenomeError> {
        if keys.is_empty() {
            return Err(GenomeError::Count { found: 0 });
        }
        for (before, pair) in keys.windows(2).enumerate() {
            if pair[0].time >= pair[1].time {
                return Err(GenomeError::Order { number: before + 2, found: pair[1].time, before: pair[0].time });
            }
        }
        let stretches = vec![OnceLock::new(); keys.len() - 1];
        Ok(KeyFrames { keys, stretches })
    }
}

impl Motion for KeyFrames {
    /// The genome at the time `frame`; before the first key and after the last it stands still.
    fn at(&self, frame: f64) -> Genome {
        let next = self.keys.partition_point(|key| key.time <= frame);
        match (next.checked_sub(1), self.stretches.get(next.wrapping_sub(1))) {
            (Some(start), Some(stretch)) if self.keys[start].time < frame => {
                let stretch = stretch.get_or_init(|| Stretch::new(&self.keys, start));
                let (from, to) = (self.keys[start].time, self.keys[next].time);
                stretch.at((frame - from) / (to - from), frame)
            }
            (Some(start), _) => self.keys[start].clone(),
            (None, _) => self.keys[0].clone(),
        }
    }
}

impl Stretch {
    /// What lies between key `start` of `keys` and the next.
    fn new(keys: &[Genome], start: usize) -> Stretch {
        let (first, last) = (&keys[start], keys.len() - 1);
        // There is no curve where it would lead beyond the file.
        let is_smooth = first.interpolation == Interpolation::Smooth && start > 0 && start + 1 < last;
        let written = |key: usize| keys[key].with_symmetry();
        let keys = if is_smooth {
            align([start - 1, start, start + 1, start + 2].map(written), first.space, Padding::AsFlam3)
        } else {
            let [from, to] = align([start, start + 1].map(written), first.space, Padding::AsFlam3);
            [from.clone(), from, to.clone(), to]
        };
        let number_of = keys[0].xforms.len() + keys[0].finals.len();
        let xform = |key: &Genome, i: usize| key.xforms.iter().chain(&key.finals).nth(i).cloned().unwrap_or_default();
        let path = |i, part: fn(&Xform) -> Affine| {
            let parts = keys.each_ref().map(|key| part(&xform(key, i)));
            if first.space == Space::Log { Path::polar(parts) } else { Path::Straight(parts) }
        };
        let paths = (0..number_of).map(|i| [path(i, |xform| xform.affine), path(i, |xform| xform.post)]).collect();
        Stretch { keys, is_smooth, paths }
    }

    /// The genome at `part` of the stretch, `0.0..=1.0`.
    fn at(&self, part: f64, time: f64) -> Genome {
        let weights = if self.is_smooth { catmull_rom(part) } else { [0.0, 1.0 - part, part, 0.0] };
        let first = &self.keys[1];
        let mut genome = self.mixture(part, |a, b, part| Genome {
            xforms: a.xforms.iter().zip(&b.xforms).map(|(a, b)| mixed(a, b, part)).collect(),
            finals: a.finals.iter().zip(&b.finals).map(|(a, b)| mixed(a, b, part)).collect(),
            ..between(a, b, part)
        });
        for (xform, [affine, post]) in genome.xforms.iter_mut().chain(&mut genome.finals).zip(&self.paths) {
            (xform.affine, xform.post) = (affine.at(weights), post.at(weights));
            // A curve may lead beyond its keys.
            xform.weight = xform.weight.max(0.0);
            xform.color = xform.color.clamp(0.0, 1.0);
            xform.color_speed = xform.color_speed.clamp(0.0, 1.0);
        }
        let palettes = self.keys.each_ref().map(|key| key.palette.as_ref());
        genome.palette = match palettes {
            [Some(before), Some(from), Some(to), Some(after)] if self.is_smooth => {
                let keys = [before, from, to, after];
                Some(blend_smoothly(keys, weights, first.hue_path, first.hue_path_rgb))
            }
            [_, Some(from), Some(to), _] => Some(blend(from, to, part, first.hue_path, first.hue_path_rgb)),
            _ => None,
        };
        Genome { time, ..genome }
    }

    /// The keys, mixed by `mix`, which is linear in its last argument: a Catmull-Rom curve is a mixture of mixtures.
    fn mixture(&self, part: f64, mix: impl Fn(&Genome, &Genome, f64) -> Genome) -> Genome {
        let [before, from, to, after] = &self.keys;
        let middle = mix(from, to, part);
        if !self.is_smooth {
            return middle;
        }
        let (early, late) = (mix(before, from, part + 1.0), mix(to, after, part - 1.0));
        mix(&mix(&early, &middle, f64::midpoint(part, 1.0)), &mix(&middle, &late, part / 2.0), part)
    }
}

impl Path {
    fn polar(parts: [Affine; 4]) -> Path {
        let columns = [parts.map(|part| (part.a, part.d)), parts.map(|part| (part.b, part.e))];
        let lengths = columns.map(|column| column.map(|(x, y)| libm::hypot(x, y)));
        let is_log = lengths.map(|lengths| lengths.iter().all(|length| *length > SHORT));
        let mut angles = columns.map(|column| column.map(|(x, y)| libm::atan2(y, x)));
        for (angles, lengths) in angles.iter_mut().zip(lengths) {
            // A column of length 0 has no angle: it takes a neighbour's.
            for key in [1, 2, 3, 2, 1, 0] {
                let neighbour = [1, 2, 1, 2][key];
                if lengths[key] == 0.0 && lengths[neighbour] > 0.0 {
                    angles[key] = angles[neighbour];
                }
            }
            for key in 1..4 {
                let way = angles[key] - angles[key - 1];
                angles[key] = angles[key - 1] + PI - (PI - way).rem_euclid(TAU);
            }
        }
        let stored = |column: usize| if is_log[column] { lengths[column].map(libm::log) } else { lengths[column] };
        let offsets = [parts.map(|part| part.c), parts.map(|part| part.f)];
        Path::Polar { is_log, lengths: [stored(0), stored(1)], angles, offsets }
    }

    fn at(&self, weights: [f64; 4]) -> Affine {
        let sum = |values: &[f64; 4]| values.iter().zip(weights).map(|(value, weight)| value * weight).sum::<f64>();
        match self {
            Path::Straight(parts) => {
                let entry = |of: fn(&Affine) -> f64| sum(&parts.each_ref().map(of));
                Affine {
                    a: entry(|part| part.a),
                    b: entry(|part| part.b),
                    c: entry(|part| part.c),
                    d: entry(|part| part.d),
                    e: entry(|part| part.e),
                    f: entry(|part| part.f),
                }
            }
            Path::Polar { is_log, lengths, angles, offsets } => {
                let column = |i: usize| {
                    let length = if is_log[i] { libm::exp(sum(&lengths[i])) } else { sum(&lengths[i]) };
                    let (sin, cos) = libm::sincos(sum(&angles[i]));
                    (length * cos, length * sin)
                };
                let ((a, d), (b, e)) = (column(0), column(1));
                Affine { a, b, c: sum(&offsets[0]), d, e, f: sum(&offsets[1]) }
            }
        }
    }
}
