//! Transfer of a saved place to another flock, by the ids that both share.
//!
//! Owns the rules: recent sheep and recent transitions are kept; counts are kept if they satisfy the credit bound with
//! the new probabilities, and are redistributed if not; from here on visits are expected by the new shares. It succeeds
//! for every flock that shares a sheep.

use std::sync::Arc;

use super::first_sheep;
use super::ledger::Ledger;
use super::memory::{Keys, Memory, NEVER, Next, Place, PlaceError};
use super::runs::Recent;
use crate::flock::Flock;
use crate::graph::{Exit, SheepIx};

/// `place` in the ordinals of `flock`, whose keys are `keys`.
/// Errors: [`PlaceError::Foreign`] if they share no sheep.
pub(crate) fn carry_over(place: &Place, flock: &Flock, keys: &Arc<Keys>) -> Result<Place, PlaceError> {
    if *place.keys == **keys {
        return Ok(place.clone());
    }
    let (graph, old) = (flock.graph(), &*place.memory);
    let sheep: Vec<Option<SheepIx>> = place.keys.sheep.iter().map(|id| graph.find(id)).collect();
    if sheep.iter().all(Option::is_none) {
        return Err(PlaceError::Foreign { saved: sheep.len(), found: graph.len() });
    }
    let exit = |&(from, to): &(SheepIx, SheepIx)| graph.between(sheep[from.index()]?, sheep[to.index()]?);
    let exits: Vec<Option<Exit>> = place.keys.exits.iter().map(exit).collect();

    let mut last = vec![NEVER; graph.len()];
    for (now, &seen) in sheep.iter().zip(&old.last) {
        if let Some(now) = now {
            last[now.index()] = seen;
        }
    }
    let mut taken = vec![0; graph.exit_count()];
    for (now, &count) in exits.iter().zip(old.ledger.counts()) {
        if let Some(now) = now {
            taken[now.index()] = count;
        }
    }
    let ledger = redistribute(flock, taken);
    // Recent steps are kept back to the first one that no longer exists.
    let recent: Recent = {
        let kept = old.recent.iter().rev().map_while(|exit| exits[exit.index()]);
        kept.collect::<Vec<_>>().into_iter().rev().collect()
    };
    let (at, next) = match sheep[old.place.index()] {
        Some(at) => (at, place.next),
        None => (first_sheep(flock, old.seed, old.step).expect("a sheep is shared"), Next::Visit { played: 0 }),
    };
    last[at.index()] = old.step;
    let before = graph.sheep().map(|sheep| ledger.left(graph, sheep)).collect();
    let memory = Memory { seed: old.seed, step: old.step, place: at, ledger, last, since: old.step, before, recent };
    Ok(Place { keys: Arc::clone(keys), memory: Arc::new(memory), next })
}

/// Counts within the credit bound: those of a sheep that violate it with the new probabilities are redistributed.
fn redistribute(flock: &Flock, taken: Vec<u64>) -> Ledger {
    let graph = flock.graph();
    let mut counts = taken.clone();
    let ledger = Ledger::with(taken);
    for sheep in graph.sheep().filter(|&sheep| !ledger.is_sound(graph, sheep)) {
        let visits = ledger.left(graph, sheep);
        let mut rest = visits;
        for exit in graph.exits(sheep) {
            counts[exit.index()] = (graph.chance(exit) * visits as f64) as u64;
            rest = rest.saturating_sub(counts[exit.index()]);
        }
        // Rounding down leaves less than one for each exit.
        for exit in graph.exits(sheep).take(usize::try_from(rest).unwrap_or(usize::MAX)) {
            counts[exit.index()] += 1;
        }
    }
    Ledger::with(counts)
}
