//! Sticks with one change each, by number: what strangers, faulty tools and faulty sticks bring to a unit.
//!
//! Owns the keys, the good sticks that all others are made from, and what a stick may have in place of a file. A number
//! makes the same mutant on every machine, but for random parts of new signatures. The modules below make the changes,
//! one for each level. Never runs a program, never judges.
//!
//! Start at [`Mutator::mutant`].

#[path = "../../../crates/bundle/tests/it/astray.rs"]
mod astray;
mod bytes;
mod dice;
mod fields;
mod files;
mod keys;
mod lists;
mod seals;
mod starts;
mod statements;
mod stick;

pub use bytes::varied;
pub use dice::Dice;
pub use keys::{KeyHolder, Keys};
pub use stick::{Good, Item, Stick};

use crate::bundle_maker::{Files, rubbish};
use std::path::Path;

/// The number of the bundle that the unit has installed, the artist's.
pub const PLAYED: u64 = 5;
/// The number of the bundle on the stick.
pub const COMING: u64 = 6;
/// The flocks here: so many sheep, each with a loop of so many bytes.
const FORM: (usize, usize) = (3, 3_000);

/// The part of a stick that is changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Bytes of any file.
    Bytes,
    /// A line or a value in a text.
    Fields,
    /// A file is replaced.
    Files,
    /// The signature, or what is signed.
    Seals,
    /// Statements about keys.
    Statements,
    /// The list of files.
    Lists,
    /// The parts that a system starts from.
    Starts,
}

/// Who can detect the change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detection {
    /// Every reader.
    ByAll,
    /// Every reader, or the content is exactly what was signed.
    ByAllOrHarmless,
    /// Only a unit, by what it knows.
    ByUnits,
}

/// A changed stick.
#[derive(Clone, Debug)]
pub struct Mutant {
    /// Its number.
    pub seed: u64,
    /// The part that was changed.
    pub level: Level,
    /// What was done.
    pub what: String,
    /// Who can detect it.
    pub detection: Detection,
    /// The content of the stick.
    pub stick: Stick,
    /// The number of the good stick that it was made from.
    pub good: usize,
}

/// Makes all mutants.
pub struct Mutator {
    keys: Keys,
    /// By the artist, by a key that a statement trusts, and one with a system.
    goods: Vec<Good>,
    /// The bundle that the unit has installed.
    played: Good,
    /// A bundle for another unit, by the artist.
    others: Good,
}

impl Level {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Bytes, Self::Fields, Self::Files, Self::Seals, Self::Statements, Self::Lists, Self::Starts];
}

impl Mutator {
    /// Reads the keys in `fixtures` and makes the good sticks.
    pub fn new(fixtures: &Path) -> Self {
        let keys = Keys::read(fixtures);
        let flock = |edition| rubbish(FORM.0, FORM.1, edition);
        let good = |edition, who, unit, sequence| Good::new(&keys, &flock(edition), who, unit, sequence);
        let said = [
            keys.trust(KeyHolder::Artist, KeyHolder::New),
            keys.trust(KeyHolder::Artist, KeyHolder::Lost),
            keys.revoke(KeyHolder::Lost),
        ];
        let mut played = good(0, KeyHolder::Artist, "lobby", PLAYED);
        played.say(&said[1..]);
        let mut goods = vec![
            good(2, KeyHolder::Artist, "lobby", COMING),
            good(3, KeyHolder::New, "lobby", 1),
            good(2, KeyHolder::Artist, "lobby", COMING),
        ];
        for good in &mut goods {
            good.say(&said[..1]);
        }
        goods[2].add_system(&keys, fixtures);
        let others = good(1, KeyHolder::Artist, "stairs", COMING + 1);
        Self { keys, goods, played, others }
    }

    /// The bundle that the unit has installed.
    pub fn played(&self) -> &Good {
        &self.played
    }

    /// The good stick that `mutant` was made from.
    pub fn good(&self, mutant: &Mutant) -> &Good {
        &self.goods[mutant.good]
    }

    /// The good sticks.
    pub fn goods(&self) -> &[Good] {
        &self.goods
    }

    /// The public keys that units trust: name and text of each file.
    pub fn trusted(&self) -> [(&'static str, String); 2] {
        [("artist.pub", self.keys.public(KeyHolder::Artist)), ("spare.pub", self.keys.public(KeyHolder::Spare))]
    }

    /// Mutant number `seed`.
    pub fn mutant(&self, seed: u64) -> Mutant {
        let mut dice = Dice::of(seed);
        let level = Level::ALL[seed as usize % Level::ALL.len()];
        let good = match level {
            Level::Starts => 2,
            Level::Statements if dice.chance(80) => 1,
            Level::Bytes | Level::Fields | Level::Files | Level::Seals | Level::Statements | Level::Lists => {
                dice.below(self.goods.len())
            }
        };
        let mut stick = self.goods[good].stick.clone();
        let (from, material) = (&self.goods[good], Material { mutator: self, number: good });
        let (what, detection) = match level {
            Level::Bytes => bytes::change(&mut stick, &mut dice),
            Level::Fields => fields::change(&mut stick, from, material, &mut dice),
            Level::Files => files::change(&mut stick, &mut dice),
            Level::Seals => seals::change(&mut stick, from, material, &mut dice),
            Level::Statements => statements::change(&mut stick, from, material, &mut dice),
            Level::Lists => lists::change(&mut stick, from, material, &mut dice),
            Level::Starts => starts::change(&mut stick, from, material, &mut dice),
        };
        // A field may have been given the value that it had.
        let detection = if stick.0 == from.stick.0 { Detection::ByAllOrHarmless } else { detection };
        Mutant { seed, level, what, detection, stick, good }
    }
}

/// What else mutants are made from.
#[derive(Clone, Copy)]
struct Material<'m> {
    mutator: &'m Mutator,
    number: usize,
}

impl<'m> Material<'m> {
    fn keys(&self) -> &'m Keys {
        &self.mutator.keys
    }

    /// Another good stick.
    fn other(&self, dice: &mut Dice) -> &'m Good {
        let Mutator { goods, played, others, .. } = self.mutator;
        [played, others, &goods[1 - self.number.min(1)]][dice.below(3)]
    }
}

/// The files of the flock of this edition.
pub fn flock(edition: usize) -> Files {
    rubbish(FORM.0, FORM.1, edition)
}
