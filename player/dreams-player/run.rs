//! One run of the player, from the manifest to the last flip.
//!
//! Owns the connections between the threads and the order of the start: manifest, first clip and screen come first,
//! what a viewer does not see comes after. Decides nothing about playing.
//!
//! Flip thread (this one, `presenter.rs`) <- frames <- `decoder.rs` <- clips <- `clip_source.rs`; events go to
//! `recording`, and `status` shows them.

use crate::control::{Acknowledgements, BrightnessControl, DisplayTarget, NoticeWatcher, Overlay};
use crate::fatal::Fatal;
use crate::pipeline::{
    ClipSource, DecoderSettings, FirstFrame, FrameReceiver, Presenter, PresenterHandles, RunEnd, StartGate, Strikes,
    Successor, frame_queue,
};
use crate::recording::{Fault, Faults, Kind, PlaceSaver, PlaceStore, Record, Recorder, SharedView, Trace};
use crate::settings::{Clock, Config, ScreenChoice};
use crate::startup::signals::{stop_on_signals, watchdog_interval};
use crate::startup::{handover, screen_opening};
use crate::status;
use crate::stream::{Generation, Plan, StreamFormat, path};
use diagnostics::chain;
use flock::{Flock, Itinerary, ManifestError, Place};
use player::{ClockReader, clock_s, now};
use screen::ScreenError;
use settings::Owner;
use std::num::NonZero;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{channel, sync_channel};
use std::thread::JoinHandle;
use video::SessionError;

/// Plays until a signal, or to the end of what was asked for.
/// Errors: [`Fatal`], if it cannot begin or go on.
pub(crate) fn play(config: &Config) -> Result<(), Fatal> {
    let stop = stop_on_signals()?;
    let generation = begun(config)?;
    let trial = generation.trial.clone();
    perform(config, generation, &stop).map_err(|fatal| match (fatal, trial) {
        (Fatal::Screen(error @ ScreenError::Size { .. }), Some(trial)) if trial.lost(&chain(&error)) => {
            Fatal::Trial(error)
        }
        // Without a screen the trial says nothing about the flock.
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
    let (recorder, recorder_thread) = Recorder::start(trace, is_free)?;
    let faults = recorded(recorder.clone());
    let shared = Shared::default();
    let Shared { view, plan, overlay, target, gate } = &shared;
    let (store, saved) = memory(config, &faults);
    let (card, lit) = handover::take(handover::SOCKET.as_ref()).map(|handed| (handed.card, handed.place)).unzip();
    let lit = lit.and_then(|bytes| Place::from_bytes(&bytes).ok());
    let itinerary = path(&flock, lit.or(saved), config.seed);
    let (frames, pipeline) = start_pipeline(config, generation, itinerary, &faults, &shared)?;
    let output = Owner::kept(&config.owner).output();
    let screen = screen_opening::screen(&config.screen, format, output, card)?;
    if let Some(trial) = trial.as_ref().filter(|_| screen.info().is_none()) {
        trial.excused();
    }
    let saver = PlaceSaver::start(store, faults.clone(), is_free)?;
    let control = BrightnessControl::new(config.day(), &config.owner);
    control.start(Arc::clone(target), Arc::clone(view), ClockReader::of_machine())?;
    NoticeWatcher::new(&config.notice, clock_s()).start(Arc::clone(view), Arc::clone(overlay), faults.clone(), now)?;
    Acknowledgements::start(config.acknowledge.0.as_deref(), Arc::clone(view), Arc::clone(overlay), now)?;
    status::serve(&config.status, shared.page(flock, &faults, config));

    let (saver, watchdog) = (Some(saver), watchdog_interval());
    let handles = PresenterHandles {
        recorder: recorder.clone(),
        faults: faults.clone(),
        saver,
        view,
        overlay,
        target,
        gate,
        stop,
        watchdog,
    };
    let (ended, saver) = Presenter::new(screen, frames, format, handles).run()?;

    let next = ended.scheduled.as_ref().filter(|_| ended.finished).and_then(|scheduled| plan.after(scheduled.number));
    if let (Some(saver), Some(next)) = (&saver, next) {
        saver.save(&next);
    }
    if let Some(saver) = saver {
        saver.end();
    }
    recorder.record(Record::End { tally: ended.tally, faults: faults.count() });
    recorder_thread.join().ok();
    let last = ended.scheduled.as_ref().map_or(trial, |scheduled| scheduled.trial.clone());
    if let Some(trial) = last {
        trial.excused();
    }
    verdict(config, &ended, pipeline)
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
        let (target, faults, source) = (Arc::clone(&self.target), faults.clone(), config.flock.clone());
        status::Page { flock, view, plan, overlay, target, faults, begun: now(), source }
    }
}

/// The faults of a run, which `recorder` writes down.
fn recorded(recorder: Recorder) -> Faults {
    Faults::new(move |Fault { kind, message, is_repeated }| {
        recorder.record(Record::Fault { kind: kind.name(), message, is_repeated });
    })
}

/// The store of the walk's place and what it holds. The player plays without it, too.
fn memory(config: &Config, faults: &Faults) -> (Option<PlaceStore>, Option<Place>) {
    match PlaceStore::open(&config.state) {
        Ok((store, bytes)) => {
            let place = bytes.map(|bytes| Place::from_bytes(&bytes)).transpose().unwrap_or_else(|error| {
                faults.once(Kind::Place, "read", format!("cannot use the saved place: {}", chain(&error)));
                None
            });
            (Some(store), place)
        }
        Err(error) => {
            let state = config.state.display();
            faults.once(Kind::Place, "open", format!("cannot save the walk's place in `{state}`: {}", chain(&error)));
            (None, None)
        }
    }
}

/// The threads that make frames; their results are read at the end of the run.
struct Pipeline {
    clip_source: JoinHandle<()>,
    decoder: JoinHandle<Result<(), SessionError>>,
}

/// Starts the clip source and the decoder.
fn start_pipeline(
    config: &Config,
    generation: Generation,
    itinerary: Itinerary,
    faults: &Faults,
    shared: &Shared,
) -> Result<(FrameReceiver, Pipeline), Fatal> {
    let (orders, inbox) = sync_channel(1);
    let (clip_ends, ends) = channel();
    let threads = usize::try_from(config.threads).ok().and_then(NonZero::new).unwrap_or(NonZero::<usize>::MIN);
    let settings = DecoderSettings { threads, prefetch_ms: config.prefetch_ms, is_hashed: config.hash };
    let (sender, frames) = frame_queue(usize::try_from(config.ahead).unwrap_or(usize::MAX));
    let form = generation.form();
    let clip_source = ClipSource {
        source: config.flock.clone(),
        spare: config.spare.clone(),
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
        strikes: Strikes::default(),
        first_frame: Some(FirstFrame { frames: sender.first_frame_sender(), is_hashed: config.hash }),
    };
    let clip_source = clip_source.open(orders, ends)?;
    let decoder = settings.open(sender, inbox, clip_ends, faults.clone(), Arc::clone(&shared.gate))?;
    Ok((frames, Pipeline { clip_source, decoder }))
}

/// Whether the run did what was asked for. A panic of one of the threads is resumed here.
fn verdict(config: &Config, ended: &RunEnd, pipeline: Pipeline) -> Result<(), Fatal> {
    if !ended.finished {
        return Ok(());
    }
    pipeline.decoder.join().unwrap_or_else(|panic| resume_unwind(panic))?;
    pipeline.clip_source.join().unwrap_or_else(|panic| resume_unwind(panic));
    let played = ended.scheduled.as_ref().map_or(0, |_| ended.tally.joins + 1);
    let flock = config.flock.clone();
    match config.clips {
        Some(wanted) if played >= wanted => Ok(()),
        Some(wanted) if played > 0 => Err(Fatal::TooFew { flock, wanted, played }),
        Some(_) | None => Err(Fatal::NothingToPlay { flock }),
    }
}
