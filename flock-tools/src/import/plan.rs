//! The plan of an import: what is done with each clip.
//!
//! Owns the cheap checks of a clip: its header, its shape, whether the flock has it. Never decodes a picture and never
//! writes: `importer.rs` does.
//!
//! Start at [`Plan::of`].

use std::path::{Path, PathBuf};

use flock::{ClipPath, Manifest};
use timing::Rate;
use video::{ForeignVideo, Form, VideoInfo};

use super::scaling::{Fit, Scaling};
use crate::flock_folder::paths;
use crate::program::chain;
use crate::render::plan::ClipRole;

/// The options of an import.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImportSettings<'a> {
    /// The folder of the flock.
    pub(super) folder: &'a Path,
    pub(super) form: Form,
    pub(super) fit: Option<Fit>,
    /// Frames in a second of a clip; `None`: every frame becomes one frame.
    pub(super) fps: Option<Rate>,
}

/// A clip to import.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) source: PathBuf,
    pub(super) role: ClipRole,
    /// Its path in the flock.
    pub(super) path: ClipPath,
    pub(super) about: VideoInfo,
    /// `None` if it has the flock's form: its bytes are copied.
    pub(super) encode: Option<Scaling>,
}

/// A plan, or why there is none.
pub(super) enum PlanResult {
    /// The clip is to be imported.
    Planned(Box<Plan>),
    /// It cannot be imported; why.
    Skipped(String),
    /// The flock has it.
    AlreadyThere(ClipPath),
}

impl Plan {
    /// The plan of the clip at `source`, which is to be `role` in the flock of `manifest`.
    pub(super) fn of(source: &Path, role: &ClipRole, manifest: &Manifest, settings: &ImportSettings<'_>) -> PlanResult {
        if let Some(path) = existing_path(manifest, role).filter(|path| path.inside(settings.folder).exists()) {
            return PlanResult::AlreadyThere(path.clone());
        }
        let foreign = match ForeignVideo::open(source) {
            Ok(foreign) => foreign,
            Err(error) => return PlanResult::Skipped(chain(&error)),
        };
        let about = foreign.info().clone();
        let fits = settings.fps.is_none_or(|fps| fps == settings.form.fps) && in_form(source, &settings.form);
        let encode = if fits { Ok(None) } else { Scaling::new(&about, settings.form.size, settings.fit).map(Some) };
        match encode {
            Ok(encode) => {
                let (source, role, path) = (source.to_owned(), role.clone(), place(role));
                PlanResult::Planned(Box::new(Self { source, role, path, about, encode }))
            }
            Err(reason) => PlanResult::Skipped(reason),
        }
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
