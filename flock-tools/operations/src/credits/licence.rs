//! Licences of clips and genomes.
//!
//! Owns what a licence is, an SPDX expression, how people write one instead, and whether it lets a flock be sold. It knows
//! of no other condition of a licence. Never judges whether a licence was given.
//!
//! Start at [`Licence::read`].

use std::fmt;

use serde::{Serialize, Serializer};
use spdx::{Expression, LicenseItem, LicenseReq};

/// The addresses of Creative Commons, without `https://` or `http://` before them.
const DEEDS: &str = "creativecommons.org/licenses/";
/// The same for the public domain.
const PUBLIC_DOMAIN: &str = "creativecommons.org/publicdomain/zero/";

/// A licence, or several: an SPDX expression.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Licence(String);

/// The licence of a genome that was made here by chance: it belongs to whoever made it, who may do anything with it.
pub const OURS: &str = "LicenseRef-ours";

/// Whether something may be sold, or shown for money, by its licence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sale {
    /// The licence allows it, or it is our own.
    Permitted,
    /// The licence is for non-commercial use.
    Forbidden,
    /// There is no licence, or one that SPDX does not list.
    Unknown,
}

impl Licence {
    /// Reads an SPDX expression, or one of Creative Commons' licences as people write it: `CC BY-NC 3.0`, or the address of
    /// its deed.
    pub fn read(text: &str) -> Option<Self> {
        let text = text.trim();
        let found = if Expression::parse(text).is_ok() { text.to_owned() } else { creative_commons(text)? };
        Some(Self(found))
    }

    /// Both together, in either order the same: what is made of both is under both.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        if self == other {
            return self.clone();
        }
        let part = |licence: &Self| if licence.0.contains(' ') { format!("({licence})") } else { licence.0.clone() };
        Self(format!("{} AND {}", part(self.min(other)), part(self.max(other))))
    }

    /// Whether it lets a flock be sold.
    pub fn sale(&self) -> Sale {
        let Ok(expression) = Expression::parse(&self.0) else { return Sale::Unknown };
        let is_ours = |requirement: &LicenseReq| requirement.license.to_string() == OURS;
        let is_listed = |requirement: &LicenseReq| matches!(requirement.license, LicenseItem::Spdx { .. });
        let listed = |requirement: &LicenseReq| is_listed(requirement) || is_ours(requirement);
        if expression.evaluate(|requirement| listed(requirement) && !is_non_commercial(requirement)) {
            Sale::Permitted
        } else if expression.evaluate(|requirement| !is_non_commercial(requirement)) {
            Sale::Unknown
        } else {
            Sale::Forbidden
        }
    }

    /// Whether `wanted` is this licence, one of it, or one of it without its version: `cc-by` is every version of CC-BY,
    /// and not CC-BY-NC.
    pub fn is(&self, wanted: &str) -> bool {
        let (wanted, own) = (wanted.trim().to_ascii_uppercase(), self.0.to_ascii_uppercase());
        let is_version =
            |rest: &str| rest.strip_prefix('-').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
        let words = own.split([' ', '(', ')']).filter(|word| !["", "AND", "OR", "WITH"].contains(word));
        own == wanted
            || words
                .into_iter()
                .any(|word| word.strip_prefix(wanted.as_str()).is_some_and(|rest| rest.is_empty() || is_version(rest)))
    }

    /// The expression.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl Sale {
    /// Of something that may have no licence.
    pub fn of(licence: Option<&Licence>) -> Self {
        licence.map_or(Self::Unknown, Licence::sale)
    }

    /// In words, after what it is said of.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Permitted => "may be sold",
            Self::Forbidden => "not for sale",
            Self::Unknown => "not known to be for sale",
        }
    }
}

impl fmt::Display for Licence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Serialize for Licence {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.0)
    }
}

/// Whether a part of an expression is for non-commercial use, by its name.
fn is_non_commercial(requirement: &LicenseReq) -> bool {
    let name = requirement.license.to_string().to_ascii_uppercase();
    name.split('-').any(|part| part == "NC") || name.contains("NONCOMMERCIAL") || name.contains("NON-COMMERCIAL")
}

/// The SPDX identifier of a licence of Creative Commons, from its name or the address of its deed.
fn creative_commons(text: &str) -> Option<String> {
    let lower = text.to_ascii_lowercase();
    let after = |mark: &str| lower.split_once(mark).map(|(_, rest)| rest.to_owned());
    let parts = |text: &str, between: &[char]| -> Vec<String> {
        let words = text.split(|c: char| between.contains(&c) || c.is_whitespace()).filter(|word| !word.is_empty());
        words.map(str::to_ascii_uppercase).collect()
    };
    let words = if let Some(deed) = after(DEEDS) {
        let mut words = vec!["CC".to_owned()];
        let address =
            deed.split(['?', '#']).next().unwrap_or_default().replace("/deed", "/").replace("/legalcode", "/");
        words.extend(parts(&address, &['/', '-']));
        words
    } else if let Some(version) = after(PUBLIC_DOMAIN) {
        vec!["CC0".to_owned(), parts(&version, &['/']).into_iter().next()?]
    } else {
        parts(&lower, &['-', '_', '/'])
    };
    if !words.first().is_some_and(|word| word == "CC" || word == "CC0") {
        return None;
    }
    // A deed of a country that SPDX does not list is the licence of that version.
    (2..=words.len()).rev().map(|count| words[..count].join("-")).find_map(|name| {
        let found = spdx::license_id(&name)?;
        (found.version().is_some()).then(|| found.name.to_owned())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Option<String> {
        Licence::read(text).map(|licence| licence.to_string())
    }

    #[test]
    fn a_licence_is_read_as_spdx_writes_it_and_as_people_do() {
        for (text, wanted) in [
            ("CC-BY-NC-3.0", "CC-BY-NC-3.0"),
            (" MIT OR Apache-2.0 ", "MIT OR Apache-2.0"),
            ("LicenseRef-by-letter", "LicenseRef-by-letter"),
            ("CC BY 4.0", "CC-BY-4.0"),
            ("cc by-nc 3.0", "CC-BY-NC-3.0"),
            ("CC BY-NC 3.0 US", "CC-BY-NC-3.0"),
            ("https://creativecommons.org/licenses/by-nc-sa/4.0/", "CC-BY-NC-SA-4.0"),
            ("see http://creativecommons.org/licenses/by/3.0/us/deed", "CC-BY-3.0-US"),
            ("https://creativecommons.org/licenses/by-nc/3.0/us/", "CC-BY-NC-3.0"),
            ("https://creativecommons.org/publicdomain/zero/1.0/", "CC0-1.0"),
        ] {
            assert_eq!(read(text).as_deref(), Some(wanted), "{text}");
        }
        for text in ["", "mine", "CC", "CC BY", "CC BY 9.9", "MIT OR", "Copyright 2013 Ram"] {
            assert_eq!(read(text), None, "{text}");
        }
    }

    #[test]
    fn what_is_non_commercial_or_unknown_is_not_for_sale() {
        let sale = |text| Licence::read(text).unwrap().sale();
        assert_eq!(sale("CC-BY-4.0"), Sale::Permitted);
        assert_eq!(sale("CC-BY-NC-3.0"), Sale::Forbidden);
        assert_eq!(sale("CC-BY-4.0 AND CC-BY-NC-SA-4.0"), Sale::Forbidden);
        assert_eq!(sale("CC-BY-NC-4.0 OR LicenseRef-by-letter"), Sale::Unknown);
        assert_eq!(sale("CC-BY-NC-4.0 OR CC-BY-4.0"), Sale::Permitted);
        assert_eq!(sale("LicenseRef-by-letter"), Sale::Unknown);
        assert_eq!(sale(OURS), Sale::Permitted);
        assert_eq!(sale("CC-BY-NC-4.0 AND LicenseRef-ours"), Sale::Forbidden);
        assert_eq!(Sale::of(None), Sale::Unknown);
    }

    #[test]
    fn what_is_made_of_two_is_under_both_licences_and_is_found_by_either() {
        let licence = |text| Licence::read(text).unwrap();
        let both = licence("CC-BY-4.0").and(&licence("MIT OR Apache-2.0"));
        assert_eq!(both.as_str(), "CC-BY-4.0 AND (MIT OR Apache-2.0)");
        assert_eq!(Licence::read(both.as_str()), Some(both.clone()));
        assert_eq!(both.and(&both), both);
        assert!(both.is("CC-BY-4.0") && both.is("cc-by") && both.is("mit") && !both.is("CC-BY-NC") && !both.is("CC"));
        assert!(!licence("CC-BY-NC-3.0").is("CC-BY") && licence("CC-BY-NC-3.0").is("cc-by-nc"));
    }
}
