//! The presenter on a fake screen, its vblanks driven by hand.
//!
//! Owns the fake screen and the fake source. Nothing here waits: a vblank begins when the presenter asks for it.

use super::display::Brightness;
use super::{FrameSource, NextFrame, Presenter, PresenterHandles, RunEnd, StreamFormat};
use crate::control::{DisplayTarget, Overlay, Pane};
use crate::pipeline::start_gate::StartGate;
use crate::recording::{Faults, PlaceSaver, PlaceStore, Record, Recorder, SharedView, Tally};
use crate::stream::ScheduledClip;
use crate::stream::scheduled_clip::tests::{frames, scheduled_clips};
use screen::{DimmedBy, Event, Light, OutputSettings, Picture, Screen, ScreenError, ScreenInfo};
use settings::hours::Lighting;
use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use timing::{Nanos, Rate, Vblank};

const HZ: u64 = 60;

/// What a fake screen and a fake source share: the vblank that has begun.
type Now = Rc<Cell<u32>>;
/// What was on the glass: since which vblank, and how bright.
type Glow = Rc<RefCell<Vec<(u32, u8)>>>;

struct FakeScreen {
    now: Now,
    glow: Glow,
    /// How bright the screen was at each of these flips.
    beam: Rc<RefCell<Vec<u16>>>,
    light: u16,
    is_lit: bool,
    staged: Option<u8>,
    /// The vblank at which the commit arrives.
    flip: Option<u32>,
    asked: Option<u32>,
    /// What goes wrong, and at which vblank.
    incidents: VecDeque<(u32, Event)>,
    /// When someone wants the run to end, and how he says so.
    stop: Option<(u32, Arc<AtomicBool>)>,
}

impl FakeScreen {
    fn happen(&mut self, incident: Event) -> Event {
        (self.flip, self.asked) = (None, None);
        self.is_lit = !matches!(incident, Event::Lost { .. } | Event::Asleep);
        incident
    }
}

impl Screen for FakeScreen {
    fn info(&self) -> Option<ScreenInfo> {
        self.is_lit.then(|| ScreenInfo {
            screen: "fake".to_owned(),
            mode: format!("16x16@{HZ}"),
            size: (16, 16),
            format: "YU12".to_owned(),
            refresh: Rate::new(HZ, 1).unwrap(),
            notes: Vec::new(),
            dimmed_by: DimmedBy::Samples,
            connector: None,
        })
    }

    fn stage(&mut self, picture: &Picture<'_>) -> Result<(), ScreenError> {
        self.staged = self.is_lit.then_some(picture.planes[0][0]);
        Ok(())
    }

    fn commit(&mut self) {
        assert!(self.flip.is_none(), "one commit in flight");
        self.flip = self.is_lit.then_some(self.now.get() + 1);
    }

    fn set_format(&mut self, _: (u32, u32), _: Rate) {
        panic!("all pictures are of one form");
    }

    fn set_light(&mut self, light: Light) {
        let Light::On { thousandths } = light else { panic!("nobody has said that it is to be off") };
        self.light = thousandths;
    }

    fn set_output(&mut self, _: &OutputSettings) {}

    fn notify_at(&mut self, vblank: Vblank) {
        self.asked = Some(vblank.0.max(self.now.get()));
    }

    fn next_event(&mut self, timeout: Duration) -> Event {
        let incident = self.incidents.front().map(|(vblank, _)| *vblank);
        let next = [self.flip, self.asked, incident].into_iter().flatten().min();
        let Some(next) = next.filter(|next| !timeout.is_zero() || *next <= self.now.get()) else { return Event::Idle };
        self.now.set(next.max(self.now.get()));
        if let Some((_, stop)) = self.stop.as_ref().filter(|(vblank, _)| *vblank <= next) {
            stop.store(true, Ordering::Relaxed);
        }
        if incident == Some(next) {
            let (_, incident) = self.incidents.pop_front().expect("it is there");
            return self.happen(incident);
        }
        let (vblank, at) = (Vblank(next), Nanos(u64::from(next) * 1_000_000_000 / HZ));
        if self.flip == Some(next) {
            self.flip = None;
            self.beam.borrow_mut().push(self.light);
            self.glow.borrow_mut().push((next, self.staged.take().expect("something was staged")));
            return Event::Flip { vblank, at };
        }
        self.asked = None;
        Event::Vblank { vblank, at }
    }
}

/// Gives things, each from a certain vblank on.
struct FakeSource {
    now: Now,
    things: VecDeque<(u32, NextFrame)>,
}

impl FrameSource for FakeSource {
    fn next(&mut self, patience: Duration) -> NextFrame {
        match self.things.pop_front_if(|(vblank, _)| *vblank <= self.now.get()) {
            Some((_, given)) => given,
            None if self.things.is_empty() => NextFrame::Finished,
            None => {
                // Whoever waits without a vblank lets the time pass all the same.
                self.now.set(self.now.get() + u32::from(!patience.is_zero()));
                NextFrame::Nothing
            }
        }
    }
}

/// A run at a rate, with what its source gives and what goes wrong.
struct Evening {
    fps: (u64, u64),
    things: Vec<(u32, NextFrame)>,
    incidents: Vec<(u32, Event)>,
    /// The vblank from which on someone wants it to end.
    stop: Option<u32>,
    /// How bright it is to be, and what lies over it.
    thousandths: Option<u16>,
    notice: Option<Pane>,
}

/// What one saw and heard of it.
struct Memory {
    glow: Vec<(u32, u8)>,
    beam: Vec<u16>,
    records: Vec<Record>,
    ended: RunEnd,
    late_on_glass: u64,
    faults: u64,
}

impl Evening {
    /// Every frame lies ready from the start.
    fn of(fps: u64, scheduled_clips: &[Arc<ScheduledClip>]) -> Self {
        let things = frames(scheduled_clips).into_iter().map(|frame| (0, NextFrame::Frame(frame))).collect();
        Self { fps: (fps, 1), things, incidents: Vec::new(), stop: None, thousandths: None, notice: None }
    }

    /// Frame `index` and all after it are ready from `vblank` on.
    fn delayed(mut self, index: usize, vblank: u32) -> Self {
        self.things.iter_mut().skip(index).for_each(|(ready, _)| *ready = vblank);
        self
    }

    /// The first frame is given once more, ahead of the stream, before frame `index`.
    fn opened(mut self, index: usize) -> Self {
        let Some((_, NextFrame::Frame(first))) = self.things.first() else { panic!("no frame comes first") };
        let first_frame = NextFrame::First(first.clone());
        self.things.insert(index, (0, first_frame));
        self
    }

    fn with(mut self, vblank: u32, incident: Event) -> Self {
        self.incidents.push((vblank, incident));
        self
    }

    fn stopped_at(mut self, vblank: u32) -> Self {
        self.stop = Some(vblank);
        self
    }

    fn watch(self) -> Memory {
        self.watch_with(None)
    }

    fn watch_with(self, saver: Option<PlaceSaver>) -> Memory {
        let beam = Rc::default();
        let (now, glow, stop) = (Now::default(), Glow::default(), Arc::new(AtomicBool::new(self.stop == Some(0))));
        let screen = FakeScreen {
            now: Rc::clone(&now),
            glow: Rc::clone(&glow),
            beam: Rc::clone(&beam),
            light: 1000,
            is_lit: true,
            staged: None,
            flip: None,
            asked: None,
            incidents: self.incidents.into(),
            stop: self.stop.map(|vblank| (vblank, Arc::clone(&stop))),
        };
        let (recorder, queue) = Recorder::for_tests();
        let (faults, view, overlay) = (Faults::new(|_| ()), SharedView::default(), Overlay::default());
        let (target, gate) = (DisplayTarget::default(), StartGate::default());
        overlay.set_notice(self.notice.map(Arc::new));
        if let Some(thousandths) = self.thousandths {
            target.set(Lighting::On { thousandths }, &Arc::default());
        }
        let watchdog = Some(Duration::from_millis(500));
        let (view, stop) = (&view, &*stop);
        let handles = PresenterHandles {
            recorder,
            faults: faults.clone(),
            saver,
            view,
            overlay: &overlay,
            target: &target,
            gate: &gate,
            stop,
            watchdog,
        };
        let format = StreamFormat { fps: Rate::new(self.fps.0, self.fps.1).unwrap(), size: (16, 16), free: false };
        let source = FakeSource { now, things: self.things.into() };
        let (ended, saver) = Presenter::new(Box::new(screen), source, format, handles).run().unwrap();
        if let Some(saver) = saver {
            saver.end();
        }
        let late_on_glass = view.get().tally.late;
        let beam = beam.take();
        Memory {
            glow: glow.take(),
            beam,
            records: queue.try_iter().collect(),
            ended,
            late_on_glass,
            faults: faults.count(),
        }
    }
}

impl Memory {
    fn vblanks(&self) -> Vec<u32> {
        self.glow.iter().map(|(vblank, _)| *vblank).collect()
    }

    fn lights(&self) -> Vec<u8> {
        self.glow.iter().map(|(_, light)| *light).collect()
    }

    fn lates(&self) -> Vec<u32> {
        let late = |record: &Record| if let Record::Flip { late, .. } = record { Some(*late) } else { None };
        self.records.iter().filter_map(late).collect()
    }
}

#[test]
fn a_notice_is_fully_lit_on_a_dimmed_screen_and_the_frames_under_it_are_as_dim_as_before() {
    let dimmed = |notice| Evening { thousandths: Some(400), notice, ..Evening::of(30, &scheduled_clips(1, 3)) }.watch();
    let without = dimmed(None);
    assert_eq!((without.lights(), without.beam), (vec![1, 2, 3], vec![400; 3]));
    // The corner that the fake screen sees lies beside the pane: frames of 1 to 3 are 15 to 13 below black.
    let pane = Pane { picture: (16, 16), at: (8, 8), size: (4, 4), luma: vec![190; 16] };
    let with = dimmed(Some(pane));
    assert_eq!((with.lights(), with.beam), (vec![10, 10, 11], vec![1000; 3]));
    let over = |dimmed_by| Brightness::of(400, dimmed_by);
    assert_eq!(over(DimmedBy::Backlight), Brightness { display: 1000, samples: 659 }, "659 by the power 2.2 is 400");
    assert_eq!(over(DimmedBy::Nothing), Brightness { display: 400, samples: 1000 });
}

fn lost() -> Event {
    Event::Lost { reason: "unplugged".to_owned() }
}

#[test]
fn last_frame_stays_lit_when_the_successor_is_late() {
    let seen = Evening::of(30, &scheduled_clips(1, 5)).delayed(2, 20).watch();
    assert_eq!(seen.glow, [(1, 1), (3, 2), (21, 3), (23, 4), (25, 5)]);
    assert_eq!(seen.lates(), [0, 0, 16, 0, 0]);
    assert_eq!(seen.ended.tally, Tally { flips: 5, late: 16, repeated: 0, skipped: 0, joins: 0 });
    assert!(seen.ended.finished);
}

#[test]
fn a_frame_that_never_comes_is_late_all_the_while() {
    // Frame 2 is due at vblank 5; the screen goes at 40, comes back, and the run is over at 300.
    let evening = Evening::of(30, &scheduled_clips(1, 3)).delayed(2, 1_000).with(40, lost()).with(100, Event::Back);
    let stopped = evening.stopped_at(300).watch();
    assert!(!stopped.ended.finished);
    let (late, shown) = (stopped.ended.tally.late, stopped.late_on_glass);
    // Until the cable was pulled, and again from the time of the frame that was lit anew on.
    let expected = (40 - 5)..=(40 - 5 + 1) + (300 - 103 + 1);
    assert!(expected.contains(&late) && late > 200, "{late}");
    assert!(late.abs_diff(shown) <= 1, "{late} in the end, {shown} on the page");
}

#[test]
fn an_opening_is_lit_at_once_and_the_stream_goes_on_from_it() {
    // The stream comes at vblank 20: it is taken up at once.
    for (stream, expected) in
        [(0, vec![1, 3, 5, 7]), (20, vec![1, 21, 23, 25]), (200, vec![1, 62, 123, 184, 201, 203, 205])]
    {
        let seen = Evening::of(30, &scheduled_clips(2, 2)).delayed(0, stream).opened(0).watch();
        assert_eq!(seen.vblanks(), expected, "a stream from vblank {stream} on");
        let repeated = expected.len() as u64 - 4;
        assert_eq!(seen.ended.tally, Tally { flips: 4 + repeated, late: 0, repeated, skipped: 0, joins: 1 });
        let mut told: Vec<_> = seen.records.iter().filter_map(told).filter(|told| told != "ready").collect();
        told.dedup();
        assert_eq!(told, ["start", "flip 0", "flip 1", "join 1-2", "flip 0", "flip 1"]);
        assert_eq!(seen.late_on_glass, 0);
    }
}

#[test]
fn an_opening_that_comes_after_the_stream_is_not_shown() {
    let seen = Evening::of(30, &scheduled_clips(1, 3)).opened(2).watch();
    assert_eq!(seen.glow, [(1, 1), (3, 2), (5, 3)]);
}

#[test]
fn an_opening_whose_clip_gives_no_more_stays_lit_until_another_clip_plays() {
    let scheduled_clips = scheduled_clips(2, 2);
    let mut evening = Evening::of(30, &scheduled_clips).delayed(0, 30);
    evening.things.drain(..2);
    let first_frame = frames(&scheduled_clips[..1]).swap_remove(0);
    evening.things.insert(0, (0, NextFrame::First(first_frame)));
    let seen = evening.watch();
    assert_eq!((seen.lights(), seen.ended.tally.late), (vec![1, 3, 4], 0));
}

#[test]
fn film_on_a_60_hz_screen_keeps_its_beat_across_joins() {
    let seen = Evening::of(24, &scheduled_clips(4, 3)).watch();
    assert_eq!(seen.vblanks(), [1, 3, 6, 8, 11, 13, 16, 18, 21, 23, 26, 28]);
    assert_eq!(seen.lights(), (1..=12).collect::<Vec<u8>>());
    assert_eq!(seen.ended.tally, Tally { flips: 12, late: 0, repeated: 0, skipped: 0, joins: 3 });
}

#[test]
fn a_flock_as_fast_as_the_screen_or_faster_is_shown_whole() {
    for fps in [60, 90] {
        let seen = Evening::of(fps, &scheduled_clips(2, 4)).watch();
        assert_eq!(seen.vblanks(), [1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(seen.ended.tally, Tally { flips: 8, late: 0, repeated: 0, skipped: 0, joins: 1 });
    }
}

#[test]
fn a_join_is_told_before_the_flip_that_makes_it() {
    let seen = Evening::of(30, &scheduled_clips(2, 2)).watch();
    let told: Vec<_> = seen.records.iter().filter_map(told).collect();
    assert_eq!(told, ["start", "flip 0", "ready", "flip 1", "join 1-2", "flip 0", "flip 1"]);
}

fn told(record: &Record) -> Option<String> {
    match record {
        Record::Start { .. } => Some("start".to_owned()),
        Record::Ready => Some("ready".to_owned()),
        Record::Flip { frame, .. } => Some(format!("flip {frame}")),
        Record::Join { from, to } => Some(format!("join {}-{}", from.number, to.number)),
        Record::Fault { .. } | Record::Alive | Record::End { .. } => None,
    }
}

#[test]
fn the_place_of_every_clip_on_the_glass_is_kept() {
    let dir = tempfile::tempdir().unwrap();
    let scheduled_clips = scheduled_clips(3, 2);
    for shown in 1..=scheduled_clips.len() {
        let (store, _) = PlaceStore::open(dir.path()).unwrap();
        let saver = PlaceSaver::start(Some(store), Faults::new(|_| ()), false).unwrap();
        Evening::of(30, &scheduled_clips[..shown]).watch_with(Some(saver));
        let (_, kept) = PlaceStore::open(dir.path()).unwrap();
        assert_eq!(kept, Some(scheduled_clips[shown - 1].place.to_bytes()));
    }
}

#[test]
fn an_unplugged_screen_gets_its_last_frame_back_and_nothing_is_skipped() {
    // Frame 3 is lit since vblank 5, frame 4 is staged when the cable is pulled.
    let seen = Evening::of(30, &scheduled_clips(2, 3)).with(6, lost()).with(500, Event::Back).watch();
    assert_eq!(seen.glow, [(1, 1), (3, 2), (5, 3), (501, 3), (503, 4), (505, 5), (507, 6)]);
    assert_eq!(seen.ended.tally, Tally { flips: 7, late: 0, repeated: 1, skipped: 0, joins: 1 });
}

#[test]
fn a_night_is_nobodys_fault_and_costs_no_frame() {
    for dusk in 1..9 {
        let seen = Evening::of(30, &scheduled_clips(2, 3)).with(dusk, Event::Asleep).with(5_000, Event::Back).watch();
        let mut lights = seen.lights();
        lights.dedup();
        assert_eq!(lights, [1, 2, 3, 4, 5, 6], "dusk at vblank {dusk}");
        assert_eq!((seen.ended.tally.late, seen.ended.tally.skipped), (0, 0));
        assert_eq!(seen.faults, 0, "dusk at vblank {dusk}");
    }
}

#[test]
fn a_cable_pulled_during_a_flip_loses_no_frame() {
    for (pulled, expected) in [(1, vec![1, 2, 3]), (3, vec![1, 1, 2, 3])] {
        let seen = Evening::of(30, &scheduled_clips(1, 3)).with(pulled, lost()).with(90, Event::Back).watch();
        assert_eq!(seen.lights(), expected, "pulled at vblank {pulled}");
        assert_eq!((seen.ended.tally.skipped, seen.ended.tally.late), (0, 0));
    }
}

#[test]
fn a_screen_that_repairs_itself_gets_its_frame_again() {
    for vblank in 1..8 {
        let recovered = Event::Recovered { reason: "a flip was lost".to_owned() };
        let seen = Evening::of(30, &scheduled_clips(1, 4)).with(vblank, recovered).watch();
        assert_eq!(seen.lights(), [1, 2, 3, 4], "at vblank {vblank}");
        assert_eq!(seen.faults, 1, "at vblank {vblank}");
    }
}

#[test]
fn a_repair_hides_no_vblank_from_the_count() {
    // Frame 2 is due at vblank 5 and comes at 20; the screen goes before it is lit.
    let evening = || Evening::of(30, &scheduled_clips(1, 3)).delayed(2, 20);
    let repaired = evening().with(20, Event::Recovered { reason: "a vblank was lost".to_owned() });
    for evening in [evening(), repaired] {
        let seen = evening.with(21, lost()).with(90, Event::Back).watch();
        assert_eq!((seen.lights(), seen.ended.tally.late), (vec![1, 2, 2, 3], 20 - 5 + 1));
    }
}

#[test]
fn a_frame_held_for_long_is_lit_again_once_a_second_so_that_the_watchdog_knows() {
    let seen = Evening::of(30, &scheduled_clips(1, 3)).delayed(1, 200).watch();
    assert_eq!(seen.lights(), [1, 1, 1, 1, 2, 3]);
    assert!(seen.vblanks().windows(2).all(|pair| pair[1] - pair[0] <= 61), "{:?}", seen.vblanks());
    assert_eq!(seen.ended.tally.repeated, 3);
    assert_eq!(seen.ended.tally.late, u64::from(seen.vblanks()[4]) - 3);
    assert!(seen.records.iter().filter(|record| matches!(record, Record::Alive)).count() >= 3);
}

#[test]
fn the_watchdog_hears_nothing_more_of_a_frame_that_is_held_for_minutes_until_another_is_lit() {
    let alive = |minutes: u32| {
        let evening = Evening::of(30, &scheduled_clips(1, 3));
        let seen = evening.delayed(1, minutes * 60 * 60).watch();
        seen.records.iter().filter(|record| matches!(record, Record::Alive)).count()
    };
    let [two, ten] = [2, 10].map(alive);
    assert!((115..=125).contains(&two), "{two}: once a second");
    assert!((two..=two + 3).contains(&ten), "{ten} in ten minutes, {two} in two");
    // The fault card waits for clips for ever.
    let mut card = Evening::of(30, &scheduled_clips(1, 2)).delayed(0, 5 * 60 * 60);
    card.things.insert(0, (0, NextFrame::Barren));
    let seen = card.watch();
    let alive = seen.records.iter().filter(|record| matches!(record, Record::Alive)).count();
    assert!(alive >= 295, "{alive}");
}

#[test]
fn a_flock_without_a_playable_clip_shows_the_fault_card_until_there_is_one() {
    let mut evening = Evening::of(30, &scheduled_clips(1, 2)).delayed(0, 30);
    evening.things.insert(0, (0, NextFrame::Barren));
    let seen = evening.watch();
    assert_eq!(seen.lights()[1..], [1, 2]);
    let cards = seen.records.iter().filter(|record| matches!(record, Record::Flip { clip: None, .. })).count();
    assert_eq!(cards, 1);
    assert_eq!(seen.ended.tally.joins, 0, "from the card to a clip is no join");
}

#[test]
fn a_show_that_is_told_to_stop_ends_where_it_is() {
    let seen = Evening::of(30, &scheduled_clips(1, 9)).stopped_at(0).watch();
    assert!(!seen.ended.finished);
    assert_eq!(seen.ended.tally.flips, 0);
}
