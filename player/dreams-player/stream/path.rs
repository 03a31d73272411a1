//! Where a run begins in the walk.
//!
//! Owns the choice between the saved place and a fresh path. Never writes a place.

use diagnostics::chain;
use flock::{Flock, Itinerary, Place};
use std::sync::Arc;
use tracing::{info, warn};

/// How many bits a fresh seed has: what JSON, and so the status page, and `--seed` can tell exactly.
const FRESH_BITS: u32 = 53;

/// The path of this run: where it was left, unless another seed is asked for; else a fresh one.
pub(crate) fn path(flock: &Arc<Flock>, saved: Option<Place>, seed: Option<u64>) -> Itinerary {
    let kept = saved.filter(|place| seed.is_none_or(|seed| seed == place.seed()));
    if let Some(place) = kept {
        match Itinerary::resume(Arc::clone(flock), &place) {
            Ok(itinerary) => {
                info!(seed = place.seed(), step = place.step(), "resuming the path");
                return itinerary;
            }
            Err(error) => warn!(error = chain(&error), "cannot resume the path, starting a new one"),
        }
    }
    let seed = seed.unwrap_or_else(|| rand::random::<u64>() >> (u64::BITS - FRESH_BITS));
    info!(seed, "starting a new path");
    Itinerary::start(Arc::clone(flock), seed)
}
