//! The threads of an import: each makes one clip at a time, and finished clips are added to the flock many at once.
//!
//! Owns the queue of clips and the time between two commits. Never makes a clip: `importer.rs` does; nor touches the
//! manifest: `commit.rs` does.
//!
//! Start at [`run`].

use std::io;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use operations::program::now::Stopwatch;
use operations::program::{Exit, Fatal};

use super::SkippedFile;
use super::commit::{Outcome, commit};
use super::importer::{Importer, Made, MadeClip, MakeError};
use super::plan::ClipPlan;

/// The time between two commits: each syncs the disk, and a kill loses what was made since the last one.
const COMMIT_EVERY: Duration = Duration::from_secs(10);

/// The result of one plan.
type Message = (usize, Result<Option<Made>, MakeError>);

/// What became of the plan with an index.
pub(super) enum Report<'a> {
    /// Its clip was finished.
    Clip(&'a MadeClip, Outcome),
    /// A file of it was not taken.
    Skipped(SkippedFile),
}

/// The system refused threads.
#[derive(Debug, thiserror::Error)]
#[error("cannot start a thread")]
struct ThreadError {
    source: io::Error,
}

/// Makes the clips of `plans` with `threads` threads and adds them to the flock. `report` hears of each once it is there.
/// Returns whether that are all: the run may have been stopped.
/// Errors: Those that concern every other clip, too: a disk that is full, a manifest that cannot be read. Clips that were
/// finished before are added all the same, if that is possible.
pub(super) fn run(
    importer: &Importer<'_>,
    plans: &[ClipPlan],
    threads: NonZeroUsize,
    report: &mut dyn FnMut(usize, Report<'_>),
) -> Result<bool, Fatal> {
    let next = AtomicUsize::new(0);
    let (sender, results) = channel::<Message>();
    thread::scope(|scope| {
        for at in 0..threads.get().min(plans.len()) {
            let (sender, next) = (sender.clone(), &next);
            let started = thread::Builder::new().spawn_scoped(scope, move || work(importer, plans, next, &sender));
            match started {
                // The threads that could be started do the work.
                Err(_) if at > 0 => break,
                Err(source) => return Err(Fatal::new(Exit::Unreadable, ThreadError { source })),
                Ok(_) => (),
            }
        }
        drop(sender);
        let collected = collect(importer, plans, &results, report);
        if collected.is_err() {
            importer.stop.store(true, Ordering::Relaxed);
        }
        collected
    })
}

/// Makes clips until none is left, one fails or the run is stopped.
fn work(importer: &Importer<'_>, plans: &[ClipPlan], next: &AtomicUsize, results: &Sender<Message>) {
    while !importer.stop.load(Ordering::Relaxed) {
        let at = next.fetch_add(1, Ordering::Relaxed);
        let Some(plan) = plans.get(at) else { return };
        let made = importer.make(plan);
        if made.is_err() {
            importer.stop.store(true, Ordering::Relaxed);
        }
        if results.send((at, made)).is_err() {
            return;
        }
    }
}

/// Takes the results as they come, until all threads have ended.
fn collect(
    importer: &Importer<'_>,
    plans: &[ClipPlan],
    results: &Receiver<Message>,
    report: &mut dyn FnMut(usize, Report<'_>),
) -> Result<bool, Fatal> {
    let (mut failure, mut finished) = (None, 0);
    let mut batch: Vec<(usize, MadeClip)> = Vec::new();
    let mut since = Stopwatch::start();
    loop {
        match results.recv_timeout(COMMIT_EVERY) {
            Ok((at, Ok(Some(made)))) => {
                finished += 1;
                made.skipped.into_iter().for_each(|skipped| report(at, Report::Skipped(skipped)));
                batch.extend(made.clip.map(|clip| (at, clip)));
            }
            Ok((_, Err(error))) => failure = failure.or(Some(error)),
            Ok((_, Ok(None))) | Err(RecvTimeoutError::Timeout) => (),
            Err(RecvTimeoutError::Disconnected) => break,
        }
        if since.wall() >= COMMIT_EVERY {
            add(importer, plans, std::mem::take(&mut batch), report)?;
            since = Stopwatch::start();
        }
    }
    let added = add(importer, plans, batch, report);
    // What broke first is the cause.
    failure.map_or(added, |error| Err(Fatal::new(Exit::Unreadable, error)))?;
    Ok(finished == plans.len())
}

/// Adds finished clips to the flock, in the order of their plans.
fn add(
    importer: &Importer<'_>,
    plans: &[ClipPlan],
    mut batch: Vec<(usize, MadeClip)>,
    report: &mut dyn FnMut(usize, Report<'_>),
) -> Result<(), Fatal> {
    if batch.is_empty() {
        return Ok(());
    }
    batch.sort_by_key(|(at, _)| *at);
    let clips: Vec<(&ClipPlan, &MadeClip)> = batch.iter().map(|(at, made)| (&plans[*at], made)).collect();
    let outcomes = commit(&clips, importer.settings)?;
    for ((at, made), outcome) in batch.iter().zip(outcomes) {
        report(*at, Report::Clip(made, outcome));
    }
    Ok(())
}
