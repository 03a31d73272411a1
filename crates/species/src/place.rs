//! A place in a text.
//!
//! Owns how lines and columns are counted, for every error about a text.
//!
//! Start at [`Place`].

use std::fmt::{Display, Formatter};

/// A place in a text, both counted from 1; columns are characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// The line.
    pub line: usize,
    /// The character in it.
    pub column: usize,
}

impl Place {
    /// The place of byte `offset` of `text`; the end of the text if it is beyond it.
    pub fn of(text: &str, offset: usize) -> Place {
        let before = &text.as_bytes()[..offset.min(text.len())];
        let lines = || before.split(|byte| *byte == b'\n');
        // Bytes that continue a character are none of their own.
        let is_start = |byte: &&u8| **byte & 0xc0 != 0x80;
        let last = lines().next_back().unwrap_or_default();
        Place { line: lines().count(), column: last.iter().filter(is_start).count() + 1 }
    }
}

impl Display for Place {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "line {}, column {}", self.line, self.column)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_are_counted_from_one_in_characters() {
        let text = "a\nbä c\n";
        for (offset, line, column) in [(0, 1, 1), (1, 1, 2), (2, 2, 1), (5, 2, 3), (6, 2, 4), (99, 3, 1)] {
            assert_eq!(Place::of(text, offset), Place { line, column }, "{offset}");
        }
        assert_eq!(Place::of("", 0).to_string(), "line 1, column 1");
    }
}
