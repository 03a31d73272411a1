//! Edits and notes as the page asks for them.
//!
//! Owns their form, and the sentence that says what each does. Never edits anything: `perform.rs` does.
//!
//! Start at [`EditRequest`] and [`NoteRequest`].

use flock::SheepId;
use serde::{Deserialize, Serialize};

use super::notes::MarkKind;

/// An edit of the manifest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "lowercase")]
pub(crate) enum EditRequest {
    /// Candidates become sheep of the flock.
    Add {
        /// Their ids.
        candidates: Vec<SheepId>,
    },
    /// A sheep is taken out, with its transitions.
    Drop {
        /// Which.
        sheep: SheepId,
    },
    /// A new transition.
    Link {
        /// Where it starts.
        from: SheepId,
        /// Where it ends.
        to: SheepId,
        /// Frames of a clip that is yet to be rendered; as usual if there are none.
        frames: Option<u32>,
    },
    /// Sheep are taken out as by `dreams prune`: with their transitions, those that name unknown sheep, and second
    /// definitions.
    Prune {
        /// Those that go.
        drop: Vec<SheepId>,
    },
    /// A sheep has another id, and its files the names of it.
    Rename {
        /// Its id.
        sheep: SheepId,
        /// Its new id.
        to: SheepId,
    },
    /// How often a loop is shown at each visit.
    Repeat {
        /// Whose.
        sheep: SheepId,
        /// Loops per visit.
        value: u32,
    },
    /// A transition is taken out.
    Unlink {
        /// Where it starts.
        from: SheepId,
        /// Where it ends.
        to: SheepId,
    },
    /// How often a sheep is wished, relative to the others.
    Want {
        /// Which.
        sheep: SheepId,
        /// Finite, above 0.
        value: f64,
    },
    /// How readily the walk takes a transition.
    Weight(NewWeight),
    /// The same of many: a balance.
    Weights {
        /// All of them.
        values: Vec<NewWeight>,
    },
}

/// A weight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct NewWeight {
    /// Where the transition starts.
    pub(crate) from: SheepId,
    /// Where it ends.
    pub(crate) to: SheepId,
    /// Finite, above 0.
    pub(crate) value: f64,
}

/// A change of what the studio notes beside the manifest.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum NoteRequest {
    /// A join that looks bad, or does no longer.
    Join {
        /// Where the transition starts.
        from: SheepId,
        /// Where it ends.
        to: SheepId,
        /// Whether it looks bad.
        bad: bool,
    },
    /// A mark, a rating, or both.
    Mark {
        /// Of which sheep, or candidate.
        sheep: SheepId,
        /// The mark; as it was without.
        mark: Option<MarkKind>,
        /// 0 to 5; as it was without.
        rating: Option<u8>,
    },
    /// Where a sheep stands in the graph; `None` if the layout says it.
    Pin {
        /// Which.
        sheep: SheepId,
        /// Its place.
        at: Option<[f64; 2]>,
    },
}

impl EditRequest {
    /// What it did, in words.
    fn said(&self) -> String {
        match self {
            Self::Add { candidates } => match candidates.as_slice() {
                [one] => format!("added {one}"),
                all => format!("added {} sheep", all.len()),
            },
            Self::Drop { sheep } => format!("dropped {sheep}"),
            Self::Link { from, to, .. } => format!("linked {from} to {to}"),
            Self::Prune { drop } => match drop.as_slice() {
                [one] => format!("pruned {one}"),
                all => format!("pruned {} sheep", all.len()),
            },
            Self::Rename { sheep, to } => format!("renamed {sheep} to {to}"),
            Self::Repeat { sheep, value } => format!("set the loops of {sheep} to {value} per visit"),
            Self::Unlink { from, to } => format!("unlinked {from} from {to}"),
            Self::Want { sheep, value } => format!("set the want of {sheep} to {value}"),
            Self::Weight(NewWeight { from, to, value }) => format!("set the weight from {from} to {to} to {value}"),
            Self::Weights { values } => format!("set {}", counted(values.len(), "weight")),
        }
    }

    /// What several did that do the same.
    fn said_of_many(&self, count: usize) -> String {
        match self {
            Self::Add { .. } => format!("added {count} times"),
            Self::Drop { .. } => format!("dropped {count} sheep"),
            Self::Link { .. } => format!("linked {}", counted(count, "pair")),
            Self::Prune { .. } => format!("pruned {count} times"),
            Self::Rename { .. } => format!("renamed {count} sheep"),
            Self::Repeat { .. } => format!("set the loops of {count} sheep"),
            Self::Unlink { .. } => format!("unlinked {}", counted(count, "pair")),
            Self::Want { .. } => format!("set the wants of {count} sheep"),
            Self::Weight { .. } => format!("set {}", counted(count, "weight")),
            Self::Weights { .. } => format!("set the weights {count} times"),
        }
    }
}

impl NoteRequest {
    fn said(&self) -> String {
        match self {
            Self::Join { from, to, bad: true } => format!("marked the join from {from} to {to} as bad"),
            Self::Join { from, to, bad: false } => format!("unmarked the join from {from} to {to}"),
            Self::Mark { sheep, mark: Some(MarkKind::Kept), .. } => format!("kept {sheep}"),
            Self::Mark { sheep, mark: Some(MarkKind::Rejected), .. } => format!("rejected {sheep}"),
            Self::Mark { sheep, mark: Some(MarkKind::None), .. } => format!("unmarked {sheep}"),
            Self::Mark { sheep, mark: None, rating } => format!("rated {sheep} {}", rating.unwrap_or_default()),
            Self::Pin { sheep, at: Some(_) } => format!("pinned {sheep}"),
            Self::Pin { sheep, at: None } => format!("unpinned {sheep}"),
        }
    }
}

/// What `edits` did, in one sentence.
pub(super) fn said_of_edits(edits: &[EditRequest]) -> String {
    match edits {
        [] => "changed nothing".to_owned(),
        [one] => one.said(),
        [
            EditRequest::Link { from, to, .. },
            EditRequest::Weight(_),
            EditRequest::Unlink { from: was_from, to: was_to },
        ] => {
            format!("linked {from} to {to} instead of {was_from} to {was_to}")
        }
        [first, rest @ ..] => {
            let alike = |other: &EditRequest| std::mem::discriminant(other) == std::mem::discriminant(first);
            let is_uniform = rest.iter().all(alike);
            if is_uniform { first.said_of_many(edits.len()) } else { format!("made {} edits", edits.len()) }
        }
    }
}

/// What `notes` did, in one sentence.
pub(super) fn said_of_notes(notes: &[NoteRequest]) -> String {
    let sheep_of = |note: &NoteRequest| match note {
        NoteRequest::Mark { mark: Some(mark), .. } => Some(*mark),
        NoteRequest::Mark { .. } | NoteRequest::Join { .. } | NoteRequest::Pin { .. } => None,
    };
    match notes {
        [] => "noted nothing".to_owned(),
        [one] => one.said(),
        [first, ..] => match sheep_of(first).filter(|mark| notes.iter().all(|note| sheep_of(note) == Some(*mark))) {
            Some(MarkKind::Kept) => format!("kept {} sheep", notes.len()),
            Some(MarkKind::Rejected) => format!("rejected {} sheep", notes.len()),
            Some(MarkKind::None) => format!("unmarked {} sheep", notes.len()),
            None => format!("made {} notes", notes.len()),
        },
    }
}

fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}
