//! The flip thread: shows each frame at its vblank.
//!
//! Owns the screen, the frame that is lit and the one that follows. Never opens, reads or writes a file, and allocates
//! nothing per frame: only at joins, when a screen comes or changes its mode, for a fault's message, for the fault card
//! and for the first frame under a notice. `playback.rs` decides what happens next, `pacing.rs` when; frames come from
//! `decoder.rs`; events go to `recorder.rs`.
//!
//! Start at [`Presenter::run`].

mod display;

use crate::control::{DisplayTarget, Overlay, PaneBuffer};
use crate::pipeline::black_picture::Blackout;
use crate::pipeline::frame_queue::{FrameSource, NextFrame};
use crate::pipeline::pacing::Pacing;
use crate::pipeline::playback::{Effect, Event, LastLit, Next, Playback};
use crate::pipeline::start_gate::StartGate;
use crate::recording::{Faults, Kind, PlaceSaver, Record, Recorder, SharedView, Tally};
use crate::stream::{FaultCard, Frame, Pixels, ScheduledClip, StreamFormat};
use flock::Flock;
use player::hours::Lighting;
use screen::{OutputSettings, Screen, ScreenError, ScreenInfo};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use timing::{Nanos, Rate, Vblank};

/// The longest wait for one event of the screen: short enough to end within a second.
const QUIET: Duration = Duration::from_millis(250);
/// The longest wait for a frame while nothing is lit.
const PATIENCE: Duration = Duration::from_millis(50);

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

/// One run, from the first frame to the last.
pub(crate) struct Presenter<'a, F> {
    screen: Box<dyn Screen>,
    source: F,
    handles: PresenterHandles<'a>,
    format: StreamFormat,
    playback: Playback,
    /// How the screen is lit, and the pace on it; `None` until it was there for the first time.
    lit: Option<(Arc<ScreenInfo>, Pacing)>,
    /// The frame on the glass, and the one that follows it.
    shown: Option<Frame>,
    next: Option<Frame>,
    /// The flock of the frame that was staged last.
    flock: Option<Arc<Flock>>,
    /// The rate of those of another form that the screen was fitted to, and of which none is on the glass yet.
    fitted: Option<Rate>,
    /// The newest vblank that the screen told of, and that of the last flip.
    vblank: Vblank,
    flipped: Vblank,
    /// There was no new frame since that vblank.
    looked: bool,
    /// The vblank at which the screen was asked for an event.
    asked: Option<Vblank>,
    /// The screen is back and nothing was lit on it since.
    returned: bool,
    finished: bool,
    /// The frame that came ahead of the stream: it stays lit until the stream has more, and is not late meanwhile.
    first_frame: Option<Frame>,
    fed: Option<Nanos>,
    /// The brightness and the owner's settings that the screen has.
    lighting: Lighting,
    output: Option<Arc<OutputSettings>>,
    /// While the night is black.
    blackout: Option<Blackout>,
    tally: Tally,
    /// Memory for the picture under a notice.
    buffer: PaneBuffer,
    /// The acknowledgement that lies over what was staged last.
    mark: Option<u32>,
}

impl<'a, F: FrameSource> Presenter<'a, F> {
    /// A presenter that has not begun.
    pub(crate) fn new(screen: Box<dyn Screen>, source: F, format: StreamFormat, handles: PresenterHandles<'a>) -> Self {
        let mut presenter = Self {
            screen,
            source,
            handles,
            format,
            playback: Playback::Away(LastLit::Nothing),
            lit: None,
            shown: None,
            next: None,
            flock: None,
            fitted: None,
            vblank: Vblank(0),
            flipped: Vblank(0),
            looked: false,
            asked: None,
            returned: false,
            finished: false,
            first_frame: None,
            fed: None,
            lighting: Lighting::FULL,
            output: None,
            blackout: None,
            tally: Tally::default(),
            buffer: PaneBuffer::default(),
            mark: None,
        };
        presenter.back();
        if presenter.lit.is_some() {
            presenter.playback = Playback::Dark;
        }
        presenter
    }

    /// Plays until the source is finished or a signal stops it. Returns the place saver.
    /// Errors: [`ScreenError`], if the flock's pictures do not fit the screen.
    pub(crate) fn run(mut self) -> Result<(RunEnd, Option<PlaceSaver>), ScreenError> {
        while self.playback != Playback::Ended {
            if let Some(event) = self.observe()? {
                let (playback, effect) = self.playback.on(event);
                self.playback = playback;
                self.act(effect)?;
            }
        }
        let tally = if self.finished { self.tally } else { self.tally_now() };
        let scheduled = self.shown.and_then(|shown| shown.scheduled);
        Ok((RunEnd { scheduled, finished: self.finished, tally }, self.handles.saver))
    }

    /// Waits until something happens; `None` if that changes nothing.
    fn observe(&mut self) -> Result<Option<Event>, ScreenError> {
        if self.handles.stop.load(Ordering::Relaxed) {
            return Ok(Some(Event::Stop));
        }
        if let Some(event) = self.go_by_the_owner()? {
            return Ok(Some(event));
        }
        if self.blackout.is_some() {
            return self.stay_black().map(|()| None);
        }
        Ok(match self.playback {
            Playback::Dark => self.look(PATIENCE).or_else(|| self.listen(Duration::ZERO)),
            Playback::Lit(Next::Missing) | Playback::Holding if self.format.free => self.look(PATIENCE),
            Playback::Lit(Next::Missing) | Playback::Holding if !self.looked => {
                self.looked = true;
                self.look(Duration::ZERO).or_else(|| self.watch())
            }
            Playback::Lit(_) | Playback::Holding => self.watch(),
            Playback::Rising | Playback::Flying | Playback::Relighting | Playback::Away(_) => self.listen(QUIET),
            Playback::Ended => None,
        })
    }

    /// Asks the source for the next frame.
    fn look(&mut self, patience: Duration) -> Option<Event> {
        if self.next.is_some() {
            return Some(Event::Ready);
        }
        match self.source.next(patience) {
            NextFrame::First(_) if self.shown.is_some() => None,
            NextFrame::First(frame) => {
                self.first_frame = Some(frame.clone());
                self.next = Some(frame);
                Some(Event::Ready)
            }
            NextFrame::Frame(frame) if self.first_frame.as_ref().is_some_and(|first_frame| first_frame.is(&frame)) => {
                self.look(patience)
            }
            NextFrame::Frame(frame) => {
                self.next = Some(frame);
                Some(Event::Ready)
            }
            NextFrame::Nothing => None,
            NextFrame::Barren => Some(Event::Barren),
            NextFrame::Finished => {
                self.finished = true;
                Some(Event::Finished)
            }
        }
    }

    /// Waits until the time of the lit frame is over.
    fn watch(&mut self) -> Option<Event> {
        if self.asked.is_some() {
            return self.listen(QUIET);
        }
        let last_vblank_before_due = self.last_vblank_before_due()?;
        if last_vblank_before_due.since(self.vblank) > 0 {
            self.ask();
            return None;
        }
        let second = self.lit.as_ref().map_or(1, |(lit, _)| lit.refresh.num().div_ceil(lit.refresh.den()));
        let held = self.vblank.since(self.flipped);
        let is_stale = self.playback == Playback::Holding && held >= second.cast_signed();
        Some(if is_stale { Event::Stale } else { Event::Due })
    }

    /// Waits for an event of the screen.
    fn listen(&mut self, patience: Duration) -> Option<Event> {
        match self.screen.next_event(patience) {
            screen::Event::Flip { vblank, at } => self.arrived(vblank, at),
            screen::Event::Vblank { vblank, .. } => {
                self.vblank = vblank;
                (self.looked, self.asked) = (false, None);
                if self.playback == Playback::Holding {
                    self.handles.view.counted(self.tally_now());
                }
                None
            }
            screen::Event::Lost { reason } => {
                self.handles.faults.tell(Kind::Screen, reason);
                self.handles.view.lit(None);
                self.asked = None;
                self.settle();
                Some(Event::Lost)
            }
            // A night is no fault; in all else it is as if the screen were gone.
            screen::Event::Asleep => {
                self.handles.view.lit(None);
                self.asked = None;
                self.settle();
                Some(Event::Lost)
            }
            screen::Event::Back => {
                self.back();
                Some(Event::Back)
            }
            screen::Event::Recovered { reason } => {
                self.handles.faults.tell(Kind::Screen, reason);
                (self.looked, self.asked) = (false, None);
                Some(Event::Recovered)
            }
            screen::Event::Changed => {
                self.fitted.get_or_insert(self.format.fps);
                None
            }
            screen::Event::Idle => {
                self.asked = None;
                self.stay_alive(&screen::Event::Idle);
                None
            }
        }
    }

    fn last_vblank_before_due(&self) -> Option<Vblank> {
        self.lit.as_ref().and_then(|(_, pacing)| pacing.last_vblank_before_due())
    }

    /// Asks the screen for an event at the lit frame's last vblank, or at the next one if that is past.
    fn ask(&mut self) {
        let Some(last_vblank_before_due) = self.last_vblank_before_due() else { return };
        let awaited = if last_vblank_before_due.since(self.vblank) > 0 {
            last_vblank_before_due
        } else if self.playback == Playback::Holding {
            self.vblank.after(1)
        } else {
            return; // Its last vblank has begun: the next frame may go at once.
        };
        self.screen.notify_at(awaited);
        self.asked = Some(awaited);
    }

    /// The screen is there: again, or for the first time.
    fn back(&mut self) {
        let Some(lit) = self.screen.info().map(Arc::new) else { return };
        self.handles.view.lit(Some(&lit));
        if self.lit.as_ref().is_none_or(|(known, _)| *known != lit) {
            self.handles.recorder.record(Record::Start { lit: Arc::clone(&lit), fps: self.format.fps });
        }
        if let Some((known, pacing)) = &mut self.lit {
            pacing.set_refresh(lit.refresh);
            *known = lit;
            self.returned = true;
        } else {
            let pacing = Pacing::new(self.format.fps, lit.refresh);
            self.lit = Some((lit, pacing));
        }
    }

    /// What was committed is on the glass.
    fn arrived(&mut self, vblank: Vblank, at: Nanos) -> Option<Event> {
        let is_new = match self.playback {
            Playback::Rising | Playback::Flying => true,
            Playback::Relighting => false,
            Playback::Dark | Playback::Lit(_) | Playback::Holding | Playback::Away(_) | Playback::Ended => {
                return None;
            }
        };
        (self.vblank, self.flipped) = (vblank, vblank);
        (self.looked, self.asked) = (false, None);
        if let Some(fps) = self.fitted.take_if(|_| is_new) {
            self.goes_on(vblank, fps);
        }
        let late = self.count(vblank, is_new);
        let shown = self.shown.as_ref()?;
        let (clip, frame, hash) = (shown.scheduled.clone(), shown.in_clip, shown.hash);
        self.handles.recorder.record(Record::Flip { clip, frame, vblank, at, late, hash, mark: self.mark });
        self.handles.view.flipped(shown, self.tally_now(), at);
        self.feed(at);
        Some(Event::Flipped)
    }

    /// Counts a flip, and goes on to the next frame if it brought that; returns how late it was.
    fn count(&mut self, vblank: Vblank, is_new: bool) -> u32 {
        self.tally.flips += 1;
        let pacing = self.lit.as_mut().map(|(_, pacing)| pacing);
        if !is_new {
            self.tally.repeated += 1;
            if let (Some(pacing), true) = (pacing, self.returned) {
                pacing.resumed(vblank);
            }
            self.returned = false;
            return 0;
        }
        self.returned = false;
        let late = pacing.map_or(0, |pacing| pacing.flipped(vblank));
        let before = self.shown.take();
        let late = if before.is_some() && self.first_frame.take().is_some() { 0 } else { late };
        self.tally.late += u64::from(late);
        self.shown = self.next.take();
        self.join(before.as_ref());
        late
    }

    /// The counters, with the frame that is awaited now as late as it is.
    fn tally_now(&self) -> Tally {
        let pacing = self.lit.as_ref().filter(|_| self.first_frame.is_none());
        let overdue = pacing.map_or(0, |(_, pacing)| pacing.overdue(self.vblank));
        Tally { late: self.tally.late + u64::from(overdue), ..self.tally }
    }

    /// The screen is gone: the awaited frame was late until now, and is not from here on.
    fn settle(&mut self) {
        self.tally = self.tally_now();
        if let Some((_, pacing)) = self.lit.as_mut().filter(|(_, pacing)| pacing.overdue(self.vblank) > 0) {
            pacing.resumed(self.vblank);
        }
    }

    /// Records a join, if `before` was a frame of another clip than the one that is lit now, and has its place saved.
    fn join(&mut self, before: Option<&Frame>) {
        let Some((shown, to)) = self.shown.as_ref().and_then(|shown| Some((shown, shown.scheduled.as_ref()?))) else {
            return;
        };
        let from = before.and_then(|before| Some((before.index, before.scheduled.as_ref()?)));
        self.tally.skipped += from.map_or(0, |(index, _)| shown.index.saturating_sub(index + 1));
        if from.is_some_and(|(_, from)| from.number == to.number) {
            return;
        }
        if let Some(saver) = &self.handles.saver {
            saver.save(to);
        }
        if let Some((_, from)) = from {
            self.tally.joins += 1;
            self.handles.recorder.record(Record::Join { from: Arc::clone(from), to: Arc::clone(to) });
        }
    }

    /// Feeds the watchdog after a completed flip, as often as it needs.
    fn feed(&mut self, at: Nanos) {
        let Some(fed) = self.fed else {
            self.fed = Some(at);
            self.handles.gate.open();
            return self.handles.recorder.record(Record::Ready);
        };
        if self.handles.watchdog.is_some_and(|often| u128::from(at.since(fed)) >= often.as_nanos()) {
            self.fed = Some(at);
            self.handles.recorder.record(Record::Alive);
        }
    }

    /// Fits the screen to the next frame, where that is of a flock of another size or rate.
    fn fit(&mut self) {
        let Some(scheduled) = self.next.as_ref().and_then(|next| next.scheduled.as_ref()) else { return };
        let form = |flock: &Flock| (flock.manifest().size, flock.manifest().fps);
        let before = self.flock.replace(Arc::clone(&scheduled.flock));
        let (size, fps) = form(&scheduled.flock);
        if before.is_some_and(|before| form(&before) != (size, fps)) {
            self.format.size = size;
            self.screen.set_format(size, fps);
            self.fitted = Some(fps);
        }
    }

    /// The first frame of another form is on the glass: it came in its time, unless a mode had to be set for it.
    fn goes_on(&mut self, vblank: Vblank, fps: Rate) {
        self.format.fps = fps;
        let Some((lit, (known, pacing))) = self.screen.info().map(Arc::new).zip(self.lit.as_mut()) else { return };
        if known.mode != lit.mode {
            pacing.resumed(vblank);
        }
        pacing.goes_on(fps, lit.refresh);
        *known = Arc::clone(&lit);
        self.handles.view.lit(Some(&lit));
        self.handles.recorder.record(Record::Start { lit, fps });
    }

    fn stage_next(&mut self) -> Result<(), ScreenError> {
        self.fit();
        self.mark = stage(&mut *self.screen, self.next.as_ref(), self.handles.overlay, &mut self.buffer)?;
        Ok(())
    }

    fn act(&mut self, effect: Effect) -> Result<(), ScreenError> {
        match effect {
            Effect::Wait | Effect::End => {}
            Effect::Stage => self.stage_next()?,
            Effect::Commit => self.screen.commit(),
            Effect::Light => {
                self.stage_next()?;
                self.screen.commit();
            }
            Effect::Relight => {
                self.mark = stage(&mut *self.screen, self.shown.as_ref(), self.handles.overlay, &mut self.buffer)?;
                self.screen.commit();
            }
            Effect::LightFaultCard => {
                let pixels = Pixels::Drawn(Arc::new(FaultCard::draw(self.format.size)));
                self.next = Some(Frame { pixels, scheduled: None, in_clip: 0, index: 0, hash: None });
                self.stage_next()?;
                self.screen.commit();
            }
            Effect::AwaitDue => self.ask(),
        }
        Ok(())
    }
}

/// Stages what is shown, with what lies over it; returns which acknowledgement that is.
fn stage(
    screen: &mut dyn Screen,
    shown: Option<&Frame>,
    overlay: &Overlay,
    buffer: &mut PaneBuffer,
) -> Result<Option<u32>, ScreenError> {
    let Some(shown) = shown else { return Ok(None) };
    let (picture, panes) = (shown.pixels.picture(), overlay.get());
    screen.stage(&panes.over(&picture, buffer))?;
    Ok(panes.mark())
}

#[cfg(test)]
mod tests;
