//! What happens in a pool.
//!
//! Owns the events, and the stamp that orders those of several pools. Never reads a file: [`crate::Ledger`] does.
//!
//! Start at [`Event`].

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::id::{Id, Origin};
use crate::rating::Count;
use crate::traits::Traits;

/// A day, counted from 1 January 1970.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Day(pub u32);

/// What an event is known by among all events of all pools. Its number is larger than those of all events that its pool
/// knew, also of those of other pools: so in the order of stamps no event comes before one that it depends on.
///
/// # Source
/// Lamport, *Time, Clocks, and the Ordering of Events in a Distributed System* (1978).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Stamp {
    /// The number.
    pub number: u64,
    /// The pool that it happened in.
    pub pool: Origin,
}

/// An event with its stamp.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Its stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// When.
    pub day: Day,
    /// What.
    #[serde(flatten)]
    pub event: Event,
}

/// What happens.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "lowercase")]
pub enum Event {
    /// A sheep came into the pool.
    Born(Born),
    /// A brood was made; its births follow.
    Brood {
        /// Its number.
        brood: u32,
        /// The seed that it was made from.
        seed: u64,
    },
    /// A sheep died.
    Died {
        /// Which.
        id: Id,
    },
    /// An edition was made; it replaces the one of the same name. Without sheep it is given up.
    Elected {
        /// Its name: that of the unit that has it, or any other.
        edition: String,
        /// Its sheep.
        ids: Vec<Id>,
        /// How many of them, the last ones, are for no other edition.
        #[serde(default)]
        unique: usize,
    },
    /// The artist judged a sheep.
    Marked {
        /// Which.
        id: Id,
        /// How.
        mark: Mark,
    },
    /// A sheep that had died lives again.
    Reborn {
        /// Which.
        id: Id,
    },
    /// What a unit has counted in all, of each sheep that has more than before. What two pools heard of a unit counts once
    /// when they are merged.
    Votes {
        /// The unit.
        unit: String,
        /// The totals. Sheep of other pools may be among them.
        sheep: BTreeMap<String, Count>,
    },
    /// The artist brought in a genome, which waits to be a stranger of a brood of the pool in which this happened.
    Waits(Waiting),
}

/// A birth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Born {
    /// Its id.
    pub id: Id,
    /// Its parents: two after crossing, one after mutation, none of a stranger.
    #[serde(default)]
    pub parents: Vec<Id>,
    /// How it was made.
    pub operator: String,
    /// The seed of its random numbers.
    pub seed: u64,
    /// Its species.
    pub species: String,
    /// Its figures.
    pub figures: Traits,
    /// Its licence.
    pub licence: String,
    /// How far its children differ from it: 1 is usual.
    #[serde(default = "one")]
    pub strength: f64,
    /// The event since which its genome waited, if it did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub waited: Option<Stamp>,
}

/// A genome that waits to be born.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Waiting {
    /// Its species.
    pub species: String,
    /// Its figures.
    pub figures: Traits,
    /// Its licence.
    pub licence: String,
    /// The text of its file.
    pub genome: String,
}

/// The artist's judgement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mark {
    /// Stays as long as it has this mark.
    Keep,
    /// Takes back what was said.
    None,
    /// Dies, and is not born again.
    Reject,
}

fn one() -> f64 {
    1.0
}
