//! The checks that run as jobs: the faults of all clips, and how well the joins meet.
//!
//! Owns both jobs. The faults are those of `dreams check`. Never changes a clip.
//!
//! Start at [`queue`].

use std::collections::BTreeSet;
use std::sync::Arc;

use flock::{Fault, Manifest, Sheep, SheepId, Transition};
use operations::check::{self, clips};
use operations::decoder::DecoderHandle;
use operations::flock_folder::file_list;
use operations::joins::{count, judge};
use operations::program::{Fatal, print};
use serde_json::{Value, json};
use species::Threads;

use crate::jobs::{Job, Kind, NewJob, Priority, Progress};
use crate::lock::locked;
use crate::store::checked::Checked;
use crate::store::joins::around;
use crate::workshop::Workshop;

/// Clips, and sheep, that are looked at between two looks at whether the check is cancelled.
const PART: usize = 8;

/// Queues a check of the whole flock, with its joins or without.
pub(crate) fn queue(workshop: &Arc<Workshop>, joins: bool) -> Job {
    let (kind, what) = if joins { (Kind::Joins, "all clips and joins") } else { (Kind::Check, "all clips") };
    let new = NewJob { key: Some(format!("check {joins}")), ..NewJob::new(Priority::Clip, kind, what) };
    workshop.add_job(new, move |workshop, progress| {
        let answer = run(workshop, joins, progress);
        workshop.tell_all();
        answer
    })
}

fn run(workshop: &Workshop, joins: bool, progress: &Progress) -> Result<Value, String> {
    let (revision, flock) = workshop.flock();
    let manifest = flock.manifest();
    let of = manifest.clips().count() as u64 + if joins { count(manifest) as u64 } else { 0 };
    // Not those of the other answers: a check of a large flock takes minutes.
    let threads = Threads::new(0).map_err(|error| error.to_string())?;
    let (folder, decoder) = (&*workshop.folder, workshop.stock.decoder);
    let sentence = |fatal: Fatal| fatal.in_words();
    let large = file_list::too_large(folder, manifest).map_err(sentence)?;
    let mut faults: Vec<Fault> = large.into_iter().chain(flock.faults().iter().cloned()).collect();
    let mut done = 0;
    for part in clip_parts(manifest) {
        go_on(progress, done, of)?;
        let found = || clips::faults(folder, &part, DecoderHandle(Some(decoder))).map_err(sentence);
        faults.extend(threads.run(found)?);
        done += part.clips().count() as u64;
    }
    for part in join_parts(manifest).filter(|_| joins) {
        go_on(progress, done, of)?;
        let judgement = threads.run(|| judge(folder, &part, decoder, |_| ()));
        faults.extend(judgement.jumps().map(check::fault_of_jump));
        let kept = locked(&workshop.joins).add(folder, &judgement);
        kept.map_err(|error| format!("cannot keep what was judged: {error}"))?;
        done += count(&part) as u64;
    }
    progress.set(of, of);
    let told = print::count(faults.len(), "fault");
    *locked(&workshop.checked) = Checked { revision: Some(revision), faults };
    Ok(json!({ "said": told }))
}

/// Tells how far a check is, and waits while it is held.
/// Errors: If it is cancelled.
fn go_on(progress: &Progress, done: u64, of: u64) -> Result<(), String> {
    progress.set(done, of);
    progress.wait_if_paused();
    if progress.is_cancelled() { Err("cancelled".to_owned()) } else { Ok(()) }
}

/// The manifest in parts of a few clips, each of which is in one part.
fn clip_parts(manifest: &Manifest) -> impl Iterator<Item = Manifest> {
    let loops = manifest.sheep.chunks(PART).map(|sheep| part(manifest, sheep, &[]));
    let transitions = manifest.transitions.chunks(PART).map(|transitions| part(manifest, &[], transitions));
    loops.chain(transitions)
}

/// The manifest in parts of a few sheep with their transitions: each join, which is at one sheep, is in one part.
fn join_parts(manifest: &Manifest) -> impl Iterator<Item = Manifest> {
    manifest.sheep.chunks(PART).map(|sheep| {
        let ids: BTreeSet<&SheepId> = sheep.iter().map(|sheep| &sheep.id).collect();
        let own = manifest.transitions.iter().filter(|own| ids.contains(&own.from) || ids.contains(&own.to));
        part(manifest, sheep, &own.cloned().collect::<Vec<_>>())
    })
}

fn part(manifest: &Manifest, sheep: &[Sheep], transitions: &[Transition]) -> Manifest {
    let (name, size, fps) = (manifest.name.clone(), manifest.size, manifest.fps);
    Manifest { name, size, fps, sheep: sheep.to_vec(), transitions: transitions.to_vec() }
}

/// Queues a look at the joins of one transition, which was rendered just now.
pub(crate) fn queue_joins(workshop: &Arc<Workshop>, from: SheepId, to: SheepId) -> Job {
    let what = format!("joins of {from} to {to}");
    let new = NewJob { key: Some(format!("joins {from}={to}")), ..NewJob::new(Priority::Preview, Kind::Joins, what) };
    workshop.add_job(new, move |workshop, _| {
        let (_, flock) = workshop.flock();
        let part = around(flock.manifest(), &from, &to);
        let threads = Threads::new(0).map_err(|error| error.to_string())?;
        let judgement = threads.run(|| judge(&workshop.folder, &part, workshop.stock.decoder, |_| ()));
        let kept = locked(&workshop.joins).add(&workshop.folder, &judgement);
        kept.map_err(|error| format!("cannot keep what was judged: {error}"))?;
        workshop.tell_all();
        Ok(json!({ "judged": judgement.joins.len(), "jumps": judgement.jumps().count() }))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn a_check_in_parts_sees_every_clip_and_every_join_once() {
        let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../demo/small");
        let manifest = Manifest::read(&demo).unwrap();
        let clips: Vec<_> = clip_parts(&manifest).flat_map(|part| part.clips().cloned().collect::<Vec<_>>()).collect();
        assert_eq!(clips, manifest.clips().cloned().collect::<Vec<_>>());
        let parts: Vec<Manifest> = join_parts(&manifest).collect();
        assert!(parts.len() > 1);
        assert_eq!(parts.iter().map(count).sum::<usize>(), count(&manifest));
    }
}
