//! The plain form of a manifest, read without building a document.
//!
//! Owns the subset of TOML that almost every manifest keeps to: a head, then `[[...]]` tables of one `key = value` a
//! line, each value a number or a text without escapes. A million transitions are read in a fraction of a second and
//! in place, where a whole TOML document would take gigabytes. Never refuses and never guesses: on anything else,
//! right or wrong, it gives up, and `manifest.rs` asks the TOML parser, which also words the errors.
//!
//! Start at [`Blocks::split`].

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

/// What one line of a table says.
enum Line<'t> {
    Header(&'t str),
    Entry(PlainEntry<'t>),
    Nothing,
}

impl<'t> Blocks<'t> {
    /// Splits `text` into its head, which is TOML of any form, and its tables. `None` if it has characters that TOML
    /// forbids somewhere.
    pub(crate) fn split(text: &'t str) -> Option<(&'t str, Self)> {
        let bytes = text.as_bytes();
        let odd = |&byte: &u8| byte == 0x7f || (byte < 0x20 && byte != b'\n' && byte != b'\t');
        // Whole pieces at a time, so that the compiler looks at many bytes at once.
        if bytes.chunks(4096).any(|piece| piece.iter().fold(false, |found, byte| found | odd(byte))) {
            return None;
        }
        let mut at = 0;
        while let Some(line) = line_at(text, at) {
            if line.trim_start_matches([' ', '\t']).starts_with("[[") {
                break;
            }
            at += line.len() + 1;
        }
        let at = at.min(text.len());
        Some((&text[..at], Self { text, at }))
    }

    /// Reads the next table into `block`. `Some(false)` at the end of the text, `None` where it is not plain.
    pub(crate) fn next(&mut self, block: &mut Block<'t>) -> Option<bool> {
        block.entries.clear();
        let mut begun = false;
        while let Some(line) = line_at(self.text, self.at) {
            let start = self.at;
            match read(line, start)? {
                Line::Header(_) if begun => return Some(true),
                Line::Header(name) => {
                    (block.name, block.at) = (name, start);
                    begun = true;
                }
                Line::Entry(_) if !begun => return None,
                Line::Entry(entry) if block.entries.iter().any(|other| other.key == entry.key) => return None,
                Line::Entry(entry) => block.entries.push(entry),
                Line::Nothing => {}
            }
            self.at += line.len() + 1;
        }
        Some(begun)
    }
}

impl Block<'_> {
    /// A table to be read into.
    pub(crate) fn new() -> Self {
        Self { name: "", at: 0, entries: Vec::new() }
    }
}

/// The line that starts at `at`, without its end; `None` behind the last.
fn line_at(text: &str, at: usize) -> Option<&str> {
    let rest = text.get(at..)?;
    Some(rest.split_once('\n').map_or(rest, |(line, _)| line)).filter(|line| !line.is_empty() || !rest.is_empty())
}

/// What `line`, which starts at `start`, says. `None` if it is not plain.
fn read(line: &str, start: usize) -> Option<Line<'_>> {
    let blank = [' ', '\t'];
    let said = line.trim_start_matches(blank);
    if said.is_empty() || said.starts_with('#') {
        return Some(Line::Nothing);
    }
    if let Some(header) = said.strip_prefix("[[") {
        let (name, rest) = header.split_once("]]")?;
        return (is_bare(name) && is_over(rest)).then_some(Line::Header(name));
    }
    let (key, rest) = said.split_once('=')?;
    let key = key.trim_end_matches(blank);
    let value = rest.trim_start_matches(blank);
    let at = start + line.len() - value.len();
    let (value, rest) = if let Some(text) = value.strip_prefix('"') {
        let (text, rest) = text.split_once('"')?;
        (Scalar::Text(text).filter(!text.contains('\\'))?, rest)
    } else {
        let end = value.find(|c: char| blank.contains(&c) || c == '#').unwrap_or(value.len());
        let (number, rest) = value.split_at(end);
        (Scalar::Number(number).filter(is_number(number))?, rest)
    };
    (is_bare(key) && is_over(rest)).then_some(Line::Entry(PlainEntry { key, value, at }))
}

impl Scalar<'_> {
    fn filter(self, fine: bool) -> Option<Self> {
        fine.then_some(self)
    }
}

/// Whether `key` needs no quotes.
fn is_bare(key: &str) -> bool {
    !key.is_empty() && key.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-')
}

/// Whether nothing but a comment comes behind a value.
fn is_over(rest: &str) -> bool {
    let rest = rest.trim_start_matches([' ', '\t']);
    rest.is_empty() || rest.starts_with('#')
}

/// Whether `text` is a plain decimal number.
fn is_number(text: &str) -> bool {
    let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, "0"));
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    digits(whole)
        && (whole.len() == 1 || !whole.starts_with('0'))
        && digits(fraction)
        && digits(exponent.strip_prefix(['+', '-']).unwrap_or(exponent))
}
