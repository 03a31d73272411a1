//! The flip thread: brings frames to the glass, each at its vblank.
//!
//! Owns the screen and the two frames that matter: the one that is lit and the one that follows. Never opens, reads
//! or writes a file, and takes no memory for a frame: only at joins, when a screen comes or is fitted, for the words about
//! a fault, for the fault card and for the first frame that bears a placard. What happens next is decided in
//! `playback.rs`, when in `pacing.rs`; frames come from `decoder.rs`; what happened goes to `recorder.rs`.
//!
//! Start at [`Show::run`].

mod display;

use crate::control::brightness::DisplayTarget;
use crate::control::notice_pane::{Overlaid, Overlay};
use crate::pipeline::black_picture::Blackout;
use crate::pipeline::frame_queue::{Given, Supply};
use crate::pipeline::pacing::Pace;
use crate::pipeline::playback::{Effect, Event, Kept, Next, Playback};
use crate::pipeline::start_gate::StartGate;
use crate::recording::faults::{Faults, Kind};
use crate::recording::place_saver::Saver;
use crate::recording::recorder::{Note, Scribe};
use crate::recording::tally::Tally;
use crate::recording::view::SharedView;
use crate::stream::fault_card::Card;
use crate::stream::format::StreamFormat;
use crate::stream::scheduled_clip::{Shown, Still, Turn};
use flock::Flock;
use player::hours::Lighting;
use screen::{Lit, OutputSettings, Screen, ScreenError};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use timing::{Nanos, Rate, Vblank};

/// How long the screen may say nothing before we look up: short enough to end within a second.
const QUIET: Duration = Duration::from_millis(250);
/// How long we wait for a frame where no vblank calls.
const PATIENCE: Duration = Duration::from_millis(50);

/// Where a show tells what happens, and hears when to end.
pub(crate) struct Ears<'a> {
    pub(crate) scribe: Scribe,
    pub(crate) faults: Faults,
    /// Gets every turn whose first frame is on the glass; `None` where places are not kept.
    pub(crate) saver: Option<Saver>,
    pub(crate) view: &'a SharedView,
    pub(crate) overlay: &'a Overlay,
    pub(crate) target: &'a DisplayTarget,
    pub(crate) gate: &'a StartGate,
    pub(crate) stop: &'a AtomicBool,
    /// How often the watchdog wants to hear of us.
    pub(crate) watchdog: Option<Duration>,
}

/// How a run ended.
#[derive(Debug)]
pub(crate) struct Ended {
    /// The turn that was on the glass last.
    pub(crate) turn: Option<Arc<Turn>>,
    /// Whether it had been shown to its end.
    pub(crate) finished: bool,
    /// The counters.
    pub(crate) tally: Tally,
}

/// One run, from the first frame to the last.
pub(crate) struct Show<'a, F> {
    screen: Box<dyn Screen>,
    supply: F,
    ears: Ears<'a>,
    piece: StreamFormat,
    playback: Playback,
    /// How the screen is lit, and the pace on it; `None` until it was there for the first time.
    lit: Option<(Arc<Lit>, Pace)>,
    /// The frame on the glass, and the one that follows it.
    shown: Option<Shown>,
    next: Option<Shown>,
    /// The flock of the frame that was staged last.
    flock: Option<Arc<Flock>>,
    /// The rate of those of another form that the screen was fitted to, and of which none is on the glass yet.
    fitted: Option<Rate>,
    /// The newest vblank that the screen told of, and that of the last flip.
    vblank: Vblank,
    flipped: Vblank,
    /// The supply was asked in vain since that vblank.
    looked: bool,
    /// The vblank to come that the screen was asked to tell of.
    asked: Option<Vblank>,
    /// The screen is back and nothing was lit on it since.
    returned: bool,
    finished: bool,
    /// The opening: it stays lit until the stream has more, and that is nobody's lateness.
    opening: Option<Shown>,
    fed: Option<Nanos>,
    /// What the screen was told of the light, and of its owner's settings.
    lighting: Lighting,
    output: Option<Arc<OutputSettings>>,
    /// While the night is black.
    blackout: Option<Blackout>,
    tally: Tally,
    /// The picture with what people are told.
    overlaid: Overlaid,
}

impl<'a, F: Supply> Show<'a, F> {
    /// A show that has not begun.
    pub(crate) fn new(screen: Box<dyn Screen>, supply: F, piece: StreamFormat, ears: Ears<'a>) -> Self {
        let mut show = Self {
            screen,
            supply,
            ears,
            piece,
            playback: Playback::Away(Kept::Nothing),
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
            opening: None,
            fed: None,
            lighting: Lighting::FULL,
            output: None,
            blackout: None,
            tally: Tally::default(),
            overlaid: Overlaid::default(),
        };
        show.back();
        if show.lit.is_some() {
            show.playback = Playback::Dark;
        }
        show
    }

    /// Plays until the supply is finished or someone wants it to stop. Gives the way to the saver back.
    ///
    /// # Errors
    /// [`ScreenError`], if the flock's pictures do not fit the screen.
    pub(crate) fn run(mut self) -> Result<(Ended, Option<Saver>), ScreenError> {
        while self.playback != Playback::Ended {
            if let Some(event) = self.observe()? {
                let (playback, effect) = self.playback.on(event);
                self.playback = playback;
                self.act(effect)?;
            }
        }
        let tally = if self.finished { self.tally } else { self.tally_now() };
        let turn = self.shown.and_then(|shown| shown.turn);
        Ok((Ended { turn, finished: self.finished, tally }, self.ears.saver))
    }

    /// Waits until something happens; `None` if that changes nothing.
    fn observe(&mut self) -> Result<Option<Event>, ScreenError> {
        if self.ears.stop.load(Ordering::Relaxed) {
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
            Playback::Lit(Next::Missing) | Playback::Holding if self.piece.free => self.look(PATIENCE),
            Playback::Lit(Next::Missing) | Playback::Holding if !self.looked => {
                self.looked = true;
                self.look(Duration::ZERO).or_else(|| self.watch())
            }
            Playback::Lit(_) | Playback::Holding => self.watch(),
            Playback::Rising | Playback::Flying | Playback::Relighting | Playback::Away(_) => self.listen(QUIET),
            Playback::Ended => None,
        })
    }

    /// Looks for the next frame.
    fn look(&mut self, patience: Duration) -> Option<Event> {
        if self.next.is_some() {
            return Some(Event::Ready);
        }
        match self.supply.next(patience) {
            Given::Opening(_) if self.shown.is_some() => None,
            Given::Opening(frame) => {
                self.opening = Some(frame.clone());
                self.next = Some(frame);
                Some(Event::Ready)
            }
            Given::Frame(frame) if self.opening.as_ref().is_some_and(|opening| opening.is(&frame)) => {
                self.look(patience)
            }
            Given::Frame(frame) => {
                self.next = Some(frame);
                Some(Event::Ready)
            }
            Given::Nothing => None,
            Given::Barren => Some(Event::Barren),
            Given::Finished => {
                self.finished = true;
                Some(Event::Finished)
            }
        }
    }

    /// Waits for the time of the lit frame to be over.
    fn watch(&mut self) -> Option<Event> {
        if self.asked.is_some() {
            return self.listen(QUIET);
        }
        let eve = self.eve()?;
        if eve.since(self.vblank) > 0 {
            self.ask();
            return None;
        }
        let second = self.lit.as_ref().map_or(1, |(lit, _)| lit.refresh.num().div_ceil(lit.refresh.den()));
        let held = self.vblank.since(self.flipped);
        let is_stale = self.playback == Playback::Holding && held >= second.cast_signed();
        Some(if is_stale { Event::Stale } else { Event::Due })
    }

    /// Waits for the screen to tell something.
    fn listen(&mut self, patience: Duration) -> Option<Event> {
        match self.screen.next_event(patience) {
            screen::Event::Flip { vblank, at } => self.arrived(vblank, at),
            screen::Event::Vblank { vblank, .. } => {
                self.vblank = vblank;
                (self.looked, self.asked) = (false, None);
                if self.playback == Playback::Holding {
                    self.ears.view.counted(self.tally_now());
                }
                None
            }
            screen::Event::Lost { reason } => {
                self.ears.faults.tell(Kind::Screen, reason);
                self.ears.view.lit(None);
                self.asked = None;
                self.settle();
                Some(Event::Lost)
            }
            // The night is nobody's fault; for all else it is as if the screen were gone.
            screen::Event::Asleep => {
                self.ears.view.lit(None);
                self.asked = None;
                self.settle();
                Some(Event::Lost)
            }
            screen::Event::Back => {
                self.back();
                Some(Event::Back)
            }
            screen::Event::Recovered { reason } => {
                self.ears.faults.tell(Kind::Screen, reason);
                (self.looked, self.asked) = (false, None);
                Some(Event::Recovered)
            }
            screen::Event::Changed => {
                self.fitted.get_or_insert(self.piece.fps);
                None
            }
            screen::Event::Idle => {
                self.asked = None;
                self.stay_alive(&screen::Event::Idle);
                None
            }
        }
    }

    fn eve(&self) -> Option<Vblank> {
        self.lit.as_ref().and_then(|(_, pace)| pace.eve())
    }

    /// Asks the screen to tell of the lit frame's last vblank, or of the next one if that is past.
    fn ask(&mut self) {
        let Some(eve) = self.eve() else { return };
        let awaited = if eve.since(self.vblank) > 0 {
            eve
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
        let Some(lit) = self.screen.lit().map(Arc::new) else { return };
        self.ears.view.lit(Some(&lit));
        if self.lit.as_ref().is_none_or(|(known, _)| *known != lit) {
            self.ears.scribe.note(Note::Start { lit: Arc::clone(&lit), fps: self.piece.fps });
        }
        if let Some((known, pace)) = &mut self.lit {
            pace.moved_to(lit.refresh);
            *known = lit;
            self.returned = true;
        } else {
            let pace = Pace::new(self.piece.fps, lit.refresh);
            self.lit = Some((lit, pace));
        }
    }

    /// What was committed is on the glass.
    fn arrived(&mut self, vblank: Vblank, at: Nanos) -> Option<Event> {
        let is_new = match self.playback {
            Playback::Rising | Playback::Flying => true,
            Playback::Relighting => false,
            Playback::Dark | Playback::Lit(_) | Playback::Holding | Playback::Away(_) | Playback::Ended => return None,
        };
        (self.vblank, self.flipped) = (vblank, vblank);
        (self.looked, self.asked) = (false, None);
        if let Some(fps) = self.fitted.take_if(|_| is_new) {
            self.goes_on(vblank, fps);
        }
        let late = self.count(vblank, is_new);
        let shown = self.shown.as_ref()?;
        let turn = shown.turn.clone();
        self.ears.scribe.note(Note::Flip { turn, frame: shown.frame, vblank, at, late, hash: shown.hash });
        self.ears.view.flipped(shown, self.tally_now());
        self.feed(at);
        Some(Event::Flipped)
    }

    /// Counts a flip and turns the page if it brought a new frame; returns how late that was.
    fn count(&mut self, vblank: Vblank, is_new: bool) -> u32 {
        self.tally.flips += 1;
        let pace = self.lit.as_mut().map(|(_, pace)| pace);
        if !is_new {
            self.tally.repeated += 1;
            if let (Some(pace), true) = (pace, self.returned) {
                pace.resumed(vblank);
            }
            self.returned = false;
            return 0;
        }
        self.returned = false;
        let late = pace.map_or(0, |pace| pace.flipped(vblank));
        let before = self.shown.take();
        let late = if before.is_some() && self.opening.take().is_some() { 0 } else { late };
        self.tally.late += u64::from(late);
        self.shown = self.next.take();
        self.join(before.as_ref());
        late
    }

    /// The counters, with the frame that is awaited now as late as it is.
    fn tally_now(&self) -> Tally {
        let pace = self.lit.as_ref().filter(|_| self.opening.is_none());
        let overdue = pace.map_or(0, |(_, pace)| pace.overdue(self.vblank));
        Tally { late: self.tally.late + u64::from(overdue), ..self.tally }
    }

    /// The screen is gone: the awaited frame was late until now, and is not from here on.
    fn settle(&mut self) {
        self.tally = self.tally_now();
        if let Some((_, pace)) = self.lit.as_mut().filter(|(_, pace)| pace.overdue(self.vblank) > 0) {
            pace.resumed(self.vblank);
        }
    }

    /// Tells of a join, if `before` was another clip's frame than what is lit now, and has its place kept.
    fn join(&mut self, before: Option<&Shown>) {
        let Some((shown, to)) = self.shown.as_ref().and_then(|shown| Some((shown, shown.turn.as_ref()?))) else {
            return;
        };
        let from = before.and_then(|before| Some((before.index, before.turn.as_ref()?)));
        self.tally.skipped += from.map_or(0, |(index, _)| shown.index.saturating_sub(index + 1));
        if from.is_some_and(|(_, from)| from.number == to.number) {
            return;
        }
        if let Some(saver) = &self.ears.saver {
            saver.keep(to);
        }
        if let Some((_, from)) = from {
            self.tally.joins += 1;
            self.ears.scribe.note(Note::Join { from: Arc::clone(from), to: Arc::clone(to) });
        }
    }

    /// Lets the watchdog know of a completed flip, as often as it wants to hear.
    fn feed(&mut self, at: Nanos) {
        let Some(fed) = self.fed else {
            self.fed = Some(at);
            self.ears.gate.open();
            return self.ears.scribe.note(Note::Ready);
        };
        if self.ears.watchdog.is_some_and(|often| u128::from(at.since(fed)) >= often.as_nanos()) {
            self.fed = Some(at);
            self.ears.scribe.note(Note::Alive);
        }
    }

    /// Fits the screen to the next frame, where that is of a flock of another size or rate.
    fn fit(&mut self) {
        let Some(turn) = self.next.as_ref().and_then(|next| next.turn.as_ref()) else { return };
        let form = |flock: &Flock| (flock.manifest().size, flock.manifest().fps);
        let before = self.flock.replace(Arc::clone(&turn.flock));
        let (size, fps) = form(&turn.flock);
        if before.is_some_and(|before| form(&before) != (size, fps)) {
            self.piece.size = size;
            self.screen.fit(size, fps);
            self.fitted = Some(fps);
        }
    }

    /// The first frame of another form is on the glass: it came in its time, unless a mode had to be set for it.
    fn goes_on(&mut self, vblank: Vblank, fps: Rate) {
        self.piece.fps = fps;
        let Some((lit, (known, pace))) = self.screen.lit().map(Arc::new).zip(self.lit.as_mut()) else { return };
        if known.mode != lit.mode {
            pace.resumed(vblank);
        }
        pace.goes_on(fps, lit.refresh);
        *known = Arc::clone(&lit);
        self.ears.view.lit(Some(&lit));
        self.ears.scribe.note(Note::Start { lit, fps });
    }

    fn stage_next(&mut self) -> Result<(), ScreenError> {
        self.fit();
        stage(&mut *self.screen, self.next.as_ref(), self.ears.overlay, &mut self.overlaid)
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
                stage(&mut *self.screen, self.shown.as_ref(), self.ears.overlay, &mut self.overlaid)?;
                self.screen.commit();
            }
            Effect::LightCard => {
                let still = Still::Drawn(Arc::new(Card::draw(self.piece.size)));
                self.next = Some(Shown { still, turn: None, frame: 0, index: 0, hash: None });
                self.stage_next()?;
                self.screen.commit();
            }
            Effect::AwaitDue => self.ask(),
        }
        Ok(())
    }
}

/// Stages what is shown, with what people are told over it.
fn stage(
    screen: &mut dyn Screen,
    shown: Option<&Shown>,
    overlay: &Overlay,
    overlaid: &mut Overlaid,
) -> Result<(), ScreenError> {
    let Some(shown) = shown else { return Ok(()) };
    let picture = shown.still.picture();
    match overlay.get() {
        Some(placard) => screen.stage(&placard.over(&picture, overlaid)),
        None => screen.stage(&picture),
    }
}

#[cfg(test)]
mod tests;
