//! The finished clips of an import, moved to their places and added to the manifest, many at once.
//!
//! Owns the order of these steps. First the disk has the bytes of all clips, then all are renamed, then the disk has their
//! names, then the manifest names them. Whenever the machine stops, the flock is sound, and the same command continues.
//!
//! Start at [`commit`].

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use flock::Draft;
use flock::{Clip, ClipHash, Edit, EditError, Manifest, Sheep, SheepId, Transition};
use operations::program::{Exit, Fatal};
use operations::render::plan::ClipRole;

use super::importer::MadeClip;
use super::plan::{ClipPlan, ImportSettings, existing_path};

/// What became of a finished clip.
#[derive(Debug)]
pub(super) enum Outcome {
    /// It is in the flock. These sheep were added for it, without loops.
    Imported { added: Vec<SheepId> },
    /// It was not taken; why.
    Refused(String),
    /// Another command has added it meanwhile.
    AlreadyThere,
}

/// Adds the finished clips of these plans to the flock.
/// Errors: Those of the disk and of the manifest. The flock is then as it was, but for clips that were replaced.
pub(super) fn commit(clips: &[(&ClipPlan, &MadeClip)], settings: &ImportSettings<'_>) -> Result<Vec<Outcome>, Fatal> {
    let folders: Vec<PathBuf> = clips.iter().map(|(_, made)| parent(&made.new.0)).collect();
    sync(&folders)?;
    let mut draft = Draft::lock(settings.folder)?;
    let mut outcomes = Vec::new();
    for (plan, made) in clips {
        outcomes.push(add(&mut draft.edit, plan, made, settings)?);
    }
    sync(&folders)?;
    draft.save()?;
    Ok(outcomes)
}

/// Moves a finished clip to its place, and adds it to the edited manifest.
fn add(edit: &mut Edit, plan: &ClipPlan, made: &MadeClip, settings: &ImportSettings<'_>) -> Result<Outcome, Fatal> {
    let manifest = edit.manifest();
    // Read again: another command may have changed the flock meanwhile.
    let own = existing_path(manifest, &plan.role);
    if !settings.force && own.is_some_and(|path| path.inside(settings.folder).exists()) {
        return Ok(Outcome::AlreadyThere);
    }
    let place = plan.path.inside(settings.folder);
    if place.exists() {
        let uses = manifest.clips().filter(|clip| clip.path == plan.path).count();
        let is_named = uses > usize::from(own == Some(&plan.path));
        // A run that was killed between the rename and the save left it.
        let same = File::open(&place).and_then(ClipHash::of).is_ok_and(|found| found == made.hash);
        if !same && (is_named || !settings.force || !place.is_file()) {
            let hint = if is_named { "which the flock uses for something else" } else { "--force replaces it" };
            return Ok(Outcome::Refused(format!("another file is in its place, `{}`; {hint}", plan.path)));
        }
    }
    let clip = Clip { path: plan.path.clone(), frames: made.frames, hash: Some(made.hash) };
    let added = add_to_manifest(edit, &plan.role, clip).map_err(|error| Fatal::new(Exit::Malformed, error))?;
    fs::rename(&made.new.0, &place).map_err(|source| Fatal::write(&place, source))?;
    Ok(Outcome::Imported { added })
}

fn sync(folders: &[PathBuf]) -> Result<(), Fatal> {
    let synced = durable::sync_file_systems(folders.iter().map(PathBuf::as_path));
    synced.map_err(|source| {
        Fatal::file("sync the disk of", folders.first().map_or(Path::new("."), PathBuf::as_path), source)
    })
}

fn parent(path: &Path) -> PathBuf {
    path.parent().unwrap_or(Path::new(".")).to_owned()
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
