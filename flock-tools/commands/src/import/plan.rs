//! What is to be done with each clip.
//!
//! Owns the cheap checks of a clip: its header, its shape, its pace, whether the flock has it. Never decodes a picture and
//! never writes: `importer.rs` does.
//!
//! Start at [`Planner::plan`].

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use flock::{ClipPath, MAX_FPS, Manifest};
use operations::flock_folder::paths;
use operations::program::chain;
use operations::render::plan::ClipRole;
use timing::Rate;
use video::{ForeignVideo, Form, Matrix, MatrixRule, Orientation, VideoInfo};

use super::SkippedFile;
use super::file_kind::Origin;
use super::scaling::{Fit, Scaling};
use super::sources::{SourceClip, SourceFile, doubled};
use crate::arguments;

/// Rates that differ by less than this part of them are the same: containers round times.
const SAME_PACE: f64 = 1.0 / 2000.0;

/// How fast clips are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pace {
    /// Every frame becomes one frame.
    FrameForFrame,
    /// As of so many frames a second.
    Of(Rate),
    /// As each file tells.
    AsTold,
}

impl Pace {
    /// `as-told`, or a rate.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        match text {
            "as-told" => Ok(Self::AsTold),
            rate => arguments::rate(rate).map(Self::Of).map_err(|wanted| format!("{wanted}, or as-told")),
        }
    }
}

/// A colour matrix, as the command line names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum NamedMatrix {
    /// That of standard definition, and of Electric Sheep
    Bt601,
    /// That of high definition
    Bt709,
}

impl From<NamedMatrix> for Matrix {
    fn from(named: NamedMatrix) -> Self {
        match named {
            NamedMatrix::Bt601 => Self::Bt601,
            NamedMatrix::Bt709 => Self::Bt709,
        }
    }
}

/// Why the colours of a clip are read by a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum MatrixBy {
    /// Its file says so.
    File,
    /// The option `--matrix` says so.
    Option,
    /// Electric Sheep made it, whose renderers used this one and did not say so.
    Origin,
    /// Players assume it of this size.
    Size,
}

/// The options of an import.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImportSettings<'a> {
    /// The folder of the flock.
    pub(super) folder: &'a Path,
    pub(super) form: Form,
    pub(super) fit: Option<Fit>,
    pub(super) pace: Pace,
    pub(super) matrix: Option<NamedMatrix>,
    /// Whether clips that the flock has are replaced, and other files in their places.
    pub(super) force: bool,
}

/// A clip to import.
#[derive(Clone, Debug)]
pub(super) struct ClipPlan {
    pub(super) role: ClipRole,
    /// Its path in the flock.
    pub(super) path: ClipPath,
    /// Whether the flock has one already.
    pub(super) replaces: bool,
    /// The files that show it, at least one; the first that is sound is taken.
    pub(super) files: Vec<FilePlan>,
}

/// A file that a clip may come from.
#[derive(Clone, Debug)]
pub(super) struct FilePlan {
    pub(super) source: PathBuf,
    pub(super) about: VideoInfo,
    /// `None` if it has the flock's form: its bytes are copied.
    pub(super) encode: Option<Scaling>,
    /// Frames in a second of it; `None`: every frame becomes one frame.
    pub(super) pace: Option<Rate>,
    pub(super) matrix: MatrixRule,
    /// The name of the matrix, and why it is that one.
    pub(super) colours: (&'static str, MatrixBy),
}

/// What is to be done with a clip.
pub(super) enum PlanResult {
    /// It is to be imported.
    Planned(ClipPlan),
    /// None of its files can be read.
    Skipped,
    /// The flock has it.
    AlreadyThere { source: PathBuf, role: ClipRole, path: ClipPath },
}

/// Plans clips for one flock.
pub(super) struct Planner<'a> {
    settings: &'a ImportSettings<'a>,
    /// The paths of the clips in the manifest, and how many clips have each.
    there: HashMap<ClipRole, &'a ClipPath>,
    uses: HashMap<&'a ClipPath, usize>,
}

impl<'a> Planner<'a> {
    /// A planner for the flock of `manifest`.
    pub(super) fn new(manifest: &'a Manifest, settings: &'a ImportSettings<'a>) -> Self {
        let loops = manifest.sheep.iter();
        let loops = loops.filter_map(|sheep| Some((ClipRole::Loop(sheep.id.clone()), &sheep.clip.as_ref()?.path)));
        let transitions = manifest.transitions.iter();
        let transitions = transitions.map(|t| (ClipRole::Transition(t.from.clone(), t.to.clone()), &t.clip.path));
        let there: HashMap<ClipRole, &ClipPath> = loops.chain(transitions).collect();
        let mut uses = HashMap::new();
        for path in there.values() {
            *uses.entry(*path).or_default() += 1;
        }
        Self { settings, there, uses }
    }

    /// The plan of `clip`, and which of its files are skipped.
    pub(super) fn plan(&self, clip: &SourceClip) -> (PlanResult, Vec<SkippedFile>) {
        let existing = self.there.get(&clip.role).filter(|path| path.inside(self.settings.folder).exists());
        let role = clip.role.clone();
        if let Some(path) = existing.filter(|_| !self.settings.force) {
            let source = clip.files[0].path.clone();
            let skipped = clip.files[1..].iter().map(|file| doubled(&role, &source, &file.path)).collect();
            return (PlanResult::AlreadyThere { source, role, path: (*path).clone() }, skipped);
        }
        let (mut files, mut skipped) = (Vec::new(), Vec::new());
        for file in &clip.files {
            match self.file(file) {
                Ok(plan) => files.push(plan),
                Err(reason) => skipped.push(SkippedFile::new(&file.path, reason)),
            }
        }
        if files.is_empty() {
            return (PlanResult::Skipped, skipped);
        }
        let own = existing.filter(|path| self.uses.get(**path) == Some(&1));
        let path = own.map_or_else(|| place(&role), |path| (*path).clone());
        (PlanResult::Planned(ClipPlan { role, path, replaces: existing.is_some(), files }), skipped)
    }

    /// The plan of one file.
    /// Errors: Why it cannot be imported.
    fn file(&self, file: &SourceFile) -> Result<FilePlan, String> {
        let ImportSettings { form, fit, matrix, pace, .. } = *self.settings;
        let foreign = ForeignVideo::open(&file.path).map_err(|error| chain(&error))?;
        let about = foreign.info().clone();
        let is_electric = file.origin == Origin::ElectricSheep;
        let untagged = if is_electric { Matrix::Bt601 } else { Matrix::by_size(about.stored_size()) };
        let (rule, by) = match (matrix, about.matrix, file.origin) {
            (Some(matrix), _, _) => (MatrixRule::Always(matrix.into()), MatrixBy::Option),
            (None, Some(_), _) => (MatrixRule::Untagged(untagged), MatrixBy::File),
            (None, None, Origin::ElectricSheep) => (MatrixRule::Untagged(untagged), MatrixBy::Origin),
            (None, None, Origin::Unknown) => (MatrixRule::Untagged(untagged), MatrixBy::Size),
        };
        let name = match rule {
            MatrixRule::Untagged(_) if by == MatrixBy::File => known(about.matrix.unwrap_or_default()),
            MatrixRule::Always(Matrix::Bt601) | MatrixRule::Untagged(Matrix::Bt601) => "bt601",
            MatrixRule::Always(Matrix::Bt709) | MatrixRule::Untagged(Matrix::Bt709) => "bt709",
        };
        let pace = match pace {
            Pace::FrameForFrame => None,
            Pace::Of(rate) => Some(rate),
            Pace::AsTold => about.fps.filter(|rate| (1..=MAX_FPS).contains(&(rate.num() / rate.den()))),
        };
        let pace = pace.filter(|rate| !is_same(*rate, form.fps));
        // Of another codec or size it needs no second look.
        let fits = pace.is_none()
            && (about.codec.as_str(), about.size) == ("h264", form.size)
            && about.orientation == Orientation::UPRIGHT
            && rule != MatrixRule::Always(Matrix::Bt601)
            && in_form(&file.path, &form);
        let encode = if fits { None } else { Some(Scaling::new(&about, form.size, fit)?) };
        let source = file.path.clone();
        Ok(FilePlan { source, about, encode, pace, matrix: rule, colours: (name, by) })
    }
}

impl ClipPlan {
    /// The file that is tried first.
    pub(super) fn first(&self) -> &FilePlan {
        &self.files[0]
    }
}

impl FilePlan {
    /// The number of frames that it would have in a flock of `fps` frames a second, as far as its header tells.
    pub(super) fn frames(&self, fps: Rate) -> Option<u64> {
        let told = self.about.fps.map(per_second).zip(self.about.seconds).map(|(fps, seconds)| (fps * seconds).round());
        let frames = self.about.frames.map(|frames| f64::from(frames.0)).or(told)?;
        Some((frames * self.frames_for_each(fps)).ceil() as u64)
    }

    /// Frames in a flock of `fps` frames a second for each of its own.
    pub(super) fn frames_for_each(&self, fps: Rate) -> f64 {
        self.pace.map_or(1.0, |pace| per_second(fps) / per_second(pace))
    }

    /// How many times as fast it looks in a flock of `fps` frames a second as its file tells.
    pub(super) fn speed(&self, fps: Rate) -> Option<f64> {
        let shown = self.pace.unwrap_or(fps);
        self.about.fps.map(|told| if is_same(shown, told) { 1.0 } else { per_second(shown) / per_second(told) })
    }
}

/// The path of the clip that the manifest has for `role`.
pub(super) fn existing_path<'a>(manifest: &'a Manifest, role: &ClipRole) -> Option<&'a ClipPath> {
    let clip = match role {
        ClipRole::Loop(id) => manifest.sheep.iter().find(|sheep| sheep.id == *id)?.clip.as_ref(),
        ClipRole::Transition(from, to) => {
            manifest.transitions.iter().find(|t| t.from == *from && t.to == *to).map(|transition| &transition.clip)
        }
    };
    clip.map(|clip| &clip.path)
}

/// Whether a clip has the form, by its packets.
fn in_form(source: &Path, form: &Form) -> bool {
    video::probe(source).is_ok_and(|probe| probe.differences(form, probe.frames).is_empty())
}

fn place(role: &ClipRole) -> ClipPath {
    match role {
        ClipRole::Loop(id) => paths::of_loop(id, paths::CLIP),
        ClipRole::Transition(from, to) => paths::of_transition(from, to, paths::CLIP),
    }
}

/// Our name of a matrix that ffmpeg calls `name`.
fn known(name: &'static str) -> &'static str {
    if ["bt470bg", "smpte170m"].contains(&name) { "bt601" } else { name }
}

fn per_second(rate: Rate) -> f64 {
    f64::from(rate.num()) / f64::from(rate.den())
}

fn is_same(a: Rate, b: Rate) -> bool {
    (per_second(a) / per_second(b) - 1.0).abs() < SAME_PACE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_that_differ_by_rounding_are_one_and_those_of_film_and_television_are_two() {
        let rate = |num, den| Rate::new(num, den).unwrap();
        assert!(is_same(rate(23_980, 1000), rate(24_000, 1001)) && is_same(rate(25, 1), rate(25_001, 1000)));
        assert!(!is_same(rate(30_000, 1001), rate(30, 1)) && !is_same(rate(23, 1), rate(24, 1)));
        assert_eq!(Pace::parse("as-told"), Ok(Pace::AsTold));
        assert_eq!(Pace::parse("23"), Ok(Pace::Of(rate(23, 1))));
        assert!(Pace::parse("told").is_err());
    }
}
