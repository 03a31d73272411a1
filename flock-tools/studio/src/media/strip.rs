//! The strip and the poster of a sheep.
//!
//! Owns their size and quality, and the two figures that are told of a strip: how much moves, and its colour. A strip has 24
//! pictures of one turn in one JPEG, in 6 columns and 4 rows; the picture after the last one is the first. It is made from
//! the loop if that is there, else from the genome with few samples, on one thread, since many are made at once.
//!
//! Start at [`Media::make_strip`].

use std::fs;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ::species::{Motion, Settings, Threads};
use flame::Backend;
use flock::Clip;
use operations::decoder::thumbnail::Thumbnail;
use operations::portrait::colour::Colour;
use operations::program::{chain, now};
use operations::species;
use serde::{Deserialize, Serialize};
use timing::FrameCount;
use video::{Form, Poll, Session};

use super::sources::Source;
use super::stopping::{go_on, with_flag};
use super::{Media, MediaError, cache, picture};
use crate::jobs::Progress;
use crate::lock::locked;

/// Pictures of a strip, and its columns.
pub(super) const PICTURES: u32 = 24;
const COLUMNS: usize = 6;
/// A picture of a strip fits into this box, and a poster into that.
const BOX: (u32, u32) = (160, 160);
const POSTER: (u32, u32) = (640, 640);
/// The most bytes of a strip, and of a poster.
pub(super) const STRIP_BYTES: usize = 100_000;
const POSTER_BYTES: usize = 120_000;
/// Samples per pixel of pictures with noise, and of others.
const NOISY: f64 = 16.0;
const PLAIN: f64 = 4.0;
/// The same for posters.
const NOISY_POSTER: f64 = 40.0;
/// The names of files.
const STRIP: &str = "-strip.jpg";
const LOOK: &str = "-strip.json";
const POSTER_FILE: &str = "-poster.jpg";

/// What is told of a strip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct StripLook {
    /// The mean change of luma from a picture to the next, 0 to 1.
    pub(super) activity: f64,
    /// `#rrggbb`.
    pub(super) colour: String,
    /// Processor seconds that a sample of the renderer took; `None` of a strip from a clip.
    pub(super) sample_s: Option<f64>,
}

impl Media {
    /// The strip of `key`, if it is made.
    pub(crate) fn find_strip(&self, key: &str) -> Option<PathBuf> {
        self.cache.find(key, STRIP)
    }

    /// How much moves in the strip of `key`, 0 to 1, and its colour, `#rrggbb`; `None` if it is not made.
    pub(crate) fn look(&self, key: &str) -> Option<(f64, String)> {
        self.strip_look(key).map(|look| (look.activity, look.colour))
    }

    /// What is told of the strip of `key`. Each is read once: the page asks for all of them after each edit.
    pub(super) fn strip_look(&self, key: &str) -> Option<StripLook> {
        let known = || locked(&self.looks);
        if let Some(look) = known().get(key) {
            return Some(look.clone());
        }
        let look: StripLook = serde_json::from_slice(&fs::read(self.cache.path(key, LOOK)).ok()?).ok()?;
        known().insert(key.to_owned(), look.clone());
        Some(look)
    }

    /// Makes the strip of `key`, if it is not there.
    /// Errors: [`MediaError`] if nothing can be shown; nothing is then kept.
    pub(crate) fn make_strip(&self, key: &str, progress: &Progress) -> Result<PathBuf, MediaError> {
        let source = self.sources.find(key)?;
        self.cache.once(key, STRIP, |path| {
            let (pictures, sample_s) = self.strip_pictures(&source, progress)?;
            let sheet = picture::sheet(&pictures, COLUMNS);
            let colour = Colour::of_picture(&sheet.rgb).to_string();
            let look = StripLook { activity: activity(&pictures), colour, sample_s };
            let told = serde_json::to_vec(&look).expect("numbers and texts are JSON");
            cache::write(&self.cache.path(key, LOOK), &told)?;
            picture::save(path, &sheet, STRIP_BYTES)
        })
    }

    /// The poster of `key`: the first frame of its loop, at most 640 pixels wide.
    /// Errors: [`MediaError`] if nothing can be shown.
    pub(crate) fn poster(&self, key: &str) -> Result<PathBuf, MediaError> {
        let source = self.sources.find(key)?;
        self.cache.once(key, POSTER_FILE, |path| {
            let (form, genome) = match &*source {
                Source::Clip { clip, form, genome } => {
                    let first = self.frames(clip, form, &[0], picture::fit(form.size, POSTER), &|| Ok(()));
                    match first.map(|mut frames| frames.pop()) {
                        Ok(Some(first)) => return picture::save(path, &first, POSTER_BYTES),
                        other => (form, genome.as_ref().ok_or_else(|| nothing(clip, other.err()))?),
                    }
                }
                Source::Genome { path, form, .. } => (form, path),
                Source::Pair(_) => return Err(MediaError::Unknown { key: key.to_owned() }),
            };
            let threads = Threads::new(0).map_err(|error| MediaError::refused("it", error.to_string()))?;
            let size = picture::fit(form.size, POSTER);
            let motion = turning(genome, size, FrameCount(1))?;
            let drawn = motion.frame(0.0, &settings(size, &*motion, NOISY_POSTER), &threads);
            let drawn = drawn.map_err(|error| MediaError::refused(genome.display().to_string(), error.to_string()))?;
            picture::save(path, &picture::of_image(&drawn.image), POSTER_BYTES)
        })
    }

    /// The pictures of a strip, and the processor seconds of a sample.
    fn strip_pictures(
        &self,
        source: &Source,
        progress: &Progress,
    ) -> Result<(Vec<Thumbnail>, Option<f64>), MediaError> {
        match source {
            Source::Clip { clip, form, genome } => {
                let stops = || go_on(progress);
                let found = self.frames(clip, form, &moments(clip.frames), picture::fit(form.size, BOX), &stops);
                match (found, genome) {
                    (Err(MediaError::Refused { .. }), Some(path)) => drawn_strip(path, clip.frames, form, progress),
                    (found, _) => Ok((found?, None)),
                }
            }
            Source::Genome { path, turn, form } => drawn_strip(path, *turn, form, progress),
            Source::Pair(pair) => Err(MediaError::refused(pair.names[0].to_string(), "it is a transition")),
        }
    }

    /// These frames of a clip, in rising order, as pictures of `size`. The frames between them are decoded only where others
    /// need them.
    fn frames(
        &self,
        clip: &Clip,
        form: &Form,
        wanted: &[u32],
        size: (u32, u32),
        stops: &dyn Fn() -> Result<(), MediaError>,
    ) -> Result<Vec<Thumbnail>, MediaError> {
        let refused = |reason: String| MediaError::refused(clip.path.as_str(), reason);
        let opened = video::Clip::open(&clip.path.inside(&self.folder), form, clip.frames);
        let mut session = Session::new(NonZero::<usize>::MIN).map_err(|error| refused(chain(&error)))?;
        session.push(opened.map_err(|error| refused(chain(&error)))?.selection(wanted));
        session.finish();
        let mut shown = Vec::new();
        loop {
            stops()?;
            match session.poll() {
                Poll::Frame(frame) => shown.extend(picture::of_frame(&frame, size)),
                Poll::ClipEnd { damage, .. } => {
                    if let Some(damage) = damage.first() {
                        return Err(refused(damage.to_string()));
                    }
                }
                Poll::Failed(error) => return Err(refused(error.to_string())),
                Poll::Finished | Poll::Starved => break,
            }
        }
        // Of a short clip some frames are shown more than once.
        let mut distinct = wanted.to_vec();
        distinct.dedup();
        let picture = |frame: &u32| shown.get(distinct.binary_search(frame).ok()?).cloned();
        wanted.iter().map(picture).collect::<Option<_>>().ok_or_else(|| nothing(clip, None))
    }
}

/// The frames of a loop that a strip shows.
fn moments(frames: FrameCount) -> Vec<u32> {
    (0..PICTURES).map(|at| (u64::from(at) * u64::from(frames.0) / u64::from(PICTURES)) as u32).collect()
}

/// A clip of which nothing could be decoded.
fn nothing(clip: &Clip, error: Option<MediaError>) -> MediaError {
    error.unwrap_or_else(|| MediaError::refused(clip.path.as_str(), "frames are missing"))
}

/// The strip of the genome at `path`, and the processor seconds of a sample.
fn drawn_strip(
    path: &Path,
    turn: FrameCount,
    form: &Form,
    progress: &Progress,
) -> Result<(Vec<Thumbnail>, Option<f64>), MediaError> {
    let size = picture::fit(form.size, BOX);
    let motion = turning(path, size, turn)?;
    let settings = settings(size, &*motion, NOISY);
    let refused = |error: &dyn ToString| MediaError::refused(path.display().to_string(), error.to_string());
    with_flag(progress, |flag| {
        let threads = Threads::new(1).map_err(|error| refused(&error))?.with_stop_flag(Arc::clone(flag));
        let (mut pictures, mut samples) = (Vec::new(), 0);
        let begun = threads.run(now::thread_cpu);
        for (number, frame) in moments(turn).into_iter().enumerate() {
            go_on(progress)?;
            let drawn = motion
                .frame(f64::from(frame), &settings, &threads)
                .map_err(|error| if progress.is_cancelled() { MediaError::Cancelled } else { refused(&error) })?;
            samples += drawn.samples;
            pictures.push(picture::of_image(&drawn.image));
            progress.set(number as u64 + 1, PICTURES.into());
        }
        let took = threads.run(now::thread_cpu).saturating_sub(begun).as_secs_f64();
        Ok((pictures, (samples > 0).then(|| took / samples as f64)))
    })
}

/// The loop of the genome at `path`.
pub(super) fn turning(path: &Path, size: (u32, u32), turn: FrameCount) -> Result<Box<dyn Motion>, MediaError> {
    let genome = species::read(path, &Backend::default());
    let genome = genome.map_err(|why| MediaError::refused(path.display().to_string(), why.source.to_string()))?;
    Ok(genome.turning([size.0, size.1], f64::from(turn.0)))
}

/// Settings of a small picture with few samples and without motion blur: `noisy` samples per pixel where there is noise.
pub(super) fn settings(size: (u32, u32), motion: &dyn Motion, noisy: f64) -> Settings {
    Settings {
        size: [size.0, size.1],
        spp: Some(if motion.is_noisy() { noisy } else { PLAIN }),
        psnr: None,
        supersample: Some(1),
        temporal_samples: Some(1),
        smooths: true,
        seed: 1,
    }
}

/// The mean change of luma from a picture to the next one, and from the last to the first; 0 to 1.
fn activity(pictures: &[Thumbnail]) -> f64 {
    let luma = |pixel: &[u8; 3]| {
        let [r, g, b] = pixel.map(f64::from);
        (0.2126 * r + 0.7152 * g + 0.0722 * b) / 255.0
    };
    let change = |(one, next): (&Thumbnail, &Thumbnail)| {
        let pixels = one.rgb.as_chunks().0.iter().zip(next.rgb.as_chunks().0);
        let count = pixels.len().max(1);
        pixels.map(|(a, b)| (luma(a) - luma(b)).abs()).sum::<f64>() / count as f64
    };
    let changes = pictures.iter().zip(pictures.iter().cycle().skip(1)).map(change);
    changes.sum::<f64>() / pictures.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strip_shows_one_turn_at_equal_steps_and_its_first_picture_follows_its_last() {
        assert_eq!(moments(FrameCount(240)), (0..24).map(|at| 10 * at).collect::<Vec<_>>());
        let short = moments(FrameCount(7));
        assert!(short.len() == 24 && short.is_sorted() && short[0] == 0 && short[23] == 6, "{short:?}");
    }

    #[test]
    fn what_changes_more_is_more_active_and_a_still_is_not() {
        let of = |level: u8| Thumbnail { size: (2, 2), rgb: vec![level; 12] };
        assert!(activity(&[of(9), of(9), of(9)]) < 1e-9);
        assert!((activity(&[of(0), of(255)]) - 1.0).abs() < 1e-9);
        assert!((activity(&[of(0), of(51), of(0), of(51)]) - 0.2).abs() < 1e-9);
    }
}
