//! What is half way: whether a transition's middle is worth its rendering.
//!
//! Owns the score of a transition and the names of what is wrong with it, found on small pictures of some moments. Never
//! changes a transition: a species does what can be done.
//!
//! Start at [`Middle::of`].

use crate::contract::{Motion, RenderError};
use crate::light::Light;
use crate::threads::Threads;

/// The moments that are looked at, not those at which the exposure was measured.
const MOMENTS: usize = 9;

/// Those nearest to half way.
const HALF_WAY: [usize; 2] = [4, 5];

/// Less of the expected brightness is dead, more than its inverse blown out.
const DIM: f64 = 0.5;

/// White that the ends do not have, as a part of the picture: more is blown out.
const WHITE: f64 = 0.15;

/// Less of what the ends show, in pixels that show something, is empty: 0.31 is a white core in the dark.
const EMPTY: f64 = 0.35;

/// How many times as far as at the ends a picture may come from one frame to the next.
const RESTLESS: f64 = 8.0;

/// So little a frame is never restless, as a root mean square of the luma of blocks.
const CALM: f64 = 0.02;

/// What is wrong with a middle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MiddleFault {
    /// Too dark, however it is exposed.
    Dead,
    /// Too bright, or white.
    BlownOut,
    /// Nearly all of its light is in few places.
    Empty,
    /// It changes too much from frame to frame.
    Flickering,
}

/// The worst of some moments between the ends of a transition.
#[derive(Clone, Debug, PartialEq)]
pub struct Middle {
    /// From 0, unusable, to 1, as good as the ends: the product of what follows, each limited to 1.
    pub score: f64,
    /// The brightness that is furthest off, as a part of what is expected between the ends.
    pub brightness: f64,
    /// The pixels that show something, as a part of those expected.
    pub lit: f64,
    /// The part of white pixels beyond those expected.
    pub white: f64,
    /// The picture's largest change from a frame to the next, as a multiple of the largest at the ends.
    pub flicker: f64,
    /// The lesser contrast of the two moments nearest to half way, as a part of the mean of the ends'. It does not count in
    /// the score.
    pub contrast: f64,
    /// What is wrong.
    pub faults: Vec<MiddleFault>,
}

impl MiddleFault {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            MiddleFault::Dead => "dead",
            MiddleFault::BlownOut => "blown-out",
            MiddleFault::Empty => "empty",
            MiddleFault::Flickering => "flickering",
        }
    }
}

impl Middle {
    /// Looks at `motion` from frame 0 to `frames`, of which pictures are to be of `size`.
    ///
    /// # Errors
    /// As [`Motion::frame`].
    pub fn of(motion: &dyn Motion, frames: f64, size: [u32; 2], threads: &Threads) -> Result<Middle, RenderError> {
        let light = |frame: f64| Light::of_motion(motion, frame, size, threads);
        // Motion is slower than a frame where there are many.
        let step = |frame: f64| Ok::<_, RenderError>((light(frame)?, light(frame + 1.0)?));
        let (start, end) = (step(0.0)?, step(frames - 1.0)?);
        let ends = |of: fn(&Light) -> f64| [of(&start.0), of(&end.1)];
        let usual = start.0.apart(&start.1).max(end.0.apart(&end.1)).max(CALM / RESTLESS);
        let usual_contrast = f64::midpoint(start.0.contrast, end.1.contrast).max(1e-6);
        let mut middle = Middle::UNSEEN;
        for moment in 1..MOMENTS {
            let part = moment as f64 / MOMENTS as f64;
            let (now, next) = step((part * frames).floor())?;
            let of_expected = |of: fn(&Light) -> f64| of(&now) / expected(ends(of), part).max(1e-6);
            let brightness = of_expected(|light| light.mean);
            if from_one(brightness) < from_one(middle.brightness) {
                middle.brightness = brightness;
            }
            middle.lit = middle.lit.min(of_expected(|light| light.lit));
            middle.white = middle.white.max(now.white - expected(ends(|light| light.white), part));
            middle.flicker = middle.flicker.max(now.apart(&next) / usual);
            if HALF_WAY.contains(&moment) {
                middle.contrast = middle.contrast.min(now.contrast / usual_contrast);
            }
        }
        middle.judge();
        Ok(middle)
    }

    /// Before any moment is looked at.
    const UNSEEN: Middle = Middle {
        score: 0.0,
        brightness: 1.0,
        lit: 1.0,
        white: 0.0,
        flicker: 0.0,
        contrast: f64::INFINITY,
        faults: Vec::new(),
    };

    fn judge(&mut self) {
        let Middle { brightness, lit, white, flicker, .. } = *self;
        self.score = from_one(brightness) * lit.min(1.0) * (1.0 - white) * (RESTLESS / flicker.max(RESTLESS));
        for (is_wrong, fault) in [
            (brightness < DIM, MiddleFault::Dead),
            (brightness > 1.0 / DIM || white > WHITE, MiddleFault::BlownOut),
            (lit < EMPTY, MiddleFault::Empty),
            (flicker > RESTLESS, MiddleFault::Flickering),
        ] {
            if is_wrong {
                self.faults.push(fault);
            }
        }
    }
}

/// What is expected at `part` of the way from the one end to the other: eased, as everything else is.
pub fn expected(ends: [f64; 2], part: f64) -> f64 {
    ends[0] + (ends[1] - ends[0]) * part * part * (3.0 - 2.0 * part)
}

/// How near a ratio is to 1: itself or its inverse, whichever is less.
fn from_one(ratio: f64) -> f64 {
    if ratio > 1.0 { 1.0 / ratio } else { ratio }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made::Made;

    fn middle(picture: fn(f32, f32, f64) -> [f32; 3]) -> Middle {
        Middle::of(&Made(picture), 100.0, [1280, 720], &Threads::new(1).unwrap()).unwrap()
    }

    /// 0 at both ends, 1 half way.
    fn half_way(frame: f64) -> f32 {
        let part = (frame / 100.0).clamp(0.0, 1.0) as f32;
        4.0 * part * (1.0 - part)
    }

    #[test]
    fn what_stays_as_it_is_is_as_good_as_its_ends() {
        let found = middle(|x, _, _| [0.4 * x + 0.5; 3]);
        assert_eq!((found.score, &found.faults[..]), (1.0, &[][..]));
        assert!((found.contrast - 1.0).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn what_is_wrong_half_way_is_named() {
        let faults = |picture: fn(f32, f32, f64) -> [f32; 3]| middle(picture).faults;
        let dark = faults(|x, _, frame| [(0.4 * x + 0.5) * (1.0 - half_way(frame)); 3]);
        assert_eq!(dark, [MiddleFault::Dead, MiddleFault::Empty]);
        assert_eq!(faults(|x, _, frame| [(0.4 * x + 0.5).max(half_way(frame)); 3]), [MiddleFault::BlownOut]);
        let shaken = faults(|x, _, frame| [0.5 + 0.4 * x * (1.0 - half_way(frame) * (frame % 2.0) as f32); 3]);
        assert_eq!(shaken, [MiddleFault::Flickering]);
    }

    #[test]
    fn contrast_that_is_lost_half_way_is_told_and_does_not_change_the_score() {
        let found = middle(|x, _, frame| [0.5 + 0.4 * x * (1.0 - 0.8 * half_way(frame)); 3]);
        // The moments nearest to the middle are 4/9 and 5/9 of the way.
        assert!((found.contrast - 0.21).abs() < 0.01 && found.score > 0.9, "{found:?}");
    }
}
