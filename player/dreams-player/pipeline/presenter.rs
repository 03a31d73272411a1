//! The flip thread: shows each frame at its vblank.
//!
//! Owns the screen and the counters. Never opens, reads or writes a file, and allocates nothing per frame: only at joins,
//! when a screen comes or changes its mode, for a fault's message, for the fault card and for the first frame under a
//! notice. `playback.rs` holds the frames and decides what happens next, `pacing.rs` when, and `glass.rs` knows the
//! display; frames come from `decoder.rs`; events go to `recorder.rs`.
//!
//! Start at [`Presenter::run`].

mod display;

use self::display::Absence;
use crate::control::{DisplayTarget, Overlay, PaneBuffer};
use crate::pipeline::frame_queue::{FrameSource, NextFrame};
use crate::pipeline::glass::{self, Glass};
use crate::pipeline::pacing::Pacing;
use crate::pipeline::playback::{self, Effect, Ending, Kept, Next};
use crate::pipeline::start_gate::StartGate;
use crate::recording::{Faults, Kind, PlaceSaver, Record, Recorder, SharedView, Tally};
use crate::stream::{FaultCard, Frame, Pixels, ScheduledClip, StreamFormat};
use screen::{OutputSettings, Screen, ScreenError, ScreenInfo};
use settings::hours::Lighting;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use timing::{Nanos, Rate, Vblank};

/// The longest wait for one event of the screen: short enough to end within a second.
const QUIET: Duration = Duration::from_millis(250);
/// The longest wait for a frame while nothing is lit.
const PATIENCE: Duration = Duration::from_millis(50);

/// How long a frame may be held, while clips are to come, before the watchdog restarts the player. A clip that cannot be
/// read at the moment is given up earlier.
const LONGEST_HOLD: Duration = Duration::from_mins(2);

/// What the presenter shares with other threads.
pub(crate) struct PresenterHandles<'a> {
    pub(crate) recorder: Recorder,
    pub(crate) faults: Faults,
    /// Gets every clip whose first frame is lit; `None` where places are not saved.
    pub(crate) saver: Option<PlaceSaver>,
    pub(crate) view: &'a SharedView,
    pub(crate) overlay: &'a Overlay,
    pub(crate) target: &'a DisplayTarget,
    pub(crate) gate: &'a StartGate,
    pub(crate) stop: &'a AtomicBool,
    /// How often the watchdog is fed.
    pub(crate) watchdog: Option<Duration>,
}

/// How a run ended.
#[derive(Debug)]
pub(crate) struct RunEnd {
    /// The clip that was lit last.
    pub(crate) scheduled: Option<Arc<ScheduledClip>>,
    /// Whether it had been shown to its end.
    pub(crate) finished: bool,
    /// The counters.
    pub(crate) tally: Tally,
}

type Playback = playback::Playback<SourceFrame, Absence>;
type Event = playback::Event<SourceFrame, Absence>;

/// One run, from the first frame to the last.
pub(crate) struct Presenter<'a, F> {
    screen: Box<dyn Screen>,
    source: F,
    handles: PresenterHandles<'a>,
    /// The form that the screen is fitted to.
    format: StreamFormat,
    playback: Playback,
    glass: Glass<Arc<ScreenInfo>>,
    pacing: Pacing,
    tally: Tally,
    /// When the watchdog was fed last.
    fed: Nanos,
    /// When a frame was lit last that was not lit already.
    moved: Nanos,
    /// The brightness and the owner's settings that the screen has.
    lighting: Lighting,
    output: Option<Arc<OutputSettings>>,
    /// Whether the frames are dimmed in place of the display, for a notice.
    is_lifted: bool,
    /// Memory for the picture under a notice.
    buffer: PaneBuffer,
}

/// A frame as the source gave it.
#[derive(Debug)]
struct SourceFrame {
    frame: Frame,
    /// It came ahead of the stream, which brings it again: until there is more it stays lit, and nothing is late.
    is_ahead: bool,
}

impl SourceFrame {
    /// The size and the rate of its flock; `None` for the fault card.
    fn form(&self) -> Option<((u32, u32), Rate)> {
        let manifest = self.frame.scheduled.as_ref()?.flock.manifest();
        Some((manifest.size, manifest.fps))
    }
}

impl<'a, F: FrameSource> Presenter<'a, F> {
    /// A presenter that has not begun.
    pub(crate) fn new(screen: Box<dyn Screen>, source: F, format: StreamFormat, handles: PresenterHandles<'a>) -> Self {
        let playback =
            if screen.info().is_some() { Playback::Dark } else { Playback::Away(Kept::Nothing, Absence::Gone) };
        let mut presenter = Self {
            screen,
            source,
            handles,
            format,
            playback,
            glass: Glass::Unseen,
            // The refresh is not known before there is a screen.
            pacing: Pacing::new(format.fps, format.fps),
            tally: Tally::default(),
            fed: Nanos(0),
            moved: Nanos(0),
            lighting: Lighting::FULL,
            output: None,
            is_lifted: false,
            buffer: PaneBuffer::default(),
        };
        presenter.back();
        presenter
    }

    /// Plays until the source is finished or a signal stops it. Returns the place saver.
    /// Errors: [`ScreenError`], if the flock's pictures do not fit the screen.
    pub(crate) fn run(mut self) -> Result<(RunEnd, Option<PlaceSaver>), ScreenError> {
        while !matches!(self.playback, Playback::Ended(..)) {
            let mut news = self.observe()?;
            while let Some(event) = news {
                let (playback, effect) = self.playback.on(event);
                self.playback = playback;
                news = self.act(effect)?;
            }
        }
        let finished = matches!(self.playback, Playback::Ended(_, Ending::Finished));
        let tally = if finished { self.tally } else { self.tally_now() };
        let scheduled = self.playback.shown().and_then(|shown| shown.frame.scheduled.clone());
        Ok((RunEnd { scheduled, finished, tally }, self.handles.saver))
    }

    /// Waits until something happens; `None` if that changes nothing.
    fn observe(&mut self) -> Result<Option<Event>, ScreenError> {
        if self.handles.stop.load(Ordering::Relaxed) {
            return Ok(Some(Event::Stop));
        }
        if let Some(event) = self.go_by_the_owner()? {
            return Ok(Some(event));
        }
        Ok(match self.playback {
            Playback::Dark => self.look(PATIENCE).or_else(|| self.listen(Duration::ZERO)),
            Playback::Lit(_, Next::Missing) | Playback::Holding(_) if self.format.free => self.look(PATIENCE),
            Playback::Lit(..) if self.pacing.last_vblank().is_none() => Some(Event::Due),
            Playback::Away(_, Absence::Night(_)) => self.stay_black().map(|()| None)?,
            Playback::Rising(_)
            | Playback::Lit(..)
            | Playback::Flying(..)
            | Playback::Relighting(..)
            | Playback::Proving(_)
            | Playback::Holding(_)
            | Playback::Away(_, Absence::Gone) => self.listen(QUIET),
            Playback::Ended(..) => None,
        })
    }

    /// Asks the source for the next frame.
    fn look(&mut self, patience: Duration) -> Option<Event> {
        let shown = self.playback.shown();
        match self.source.next(patience) {
            NextFrame::First(_) if shown.is_some() => None,
            NextFrame::First(frame) => Some(Event::Ready(SourceFrame { frame, is_ahead: true })),
            NextFrame::Frame(frame) if shown.is_some_and(|shown| shown.is_ahead && shown.frame.is(&frame)) => {
                self.look(patience)
            }
            NextFrame::Frame(frame) => Some(Event::Ready(SourceFrame { frame, is_ahead: false })),
            NextFrame::Barren if shown.is_none() => {
                let pixels = Pixels::Drawn(Arc::new(FaultCard::draw(self.format.size)));
                let frame = Frame { pixels, scheduled: None, in_clip: 0, index: 0, hash: None };
                Some(Event::Barren(SourceFrame { frame, is_ahead: false }))
            }
            NextFrame::Barren | NextFrame::Nothing => None,
            NextFrame::Finished => Some(Event::Finished),
        }
    }

    /// Waits for an event of the screen.
    fn listen(&mut self, patience: Duration) -> Option<Event> {
        match self.screen.next_event(patience) {
            screen::Event::Flip { vblank, at } => self.arrived(vblank, at),
            screen::Event::Vblank { vblank, .. } => {
                self.pacing.begun(vblank);
                if matches!(self.playback, Playback::Holding(_)) {
                    self.handles.view.counted(self.tally_now());
                }
                Some(Event::Vblank)
            }
            screen::Event::Lost { reason } => {
                self.handles.faults.tell(Kind::Screen, reason);
                Some(self.lost(Absence::Gone))
            }
            // A night is no fault; in all else it is as if the screen were gone.
            screen::Event::Asleep => Some(self.lost(Absence::Gone)),
            screen::Event::Back => {
                self.back();
                Some(Event::Back)
            }
            screen::Event::Recovered { reason } => {
                self.handles.faults.tell(Kind::Screen, reason);
                Some(Event::Recovered)
            }
            screen::Event::Changed => {
                self.glass_is(glass::Event::Changed);
                None
            }
            screen::Event::Idle => {
                self.stay_alive(&screen::Event::Idle);
                Some(Event::Idle)
            }
        }
    }

    /// Asks the screen for an event at `vblank`.
    fn ask(&mut self, vblank: Option<Vblank>) {
        if let Some(vblank) = vblank {
            self.screen.notify_at(vblank);
        }
    }

    fn glass_is(&mut self, event: glass::Event<Arc<ScreenInfo>>) {
        self.glass = std::mem::take(&mut self.glass).on(event);
    }

    /// The screen is there: again, or for the first time.
    fn back(&mut self) {
        let Some(lit) = self.screen.info().map(Arc::new) else { return };
        self.handles.view.lit(Some(&lit));
        self.pacing.set_refresh(lit.refresh);
        if self.glass.mode() != Some(&lit) {
            self.handles.recorder.record(Record::Start { lit: Arc::clone(&lit), fps: self.pacing.frames() });
        }
        self.glass_is(glass::Event::Seen(lit));
    }

    /// The screen is gone: the awaited frame was late until now, and is not from here on.
    fn lost(&mut self, why: Absence) -> Event {
        self.handles.view.lit(None);
        self.tally = self.tally_now();
        self.pacing.settle();
        Event::Lost(why)
    }

    /// What was committed is on the glass.
    fn arrived(&mut self, vblank: Vblank, at: Nanos) -> Option<Event> {
        if matches!(self.playback, Playback::Rising(_) | Playback::Flying(..)) {
            self.goes_on(vblank);
        }
        let (shown, late) = match &self.playback {
            Playback::Rising(shown) => {
                join(None, &shown.frame, &mut self.tally, &self.handles);
                (shown, self.pacing.flipped(vblank))
            }
            Playback::Flying(before, shown) => {
                join(Some(&before.frame), &shown.frame, &mut self.tally, &self.handles);
                let late = self.pacing.flipped(vblank);
                (shown, if before.is_ahead { 0 } else { late })
            }
            Playback::Relighting(shown, _) => {
                self.pacing.resumed(vblank);
                (shown, 0)
            }
            Playback::Proving(shown) => {
                self.pacing.repeated(vblank);
                (shown, 0)
            }
            Playback::Dark | Playback::Lit(..) | Playback::Holding(_) | Playback::Away(..) | Playback::Ended(..) => {
                return None;
            }
        };
        self.tally.flips += 1;
        self.tally.late += u64::from(late);
        self.tally.repeated += u64::from(self.playback.coming().is_none());
        let SourceFrame { frame: shown, .. } = shown;
        let (clip, frame, hash) = (shown.scheduled.clone(), shown.in_clip, shown.hash);
        self.handles.recorder.record(Record::Flip { clip, frame, vblank, at, late, hash, mark: self.buffer.mark });
        self.handles.view.flipped(shown, self.tally_now(), at);
        let is_proof = matches!(self.playback, Playback::Proving(_));
        // The fault card is held for as long as there is no clip.
        if !is_proof || shown.scheduled.is_none() {
            self.moved = at;
        }
        if u128::from(at.since(self.moved)) <= LONGEST_HOLD.as_nanos() {
            self.feed(at);
        }
        Some(Event::Flipped)
    }

    /// The counters, with the frame that is awaited now as late as it is.
    fn tally_now(&self) -> Tally {
        let is_ahead = self.playback.shown().is_some_and(|shown| shown.is_ahead);
        let overdue = if is_ahead { 0 } else { self.pacing.overdue() };
        Tally { late: self.tally.late + u64::from(overdue), ..self.tally }
    }

    /// Feeds the watchdog after a completed flip, as often as it needs.
    fn feed(&mut self, at: Nanos) {
        let record = if matches!(self.playback, Playback::Rising(_)) {
            self.handles.gate.open();
            Record::Ready
        } else if self.handles.watchdog.is_some_and(|often| u128::from(at.since(self.fed)) >= often.as_nanos()) {
            Record::Alive
        } else {
            return;
        };
        self.fed = at;
        self.handles.recorder.record(record);
    }

    /// Fits the screen to the next frame, where that is of a flock of another size or rate than the lit one.
    fn fit(&mut self) {
        let [lit, next] =
            [self.playback.shown(), self.playback.coming()].map(|frame| frame.and_then(SourceFrame::form));
        let (Some((size, fps)), true) = (next, lit.is_some() && lit != next) else { return };
        if (size, fps) != (self.format.size, self.format.fps) {
            (self.format.size, self.format.fps) = (size, fps);
            self.screen.set_format(size, fps);
            self.glass_is(glass::Event::Changed);
        }
    }

    /// A new frame is on the glass. If it is the first of another form it came in its time, unless a mode had to be set for
    /// it.
    fn goes_on(&mut self, vblank: Vblank) {
        let Glass::Changing(known) = &self.glass else { return };
        let Some(lit) = self.screen.info().map(Arc::new) else { return };
        if known.mode != lit.mode {
            self.pacing.resumed(vblank);
        }
        let form = self.playback.coming().and_then(SourceFrame::form);
        let fps = form.map_or(self.pacing.frames(), |(_, fps)| fps);
        self.pacing.goes_on(fps, lit.refresh);
        self.handles.view.lit(Some(&lit));
        self.handles.recorder.record(Record::Start { lit: Arc::clone(&lit), fps });
        self.glass_is(glass::Event::Arrived(lit));
    }

    fn act(&mut self, effect: Effect) -> Result<Option<Event>, ScreenError> {
        match effect {
            Effect::Wait | Effect::End => {}
            Effect::Stage => self.stage_next()?,
            Effect::Commit => self.screen.commit(),
            Effect::Light => {
                self.stage_next()?;
                self.screen.commit();
            }
            Effect::Relight => {
                self.stage(Playback::shown)?;
                self.screen.commit();
            }
            Effect::AwaitDue => self.ask(self.pacing.last_vblank()),
            Effect::AwaitDueAndStage => {
                self.ask(self.pacing.last_vblank());
                self.stage_next()?;
            }
            Effect::AwaitDueAndLook => {
                self.ask(self.pacing.last_vblank());
                return Ok(self.look(Duration::ZERO));
            }
            Effect::AwaitVblank => self.ask(Some(self.pacing.next_vblank())),
            Effect::AwaitVblankAndLook => {
                self.ask(Some(self.pacing.next_vblank()));
                return Ok(self.look(Duration::ZERO));
            }
            Effect::LookOrAwaitVblank => {
                let news = self.look(Duration::ZERO).or(self.pacing.is_stale().then_some(Event::Stale));
                if news.is_none() {
                    self.ask(Some(self.pacing.next_vblank()));
                }
                return Ok(news);
            }
        }
        Ok(None)
    }

    fn stage_next(&mut self) -> Result<(), ScreenError> {
        self.fit();
        self.stage(Playback::coming)
    }

    /// Stages a frame, with what lies over it.
    fn stage(&mut self, which: fn(&Playback) -> Option<&SourceFrame>) -> Result<(), ScreenError> {
        let panes = self.handles.overlay.get();
        self.lift(panes.has_notice());
        let samples = self.brightness().samples;
        let Some(SourceFrame { frame, .. }) = which(&self.playback) else { return Ok(()) };
        self.screen.stage(&panes.over(&frame.pixels.picture(), samples, &mut self.buffer))
    }
}

/// Counts and records a join, if `before` was a frame of another clip than `shown`, and has the place of its clip saved.
fn join(before: Option<&Frame>, shown: &Frame, tally: &mut Tally, handles: &PresenterHandles<'_>) {
    let Some(to) = &shown.scheduled else { return };
    let from = before.and_then(|before| Some((before.index, before.scheduled.as_ref()?)));
    tally.skipped += from.map_or(0, |(index, _)| shown.index.saturating_sub(index + 1));
    if from.is_some_and(|(_, from)| from.number == to.number) {
        return;
    }
    if let Some(saver) = &handles.saver {
        saver.save(to);
    }
    if let Some((_, from)) = from {
        tally.joins += 1;
        handles.recorder.record(Record::Join { from: Arc::clone(from), to: Arc::clone(to) });
    }
}

#[cfg(test)]
mod tests;
