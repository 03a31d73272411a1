//! The text of a file with a genome, in whatever encoding it was saved.
//!
//! Owns how bytes become text: here and nowhere else. A mark at the beginning decides, then what bytes of UTF-16 look like,
//! then the XML declaration; else it is UTF-8. Never changes a file.
//!
//! Start at [`text`].

use std::fs::File;
use std::io::{self, Read};
use std::ops::Range;
use std::path::Path;

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE};

use super::Refused;
use crate::program::Exit;

/// Most bytes of a file: as many as the longest text that is read as flames, 16 MiB, has in UTF-16, with its mark.
const MOST_BYTES: u64 = (32 << 20) + 2;
/// What may stand before the `<` of a text without a mark: tabs, ends of lines, spaces.
const BLANKS: [u16; 4] = [0x09, 0x0A, 0x0D, 0x20];
/// Bytes in which an XML declaration is searched.
const DECLARATION: usize = 1024;

/// Why the bytes of a file are no text.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum TextError {
    /// They are not of the encoding that the file has by its mark or its declaration.
    #[error("line {line} has bytes that are not {encoding}")]
    Bytes {
        /// The line of the first of them, from 1.
        line: usize,
        /// The name of the encoding.
        encoding: &'static str,
    },
    /// An XML declaration names an encoding that nobody knows.
    #[error(
        "its encoding is `{found}`, which is not known (expected UTF-8, UTF-16, ISO-8859-1 or another of the web's)"
    )]
    Encoding {
        /// The name found; a long one is cut.
        found: String,
    },
    /// There are more of them than are read.
    #[error("it has more than {MOST_BYTES} bytes, which are not read as a genome")]
    Long,
}

/// The text of the file at `path`, without a mark at its beginning and zeros at its end. Where it is not saved as UTF-8, blanks
/// stand in place of the encoding that it declares, so that it may be saved as UTF-8; lines and columns stay.
/// Errors: [`Exit::Unreadable`] with the system's error; [`Exit::Malformed`] with [`TextError`].
pub fn text(path: &Path) -> Result<String, Refused> {
    let unread = |source: io::Error| Refused { exit: Exit::Unreadable, source: source.into(), hint: None };
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(MOST_BYTES + 1).read_to_end(&mut bytes)).map_err(unread)?;
    let text = if bytes.len() as u64 > MOST_BYTES { Err(TextError::Long) } else { decoded(bytes) };
    text.map_err(|error| {
        let hint = (error != TextError::Long).then_some("save it as UTF-8");
        Refused { exit: Exit::Malformed, source: error.into(), hint }
    })
}

/// The text of `bytes`.
fn decoded(bytes: Vec<u8>) -> Result<String, TextError> {
    let (encoding, marked) = match Encoding::for_bom(&bytes) {
        Some(marked) => marked,
        None => (unmarked(&bytes)?, 0),
    };
    let is_utf8 = encoding == UTF_8;
    let mut text = if is_utf8 && marked == 0 {
        String::from_utf8(bytes).map_err(|error| wrong(error.as_bytes(), encoding))?
    } else {
        let content = &bytes[marked..];
        // A file that was filled up with zeros may end within a character.
        let is_torn = encoding != UTF_8 && is_utf16(encoding) && content.len() % 2 == 1 && content.ends_with(&[0]);
        let content = &content[..content.len() - usize::from(is_torn)];
        let text = encoding.decode_without_bom_handling_and_without_replacement(content);
        text.ok_or_else(|| wrong(content, encoding))?.into_owned()
    };
    text.truncate(text.trim_end_matches('\0').len());
    if let Some(declared) = encoding_in(&text).filter(|_| !is_utf8) {
        text.replace_range(declared.clone(), &" ".repeat(declared.len()));
    }
    Ok(text)
}

/// The encoding of `bytes` that begin without a mark.
fn unmarked(bytes: &[u8]) -> Result<&'static Encoding, TextError> {
    for (encoding, unit) in [(UTF_16LE, u16::from_le_bytes as fn([u8; 2]) -> u16), (UTF_16BE, u16::from_be_bytes)] {
        let mut units = bytes.as_chunks().0.iter().map(|pair| unit(*pair));
        if units.find(|unit| !BLANKS.contains(unit)) == Some(u16::from(b'<')) {
            return Ok(encoding);
        }
    }
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(DECLARATION)]);
    let Some(declared) = encoding_in(&head) else { return Ok(UTF_8) };
    let label = head[declared].split(['"', '\'']).nth(1).unwrap_or_default();
    match Encoding::for_label(label.as_bytes()) {
        // It could not be read if it were.
        Some(encoding) if is_utf16(encoding) => Ok(UTF_8),
        Some(encoding) => Ok(encoding),
        None => Err(TextError::Encoding { found: label.chars().take(40).collect() }),
    }
}

/// Where an XML declaration at the beginning of `text`, or after blanks there, says the encoding: `encoding="..."`.
fn encoding_in(text: &str) -> Option<Range<usize>> {
    let declaration = &text[..text.trim_start().starts_with("<?xml").then(|| text.find("?>"))??];
    let start = declaration.find("encoding")?;
    let quote = start + declaration[start..].find(['"', '\''])?;
    let end = quote + 1 + declaration[quote + 1..].find(&declaration[quote..=quote])?;
    Some(start..end + 1)
}

fn is_utf16(encoding: &'static Encoding) -> bool {
    encoding == UTF_16LE || encoding == UTF_16BE
}

/// What is wrong with `bytes`: the line of the first one that is.
fn wrong(bytes: &[u8], encoding: &'static Encoding) -> TextError {
    let mut decoder = encoding.new_decoder_without_bom_handling();
    let mut before = String::with_capacity(decoder.max_utf8_buffer_length(bytes.len()).unwrap_or(0));
    let _ = decoder.decode_to_string_without_replacement(bytes, &mut before, true);
    TextError::Bytes { line: before.matches('\n').count() + 1, encoding: encoding.name() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAME: &str = "<flame name=\"Z\u{fc}rich \u{2013} \u{e9}t\u{e9}\"/>\n";

    fn utf16(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(bytes).collect()
    }

    #[test]
    fn a_text_is_the_same_in_every_encoding() {
        let declared = |encoding: &str| format!("<?xml version='1.0' encoding=\"{encoding}\"?>{NAME}");
        let latin = |text: &str, dash: u8| -> Vec<u8> {
            text.chars().map(|c| if c == '\u{2013}' { dash } else { u8::try_from(u32::from(c)).unwrap() }).collect()
        };
        let marked = format!("\u{feff}{NAME}");
        for bytes in [
            NAME.as_bytes().to_vec(),
            marked.clone().into_bytes(),
            [NAME.as_bytes(), &[0; 7]].concat(),
            utf16(&marked, u16::to_le_bytes),
            utf16(&marked, u16::to_be_bytes),
            utf16(NAME, u16::to_le_bytes),
            utf16(NAME, u16::to_be_bytes),
            [utf16(NAME, u16::to_le_bytes), vec![0; 5]].concat(),
        ] {
            assert_eq!(decoded(bytes).unwrap(), NAME);
        }
        for (encoding, dash) in [("windows-1252", 0x96), ("ISO-8859-1", 0x96)] {
            let blanked = format!("<?xml version='1.0' {}?>{NAME}", " ".repeat(encoding.len() + 11));
            assert_eq!(decoded(latin(&declared(encoding), dash)).unwrap(), blanked);
            assert_eq!(decoded(blanked.clone().into_bytes()).unwrap(), blanked, "it may be saved as UTF-8");
        }
        for untrue in ["utf-16", "UTF-8"] {
            assert_eq!(decoded(declared(untrue).into_bytes()).unwrap(), declared(untrue));
        }
        let wide = utf16(&declared("UTF-16"), u16::to_le_bytes);
        assert_eq!(decoded(wide).unwrap(), declared("UTF-16").replace("encoding=\"UTF-16\"", &" ".repeat(17)));
    }

    #[test]
    fn blanks_may_stand_before_a_text_in_every_encoding() {
        let units: [fn(u16) -> [u8; 2]; 2] = [u16::to_le_bytes, u16::to_be_bytes];
        for blanks in ["\n", " ", "\r\n\t "] {
            let text = format!("{blanks}{NAME}");
            let declared = format!("{blanks}<?xml version='1.0' encoding=\"ISO-8859-1\"?><flame name='\u{fc}'/>");
            for bytes in units {
                assert_eq!(decoded(utf16(&text, bytes)).unwrap(), text);
            }
            assert_eq!(decoded(text.clone().into_bytes()).unwrap(), text);
            let latin: Vec<u8> = declared.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
            assert_eq!(decoded(latin).unwrap(), declared.replace("encoding=\"ISO-8859-1\"", &" ".repeat(21)));
        }
        assert_eq!(decoded(utf16(" \n", u16::to_le_bytes)).unwrap(), " \0\n", "blanks alone are no UTF-16");
    }

    #[test]
    fn bytes_that_are_no_text_are_named_with_their_line() {
        let of = |bytes: &[u8]| decoded(bytes.to_vec()).unwrap_err().to_string();
        assert_eq!(of(b"<flame\nname='Z\xfcrich'/>"), "line 2 has bytes that are not UTF-8");
        assert_eq!(of(b"\xef\xbb\xbfa\n\n\xff"), "line 3 has bytes that are not UTF-8");
        assert_eq!(of(b"\xff\xfe<\0\n\0\0\xd8<\0"), "line 2 has bytes that are not UTF-16LE");
        let unknown = of(b"<?xml version=\"1.0\" encoding='EBCDIC-7'?><flame/>");
        assert!(unknown.starts_with("its encoding is `EBCDIC-7`, which is not known"), "{unknown}");
    }
}
