//! What other programs than flam3 make of a pixel's light: white level, balance, saturation, tone curves.
//!
//! Owns how a genome's [`Finish`] is applied to pixels. Gamma is `tonemap.rs`'s, log-density `density.rs`'s.
//!
//! Start at [`Look::new`].

use crate::genome::{Curves, Finish};

/// Stretches of a curve's table: four to a step of a byte.
const STRETCHES: usize = 1024;

/// A finish, ready to be applied to pixels.
pub(super) struct Look {
    /// By which red, green and blue are multiplied before gamma.
    channels: [f64; 3],
    /// What is added to the saturation.
    saturation: f64,
    /// The curve of each channel after that of all.
    curves: Option<[Vec<f32>; 3]>,
}

impl Look {
    /// What `finish` does to pixels; `None` if it leaves them flam3's.
    pub(super) fn new(finish: &Finish) -> Option<Look> {
        let channels = finish.channels();
        let saturation = finish.saturation - 1.0;
        let curves = finish.curves.as_deref().map(tables);
        let is_plain = channels == [1.0; 3] && saturation == 0.0 && curves.is_none();
        (!is_plain).then_some(Look { channels, saturation, curves })
    }

    /// The log-density of a pixel, balanced.
    pub(super) fn balanced(&self, [red, green, blue, density]: [f64; 4]) -> [f64; 4] {
        let [r, g, b] = self.channels;
        [red * r, green * g, blue * b, density]
    }

    /// The light of a pixel, finished.
    pub(super) fn finished(&self, light: [f32; 3]) -> [f32; 3] {
        let light = if self.saturation == 0.0 { light } else { saturated(light, self.saturation) };
        let Some(curves) = &self.curves else { return light };
        std::array::from_fn(|channel| looked_up(&curves[channel], light[channel]))
    }
}

/// The curve of each channel after that of all: at even places from 0 to 1.
fn tables(curves: &Curves) -> [Vec<f32>; 3] {
    let overall = curves.table(0, STRETCHES + 1);
    [1, 2, 3].map(|number| {
        let own: Vec<f32> = curves.table(number, STRETCHES + 1).into_iter().map(|y| y as f32).collect();
        overall.iter().map(|y| looked_up(&own, *y as f32)).collect()
    })
}

fn looked_up(table: &[f32], x: f32) -> f32 {
    let place = x.clamp(0.0, 1.0) * STRETCHES as f32;
    let start = (place as usize).min(STRETCHES - 1);
    let [from, to] = [table[start], table[start + 1]];
    (from + (to - from) * (place - start as f32)).clamp(0.0, 1.0)
}

/// `light` with its saturation in HSL, from 0 to 1, changed by `more`. Gray stays gray.
fn saturated(light: [f32; 3], more: f64) -> [f32; 3] {
    let [red, green, blue] = light.map(f64::from);
    let (high, low) = (red.max(green).max(blue), red.min(green).min(blue));
    let lightness = f64::midpoint(high, low);
    let most = 1.0 - (2.0 * lightness - 1.0).abs();
    if high <= low || most <= 0.0 {
        return light;
    }
    let saturation = (high - low) / most;
    let ratio = (saturation + more).clamp(0.0, 1.0) / saturation;
    [red, green, blue].map(|channel| (lightness + (channel - lightness) * ratio).clamp(0.0, 1.0) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn saturation_moves_a_colour_from_its_gray_to_its_hue() {
        let orange = [0.8, 0.5, 0.2];
        assert_eq!(saturated(orange, -1.0), [0.5; 3]);
        assert!(saturated(orange, 9.0).iter().zip([1.0, 0.5, 0.0]).all(|(a, b)| (a - b).abs() < 1e-6));
        assert!(saturated(orange, -0.3).iter().zip([0.65, 0.5, 0.35]).all(|(a, b)| (a - b).abs() < 1e-6));
        assert_eq!(saturated([0.4; 3], 0.5), [0.4; 3]);
    }

    #[test]
    fn flam3s_finish_is_no_work_and_others_are_applied_in_order() {
        assert!(Look::new(&Finish::default()).is_none());
        let look = Look::new(&Finish {
            white_level: 2.0 * Finish::default().white_level,
            balancing: [1.0, 2.0, 0.0],
            ..Finish::default()
        })
        .unwrap();
        assert_eq!(look.balanced([0.4, 0.4, 0.4, 0.9]), [0.2, 0.4, 0.0, 0.9]);
        assert_eq!(look.finished([0.1, 0.2, 0.3]), [0.1, 0.2, 0.3]);
        let line = |from: f64, to: f64| vec![[0.0, from], [1.0, to]];
        let curves = Curves::Splines([line(0.0, 0.5), line(0.0, 1.0), line(1.0, 0.0), line(0.5, 0.5)]);
        let look = Look::new(&Finish { curves: Some(Box::new(curves)), ..Finish::default() }).unwrap();
        // Half the light by the curve of all, then turned round in green, and level in blue.
        let found = look.finished([0.6; 3]);
        assert!(found.iter().zip([0.3, 0.7, 0.5]).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }
}
