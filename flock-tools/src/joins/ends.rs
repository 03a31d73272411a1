//! The frames on either side of joins, as the unit's own decoder shows them.
//!
//! Owns the sessions that decode the ends of clips. Never judges what comes out: `figures.rs` does.
//!
//! Start at [`meetings`].

use std::num::NonZero;
use std::ops::Range;
use std::path::Path;

use flock::Clip;
use video::{ClipNumber, Form, Frame, Poll, Session, Yuv420p};

use super::figures::{FRAMES, Figures, Squares, figures};
use super::view::View;
use crate::report::chain;

/// Judges how `before` meets each clip of `afters`. One session decodes the end of the first and then the beginnings
/// of the others, as a unit that plays them: nothing is drained or opened anew in between. A beginning starts at an IDR
/// picture, so what stands before it changes no bit of it.
///
/// * Returns the figures in the order of `afters`, or why a clip cannot be shown.
pub(crate) fn meetings(folder: &Path, form: &Form, before: &Clip, afters: &[&Clip]) -> Vec<Result<Figures, String>> {
    let count = FRAMES as u32;
    let end = before.frames.0;
    let tail = [(before, end.saturating_sub(count)..end)];
    let heads = afters.iter().map(|clip| (*clip, 0..count));
    let mut ends: Vec<End> = Vec::new();
    ends.resize_with(afters.len() + 1, End::default);
    let parts: Vec<Part> = tail.into_iter().chain(heads).collect();
    let went = play(folder, form, &parts, |part, frame| ends[part].take(frame));
    let (last, lasted) = (&ends[0], &went[0]);
    let judge = |(first, went): (&End, &Result<(), String>)| {
        lasted.clone().and(went.clone())?;
        let across = last.latest.as_ref().zip(first.first.as_ref()).map_or(0.0, |(a, b)| difference(a, b));
        let inside = last.steps.iter().rev().take(2).chain(first.steps.iter().take(2)).copied().collect();
        Ok(figures(&last.views, &first.views, &Squares { across, inside }))
    };
    ends[1..].iter().zip(&went[1..]).map(judge).collect()
}

/// The last two frames of `before` and the first two of `after`, in order; fewer where a clip has one.
pub(crate) fn pictures(folder: &Path, form: &Form, before: &Clip, after: &Clip) -> Result<Vec<Yuv420p>, String> {
    let end = before.frames.0;
    let parts = [(before, end.saturating_sub(2)..end), (after, 0..2)];
    let mut pictures = Vec::new();
    let went = play(folder, form, &parts, |_, frame| pictures.push(Yuv420p::from(&frame)));
    went.into_iter().collect::<Result<(), String>>()?;
    Ok(pictures)
}

/// Some frames of a clip.
type Part<'a> = (&'a Clip, Range<u32>);

/// What is needed of one end of a clip.
#[derive(Default)]
struct End {
    views: Vec<View>,
    /// The mean squared difference of each frame and the next.
    steps: Vec<f64>,
    first: Option<Frame>,
    latest: Option<Frame>,
}

impl End {
    fn take(&mut self, frame: Frame) {
        self.views.push(View::of(&Yuv420p::from(&frame)));
        if let Some(latest) = &self.latest {
            self.steps.push(difference(latest, &frame));
        } else {
            self.first = Some(frame.clone());
        }
        self.latest = Some(frame);
    }
}

/// Decodes `parts` one after the other in one session, and gives `each` their frames with the number of the part.
/// Returns for every part whether all of it came.
fn play(folder: &Path, form: &Form, parts: &[Part], mut each: impl FnMut(usize, Frame)) -> Vec<Result<(), String>> {
    let mut went: Vec<Result<(), String>> = vec![Err("nothing came out".into()); parts.len()];
    let mut session = match Session::new(NonZero::<usize>::MIN) {
        Ok(session) => session,
        Err(error) => return vec![Err(chain(&error)); parts.len()],
    };
    // Clips that cannot be opened get no number in the session.
    let mut pushed: Vec<usize> = Vec::new();
    let mut waiting = parts.iter().enumerate();
    let part_of = |pushed: &[usize], clip: ClipNumber| usize::try_from(clip.0).ok().map(|clip| pushed[clip]);
    loop {
        match session.poll() {
            Poll::Frame(frame) => {
                if let Some(part) = part_of(&pushed, frame.clip()) {
                    each(part, frame);
                }
            }
            Poll::ClipEnd { clip, damage, .. } => {
                if let Some(part) = part_of(&pushed, clip) {
                    went[part] = damage.first().map_or(Ok(()), |damage| Err(damage.to_string()));
                }
            }
            Poll::Starved => match waiting.next() {
                Some((part, (clip, frames))) => match video::Clip::open(&clip.path.inside(folder), form, clip.frames) {
                    Ok(opened) => {
                        session.push(opened.excerpt(frames.clone()));
                        pushed.push(part);
                    }
                    Err(error) => went[part] = Err(chain(&error)),
                },
                None => session.finish(),
            },
            Poll::Finished => return went,
            Poll::Failed(error) => {
                went.iter_mut().filter(|went| went.is_ok()).for_each(|went| *went = Err(error.to_string()));
                return went;
            }
        }
    }
}

/// The mean squared difference of the luma of two frames of one size.
fn difference(one: &Frame, other: &Frame) -> f64 {
    let (width, height) = (one.size().0 as usize, one.size().1 as usize);
    let rows = |frame: &'_ Frame| frame.strides()[0].max(1);
    let pairs = one.planes()[0].chunks(rows(one)).zip(other.planes()[0].chunks(rows(other))).take(height);
    let row = |(one, other): (&[u8], &[u8])| {
        let squares = one.iter().zip(other).take(width).map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2));
        u64::from(squares.sum::<u32>())
    };
    pairs.map(row).sum::<u64>() as f64 / (width * height).max(1) as f64
}
