//! The frames on either side of joins, as the unit's own decoder shows them.
//!
//! Owns which frames of a clip's ends are decoded, and what is kept of them. The criterion is in `figures.rs`.
//!
//! Start at [`judge`].

use std::path::Path;

use flock::Clip;
use video::{Form, Yuv420p};

use super::figures::{FRAMES, Figures, SquaredDifferences, figures};
use super::view::View;
use crate::decoder::{DecodedFrame, Decoder, Excerpt};

/// Judges how `before` meets each clip of `afters`. One session decodes the end of the first and then the beginnings
/// of the others, as on a unit: it is not drained or opened again in between. A beginning starts at an IDR picture, so the
/// frames before it change no bit of it.
///
/// * Returns the figures in the order of `afters`, or why a clip cannot be shown.
pub(super) fn judge(
    folder: &Path,
    form: &Form,
    before: &Clip,
    afters: &[&Clip],
    decoder: &dyn Decoder,
) -> Vec<Result<Figures, String>> {
    let count = FRAMES as u32;
    let end = before.frames.0;
    let tail = [(before, end.saturating_sub(count)..end)];
    let heads = afters.iter().map(|clip| (*clip, 0..count));
    let mut ends: Vec<ClipEnd> = Vec::new();
    ends.resize_with(afters.len() + 1, ClipEnd::default);
    let excerpts: Vec<Excerpt> = tail.into_iter().chain(heads).collect();
    let results = decoder.play(folder, form, &excerpts, &mut |excerpt, frame| ends[excerpt].add(frame));
    let (last, last_result) = (&ends[0], &results[0]);
    let judge = |(first, result): (&ClipEnd, &Result<(), String>)| {
        last_result.clone().and(result.clone())?;
        let across = last.latest.as_ref().zip(first.first.as_ref()).map_or(0.0, |(a, b)| difference(a, b));
        let inside = last.steps.iter().rev().take(2).chain(first.steps.iter().take(2)).copied().collect();
        Ok(figures(&last.views, &first.views, &SquaredDifferences { across, inside }))
    };
    ends[1..].iter().zip(&results[1..]).map(judge).collect()
}

/// The last two frames of `before` and the first two of `after`, in order; fewer where a clip has one.
pub(super) fn pictures(
    folder: &Path,
    form: &Form,
    before: &Clip,
    after: &Clip,
    decoder: &dyn Decoder,
) -> Result<Vec<Yuv420p>, String> {
    let end = before.frames.0;
    let excerpts = [(before, end.saturating_sub(2)..end), (after, 0..2)];
    let mut pictures = Vec::new();
    let results = decoder.play(folder, form, &excerpts, &mut |_, frame| pictures.push(frame.picture));
    results.into_iter().collect::<Result<(), String>>()?;
    Ok(pictures)
}

/// What the judgement needs of one end of a clip.
#[derive(Default)]
struct ClipEnd {
    views: Vec<View>,
    /// The mean squared difference of each frame and the next.
    steps: Vec<f64>,
    first: Option<Yuv420p>,
    latest: Option<Yuv420p>,
}

impl ClipEnd {
    fn add(&mut self, DecodedFrame { picture, quantiser }: DecodedFrame) {
        self.views.push(View::of(&picture, quantiser));
        if let Some(latest) = &self.latest {
            self.steps.push(difference(latest, &picture));
        } else {
            self.first = Some(picture.clone());
        }
        self.latest = Some(picture);
    }
}

/// The mean squared difference of the luma of two frames of one size.
fn difference(one: &Yuv420p, other: &Yuv420p) -> f64 {
    let (width, height) = (one.size().0 as usize, one.size().1 as usize);
    let row = |(one, other): (&[u8], &[u8])| {
        let squares = one.iter().zip(other).map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2));
        u64::from(squares.sum::<u32>())
    };
    let rows = one.planes()[0].chunks(width).zip(other.planes()[0].chunks(width));
    rows.map(row).sum::<u64>() as f64 / (width * height) as f64
}
