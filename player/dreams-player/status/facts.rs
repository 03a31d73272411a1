//! The contents of the status page, in one document.
//!
//! Owns the fields of `/status.json` and `/glass.json`. Gathered anew for each request: nothing is computed without one.

use super::standing::{ContactFacts, GenerationFacts};
use crate::recording::{Faults, LitClip, SharedView, Tally, View};
use crate::stream::FAULT_CARD;
use crate::stream::Plan;
use flock::{ClipKind, Flock, Itinerary};
use serde::Serialize;
use std::sync::Arc;
use timing::Rate;

/// Nanoseconds of a millisecond.
const NS_PER_MS: u64 = 1_000_000;

/// The state of the run.
#[derive(Debug, Serialize)]
pub(crate) struct Facts {
    /// The flock's name.
    pub(crate) flock: String,
    /// The flock's frames a second, numerator and denominator.
    pub(crate) fps: [u32; 2],
    /// How the screen is lit; none while it is away.
    pub(crate) screen: Option<ScreenFacts>,
    #[serde(flatten)]
    pub(crate) showing: Showing,
    /// The clip that comes next, if it is chosen.
    pub(crate) next: Option<String>,
    pub(crate) uptime_s: u64,
    #[serde(flatten)]
    pub(crate) tally: Tally,
    /// Whether frames are late all the time: this computer does not keep up with the flock.
    pub(crate) too_slow: bool,
    pub(crate) faults: u64,
    /// The latest faults, oldest first.
    pub(crate) latest_faults: Vec<FaultFacts>,
    /// The path: its seed and the steps taken.
    pub(crate) path: Option<PathFacts>,
    /// The flock's number and age, if it came as a bundle.
    pub(crate) generation: Option<GenerationFacts>,
    /// What became of the last look for another.
    pub(crate) contact: Option<ContactFacts>,
    /// The newest change of the owner's settings of the display; none since the run began.
    pub(crate) settings: Option<SettingsFacts>,
    /// What became of the newest request to the display to switch itself off or on; none if there was none.
    pub(crate) display_power: Option<PowerFacts>,
    /// Every sheep's share of the visits so far, and the one that is due to it.
    pub(crate) sheep: Vec<SheepFacts>,
}

#[derive(Debug, Serialize)]
pub(crate) struct ScreenFacts {
    pub(crate) name: String,
    pub(crate) mode: String,
    pub(crate) format: String,
    /// Vblanks per second, in thousandths.
    pub(crate) refresh_mhz: u64,
    /// What people on site are to be told of it.
    pub(crate) notes: Vec<String>,
}

/// What is shown now, and what was shown before.
#[derive(Debug, Serialize)]
pub(crate) struct Showing {
    /// What is on the glass; none before the first flip.
    pub(crate) glass: Option<GlassFacts>,
    /// The clip that was on the glass before that one; none at the start, and after a fault card.
    pub(crate) before: Option<ClipFacts>,
}

/// The frame on the glass, with its clip.
#[derive(Debug, Serialize)]
pub(crate) struct GlassFacts {
    pub(crate) clip: String,
    pub(crate) frame: u32,
    pub(crate) frames: u32,
    /// Whether the screen is there.
    pub(crate) is_lit: bool,
    #[serde(flatten)]
    pub(crate) of: Option<ClipFacts>,
}

/// A clip on the glass, or before it.
#[derive(Debug, Serialize)]
pub(crate) struct ClipFacts {
    /// The sheep of a loop; those at both ends of a transition.
    pub(crate) sheep: Vec<String>,
    /// The walk, and the steps that it had taken before this clip.
    pub(crate) seed: u64,
    pub(crate) step: u64,
    /// How long before the newest flip its first frame was lit.
    pub(crate) since_ms: u64,
    /// How long it lasts as a whole.
    pub(crate) lasts_ms: u64,
}

impl Showing {
    /// What `view` shows.
    pub(crate) fn of(view: &View) -> Self {
        let [newest, before] = &view.clips;
        let facts = |clip: &LitClip| {
            let scheduled = clip.scheduled.as_ref()?;
            let sheep = match &scheduled.what {
                ClipKind::Loop { sheep } => vec![sheep],
                ClipKind::Transition { from, to } => vec![from, to],
            };
            Some(ClipFacts {
                sheep: sheep.into_iter().map(|id| id.as_str().to_owned()).collect(),
                seed: scheduled.place.seed(),
                step: scheduled.place.step(),
                since_ms: view.at.since(clip.since) / NS_PER_MS,
                lasts_ms: scheduled.flock.manifest().fps.span_ns(u64::from(scheduled.frames.0)) / NS_PER_MS,
            })
        };
        let glass = view.shown.as_ref().map(|shown| GlassFacts {
            clip: shown.scheduled.as_ref().map_or(FAULT_CARD, |scheduled| scheduled.clip.as_str()).to_owned(),
            frame: shown.in_clip,
            frames: shown.scheduled.as_ref().map_or(1, |scheduled| scheduled.frames.0),
            is_lit: view.lit.is_some(),
            of: facts(newest),
        });
        Self { glass, before: facts(before) }
    }
}

#[derive(Debug, Serialize)]
pub(crate) struct FaultFacts {
    pub(crate) kind: &'static str,
    pub(crate) message: String,
}

#[derive(Debug, Serialize)]
pub(crate) struct SettingsFacts {
    /// The keys that got another value.
    pub(crate) changed: Vec<&'static str>,
    /// How long ago that was.
    pub(crate) age_s: u64,
}

#[derive(Debug, Serialize)]
pub(crate) struct PowerFacts {
    /// `ddc` or `cec`.
    pub(crate) by: String,
    /// What the display was asked: `on` or `off`.
    pub(crate) asked: &'static str,
    /// Why the display has not done so; none if it has.
    pub(crate) error: Option<String>,
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
        let screen = view.lit.as_ref().map(|lit| ScreenFacts {
            name: lit.screen.clone(),
            mode: lit.mode.clone(),
            format: lit.format.clone(),
            refresh_mhz: per_thousand_s(lit.refresh),
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
            showing: Showing::of(&view),
            next,
            uptime_s: uptime_ns / 1_000_000_000,
            tally: view.tally,
            too_slow: view.is_slow,
            faults: faults.count(),
            latest_faults: latest.map(|f| FaultFacts { kind: f.kind.name(), message: f.message }).collect(),
            generation: None,
            contact: None,
            settings: None,
            display_power: None,
            path: scheduled.map(|scheduled| PathFacts { seed: scheduled.place.seed(), step: scheduled.place.step() }),
            sheep: itinerary.map_or_else(Vec::new, |itinerary| sheep(&itinerary)),
        }
    }
}

/// How often something happens in a thousand seconds, to the nearest.
fn per_thousand_s(rate: Rate) -> u64 {
    let (num, den) = (u64::from(rate.num()), u64::from(rate.den()));
    (num * 1_000 + den / 2) / den
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
