//! The owner's file, as people write it.
//!
//! Owns the finding of the file in its folder, and what its bytes are: text in UTF-8, another form of text, or nothing.
//! Never knows a key: `owner.rs` does.
//!
//! Start at [`OwnersText::read`].

use crate::config_file::LARGEST;
use crate::owner::FILE_NAME;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::Path;

/// The marks that some programs begin a text with.
const UTF_8: &[u8] = b"\xef\xbb\xbf";
const UTF_16: [&[u8]; 2] = [b"\xff\xfe", b"\xfe\xff"];

/// What there is in the owner's folder.
#[derive(Debug)]
pub struct OwnersText {
    /// The text of the file, or what it has instead; `None` if there is no file.
    pub text: Option<Result<String, NoText>>,
    /// A file that is meant, and has another name.
    pub misnamed: Option<String>,
}

/// What a file has that is no text for us.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoText {
    /// Nothing, or blanks only.
    #[error("it is empty; lines that begin with `#` alone take all settings back")]
    Empty,
    /// Letters of another encoding, such as Windows-1252.
    #[error("line {line} has characters that are not UTF-8: save it as UTF-8")]
    NotUtf8 {
        /// The first line with one, from 1.
        line: usize,
    },
    /// The encoding that some programs call Unicode.
    #[error("it is saved as UTF-16: save it as UTF-8")]
    Utf16,
}

impl OwnersText {
    /// What there is in `folder`.
    /// Errors: What the file system says, and [`ErrorKind::FileTooLarge`] for a file that is longer than settings may be.
    pub fn read(folder: &Path) -> io::Result<Self> {
        let text = match Self::read_file(&folder.join(FILE_NAME)) {
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            text => Some(text?),
        };
        let misnamed = misnamed(folder, text.is_some())?;
        Ok(Self { text, misnamed })
    }

    /// The text of the plain file at `path`, or what it has instead.
    /// Errors: As of [`Self::read`], and [`ErrorKind::NotFound`].
    pub fn read_file(path: &Path) -> io::Result<Result<String, NoText>> {
        durable::read_plain(path, LARGEST).map(|bytes| decoded(&bytes))
    }
}

/// The owner's file at `path`, whatever its name is.
/// Errors: As of [`OwnersText::read`], and [`ErrorKind::NotFound`].
pub fn read_file(path: &Path) -> io::Result<Result<String, NoText>> {
    durable::read_plain(path, LARGEST).map(|bytes| decoded(&bytes))
}

/// The first name in `folder` that somebody has given to the file. On FAT, capital letters are the same name.
fn misnamed(folder: &Path, is_there: bool) -> io::Result<Option<String>> {
    let names = match fs::read_dir(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        names => names?.map(|entry| Ok(entry?.file_name().into_string().ok())).collect::<io::Result<Vec<_>>>()?,
    };
    let is_itself = |name: &str| name == FILE_NAME || is_there && !names.iter().flatten().any(|name| name == FILE_NAME);
    let is_meant = |name: &&String| {
        let lower = name.to_lowercase();
        lower == format!("{FILE_NAME}.txt") || lower == FILE_NAME && !is_itself(name)
    };
    Ok(names.iter().flatten().filter(is_meant).min().cloned())
}

/// The text in `bytes`, without a mark.
/// Errors: [`NoText`], if there is none.
pub fn decoded(bytes: &[u8]) -> Result<String, NoText> {
    let plain = bytes.strip_prefix(UTF_8).unwrap_or(bytes);
    let mark = UTF_16.into_iter().find_map(|mark| plain.strip_prefix(mark));
    let is_blank = |bytes: &[u8]| bytes.iter().all(|byte| byte.is_ascii_whitespace() || *byte == 0);
    if is_blank(mark.unwrap_or(plain)) {
        return Err(NoText::Empty);
    }
    // Most letters of UTF-16 have a zero at one side: those of ASCII.
    let pairs = plain.chunks_exact(2).filter(|pair| (pair[0] == 0) != (pair[1] == 0)).count();
    if mark.is_some() || pairs * 4 > plain.len() {
        return Err(NoText::Utf16);
    }
    str::from_utf8(plain)
        .map(str::to_owned)
        .map_err(|error| NoText::NotUtf8 { line: plain[..error.valid_up_to()].split(|byte| *byte == b'\n').count() })
}

#[cfg(test)]
mod tests {
    use super::{NoText, OwnersText, decoded};
    use std::fs;

    const TEXT: &str = "# Museum\nunit = \"lobby\"\r\n";

    #[test]
    fn text_is_taken_with_a_mark_and_without_and_any_other_form_is_named() {
        let utf_16 = |unit: u16| unit.to_le_bytes();
        let little: Vec<u8> = TEXT.encode_utf16().flat_map(utf_16).collect();
        let big: Vec<u8> = TEXT.encode_utf16().flat_map(u16::to_be_bytes).collect();
        let with = |mark: &[u8], bytes: &[u8]| [mark, bytes].concat();
        assert_eq!(decoded(TEXT.as_bytes()).unwrap(), TEXT);
        assert_eq!(decoded(&with(b"\xef\xbb\xbf", TEXT.as_bytes())).unwrap(), TEXT);
        assert_eq!(decoded("# Z\u{fc}rich\n".as_bytes()).unwrap(), "# Z\u{fc}rich\n");
        for bytes in [&little, &big, &with(b"\xff\xfe", &little), &with(b"\xfe\xff", &big)] {
            assert_eq!(decoded(bytes), Err(NoText::Utf16), "{bytes:?}");
        }
        let mixed: Vec<u8> = "# \u{4e2d}\u{6587}\u{4e2d}\u{6587}\n".encode_utf16().flat_map(utf_16).collect();
        assert_eq!(decoded(&with(b"\xff\xfe", &mixed)), Err(NoText::Utf16));
        assert_eq!(decoded(b"# Museum\nwifi = \"Caf\xe9\"\n"), Err(NoText::NotUtf8 { line: 2 }));
        for empty in [&b""[..], b" \r\n\t", b"\0\0\0\0", b"\xef\xbb\xbf\n", b"\xff\xfe", b"\xff\xfe\n\0 \0"] {
            assert_eq!(decoded(empty), Err(NoText::Empty), "{empty:?}");
        }
    }

    #[test]
    fn a_name_that_is_meant_is_found_and_no_other() {
        let found = |names: &[&str]| {
            let folder = tempfile::tempdir().unwrap();
            for name in names {
                fs::write(folder.path().join(name), TEXT).unwrap();
            }
            let OwnersText { text, misnamed } = OwnersText::read(folder.path()).unwrap();
            (text.is_some(), misnamed)
        };
        let named = |name: &str| Some(name.to_owned());
        assert_eq!(found(&[]), (false, None));
        assert_eq!(found(&["dreams.toml", "README.txt", "dreams.toml.bak", "._dreams.toml"]), (true, None));
        assert_eq!(found(&["dreams.toml", "dreams.toml.txt"]), (true, named("dreams.toml.txt")));
        assert_eq!(found(&["dreams.toml", "DREAMS.TOML"]), (true, named("DREAMS.TOML")));
        for alone in ["dreams.toml.txt", "Dreams.toml.TXT", "DREAMS.TOML"] {
            assert_eq!(found(&[alone]), (false, named(alone)));
        }
    }
}
