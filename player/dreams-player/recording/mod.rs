//! What happened in a run: trace, log lines, counters, faults, what is on the screen, and the saved place.
//!
//! Owns the files that the player writes. Never decides what is played.
//!
//! Start at [`Recorder`].

mod faults;
mod place_saver;
mod place_store;
mod recorder;
mod slowness;
mod trace;
mod view;

pub(crate) use faults::{Fault, Faults, Kind};
pub(crate) use place_saver::PlaceSaver;
pub(crate) use place_store::{PlaceStore, saved_place};
pub(crate) use recorder::{Record, Recorder, Trace};
pub(crate) use slowness::Slowness;
pub(crate) use view::{LitClip, SharedView, Tally, View};
