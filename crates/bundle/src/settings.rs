//! A signed file of settings, on its way to units.
//!
//! Owns its form and its only spelling: who it is for, its number and time as in a seal, an empty line, and the owner's
//! file as it is. The signature covers all of it. It is complete in itself: no object belongs to it. What the owner's
//! file says is not parsed here. A seal is not accepted as settings, nor the other way round.
//!
//! ```text
//! dreams settings 1
//! units lobby
//! sequence 9
//! created 2026-03-01T12:00:00Z
//!
//! unit = "lobby"
//! wifi = "Home"
//! ```
//!
//! Start at [`UnverifiedSettings::verify`], the only constructor of [`SignedSettings`].
#![allow(
    clippy::missing_errors_doc,
    reason = "a function that does not say otherwise fails with `Refusal::Read` or `Refusal::TooLarge`"
)]

use crate::envelope::{SealHeader, SignError, own_or_common, read_addressed, read_part};
use crate::key::KeyId;
use crate::limits;
use crate::lines::Lines;
use crate::names::{Addressees, Sequence, UnitId};
use crate::refusal::{Part, Refusal};
use crate::secret::SecretKey;
use crate::source::Source;
use crate::trust::Trust;

/// The first line.
const HEADING: &str = "dreams settings 1";
/// Bytes of the file: the owner's file and what stands before it.
const LARGEST: u64 = limits::SETTINGS + limits::SEAL;
const TOO_LARGE: Refusal = Refusal::TooLarge { part: Part::Settings, limit: limits::SETTINGS };

/// The bytes of a file of settings before verification.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnverifiedSettings(Vec<u8>);

/// What a file of settings says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SettingsBody {
    /// For whom they are.
    pub addressees: Addressees,
    /// Their number among all that this key has signed.
    pub sequence: Sequence,
    /// When they were signed, as `2026-03-01T12:00:00Z`. For people only: units do not check it.
    pub created: String,
    /// The owner's file, of at most [`limits::SETTINGS`] bytes.
    pub text: String,
}

/// Settings signed by a trusted key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SignedSettings {
    body: SettingsBody,
    signer: KeyId,
}

impl UnverifiedSettings {
    /// Reads the settings of `source` for `unit`, or else those for all units; `None` if it has neither.
    pub fn open(source: &mut dyn Source, unit: &UnitId) -> Result<Option<Self>, Refusal> {
        own_or_common(unit, |addressees| Self::addressed(source, addressees))
    }

    /// Reads the settings of `source` for the first of `addressees`; `None` if it has none.
    pub fn addressed(source: &mut dyn Source, addressees: &Addressees) -> Result<Option<Self>, Refusal> {
        Ok(read_addressed(addressees, |stem| read_part(source, &path(stem), &Part::Settings, LARGEST))?.map(Self))
    }

    /// The settings in `bytes`.
    pub fn new(bytes: impl Into<Vec<u8>>) -> Self {
        Self(bytes.into())
    }

    /// Verifies the signature, and then parses the lines before the owner's file.
    ///
    /// # Errors
    /// [`Refusal`] if no trusted key signed them, or they are invalid.
    pub fn verify(&self, trust: &Trust) -> Result<SignedSettings, Refusal> {
        if self.0.len() as u64 > LARGEST {
            return Err(TOO_LARGE);
        }
        let (signer, text) = trust.verify(&Part::Settings, &self.0, HEADING)?;
        Ok(SignedSettings { body: SettingsBody::parse(text)?, signer })
    }
}

impl SettingsBody {
    /// Signs the settings; returns the bytes of their file.
    ///
    /// # Errors
    /// [`SignError`] if units would refuse them, or signing fails.
    pub fn sign(&self, key: &SecretKey) -> Result<Vec<u8>, SignError> {
        let text = self.to_text();
        let read = Self::parse(&text).map_err(SignError::Refused)?;
        debug_assert_eq!(&read, self, "settings read back as written");
        key.sign(&format!("settings sequence {}", self.sequence), &text).map_err(SignError::Key)
    }

    fn to_text(&self) -> String {
        let header = SealHeader::to_text(&self.addressees, self.sequence, &self.created);
        format!("{HEADING}\n{header}\n{}", self.text)
    }

    fn parse(text: &str) -> Result<Self, Refusal> {
        let mut lines = Lines::new(Part::Settings, text);
        lines.expect_line(HEADING)?;
        let SealHeader { addressees, sequence, created } = SealHeader::parse(&mut lines)?;
        let wanted = "an empty line";
        match lines.next(wanted)? {
            Some("") => {}
            line => return Err(lines.wrong_line(wanted, line.unwrap_or_default())),
        }
        let text = lines.rest();
        if text.len() as u64 > limits::SETTINGS {
            return Err(TOO_LARGE);
        }
        Ok(Self { addressees, sequence, created, text: text.to_owned() })
    }
}

impl SignedSettings {
    /// What they say.
    pub fn body(&self) -> &SettingsBody {
        &self.body
    }

    /// Who says so.
    pub fn signer(&self) -> KeyId {
        self.signer
    }
}

/// The path of the settings with this file stem on a stick.
pub fn path(stem: &str) -> String {
    format!("settings/{stem}.settings")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seal::tests::letter;
    use crate::secret::tests::{artist, stranger};
    use crate::{SealBody, UnverifiedSeal};

    fn body(text: &str) -> SettingsBody {
        SettingsBody {
            addressees: Addressees::of([UnitId::new("lobby").unwrap()]),
            sequence: Sequence(9),
            created: "2026-03-01T12:00:00Z".to_owned(),
            text: text.to_owned(),
        }
    }

    fn read(bytes: &[u8]) -> Result<SettingsBody, Refusal> {
        let trust = Trust::of([artist().public()]);
        UnverifiedSettings::new(bytes).verify(&trust).map(|signed| signed.body().clone())
    }

    #[test]
    fn settings_are_read_as_they_were_signed() {
        for text in ["", "unit = \"lobby\"\n", "\n\n# no end of line", "wifi = \"Caf\u{e9}\"\r\n"] {
            assert_eq!(read(&body(text).sign(artist()).unwrap()).unwrap(), body(text), "{text:?}");
        }
    }

    #[test]
    fn any_changed_bit_of_settings_is_refused() {
        let whole = body("wifi = \"Home\"\n").sign(artist()).unwrap();
        for bit in 0..whole.len() * 8 {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(read(&bytes).is_err(), "bit {bit}");
        }
        for at in 0..whole.len() {
            assert!(read(&whole[..at]).is_err(), "cut at {at}");
        }
    }

    #[test]
    fn a_strangers_settings_and_a_seal_as_settings_are_refused() {
        let theirs = body("").sign(&stranger()).unwrap();
        assert!(matches!(read(&theirs), Err(Refusal::UnknownKey { part: Part::Settings, .. })));
        let seal = SealBody { ..letter(9) }.sign(artist()).unwrap();
        assert!(matches!(read(&seal), Err(Refusal::Forged { .. })));
        let ours = body("").sign(artist()).unwrap();
        let as_seal = UnverifiedSeal::new(ours).verify(&Trust::of([artist().public()]));
        assert!(matches!(as_seal, Err(Refusal::Forged { .. })));
    }

    #[test]
    fn settings_have_so_many_bytes_and_no_more() {
        let most = usize::try_from(limits::SETTINGS).unwrap();
        assert_eq!(read(&body(&"#".repeat(most)).sign(artist()).unwrap()).unwrap().text.len(), most);
        let refused = body(&"#".repeat(most + 1)).sign(artist()).unwrap_err();
        assert!(matches!(refused, SignError::Refused(Refusal::TooLarge { part: Part::Settings, .. })), "{refused}");
    }

    #[test]
    fn lines_before_the_owners_file_have_one_spelling() {
        let good = body("a = 1\n").to_text();
        assert!(SettingsBody::parse(&good).is_ok());
        for (from, to) in [
            ("created 2026-03-01T12:00:00Z\n\n", "created 2026-03-01T12:00:00Z\n"),
            ("created 2026-03-01T12:00:00Z\n\n", "created 2026-03-01T12:00:00Z\n \n"),
            ("settings 1\n", "settings 2\n"),
            ("sequence 9", "sequence 09"),
            ("units lobby", "units lobby lobby"),
        ] {
            let text = good.replace(from, to);
            assert!(matches!(SettingsBody::parse(&text), Err(Refusal::Line { .. } | Refusal::Name { .. })), "{text}");
        }
    }
}
