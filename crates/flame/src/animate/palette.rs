//! Interpolation from one palette to another.
//!
//! Owns the four methods that genomes choose among. Looking a colour up is `genome/palette.rs`'s.
//!
//! Start at [`blend`].

use super::transition::mix;
use crate::genome::palette::{from_hsv, to_hsv};
use crate::genome::{HuePath, Palette};

/// Interpolates from `from` to `to` by `part` (`0.0..=1.0`).
///
/// * `path` — through which space.
/// * `rgb` — how much of the linear RGB blend is mixed in, `0.0..=1.0`.
pub(super) fn blend(from: &Palette, to: &Palette, part: f64, path: HuePath, rgb: f64) -> Palette {
    Palette::from_fn(|i| {
        let (start, end) = (from.entries[i], to.entries[i]);
        let straight: [f64; 4] = std::array::from_fn(|c| mix(start[c], end[c], part));
        let circular = match path {
            HuePath::Rgb => return straight,
            HuePath::Sweep => return if i as f64 + 0.5 < part * Palette::LEN as f64 { end } else { start },
            HuePath::Hsv => false,
            HuePath::HsvCircular => true,
        };
        let [red, green, blue] = by_hue(colour(start), colour(end), part, circular);
        let round = [red, green, blue, straight[3]];
        std::array::from_fn(|c| mix(round[c], straight[c], rgb))
    })
}

fn colour([red, green, blue, _]: [f64; 4]) -> [f64; 3] {
    [red, green, blue]
}

/// By hue, saturation and value. Grey has no hue: it takes the other end's.
fn by_hue(start: [f64; 3], end: [f64; 3], part: f64, circular: bool) -> [f64; 3] {
    let (mut a, mut b) = (to_hsv(start), to_hsv(end));
    if a[1] == 0.0 {
        a[0] = b[0];
    } else if b[1] == 0.0 {
        b[0] = a[0];
    }
    let mut way = b[0] - a[0];
    if circular {
        way = (way + 3.0).rem_euclid(6.0) - 3.0;
    }
    from_hsv([a[0] + way * part, mix(a[1], b[1], part), mix(a[2], b[2], part)])
}
