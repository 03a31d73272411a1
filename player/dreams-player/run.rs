//! One run of the player, from the manifest to the last flip.
//!
//! Owns the wiring of the threads and the order of things at the start: manifest, first clip and screen come first,
//! whatever a viewer does not see comes after. Decides nothing about playing.
//!
//! Flip thread (this one, `presenter.rs`) <- frames <- `decoder.rs` <- clips <- `clip_source.rs`; what happened goes to
//! `recorder.rs` and `place_saver.rs`, what is on the glass to `status`.

use crate::control::brightness::{DisplayTarget, LightingControl};
use crate::control::notice_pane::Overlay;
use crate::control::notice_watcher::Usher;
use crate::fatal::Fatal;
use crate::pipeline::clip_source::{Library, Struck, Successor};
use crate::pipeline::decoder::Workshop;
use crate::pipeline::first_frame::Herald;
use crate::pipeline::frame_queue::{Frames, shelf};
use crate::pipeline::presenter::{Ears, Ended, Show};
use crate::pipeline::start_gate::StartGate;
use crate::recording::faults::{Fault, Faults, Kind};
use crate::recording::place_saver::Saver;
use crate::recording::place_store::Slots;
use crate::recording::recorder::{Note, Scribe, Trace};
use crate::recording::view::SharedView;
use crate::settings::choices::{Clock, ScreenChoice};
use crate::settings::config::Config;
use crate::startup::signals::{stop_on_signals, watchdog_interval};
use crate::startup::{handover, screen_opening};
use crate::status;
use crate::stream::format::{StreamFormat, form};
use crate::stream::generation::Generation;
use crate::stream::path::path;
use crate::stream::plan::Plan;
use flock::{Flock, Itinerary, ManifestError, Place};
use player::ending::chain;
use player::now::{clock_s, now};
use player::owner::Owner;
use screen::ScreenError;
use std::num::NonZero;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{channel, sync_channel};
use std::thread::JoinHandle;
use video::SessionError;

/// Plays until it is told to stop, or to the end of what was asked for.
///
/// # Errors
/// [`Fatal`], if it cannot begin or go on.
pub(crate) fn play(config: &Config) -> Result<(), Fatal> {
    let stop = stop_on_signals()?;
    let generation = begun(config)?;
    let trial = generation.trial.clone();
    perform(config, generation, &stop).map_err(|fatal| match (fatal, trial) {
        (Fatal::Screen(error @ ScreenError::Size { .. }), Some(trial)) if trial.lost(&chain(&error)) => {
            Fatal::Trial(error)
        }
        // Nobody could see it.
        (Fatal::Screen(error), Some(trial)) => {
            trial.excused();
            Fatal::Screen(error)
        }
        (fatal, _) => fatal,
    })
}

/// The flock to play, begun.
fn begun(config: &Config) -> Result<Generation, ManifestError> {
    loop {
        let mut generation = Generation::open_or(&config.flock, &config.spare)?;
        if generation.begin() {
            return Ok(generation);
        }
    }
}

fn perform(config: &Config, generation: Generation, stop: &AtomicBool) -> Result<(), Fatal> {
    let (flock, trial) = (Arc::clone(&generation.flock), generation.trial.clone());
    let is_free = config.clock == Clock::Free && !matches!(config.screen, ScreenChoice::Kms(_));
    let format = StreamFormat::of(&flock, is_free);

    let create = |path: &PathBuf| Trace::create(path).map_err(|source| Fatal::Trace { path: path.clone(), source });
    let trace = config.trace.as_ref().map(create).transpose()?;
    let (scribe, scribing) = Scribe::start(trace, is_free)?;
    let faults = recorded(scribe.clone());
    let shared = Shared::default();
    let Shared { view, plan, overlay, target, gate } = &shared;
    let (slots, saved) = memory(config, &faults);
    let (card, lit) = handover::take().map(|handed| (handed.card, handed.place)).unzip();
    let lit = lit.and_then(|bytes| Place::from_bytes(&bytes).ok());
    let itinerary = path(&flock, lit.or(saved), config.seed);
    let (frames, studio) = open_studio(config, generation, itinerary, &faults, &shared)?;
    let output = Owner::kept(&config.owner).output();
    let screen = screen_opening::screen(&config.screen, format, output, card)?;
    if let Some(trial) = trial.as_ref().filter(|_| screen.lit().is_none()) {
        trial.excused();
    }
    let saver = Saver::start(slots, faults.clone(), is_free)?;
    LightingControl::new(config.day(), &config.owner).start(Arc::clone(target), clock_s)?;
    Usher::new(&config.card, clock_s()).start(Arc::clone(view), Arc::clone(overlay), now)?;
    status::serve(&config.status, shared.page(flock, &faults, config));

    let (saver, watchdog) = (Some(saver), watchdog_interval());
    let ears =
        Ears { scribe: scribe.clone(), faults: faults.clone(), saver, view, overlay, target, gate, stop, watchdog };
    let (ended, saver) = Show::new(screen, frames, format, ears).run()?;

    let next = ended.turn.as_ref().filter(|_| ended.finished).and_then(|turn| plan.after(turn.number));
    if let (Some(saver), Some(next)) = (&saver, next) {
        saver.keep(&next);
    }
    if let Some(saver) = saver {
        saver.end();
    }
    scribe.note(Note::End { tally: ended.tally, faults: faults.count() });
    scribing.join().ok();
    let last = ended.turn.as_ref().map_or(trial, |turn| turn.trial.clone());
    if let Some(trial) = last {
        trial.excused();
    }
    verdict(config, &ended, studio)
}

/// What the threads of a run share.
#[derive(Default)]
struct Shared {
    view: Arc<SharedView>,
    plan: Arc<Plan>,
    overlay: Arc<Overlay>,
    target: Arc<DisplayTarget>,
    gate: Arc<StartGate>,
}

impl Shared {
    /// The status page of a run that begins now.
    fn page(&self, flock: Arc<Flock>, faults: &Faults, config: &Config) -> status::Page {
        let (view, plan, overlay) = (Arc::clone(&self.view), Arc::clone(&self.plan), Arc::clone(&self.overlay));
        status::Page { flock, view, plan, overlay, faults: faults.clone(), begun: now(), source: config.flock.clone() }
    }
}

/// The faults of a run, which are written down by `scribe`.
fn recorded(scribe: Scribe) -> Faults {
    Faults::new(move |Fault { kind, message, is_repeated }| {
        scribe.note(Note::Fault { kind: kind.name(), message, is_repeated });
    })
}

/// The slots for the walk's place and what they hold. Without them the picture comes all the same.
fn memory(config: &Config, faults: &Faults) -> (Option<Slots>, Option<Place>) {
    match Slots::open(&config.state) {
        Ok((slots, bytes)) => {
            let place = bytes.map(|bytes| Place::from_bytes(&bytes)).transpose().unwrap_or_else(|error| {
                faults.once(Kind::Place, "read", format!("the kept place is of no use: {}", chain(&error)));
                None
            });
            (Some(slots), place)
        }
        Err(error) => {
            let state = config.state.display();
            faults.once(Kind::Place, "open", format!("cannot keep the walk's place in `{state}`: {}", chain(&error)));
            (None, None)
        }
    }
}

/// The threads that make frames, to be asked at the end how it went.
struct Studio {
    library: JoinHandle<()>,
    decoder: JoinHandle<Result<(), SessionError>>,
}

/// Starts library and decoder.
fn open_studio(
    config: &Config,
    generation: Generation,
    itinerary: Itinerary,
    faults: &Faults,
    shared: &Shared,
) -> Result<(Frames, Studio), Fatal> {
    let (orders, inbox) = sync_channel(1);
    let (reports, ends) = channel();
    let threads = usize::try_from(config.threads).ok().and_then(NonZero::new).unwrap_or(NonZero::<usize>::MIN);
    let workshop = Workshop { threads, prefetch_ms: config.prefetch_ms, is_hashed: config.hash };
    let (hand, frames) = shelf(usize::try_from(config.ahead).unwrap_or(usize::MAX));
    let form = form(&generation.flock);
    let library = Library {
        source: config.flock.clone(),
        generation,
        successor: Successor::default(),
        form,
        is_reformed: false,
        itinerary,
        clips: config.clips,
        faults: faults.clone(),
        plan: Arc::clone(&shared.plan),
        view: Arc::clone(&shared.view),
        gate: Arc::clone(&shared.gate),
        now,
        struck: Struck::default(),
        herald: Some(Herald { frames: hand.side(), is_hashed: config.hash }),
    };
    let library = library.open(orders, ends)?;
    let decoder = workshop.open(hand, inbox, reports, faults.clone(), Arc::clone(&shared.gate))?;
    Ok((frames, Studio { library, decoder }))
}

/// Whether the run was what was asked for. A panic of the studio becomes ours.
fn verdict(config: &Config, ended: &Ended, studio: Studio) -> Result<(), Fatal> {
    if !ended.finished {
        return Ok(());
    }
    studio.decoder.join().unwrap_or_else(|panic| resume_unwind(panic))?;
    studio.library.join().unwrap_or_else(|panic| resume_unwind(panic));
    let played = ended.turn.as_ref().map_or(0, |_| ended.tally.joins + 1);
    let flock = config.flock.clone();
    match config.clips {
        Some(wanted) if played >= wanted => Ok(()),
        Some(wanted) if played > 0 => Err(Fatal::TooFew { flock, wanted, played }),
        Some(_) | None => Err(Fatal::NothingToPlay { flock }),
    }
}
