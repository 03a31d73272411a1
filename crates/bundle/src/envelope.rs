//! What every seal has, whatever it stands in front of: a signature, and for whom and when it was made.
//!
//! Owns the way from signed bytes to the text within and back, and the lines that a flock's seal and a system's have in
//! common. Never knows what is sealed: [`crate::Seal`] and [`crate::System`] do.
//!
//! Start at [`opened`].

use std::io::Read;

use crate::beneath;
use crate::key::{KeyError, KeyId};
use crate::limits;
use crate::lines::Lines;
use crate::names::{Addressees, ObjectId, Sequence, UnitId, plain};
use crate::refused::{Part, Refused};
use crate::secret::SecretKey;
use crate::source::Source;
use crate::trust::Trust;

/// What `units` says of a seal for everybody.
const EVERYBODY: &str = "*";
/// What begins the line that says which statements are expected.
const STATEMENTS: &str = "statements";
const TOO_LARGE: Refused = Refused::TooLarge { part: Part::Seal, limit: limits::SEAL };

/// The lines that say for whom a seal is, its number, and when it was made.
pub(crate) struct Address {
    pub(crate) addressees: Addressees,
    pub(crate) sequence: Sequence,
    pub(crate) created: String,
}

/// Why a letter was not signed.
#[derive(Debug, thiserror::Error)]
pub enum SignError {
    /// The key did not sign.
    #[error("cannot seal the bundle")]
    Key(#[source] KeyError),
    /// No unit would take it.
    #[error("no unit would take this bundle")]
    Refused(#[source] Refused),
}

/// Who signed `bytes`, and the text that begins with the line `heading`, once the signature was checked.
///
/// # Errors
/// [`Refused`] if it is too large, or nobody trusted signed it, or as something else.
pub(crate) fn opened<'a>(bytes: &'a [u8], trust: &Trust, heading: &str) -> Result<(KeyId, &'a str), Refused> {
    if bytes.len() as u64 > limits::SEAL {
        return Err(TOO_LARGE);
    }
    trust.verify(&Part::Seal, bytes, heading)
}

/// The bytes of the file of a seal that says `text`; `comment` is for people.
///
/// # Errors
/// [`SignError`] if the key does not sign, or it would be too large.
pub(crate) fn signed(key: &SecretKey, comment: &str, text: &str) -> Result<Vec<u8>, SignError> {
    let bytes = key.sign(comment, text).map_err(SignError::Key)?;
    if bytes.len() as u64 > limits::SEAL {
        return Err(SignError::Refused(TOO_LARGE));
    }
    Ok(bytes)
}

/// The bytes of the seal that `source` has at `path`.
pub(crate) fn read(source: &mut dyn Source, path: &str) -> Result<Vec<u8>, Refused> {
    let read = source.small(path, limits::SEAL).and_then(|reader| beneath::read_all(reader, limits::SEAL));
    read.map_err(|error| {
        if error.kind() == std::io::ErrorKind::FileTooLarge {
            TOO_LARGE
        } else {
            Refused::Read { part: Part::Seal, source: error }
        }
    })
}

/// The line that says which statements about keys a seal expects; nothing if it expects none.
pub(crate) fn statements_text(statements: Option<(ObjectId, u64)>) -> String {
    statements.map_or_else(String::new, |(id, size)| format!("{STATEMENTS} {size} {id}\n"))
}

/// The statements about keys that the next line expects, if it is the line for that, and their size in bytes.
pub(crate) fn statements(lines: &mut Lines<'_>) -> Result<Option<(ObjectId, u64)>, Refused> {
    let wanted = "`statements`, a size and a digest, or nothing";
    let Some(value) = lines.value_if_any(STATEMENTS, wanted)? else { return Ok(None) };
    let (id, size) = sized(lines, value, wanted)?;
    if size > limits::STATEMENTS {
        return Err(Refused::TooLarge { part: Part::Statement, limit: limits::STATEMENTS });
    }
    Ok(Some((id, size)))
}

/// Reads the statements about keys that a seal expects from `source`, which must have them; none if it expects none.
pub(crate) fn expected(statements: Option<(ObjectId, u64)>, source: &mut dyn Source) -> Result<Vec<u8>, Refused> {
    let Some((expected, size)) = statements else { return Ok(Vec::new()) };
    let withheld = |found| Refused::Withheld { expected, found };
    let mut bytes = Vec::new();
    match source.object(&expected, size, 0).and_then(|reader| reader.take(size).read_to_end(&mut bytes)) {
        Ok(_) => {}
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Err(withheld(None)),
        Err(source) => return Err(Refused::Read { part: Part::Statement, source }),
    }
    let found = ObjectId::of(&bytes);
    if found == expected { Ok(bytes) } else { Err(withheld(Some(found))) }
}

impl Address {
    /// The three lines.
    pub(crate) fn to_text(addressees: &Addressees, sequence: Sequence, created: &str) -> String {
        format!("units {}\nsequence {sequence}\ncreated {created}\n", named(addressees))
    }

    pub(crate) fn parse(lines: &mut Lines<'_>) -> Result<Self, Refused> {
        let wanted = "`units` and `*`, or names in order";
        let addressees = addressees(&lines.value("units", wanted).map(str::to_owned)?, lines, wanted)?;
        let sequence = lines.value("sequence", "`sequence` and a number")?;
        let sequence = Sequence::parse(sequence).map_err(|error| lines.misnamed(error))?;
        let wanted = "`created` and a time as 2026-03-01T12:00:00Z";
        let created = lines.value("created", wanted)?.to_owned();
        if !is_time(&created) {
            return Err(lines.unlike(wanted, &created));
        }
        Ok(Self { addressees, sequence, created })
    }
}

/// The object and its size, in bytes, that the line `name` gives.
pub(crate) fn object(lines: &mut Lines<'_>, name: &str, wanted: &'static str) -> Result<(ObjectId, u64), Refused> {
    let value = lines.value(name, wanted)?;
    sized(lines, value, wanted)
}

/// The object and its size, in bytes, that `value` on the line read last gives.
fn sized(lines: &Lines<'_>, value: &str, wanted: &'static str) -> Result<(ObjectId, u64), Refused> {
    let (size, id) = value.split_once(' ').ok_or_else(|| lines.unlike(wanted, value))?;
    let size = plain(size).ok_or_else(|| lines.unlike(wanted, value))?;
    let id = ObjectId::parse(id).map_err(|error| lines.misnamed(error))?;
    Ok((id, size))
}

/// How a seal says for whom it is.
fn named(addressees: &Addressees) -> String {
    match addressees {
        Addressees::Anyone => EVERYBODY.to_owned(),
        units @ Addressees::Units(_) => units.to_string(),
    }
}

/// For whom a seal is that says so in `value`.
fn addressees(value: &str, lines: &Lines<'_>, wanted: &'static str) -> Result<Addressees, Refused> {
    if value == EVERYBODY {
        return Ok(Addressees::Anyone);
    }
    let mut units: Vec<UnitId> = Vec::new();
    for name in value.split(' ') {
        if units.len() == limits::UNITS {
            return Err(Refused::TooMany { part: Part::Seal, limit: limits::UNITS, things: "units" });
        }
        let unit = UnitId::new(name).map_err(|error| lines.misnamed(error))?;
        if units.last().is_some_and(|last| *last >= unit) {
            return Err(lines.unlike(wanted, value));
        }
        units.push(unit);
    }
    Ok(Addressees::Units(units))
}

/// Whether `text` has the form of a time, to the second, in UTC.
fn is_time(text: &str) -> bool {
    const FORM: &[u8] = b"0000-00-00T00:00:00Z";
    let fits = |(found, form): (u8, &u8)| if *form == b'0' { found.is_ascii_digit() } else { found == *form };
    text.len() == FORM.len() && text.bytes().zip(FORM).all(fits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::Folder;
    use crate::seal::tests::letter;
    use crate::seal::{Letter, Unverified};
    use crate::secret::tests::{artist, stranger};
    use crate::trust::Statement;
    use std::fs;

    #[test]
    fn a_seal_is_read_with_the_statements_that_it_expects_or_refused() {
        let scratch = tempfile::tempdir().unwrap();
        let mut folder = Folder::create(scratch.path()).unwrap();
        let said = Statement::Trust(stranger().public()).sign(artist()).unwrap();
        let statements = folder.put_statements(std::slice::from_ref(&said)).unwrap();
        let (id, size) = statements.unwrap();
        let letter = Letter { statements, ..letter(8) };
        let trust = Trust::of([artist().public()]);
        let seal = |letter: &Letter| Unverified::new(letter.sign(artist()).unwrap()).verify(&trust).unwrap();
        let bound = seal(&letter);
        assert!(bound.letter() == &letter && bound.bytes().ends_with(format!("statements {size} {id}\n").as_bytes()));
        assert_eq!(bound.expected_statements(&mut folder).unwrap(), said);
        let plain = seal(&Letter { statements: None, ..letter.clone() });
        assert_eq!(plain.expected_statements(&mut folder).unwrap(), b"");

        let path = scratch.path().join(id.path());
        for other in [&said[..said.len() - 1], b"", &said.repeat(2)[1..]] {
            fs::write(&path, other).unwrap();
            let refused = bound.expected_statements(&mut folder).unwrap_err();
            let other = ObjectId::of(&other[..other.len().min(said.len())]);
            let is_withheld = matches!(refused, Refused::Withheld { expected, found: Some(found) } if (expected, found) == (id, other));
            assert!(is_withheld, "{refused}");
        }
        fs::remove_file(&path).unwrap();
        let refused = bound.expected_statements(&mut folder).unwrap_err();
        assert_eq!(
            refused.to_string(),
            format!("what keys say about keys is withheld: the seal expects {id}, found nothing")
        );
        let large = Letter { statements: Some((id, limits::STATEMENTS + 1)), ..letter };
        assert!(matches!(large.sign(artist()), Err(SignError::Refused(Refused::TooLarge { .. }))));
    }

    #[test]
    fn a_seal_names_so_many_units_and_no_more() {
        let to = |count: usize| Addressees::of((0..count).map(|at| UnitId::new(&at.to_string()).unwrap()));
        let signed = |count| Letter { addressees: to(count), ..letter(8) }.sign(artist());
        signed(limits::UNITS).unwrap();
        let refused = signed(limits::UNITS + 1).unwrap_err();
        assert!(matches!(refused, SignError::Refused(Refused::TooMany { limit: limits::UNITS, .. })), "{refused}");
    }
}
