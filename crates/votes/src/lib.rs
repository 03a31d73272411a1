//! The votes of the people before a wall.
//!
//! Owns what a press counts for, the totals by sheep, their store on a unit, and which reports of other units are
//! accepted. Never reads a clock, a device or a random source: they come in as arguments. Never knows a person, a time of
//! day or an order of presses.
//!
//! A *showing* is one visit of a sheep: from the middle of the transition to it until the middle of the one from it. At
//! most one vote counts per showing.
//!
//! | module | owns |
//! |---|---|
//! | `error` | why a report is refused, or a store cannot be used |
//! | `totals` | the document that is sent: totals by sheep, which only grow |
//! | `showing` | what was lit when: what a press counts for |
//! | `buttons` | which events of a key are presses |
//! | `noise` | the noise that a home may add |
//! | `ledger` | the open showings and the totals of a unit |
//! | `store` | the two files of a ledger |
//! | `received` | what the units have reported |
//!
//! Start at [`Ledger`] for a unit, at [`Received`] for the artist.
#![forbid(unsafe_code)]

mod buttons;
mod error;
mod ledger;
mod noise;
mod received;
mod showing;
mod store;
mod totals;

pub use buttons::{Buttons, Press, STUCK_NS};
pub use error::VotesError;
pub use ledger::{Credit, Ledger};
pub use received::{DAY_S, FOUNDED_DAY, Received, UnitLimits};
pub use showing::{Lit, SEEN_MS, Shows, Visit, Vote, seen};
pub use store::Store;
pub use totals::{LONGEST, LedgerId, MOST_SHEEP, SheepTotals, Totals};
