//! Totals by sheep, which only grow: the document that a unit sends.
//!
//! Owns the form of the document, its limits, and what is refused while it is read. Has no time of day, no order and no
//! person: days since 1970 and sums only, in the order of the ids.
//!
//! Start at [`Totals::parse`].

use crate::error::VotesError;
use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt;

/// Sheep of a document, at most: twenty times a flock of 200.
pub const MOST_SHEEP: usize = 4_096;
/// Bytes of a document that are read, at most: as many sheep with the longest ids and numbers, and white space.
pub const LONGEST: usize = 1 << 20;
/// Characters of an id, at most.
const LONGEST_ID: usize = 64;
/// Digits of a ledger's number.
const DIGITS: usize = 16;

/// The number of a ledger: random, made with it, so that the totals of a unit that begins anew are not mistaken for
/// those before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LedgerId(pub u64);

/// The totals of one sheep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SheepTotals {
    /// Showings.
    pub shown: u32,
    /// Showings that were voted for.
    pub up: u32,
    /// Showings that were voted against.
    pub down: u32,
    /// Seconds in which somebody was near.
    pub near_s: u32,
}

/// The totals of a ledger.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Totals {
    /// The ledger.
    pub ledger: LedgerId,
    /// The day on which it began, since 1970; 0 if the clock was not set then.
    pub since_day: u32,
    /// Each sheep that was shown.
    #[serde(deserialize_with = "by_id")]
    pub sheep: BTreeMap<String, SheepTotals>,
}

impl SheepTotals {
    /// The larger of both, number by number.
    #[must_use]
    pub fn larger(self, other: Self) -> Self {
        Self {
            shown: self.shown.max(other.shown),
            up: self.up.max(other.up),
            down: self.down.max(other.down),
            near_s: self.near_s.max(other.near_s),
        }
    }

    /// No more votes of a kind than showings.
    #[must_use]
    pub fn capped(self) -> Self {
        Self { up: self.up.min(self.shown), down: self.down.min(self.shown), ..self }
    }

    /// The sum, number by number.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            shown: self.shown.saturating_add(other.shown),
            up: self.up.saturating_add(other.up),
            down: self.down.saturating_add(other.down),
            near_s: self.near_s.saturating_add(other.near_s),
        }
    }
}

impl Totals {
    /// Reads a document that may come from anybody.
    ///
    /// # Errors
    /// [`VotesError::Large`] and [`VotesError::Malformed`]: also for an unknown or doubled member, a number that
    /// is no total, and more sheep than [`MOST_SHEEP`].
    pub fn parse(document: &[u8]) -> Result<Self, VotesError> {
        if document.len() > LONGEST {
            return Err(VotesError::Large { found: document.len(), most: LONGEST });
        }
        serde_json::from_slice(document).map_err(|error| VotesError::Malformed { message: error.to_string() })
    }

    /// The document, with a line for each number.
    ///
    /// # Panics
    /// Serializing names and numbers to memory cannot fail.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("totals are names and numbers")
    }
}

/// Whether `id` can be a sheep's: 1 to 64 of `A-Z a-z 0-9 . _ -`.
pub(crate) fn is_id(id: &str) -> bool {
    (1..=LONGEST_ID).contains(&id.len()) && id.bytes().all(|b| b.is_ascii_alphanumeric() || b"._-".contains(&b))
}

fn by_id<'de, D: Deserializer<'de>>(from: D) -> Result<BTreeMap<String, SheepTotals>, D::Error> {
    from.deserialize_map(ById)
}

struct ById;

impl<'de> Visitor<'de> for ById {
    type Value = BTreeMap<String, SheepTotals>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at most {MOST_SHEEP} sheep by their ids")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Self::Value, A::Error> {
        let mut sheep = BTreeMap::new();
        while let Some(id) = entries.next_key::<String>()? {
            if !is_id(&id) {
                return Err(A::Error::custom(format!("an id has 1 to {LONGEST_ID} of `A-Z a-z 0-9 . _ -`")));
            }
            if sheep.len() == MOST_SHEEP {
                return Err(A::Error::custom(format!("there are more than {MOST_SHEEP} sheep")));
            }
            if sheep.insert(id, entries.next_value()?).is_some() {
                return Err(A::Error::custom("a sheep stands there twice"));
            }
        }
        Ok(sheep)
    }
}

impl fmt::Display for LedgerId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

impl Serialize for LedgerId {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for LedgerId {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let text = String::deserialize(from)?;
        let is_plain = text.len() == DIGITS && text.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
        let number = u64::from_str_radix(&text, 16).ok().filter(|_| is_plain);
        number.map(Self).ok_or_else(|| D::Error::custom(format!("a ledger's number has {DIGITS} digits of `0-9 a-f`")))
    }
}

#[cfg(test)]
mod tests {
    use super::{LONGEST, Totals};

    const EXAMPLE: &str = r#"{"ledger":"f3a9c2d17b60e845","since_day":20412,"sheep":{"191.21054":{"shown":412,"up":9,"down":1,"near_s":5310}}}"#;

    #[test]
    fn the_document_is_the_one_of_the_contract() {
        let totals = Totals::parse(EXAMPLE.as_bytes()).unwrap();
        assert_eq!(serde_json::to_string(&totals).unwrap(), EXAMPLE);
        assert_eq!(Totals::parse(totals.to_json().as_bytes()).unwrap(), totals);
    }

    #[test]
    fn what_is_no_document_is_refused_with_its_reason() {
        let long = format!("{}{EXAMPLE}", " ".repeat(LONGEST));
        let twice = r#""a":{"shown":1,"up":0,"down":0,"near_s":0},"a":{"shown":9,"up":0,"down":0,"near_s":0}"#;
        for (text, reason) in [
            (String::new(), "EOF"),
            (EXAMPLE.replace("\"up\":9", "\"up\":-9"), "invalid value"),
            (EXAMPLE.replace("\"up\":9", "\"up\":9.5"), "invalid type"),
            (EXAMPLE.replace("\"up\":9", "\"up\":4294967296"), "invalid value"),
            (EXAMPLE.replace("\"up\":9,", ""), "missing field `up`"),
            (EXAMPLE.replace("\"up\":9", "\"up\":9,\"who\":1"), "unknown field `who`"),
            (EXAMPLE.replace("f3a9c2d17b60e845", "F3A9C2D17B60E845"), "16 digits"),
            (EXAMPLE.replace("f3a9c2d17b60e845", "+3a9c2d17b60e845"), "16 digits"),
            (EXAMPLE.replace("191.21054", "../191"), "an id has"),
            (EXAMPLE.replace("191.21054", ""), "an id has"),
            (EXAMPLE.replace("191.21054", &"1".repeat(65)), "an id has"),
            (format!(r#"{{"ledger":"f3a9c2d17b60e845","since_day":1,"sheep":{{{twice}}}}}"#), "stands there twice"),
            (format!("{EXAMPLE}{EXAMPLE}"), "trailing characters"),
            (long, "bytes, at most"),
        ] {
            let said = Totals::parse(text.as_bytes()).unwrap_err().to_string();
            assert!(said.contains(reason), "{said}: expected {reason}");
        }
    }
}

/// Random bits for the tests of this crate.
#[cfg(test)]
pub(crate) mod tests_random {
    /// A source of 64 random bits a call (`SplitMix64`), which is the same for the same `seed`.
    pub(crate) fn random(mut seed: u64) -> impl FnMut() -> u64 {
        move || {
            seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mixed = (seed ^ (seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            mixed ^ (mixed >> 31)
        }
    }
}
