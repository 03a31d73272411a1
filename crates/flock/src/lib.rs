//! The flock: manifest, graph, faults, shares and the walk.
//!
//! Owns what a flock means: the tools and the unit read the same manifest and run the same walk, so that a unit shows
//! what `dreams walk` prints. Never touches a pixel, a socket or a clock; the only file that it reads and writes is the
//! manifest; clips are hashed and probed by the tools.
//!
//! A folder sees only folders above it in this table; `tests/it/house/folders.rs` holds that.
//!
//! | folder | what is there |
//! |---|---|
//! | `manifest` | `flock.toml`: its keys and their limits, names, errors |
//! | `edit` | changes of a manifest's text that keep every other byte |
//! | `folder` | the manifest locked while it is edited, and the usual paths of a flock's files |
//! | `graph` | sheep and transitions by number, and which parts hang together |
//! | `shares` | how often each sheep comes in the long run |
//! | `flock` | a manifest ready to be walked: the part that is played, its faults, its shares |
//! | `walk` | what comes next, and the place that a unit saves |
//! | `simulation` | what a long walk amounts to |
//! | `balance` | weights that give the shares that are wanted |
//!
//! Start at [`Manifest`], then [`Flock`], then [`Itinerary`], which the player drives.
#![forbid(unsafe_code)]

mod balance;
mod edit;
mod flock;
mod folder;
mod graph;
mod manifest;
mod shares;
mod simulation;
mod walk;

pub use balance::{Balance, Bottleneck, SheepBalance, Suggestion, Suggestions, Terms, Weight};
pub use edit::{Edit, EditError};
pub use flock::{
    Bridge, Fault, FaultKind, Flock, FlockShares, Measure, Part, Parts, SheepShare, TransitionShare, forced_repeats,
};
pub use folder::{Draft, DraftError, Turn, paths};
pub use graph::{Exit, Graph, SheepIx, Structure};
pub use manifest::{
    Clip, ClipHash, ClipPath, FILE_NAME, MAX_FPS, MAX_FRAMES, MAX_REPEATS, Manifest, ManifestError, NameError,
    SIDES_PX, Sheep, SheepId, Transition, UNIT_BYTES, UNIT_DOCUMENT_BYTES, excerpt,
};
pub use shares::{Shares, SharesError};
pub use simulation::{FirstRepeat, Simulation, Tally, Visits};
pub use walk::{ClipKind, ClipRef, Itinerary, Leg, Place, PlaceError, SheepVisits, Step, Walk};
