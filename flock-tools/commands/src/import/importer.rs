//! The making of one clip: copied or encoded beside its place, and checked.
//!
//! Owns what is done with a file, and which of several files is taken: the first that is sound. Never touches the manifest:
//! `commit.rs` does.
//!
//! Start at [`Importer::make`].

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use flock::{ClipHash, MAX_FRAMES};
use indicatif::ProgressBar;
use operations::check::clips;
use operations::decoder::Decoder;
use operations::flock_folder::paths;
use operations::program::{chain, print};
use timing::{FrameCount, Rate};
use video::{EncodeError, Encoder, ForeignVideo, Quality};

use super::SkippedFile;
use super::plan::{ClipPlan, FilePlan, ImportSettings};
use super::scaling::Scaling;
use super::sources::doubled;

/// Makes the clips of one run.
pub(super) struct Importer<'a> {
    pub(super) settings: &'a ImportSettings<'a>,
    pub(super) quality: Quality<'static>,
    pub(super) stop: &'a AtomicBool,
    pub(super) decoder: &'a dyn Decoder,
    /// Counts frames.
    pub(super) bar: &'a ProgressBar,
}

/// What became of a clip.
pub(super) struct Made {
    /// The clip, if one of its files was sound.
    pub(super) clip: Option<MadeClip>,
    /// The files that were not taken.
    pub(super) skipped: Vec<SkippedFile>,
}

/// A clip beside its place.
pub(super) struct MadeClip {
    /// The index of the file that it comes from.
    pub(super) file: usize,
    pub(super) new: TemporaryFile,
    pub(super) frames: FrameCount,
    pub(super) hash: ClipHash,
}

/// A clip that is not in its place yet; removed when it is dropped.
pub(super) struct TemporaryFile(pub(super) PathBuf);

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        // After the rename there is nothing to remove.
        let _ = fs::remove_file(&self.0);
    }
}

/// Why the making of all clips ends.
#[derive(Debug, thiserror::Error)]
pub(super) enum MakeError {
    #[error("cannot encode `{from}`")]
    Encode { from: String, source: EncodeError },
    #[error("cannot write `{path}`")]
    Write { path: PathBuf, source: io::Error },
}

/// Why there is no new clip.
pub(super) enum Failure {
    Interrupted,
    Skipped(String),
    Broken(MakeError),
}

impl Importer<'_> {
    /// Makes the clip of `plan`; `None` if the run was stopped.
    /// Errors: Those that concern every other clip, too: a disk that is full.
    pub(super) fn make(&self, plan: &ClipPlan) -> Result<Option<Made>, MakeError> {
        let place = plan.path.inside(self.settings.folder);
        let parent = place.parent().unwrap_or(self.settings.folder);
        let write = |path: &Path, source| MakeError::Write { path: path.to_owned(), source };
        fs::create_dir_all(parent).map_err(|source| write(parent, source))?;
        let mut made = Made { clip: None, skipped: Vec::new() };
        for (at, file) in plan.files.iter().enumerate() {
            if let Some(clip) = &made.clip {
                made.skipped.push(doubled(&plan.role, &plan.files[clip.file].source, &file.source));
                continue;
            }
            let new = TemporaryFile(paths::with_suffix(&place, ".new"));
            match self.make_from(file, &new.0) {
                Ok(frames) => {
                    let hash = File::open(&new.0).and_then(ClipHash::of).map_err(|source| write(&new.0, source))?;
                    made.clip = Some(MadeClip { file: at, new, frames, hash });
                }
                Err(Failure::Skipped(reason)) => {
                    made.skipped.push(SkippedFile::new(&file.source, reason));
                }
                Err(Failure::Interrupted) => return Ok(None),
                Err(Failure::Broken(error)) => return Err(error),
            }
        }
        Ok(Some(made))
    }

    /// Makes the clip `new` from `file`.
    fn make_from(&self, file: &FilePlan, new: &Path) -> Result<FrameCount, Failure> {
        match &file.encode {
            None => self.copy(&file.source, new),
            Some(scaling) => self.encode(file, scaling, new, MAX_FRAMES + 1),
        }
    }

    /// Copies a clip that has the flock's form, if it decodes cleanly.
    fn copy(&self, source: &Path, new: &Path) -> Result<FrameCount, Failure> {
        let frames = clips::frames(source, &self.settings.form, self.decoder).map_err(Failure::Skipped)?;
        let mut from = File::open(source).map_err(|error| Failure::Skipped(format!("cannot be read: {error}")))?;
        let copied = File::create(new).and_then(|mut to| io::copy(&mut from, &mut to));
        copied.map_err(|source| Failure::Broken(MakeError::Write { path: new.to_owned(), source }))?;
        self.bar.inc(u64::from(frames.0));
        Ok(frames)
    }

    /// Encodes a clip that has another form: its first `most` frames, or all of them.
    pub(super) fn encode(
        &self,
        file: &FilePlan,
        scaling: &Scaling,
        new: &Path,
        most: u32,
    ) -> Result<FrameCount, Failure> {
        let broken = |source| Failure::Broken(MakeError::Encode { from: print::path(&file.source), source });
        let foreign = ForeignVideo::open(&file.source).map_err(|error| Failure::Skipped(chain(&error)))?;
        let mut foreign = foreign.with_matrix(file.matrix);
        let form = &self.settings.form;
        let mut encoder = Encoder::create_tagged(new, form, self.quality, &file.about.tags).map_err(broken)?;
        let (mut number, mut frames) = (0u32, 0u32);
        while frames < most
            && let Some(picture) = foreign.picture().map_err(|error| Failure::Skipped(chain(&error)))?
        {
            if self.stop.load(Ordering::Relaxed) {
                return Err(Failure::Interrupted);
            }
            let times = file.pace.map_or(1, |pace| times(number, pace, form.fps));
            (number, frames) = (number + 1, frames.saturating_add(times));
            if frames > MAX_FRAMES {
                return Err(Failure::Skipped(format!("has too many frames (expected at most {MAX_FRAMES})")));
            }
            if times > 0 {
                let picture = scaling.picture(&picture).map_err(Failure::Skipped)?;
                for _ in 0..times {
                    encoder.push(&picture).map_err(broken)?;
                }
            }
            self.bar.inc(1);
        }
        if frames == 0 {
            return Err(Failure::Skipped("would have no frames at this rate".to_owned()));
        }
        encoder.finish_unsynced().map_err(broken)?;
        // Checked with the unit's own decoder, as all clips of a flock.
        match clips::frames(new, form, self.decoder) {
            Ok(found) if found == FrameCount(frames) => Ok(found),
            Ok(found) => {
                Err(Failure::Skipped(format!("cannot be encoded: the copy yields {found} frames (expected {frames})")))
            }
            Err(why) => Err(Failure::Skipped(format!("cannot be encoded: the copy {why}"))),
        }
    }
}

/// The number of frames, at `to` frames a second, that show frame `number` of a clip of `from`: those whose times are
/// between its own and that of the next frame.
fn times(number: u32, from: Rate, to: Rate) -> u32 {
    let up = u128::from(to.num()) * u128::from(from.den());
    let down = u128::from(to.den()) * u128::from(from.num());
    let first = |number: u128| (number * up).div_ceil(down);
    let number = u128::from(number);
    u32::try_from(first(number + 1) - first(number)).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::times;
    use timing::Rate;

    fn rate(num: u64, den: u64) -> Rate {
        Rate::new(num, den).unwrap()
    }

    #[test]
    fn frames_are_shown_as_often_as_their_moments_take() {
        let counts = |from, to| (0..6).map(|number| times(number, from, to)).collect::<Vec<_>>();
        assert_eq!(counts(rate(30, 1), rate(30, 1)), [1; 6]);
        assert_eq!(counts(rate(15, 1), rate(30, 1)), [2; 6]);
        assert_eq!(counts(rate(60, 1), rate(30, 1)), [1, 0, 1, 0, 1, 0]);
        assert_eq!(counts(rate(20, 1), rate(30, 1)), [2, 1, 2, 1, 2, 1]);
        for (from, to) in [(rate(24_000, 1001), rate(30, 1)), (rate(23, 1), rate(60, 1)), (rate(240, 1), rate(1, 1))] {
            let seconds = 1001;
            let frames = from.num() / from.den() * seconds;
            let shown: u32 = (0..frames).map(|number| times(number, from, to)).sum();
            let due = f64::from(frames) * f64::from(from.den()) / f64::from(from.num()) * f64::from(to.num());
            assert!((f64::from(shown) - due).abs() <= 1.0, "{shown} of {due}");
        }
    }
}
