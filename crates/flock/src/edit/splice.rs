//! Replacement of bytes in a text.
//!
//! Owns the list of replacements and applies them.

use std::ops::Range;

/// Replacements in a text, in any order.
#[derive(Debug, Default)]
pub(super) struct Splice(Vec<(Range<usize>, String)>);

impl Splice {
    /// Puts `new` in place of the bytes at `old`; of several at the same place the first put comes first.
    pub(super) fn put(&mut self, old: Range<usize>, new: impl Into<String>) {
        self.0.push((old, new.into()));
    }

    /// Takes the bytes at `old` away, and with them whatever else is put there.
    pub(super) fn cut(&mut self, old: Range<usize>) {
        self.put(old, "");
    }

    /// `text` with everything in its place.
    pub(super) fn join(mut self, text: &str) -> String {
        // What is put before a cut's first byte stays.
        self.0.sort_by_key(|(old, _)| (old.start, old.end));
        let new: usize = self.0.iter().map(|(_, new)| new.len()).sum();
        let mut joined = String::with_capacity(text.len() + new);
        let mut done = 0;
        for (old, new) in &self.0 {
            if old.start >= done {
                joined.push_str(&text[done..old.start]);
                joined.push_str(new);
            }
            done = done.max(old.end);
        }
        joined.push_str(&text[done..]);
        joined
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_stands_in_the_order_of_the_text() {
        let mut splice = Splice::default();
        splice.put(3..4, "D");
        splice.put(1..1, "x");
        splice.put(1..1, "y");
        assert_eq!(splice.join("abcde"), "axybcDe");
        assert_eq!(Splice::default().join("abcde"), "abcde");
    }

    #[test]
    fn a_cut_takes_with_it_what_was_put_inside() {
        let mut splice = Splice::default();
        splice.put(2..3, "C");
        splice.cut(1..4);
        splice.cut(3..5);
        splice.put(5..5, "!");
        splice.put(1..1, "?");
        assert_eq!(splice.join("abcdef"), "a?!f");
    }
}
