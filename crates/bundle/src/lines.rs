//! Reading our own signed texts, line by line, in their only spelling.
//!
//! Owns where in a text one is, so that errors name the line. Never skips anything: every line is wanted, in order.

use flock::told;

use crate::names::NameError;
use crate::refused::{Part, Refused};

/// The lines of a text that are still to be read.
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

    /// The next line, without its end; `None` behind the last.
    pub(crate) fn next(&mut self, wanted: &'static str) -> Result<Option<&'a str>, Refused> {
        if self.rest.is_empty() {
            return Ok(None);
        }
        self.line += 1;
        match self.rest.split_once('\n') {
            Some((line, rest)) => {
                self.rest = rest;
                Ok(Some(line))
            }
            None => Err(self.unlike(wanted, self.rest)),
        }
    }

    /// The next line, which must be `wanted`.
    pub(crate) fn exactly(&mut self, wanted: &'static str) -> Result<(), Refused> {
        match self.next(wanted)? {
            Some(line) if line == wanted => Ok(()),
            line => Err(self.unlike(wanted, line.unwrap_or_default())),
        }
    }

    /// What stands behind `key` and a space on the next line.
    pub(crate) fn value(&mut self, key: &str, wanted: &'static str) -> Result<&'a str, Refused> {
        let line = self.next(wanted)?.unwrap_or_default();
        let value = line.strip_prefix(key).and_then(|rest| rest.strip_prefix(' '));
        value.ok_or_else(|| self.unlike(wanted, line))
    }

    /// The same, if the next line begins so; no line is read if it does not.
    pub(crate) fn value_if_any(&mut self, key: &str, wanted: &'static str) -> Result<Option<&'a str>, Refused> {
        let is_next = self.rest.strip_prefix(key).is_some_and(|rest| rest.starts_with(' '));
        if is_next { self.value(key, wanted).map(Some) } else { Ok(None) }
    }

    /// There must be no more lines.
    pub(crate) fn end(&mut self) -> Result<(), Refused> {
        match self.next("the end")? {
            None => Ok(()),
            Some(line) => Err(self.unlike("the end", line)),
        }
    }

    /// The line read last is not as it must be.
    pub(crate) fn unlike(&self, wanted: &'static str, found: &str) -> Refused {
        Refused::Line { part: self.part.clone(), line: self.line, wanted, found: told(found) }
    }

    /// A name on the line read last is none.
    pub(crate) fn misnamed(&self, source: NameError) -> Refused {
        Refused::Name { part: self.part.clone(), line: self.line, source }
    }

    /// The number of the line read last, from 1.
    pub(crate) fn line(&self) -> usize {
        self.line
    }
}
