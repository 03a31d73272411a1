//! Arguments that are sizes, rates and numbers, and those that several commands take.
//!
//! Owns their parsers, the messages for malformed ones, and the seed of a walk for which none is given.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use flock::{MAX_FPS, Measure, SIDES_PX};
use operations::program::print;
use timing::Rate;

/// The most steps: 158 years. A simulation takes a dozen bytes for each.
const MOST_STEPS: usize = 100_000_000;
/// Most threads: more than any machine has cores.
const MOST_THREADS: usize = 1024;

/// What a share is a part of.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(crate) enum By {
    /// All visits
    Visits,
    /// The time in which loops are shown, repeats included; a sheep without a loop has none
    Time,
}

impl From<By> for Measure {
    fn from(by: By) -> Self {
        match by {
            By::Visits => Self::Visits,
            By::Time => Self::Time,
        }
    }
}

/// A part of a walk: which one, and how many steps.
#[derive(Debug, clap::Args)]
pub(crate) struct WalkArgs {
    /// Folder of the flock
    pub(crate) dir: PathBuf,
    /// Which of the endless walks: the same seed and flock give the same walk [default: a fresh one, which is told]
    #[arg(long)]
    seed: Option<u64>,
    /// Transitions to take; a year of 50-second steps has 630000
    #[arg(long, value_parser = steps)]
    pub(crate) steps: usize,
}

impl WalkArgs {
    /// The seed, or a fresh one if none is given. That is told on stderr, unless the answer is JSON and has it.
    pub(crate) fn seed(&self, json: bool) -> u64 {
        self.seed.unwrap_or_else(|| {
            // Few enough digits to be typed again, and a number that every reader of JSON holds exactly.
            let fresh = rand::random::<u32>().into();
            if !json {
                print::note(&format!("note: a fresh walk; --seed {fresh} gives it again"));
            }
            fresh
        })
    }
}

/// `630000`: steps of a walk.
fn steps(text: &str) -> Result<usize, String> {
    let steps = text.parse().ok().filter(|steps| *steps <= MOST_STEPS);
    steps.ok_or_else(|| format!("wanted a whole number up to {MOST_STEPS}"))
}

/// `1280x720`: width and height in pixels, both even.
pub(crate) fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| text.parse().ok().filter(|side: &u32| SIDES_PX.contains(side) && side.is_multiple_of(2));
    let sides = text.split_once('x').and_then(|(width, height)| Some((side(width)?, side(height)?)));
    let (least, most) = (SIDES_PX.start(), SIDES_PX.end());
    sides.ok_or_else(|| format!("wanted an even width and height from {least} to {most}, such as 1280x720"))
}

/// `30` or `30000/1001`: frames per second.
pub(crate) fn rate(text: &str) -> Result<Rate, String> {
    let (num, den) = text.split_once('/').unwrap_or((text, "1"));
    let whole = |text: &str| text.parse::<u32>().ok().map(u64::from);
    let rate = whole(num).zip(whole(den)).and_then(|(num, den)| Rate::new(num, den).ok());
    rate.filter(|rate| (1..=MAX_FPS).contains(&(rate.num() / rate.den())))
        .ok_or_else(|| format!("wanted a rate from 1 to {MAX_FPS} per second, such as 30 or 30000/1001"))
}

/// A finite number above 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_normal() && *number > 0.0);
    number.ok_or_else(|| "wanted a finite number above 0".to_owned())
}

/// `WxH`: the sides of a picture.
pub(crate) fn any_size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse().ok().filter(|side: &u32| (1..=32_768).contains(side));
    let sides = text.split_once('x').and_then(|(width, height)| Some([side(width)?, side(height)?]));
    sides.ok_or_else(|| "wanted a width and height from 1 to 32768, such as 1280x720".into())
}

/// Threads.
pub(crate) fn threads(text: &str) -> Result<NonZeroUsize, String> {
    let number = text.parse().ok().filter(|number: &NonZeroUsize| number.get() <= MOST_THREADS);
    number.ok_or_else(|| format!("wanted a whole number from 1 to {MOST_THREADS}"))
}

/// Samples per pixel.
pub(crate) fn samples(text: &str) -> Result<f64, String> {
    within(text, 0.01, 1e7)
}

/// Peak signal-to-noise ratio in decibels.
pub(crate) fn decibels(text: &str) -> Result<f64, String> {
    within(text, 10.0, 60.0)
}

/// x264's constant rate factor.
pub(crate) fn rate_factor(text: &str) -> Result<f32, String> {
    within(text, 0.1, 51.0).map(|number| number as f32)
}

/// A time in a genome's file, in frames.
pub(crate) fn time(text: &str) -> Result<f64, String> {
    within(text, -1e9, 1e9)
}

fn within(text: &str, least: f64, most: f64) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (least..=most).contains(number));
    number.ok_or_else(|| format!("wanted a number from {least} to {most}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_manifest_takes_is_read_and_nothing_else() {
        assert_eq!(size("1280x720"), Ok((1280, 720)));
        assert_eq!(rate("30000/1001").map(|rate| (rate.num(), rate.den())), Ok((30_000, 1001)));
        assert_eq!(rate("25").map(|rate| (rate.num(), rate.den())), Ok((25, 1)));
        assert_eq!(positive("2.5"), Ok(2.5));
        for bad in ["", "1280", "1281x720", "8x8", "8192x16", "1280x720x2", "x", "axb"] {
            assert!(size(bad).is_err(), "{bad}");
        }
        for bad in ["", "0", "241", "1/2", "30/0", "30/1/1", "29.97"] {
            assert!(rate(bad).is_err(), "{bad}");
        }
        for bad in ["", "0", "-1", "nan", "inf", "1e-400"] {
            assert!(positive(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn numbers_outside_their_ranges_are_refused() {
        for bad in ["0", "-1", "NaN", "inf", "1e9", ""] {
            assert!(samples(bad).is_err(), "{bad}");
            assert!(rate_factor(bad).is_err(), "{bad}");
            assert!(decibels(bad).is_err() && decibels("200").is_err(), "{bad}");
            assert!(threads(bad).is_err(), "{bad}");
        }
        assert_eq!((samples("1000000"), threads("1000000").ok()), (Ok(1e6), None));
    }
}
