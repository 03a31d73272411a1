//! Why a file is not a genome.
//!
//! Owns the errors of reading; those of rendering are `RenderError`.
//!
//! Start at [`GenomeError`].

use std::fmt;

/// Where something stands in a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// The line, from 1.
    pub line: u32,
    /// The column in characters, from 1.
    pub column: u32,
}

/// Why a text is not a genome, or not one genome.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum GenomeError {
    /// An attribute's value cannot be read.
    #[error("{place}: attribute `{attribute}` of `{element}` is `{value}`, expected {expected}")]
    Attribute {
        /// Where the attribute stands.
        place: Place,
        /// The element's tag.
        element: String,
        /// The attribute's name.
        attribute: String,
        /// The value found; a long one is cut.
        value: String,
        /// The expected value.
        expected: &'static str,
    },
    /// The text holds another number of flames than one.
    #[error("found {found} flames, expected one")]
    Count {
        /// How many there are.
        found: usize,
    },
    /// A flame consists of layers, as `JWildfire` mixes them.
    #[error(
        "{place}: a `jwf-flame` has layers, which are not drawn, expected a `flame`, or one visible layer of weight 1 and \
         density 1"
    )]
    Layers {
        /// Where it begins.
        place: Place,
    },
    /// The text holds more than is read.
    #[error("{place}: {found} {what}, at most {most} are read")]
    Limit {
        /// Where the limit is passed.
        place: Place,
        /// What there is too much of.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many may be.
        most: usize,
    },
    /// A library lacks the palette that a genome names.
    #[error("palette {number} is not among the {found} of the library")]
    NoSuchPalette {
        /// Its number.
        number: i32,
        /// How many palettes the library has.
        found: usize,
    },
    /// The key frames of a file are not in the order of their times.
    #[error("flame {number} of the file has time {found}, expected more than the {before} of the one before it")]
    Order {
        /// The number of the flame, from 1.
        number: usize,
        /// Its time.
        found: f64,
        /// The time of the one before it.
        before: f64,
    },
    /// Colours are given in a form that makes no sense.
    #[error("{place}: palette `{element}` has {found}, expected {expected}")]
    Palette {
        /// Where the element begins.
        place: Place,
        /// The element's tag.
        element: String,
        /// The value found.
        found: String,
        /// The expected value.
        expected: &'static str,
    },
    /// The text is not XML.
    #[error("not well-formed XML: {reason}")]
    Xml {
        /// The message of the XML parser, with line and column.
        reason: String,
    },
}

impl Place {
    /// Where every text begins.
    pub(super) const START: Place = Place { line: 1, column: 1 };

    /// The place behind `text`, which begins here.
    pub(super) fn after(self, text: &str) -> Place {
        self.of_inner(Place::of(text, text.len()))
    }

    /// The place in the whole text of a place in a part of it that begins here.
    pub(super) fn of_inner(self, inner: Place) -> Place {
        let column = if inner.line == 1 { self.column + inner.column - 1 } else { inner.column };
        Place { line: self.line + inner.line - 1, column }
    }

    /// The place of the byte `at` in `text`.
    pub(super) fn of(text: &str, at: usize) -> Place {
        let before = &text[..text.floor_char_boundary(at)];
        let (lines, last) = before.rsplit_once('\n').map_or((0, before), |(above, last)| (newlines(above) + 1, last));
        Place { line: lines as u32 + 1, column: last.chars().count() as u32 + 1 }
    }
}

/// How many lines end in `text`; counted byte by byte, which the compiler does for many at once.
fn newlines(text: &str) -> usize {
    text.bytes().filter(|byte| *byte == b'\n').count()
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, column {}", self.line, self.column)
    }
}

impl GenomeError {
    /// The same error in a text of which the one that was read is a part: it begins at `start`, behind `columns`
    /// characters of its own.
    pub(super) fn moved(mut self, start: Place, columns: usize) -> GenomeError {
        let place = match &mut self {
            GenomeError::Attribute { place, .. }
            | GenomeError::Layers { place }
            | GenomeError::Limit { place, .. }
            | GenomeError::Palette { place, .. } => place,
            GenomeError::Count { .. }
            | GenomeError::NoSuchPalette { .. }
            | GenomeError::Order { .. }
            | GenomeError::Xml { .. } => return self,
        };
        if place.line == 1 {
            place.column -= columns as u32;
        }
        *place = start.of_inner(*place);
        self
    }
}
