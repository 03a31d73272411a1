//! A parser of our signed texts, line by line.
//!
//! Counts lines, so that errors name them. No line is skipped, and each must have its only valid spelling.

use flock::excerpt;

use crate::names::NameError;
use crate::refusal::{Part, Refusal};

/// The unread lines of a text.
pub(crate) struct Lines<'a> {
    part: Part,
    rest: &'a str,
    line: usize,
}

impl<'a> Lines<'a> {
    /// The lines of `text`, each of which must end.
    pub(crate) fn new(part: Part, text: &'a str) -> Self {
        Self { part, rest: text, line: 0 }
    }

    /// The next line, without its end; `None` after the last.
    pub(crate) fn next(&mut self, wanted: &'static str) -> Result<Option<&'a str>, Refusal> {
        if self.rest.is_empty() {
            return Ok(None);
        }
        self.line += 1;
        match self.rest.split_once('\n') {
            Some((line, rest)) => {
                self.rest = rest;
                Ok(Some(line))
            }
            None => Err(self.wrong_line(wanted, self.rest)),
        }
    }

    /// The next line, which must be `wanted`.
    pub(crate) fn expect_line(&mut self, wanted: &'static str) -> Result<(), Refusal> {
        match self.next(wanted)? {
            Some(line) if line == wanted => Ok(()),
            line => Err(self.wrong_line(wanted, line.unwrap_or_default())),
        }
    }

    /// The value after `key` and a space on the next line.
    pub(crate) fn value(&mut self, key: &str, wanted: &'static str) -> Result<&'a str, Refusal> {
        let line = self.next(wanted)?.unwrap_or_default();
        let value = line.strip_prefix(key).and_then(|rest| rest.strip_prefix(' '));
        value.ok_or_else(|| self.wrong_line(wanted, line))
    }

    /// The same, if the next line begins so; no line is read if it does not.
    pub(crate) fn optional_value(&mut self, key: &str, wanted: &'static str) -> Result<Option<&'a str>, Refusal> {
        let is_next = self.rest.strip_prefix(key).is_some_and(|rest| rest.starts_with(' '));
        if is_next { self.value(key, wanted).map(Some) } else { Ok(None) }
    }

    /// There must be no more lines.
    pub(crate) fn end(&mut self) -> Result<(), Refusal> {
        match self.next("the end")? {
            None => Ok(()),
            Some(line) => Err(self.wrong_line("the end", line)),
        }
    }

    /// All unread lines, as they are.
    pub(crate) fn rest(self) -> &'a str {
        self.rest
    }

    /// The error for the last line, if it is invalid.
    pub(crate) fn wrong_line(&self, wanted: &'static str, found: &str) -> Refusal {
        Refusal::Line { part: self.part.clone(), line: self.line, wanted, found: excerpt(found) }
    }

    /// The error for an invalid name on the last line.
    pub(crate) fn bad_name(&self, source: NameError) -> Refusal {
        Refusal::Name { part: self.part.clone(), line: self.line, source }
    }

    /// The number of the last line, from 1.
    pub(crate) fn line(&self) -> usize {
        self.line
    }
}
