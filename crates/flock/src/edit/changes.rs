//! The keys that edits change in entries of the text.
//!
//! Owns their list, which is short of bytes: a balance may change a million weights. `place.rs` writes them.
//!
//! Start at [`Changes::of`].

use std::borrow::Cow;

use super::{Kind, render};

/// The changes, in the order in which they were made.
#[derive(Debug, Default)]
pub(super) struct Changes(Vec<Change>);

/// A changed key of an entry.
#[derive(Debug)]
pub(super) struct Change {
    kind: Kind,
    /// The place of the entry among those of its kind in the text.
    pub(super) entry: u32,
    /// The place of the key in the order of writing.
    pub(super) key: u8,
    pub(super) value: NewValue,
}

/// What becomes of the value of a key.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NewValue {
    /// It is removed, with its key.
    Gone,
    /// This number.
    Number(f64),
    /// As it is written.
    Written(Box<str>),
}

impl Changes {
    /// Adds a change; it takes the place of an earlier one of the same key.
    pub(super) fn put(&mut self, kind: Kind, entry: u32, key: u8, value: NewValue) {
        self.0.push(Change { kind, entry, key, value });
    }

    /// The changes of entries of `kind`: the last one of each key, by entry and then in the order of writing.
    pub(super) fn of(&self, kind: Kind) -> Vec<&Change> {
        let mut changes: Vec<&Change> = self.0.iter().filter(|change| change.kind == kind).rev().collect();
        // Stable: of one key the last change comes first.
        changes.sort_by_key(|change| (change.entry, change.key));
        changes.dedup_by_key(|change| (change.entry, change.key));
        changes
    }
}

impl NewValue {
    /// A text that is written like this.
    pub(super) fn written(text: String) -> Self {
        Self::Written(text.into_boxed_str())
    }

    /// As it is written; `None` if it is removed.
    pub(super) fn text(&self) -> Option<Cow<'_, str>> {
        match self {
            Self::Gone => None,
            Self::Number(number) => Some(render::number(*number).into()),
            Self::Written(text) => Some(text.as_ref().into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_change_of_a_key_counts() {
        let mut changes = Changes::default();
        for (entry, key, number) in [(7, 1, 1.0), (3, 2, 2.0), (7, 1, 3.0), (7, 0, 4.0)] {
            changes.put(Kind::Sheep, entry, key, NewValue::Number(number));
        }
        changes.put(Kind::Transition, 7, 1, NewValue::Gone);
        let told = |change: &&Change| (change.entry, change.key, change.value.text().map(Cow::into_owned));
        let number = |text: &str| Some(text.to_owned());
        assert_eq!(
            changes.of(Kind::Sheep).iter().map(told).collect::<Vec<_>>(),
            [(3, 2, number("2.0")), (7, 0, number("4.0")), (7, 1, number("3.0"))]
        );
        assert_eq!(changes.of(Kind::Transition).iter().map(told).collect::<Vec<_>>(), [(7, 1, None)]);
    }
}
