//! Text as nested forms, each with its place.
//!
//! Owns parentheses, strings, comments, and the limits on a text's length and depth. Never knows what a form means:
//! `reader.rs` does.
//!
//! Start at [`read`].

use ::species::Place;

use crate::error::ExpressionError;
use crate::node::DEEPEST;

/// The most bytes of a text.
pub const MOST_BYTES: usize = 64 << 10;

/// A form: an atom, a string, or a list of forms.
#[derive(Debug)]
pub(crate) struct Form<'t> {
    pub(crate) place: Place,
    /// As it is written.
    pub(crate) text: &'t str,
    pub(crate) kind: Kind<'t>,
}

#[derive(Debug)]
pub(crate) enum Kind<'t> {
    /// A name or a number.
    Atom,
    /// `( ... )`
    List(Vec<Form<'t>>),
    /// `" ... "`, without the quotes.
    Text(String),
    /// `#( ... )`
    Vector(Vec<Form<'t>>),
}

/// What is left of a text.
struct Rest<'t> {
    text: &'t str,
    /// Bytes that are read.
    at: usize,
    place: Place,
    depth: usize,
}

/// The one form of a text.
pub(crate) fn read(text: &str) -> Result<Form<'_>, ExpressionError> {
    let mut rest = Rest { text, at: 0, place: Place { line: 1, column: 1 }, depth: 0 };
    if text.len() > MOST_BYTES {
        while rest.at < MOST_BYTES {
            rest.take();
        }
        return Err(ExpressionError::Long { place: rest.place, most: MOST_BYTES });
    }
    rest.skip();
    let form = rest.form()?;
    rest.skip();
    if rest.peek().is_some() { Err(rest.expected("the end of the text")) } else { Ok(form) }
}

impl<'t> Rest<'t> {
    fn peek(&self) -> Option<char> {
        self.text[self.at..].chars().next()
    }

    fn take(&mut self) -> Option<char> {
        let next = self.peek()?;
        self.at += next.len_utf8();
        self.place = match next {
            '\n' => Place { line: self.place.line + 1, column: 1 },
            _ => Place { column: self.place.column + 1, ..self.place },
        };
        Some(next)
    }

    fn expected(&self, wants: &'static str) -> ExpressionError {
        ExpressionError::Syntax { place: self.place, wants }
    }

    /// Goes past space, and comments from `;` to the line's end.
    fn skip(&mut self) {
        while let Some(next) = self.peek() {
            if next == ';' {
                while self.peek().is_some_and(|next| next != '\n') {
                    self.take();
                }
            } else if next.is_whitespace() {
                self.take();
            } else {
                return;
            }
        }
    }

    fn form(&mut self) -> Result<Form<'t>, ExpressionError> {
        let (place, start) = (self.place, self.at);
        let kind = match self.peek() {
            Some('(') => Kind::List(self.forms(place)?),
            Some('"') => Kind::Text(self.string()?),
            Some('#') => {
                self.take();
                if self.peek() != Some('(') {
                    return Err(self.expected("`(` after `#`"));
                }
                Kind::Vector(self.forms(place)?)
            }
            Some(next) if is_of_an_atom(next) => {
                while self.peek().is_some_and(is_of_an_atom) {
                    self.take();
                }
                Kind::Atom
            }
            _ => return Err(self.expected("a form")),
        };
        Ok(Form { place, text: &self.text[start..self.at], kind })
    }

    /// All forms up to the parenthesis that closes the next one, which opens.
    fn forms(&mut self, place: Place) -> Result<Vec<Form<'t>>, ExpressionError> {
        if self.depth == DEEPEST {
            return Err(ExpressionError::Deep { place, most: DEEPEST });
        }
        self.depth += 1;
        self.take();
        let mut forms = Vec::new();
        loop {
            self.skip();
            match self.peek() {
                Some(')') => break,
                Some(_) => forms.push(self.form()?),
                None => return Err(self.expected("`)`")),
            }
        }
        self.take();
        self.depth -= 1;
        Ok(forms)
    }

    fn string(&mut self) -> Result<String, ExpressionError> {
        self.take();
        let mut string = String::new();
        loop {
            match self.take() {
                Some('"') => return Ok(string),
                Some('\\') => string.push(self.take().ok_or_else(|| self.expected("`\"`"))?),
                Some(next) => string.push(next),
                None => return Err(self.expected("`\"`")),
            }
        }
    }
}

fn is_of_an_atom(next: char) -> bool {
    !next.is_whitespace() && !matches!(next, '(' | ')' | '"' | '#' | ';')
}
