//! A signed text: four lines of a minisign signature, then the text itself.
//!
//! Owns the format, with a single spelling: any changed byte, also in a comment, is refused. Signature and text are one
//! file, so that they cannot be separated. Every text begins with a heading, so that a text signed for one purpose is
//! not accepted for another. The text is parsed only after its signature was verified.
//!
//! To verify one with minisign: `head -n 4 FILE > f.minisig; tail -n +5 FILE > f; minisign -Vm f -p KEY.pub`.
//!
//! Start at [`SignedText::open`]; [`crate::Trust::verify`] returns the text.

use ct_codecs::{Base64, Decoder, Encoder};
use minisign_verify::{PublicKey, Signature};

use crate::key::KeyId;
use crate::limits;
use crate::refusal::{Part, Refusal};

/// The first line of a signature: what minisign writes.
pub(crate) const UNTRUSTED_COMMENT: &str = "signature from minisign secret key";
const UNTRUSTED: &str = "untrusted comment: ";
const TRUSTED: &str = "trusted comment: ";
/// Lines of a signature.
const LINES: usize = 4;
/// Algorithm, key id, signature.
const SIGNATURE: usize = 2 + KeyId::BYTES + 64;
/// The signature over signature and comment.
const GLOBAL: usize = 64;

/// A text whose signature has not been checked.
pub(crate) struct SignedText<'a> {
    /// The key that it names.
    pub(crate) signer: KeyId,
    signature: Signature,
    text: &'a [u8],
}

impl<'a> SignedText<'a> {
    /// Splits `bytes` into signature and text.
    /// Errors: [`Refusal::NotSigned`] unless the signature has the only valid spelling.
    pub(crate) fn open(part: &Part, bytes: &'a [u8]) -> Result<Self, Refusal> {
        let refused = |why| Refusal::NotSigned { part: part.clone(), why };
        let mut ends = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(at, _)| at + 1);
        let end = ends.nth(LINES - 1).ok_or_else(|| refused("it has no four lines of a signature"))?;
        let (head, text) = bytes.split_at(end);
        let head = std::str::from_utf8(head).map_err(|_| refused("its signature is not text"))?;
        let lines: Vec<&str> = head.split_terminator('\n').collect();
        let &[untrusted, signature, trusted, global] = lines.as_slice() else {
            return Err(refused("it has no four lines of a signature"));
        };
        if untrusted.strip_prefix(UNTRUSTED) != Some(UNTRUSTED_COMMENT) {
            return Err(refused("its first line is not minisign's"));
        }
        let comment = trusted.strip_prefix(TRUSTED).ok_or_else(|| refused("its comment is missing"))?;
        if comment.len() > limits::COMMENT || comment.chars().any(|c| c.is_ascii_control() && c != '\t') {
            return Err(refused("its comment is too long or not text"));
        }
        let raw = exact::<SIGNATURE>(signature).ok_or_else(|| refused("its signature is misspelled"))?;
        exact::<GLOBAL>(global).ok_or_else(|| refused("its second signature is misspelled"))?;
        let signer = KeyId::of(&raw[2..]).ok_or_else(|| refused("its signature names no key"))?;
        let signature = Signature::decode(head).map_err(|_| refused("its signature is not minisign's"))?;
        Ok(Self { signer, signature, text })
    }

    /// The text, if `key` has signed it and it begins with the line `heading`.
    pub(crate) fn text(&self, part: &Part, key: &PublicKey, heading: &str) -> Result<&'a str, Refusal> {
        let forged = || Refusal::Forged { part: part.clone(), signer: self.signer };
        key.verify(self.text, &self.signature, false).map_err(|_| forged())?;
        // Signed for another purpose, which counts as forged.
        let headed = self.text.strip_prefix(heading.as_bytes()).is_some_and(|rest| rest.starts_with(b"\n"));
        if headed { std::str::from_utf8(self.text).map_err(|_| forged()) } else { Err(forged()) }
    }

    /// The text of a file whose signature was verified before; the caller has checked that the bytes are the same.
    pub(crate) fn kept(&self, part: &Part) -> Result<&'a str, Refusal> {
        std::str::from_utf8(self.text).map_err(|_| Refusal::Forged { part: part.clone(), signer: self.signer })
    }
}

/// The `N` bytes in the Base64 `text`, if it has the only valid spelling.
pub(crate) fn exact<const N: usize>(text: &str) -> Option<[u8; N]> {
    if text.len() > 2 * N + 4 {
        return None;
    }
    let bytes: [u8; N] = Base64::decode_to_vec(text, None).ok()?.try_into().ok()?;
    let spelled = Base64::encode_to_string(bytes).ok()?;
    (spelled == text).then_some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::secret::tests::artist;

    const HEADING: &str = "dreams test 1";

    fn signed() -> Vec<u8> {
        artist().sign("a test", "dreams test 1\nthe text\n").unwrap()
    }

    fn read(bytes: &[u8]) -> Result<String, Refusal> {
        let key = artist().public();
        let signed = SignedText::open(&Part::Seal, bytes)?;
        if signed.signer != key.id() {
            return Err(Refusal::UnknownKey { part: Part::Seal, signer: signed.signer, trusted: vec![key.id()] });
        }
        signed.text(&Part::Seal, key.verifier(), HEADING).map(str::to_owned)
    }

    #[test]
    fn what_was_signed_is_read() {
        assert_eq!(read(&signed()).unwrap(), "dreams test 1\nthe text\n");
    }

    #[test]
    fn any_changed_bit_is_refused() {
        let whole = signed();
        for bit in 0..whole.len() * 8 {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(read(&bytes).is_err(), "bit {bit}: {}", String::from_utf8_lossy(&bytes));
        }
    }

    #[test]
    fn any_cut_and_any_byte_more_is_refused() {
        let whole = signed();
        for at in 0..whole.len() {
            assert!(read(&whole[..at]).is_err(), "cut at {at}");
            for more in [b'\n', b'\r', b' ', b'A', 0] {
                let mut bytes = whole.clone();
                bytes.insert(at, more);
                assert!(read(&bytes).is_err(), "{more} at {at}");
            }
        }
    }

    #[test]
    fn what_was_signed_as_something_else_is_refused() {
        let other = artist().sign("a test", "dreams test 10\nthe text\n").unwrap();
        assert!(matches!(read(&other), Err(Refusal::Forged { .. })));
    }
}
