//! What programs other than flam3 make of a picture's light.
//!
//! Owns the values by which Fractorium's and JWildfire's tone differ from flam3's, and their way from one genome to
//! another. `finish_xml.rs` reads and writes them, `render` applies them. Its default is flam3's own tone.
//!
//! Start at [`Finish`].

use super::curve::Curves;

/// The gain of JWildfire's logarithm: it has `2 log10` where flam3 has the natural logarithm.
pub(super) const JWILDFIRE_GAIN: f64 = 2.0 / std::f64::consts::LN_10;

/// The gain of Fractorium's logarithm: it has 255 steps where flam3 has 268.
pub(super) const FRACTORIUM_GAIN: f64 = 255.0 / 268.0;

/// The white level at which colours are flam3's: it has 256 steps to the 255 of others.
const WHITE_LEVEL: f64 = 200.0 * 255.0 / 256.0;

/// Where JWildfire has colour 0 in the palette, and the part over which it spreads colours: entry `254 colour`, rounded to the
/// nearest.
const JWILDFIRES_PALETTE: [f64; 2] = [0.5 / 256.0, 254.0 / 256.0];

/// The part of the palette over which Fractorium spreads colours: the last one is at 1 alone.
pub(super) const PALETTE_SPAN: f64 = 255.0 / 256.0;

/// What the program that wrote a genome does to light, where flam3 does otherwise.
///
/// # Source
/// Pictures of a blurred disc whose density is known, rendered by JWildfire 9.00 with other values of each attribute: the
/// log-density of a pixel is `log_gain contrast brightness ln(1 + density / contrast)` as flam3 counts both, and
/// `low_density / (contrast spp (1 + samples))` more, of `spp` samples per pixel that are drawn; colours are multiplied by
/// `200 balancing / white_level`. Its palette: probes of 30 colours between two entries. Fractorium's gain: the slope of its
/// grey values against flam3's of the same white flame at gamma 1, 0.9518. Lost samples: a second
/// transform that leads to infinity takes as much light from a JWildfire's disc as one that leads out of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Finish {
    /// `contrast`: multiplies log-density and divides density, > 0.
    pub contrast: f64,
    /// `white_level`: what counts as white, > 0; 200 of 256 steps in flam3.
    pub white_level: f64,
    /// `balancing_red`, `balancing_green`, `balancing_blue`: multiply the channels, from 0 on.
    pub balancing: [f64; 3],
    /// `low_density_brightness`: light of pixels with few samples; below 0 it darkens them.
    pub low_density: f64,
    /// `saturation`: more or less than 1 is added to the saturation, from 0 on.
    pub saturation: f64,
    /// `log_gain`: multiplies log-density, > 0; 1 in flam3.
    pub log_gain: f64,
    /// `palette_span`: the part of the palette over which colours from 0 to 1 are spread; 1 in flam3, 255/256 in Fractorium,
    /// 254/256 in JWildfire.
    pub palette_span: f64,
    /// `palette_start`: where colour 0 is in the palette, from 0 to 1; 1/512 in JWildfire, 0 in others.
    pub palette_start: f64,
    /// `lost_samples`: the part of the samples of escaped orbits that counts as drawn; 0 in flam3, 1 in JWildfire, whose
    /// pictures they darken. How long an orbit stays away follows it, too: see `render/escape.rs`.
    pub lost_samples: f64,
    /// Tone curves, after everything else; `None` where all are straight.
    pub curves: Option<Box<Curves>>,
}

impl Default for Finish {
    fn default() -> Finish {
        Finish {
            contrast: 1.0,
            white_level: WHITE_LEVEL,
            balancing: [1.0; 3],
            low_density: 0.0,
            saturation: 1.0,
            log_gain: 1.0,
            palette_span: 1.0,
            palette_start: 0.0,
            lost_samples: 0.0,
            curves: None,
        }
    }
}

impl Finish {
    /// JWildfire's, where a genome says nothing else.
    pub(super) fn jwildfire() -> Finish {
        let light = Finish { white_level: 220.0, low_density: 0.24, log_gain: JWILDFIRE_GAIN, ..Finish::default() };
        let [palette_start, palette_span] = JWILDFIRES_PALETTE;
        Finish { palette_span, palette_start, lost_samples: 1.0, ..light }
    }

    /// Whether colours are spread as flam3 does. Genomes whose colours are keep their pictures to the bit.
    pub(crate) fn has_flam3s_colours(&self) -> bool {
        self.palette_span == 1.0
    }

    /// Whether light has something that only JWildfire's has.
    pub(super) fn has_jwildfires_light(&self) -> bool {
        let Finish { contrast, white_level, balancing, low_density, saturation, .. } = self.clone();
        Finish { contrast, white_level, balancing, low_density, saturation, ..Finish::default() } != Finish::default()
    }

    /// What differs from flam3's tone, in words, in the order in which it is applied.
    pub fn names(&self) -> Vec<&'static str> {
        let light = match self.log_gain {
            _ if self.has_jwildfires_light() => Some("JWildfire's light"),
            1.0 => None,
            FRACTORIUM_GAIN => Some("Fractorium's light"),
            _ => Some("another gain of light"),
        };
        let span = match self.palette_span {
            _ if self.palette_start > 0.0 => Some("colours of the palette's nearest entries"),
            1.0 => None,
            _ => Some("colours up to the palette's last one"),
        };
        span.into_iter().chain(light).chain(self.curves.as_ref().map(|_| "tone curves")).collect()
    }

    /// What lies between this and `to`, linearly by `part`.
    pub(crate) fn mixed(&self, to: &Finish, part: f64) -> Finish {
        if self == to {
            return self.clone();
        }
        let mix = |a: f64, b: f64| a + (b - a) * part;
        // A curve through key frames may lead beyond them.
        let above_0 = |a: f64, b: f64| mix(a, b).max(1e-3 * a.min(b));
        Finish {
            contrast: above_0(self.contrast, to.contrast),
            white_level: above_0(self.white_level, to.white_level),
            balancing: std::array::from_fn(|i| mix(self.balancing[i], to.balancing[i]).max(0.0)),
            low_density: mix(self.low_density, to.low_density),
            saturation: mix(self.saturation, to.saturation).max(0.0),
            log_gain: above_0(self.log_gain, to.log_gain),
            palette_span: mix(self.palette_span, to.palette_span).clamp(0.0, 1.0),
            palette_start: mix(self.palette_start, to.palette_start).clamp(0.0, 1.0),
            lost_samples: mix(self.lost_samples, to.lost_samples).clamp(0.0, 1.0),
            curves: Curves::mixed(self.curves.as_deref(), to.curves.as_deref(), part).map(Box::new),
        }
    }

    /// By what red, green and blue are multiplied before gamma: 1 in flam3.
    pub(crate) fn channels(&self) -> [f64; 3] {
        self.balancing.map(|balance| balance * WHITE_LEVEL / self.white_level)
    }

    /// The memory that it owns.
    pub(super) fn bytes(&self) -> usize {
        self.curves.as_ref().map_or(0, |curves| curves.bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_two_tones_lies_what_leads_from_one_to_the_other() {
        let (flam3, artist) = (Finish::default(), Finish { contrast: 2.0, ..Finish::jwildfire() });
        assert_eq!(flam3.mixed(&artist, 0.0), flam3);
        assert_eq!(flam3.mixed(&artist, 1.0), artist);
        let middle = flam3.mixed(&artist, 0.5);
        assert_eq!(
            (middle.contrast, middle.white_level, middle.low_density),
            (1.5, f64::midpoint(220.0, WHITE_LEVEL), 0.12)
        );
        let beyond = artist.mixed(&flam3, 4.0);
        assert!(beyond.contrast > 0.0 && beyond.log_gain > 0.0 && beyond.white_level > 0.0, "{beyond:?}");
        assert_eq!(flam3.names(), [""; 0]);
        assert_eq!(artist.names(), ["colours of the palette's nearest entries", "JWildfire's light"]);
        assert_eq!(Finish { log_gain: FRACTORIUM_GAIN, ..Finish::default() }.names(), ["Fractorium's light"]);
    }
}
