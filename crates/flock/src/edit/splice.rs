//! Replacement of bytes in a text.
//!
//! Owns the list of replacements and applies them.

use std::ops::Range;

/// Replacements in a text, in any order.
#[derive(Debug, Default)]
pub(super) struct Splice {
    /// The bytes that are replaced, and where what takes their place stands in `new`.
    parts: Vec<(Range<usize>, Range<usize>)>,
    /// All that is put in. There may be a million parts, of a few bytes each.
    new: String,
}

impl Splice {
    /// None yet; memory for so many.
    pub(super) fn of(count: usize) -> Self {
        Self { parts: Vec::with_capacity(count), new: String::new() }
    }

    /// Puts `new` in place of the bytes at `old`; of several at the same place the first put comes first.
    pub(super) fn put(&mut self, old: Range<usize>, new: &str) {
        let start = self.new.len();
        self.new.push_str(new);
        self.parts.push((old, start..self.new.len()));
    }

    /// Takes the bytes at `old` away, and with them whatever else is put there.
    pub(super) fn cut(&mut self, old: Range<usize>) {
        self.put(old, "");
    }

    /// `text` with everything in its place, in the memory of `text`: there may not be enough for two of them.
    pub(super) fn join(mut self, text: String) -> String {
        if self.parts.is_empty() {
            return text;
        }
        // What is put before a cut's first byte stays.
        self.parts.sort_by_key(|(old, _)| (old.start, old.end));
        let (mut bytes, more) = (text.into_bytes(), self.new.len());
        let end = bytes.len();
        // The text moves up by all that is put in: so the place that is written to never comes up with the one that is read.
        bytes.reserve_exact(more);
        bytes.resize(end + more, 0);
        bytes.copy_within(..end, more);
        let (mut done, mut written) = (0, 0);
        for (old, new) in self.parts.into_iter().chain([(end..end, 0..0)]) {
            if old.start >= done {
                bytes.copy_within(more + done..more + old.start, written);
                written += old.start - done;
                bytes[written..written + new.len()].copy_from_slice(&self.new.as_bytes()[new.clone()]);
                written += new.len();
            }
            done = done.max(old.end);
        }
        bytes.truncate(written);
        String::from_utf8(bytes).expect("parts of texts are texts")
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
        assert_eq!(splice.join("abcde".to_owned()), "axybcDe");
        assert_eq!(Splice::default().join("abcde".to_owned()), "abcde");
    }

    #[test]
    fn a_text_may_become_longer_or_shorter_by_far() {
        for (old, new) in
            [(0..0, "0123456789"), (3..3, "0123456789"), (0..5, "x"), (1..4, ""), (5..5, "!"), (2..3, "ää")]
        {
            let mut splice = Splice::default();
            splice.put(old.clone(), new);
            splice.put(4..5, "y");
            let mut expected = "abcdy".to_owned();
            match old.end {
                5 if old.start == 5 => expected.push_str(new),
                5 => expected = new.to_owned(),
                _ => expected.replace_range(old, new),
            }
            assert_eq!(splice.join("abcde".to_owned()), expected);
        }
    }

    #[test]
    fn a_cut_takes_with_it_what_was_put_inside() {
        let mut splice = Splice::default();
        splice.put(2..3, "C");
        splice.cut(1..4);
        splice.cut(3..5);
        splice.put(5..5, "!");
        splice.put(1..1, "?");
        assert_eq!(splice.join("abcdef".to_owned()), "a?!f");
    }
}
