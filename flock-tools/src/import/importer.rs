//! The import of one clip: copied or encoded, moved to its place, added to the manifest.
//!
//! Owns the order of these steps. A clip is complete in a temporary file before the manifest is changed, and the manifest
//! names it as soon as it is in its place. Whenever the machine stops, the flock is sound, and the same command continues.
//!
//! Start at [`Importer::import`].

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use flock::{Clip, ClipHash, Edit, EditError, MAX_FRAMES, Manifest, Sheep, SheepId, Transition};
use indicatif::ProgressBar;
use timing::{FrameCount, Rate};
use video::{EncodeError, Encoder, ForeignVideo, Quality};

use super::plan::{ImportSettings, Plan, existing_path};
use super::scaling::Scaling;
use crate::check::clips;
use crate::decoder::Decoder;
use crate::flock_folder::{Draft, paths};
use crate::program::{Exit, Fatal, chain};
use crate::render::plan::ClipRole;

/// Imports the clips of one run.
pub(super) struct Importer<'a> {
    pub(super) settings: &'a ImportSettings<'a>,
    pub(super) quality: Quality<'static>,
    /// Whether other files in the places of clips are replaced.
    pub(super) force: bool,
    pub(super) stop: &'a AtomicBool,
    pub(super) decoder: &'a dyn Decoder,
    /// Counts frames.
    pub(super) bar: &'a ProgressBar,
}

/// What the import did with a clip.
#[derive(Debug)]
pub(super) enum Outcome {
    /// It is in the flock now. These sheep were added for it, without loops.
    Imported { frames: FrameCount, hash: ClipHash, added: Vec<SheepId> },
    /// The run was stopped.
    Interrupted,
    /// It cannot be imported; why.
    Skipped(String),
    /// Another command has added it meanwhile.
    AlreadyThere,
}

/// Why the import of all clips ends.
#[derive(Debug, thiserror::Error)]
enum ImportError {
    #[error("cannot encode `{from}`")]
    Encode { from: PathBuf, source: EncodeError },
    #[error("`{to}`, encoded from `{from}`, is not as expected: {why}")]
    Unexpected { from: PathBuf, to: PathBuf, why: String },
}

/// Why there is no new clip.
enum Failure {
    Interrupted,
    Skipped(String),
    Fatal(Fatal),
}

impl Importer<'_> {
    /// Imports the clip of `plan`.
    /// Errors: Those that concern every other clip, too: a disk that is full, a manifest that cannot be read. Clips that were
    /// imported before stay.
    pub(super) fn import(&self, plan: &Plan) -> Result<Outcome, Fatal> {
        let place = plan.path.inside(self.settings.folder);
        let parent = place.parent().unwrap_or(self.settings.folder);
        fs::create_dir_all(parent).map_err(|source| Fatal::write(parent, source))?;
        let new = TemporaryFile(paths::with_suffix(&place, ".new"));
        let made = match &plan.encode {
            None => self.copy(plan, &new.0),
            Some(scaling) => self.encode(plan, scaling, &new.0),
        };
        match made {
            Ok(frames) => {
                let hash = File::open(&new.0).and_then(ClipHash::of).map_err(|source| Fatal::write(&new.0, source))?;
                self.add(plan, &new, frames, hash)
            }
            Err(Failure::Interrupted) => Ok(Outcome::Interrupted),
            Err(Failure::Skipped(why)) => Ok(Outcome::Skipped(why)),
            Err(Failure::Fatal(fatal)) => Err(fatal),
        }
    }

    /// Copies a clip that has the flock's form, if it decodes cleanly.
    fn copy(&self, plan: &Plan, new: &Path) -> Result<FrameCount, Failure> {
        let frames = clips::frames(&plan.source, &self.settings.form, self.decoder).map_err(Failure::Skipped)?;
        durable::copy(&plan.source, new).map_err(|source| Failure::Fatal(Fatal::write(new, source)))?;
        self.bar.inc(u64::from(frames.0));
        Ok(frames)
    }

    /// Encodes a clip that has another form.
    fn encode(&self, plan: &Plan, scaling: &Scaling, new: &Path) -> Result<FrameCount, Failure> {
        let import_fatal = |source| {
            Failure::Fatal(Fatal::new(Exit::Unreadable, ImportError::Encode { from: plan.source.clone(), source }))
        };
        let mut foreign = ForeignVideo::open(&plan.source).map_err(|error| Failure::Skipped(chain(&error)))?;
        let form = &self.settings.form;
        let mut encoder = Encoder::create_tagged(new, form, self.quality, &plan.about.tags).map_err(import_fatal)?;
        let (mut number, mut frames) = (0u32, 0u32);
        while let Some(picture) = foreign.picture().map_err(|error| Failure::Skipped(chain(&error)))? {
            if self.stop.load(Ordering::Relaxed) {
                return Err(Failure::Interrupted);
            }
            let times = self.settings.fps.map_or(1, |fps| times(number, fps, form.fps));
            if times > 0 {
                let picture = scaling.picture(&picture).map_err(Failure::Skipped)?;
                for _ in 0..times {
                    encoder.push(&picture).map_err(import_fatal)?;
                }
            }
            (number, frames) = (number + 1, frames + times);
            if frames > MAX_FRAMES {
                return Err(Failure::Skipped(format!("has too many frames (expected at most {MAX_FRAMES})")));
            }
            self.bar.inc(1);
        }
        if frames == 0 {
            return Err(Failure::Skipped("would have no frames at this rate".to_owned()));
        }
        encoder.finish().map_err(import_fatal)?;
        // Checked with the unit's own decoder, as all clips of a flock.
        let why = match clips::frames(new, form, self.decoder) {
            Ok(found) if found == FrameCount(frames) => return Ok(found),
            Ok(found) => format!("it yields {found} frames (expected {frames})"),
            Err(why) => format!("it {why}"),
        };
        let error = ImportError::Unexpected { from: plan.source.clone(), to: new.to_owned(), why };
        Err(Failure::Fatal(Fatal::new(Exit::Unreadable, error)))
    }

    /// Moves the finished clip to its place, and adds it to the manifest.
    fn add(&self, plan: &Plan, new: &TemporaryFile, frames: FrameCount, hash: ClipHash) -> Result<Outcome, Fatal> {
        let mut draft = Draft::lock(self.settings.folder)?;
        let manifest = draft.edit.manifest();
        // Read again: another command may have changed the flock meanwhile.
        if existing_path(manifest, &plan.role).is_some_and(|path| path.inside(self.settings.folder).exists()) {
            return Ok(Outcome::AlreadyThere);
        }
        let place = plan.path.inside(self.settings.folder);
        if place.exists() {
            let named = manifest.clips().any(|clip| clip.path == plan.path);
            // A run that was killed between the rename and the save left it.
            let same = File::open(&place).and_then(ClipHash::of).is_ok_and(|found| found == hash);
            if !same && (named || !self.force || !place.is_file()) {
                let hint = if named { "which the flock uses for something else" } else { "--force replaces it" };
                return Ok(Outcome::Skipped(format!("another file is in its place, `{}`; {hint}", plan.path)));
            }
        }
        let clip = Clip { path: plan.path.clone(), frames, hash: Some(hash) };
        let added =
            add_to_manifest(&mut draft.edit, &plan.role, clip).map_err(|error| Fatal::new(Exit::Malformed, error))?;
        durable::persist(&new.0, &place).map_err(|source| Fatal::write(&place, source))?;
        draft.save()?;
        Ok(Outcome::Imported { frames, hash, added })
    }
}

/// A clip that is not complete yet; removed when it is dropped.
struct TemporaryFile(PathBuf);

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        // After the rename there is nothing to remove.
        let _ = fs::remove_file(&self.0);
    }
}

/// Adds `clip` to the manifest as `role`, with the sheep that it needs. Returns those that were added without a loop.
fn add_to_manifest(edit: &mut Edit, role: &ClipRole, clip: Clip) -> Result<Vec<SheepId>, EditError> {
    let is_there = |manifest: &Manifest, id: &SheepId| manifest.sheep.iter().any(|sheep| sheep.id == *id);
    match role {
        ClipRole::Loop(id) if is_there(edit.manifest(), id) => edit.set_loop(id, clip)?,
        ClipRole::Loop(id) => edit.add_sheep(sheep(id, Some(clip)))?,
        ClipRole::Transition(from, to) => {
            let missing: Vec<&SheepId> = [from, to].into_iter().filter(|id| !is_there(edit.manifest(), id)).collect();
            for id in &missing {
                edit.add_sheep(sheep(id, None))?;
            }
            if existing_path(edit.manifest(), role).is_some() {
                edit.set_transition_clip(from, to, clip)?;
            } else {
                edit.add_transition(Transition { from: from.clone(), to: to.clone(), clip, weight: 1.0 })?;
            }
            return Ok(missing.into_iter().cloned().collect());
        }
    }
    Ok(Vec::new())
}

fn sheep(id: &SheepId, clip: Option<Clip>) -> Sheep {
    Sheep { id: id.clone(), clip, genome: None, want: 1.0, repeat: 1 }
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
