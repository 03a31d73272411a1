//! Writes balanced weights into the manifest.
//!
//! Owns the edit of `--write`: only weights that differ are changed. A manifest without such is not written. The flock crate
//! finds the weights.

use flock::{Balance, Flock, FlockShares};

use crate::flock_folder::Draft;
use crate::program::{Exit, Fatal};

/// Writes the weights of `balance` into `draft`, the manifest of the same flock; returns how many were changed.
/// Errors: If the manifest cannot be saved. It is then as it was.
pub(super) fn weights(mut draft: Draft, balance: &Balance<'_>) -> Result<usize, Fatal> {
    let before: Vec<f64> = draft.edit.manifest().transitions.iter().map(|transition| transition.weight).collect();
    for weight in &balance.weights {
        let set = draft.edit.set_weight(weight.from, weight.to, weight.weight);
        set.map_err(|error| Fatal::new(Exit::Malformed, error))?;
    }
    let after = draft.edit.manifest().transitions.iter().map(|transition| transition.weight);
    let changed = before.into_iter().zip(after).filter(|(before, after)| before.to_bits() != after.to_bits()).count();
    if changed > 0 {
        draft.save()?;
    }
    Ok(changed)
}

/// `flock` with the weights of `balance`.
pub(crate) fn with_weights(flock: &Flock, balance: &Balance<'_>) -> Flock {
    let whole = flock.whole();
    let mut manifest = flock.manifest().clone();
    let exits = whole.sheep().flat_map(|sheep| whole.exits(sheep));
    for (exit, weight) in exits.zip(&balance.weights) {
        manifest.transitions[whole.transition_in_manifest(exit)].weight = weight.weight;
    }
    Flock::new(manifest)
}

/// What was written, in one line; `flock` is the flock before.
pub(super) fn summary(changed: usize, flock: &Flock) -> String {
    let all = flock.whole().exit_count();
    if changed == 0 {
        return format!("note: nothing to write, all {all} weights stand already");
    }
    let was = FlockShares::of(flock).and_then(|shares| shares.worst_ratio);
    let was = was.map_or(String::new(), |ratio| format!("; the worst ratio of visits and want was {ratio:.3}"));
    format!("note: wrote {changed} of {all} weights{was}")
}
