//! The form that all clips of a flock have.
//!
//! Owns [`Form`] and the comparison of a probed clip with it. The form lets all clips go through one decoder without a
//! flush. Files are opened by `probe.rs`.
//!
//! Start at [`Probe::differences`].

use crate::probe::Probe;
use std::fmt;
use timing::{FrameCount, Rate};

/// A flock's form: the values that differ between flocks. The rest is the same for all:
///
/// * MP4, one H.264 stream, profile High or one within it (Main, Constrained Baseline), 8-bit 4:2:0, progressive,
///   square pixels;
/// * tagged BT.709 (primaries, transfer, matrix), limited range;
/// * constant frame rate, as many frames as the manifest says;
/// * the first access unit is an IDR picture and carries its parameter sets; they state the reorder depth, so that the
///   decoder need not guess it, which may drop a frame; every GOP is closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Form {
    /// Visible width and height in pixels.
    pub size: (u32, u32),
    /// Frames per second.
    pub fps: Rate,
}

/// One way in which a clip is not in the form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// What differs: `codec`, `size`, `frame rate`, ...
    pub what: &'static str,
    /// The value in the form.
    pub expected: String,
    /// The value of the clip.
    pub found: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is `{}` (expected `{}`)", self.what, self.found, self.expected)
    }
}

/// Differences as one line of text.
pub(crate) fn join_differences(differences: &[Difference]) -> String {
    differences.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

impl Probe {
    /// How the clip differs from `form` and `frames`; empty if it is in the form. For a clip that is not H.264 only the
    /// codec is compared.
    pub fn differences(&self, form: &Form, frames: FrameCount) -> Vec<Difference> {
        if self.codec != "h264" {
            let found = self.codec.clone();
            return vec![Difference { what: "codec", expected: "h264".into(), found }];
        }
        let size = |(width, height): (u32, u32)| format!("{width}x{height}");
        let rate = self.fps.map_or("uneven".into(), |rate| rate.to_string());
        let yes = |is: bool| if is { "yes" } else { "no" }.to_owned();
        let within = ["High", "Main", "Constrained Baseline"].contains(&self.profile.as_str());
        let profile = if within { "High".into() } else { self.profile.clone() };
        let rows: [(&'static str, String, String); 12] = [
            ("size", size(form.size), size(self.size)),
            ("frame rate", form.fps.to_string(), rate),
            ("frame count", frames.to_string(), self.frames.to_string()),
            ("first access unit is IDR", yes(true), yes(self.starts_with_idr)),
            ("parameter sets in band", yes(true), yes(self.parameter_sets_in_band)),
            ("profile", "High".into(), profile),
            ("pixel format", "yuv420p".into(), self.pixel_format.clone()),
            ("colour", COLOUR.into(), self.colour.clone()),
            ("progressive", yes(true), yes(self.progressive)),
            ("square pixels", yes(true), yes(self.square_pixels)),
            ("reorder depth stated", yes(true), yes(self.reorder_told)),
            ("closed GOP", yes(true), yes(self.closed_gop)),
        ];
        // A single frame has no rate of its own: it is shown at the flock's.
        let is_told = |row: &(&str, _, _)| row.0 != "frame rate" || self.frames != FrameCount(1);
        let differs = |(what, expected, found)| (expected != found).then_some(Difference { what, expected, found });
        rows.into_iter().filter(is_told).filter_map(differs).collect()
    }
}

/// The form's colour tags as [`Probe::colour`] spells them.
pub(crate) const COLOUR: &str = "bt709 bt709 bt709 limited";
