//! The contents of the status page, in one document.
//!
//! Owns the fields of `/status.json`. Gathered anew for each request: nothing is computed without one.

use super::standing::{ContactFacts, GenerationFacts};
use crate::recording::{Faults, SharedView, Tally};
use crate::stream::FAULT_CARD;
use crate::stream::Plan;
use flock::{Flock, Itinerary};
use serde::Serialize;
use std::sync::Arc;

/// The state of the run.
#[derive(Debug, Serialize)]
pub(crate) struct Facts {
    /// The flock's name.
    pub(crate) flock: String,
    /// The flock's frames a second, numerator and denominator.
    pub(crate) fps: [u32; 2],
    /// How the screen is lit; none while it is away.
    pub(crate) screen: Option<ScreenFacts>,
    /// What is on the glass; none before the first flip.
    pub(crate) glass: Option<GlassFacts>,
    /// The clip that comes next, if it is chosen.
    pub(crate) next: Option<String>,
    pub(crate) uptime_s: u64,
    #[serde(flatten)]
    pub(crate) tally: Tally,
    pub(crate) faults: u64,
    /// The latest faults, oldest first.
    pub(crate) latest_faults: Vec<FaultFacts>,
    /// The path: its seed and the steps taken.
    pub(crate) path: Option<PathFacts>,
    /// The flock's number and age, if it came as a bundle.
    pub(crate) generation: Option<GenerationFacts>,
    /// What became of the last look for another.
    pub(crate) contact: Option<ContactFacts>,
    /// Every sheep's share of the visits so far, and the one that is due to it.
    pub(crate) sheep: Vec<SheepFacts>,
}

#[derive(Debug, Serialize)]
pub(crate) struct ScreenFacts {
    pub(crate) name: String,
    pub(crate) mode: String,
    pub(crate) format: String,
    /// What people on site are to be told of it.
    pub(crate) notes: Vec<String>,
}

#[derive(Debug, Serialize)]
pub(crate) struct GlassFacts {
    pub(crate) clip: String,
    pub(crate) frame: u32,
    pub(crate) frames: u32,
}

#[derive(Debug, Serialize)]
pub(crate) struct FaultFacts {
    pub(crate) kind: &'static str,
    pub(crate) message: String,
}

#[derive(Debug, Serialize)]
pub(crate) struct PathFacts {
    pub(crate) seed: u64,
    pub(crate) step: u64,
}

#[derive(Debug, Serialize)]
pub(crate) struct SheepFacts {
    pub(crate) id: String,
    pub(crate) visits: u64,
    pub(crate) share: f64,
    pub(crate) due: f64,
}

impl Facts {
    /// The state now, `uptime_ns` after the run began with `flock`.
    pub(crate) fn gather(flock: &Arc<Flock>, view: &SharedView, plan: &Plan, faults: &Faults, uptime_ns: u64) -> Self {
        let view = view.get();
        let scheduled = view.shown.as_ref().and_then(|shown| shown.scheduled.as_ref());
        let flock = scheduled.map_or(flock, |scheduled| &scheduled.flock);
        let manifest = flock.manifest();
        let on_glass = view.shown.as_ref().map(|shown| GlassFacts {
            clip: scheduled.map_or(FAULT_CARD, |scheduled| scheduled.clip.as_str()).to_owned(),
            frame: shown.in_clip,
            frames: scheduled.map_or(1, |scheduled| scheduled.frames.0),
        });
        let screen = view.lit.as_ref().map(|lit| ScreenFacts {
            name: lit.screen.clone(),
            mode: lit.mode.clone(),
            format: lit.format.clone(),
            notes: lit.notes.clone(),
        });
        let next =
            plan.after(scheduled.map_or(0, |scheduled| scheduled.number)).map(|next| next.clip.as_str().to_owned());
        let latest = faults.latest().into_iter();
        let itinerary = scheduled.and_then(|scheduled| Itinerary::resume(Arc::clone(flock), &scheduled.place).ok());
        Self {
            flock: manifest.name.clone(),
            fps: [manifest.fps.num(), manifest.fps.den()],
            screen,
            glass: on_glass,
            next,
            uptime_s: uptime_ns / 1_000_000_000,
            tally: view.tally,
            faults: faults.count(),
            latest_faults: latest.map(|f| FaultFacts { kind: f.kind.name(), message: f.message }).collect(),
            generation: None,
            contact: None,
            path: scheduled.map(|scheduled| PathFacts { seed: scheduled.place.seed(), step: scheduled.place.step() }),
            sheep: itinerary.map_or_else(Vec::new, |itinerary| sheep(&itinerary)),
        }
    }
}

fn sheep(itinerary: &Itinerary) -> Vec<SheepFacts> {
    let visits_by_sheep = itinerary.visits_by_sheep();
    let all = visits_by_sheep.iter().map(|showing| showing.visits).sum::<u64>().max(1) as f64;
    let facts = |showing: flock::SheepVisits| SheepFacts {
        id: showing.id.as_str().to_owned(),
        visits: showing.visits,
        share: showing.visits as f64 / all,
        due: showing.share,
    };
    visits_by_sheep.into_iter().map(facts).collect()
}
