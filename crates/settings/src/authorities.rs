//! Certificate authorities: who may vouch for web servers, besides those that are built into the updater.
//!
//! Owns [`Authorities`], and how they are written: certificates in PEM. Never judges a server: `dreams-update/tls.rs`
//! does.
//!
//! Start at [`Authorities`].

use ct_codecs::{Base64, Encoder};
use rustls::RootCertStore;
use rustls::pki_types::CertificateDer;
use rustls::pki_types::pem::PemObject;
use serde::Deserialize;
use std::str::FromStr;

/// Certificates of authorities, each of which can be read.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub struct Authorities(Vec<CertificateDer<'static>>);

/// A text that has none, or has one that cannot be read.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoAuthorities {
    /// One that is no certificate.
    #[error("certificate {0} cannot be read: expected certificates in PEM")]
    Certificate(usize),
    /// None at all.
    #[error("there is no certificate: expected certificates in PEM, which begin with `-----BEGIN CERTIFICATE-----`")]
    None,
}

impl Authorities {
    /// What can be read of the PEM in `bytes`, and the number of certificates that cannot.
    pub fn readable(bytes: &[u8]) -> (Self, usize) {
        let (readable, wrong): (Vec<_>, Vec<_>) = certificates(bytes).into_iter().partition(Option::is_some);
        (Self(readable.into_iter().flatten().collect()), wrong.len())
    }

    /// Their certificates as text, in PEM (RFC 7468).
    pub fn pem(&self) -> String {
        let text = |certificate: &CertificateDer<'_>| {
            // Only a text of more than a gigabyte cannot be encoded, and a certificate was read from settings.
            let digits = Base64::encode_to_string(certificate).unwrap_or_default();
            let letters: Vec<char> = digits.chars().collect();
            let lines: String = letters.chunks(64).flat_map(|line| line.iter().chain(&['\n'])).collect();
            format!("-----BEGIN CERTIFICATE-----\n{lines}-----END CERTIFICATE-----\n")
        };
        self.0.iter().map(text).collect()
    }

    /// Their certificates, in the order of the text.
    pub fn certificates(&self) -> &[CertificateDer<'static>] {
        &self.0
    }
}

impl FromStr for Authorities {
    type Err = NoAuthorities;

    fn from_str(text: &str) -> Result<Self, NoAuthorities> {
        let found = certificates(text.as_bytes());
        if found.is_empty() {
            return Err(NoAuthorities::None);
        }
        let read = |(at, found): (usize, Option<_>)| found.ok_or(NoAuthorities::Certificate(at + 1));
        found.into_iter().enumerate().map(read).collect::<Result<_, _>>().map(Self)
    }
}

crate::from_string!(NoAuthorities: Authorities);

/// The certificates in PEM; `None` for each that cannot be read.
fn certificates(bytes: &[u8]) -> Vec<Option<CertificateDer<'static>>> {
    let is_anchor = |found: &CertificateDer<'static>| RootCertStore::empty().add(found.clone()).is_ok();
    CertificateDer::pem_slice_iter(bytes).map(|found| found.ok().filter(is_anchor)).collect()
}

#[cfg(test)]
mod tests {
    use super::{Authorities, NoAuthorities};

    const GOOD: &str = include_str!("../../../tests/fixtures/certificates/authority.pem");
    const RUBBISH: &str = "-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n";

    #[test]
    fn each_certificate_of_an_owner_is_readable_or_named() {
        let read = |text: &str| text.parse::<Authorities>().map(|found| found.certificates().len());
        assert_eq!(read(GOOD), Ok(1));
        assert_eq!(read(&format!("A title\n{GOOD}\n{GOOD}")), Ok(2));
        for none in ["", "rubbish", "-----BEGIN PUBLIC KEY-----\nAAAA\n-----END PUBLIC KEY-----\n"] {
            assert_eq!(read(none), Err(NoAuthorities::None), "{none}");
        }
        assert_eq!(read(&format!("{GOOD}{RUBBISH}")), Err(NoAuthorities::Certificate(2)));
        let cut_off = &GOOD[..GOOD.len() / 2];
        assert_eq!(read(cut_off), Err(NoAuthorities::Certificate(1)));
    }

    #[test]
    fn of_a_systems_authorities_those_count_that_can_be_read() {
        let (found, wrong) = Authorities::readable(format!("{RUBBISH}{GOOD}{RUBBISH}").as_bytes());
        assert_eq!((found.certificates().len(), wrong), (1, 2));
    }
}
