//! One clip taken in: copied or encoded anew, put in its place, named in the manifest.
//!
//! Owns the order of these steps. A clip lies whole beside its place before the manifest is touched, and the manifest
//! names it as soon as it is in it: whenever the machine stops, the flock is one that was asked for, and the same
//! command goes on.
//!
//! Start at [`Hand::take`].

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use flock::{Clip, ClipHash, Edit, EditError, MAX_FRAMES, Manifest, Sheep, SheepId, Transition};
use indicatif::ProgressBar;
use timing::{FrameCount, Rate};
use video::{EncodeError, Encoder, ForeignVideo, Quality};

use super::fit::Fitting;
use super::plan::{Plan, Wishes, stands};
use crate::clips;
use crate::draft::Draft;
use crate::render::plan::Shows;
use crate::report::{Exit, Fatal, chain};
use crate::save;

/// What takes clips in.
pub(super) struct Hand<'a> {
    pub(super) folder: &'a Path,
    pub(super) wishes: &'a Wishes,
    pub(super) quality: Quality<'static>,
    /// Whether other files in the places of clips are replaced.
    pub(super) force: bool,
    pub(super) stop: &'a AtomicBool,
    /// Counts frames.
    pub(super) bar: &'a ProgressBar,
}

/// What became of a clip.
#[derive(Debug)]
pub(super) enum Took {
    /// It is in the flock, and so are these sheep, which were not and have no loop.
    In { frames: FrameCount, hash: ClipHash, added: Vec<SheepId> },
    /// The run was stopped.
    Interrupted,
    /// It is not fit; why.
    LeftOut(String),
    /// Somebody else has taken it in meanwhile.
    Stands,
}

/// What the machine would not do.
#[derive(Debug, thiserror::Error)]
enum Stuck {
    #[error("cannot encode `{from}`")]
    Encode { from: PathBuf, source: EncodeError },
    #[error("`{to}`, made from `{from}`, is not as it was meant: {why}")]
    Meaning { from: PathBuf, to: PathBuf, why: String },
    #[error("cannot write `{path}`")]
    Write { path: PathBuf, source: io::Error },
}

/// Why there is no new clip.
enum Unmade {
    Interrupted,
    LeftOut(String),
    Stuck(Fatal),
}

impl Hand<'_> {
    /// Takes in the clip of `plan`.
    ///
    /// # Errors
    /// What would stop every other clip, too: a disk that is full, a manifest that cannot be read. What was taken in
    /// before stays.
    pub(super) fn take(&self, plan: &Plan) -> Result<Took, Fatal> {
        let place = plan.path.inside(self.folder);
        let parent = place.parent().unwrap_or(self.folder);
        fs::create_dir_all(parent).map_err(|source| cannot(parent, source))?;
        let new = New(with_suffix(&place, ".new"));
        let made = match &plan.encode {
            None => self.copy(plan, &new.0),
            Some(fitting) => self.encode(plan, fitting, &new.0),
        };
        match made {
            Ok(frames) => {
                let hash = File::open(&new.0).and_then(ClipHash::of).map_err(|source| cannot(&new.0, source))?;
                self.settle(plan, &new, frames, hash)
            }
            Err(Unmade::Interrupted) => Ok(Took::Interrupted),
            Err(Unmade::LeftOut(why)) => Ok(Took::LeftOut(why)),
            Err(Unmade::Stuck(fatal)) => Err(fatal),
        }
    }

    /// Copies a clip that is in the form, if it decodes cleanly.
    fn copy(&self, plan: &Plan, new: &Path) -> Result<FrameCount, Unmade> {
        let frames = clips::frames(&plan.source, &self.wishes.form).map_err(Unmade::LeftOut)?;
        save::copy(&plan.source, new).map_err(|source| Unmade::Stuck(cannot(new, source)))?;
        self.bar.inc(u64::from(frames.0));
        Ok(frames)
    }

    /// Encodes a clip that is not.
    fn encode(&self, plan: &Plan, fitting: &Fitting, new: &Path) -> Result<FrameCount, Unmade> {
        let stuck =
            |source| Unmade::Stuck(Fatal::new(Exit::Unreadable, Stuck::Encode { from: plan.source.clone(), source }));
        let mut foreign = ForeignVideo::open(&plan.source).map_err(|error| Unmade::LeftOut(chain(&error)))?;
        let form = &self.wishes.form;
        let mut encoder = Encoder::create_tagged(new, form, self.quality, &plan.about.tags).map_err(stuck)?;
        let (mut number, mut frames) = (0u32, 0u32);
        while let Some(picture) = foreign.picture().map_err(|error| Unmade::LeftOut(chain(&error)))? {
            if self.stop.load(Ordering::Relaxed) {
                return Err(Unmade::Interrupted);
            }
            let times = self.wishes.fps.map_or(1, |fps| times(number, fps, form.fps));
            if times > 0 {
                let picture = fitting.picture(&picture).map_err(Unmade::LeftOut)?;
                for _ in 0..times {
                    encoder.push(&picture).map_err(stuck)?;
                }
            }
            (number, frames) = (number + 1, frames + times);
            if frames > MAX_FRAMES {
                return Err(Unmade::LeftOut(format!("has too many frames (expected at most {MAX_FRAMES})")));
            }
            self.bar.inc(1);
        }
        if frames == 0 {
            return Err(Unmade::LeftOut("would have no frames at this rate".to_owned()));
        }
        encoder.finish().map_err(stuck)?;
        // With the unit's own decoder, as whatever comes into a flock.
        let why = match clips::frames(new, form) {
            Ok(found) if found == FrameCount(frames) => return Ok(found),
            Ok(found) => format!("it yields {found} frames (expected {frames})"),
            Err(why) => format!("it {why}"),
        };
        let meaning = Stuck::Meaning { from: plan.source.clone(), to: new.to_owned(), why };
        Err(Unmade::Stuck(Fatal::new(Exit::Unreadable, meaning)))
    }

    /// Gives the finished clip its name, and names it in the manifest.
    fn settle(&self, plan: &Plan, new: &New, frames: FrameCount, hash: ClipHash) -> Result<Took, Fatal> {
        let mut draft = Draft::take(self.folder)?;
        let manifest = draft.edit.manifest();
        // As it is now: somebody may have worked on the flock meanwhile.
        if stands(manifest, &plan.shows).is_some_and(|path| path.inside(self.folder).exists()) {
            return Ok(Took::Stands);
        }
        let place = plan.path.inside(self.folder);
        if place.exists() {
            let named = manifest.clips().any(|clip| clip.path == plan.path);
            // What a run that was killed in just this moment left.
            let same = File::open(&place).and_then(ClipHash::of).is_ok_and(|found| found == hash);
            if !same && (named || !self.force || !place.is_file()) {
                let hint = if named { "which the flock names for something else" } else { "--force replaces it" };
                return Ok(Took::LeftOut(format!("another file is in its place, `{}`; {hint}", plan.path)));
            }
        }
        let clip = Clip { path: plan.path.clone(), frames, hash: Some(hash) };
        let added = name(&mut draft.edit, &plan.shows, clip).map_err(|error| Fatal::new(Exit::Malformed, error))?;
        fs::rename(&new.0, &place).and_then(|()| save::names(&place)).map_err(|source| cannot(&place, source))?;
        draft.save()?;
        Ok(Took::In { frames, hash, added })
    }
}

/// A file that is on its way to its name, removed unless it got there.
struct New(PathBuf);

impl Drop for New {
    fn drop(&mut self) {
        // Gone where it has its name; of no use where it has not.
        let _ = fs::remove_file(&self.0);
    }
}

/// Names `clip` in the manifest as what shows `shows`, with the sheep that it needs. Answers which were added without
/// a loop.
fn name(edit: &mut Edit, shows: &Shows, clip: Clip) -> Result<Vec<SheepId>, EditError> {
    let is_there = |manifest: &Manifest, id: &SheepId| manifest.sheep.iter().any(|sheep| sheep.id == *id);
    match shows {
        Shows::Loop(id) if is_there(edit.manifest(), id) => edit.set_loop(id, clip)?,
        Shows::Loop(id) => edit.add_sheep(sheep(id, Some(clip)))?,
        Shows::Transition(from, to) => {
            let missing: Vec<&SheepId> = [from, to].into_iter().filter(|id| !is_there(edit.manifest(), id)).collect();
            for id in &missing {
                edit.add_sheep(sheep(id, None))?;
            }
            if stands(edit.manifest(), shows).is_some() {
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

/// How many frames of a flock of `to` frames a second show frame `number` of a clip of `from`: those whose moments lie
/// between its own and its successor's.
fn times(number: u32, from: Rate, to: Rate) -> u32 {
    let up = u128::from(to.num()) * u128::from(from.den());
    let down = u128::from(to.den()) * u128::from(from.num());
    let first = |number: u128| (number * up).div_ceil(down);
    let number = u128::from(number);
    u32::try_from(first(number + 1) - first(number)).unwrap_or(u32::MAX)
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

fn cannot(path: &Path, source: io::Error) -> Fatal {
    Fatal::new(Exit::Unreadable, Stuck::Write { path: path.to_owned(), source })
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
