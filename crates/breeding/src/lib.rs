//! How a pool of sheep evolves by what people like: lineage, ratings, broods, deaths, editions.
//!
//! Owns the rules, as functions of settings and of the events of a ledger; and the folder that keeps both. The same ledger
//! and seed give the same brood, on any number of threads. Never knows a genome: a [`Nursery`] makes and draws candidates.
//! Never reads a clock: days are arguments.
//!
//! | file | what is there |
//! |---|---|
//! | `id.rs`, `event.rs`, `traits.rs` | the names of sheep, what happens, figures as numbers |
//! | `ledger.rs`, `settings.rs`, `folder.rs` | the files |
//! | `pool.rs`, `rating.rs`, `niches.rs`, `census.rs` | what follows from the events |
//! | `births.rs`, `screening.rs`, `brood.rs` | a brood: its plan, the guess of what will be liked, its births |
//! | `deaths.rs`, `elect.rs` | who dies, who goes to a unit |
//! | `simulation/` | a world of voters with a hidden taste, in which the rules are tried |
//!
//! Start at [`Folder`], or at [`breed`].
#![forbid(unsafe_code)]

mod births;
mod brood;
mod census;
mod chance;
mod deaths;
mod elect;
mod error;
mod event;
mod folder;
mod id;
mod ledger;
mod niches;
mod pool;
mod rating;
mod screening;
mod settings;
pub mod simulation;
mod traits;

pub use births::{Birth, Operation, Order, Plan, plan};
pub use brood::{Brood, Made, Nursery, Refused, breed};
pub use census::Census;
pub use deaths::{Deaths, deaths};
pub use elect::{Ballot, Elected, Reason, elect};
pub use error::BreedingError;
pub use event::{Born, Day, Entry, Event, Mark, Stamp, Waiting};
pub use folder::Folder;
pub use id::{Id, IdError, Origin};
pub use ledger::{LEDGER, Ledger};
pub use niches::{Niche, Niches};
pub use pool::{Edition, News, Pool, Sheep};
pub use rating::{Count, Tally, Votes};
pub use screening::Liking;
pub use settings::{LicencePolicy, SETTINGS, Settings};
pub use traits::{Point, Scale, Traits};
