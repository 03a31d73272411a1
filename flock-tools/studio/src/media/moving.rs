//! The moving preview of a transition: a small clip that is watched while it grows.
//!
//! Owns its size, rate and samples: every second frame, at most 320 pixels wide, few samples. It is written in fragments, so
//! that the page plays the first second while the rest is drawn: `growing.js` asks for what has come. A preview that is
//! cancelled is begun anew the next time.
//!
//! Start at [`Media::make_moving`].

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ::species::{RenderError, Threads};
use operations::flock_folder::paths;
use operations::program::chain;
use operations::render::plan::Look;
use timing::Rate;
use video::{EncodeError, Encoder, Form, Quality, Tuning, Yuv420p};

use super::between::few_samples;
use super::sources::{PairSource, Source};
use super::stopping::{go_on, with_flag};
use super::{Media, MediaError, picture};
use crate::jobs::Progress;

/// A picture fits into this box.
const BOX: (u32, u32) = (320, 320);
/// Samples of each pixel.
const SAMPLES: f64 = 20.0;
/// So many frames of the transition for each of the preview.
const EVERY: u32 = 2;
/// Frames of a fragment.
const GROUP: NonZero<u32> = NonZero::new(6).expect("it is not 0");
const QUALITY: Quality<'_> =
    Quality { crf: 27.0, preset: "veryfast", tuning: Tuning::Gradients, max_bits_per_second: None };
/// The file, and what ends the name of one that grows.
const FILE: &str = "-moving.mp4";
const GROWING: &str = ".part";

impl Media {
    /// What there is of the moving preview of `key`, from byte `from` on, and whether it is whole; `None` if it is not begun.
    /// Behind the end there are no bytes.
    pub(crate) fn moving(&self, key: &str, from: u64) -> Option<(Vec<u8>, bool)> {
        let path = self.cache.path(key, FILE);
        // It may be finished between two looks, and what was read stays true.
        let growing = || read(&paths::with_suffix(&path, GROWING), from).ok().map(|bytes| (bytes, false));
        let whole = || read(&path, from).ok().map(|bytes| (bytes, true));
        whole().or_else(growing).or_else(whole)
    }

    /// Makes the moving preview of `key`, if it is not there.
    /// Errors: [`MediaError`] if a genome cannot be read or drawn, or the clip cannot be written.
    pub(crate) fn make_moving(&self, key: &str, progress: &Progress) -> Result<PathBuf, MediaError> {
        let source = self.sources.find(key)?;
        let Source::Pair(pair) = &*source else { return Err(MediaError::Unknown { key: key.to_owned() }) };
        self.cache.once(key, FILE, |path| {
            with_flag(progress, |flag| {
                let threads = Threads::new(0).map_err(|error| MediaError::refused(pair.words(), error.to_string()))?;
                draw(pair, path, &threads.with_stop_flag(Arc::clone(flag)), progress)
            })
        })
    }
}

fn draw(pair: &PairSource, path: &Path, threads: &Threads, progress: &Progress) -> Result<(), MediaError> {
    let Form { size, fps } = pair.form;
    let size = picture::fit(size, BOX);
    let slower = Rate::new(fps.num().into(), u64::from(fps.den()) * u64::from(EVERY));
    let slower = slower.map_err(|error| MediaError::refused(pair.words(), error.to_string()))?;
    let plan = pair.plan(size, &Look::of_genomes(pair.form))?;
    let encoding = |error: EncodeError| MediaError::refused(pair.words(), chain(&error));
    let mut encoder = Encoder::create_growing(path, &Form { size, fps: slower }, QUALITY, GROUP).map_err(encoding)?;
    let frames = pair.frames.0.div_ceil(EVERY).max(1);
    for number in 0..frames {
        go_on(progress)?;
        let frame = f64::from(number * EVERY);
        let drawn = plan.motion.frame(frame, &few_samples(size, SAMPLES), threads);
        let image = drawn.map_err(|error: RenderError| pair.refused(&error, progress))?.image;
        let picture = Yuv420p::from_rgb16_dithered(size.0, size.1, &image.to_rgb16());
        encoder
            .push(&picture.map_err(|error| MediaError::refused(pair.words(), error.to_string()))?)
            .map_err(encoding)?;
        progress.set(u64::from(number) + 1, frames.into());
    }
    encoder.finish().map(drop).map_err(encoding)
}

/// The bytes of the file at `path` from byte `from` on.
fn read(path: &Path, from: u64) -> io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    // An offset beyond the largest that the system knows is an error, one behind the end is none.
    file.seek(SeekFrom::Start(from.min(file.metadata()?.len())))?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}
