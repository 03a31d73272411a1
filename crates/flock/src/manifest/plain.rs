//! The plain form of a manifest, read without building a document.
//!
//! Owns the subset of TOML that almost every manifest keeps to: a head, then `[[...]]` tables of one `key = value` a
//! line, each value a number or a text without escapes. For any other text, valid or not, it returns no result, and
//! `mod.rs` uses the TOML parser, for the reasons given there.
//!
//! Start at [`Blocks::split`].

use super::table::MAX_KEYS;

/// The tables of a plain manifest, one after another.
pub(crate) struct Blocks<'t> {
    text: &'t str,
    /// Where the next line starts.
    at: usize,
}

/// One `[[...]]` table, its lines read.
pub(crate) struct Block<'t> {
    /// What stands between the brackets.
    pub(crate) name: &'t str,
    /// Where it starts, in bytes from the start of the text.
    pub(crate) at: usize,
    /// In the order of the file, no key twice.
    pub(crate) entries: Vec<PlainEntry<'t>>,
}

/// One `key = value` line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlainEntry<'t> {
    /// As written.
    pub(crate) key: &'t str,
    /// As meant.
    pub(crate) value: Scalar<'t>,
    /// Where the value starts, in bytes from the start of the text.
    pub(crate) at: usize,
}

/// A value that takes no parsing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scalar<'t> {
    /// Digits, perhaps with a fraction and an exponent: no sign, no leading zero, no underscore.
    Number(&'t str),
    /// What stands between the quotes.
    Text(&'t str),
}

impl<'t> Blocks<'t> {
    /// Splits `text` into its head, which is TOML of any form, and its tables.
    /// Errors: The first character that TOML does not allow everywhere, in bytes from the start.
    pub(crate) fn split(text: &'t str) -> Result<(&'t str, Self), usize> {
        let bytes = text.as_bytes();
        let odd = |&byte: &u8| byte == 0x7f || (byte < 0x20 && byte != b'\n' && byte != b'\t');
        // In blocks, so that the compiler can vectorise.
        if bytes.chunks(4096).any(|piece| piece.iter().fold(false, |found, byte| found | odd(byte))) {
            return Err(bytes.iter().position(odd).unwrap_or_default());
        }
        let mut at = 0;
        while let Some(line) = line_at(text, at) {
            if line.trim_start_matches([' ', '\t']).starts_with("[[") {
                break;
            }
            at += line.len() + 1;
        }
        let at = at.min(text.len());
        Ok((&text[..at], Self { text, at }))
    }

    /// Where the next line starts, in bytes from the start of the text: the line that is not plain, if one was not.
    pub(crate) fn at(&self) -> usize {
        self.at
    }

    /// Reads the next table into `block`. `Some(false)` at the end of the text, `None` where it is not plain.
    pub(crate) fn next(&mut self, block: &mut Block<'t>) -> Option<bool> {
        let bytes = self.text.as_bytes();
        block.entries.clear();
        let mut begun = false;
        loop {
            let at = behind(bytes, self.at, is_blank);
            self.at = match bytes.get(at) {
                None => return Some(begun),
                Some(b'\n' | b'#') => line_end(bytes, at)?,
                Some(b'[') if begun => return Some(true),
                Some(b'[') => {
                    let (name, end) = header(self.text, at)?;
                    (block.name, block.at, begun) = (name, at, true);
                    line_end(bytes, end)?
                }
                Some(_) if !begun => return None,
                Some(_) => {
                    let (entry, end) = entry(self.text, at)?;
                    let is_known = block.entries.iter().any(|other| other.key == entry.key);
                    if is_known || block.entries.len() == MAX_KEYS {
                        return None;
                    }
                    block.entries.push(entry);
                    line_end(bytes, end)?
                }
            };
        }
    }
}

impl Block<'_> {
    /// A table to be read into.
    pub(crate) fn new() -> Self {
        Self { name: "", at: 0, entries: Vec::new() }
    }
}

/// The line that starts at `at`, without its end; `None` after the last.
fn line_at(text: &str, at: usize) -> Option<&str> {
    let rest = text.get(at..)?;
    Some(rest.split_once('\n').map_or(rest, |(line, _)| line)).filter(|line| !line.is_empty() || !rest.is_empty())
}

/// The first position from `at` on whose byte is not in `within`.
fn behind(bytes: &[u8], at: usize, within: impl Fn(u8) -> bool) -> usize {
    let rest = bytes.get(at..).unwrap_or_default();
    at + rest.iter().position(|&byte| !within(byte)).unwrap_or(rest.len())
}

fn is_blank(byte: u8) -> bool {
    byte == b' ' || byte == b'\t'
}

/// Whether a key with this byte needs no quotes.
fn is_bare(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_' || byte == b'-'
}

/// Where the next line starts, if nothing but a comment comes before the end of the one that `at` lies in.
fn line_end(bytes: &[u8], at: usize) -> Option<usize> {
    let at = behind(bytes, at, is_blank);
    match bytes.get(at) {
        None => Some(at),
        Some(b'\n') => Some(at + 1),
        Some(b'#') => Some((behind(bytes, at, |byte| byte != b'\n') + 1).min(bytes.len())),
        Some(_) => None,
    }
}

/// The text between the brackets at `at`, and their end.
fn header(text: &str, at: usize) -> Option<(&str, usize)> {
    let bytes = text.as_bytes();
    let end = behind(bytes, at + 2, is_bare);
    let name = text.get(at + 2..end).filter(|name| !name.is_empty())?;
    (bytes[at..].starts_with(b"[[") && bytes[end..].starts_with(b"]]")).then_some((name, end + 2))
}

/// The entry whose key stands at `start`, and where it ends.
fn entry(text: &str, start: usize) -> Option<(PlainEntry<'_>, usize)> {
    let bytes = text.as_bytes();
    let end = behind(bytes, start, is_bare);
    let key = text.get(start..end).filter(|key| !key.is_empty())?;
    let equals = behind(bytes, end, is_blank);
    if bytes.get(equals) != Some(&b'=') {
        return None;
    }
    let at = behind(bytes, equals + 1, is_blank);
    let (value, end) = if bytes.get(at) == Some(&b'"') {
        let end = behind(bytes, at + 1, |byte| !matches!(byte, b'"' | b'\\' | b'\n'));
        let closed = bytes.get(end) == Some(&b'"');
        (Scalar::Text(text.get(at + 1..end).filter(|_| closed)?), end + 1)
    } else {
        let end = behind(bytes, at, |byte| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'+' | b'-'));
        (Scalar::Number(text.get(at..end).filter(|number| is_number(number))?), end)
    };
    Some((PlainEntry { key, value, at }, end))
}

/// Whether `text` is a plain decimal number.
fn is_number(text: &str) -> bool {
    let bytes = text.as_bytes();
    let digits = |from: usize| behind(bytes, from, |byte| byte.is_ascii_digit());
    let mut end = digits(0);
    if end == 0 || (end > 1 && bytes[0] == b'0') {
        return false;
    }
    for mark in [&b"."[..], b"eE"] {
        if bytes.get(end).is_some_and(|byte| mark.contains(byte)) {
            let is_signed = mark.len() > 1 && matches!(bytes.get(end + 1), Some(b'+' | b'-'));
            let first = end + 1 + usize::from(is_signed);
            end = digits(first);
            if end == first {
                return false;
            }
        }
    }
    end == bytes.len()
}
