//! The names of sheep and pools.
//!
//! Owns the text of an id, `7.00412-k3v9q2`: the brood, the number among all births of the pool, and the pool that bred it.
//! Electric Sheep numbers its sheep so, in a single pool. The pool's name is by chance, so that pools can be merged
//! without a clash of ids. Never knows a sheep.
//!
//! Start at [`Id`].

use std::fmt::{self, Debug, Display, Formatter};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Letters and digits of origins by chance; none that is mistaken for another.
const LETTERS: &[u8; 32] = b"abcdefghjkmnpqrstuvwxyz023456789";

/// Letters of an origin.
const LENGTH: usize = 6;

/// The name of a pool that no other has: six letters or digits by chance.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Origin([u8; LENGTH]);

/// The name of a sheep, unique among all pools.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Id {
    /// The brood that it was born in, counted from 0 by the pool that bred it.
    pub brood: u32,
    /// Its number among the births of that pool.
    pub serial: u32,
    /// The pool that bred it.
    pub origin: Origin,
}

/// A text that is no id or origin.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` is no {what}, as `{example}` is")]
pub struct IdError {
    text: String,
    what: &'static str,
    example: &'static str,
}

impl Origin {
    /// An origin from random bits.
    pub fn of_bits(bits: u64) -> Origin {
        Origin(std::array::from_fn(|at| LETTERS[(bits >> (5 * at) & 31) as usize]))
    }
}

impl Display for Origin {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|letter| write!(f, "{}", char::from(*letter)))
    }
}

impl Display for Id {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{:05}-{}", self.brood, self.serial, self.origin)
    }
}

impl Debug for Origin {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        Display::fmt(self, f)
    }
}

impl Debug for Id {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        Display::fmt(self, f)
    }
}

impl FromStr for Origin {
    type Err = IdError;

    fn from_str(text: &str) -> Result<Self, IdError> {
        let is_letter = |byte: &u8| byte.is_ascii_lowercase() || byte.is_ascii_digit();
        match <[u8; LENGTH]>::try_from(text.as_bytes()) {
            Ok(bytes) if bytes.iter().all(is_letter) => Ok(Origin(bytes)),
            _ => Err(IdError { text: text.to_owned(), what: "origin of a pool", example: "k3v9q2" }),
        }
    }
}

impl FromStr for Id {
    type Err = IdError;

    /// Only the text that [`Display`] writes is an id, so that two texts never mean one sheep.
    fn from_str(text: &str) -> Result<Self, IdError> {
        let parts = || {
            let (brood, rest) = text.split_once('.')?;
            let (serial, origin) = rest.split_once('-')?;
            Some(Id { brood: brood.parse().ok()?, serial: serial.parse().ok()?, origin: origin.parse().ok()? })
        };
        let error = || IdError { text: text.to_owned(), what: "id of a sheep", example: "7.00412-k3v9q2" };
        parts().filter(|id| id.to_string() == text).ok_or_else(error)
    }
}

impl TryFrom<String> for Origin {
    type Error = IdError;

    fn try_from(text: String) -> Result<Self, IdError> {
        text.parse()
    }
}

impl TryFrom<String> for Id {
    type Error = IdError;

    fn try_from(text: String) -> Result<Self, IdError> {
        text.parse()
    }
}

impl From<Origin> for String {
    fn from(origin: Origin) -> String {
        origin.to_string()
    }
}

impl From<Id> for String {
    fn from(id: Id) -> String {
        id.to_string()
    }
}
