//! What the artist notes beside the manifest: marks, ratings, pins, bad joins.
//!
//! Owns the notes, and changes of them that can be taken back. A note about a sheep that is nowhere any more is kept: it may
//! come back by an undo. Of a sheep of a pool the pool has the mark, which others may change: it is asked. Never touches a file.
//!
//! Start at [`Notes`].

use std::collections::{BTreeMap, BTreeSet};

use flock::SheepId;
use serde::{Deserialize, Serialize};

use super::requests::NoteRequest;

/// The best rating.
pub(crate) const BEST_RATING: u8 = 5;

/// All notes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Notes {
    /// Of sheep and candidates that have one.
    pub(crate) marks: BTreeMap<SheepId, Mark>,
    /// Places in the graph.
    pub(crate) pins: BTreeMap<SheepId, [f64; 2]>,
    /// Transitions that look bad at one of their joins.
    pub(crate) bad_joins: BTreeSet<(SheepId, SheepId)>,
}

/// What is thought of a sheep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Mark {
    /// Whether it is to stay.
    pub(crate) kind: MarkKind,
    /// 0 to [`BEST_RATING`]; 0 is none.
    pub(crate) rating: u8,
}

/// Whether a sheep is to stay.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum MarkKind {
    /// Not thought about.
    #[default]
    None,
    /// To stay.
    Kept,
    /// To go. It is still there.
    Rejected,
}

/// A change of one note, which can be taken back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum NoteChange {
    Join { from: SheepId, to: SheepId, was: bool, is: bool },
    Mark { sheep: SheepId, was: Mark, is: Mark },
    Pin { sheep: SheepId, was: Option<[f64; 2]>, is: Option<[f64; 2]> },
}

/// The kinds of mark that `changes`, one after the other, led from and to, of each sheep where they differ.
pub(super) fn marked(changes: &[NoteChange]) -> BTreeMap<&SheepId, [MarkKind; 2]> {
    let mut kinds = BTreeMap::new();
    for change in changes {
        match change {
            NoteChange::Mark { sheep, was, is } => kinds.entry(sheep).or_insert([was.kind; 2])[1] = is.kind,
            NoteChange::Join { .. } | NoteChange::Pin { .. } => {}
        }
    }
    kinds.retain(|_, [was, is]| was != is);
    kinds
}

/// Why a note is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum NoteRefusal {
    /// No number.
    #[error("the place of `{sheep}` must be two finite numbers")]
    Place {
        /// Whose.
        sheep: SheepId,
    },
    /// Too high.
    #[error("a rating is from 0 to {BEST_RATING}, found {found}")]
    Rating {
        /// As given.
        found: u8,
    },
}

impl Notes {
    /// The changes that `requests` make, one after the other; those that change nothing are left out. `in_pool` tells how a pool
    /// has marked its sheep.
    /// Errors: [`NoteRefusal`] of the first that is refused.
    pub(super) fn changes(
        &self,
        requests: &[NoteRequest],
        in_pool: impl Fn(&SheepId) -> Option<MarkKind>,
    ) -> Result<Vec<NoteChange>, NoteRefusal> {
        let (mut now, mut changes) = (self.clone(), Vec::new());
        for request in requests {
            if let NoteRequest::Mark { sheep, .. } = request
                && let Some(kind) = in_pool(sheep)
            {
                let rating = now.marks.get(sheep).map_or(0, |mark| mark.rating);
                now.set_mark(sheep, Mark { kind, rating });
            }
        }
        for request in requests {
            if let Some(change) = now.change(request)? {
                now.apply(&change);
                changes.push(change);
            }
        }
        Ok(changes)
    }

    fn change(&self, request: &NoteRequest) -> Result<Option<NoteChange>, NoteRefusal> {
        match request {
            NoteRequest::Join { from, to, bad } => {
                let was = self.bad_joins.contains(&(from.clone(), to.clone()));
                let change = || NoteChange::Join { from: from.clone(), to: to.clone(), was, is: *bad };
                Ok((was != *bad).then(change))
            }
            NoteRequest::Mark { sheep, mark, rating } => {
                if let Some(found) = rating.filter(|rating| *rating > BEST_RATING) {
                    return Err(NoteRefusal::Rating { found });
                }
                let was = self.marks.get(sheep).copied().unwrap_or_default();
                let is = Mark { kind: mark.unwrap_or(was.kind), rating: rating.unwrap_or(was.rating) };
                Ok((was != is).then(|| NoteChange::Mark { sheep: sheep.clone(), was, is }))
            }
            NoteRequest::Pin { sheep, at } => {
                if at.is_some_and(|place| !place.iter().all(|number| number.is_finite())) {
                    return Err(NoteRefusal::Place { sheep: sheep.clone() });
                }
                let was = self.pins.get(sheep).copied();
                Ok((was != *at).then(|| NoteChange::Pin { sheep: sheep.clone(), was, is: *at }))
            }
        }
    }

    /// The changes that take all notes of the sheep `old` to `new`.
    pub(super) fn renamed(&self, old: &SheepId, new: &SheepId) -> Vec<NoteChange> {
        let (mut now, mut changes) = (self.clone(), Vec::new());
        let mut add = |change: NoteChange| {
            now.apply(&change);
            changes.push(change);
        };
        if let Some(mark) = self.marks.get(old) {
            let was = self.marks.get(new).copied().unwrap_or_default();
            add(NoteChange::Mark { sheep: new.clone(), was, is: *mark });
            add(NoteChange::Mark { sheep: old.clone(), was: *mark, is: Mark::default() });
        }
        if let Some(place) = self.pins.get(old) {
            add(NoteChange::Pin { sheep: new.clone(), was: self.pins.get(new).copied(), is: Some(*place) });
            add(NoteChange::Pin { sheep: old.clone(), was: Some(*place), is: None });
        }
        let id = |id: &SheepId| if id == old { new.clone() } else { id.clone() };
        for (from, to) in self.bad_joins.iter().filter(|(from, to)| from == old || to == old) {
            add(NoteChange::Join { from: from.clone(), to: to.clone(), was: true, is: false });
            let was = self.bad_joins.contains(&(id(from), id(to)));
            if !was {
                add(NoteChange::Join { from: id(from), to: id(to), was, is: true });
            }
        }
        changes
    }

    /// Makes a change.
    pub(super) fn apply(&mut self, change: &NoteChange) {
        match change {
            NoteChange::Join { from, to, is, .. } => self.set_join(from, to, *is),
            NoteChange::Mark { sheep, is, .. } => self.set_mark(sheep, *is),
            NoteChange::Pin { sheep, is, .. } => self.set_pin(sheep, *is),
        }
    }

    /// Takes a change back.
    pub(super) fn revert(&mut self, change: &NoteChange) {
        match change {
            NoteChange::Join { from, to, was, .. } => self.set_join(from, to, *was),
            NoteChange::Mark { sheep, was, .. } => self.set_mark(sheep, *was),
            NoteChange::Pin { sheep, was, .. } => self.set_pin(sheep, *was),
        }
    }

    fn set_join(&mut self, from: &SheepId, to: &SheepId, is: bool) {
        let join = (from.clone(), to.clone());
        if is {
            self.bad_joins.insert(join)
        } else {
            self.bad_joins.remove(&join)
        };
    }

    fn set_mark(&mut self, sheep: &SheepId, is: Mark) {
        if is == Mark::default() {
            self.marks.remove(sheep)
        } else {
            self.marks.insert(sheep.clone(), is)
        };
    }

    fn set_pin(&mut self, sheep: &SheepId, is: Option<[f64; 2]>) {
        match is {
            Some(place) => self.pins.insert(sheep.clone(), place),
            None => self.pins.remove(sheep),
        };
    }
}
