//! Transitions that connect unplayed sheep to the played part.
//!
//! Owns the choice of the next missing transition between the parts of a flock. Shares only decide where it starts and
//! ends in the played part.
//!
//! # Source
//! Eswaran & Tarjan (1976): a flock is one part once its last parts lead to its first ones. Each transition here joins
//! the end of a way out of the played part to the start of a way into it, and so both ways at once.

use crate::flock::Flock;
use crate::graph::{SheepIx, Structure};
use crate::manifest::SheepId;

/// The next transition that `flock` needs so that all its sheep are played. `None` if they are.
pub(super) fn missing(flock: &Flock) -> Option<(SheepId, SheepId)> {
    let whole = flock.whole();
    let structure = Structure::of(whole);
    let count = structure.class_count();
    let first = flock.graph().sheep().next().and_then(|sheep| whole.find(flock.id(sheep)))?;
    let played = structure.class_of(first);
    let (mut after, mut before) = (vec![Vec::new(); count], vec![Vec::new(); count]);
    for from in whole.sheep() {
        for to in whole.exits(from).map(|exit| whole.target(exit)) {
            let (from, to) = (structure.class_of(from), structure.class_of(to));
            if from != to {
                after[from].push(to);
                before[to].push(from);
            }
        }
    }
    let others = || (0..count).filter(|&class| class != played);
    let (below, above) = (reached(&after, played), reached(&before, played));
    let last = others().find(|&class| below[class] && after[class].is_empty());
    let first = others().find(|&class| above[class] && before[class].is_empty());
    // A part with no way to or from the one that is played: into it first, the way back comes next.
    let apart = others().find(|&class| before[class].is_empty());
    let member = |class: usize| whole.sheep().find(|&sheep| structure.class_of(sheep) == class);
    let id = |class: Option<usize>| class.and_then(member).map(|sheep| whole.id(sheep).clone());
    let (from, to) = if last.is_none() && first.is_none() { (None, apart) } else { (last, first) };
    if from.is_none() && to.is_none() {
        return None;
    }
    Some((id(from).or_else(|| extreme(flock, false))?, id(to).or_else(|| extreme(flock, true))?))
}

/// The classes that can be reached from `start`.
fn reached(next: &[Vec<usize>], start: usize) -> Vec<bool> {
    let mut reached = vec![false; next.len()];
    reached[start] = true;
    let mut open = vec![start];
    while let Some(class) = open.pop() {
        for &to in &next[class] {
            if !std::mem::replace(&mut reached[to], true) {
                open.push(to);
            }
        }
    }
    reached
}

/// Of the sheep that are played, that which is shown least for its want, or most.
fn extreme(flock: &Flock, least: bool) -> Option<SheepId> {
    let ratio = |sheep: &SheepIx| flock.share(*sheep) / flock.sheep(*sheep).want;
    let by_ratio = |a: &SheepIx, b: &SheepIx| ratio(a).total_cmp(&ratio(b));
    let sheep = flock.graph().sheep();
    let found = if least { sheep.min_by(by_ratio) } else { sheep.max_by(by_ratio) };
    found.map(|sheep| flock.id(sheep).clone())
}
