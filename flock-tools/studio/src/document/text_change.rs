//! The difference of two texts, as one replaced part.
//!
//! Owns the form in which the journal keeps edits: what an edit does not touch is not kept twice. Never guesses: a text
//! that does not fit is not changed.
//!
//! Start at [`TextChange::between`].

use serde::{Deserialize, Serialize};

/// A part of a text that was replaced.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct TextChange {
    /// Bytes before the part.
    before: usize,
    /// Bytes behind it.
    behind: usize,
    was: String,
    is: String,
}

impl TextChange {
    /// What makes `new` of `old`; `None` if they are the same.
    pub(super) fn between(old: &str, new: &str) -> Option<Self> {
        if old == new {
            return None;
        }
        let same = |(a, b): &(u8, u8)| a == b;
        let mut before = old.bytes().zip(new.bytes()).take_while(same).count();
        while !(old.is_char_boundary(before) && new.is_char_boundary(before)) {
            before -= 1;
        }
        let (old_rest, new_rest) = (&old[before..], &new[before..]);
        let mut behind = old_rest.bytes().rev().zip(new_rest.bytes().rev()).take_while(same).count();
        while !(old_rest.is_char_boundary(old_rest.len() - behind)
            && new_rest.is_char_boundary(new_rest.len() - behind))
        {
            behind -= 1;
        }
        let part = |rest: &str| rest[..rest.len() - behind].to_owned();
        Some(Self { before, behind, was: part(old_rest), is: part(new_rest) })
    }

    /// `text` with the change; `None` if it is not the text that was changed.
    pub(super) fn apply(&self, text: &str) -> Option<String> {
        self.replaced(text, &self.was, &self.is)
    }

    /// `text` without the change; `None` if it is not the text that came of it.
    pub(super) fn revert(&self, text: &str) -> Option<String> {
        self.replaced(text, &self.is, &self.was)
    }

    /// How many bytes it takes.
    pub(super) fn bytes(&self) -> usize {
        self.was.len() + self.is.len()
    }

    fn replaced(&self, text: &str, is: &str, new: &str) -> Option<String> {
        let end = text.len().checked_sub(self.behind)?;
        let (head, part, tail) = (text.get(..self.before)?, text.get(self.before..end)?, text.get(end..)?);
        (part == is).then(|| [head, new, tail].concat())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_change_leads_from_one_text_to_the_other_and_back(old in "[aäñ\n]{0,12}", new in "[aäñ\n]{0,12}") {
            match TextChange::between(&old, &new) {
                None => prop_assert_eq!(old, new),
                Some(change) => {
                    prop_assert_eq!(change.apply(&old), Some(new.clone()));
                    prop_assert_eq!(change.revert(&new), Some(old));
                }
            }
        }
    }

    #[test]
    fn a_text_that_does_not_fit_is_not_changed() {
        let change = TextChange::between("want = 1.0\n", "want = 2.5\n").unwrap();
        for other in ["", "want = 3.0\n", "want = 1.0", "ä"] {
            assert_eq!(change.apply(other), None, "{other}");
        }
        assert_eq!(change.bytes(), 6);
    }
}
