//! The common parts of all seals: signature, addressees, sequence and time.
//!
//! Signs and verifies the text of a seal, and owns the lines that a flock's seal and a system's have in common. The
//! rest is in [`crate::Seal`] and [`crate::System`].
//!
//! Start at [`open_text`].

use std::io::{ErrorKind, Read};

use crate::key::{KeyError, KeyId};
use crate::limits;
use crate::lines::Lines;
use crate::names::{Addressees, ObjectId, Sequence, UnitId, parse_plain};
use crate::refusal::{Part, Refusal};
use crate::secret::SecretKey;
use crate::source::Source;
use crate::trust::Trust;

/// The value of `units` in a seal for all units.
const EVERYBODY: &str = "*";
/// The key of the line with the expected statements.
const STATEMENTS: &str = "statements";
const TOO_LARGE: Refusal = Refusal::TooLarge { part: Part::Seal, limit: limits::SEAL };

/// The lines with addressees, sequence and time.
pub(crate) struct SealHeader {
    pub(crate) addressees: Addressees,
    pub(crate) sequence: Sequence,
    pub(crate) created: String,
}

/// Why a letter was not signed.
#[derive(Debug, thiserror::Error)]
pub enum SignError {
    /// The key did not sign.
    #[error("cannot sign the bundle")]
    Key(#[source] KeyError),
    /// No unit would take it.
    #[error("units would refuse this bundle")]
    Refused(#[source] Refusal),
}

/// Verifies `bytes`; returns the signer, and the text, which begins with the line `heading`.
/// Errors: [`Refusal`] if it is too large, not signed by a trusted key, or has another heading.
pub(crate) fn open_text<'a>(bytes: &'a [u8], trust: &Trust, heading: &str) -> Result<(KeyId, &'a str), Refusal> {
    if bytes.len() as u64 > limits::SEAL {
        return Err(TOO_LARGE);
    }
    trust.verify(&Part::Seal, bytes, heading)
}

/// Signs `text`; returns the bytes of the seal's file. `comment` is for people.
/// Errors: [`SignError`] if signing fails, or it would be too large.
pub(crate) fn signed(key: &SecretKey, comment: &str, text: &str) -> Result<Vec<u8>, SignError> {
    let bytes = key.sign(comment, text).map_err(SignError::Key)?;
    if bytes.len() as u64 > limits::SEAL {
        return Err(SignError::Refused(TOO_LARGE));
    }
    Ok(bytes)
}

/// Reads the seal at `path` of `source`.
pub(crate) fn read(source: &mut dyn Source, path: &str) -> Result<Vec<u8>, Refusal> {
    read_part(source, path, &Part::Seal, limits::SEAL)
}

/// What `read` finds for `unit`, or else for all units; `None` if there is neither.
pub(crate) fn own_or_common<T>(
    unit: &UnitId,
    mut read: impl FnMut(&Addressees) -> Result<Option<T>, Refusal>,
) -> Result<Option<T>, Refusal> {
    match read(&Addressees::of([unit.clone()]))? {
        Some(own) => Ok(Some(own)),
        None => read(&Addressees::Anyone),
    }
}

/// What `read` has read of the file for the first of `addressees`; `None` if there is no such file.
pub(crate) fn read_addressed(
    addressees: &Addressees,
    read: impl FnOnce(&str) -> Result<Vec<u8>, Refusal>,
) -> Result<Option<Vec<u8>>, Refusal> {
    match read(addressees.file_stems().first().copied().unwrap_or_default()) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(Refusal::Read { source, .. }) if source.kind() == ErrorKind::NotFound => Ok(None),
        Err(refused) => Err(refused),
    }
}

/// Reads the signed `part` at `path` of `source`, of at most `limit` bytes.
pub(crate) fn read_part(source: &mut dyn Source, path: &str, part: &Part, limit: u64) -> Result<Vec<u8>, Refusal> {
    let read = source.small(path, limit).and_then(|reader| durable::read_all(reader, limit));
    read.map_err(|source| {
        let part = part.clone();
        if source.kind() == ErrorKind::FileTooLarge {
            Refusal::TooLarge { part, limit }
        } else {
            Refusal::Read { part, source }
        }
    })
}

/// The line with the expected statements about keys; empty if there are none.
pub(crate) fn statements_text(statements: Option<(ObjectId, u64)>) -> String {
    statements.map_or_else(String::new, |(id, size)| format!("{STATEMENTS} {size} {id}\n"))
}

/// The expected statements about keys and their size in bytes, if the next line has them.
pub(crate) fn statements(lines: &mut Lines<'_>) -> Result<Option<(ObjectId, u64)>, Refusal> {
    let wanted = "`statements`, a size and a digest, or nothing";
    let Some(value) = lines.optional_value(STATEMENTS, wanted)? else { return Ok(None) };
    let (id, size) = sized(lines, value, wanted)?;
    if size > limits::STATEMENTS {
        return Err(Refusal::TooLarge { part: Part::Statement, limit: limits::STATEMENTS });
    }
    Ok(Some((id, size)))
}

/// Reads the statements about keys that a seal expects from `source`; empty if it expects none.
pub(crate) fn read_expected(statements: Option<(ObjectId, u64)>, source: &mut dyn Source) -> Result<Vec<u8>, Refusal> {
    let Some((expected, size)) = statements else { return Ok(Vec::new()) };
    let withheld = |found| Refusal::Withheld { expected, found };
    let mut bytes = Vec::new();
    match source.object(&expected, size, 0).and_then(|reader| reader.take(size).read_to_end(&mut bytes)) {
        Ok(_) => {}
        Err(error) if error.kind() == ErrorKind::NotFound => return Err(withheld(None)),
        Err(source) => return Err(Refusal::Read { part: Part::Statement, source }),
    }
    let found = ObjectId::of(&bytes);
    if found == expected { Ok(bytes) } else { Err(withheld(Some(found))) }
}

impl SealHeader {
    /// The three lines.
    pub(crate) fn to_text(addressees: &Addressees, sequence: Sequence, created: &str) -> String {
        format!("units {}\nsequence {sequence}\ncreated {created}\n", named(addressees))
    }

    pub(crate) fn parse(lines: &mut Lines<'_>) -> Result<Self, Refusal> {
        let wanted = "`units` and `*`, or names in order";
        let addressees = addressees(&lines.value("units", wanted).map(str::to_owned)?, lines, wanted)?;
        let sequence = lines.value("sequence", "`sequence` and a number")?;
        let sequence = Sequence::parse(sequence).map_err(|error| lines.bad_name(error))?;
        let wanted = "`created` and a time as 2026-03-01T12:00:00Z";
        let created = lines.value("created", wanted)?.to_owned();
        if !is_time(&created) {
            return Err(lines.wrong_line(wanted, &created));
        }
        Ok(Self { addressees, sequence, created })
    }
}

/// The object on the line `name`, and its size in bytes.
pub(crate) fn object(lines: &mut Lines<'_>, name: &str, wanted: &'static str) -> Result<(ObjectId, u64), Refusal> {
    let value = lines.value(name, wanted)?;
    sized(lines, value, wanted)
}

/// The object in `value` of the last line, and its size in bytes.
fn sized(lines: &Lines<'_>, value: &str, wanted: &'static str) -> Result<(ObjectId, u64), Refusal> {
    let (size, id) = value.split_once(' ').ok_or_else(|| lines.wrong_line(wanted, value))?;
    let size = parse_plain(size).ok_or_else(|| lines.wrong_line(wanted, value))?;
    let id = ObjectId::parse(id).map_err(|error| lines.bad_name(error))?;
    Ok((id, size))
}

/// How a seal says for whom it is.
fn named(addressees: &Addressees) -> String {
    match addressees {
        Addressees::Anyone => EVERYBODY.to_owned(),
        units @ Addressees::Units(_) => units.to_string(),
    }
}

/// The addressees in `value`.
fn addressees(value: &str, lines: &Lines<'_>, wanted: &'static str) -> Result<Addressees, Refusal> {
    if value == EVERYBODY {
        return Ok(Addressees::Anyone);
    }
    let mut units: Vec<UnitId> = Vec::new();
    for name in value.split(' ') {
        if units.len() == limits::UNITS {
            return Err(Refusal::TooMany { part: Part::Seal, limit: limits::UNITS, things: "units" });
        }
        let unit = UnitId::new(name).map_err(|error| lines.bad_name(error))?;
        if units.last().is_some_and(|last| *last >= unit) {
            return Err(lines.wrong_line(wanted, value));
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
    use crate::seal::SealBody;
    use crate::seal::tests::letter;
    use crate::secret::tests::artist;

    #[test]
    fn a_seal_names_so_many_units_and_no_more() {
        let to = |count: usize| Addressees::of((0..count).map(|at| UnitId::new(&at.to_string()).unwrap()));
        let signed = |count| SealBody { addressees: to(count), ..letter(8) }.sign(artist());
        signed(limits::UNITS).unwrap();
        let refused = signed(limits::UNITS + 1).unwrap_err();
        assert!(matches!(refused, SignError::Refused(Refusal::TooMany { limit: limits::UNITS, .. })), "{refused}");
    }
}
