//! Threads and instruction sets: who draws which part of a shot.
//!
//! Owns the choice of the instruction set and the sharing of parts among threads. Neither changes a bit of the result.
//!
//! Start at [`draw`].

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use fearless_simd::Level;

use super::bins::Bins;
use super::chaos::Reference;
use super::histogram::{Histogram, Sums};
use super::pool::Pool;
use super::shot::Shot;

/// How samples are calculated. Each gives the same bits on every machine, and all but [`Arithmetic::Reference`] the same
/// as each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arithmetic {
    /// `f32`, by the widest instructions that this processor has; `f64` for what is too deep for that.
    #[default]
    Fastest,
    /// `f32`, by AVX2 where this processor has it and at most that.
    Avx2,
    /// `f32`, by what every processor of its kind has.
    Portable,
    /// `f64`, one orbit at a time: a fifth as fast or less, and what the others are compared with.
    Reference,
}

/// Plays the chaos game.
pub(crate) trait Game {
    /// Draws the part `number` of `shot` into `bins` and returns how many samples that were; once `stop` is set, fewer.
    fn play(&mut self, shot: &Shot, number: u64, bins: &mut Bins, stop: &AtomicBool) -> u64;
}

/// Draws all parts of `shot` on the threads of the current pool and adds them to `sums`; once `stop` is set, only what is
/// begun. Returns how many samples that were, seen or not.
pub(crate) fn draw(shot: &Shot, sums: &mut Sums, arithmetic: Arithmetic, stop: &AtomicBool) -> u64 {
    let (next, samples) = (AtomicU64::new(0), AtomicU64::new(0));
    let histogram = &Histogram::new(sums, &shot.palette);
    rayon::broadcast(|_| {
        let mut game = None;
        let mut bins = Bins::new(histogram);
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= shot.parts() || stop.load(Ordering::Relaxed) {
                break;
            }
            let game = game.get_or_insert_with(|| arithmetic.game());
            samples.fetch_add(game.play(shot, number, &mut bins, stop), Ordering::Relaxed);
        }
        bins.finish();
    });
    samples.into_inner()
}

impl Arithmetic {
    fn game(self) -> Box<dyn Game> {
        if self == Arithmetic::Reference { Box::new(Reference) } else { self.pool() }
    }

    // Not by `dispatch!`, which compiles all formulas for instruction sets between these, too. Tests of units do with one:
    // `tests/it` compares the bits of all.
    #[cfg(target_arch = "x86_64")]
    fn pool(self) -> Box<dyn Game> {
        let level = Level::new();
        match (self, level.as_avx512(), level.as_avx2()) {
            #[cfg(not(test))]
            (Arithmetic::Fastest, Some(avx512), _) => Box::new(Pool::new(avx512)),
            #[cfg(not(test))]
            (Arithmetic::Fastest | Arithmetic::Avx2, _, Some(avx2)) => Box::new(Pool::new(avx2)),
            _ => Box::new(Pool::new(Level::baseline().as_sse2().expect("every x86-64 processor has SSE2"))),
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn pool(self) -> Box<dyn Game> {
        fearless_simd::dispatch!(Level::new(), simd => Box::new(Pool::new(simd)))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;
    use crate::genome::Genome;
    use crate::render::filter::Moment;
    use crate::render::histogram::UNIT;
    use crate::render::view::View;

    /// Samples of blocks of 6 x 6 cells, as a part of all samples.
    fn counts(genome: &Genome, arithmetic: Arithmetic, seed: u64) -> Vec<f64> {
        let view = View::new(genome).unwrap();
        let [width, height] = view.cells;
        let moments = [Moment { offset: 0.0, light: 1.0 }];
        let shot = Shot::new(&[(genome.clone(), view)], &moments, 4_000_000, seed).unwrap();
        let mut sums = Sums::new(width * height);
        let samples = draw(&shot, &mut sums, arithmetic, &AtomicBool::new(false));
        let across = width.div_ceil(6);
        let mut counts = vec![0.0; across * height.div_ceil(6)];
        for (cell, light) in (0..width * height).map(|cell| sums.at(cell)).enumerate() {
            counts[cell / width / 6 * across + cell % width / 6] += f64::from(light[3]) / f64::from(UNIT);
        }
        counts.iter().map(|count| count / samples as f64 * 4e6).collect()
    }

    /// Chi-square over its degrees of freedom: 1 where two counts differ as independent samples do.
    fn chi_square(a: &[f64], b: &[f64]) -> f64 {
        let blocks: Vec<f64> =
            a.iter().zip(b).filter(|(a, b)| *a + *b >= 20.0).map(|(a, b)| (a - b).powi(2) / (a + b)).collect();
        blocks.iter().sum::<f64>() / blocks.len() as f64
    }

    #[test]
    fn lanes_fill_the_cells_as_the_reference_does() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/genomes");
        let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        for file in files {
            let genome = Genome::parse(&fs::read_to_string(&file).unwrap()).unwrap();
            let reference = counts(&genome, Arithmetic::Reference, 1);
            // Samples of an orbit follow each other, so that they are less than independent: the reference against itself
            // says by how much.
            let usual = chi_square(&reference, &counts(&genome, Arithmetic::Reference, 2));
            let lanes = chi_square(&reference, &counts(&genome, Arithmetic::Fastest, 3));
            println!("{lanes:.2} against {usual:.2} {}", file.file_stem().unwrap().to_string_lossy());
            assert!(lanes <= 1.5 * usual.max(1.0), "{lanes} against {usual}: {}", file.display());
        }
    }
}
