//! Makes edits, as the commands make them.
//!
//! Owns what each request means on a manifest, and which hashes of clips outlive an undo. Never saves anything.
//!
//! Start at [`perform`].

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use flock::{Clip, ClipHash, ClipPath, Edit, EditError, FILE_NAME, Flock, Manifest, Sheep, SheepId, Transition, paths};
use timing::FrameCount;

use super::requests::{EditRequest, NewWeight};
use super::{ApplyError, Surroundings};

/// What edits need of the files beside the manifest.
#[derive(Debug, Default)]
pub(super) struct Needs {
    /// Sheep that were candidates: their genomes must be there.
    pub(super) added: Vec<Sheep>,
    /// Files that have another name now: the old one, and the new one.
    pub(super) renamed: BTreeMap<ClipPath, ClipPath>,
    /// Sheep that have another id now.
    pub(super) ids: Vec<(SheepId, SheepId)>,
}

/// Makes `requests` on `edit`, in their order.
/// Errors: [`ApplyError::Refused`] of the first that is refused; `edit` must then be dropped.
pub(super) fn perform(
    requests: &[EditRequest],
    edit: &mut Edit,
    around: &dyn Surroundings,
) -> Result<Needs, ApplyError> {
    let mut needs = Needs::default();
    let refused = |error: String| ApplyError::Refused { error };
    let edited = |result: Result<(), EditError>| result.map_err(|error| refused(error.to_string()));
    // Many at once: the edit looks them all up in one pass.
    if let Some(pairs) = unlinked(requests) {
        return edited(edit.drop_transitions(&pairs)).map(|()| needs);
    }
    for request in requests {
        match request {
            EditRequest::Add { candidates } => {
                for id in candidates {
                    let sheep = around.candidate(id, edit.manifest()).map_err(refused)?;
                    edited(edit.add_sheep(sheep.clone()))?;
                    needs.added.push(sheep);
                }
            }
            EditRequest::Drop { sheep } => edited(edit.drop_sheep(sheep))?,
            EditRequest::Link { from, to, frames } => {
                let path = paths::of_transition(from, to, paths::CLIP);
                let frames = FrameCount(frames.unwrap_or(paths::TRANSITION_FRAMES));
                if frames.0 == 0 || frames.0 > flock::MAX_FRAMES {
                    let error = format!("a transition has 1 to {} frames, found {frames}", flock::MAX_FRAMES);
                    return Err(refused(error));
                }
                let clip = around.clip(Clip { path, frames, hash: None }, edit.manifest()).map_err(refused)?;
                let (from, to) = (from.clone(), to.clone());
                edited(edit.add_transition(Transition { from, to, clip, weight: 1.0 }))?;
            }
            EditRequest::Prune { drop } => edited(prune(edit, drop))?,
            EditRequest::Rename { sheep, to } => {
                let moves = edit.rename_with_files(sheep, to).map_err(|error| refused(error.to_string()))?;
                needs.renamed.extend(moves);
                needs.ids.push((sheep.clone(), to.clone()));
            }
            EditRequest::Repeat { sheep, value } => edited(edit.set_repeat(sheep, *value))?,
            EditRequest::Unlink { from, to } => edited(edit.drop_transition(from, to))?,
            EditRequest::Want { sheep, value } => edited(edit.set_want(sheep, *value))?,
            EditRequest::Weight(NewWeight { from, to, value }) => edited(edit.set_weight(from, to, *value))?,
            EditRequest::Weights { values } => {
                values.iter().try_for_each(|new| edited(edit.set_weight(&new.from, &new.to, new.value)))?;
            }
        }
    }
    Ok(needs)
}

/// Keeps all sheep but those of `drop`, as `dreams prune` keeps a part. Sheep that came in meanwhile stay.
fn prune(edit: &mut Edit, drop: &[SheepId]) -> Result<(), EditError> {
    let all: BTreeSet<SheepId> = edit.manifest().sheep.iter().map(|sheep| sheep.id.clone()).collect();
    if let Some(id) = drop.iter().find(|id| !all.contains(*id)) {
        return Err(EditError::UnknownSheep { id: id.clone() });
    }
    edit.keep_only(&all.into_iter().filter(|id| !drop.contains(id)).collect());
    Ok(())
}

/// The pairs, if all `requests` take different transitions out.
fn unlinked(requests: &[EditRequest]) -> Option<BTreeSet<(SheepId, SheepId)>> {
    let mut pairs = BTreeSet::new();
    let adds = |request: &EditRequest| match request {
        EditRequest::Unlink { from, to } => pairs.insert((from.clone(), to.clone())),
        EditRequest::Add { .. }
        | EditRequest::Drop { .. }
        | EditRequest::Link { .. }
        | EditRequest::Prune { .. }
        | EditRequest::Rename { .. }
        | EditRequest::Repeat { .. }
        | EditRequest::Want { .. }
        | EditRequest::Weight { .. }
        | EditRequest::Weights { .. } => false,
    };
    let are_all = requests.iter().all(adds);
    are_all.then_some(pairs)
}

/// The sheep that the walk plays in `before` and no longer in `after`, although the flock still has them.
pub(super) fn lost(before: &Arc<Manifest>, after: &Arc<Manifest>) -> Vec<SheepId> {
    let (had, has) = (shown(before), shown(after));
    let still: HashSet<&SheepId> = after.sheep.iter().map(|sheep| &sheep.id).collect();
    had.difference(&has).filter(|id| still.contains(id)).cloned().collect()
}

/// The sheep that the walk plays.
fn shown(manifest: &Arc<Manifest>) -> BTreeSet<SheepId> {
    let flock = Flock::new(Arc::clone(manifest));
    let sheep = flock.graph().sheep().filter(|_| flock.is_walkable());
    sheep.map(|sheep| flock.id(sheep).clone()).collect()
}

/// Whether `text` is `ours`, but for hashes of clips.
pub(super) fn is_but_for_hashes(text: &str, ours: &str) -> bool {
    if text == ours {
        return true;
    }
    let Ok(edit) = Edit::parse(text.to_owned(), Path::new(FILE_NAME)) else { return false };
    with_hashes(ours, edit.manifest()).is_some_and(|ours| ours == text)
}

/// `text` with the hashes that `manifest` has of clips of the same path and length. `None` if `text` is no manifest.
pub(super) fn with_hashes(text: &str, manifest: &Manifest) -> Option<String> {
    let mut edit = Edit::parse(text.to_owned(), Path::new(FILE_NAME)).ok()?;
    let hashed = |clip: &Clip| Some(((clip.path.clone(), clip.frames), clip.hash?));
    let known: HashMap<(ClipPath, FrameCount), ClipHash> = manifest.clips().filter_map(hashed).collect();
    let with_hash = |clip: &Clip| {
        let hash = known.get(&(clip.path.clone(), clip.frames)).filter(|hash| clip.hash != Some(**hash))?;
        Some(Clip { hash: Some(*hash), ..clip.clone() })
    };
    let before = edit.shared_manifest();
    for sheep in &before.sheep {
        if let Some(clip) = sheep.clip.as_ref().and_then(with_hash) {
            edit.set_loop(&sheep.id, clip).ok()?;
        }
    }
    for transition in &before.transitions {
        if let Some(clip) = with_hash(&transition.clip) {
            edit.set_transition_clip(&transition.from, &transition.to, clip).ok()?;
        }
    }
    Some(edit.text())
}
