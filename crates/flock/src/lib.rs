//! The flock: manifest, graph, faults, shares and the walk.
//!
//! Owns what a flock means: the studio and the unit read the same manifest and walk the same code, so that what
//! `flock walk` prints is what the wall shows. Never touches a pixel, a socket or a clock; the only file it reads is
//! the manifest, clips are hashed and probed by the tools.
//!
//! Start at [`Manifest`], then [`Flock`], then [`Itinerary`], which the player drives.
#![forbid(unsafe_code)]

mod balance;
mod carry;
mod closed;
mod edit;
mod faults;
mod flock;
mod flock_shares;
mod graph;
mod itinerary;
mod ledger;
mod manifest;
mod memory;
mod names;
mod plain;
mod runs;
mod shares;
mod simulation;
mod structure;
mod table;
mod tally;
mod told;
mod walk;

pub use balance::{Balance, Balanced, Bottleneck, Suggestion, Suggestions, Terms, Weight};
pub use edit::{Edit, EditError};
pub use faults::{Fault, FaultKind, forced_repeats};
pub use flock::Flock;
pub use flock_shares::{FlockShares, SheepShare, TransitionShare};
pub use graph::{Exit, Graph, SheepIx};
pub use itinerary::{ClipRef, Itinerary, Leg, Showing, What};
pub use ledger::{Ledger, THETA};
pub use manifest::{
    Clip, FASTEST_FPS, FILE_NAME, MOST_FRAMES, MOST_REPEATS, Manifest, SIDES_PX, Sheep, Transition, UNIT_BYTES,
    UNIT_DOCUMENT_BYTES,
};
pub use memory::{Place, PlaceError};
pub use names::{ClipHash, ClipPath, NameError, SheepId};
pub use shares::{Shares, SharesError};
pub use simulation::{FirstRepeat, Simulation, Visits};
pub use structure::Structure;
pub use table::ManifestError;
pub use tally::Tally;
pub use told::told;
pub use walk::{Step, Walk};
