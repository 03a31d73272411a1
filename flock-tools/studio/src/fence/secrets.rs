//! What only this start of the studio, its address and its pages know.
//!
//! Owns four texts of 128 random bits: the token in the address, the cookie, what a page sends with every question, and
//! what stands in the addresses of pictures, clips and events, which elements of a page ask for without headers.
//! A cookie goes to every port of this machine, so it alone reads and changes nothing.

use std::fs::File;
use std::io::{self, Read};

/// The four texts, in hexadecimal.
#[derive(Clone)]
pub(crate) struct Secrets {
    pub(super) token: String,
    pub(super) cookie: String,
    pub(super) page: String,
    pub(super) look: String,
}

impl std::fmt::Debug for Secrets {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Secrets").finish_non_exhaustive()
    }
}

impl Secrets {
    /// Those of these numbers.
    pub(crate) fn of([token, cookie, page, look]: [u128; 4]) -> Self {
        let hex = |number| format!("{number:032x}");
        Self { token: hex(token), cookie: hex(cookie), page: hex(page), look: hex(look) }
    }

    /// Those of the system's random numbers.
    /// Errors: What the system says.
    pub(crate) fn from_system() -> io::Result<Self> {
        let mut random = File::open("/dev/urandom")?;
        let mut number = || {
            let mut bytes = [0; size_of::<u128>()];
            random.read_exact(&mut bytes).map(|()| u128::from_le_bytes(bytes))
        };
        Ok(Self::of([number()?, number()?, number()?, number()?]))
    }
}

/// Whether `given` is `secret`, in a time that does not tell how much of it was right.
pub(super) fn is(secret: &str, given: &[u8]) -> bool {
    let differences = secret.bytes().zip(given).map(|(a, b)| a ^ b);
    secret.len() == given.len() && differences.fold(0, |all, one| all | one) == 0
}
