//! The ids of imported sheep.
//!
//! Owns how the name of a genome, or of its file, becomes an id: in any script, of any length, and which ids are one name.
//! Electric Sheep's names are those of its clips. Never reads a flock.
//!
//! Start at [`id`].

use std::collections::{HashMap, HashSet};

use deunicode::deunicode_with_tofu;
use flock::SheepId;

use crate::import::electric::ElectricName;

/// Most bytes of an id.
const LONGEST: usize = 64;
/// What a genome is called if neither its name nor that of its file has a letter or a digit.
const NAMELESS: &str = "sheep";

/// The id of a genome: its name, in the letters that an id may have; without one that has any, the file's `stem`, and the
/// genome's number where the file has several.
pub(super) fn id(name: Option<&str>, stem: &str, number: Option<usize>) -> SheepId {
    if let Some(own) = name.and_then(plain) {
        return new(&own, "");
    }
    let of_file = plain(stem).unwrap_or_else(|| NAMELESS.to_owned());
    match number {
        Some(number) => new(&of_file, &format!(".{number}")),
        None => new(&of_file, ""),
    }
}

/// The ids of a flock, in which no two may differ only in capitals.
#[derive(Debug, Default)]
pub(super) struct Spellings {
    /// Each id, in small letters; in a flock that has several, by the last of them.
    by_small: HashMap<String, SheepId>,
    all: HashSet<SheepId>,
}

impl Spellings {
    /// `id` as the flock spells it; `id` itself where it has none of that name.
    pub(super) fn of(&self, id: &SheepId) -> SheepId {
        if self.all.contains(id) {
            return id.clone();
        }
        self.by_small.get(&id.as_str().to_ascii_lowercase()).unwrap_or(id).clone()
    }

    /// Adds an id of the flock.
    pub(super) fn add(&mut self, id: &SheepId) {
        self.by_small.insert(id.as_str().to_ascii_lowercase(), id.clone());
        self.all.insert(id.clone());
    }
}

impl FromIterator<SheepId> for Spellings {
    fn from_iter<I: IntoIterator<Item = SheepId>>(ids: I) -> Self {
        let mut spellings = Self::default();
        ids.into_iter().for_each(|id| spellings.add(&id));
        spellings
    }
}

/// `id` with a number, for another genome of that name.
pub(super) fn numbered(id: &SheepId, number: usize) -> SheepId {
    new(id.as_str(), &format!(".{number}"))
}

/// `name` in the letters that an id may have, if a letter or a digit is among them.
fn plain(name: &str) -> Option<String> {
    let name =
        ElectricName::of_file(name).map_or_else(|| deunicode_with_tofu(name, ""), |name| name.sheep().to_string());
    let plain = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '-' };
    let plain: String = name.trim().chars().map(plain).collect();
    // A word that begins with `-` is an option, and a file that begins with `.` is hidden.
    let plain = plain.trim_start_matches(['-', '.']).to_owned();
    plain.contains(|c: char| c.is_ascii_alphanumeric()).then_some(plain)
}

/// The id of `name`, cut so that `ending` has a place behind it.
fn new(name: &str, ending: &str) -> SheepId {
    let name = &name[..name.len().min(LONGEST - ending.len())];
    SheepId::new(&format!("{name}{ending}")).expect("plain letters and digits, 64 at most, are an id")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: Option<&str>, stem: &str, number: Option<usize>) -> String {
        id(name, stem, number).to_string()
    }

    #[test]
    fn a_flame_is_called_by_its_name_or_else_by_its_file() {
        assert_eq!(of(Some("electricsheep.247.00505"), "x", None), "247.505");
        assert_eq!(of(None, "electricsheep.247.00505", None), "247.505");
        assert_eq!(of(None, "electricsheep.165.00002", Some(2)), "165.2.2");
        assert_eq!(of(Some("Blue Dream #3"), "x", Some(3)), "Blue-Dream--3");
        assert_eq!(of(None, "best", Some(2)), "best.2");
        assert_eq!(of(Some("electricsheep.x.y"), "best", None), "electricsheep.x.y");
    }

    #[test]
    fn names_in_any_script_are_read_as_they_sound() {
        for (name, wanted) in [
            ("Z\u{fc}rich \u{e9}t\u{e9}", "Zurich-ete"),
            ("\u{41c}\u{43e}\u{441}\u{43a}\u{432}\u{430}", "Moskva"),
            ("\u{5317}\u{4eac}", "Bei-Jing"),
            ("\u{3042}\u{3044}", "ai"),
            ("\u{1f525}", "fire"),
            ("\u{201c}\u{dc}rw\u{20ac}\u{201d}", "UrwEUR-"),
            ("--help", "help"),
            ("../../etc/passwd", "etc-passwd"),
        ] {
            assert_eq!(of(Some(name), "x", None), wanted, "{name}");
        }
    }

    #[test]
    fn a_name_without_letters_is_that_of_the_file_and_a_long_one_is_cut() {
        for nothing in ["-----", "***", "\u{2014}\u{2014}", "\u{fffd}"] {
            assert_eq!(of(Some(nothing), "best", None), "best", "{nothing}");
            assert_eq!(of(Some(nothing), "best", Some(2)), "best.2", "{nothing}");
            assert_eq!(of(None, nothing, Some(2)), "sheep.2", "{nothing}");
        }
        let long = "n".repeat(65);
        assert_eq!(of(Some(&long), "best", None), long[1..]);
        assert_eq!(numbered(&id(Some(&long), "best", None), 12).as_str(), format!("{}.12", "n".repeat(61)));
    }
}
