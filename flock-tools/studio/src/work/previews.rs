//! Strips, and previews of transitions, as jobs.
//!
//! Owns the jobs: their keys and their urgency. `media` makes the files. Never draws on a thread that answers.
//!
//! Start at [`preview`] and [`queue_strip`].

use std::sync::Arc;

use flock::SheepId;
use serde_json::{Value, json};

use crate::answer::{Problem, conflict, malformed};
use crate::events::EventKind;
use crate::jobs::{Job, Kind, NewJob, Priority, Progress};
use crate::media::MediaError;
use crate::requests::{PreviewKind, PreviewRequest};
use crate::workshop::Workshop;

/// Frames of a transition that does not exist, for its previews.
const FRAMES: u32 = flock::paths::TRANSITION_FRAMES;

/// What makes a file of `media`, by its key.
type Make = fn(&Workshop, &str, &Progress) -> Result<Value, MediaError>;

/// Queues a preview of a transition, which need not exist, unless it is there already.
/// Errors: If one of the sheep has no genome.
pub(crate) fn preview(workshop: &Arc<Workshop>, request: &PreviewRequest) -> Result<Value, Problem> {
    let id = |text: &String| SheepId::new(text).map_err(|error| malformed(error.to_string()));
    let (from, to) = (id(&request.from)?, id(&request.to)?);
    let (_, flock) = workshop.flock();
    let manifest = flock.manifest();
    let own = manifest.transitions.iter().find(|own| own.from == from && own.to == to);
    let frames = own.map_or(FRAMES, |own| own.clip.frames.0);
    let key = workshop.keys(manifest).pair(&from, &to, frames);
    let key = key.ok_or_else(|| conflict(format!("`{from}` and `{to}` need genomes for a preview")))?;
    let figures = workshop.media.find_figures(&key);
    let (ready, kind, word, make): (bool, Kind, &str, Make) = match request.kind {
        PreviewKind::Middles => (figures.is_some(), Kind::Middles, "middle", |workshop, key, progress| {
            workshop.media.make_middles(key, progress)
        }),
        PreviewKind::Moving => {
            let is_whole = workshop.media.moving(&key, u64::MAX).is_some_and(|(_, is_whole)| is_whole);
            (is_whole, Kind::Moving, "preview", |workshop, key, progress| {
                workshop.media.make_moving(key, progress).map(|_| Value::Null)
            })
        }
    };
    if ready {
        return Ok(json!({ "job": null, "key": key, "ready": true, "figures": figures }));
    }
    let what = format!("{word} of {from} to {to}");
    let job = queue_media(workshop, Priority::Interactive, kind, what, &key, make);
    Ok(json!({ "job": job, "key": key, "ready": false, "figures": figures }))
}

/// Queues a strip that is not there.
pub(crate) fn queue_strip(workshop: &Arc<Workshop>, key: &str) -> Job {
    let make: Make = |workshop, key, progress| make_strip(workshop, key, progress).map(|()| Value::Null);
    let what = name_of_strip(workshop, key).map_or_else(|| "strip".to_owned(), |id| format!("strip of {id}"));
    queue_media(workshop, Priority::Preview, Kind::Strip, what, key, make)
}

/// Makes the strip of `key`, and tells the pages what is seen in it.
/// Errors: [`MediaError`] if nothing can be shown.
pub(crate) fn make_strip(workshop: &Workshop, key: &str, progress: &Progress) -> Result<(), MediaError> {
    workshop.media.make_strip(key, progress)?;
    if let Some((activity, colour)) = workshop.media.look(key) {
        let look = json!({ "strip": key, "activity": activity, "colour": colour });
        workshop.hub.send(EventKind::Looks, &json!({ "looks": [look] }));
    }
    Ok(())
}

/// Whose strip has this key: a sheep's of the flock, or a candidate's.
fn name_of_strip(workshop: &Workshop, key: &str) -> Option<String> {
    let (_, flock) = workshop.flock();
    let manifest = flock.manifest();
    let keys = workshop.keys(manifest);
    let of_flock = manifest.sheep.iter().find(|sheep| {
        let genome = sheep.genome.as_ref().map(|genome| genome.inside(&workshop.folder));
        keys.strip(sheep.clip.as_ref(), genome.as_deref()).as_deref() == Some(key)
    });
    let candidates = workshop.stock.candidates.all(&workshop.stock.genomes);
    let found = || candidates.iter().find(|own| keys.strip(None, Some(&own.path)).as_deref() == Some(key));
    of_flock.map(|sheep| &sheep.id).or_else(|| found().map(|own| &own.id)).map(ToString::to_string)
}

/// Why the strip of `key` could not be made, if that was tried last.
pub(crate) fn failed_strip(workshop: &Workshop, key: &str) -> Option<String> {
    let own = key_of(Kind::Strip, key);
    let jobs = workshop.queue.jobs();
    jobs.into_iter().rev().find(|job| job.key.as_ref() == Some(&own))?.error
}

fn queue_media(workshop: &Arc<Workshop>, priority: Priority, kind: Kind, what: String, key: &str, make: Make) -> Job {
    let (new, own) = (NewJob { key: Some(key_of(kind, key)), ..NewJob::new(priority, kind, what) }, key.to_owned());
    workshop.add_job(new, move |workshop, progress| {
        let made = make(workshop, &own, progress).map_err(|error| error.to_string())?;
        Ok(json!({ "key": own, "figures": made }))
    })
}

/// The key of a job of this kind that makes the file of `key`.
fn key_of(kind: Kind, key: &str) -> String {
    format!("{kind:?} {key}")
}
