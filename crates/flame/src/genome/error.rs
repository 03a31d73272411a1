//! Why a file is not a genome.
//!
//! Owns the errors of reading; those of rendering are `RenderError`.
//!
//! Start at [`GenomeError`].

/// Why a text is not a genome, or not one genome.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum GenomeError {
    /// An attribute's value cannot be read.
    #[error("line {line}: attribute `{attribute}` of `{element}` is `{value}`, expected {expected}")]
    Attribute {
        /// Line of the element, from 1.
        line: u32,
        /// The element's tag.
        element: String,
        /// The attribute's name.
        attribute: String,
        /// The value found.
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
    /// Elements are nested too deep.
    #[error("line {line}: elements are nested more than {most} deep")]
    Deep {
        /// Line of the first element that is too deep, from 1.
        line: u32,
        /// How many may.
        most: usize,
    },
    /// Colours are given in a form that makes no sense.
    #[error("line {line}: palette `{element}` has {found}, expected {expected}")]
    Palette {
        /// Line of the element, from 1.
        line: u32,
        /// The element's tag.
        element: String,
        /// The value found.
        found: String,
        /// The expected value.
        expected: &'static str,
    },
    /// Something is there twice that may be there once.
    #[error("line {line}: a flame has one `{element}`, found a second one")]
    Second {
        /// Line of the second one, from 1.
        line: u32,
        /// The element's tag.
        element: &'static str,
    },
    /// The text is not XML.
    #[error("not well-formed XML: {reason}")]
    Xml {
        /// The message of the XML parser, with line and column.
        reason: String,
    },
}
