//! The moments of a frame.
//!
//! Owns how long the shutter is open, for species whose pictures are the mean of a few moments: all have the same blur. Never
//! draws.
//!
//! Start at [`shutter`].

use crate::contract::{Recipe, Settings};

/// How long the shutter is open, in frames.
const OPEN: f64 = 0.5;

/// Frames from the middle of a frame to the middle of moment `moment` of `moments`.
pub fn shutter(moment: u32, moments: u32) -> f64 {
    ((f64::from(moment) + 0.5) / f64::from(moments) - 0.5) * OPEN
}

impl Recipe {
    /// The recipe of pictures that are the mean of `moments` moments, of the version `version` of a species.
    pub fn of_moments(version: String, settings: &Settings, moments: u32, genome: String) -> Recipe {
        let [width, height] = settings.size;
        Recipe { version, settings: format!("{width} by {height} pixels, {moments} moments"), genome }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_lie_evenly_around_the_middle_of_the_frame_while_the_shutter_is_open() {
        let sixteenths = [0, 1, 2, 3].map(|moment| shutter(moment, 4) * 16.0);
        assert_eq!(sixteenths.map(f64::to_bits), [-3.0f64, -1.0, 1.0, 3.0].map(f64::to_bits));
        assert_eq!(shutter(0, 1).to_bits(), 0);
    }
}
