//! The unit's own decoder, which is ffmpeg's.
//!
//! Owns the one implementation of [`Decoder`]. Never judges what comes out.

use std::num::NonZero;
use std::path::Path;

use timing::FrameCount;
use video::{ClipNumber, Form, Poll, Probe, ProbeError, Session, Yuv420p};

use super::{DecodedFrame, Decoder, Excerpt};
use crate::program::chain;

/// ffmpeg, linked into this program.
pub struct Ffmpeg;

impl Decoder for Ffmpeg {
    fn probe(&self, path: &Path) -> Result<Probe, ProbeError> {
        video::probe(path)
    }

    /// One thread each: the clips are many.
    fn decode(&self, path: &Path) -> Result<FrameCount, String> {
        video::decode_whole(path, NonZero::<usize>::MIN).map_err(|damage| damage.to_string())
    }

    fn play(
        &self,
        folder: &Path,
        form: &Form,
        excerpts: &[Excerpt],
        each: &mut dyn FnMut(usize, DecodedFrame),
    ) -> Vec<Result<(), String>> {
        let mut results: Vec<Result<(), String>> = vec![Err("nothing came out".into()); excerpts.len()];
        let mut session = match Session::with_quantisers(NonZero::<usize>::MIN) {
            Ok(session) => session,
            Err(error) => return vec![Err(chain(&error)); excerpts.len()],
        };
        // Clips that cannot be opened get no number in the session.
        let mut pushed: Vec<usize> = Vec::new();
        let mut waiting = excerpts.iter().enumerate();
        let index = |pushed: &[usize], clip: ClipNumber| usize::try_from(clip.0).ok().map(|clip| pushed[clip]);
        loop {
            match session.poll() {
                Poll::Frame(frame) => {
                    if let Some(excerpt) = index(&pushed, frame.clip()) {
                        each(excerpt, DecodedFrame { picture: Yuv420p::from(&frame), quantiser: frame.quantiser() });
                    }
                }
                Poll::ClipEnd { clip, damage, .. } => {
                    if let Some(excerpt) = index(&pushed, clip) {
                        results[excerpt] = damage.first().map_or(Ok(()), |damage| Err(damage.to_string()));
                    }
                }
                Poll::Starved => match waiting.next() {
                    Some((excerpt, (clip, frames))) => {
                        match video::Clip::open(&clip.path.inside(folder), form, clip.frames) {
                            Ok(opened) => {
                                session.push(opened.excerpt(frames.clone()));
                                pushed.push(excerpt);
                            }
                            Err(error) => results[excerpt] = Err(chain(&error)),
                        }
                    }
                    None => session.finish(),
                },
                Poll::Finished => return results,
                Poll::Failed(error) => {
                    results.iter_mut().filter(|result| result.is_ok()).for_each(|r| *r = Err(error.to_string()));
                    return results;
                }
            }
        }
    }
}
