//! Where the camera of a bred flame stands, how bright it is, and at which moment its loop begins.
//!
//! Owns the box that is framed, the glances at a loop, and how bright a flame is made. Never judges it.
//!
//! Start at [`framed`] and [`lit`].

use species::{Light, Threads};

use super::chance::short;
use crate::animate::{Loop, Motion};
use crate::genome::{Affine, Camera, Genome};
use crate::light::glance;
use crate::render::{RenderError, points};

/// Moments of the loop that are looked at.
const MOMENTS: usize = 8;
/// Points of all moments together, by whose box a flame is framed.
const POINTS: usize = 100_000;
/// The least part of them that has to be on the plane.
const LEAST_POINTS: f64 = 0.5;
/// The parts of all points that are left out to either side.
const OUTSIDE: f64 = 0.02;
/// Boxes that are smaller or larger are no pictures.
const SIDES: [f64; 2] = [1e-4, 1e4];
/// How much of the box's height is seen at least: most flames are as high as wide, and pictures are wide.
const LEAST_HEIGHT: f64 = 0.65;
/// Random numbers of points.
const SEED: u64 = 1;

/// The mean luma of the brightest moment of a flame at random, and that of others at least and at most.
const LUMA: f64 = 0.22;
const LUMAS: [f64; 2] = [0.14, 0.32];
/// Gains of the log-density.
const BRIGHTNESS: [f64; 2] = [0.02, 4000.0];
/// How often brightness is set anew, by how much at most, and how near is near enough.
const EXPOSURES: usize = 5;
const MOST_GAIN: f64 = 40.0;
const NEAR: f64 = 0.08;

/// Whose brightness is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Exposing {
    /// That of a flame which had none.
    All,
    /// That of a flame which is too dark or too bright.
    Extremes,
}

/// The same flame in front of its camera: it sees the box that has all points of the loop but for 2 % to either side, in
/// its width, and at least two thirds of its height. `None` if there is no such box.
pub(super) fn framed(genome: &Genome) -> Option<Genome> {
    let turning = Loop::new(genome, MOMENTS as f64);
    let mut seen: Vec<[f64; 2]> = Vec::with_capacity(POINTS);
    for moment in 0..MOMENTS {
        let then = turning.at(moment as f64);
        seen.extend(points(&then, POINTS / MOMENTS, SEED + moment as u64).ok()?);
    }
    if (seen.len() as f64) < LEAST_POINTS * POINTS as f64 {
        return None;
    }
    // As the camera has its axes.
    let (sin, cos) = libm::sincos(genome.camera.rotate.to_radians());
    let turned = Affine { a: cos, b: -sin, d: sin, e: cos, c: 0.0, f: 0.0 };
    let [across, down] = [0, 1].map(|axis| {
        let mut places: Vec<f64> = seen.iter().map(|[x, y]| <[f64; 2]>::from(turned.apply(*x, *y))[axis]).collect();
        middle_part(&mut places)
    });
    let [width, height] = [across, down].map(|[from, to]| to - from);
    let is_fine = |side: f64| side.is_finite() && (SIDES[0]..SIDES[1]).contains(&side);
    if !is_fine(width) || !is_fine(height) {
        return None;
    }
    let size = genome.camera.size.map(f64::from);
    let pixels_per_unit = (size[0] / width).min(size[1] / (LEAST_HEIGHT * height));
    let [x, y] = [across, down].map(|[from, to]| f64::midpoint(from, to));
    let back = Affine { b: sin, d: -sin, ..turned };
    let (x, y) = back.apply(x, y);
    let camera = Camera {
        center: [short(x), short(y)],
        center_turns: 1.0,
        scale: short(pixels_per_unit / libm::exp2(genome.camera.zoom)),
        ..genome.camera
    };
    Some(Genome { camera, ..genome.clone() })
}

/// From where to where all of `places` are but for those outside.
fn middle_part(places: &mut [f64]) -> [f64; 2] {
    let out = (OUTSIDE * places.len() as f64) as usize;
    let last = places.len() - 1 - out;
    let low = *places.select_nth_unstable_by(out, f64::total_cmp).1;
    [low, *places.select_nth_unstable_by(last, f64::total_cmp).1]
}

/// The same flame at the brightest of 8 moments of its loop, and the light of that moment. A flame that waves, too,
/// begins where it did: its waves have their own beginning.
pub(super) fn turned_to_the_brightest(genome: &Genome, threads: &Threads) -> Result<(Genome, Light), RenderError> {
    let turning = Loop::new(genome, MOMENTS as f64);
    let mut brightest = (0, glance(&turning, 0.0, threads)?);
    if genome.xforms.iter().chain(&genome.finals).any(|xform| !xform.motions.is_empty()) {
        return Ok((genome.clone(), brightest.1));
    }
    for moment in 1..MOMENTS {
        let light = glance(&turning, moment as f64, threads)?;
        if light.mean > brightest.1.mean {
            brightest = (moment, light);
        }
    }
    let mut turned = turning.at(brightest.0 as f64);
    for xform in turned.xforms.iter_mut().filter(|_| brightest.0 > 0) {
        let Affine { a, b, c, d, e, f } = xform.affine;
        let [a, b, d, e] = [a, b, d, e].map(short);
        xform.affine = Affine { a, b, c, d, e, f };
    }
    Ok((turned, brightest.1))
}

/// The same flame as bright as flames are, whose first frame has this light.
pub(super) fn lit(
    mut genome: Genome,
    light: &Light,
    whose: Exposing,
    threads: &Threads,
) -> Result<Genome, RenderError> {
    let wanted = match whose {
        Exposing::All => LUMA,
        Exposing::Extremes => light.mean.clamp(LUMAS[0], LUMAS[1]),
    };
    let mut mean = light.mean;
    for _ in 0..EXPOSURES {
        if (mean / wanted - 1.0).abs() < NEAR {
            break;
        }
        // By the gamma of usual flames, light grows with the root of the gain.
        let gain = (wanted / mean.max(1e-6)).powi(2).clamp(1.0 / MOST_GAIN, MOST_GAIN);
        genome.tone.brightness = short((genome.tone.brightness * gain).clamp(BRIGHTNESS[0], BRIGHTNESS[1]));
        mean = glance(&genome, 0.0, threads)?.mean;
    }
    Ok(genome)
}

#[cfg(test)]
mod tests {
    use species::Rng;

    use super::*;

    #[test]
    fn the_box_of_nearly_all_points_fills_the_frame() {
        let mut rng = Rng::stream(7, 0);
        let mut framed_flames = 0;
        for number in 0..30 {
            let rotate = f64::from(number) * 12.0;
            let mut genome = Genome::random(&mut rng);
            (genome.camera.rotate, genome.camera.zoom) = (rotate, 0.5);
            let Some(framed) = framed(&genome) else { continue };
            framed_flames += 1;
            let turning = Loop::new(&framed, 8.0);
            let (sin, cos) = libm::sincos(rotate.to_radians());
            let scale = framed.camera.scale * libm::exp2(0.5);
            let mut places = [Vec::new(), Vec::new()];
            for moment in 0..8 {
                for [x, y] in points(&turning.at(f64::from(moment)), 5000, 99).unwrap() {
                    let [x, y] = [x - framed.camera.center[0], y - framed.camera.center[1]];
                    places[0].push((cos * x - sin * y) * scale / 640.0);
                    places[1].push((sin * x + cos * y) * scale / 360.0);
                }
            }
            // From -1 to 1 is the picture.
            let [across, down] = places.map(|mut places| middle_part(&mut places));
            let [width, height] = [across, down].map(|[from, to]| (to - from) / 2.0);
            assert!(width < 1.1 && LEAST_HEIGHT * height < 1.1, "flame {number}: {across:?}, {down:?}");
            assert!(width > 0.9 || LEAST_HEIGHT * height > 0.9, "flame {number}: {across:?}, {down:?}");
            let is_central = |[from, to]: [f64; 2]| (from + to).abs() < 0.1 * (to - from).max(1.0);
            assert!(is_central(across) && is_central(down), "flame {number}: {across:?}, {down:?}");
        }
        assert!(framed_flames > 20, "{framed_flames}");
    }

    #[test]
    fn a_loop_begins_at_its_brightest_moment_and_is_neither_dark_nor_blown_out() {
        let threads = Threads::new(1).unwrap();
        let mut rng = Rng::stream(8, 0);
        let mut turned_ones = 0;
        for _ in 0..12 {
            let Some(flame) = framed(&Genome::random(&mut rng)) else { continue };
            let (turned, light) = turned_to_the_brightest(&flame, &threads).unwrap();
            let turning = Loop::new(&turned, 8.0);
            let means: Vec<f64> = (0..8).map(|at| glance(&turning, f64::from(at), &threads).unwrap().mean).collect();
            assert!(means.iter().all(|mean| *mean <= 1.05 * means[0]), "{means:?}");
            turned_ones += usize::from(turned != flame);
            let lit = lit(turned, &light, Exposing::All, &threads).unwrap();
            let mean = glance(&lit, 0.0, &threads).unwrap().mean;
            assert!((0.1..0.4).contains(&mean), "{mean}");
        }
        assert!(turned_ones > 4, "{turned_ones}");
    }
}
