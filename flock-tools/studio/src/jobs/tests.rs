//! The order of jobs, and that none is lost.
//! Work is held and released by channels; nothing sleeps.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rustix::process::getpriority_process;
use serde_json::{Value, json};

use super::progress::Progress;
use super::queue::{CLIP_NICE, PREVIEW_NICE};
use super::{Job, JobId, Kind, NewJob, Priority, Queue, Settings, State, Work};

/// The longest that a test waits for a job.
const LONGEST: Duration = Duration::from_secs(20);

fn settings() -> Settings {
    Settings { threads: 1, kept: None, clock: || Duration::ZERO, listener: Box::new(|_| {}) }
}

fn open() -> Queue {
    Queue::open(settings()).unwrap()
}

fn keeping(path: &Path) -> Queue {
    Queue::open(Settings { kept: Some(path.to_owned()), ..settings() }).unwrap()
}

/// Work that says its name, as a log line too, and then waits until it is released, or cancelled.
fn held(name: &'static str, said: &Arc<Mutex<Vec<&'static str>>>, release: Receiver<()>) -> Work {
    let said = Arc::clone(said);
    Box::new(move |progress| {
        said.lock().unwrap().push(name);
        progress.log(name);
        let _ = release.recv_timeout(LONGEST);
        Ok(Value::Null)
    })
}

fn quick(name: &'static str, said: &Arc<Mutex<Vec<&'static str>>>) -> Work {
    let (sender, receiver) = channel();
    drop::<Sender<()>>(sender);
    held(name, said, receiver)
}

/// Work that goes on until it is cancelled.
fn endless() -> Work {
    Box::new(|progress| {
        while !progress.is_cancelled() {
            progress.wait_if_paused();
            std::thread::yield_now();
        }
        Err("cancelled".to_owned())
    })
}

fn is(queue: &Queue, id: JobId, state: State) -> bool {
    queue.wait_until(LONGEST, |jobs| jobs.iter().any(|job| job.id == id && job.state == state))
}

/// Whether the held work of `id` has said its name: a job counts as running before its thread gets to its first line.
fn has_begun(queue: &Queue, id: JobId) -> bool {
    queue.wait_until(LONGEST, |jobs| jobs.iter().any(|job| job.id == id && !job.log.is_empty()))
}

fn are_over(jobs: &[Job]) -> bool {
    jobs.iter().all(|job| job.state.is_over())
}

#[test]
fn what_somebody_waits_for_comes_first_then_previews_then_clips_by_age() {
    let (queue, said) = (open(), Arc::new(Mutex::new(Vec::new())));
    let (go_clip, clip) = channel();
    let (go_preview, preview) = channel();
    let a = queue.add(Priority::Clip, Kind::Render, "a", held("a", &said, clip));
    assert!(has_begun(&queue, a));
    let p = queue.add(Priority::Preview, Kind::Strip, "p", held("p", &said, preview));
    assert!(has_begun(&queue, p), "a preview never waits for a clip");
    let other = queue.add(Priority::Preview, Kind::Strip, "other", endless());
    assert!(is(&queue, other, State::Running));
    queue.add(Priority::Clip, Kind::Render, "b", quick("b", &said));
    queue.add(Priority::Clip, Kind::Render, "c", quick("c", &said));
    queue.add(Priority::Preview, Kind::Strip, "q", quick("q", &said));
    queue.add(Priority::Interactive, Kind::Middles, "i", quick("i", &said));
    go_preview.send(()).unwrap();
    assert!(queue.wait_until(LONGEST, |jobs| jobs.iter().filter(|job| job.state == State::Done).count() == 3));
    go_clip.send(()).unwrap();
    queue.cancel(other);
    assert!(queue.wait_until(LONGEST, are_over));
    assert_eq!(*said.lock().unwrap(), ["a", "p", "i", "q", "b", "c"]);
}

#[test]
fn previews_leave_the_processors_to_the_page_and_clips_to_previews() {
    let queue = open();
    let own = getpriority_process(None).unwrap();
    let nice = [(Priority::Preview, Kind::Strip), (Priority::Clip, Kind::Render)].map(|(priority, kind)| {
        let (tell, told) = channel();
        let work = move |_: &Progress| {
            tell.send(getpriority_process(None).unwrap()).unwrap();
            Ok(Value::Null)
        };
        queue.add(priority, kind, "nice", Box::new(work));
        told.recv_timeout(LONGEST).unwrap()
    });
    assert_eq!(nice, [own.max(PREVIEW_NICE), own.max(CLIP_NICE)]);
    assert_eq!(getpriority_process(None).unwrap(), own, "the threads of the page are as they were");
}

#[test]
fn a_pause_holds_clips_that_run_and_that_wait_and_no_preview() {
    let (queue, said) = (open(), Arc::new(Mutex::new(Vec::new())));
    queue.pause(true);
    let clip = queue.add(Priority::Clip, Kind::Render, "clip", quick("clip", &said));
    let strip = queue.add(Priority::Preview, Kind::Strip, "strip", quick("strip", &said));
    assert!(is(&queue, strip, State::Done));
    assert_eq!(queue.job(clip).unwrap().state, State::Queued);
    queue.pause(false);
    assert!(is(&queue, clip, State::Done));
    let (go, going) = channel();
    let stops: Work = Box::new(move |progress| {
        going.recv_timeout(LONGEST).unwrap();
        progress.wait_if_paused();
        Ok(json!("went on"))
    });
    let clip = queue.add(Priority::Clip, Kind::Render, "clip", stops);
    assert!(is(&queue, clip, State::Running));
    queue.pause(true);
    go.send(()).unwrap();
    let strip = queue.add(Priority::Preview, Kind::Strip, "strip", quick("strip", &said));
    assert!(is(&queue, strip, State::Done) && queue.job(clip).unwrap().state == State::Running);
    queue.pause(false);
    assert!(is(&queue, clip, State::Done));
    assert_eq!(queue.job(clip).unwrap().result, Some(json!("went on")));
}

#[test]
fn a_job_that_is_paused_is_passed_over_or_stands_still_and_the_others_go_on() {
    let (queue, said) = (open(), Arc::new(Mutex::new(Vec::new())));
    let (go_first, first) = channel();
    let runs = queue.add(Priority::Clip, Kind::Render, "runs", held("runs", &said, first));
    assert!(has_begun(&queue, runs));
    let waits = queue.add(Priority::Clip, Kind::Render, "waits", quick("waits", &said));
    assert!(queue.pause_job(waits, true).unwrap().paused);
    let other = queue.add(Priority::Clip, Kind::Render, "other", quick("other", &said));
    go_first.send(()).unwrap();
    assert!(is(&queue, other, State::Done));
    assert_eq!((queue.job(waits).unwrap().state, queue.job(waits).unwrap().paused), (State::Queued, true));
    queue.pause_job(waits, false);
    assert!(is(&queue, waits, State::Done));
    assert_eq!(*said.lock().unwrap(), ["runs", "other", "waits"]);
    // One that runs stands still between its steps, until it may go on.
    let (go_step, step) = channel();
    let steps: Work = Box::new(move |progress| {
        progress.log("begun");
        step.recv_timeout(LONGEST).unwrap();
        progress.wait_if_paused();
        Ok(json!("went on"))
    });
    let steps = queue.add(Priority::Clip, Kind::Render, "steps", steps);
    assert!(has_begun(&queue, steps) && queue.pause_job(steps, true).unwrap().paused);
    go_step.send(()).unwrap();
    let strip = queue.add(Priority::Preview, Kind::Strip, "strip", quick("strip", &said));
    assert!(is(&queue, strip, State::Done) && queue.job(steps).unwrap().state == State::Running);
    queue.pause_job(steps, false);
    assert!(is(&queue, steps, State::Done));
}

#[test]
fn a_job_that_is_over_or_runs_without_steps_is_not_said_to_be_paused() {
    let queue = open();
    let runs = queue.add(Priority::Clip, Kind::Pack, "runs", endless());
    assert!(is(&queue, runs, State::Running));
    let told = queue.pause_job(runs, true).unwrap();
    assert_eq!((told.can_pause, told.paused), (false, false));
    let waits = queue.add(Priority::Clip, Kind::Pack, "waits", endless());
    assert!(queue.pause_job(waits, true).unwrap().paused && queue.cancel(waits));
    assert_eq!((queue.job(waits).unwrap().state, queue.job(waits).unwrap().paused), (State::Cancelled, false));
    assert!(queue.cancel(runs) && queue.pause_job(99, true).is_none());
}

#[test]
fn a_clip_gives_way_between_frames_while_somebody_waits() {
    let (queue, said) = (open(), Arc::new(Mutex::new(Vec::new())));
    let (go_frame, frame) = channel();
    let (go_urgent, urgent) = channel();
    let told = Arc::clone(&said);
    let clip: Work = Box::new(move |progress| {
        frame.recv_timeout(LONGEST).unwrap();
        progress.wait_if_paused();
        told.lock().unwrap().push("next frame");
        Ok(Value::Null)
    });
    let clip = queue.add(Priority::Clip, Kind::Render, "clip", clip);
    assert!(is(&queue, clip, State::Running));
    let middles = queue.add(Priority::Interactive, Kind::Middles, "middles", held("middles", &said, urgent));
    assert!(has_begun(&queue, middles));
    go_frame.send(()).unwrap();
    go_urgent.send(()).unwrap();
    assert!(queue.wait_until(LONGEST, are_over));
    assert_eq!(*said.lock().unwrap(), ["middles", "next frame"]);
}

#[test]
fn a_job_is_cancelled_while_it_waits_and_while_it_runs_and_even_while_it_is_paused() {
    let (queue, said) = (open(), Arc::new(Mutex::new(Vec::new())));
    let runs = queue.add(Priority::Clip, Kind::Render, "runs", endless());
    assert!(is(&queue, runs, State::Running));
    let waits = queue.add(Priority::Clip, Kind::Render, "waits", quick("waits", &said));
    assert!(queue.cancel(waits));
    assert_eq!(queue.job(waits).unwrap().state, State::Cancelled);
    queue.pause(true);
    assert!(queue.cancel(runs) && is(&queue, runs, State::Cancelled));
    assert!(said.lock().unwrap().is_empty() && !queue.cancel(99));
}

#[test]
fn a_job_that_fails_or_panics_says_so_and_the_next_one_runs() {
    let (queue, said) = (open(), Arc::new(Mutex::new(Vec::new())));
    let fails = queue.add(Priority::Clip, Kind::Render, "fails", Box::new(|_| Err("no disk".to_owned())));
    let panics = queue.add(Priority::Clip, Kind::Render, "panics", Box::new(|_| panic!("on purpose")));
    let next = queue.add(Priority::Clip, Kind::Render, "next", quick("next", &said));
    assert!(is(&queue, next, State::Done));
    let error = |id| (queue.job(id).unwrap().state, queue.job(id).unwrap().error.unwrap());
    assert_eq!(error(fails), (State::Failed, "no disk".to_owned()));
    assert_eq!(error(panics).0, State::Failed);
    assert!(error(panics).1.contains("bug"), "{:?}", error(panics));
}

#[test]
fn the_same_thing_is_made_once_and_is_as_urgent_as_the_most_urgent_asker() {
    let (queue, said) = (open(), Arc::new(Mutex::new(Vec::new())));
    let (go, holds) = channel();
    let busy = queue.add(Priority::Preview, Kind::Moving, "busy", endless());
    assert!(is(&queue, busy, State::Running));
    let first = queue.add(Priority::Preview, Kind::Strip, "first", held("first", &said, holds));
    assert!(has_begun(&queue, first));
    let keyed = |priority| NewJob { key: Some("strip 1".to_owned()), ..NewJob::new(priority, Kind::Strip, "strip") };
    let asked = queue.add_job(keyed(Priority::Preview), quick("strip", &said));
    queue.add(Priority::Preview, Kind::Strip, "other", quick("other", &said));
    let again = queue.add_job(keyed(Priority::Interactive), quick("twice", &said));
    assert_eq!(asked.id, again.id);
    go.send(()).unwrap();
    assert!(is(&queue, asked.id, State::Done));
    let after = queue.add_job(keyed(Priority::Preview), quick("anew", &said));
    assert!(after.id != asked.id && is(&queue, after.id, State::Done));
    assert_eq!(*said.lock().unwrap(), ["first", "strip", "other", "anew"]);
}

#[test]
fn a_restart_goes_on_with_what_ran_and_what_waited_and_not_with_what_was_over() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("jobs.json");
    let said = Arc::new(Mutex::new(Vec::new()));
    let kept =
        |what: &str| NewJob { spec: Some(json!({ "clip": what })), ..NewJob::new(Priority::Clip, Kind::Render, what) };
    let queue = keeping(&path);
    let done = queue.add_job(kept("done"), quick("done", &said)).id;
    assert!(is(&queue, done, State::Done));
    let runs = queue.add_job(kept("runs"), endless()).id;
    assert!(is(&queue, runs, State::Running));
    let waits = queue.add_job(kept("waits"), endless()).id;
    let cancelled = queue.add_job(kept("cancelled"), endless()).id;
    queue.add(Priority::Clip, Kind::Check, "forgotten", endless());
    queue.cancel(cancelled);
    drop(queue);
    // A second restart in between loses nothing.
    drop(keeping(&path));
    let queue = keeping(&path);
    let left = queue.left();
    let told: Vec<_> = left.iter().map(|kept| (kept.id, kept.spec["clip"].as_str().unwrap())).collect();
    assert_eq!(told, [(runs, "runs"), (waits, "waits")]);
    for kept in &left {
        queue.go_on(kept, quick("again", &said));
    }
    assert!(is(&queue, runs, State::Done) && is(&queue, waits, State::Done));
    assert!(queue.add(Priority::Clip, Kind::Check, "new", quick("new", &said)) > waits);
    drop(queue);
    assert_eq!(keeping(&path).left(), []);
}

#[test]
fn a_job_that_is_given_up_is_not_gone_on_with_and_a_damaged_list_is_empty() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("jobs.json");
    let queue = keeping(&path);
    let new = NewJob { spec: Some(json!(1)), ..NewJob::new(Priority::Clip, Kind::Render, "clip") };
    queue.add_job(new, endless());
    drop(queue);
    let queue = keeping(&path);
    queue.forget(&queue.left()[0]);
    drop(queue);
    assert_eq!(keeping(&path).left(), []);
    std::fs::write(&path, "[{").unwrap();
    assert_eq!(keeping(&path).left(), []);
}

#[test]
fn work_that_waits_for_somebody_does_not_hold_the_end_of_the_program() {
    let (go, never) = channel::<()>();
    let queue = open();
    let waits: Work = Box::new(move |progress| {
        progress.waiting_for("a passphrase");
        never.recv().map_or(Err("the program has ended".to_owned()), |()| Ok(Value::Null))
    });
    let pack = queue.add(Priority::Clip, Kind::Pack, "pack", waits);
    assert!(is(&queue, pack, State::Waiting));
    drop(queue);
    drop(go);
}

/// Seconds, as the clock of the test below has them.
static SECONDS: AtomicU64 = AtomicU64::new(0);

#[test]
fn the_pace_is_of_the_time_that_a_job_ran_and_every_change_is_told() {
    let (sender, told) = channel();
    let sender = Mutex::new(sender);
    let listener = Box::new(move |job: &Job| drop(sender.lock().unwrap().send(job.clone())));
    let clock = || Duration::from_secs(SECONDS.load(Ordering::SeqCst));
    let queue = Queue::open(Settings { clock, listener, ..settings() }).unwrap();
    let work: Work = Box::new(|progress| {
        SECONDS.fetch_add(4, Ordering::SeqCst);
        progress.set(8, 20);
        progress.waiting_for("a passphrase\u{7}");
        progress.log("the key is open");
        progress.set(20, 20);
        Ok(Value::Null)
    });
    let id = queue.add(Priority::Clip, Kind::Pack, "pack", work);
    assert!(is(&queue, id, State::Done));
    drop(queue);
    let jobs: Vec<Job> = told.iter().collect();
    let states: Vec<State> = jobs.iter().map(|job| job.state).collect();
    let running = State::Running;
    assert_eq!(states, [State::Queued, running, running, State::Waiting, running, State::Done]);
    assert_eq!((jobs[2].done, jobs[2].of, jobs[2].per_second, jobs[2].left_s), (8, 20, Some(2.0), Some(6.0)));
    assert_eq!(jobs[4].log, ["a passphrase", "the key is open"]);
}
