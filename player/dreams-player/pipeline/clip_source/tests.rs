//! The clip source on small flocks, encoded on the spot and then spoiled.
//!
//! Owns the claims on what happens when a clip is bad, and on where a path begins.

use super::{ClipSource, Strikes, Successor, retry_on_shortage};
use crate::pipeline::decoder::{ClipEnd, Order};
use crate::pipeline::grey_clip::{SIZE, encode};
use crate::pipeline::start_gate::StartGate;
use crate::recording::{Fault, Faults, SharedView};
use crate::stream::{Generation, Plan, ScheduledClip, path};
use flock::{ClipHash, ClipPath, Flock, Itinerary, Manifest};
use std::cell::{Cell, RefCell};
use std::fmt::Write;
use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel, sync_channel};
use std::time::Duration;
use tempfile::TempDir;
use timing::{FrameCount, Nanos};
use video::Form;

/// The clock of all libraries here: by hand.
static CLOCK: AtomicU64 = AtomicU64::new(0);

const SHEEP: [&str; 3] = ["a", "b", "c"];

/// A folder with three sheep, every one with a way to every other; each clip has two frames.
fn folder(is_hashed: bool) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut text = format!("format = 1\nname = \"three\"\nsize = [{}, {}]\nfps = [30, 1]\n", SIZE.0, SIZE.1);
    for from in SHEEP {
        for to in SHEEP {
            let (clip, head) = if from == to {
                (format!("{from}.mp4"), format!("[[sheep]]\nid = \"{from}\""))
            } else {
                (format!("{from}={to}.mp4"), format!("[[transition]]\nfrom = \"{from}\"\nto = \"{to}\""))
            };
            let path = folder.path().join(&clip);
            encode(&path);
            writeln!(text, "{head}\nframes = 2\nclip = \"{clip}\"").unwrap();
            if is_hashed {
                writeln!(text, "hash = \"{}\"", ClipHash::of(File::open(path).unwrap()).unwrap()).unwrap();
            }
        }
    }
    fs::write(folder.path().join("flock.toml"), text).unwrap();
    folder
}

fn flock(folder: &Path) -> Arc<Flock> {
    Arc::new(Flock::new(Manifest::read(folder).unwrap()))
}

/// A clip source at work: its orders, the way to tell it of bad clips, and the faults told.
struct Work {
    orders: Receiver<Order>,
    clip_ends: Sender<ClipEnd>,
    /// The last clip ordered.
    scheduled: RefCell<Option<Arc<ScheduledClip>>>,
    told: Receiver<Fault>,
    plan: Arc<Plan>,
}

fn work(folder: &Path, clips: Option<u64>) -> Work {
    work_by(folder, clips, || Nanos(CLOCK.load(Ordering::Relaxed)))
}

/// The same by another clock.
fn work_by(folder: &Path, clips: Option<u64>, now: fn() -> Nanos) -> Work {
    let generation = Generation::open(folder).unwrap();
    let flock = Arc::clone(&generation.flock);
    let (tell, told) = channel();
    let plan = Arc::new(Plan::default());
    let clip_source = ClipSource {
        source: folder.to_owned(),
        spare: folder.join("spare"),
        generation,
        successor: Successor::default(),
        form: Form { size: SIZE, fps: flock.manifest().fps },
        is_reformed: false,
        itinerary: Itinerary::start(flock, 1),
        clips,
        faults: Faults::new(move |fault| tell.send(fault).unwrap_or_default()),
        plan: Arc::clone(&plan),
        view: Arc::new(SharedView::default()),
        gate: Arc::new(StartGate::default()),
        now,
        strikes: Strikes::default(),
        first_frame: None,
    };
    // Orders come one by one, so that a bad clip told between two of them is known for the second next.
    let (sender, orders) = sync_channel(0);
    let (clip_ends, ends) = channel();
    clip_source.open(sender, ends).unwrap();
    Work { orders, clip_ends, scheduled: RefCell::new(None), told, plan }
}

impl Work {
    /// The next clip ordered; `None` for nothing to play.
    fn next(&self) -> Option<String> {
        match self.orders.recv_timeout(Duration::from_secs(10)).unwrap() {
            Order::Play(_, scheduled) => {
                let clip = scheduled.clip.as_str().to_owned();
                self.scheduled.replace(Some(scheduled));
                Some(clip)
            }
            Order::Barren => None,
            Order::Rest => panic!("a rest"),
        }
    }

    /// The next clip, ended at once with `frames` frames.
    fn ended(&self, frames: u32, is_damaged: bool) -> Option<String> {
        let clip = self.next()?;
        self.end(frames, is_damaged);
        Some(clip)
    }

    /// The name of the flock of the next clip.
    fn next_flock(&self) -> String {
        self.next().expect("there is something to play");
        self.scheduled.borrow().as_ref().unwrap().flock.manifest().name.clone()
    }

    /// Reports the end of the last clip ordered.
    fn end(&self, frames: u32, is_damaged: bool) {
        let scheduled = self.scheduled.borrow_mut().take().unwrap();
        self.clip_ends.send(ClipEnd { scheduled, frames: FrameCount(frames), is_damaged }).unwrap();
    }

    /// Whether no more clips are ordered.
    fn is_over(&self) -> bool {
        while let Ok(order) = self.orders.recv_timeout(Duration::from_secs(10)) {
            if !matches!(order, Order::Rest) {
                return false;
            }
        }
        true
    }

    fn rests(&self) -> bool {
        matches!(self.orders.recv_timeout(Duration::from_secs(10)), Ok(Order::Rest))
    }

    fn faults(&self) -> Vec<(&'static str, String)> {
        self.told.try_iter().map(|fault| (fault.kind.name(), fault.message)).collect()
    }
}

#[test]
fn a_bad_clip_is_told_once_and_the_path_goes_on_around_it() {
    for (kind, bytes) in [("missing-clip", None), ("damaged-clip", Some("")), ("damaged-clip", Some("no video"))] {
        let folder = folder(false);
        let bad = folder.path().join("a=b.mp4");
        bytes.map_or_else(|| fs::remove_file(&bad), |bytes| fs::write(&bad, bytes)).unwrap();
        let work = work(folder.path(), Some(100));
        let played: Vec<_> = (0..100).map(|_| work.next().expect("there is always a way around")).collect();
        assert!(!played.contains(&"a=b.mp4".to_owned()), "{kind}");
        assert!(played.contains(&"a=c.mp4".to_owned()), "{kind}");
        let faults = work.faults();
        assert_eq!(faults.len(), 1, "{faults:?}");
        assert!(faults[0].0 == kind && faults[0].1.contains("a=b.mp4"), "{faults:?}");
    }
}

#[test]
fn where_nothing_can_be_played_the_spare_flock_is_until_it_is_time_to_try_again() {
    static LATER: AtomicU64 = AtomicU64::new(0);
    let minutes = |count: u64| LATER.fetch_add(count * 60_000_000_000, Ordering::Relaxed);
    let (own, spare) = (folder(false), folder(false));
    let text = fs::read_to_string(spare.path().join("flock.toml")).unwrap();
    fs::write(spare.path().join("flock.toml"), text.replace("three", "spare")).unwrap();
    fs::rename(spare.path(), own.path().join("spare")).unwrap();
    let clips: Vec<_> = fs::read_dir(own.path()).unwrap().map(|entry| entry.unwrap().path()).collect();
    let clips = || clips.iter().filter(|path| path.extension().is_some_and(|extension| extension == "mp4"));
    clips().for_each(|clip| fs::remove_file(clip).unwrap());
    let work = work_by(own.path(), None, || Nanos(LATER.load(Ordering::Relaxed)));
    assert!((0..20).all(|_| work.next_flock() == "spare"));
    minutes(10);
    assert!((0..20).all(|_| work.next_flock() == "spare"), "there is still nothing");
    for clip in clips() {
        fs::copy(own.path().join("spare").join(clip.file_name().unwrap()), clip).unwrap();
    }
    minutes(9);
    assert!((0..20).all(|_| work.next_flock() == "spare"), "it is not yet time");
    minutes(1);
    let flocks: Vec<_> = (0..20).map(|_| work.next_flock()).collect();
    // What was ordered before is still played.
    assert!(flocks[2..].iter().all(|flock| flock == "three"), "{flocks:?}");
}

#[test]
fn a_clip_with_other_bytes_than_the_manifests_is_not_played() {
    let folder = folder(true);
    let spoiled = folder.path().join("c.mp4");
    let mut bytes = fs::read(&spoiled).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&spoiled, bytes).unwrap();
    let work = work(folder.path(), Some(60));
    let played: Vec<_> = (0..60).map(|_| work.next().unwrap()).collect();
    // The first clip is only looked at once it plays: nothing is to delay the first picture.
    assert!(!played[1..].contains(&"c.mp4".to_owned()), "{played:?}");
    assert_eq!(work.faults().iter().map(|(kind, _)| *kind).collect::<Vec<_>>(), ["damaged-clip"]);
}

#[test]
fn without_a_way_out_the_loop_plays_again_and_without_a_loop_nothing_does() {
    let folder = folder(false);
    for clip in ["a=b.mp4", "a=c.mp4", "b=a.mp4", "b=c.mp4", "c=a.mp4", "c=b.mp4"] {
        fs::remove_file(folder.path().join(clip)).unwrap();
    }
    let looping = work(folder.path(), None);
    let played: Vec<_> = (0..5).map(|_| looping.next().unwrap()).collect();
    assert!(played.iter().all(|clip| *clip == played[0] && SHEEP.contains(&&clip[..1])), "{played:?}");
    drop(looping);
    for sheep in SHEEP {
        fs::remove_file(folder.path().join(format!("{sheep}.mp4"))).unwrap();
    }
    let barren = work(folder.path(), None);
    assert_eq!(barren.next(), None);
    let faults = barren.faults();
    assert_eq!(faults.iter().filter(|(kind, _)| *kind == "barren").count(), 1, "{faults:?}");
}

#[test]
fn a_clip_that_turned_out_bad_while_it_played_is_not_played_again() {
    let folder = folder(false);
    let work = work(folder.path(), None);
    let first = work.next().unwrap();
    work.end(2, true);
    // Two clips may be under way to us already.
    let later: Vec<_> = (0..60).map(|_| work.next().unwrap()).skip(2).collect();
    assert!(!later.contains(&first), "{later:?}");
}

#[test]
fn a_run_of_a_few_clips_leaves_the_place_behind_the_last_one() {
    let folder = folder(false);
    let work = work(folder.path(), Some(4));
    let played: Vec<_> = (0..4).map(|_| work.ended(2, false).unwrap()).collect();
    assert!(work.is_over(), "no fifth clip");
    let next = work.plan.after(4).expect("where the path goes on is planned");
    let mut again = Itinerary::start(flock(folder.path()), 1);
    let walk: Vec<_> = (0..5).map(|_| again.next_leg().unwrap().clip.path.as_str().to_owned()).collect();
    assert_eq!(played, walk[..4]);
    assert_eq!(next.clip.as_str(), walk[4]);
}

#[test]
fn clips_without_a_picture_do_not_count() {
    let folder = folder(false);
    let work = work(folder.path(), Some(4));
    let empty: Vec<_> = (0..3).map(|_| work.ended(0, true).unwrap()).collect();
    let mut shown: Vec<_> = (0..3).map(|_| work.ended(2, false).unwrap()).collect();
    // The seventh is under way when three of the six before have turned out empty, and is empty as well.
    let last = work.next().unwrap();
    assert!(work.rests(), "all clips are waited for, to know how many had pictures");
    work.end(0, true);
    shown.push(work.ended(2, false).unwrap());
    assert!(work.is_over(), "four clips had pictures");
    assert!(shown.iter().all(|clip| !empty[..1].contains(clip)), "{last} {empty:?} {shown:?}");
}

#[test]
fn a_moments_failure_of_the_only_way_out_does_not_leave_one_sheep_on_the_wall_for_ever() {
    let folder = folder(false);
    let exits = ["a=b.mp4", "a=c.mp4", "b=a.mp4", "b=c.mp4", "c=a.mp4", "c=b.mp4"];
    let moved = |clip: &str| folder.path().join(format!("{clip}.away"));
    for clip in exits {
        fs::rename(folder.path().join(clip), moved(clip)).unwrap();
    }
    let work = work(folder.path(), None);
    let first = work.next().unwrap();
    assert!((0..3).all(|_| work.next().unwrap() == first));
    for clip in exits {
        fs::rename(moved(clip), folder.path().join(clip)).unwrap();
    }
    assert!((0..3).all(|_| work.next().unwrap() == first), "not before the time");
    CLOCK.fetch_add(30_000_000_000, Ordering::Relaxed);
    assert!((0..3).any(|_| work.next().unwrap() != first));
}

#[test]
fn a_path_goes_on_where_it_was_left_unless_another_seed_is_asked_for() {
    let folder = folder(false);
    let flock = flock(folder.path());
    let clips = |mut itinerary: Itinerary| -> Vec<_> {
        (0..20).map(|_| itinerary.next_leg().unwrap().clip.path.as_str().to_owned()).collect()
    };
    let mut walked = path(&flock, None, Some(7));
    let place = (0..9).map(|_| walked.next_leg().unwrap()).last().unwrap().place;
    let left = clips(path(&flock, Some(place.clone()), None));
    assert_eq!(clips(path(&flock, Some(place.clone()), Some(7))), left);
    assert_eq!(left[1..], clips(walked)[..19]);
    assert_eq!(clips(path(&flock, Some(place), Some(8))), clips(path(&flock, None, Some(8))));
    assert_ne!(clips(path(&flock, None, None)), clips(path(&flock, None, None)));
}

#[test]
fn a_machine_short_of_something_is_waited_for_and_not_for_ever() {
    let (tell, told) = channel();
    let faults = Faults::new(move |fault: Fault| tell.send(fault).unwrap_or_default());
    let clip = ClipPath::new("loops/a.mp4").unwrap();
    let tries = Cell::new(0);
    let short = |until: u32| {
        tries.set(0);
        let work = || -> io::Result<u32> {
            tries.set(tries.get() + 1);
            if tries.get() < until { Err(ErrorKind::OutOfMemory.into()) } else { Ok(tries.get()) }
        };
        retry_on_shortage(&faults, &clip, work, |error| error.kind() == ErrorKind::OutOfMemory, 4)
    };
    assert_eq!(short(3).unwrap(), 3);
    assert_eq!(short(9).unwrap_err().kind(), ErrorKind::OutOfMemory, "what looks like a shortage each time is none");
    assert_eq!(tries.get(), 4);
    assert_eq!(told.try_iter().count(), 1, "it is told once");
}
