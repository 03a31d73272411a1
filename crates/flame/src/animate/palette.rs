//! Interpolation from one palette to another.
//!
//! Owns the methods that genomes choose among, as flam3 has them, and the choice of another one where a genome makes none:
//! `oklab.rs`. Looking a colour up is `genome/palette.rs`'s.
//!
//! Start at [`PaletteWay`]; [`blend`] is flam3's.

use super::oklab::Way;
use super::transition::mix;
use crate::genome::palette::{from_hsv, to_hsv};
use crate::genome::{HuePath, Palette};

/// The way from one palette to another in a transition.
///
/// A genome that asks for `rgb`, `hsv` or `sweep` gets it. The other one, `hsv_circular`, is what flam3 writes into every
/// file. It is taken for no choice: those colours are blended as the eye sees them.
#[derive(Clone, Debug)]
pub(super) struct PaletteWay {
    ends: [Palette; 2],
    path: HuePath,
    /// The way where no path was chosen.
    seen: Option<Seen>,
}

/// A way as the eye sees it, and what it leaves out at both ends of each entry: rounding, and colours that no screen shows.
#[derive(Clone, Debug)]
struct Seen {
    way: Way,
    rest: Vec<[[f64; 3]; 2]>,
}

impl PaletteWay {
    /// The way from `from` to `to` that `path` asks for.
    pub(super) fn new(from: &Palette, to: &Palette, path: HuePath) -> PaletteWay {
        let seen = (path == HuePath::HsvCircular).then(|| {
            let way = Way::new(from, to);
            let off = |own: &[f64; 4], shown: [f64; 3]| std::array::from_fn(|c| own[c] - shown[c]);
            let starts = from.entries.iter().zip(way.at(0.0)).map(|(own, shown)| off(own, shown));
            let ends = to.entries.iter().zip(way.at(1.0)).map(|(own, shown)| off(own, shown));
            let rest = starts.zip(ends).map(|(start, end)| [start, end]).collect();
            Seen { way, rest }
        });
        PaletteWay { ends: [from.clone(), to.clone()], path, seen }
    }

    /// The palette at `part` of the way, `0.0..=1.0`, of which `rgb` is blended straight.
    pub(super) fn at(&self, part: f64, rgb: f64) -> Palette {
        let [from, to] = &self.ends;
        let Some(Seen { way, rest }) = &self.seen else {
            // A sweep ends half an entry early: flam3's changes the last one at the very end, which would be a jump there.
            let early = if self.path == HuePath::Sweep { 0.5 / Palette::LEN as f64 } else { 0.0 };
            return blend(from, to, part + early, self.path, rgb);
        };
        let seen = way.at(part);
        Palette::from_fn(|i| {
            let straight: [f64; 4] = std::array::from_fn(|c| mix(from.entries[i][c], to.entries[i][c], part));
            let round = |c: usize| seen[i][c] + mix(rest[i][0][c], rest[i][1][c], part);
            std::array::from_fn(|c| if c < 3 { mix(round(c), straight[c], rgb) } else { straight[c] })
        })
    }
}

/// Interpolates from `from` to `to` by `part` (`0.0..=1.0`), as flam3 does.
///
/// * `path` — through which space.
/// * `rgb` — how much of the linear RGB blend is mixed in, `0.0..=1.0`.
pub(super) fn blend(from: &Palette, to: &Palette, part: f64, path: HuePath, rgb: f64) -> Palette {
    Palette::from_fn(|i| {
        let (start, end) = (from.entries[i], to.entries[i]);
        let straight: [f64; 4] = std::array::from_fn(|c| mix(start[c], end[c], part));
        let circular = match path {
            HuePath::Rgb => return straight,
            HuePath::Sweep => return if i as f64 >= (1.0 - part) * Palette::LEN as f64 { end } else { start },
            HuePath::Hsv => false,
            HuePath::HsvCircular => true,
        };
        // flam3 mixes nothing into `hsv`.
        let rgb = if circular { rgb } else { 0.0 };
        let [red, green, blue] = by_hue(colour(start), colour(end), part, circular);
        let round = [red, green, blue, straight[3]];
        std::array::from_fn(|c| mix(round[c], straight[c], rgb))
    })
}

fn colour([red, green, blue, _]: [f64; 4]) -> [f64; 3] {
    [red, green, blue]
}

/// The same through four palettes, by these weights, as flam3 does for the second and the third of four key frames: hues
/// then never take the shorter way round.
pub(super) fn blend_smoothly(keys: [&Palette; 4], weights: [f64; 4], path: HuePath, rgb: f64) -> Palette {
    if path == HuePath::Sweep {
        // flam3 does not sweep here.
        return keys[1].clone();
    }
    let rgb = match path {
        HuePath::Rgb => 1.0,
        HuePath::HsvCircular => rgb,
        HuePath::Hsv | HuePath::Sweep => 0.0,
    };
    let sum = |of: &dyn Fn(usize) -> f64| (0..4).map(|key| weights[key] * of(key)).sum::<f64>();
    Palette::from_fn(|i| {
        let hsv = keys.map(|key| to_hsv(colour(key.entries[i])));
        let [hue, saturation, value] = std::array::from_fn(|c| sum(&|key| hsv[key][c]));
        let [red, green, blue] = from_hsv([hue, saturation.clamp(0.0, 1.0), value]);
        let straight: [f64; 4] = std::array::from_fn(|c| sum(&|key| keys[key].entries[i][c]));
        let round = [red, green, blue, straight[3]];
        std::array::from_fn(|c| mix(round[c], straight[c], rgb).clamp(0.0, 255.0))
    })
}

/// By hue, saturation and value. The hue of grey is that of red.
fn by_hue(start: [f64; 3], end: [f64; 3], part: f64, circular: bool) -> [f64; 3] {
    let (a, b) = (to_hsv(start), to_hsv(end));
    let mut way = b[0] - a[0];
    if circular && way.abs() > 3.0 {
        way -= way.signum() * 6.0;
    }
    from_hsv([a[0] + way * part, mix(a[1], b[1], part), mix(a[2], b[2], part)])
}
