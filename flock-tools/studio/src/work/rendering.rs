//! Clips to render, strips and previews of transitions, as jobs.
//!
//! Owns the jobs: their keys, their urgency and what a restart goes on with. `media` makes the files. Never renders on a
//! thread that answers.
//!
//! Start at [`Workshop::render`].

use std::sync::Arc;

use flock::{ClipPath, SheepId};
use serde_json::{Value, json};

use super::{checking, measuring};
use crate::answer::Problem;
use crate::answers::{conflict, malformed, refused};
use crate::events::EventKind;
use crate::jobs::{Job, Kept, Kind, NewJob, Priority, Progress, Work};
use crate::media::{MediaError, RENDER_KEY, Wanted};
use crate::requests::{JobRequest, PreviewKind, PreviewRequest};
use crate::workshop::Workshop;

/// Frames of a transition that does not exist, for its previews.
const FRAMES: u32 = flock::paths::TRANSITION_FRAMES;

/// What makes a file of `media`, by its key.
type Make = fn(&Workshop, &str, &Progress) -> Result<Value, MediaError>;

impl Workshop {
    /// Queues what is asked for, or only tells what it costs.
    /// Errors: If nothing is named, if it is not in the flock, or if a genome cannot be read.
    pub(crate) fn render(self: &Arc<Self>, request: &JobRequest) -> Result<Value, Problem> {
        match request.kind.as_str() {
            "measure" => return Ok(json!({ "jobs": [measuring::queue(self)] })),
            "render" => {}
            other => {
                return Err(malformed(format!(
                    "jobs that can be asked for are `measure` and `render`, found `{other}`"
                )));
            }
        }
        let id = |text: &String| SheepId::new(text).map_err(|error| malformed(error.to_string()));
        let wanted = match (&request.sheep, &request.from, &request.to) {
            (Some(sheep), None, None) => Wanted::Loop(id(sheep)?),
            (None, Some(from), Some(to)) => Wanted::Transition(id(from)?, id(to)?),
            (None, None, None) if request.all_missing => Wanted::Missing,
            _ => return Err(malformed("what is to be rendered: a sheep, a transition, or all that is missing?")),
        };
        let (_, flock) = self.flock();
        let found = self.media.to_render(flock.manifest(), &wanted, request.draft);
        let (clips, left_out) = found.map_err(refused)?;
        let cost_s = clips.iter().try_fold(0.0, |sum, clip| Some(sum + clip.cost_s?));
        let count = clips.len();
        if request.dry {
            return Ok(json!({ "jobs": [], "cost_s": cost_s, "clips": count, "left_out": left_out }));
        }
        let jobs: Vec<Job> = clips
            .into_iter()
            .map(|clip| {
                let key = format!("{RENDER_KEY}{}", clip.path);
                let spec = json!({ "path": clip.path.as_str(), "draft": request.draft });
                let what = if request.draft { format!("a draft of {}", clip.what) } else { clip.what };
                let new = NewJob {
                    key: Some(key),
                    about: Some(clip.about),
                    cost_s: clip.cost_s,
                    spec: Some(spec),
                    ..NewJob::new(Priority::Clip, Kind::Render, what)
                };
                self.queue.add_job(new, self.work_of_clip(clip.path, request.draft))
            })
            .collect();
        self.tell_all();
        Ok(json!({ "jobs": jobs, "cost_s": cost_s, "clips": count, "left_out": left_out }))
    }

    fn work_of_clip(self: &Arc<Self>, path: ClipPath, is_draft: bool) -> Work {
        let shared = Arc::downgrade(self);
        Box::new(move |progress: &Progress| {
            let workshop = shared.upgrade().ok_or("the studio has ended")?;
            let rendered = workshop.media.render(&path, is_draft, progress);
            workshop.look();
            workshop.tell_all();
            if rendered.is_ok() {
                workshop.judge_joins_of(&path);
            }
            rendered
        })
    }

    /// Queues a look at the joins of a transition that was rendered.
    fn judge_joins_of(self: &Arc<Self>, path: &ClipPath) {
        let (_, flock) = self.flock();
        let own = flock.manifest().transitions.iter().find(|own| own.clip.path == *path);
        if let Some(own) = own {
            checking::queue_joins(self, own.from.clone(), own.to.clone());
        }
    }

    /// Queues a preview of a transition, which need not exist, unless it is there already.
    /// Errors: If one of the sheep has no genome.
    pub(crate) fn preview(self: &Arc<Self>, request: &PreviewRequest) -> Result<Value, Problem> {
        let id = |text: &String| SheepId::new(text).map_err(|error| malformed(error.to_string()));
        let (from, to) = (id(&request.from)?, id(&request.to)?);
        let (_, flock) = self.flock();
        let manifest = flock.manifest();
        let own = manifest.transitions.iter().find(|own| own.from == from && own.to == to);
        let frames = own.map_or(FRAMES, |own| own.clip.frames.0);
        let key = self.keys(manifest).pair(&from, &to, frames);
        let key = key.ok_or_else(|| conflict(format!("`{from}` and `{to}` need genomes for a preview")))?;
        let figures = self.media.find_figures(&key);
        let (ready, kind, word, make): (bool, Kind, &str, Make) = match request.kind {
            PreviewKind::Middles => (figures.is_some(), Kind::Middles, "middle", |workshop, key, progress| {
                workshop.media.make_middles(key, progress)
            }),
            PreviewKind::Moving => {
                let is_whole = self.media.moving(&key, u64::MAX).is_some_and(|(_, is_whole)| is_whole);
                (is_whole, Kind::Moving, "preview", |workshop, key, progress| {
                    workshop.media.make_moving(key, progress).map(|_| Value::Null)
                })
            }
        };
        if ready {
            return Ok(json!({ "job": null, "key": key, "ready": true, "figures": figures }));
        }
        let what = format!("{word} of {from} to {to}");
        let job = self.queue_media(Priority::Interactive, kind, what, &key, make);
        Ok(json!({ "job": job, "key": key, "ready": false, "figures": figures }))
    }

    /// Queues a strip that is not there.
    pub(crate) fn queue_strip(self: &Arc<Self>, key: &str) -> Job {
        let make: Make = |workshop, key, progress| workshop.make_strip(key, progress).map(|()| Value::Null);
        let what = self.name_of_strip(key).map_or_else(|| "strip".to_owned(), |id| format!("strip of {id}"));
        self.queue_media(Priority::Preview, Kind::Strip, what, key, make)
    }

    /// Makes the strip of `key`, and tells the pages what is seen in it.
    /// Errors: [`MediaError`] if nothing can be shown.
    pub(crate) fn make_strip(&self, key: &str, progress: &Progress) -> Result<(), MediaError> {
        self.media.make_strip(key, progress)?;
        if let Some((activity, colour)) = self.media.look(key) {
            let look = json!({ "strip": key, "activity": activity, "colour": colour });
            self.hub.send(EventKind::Looks, &json!({ "looks": [look] }));
        }
        Ok(())
    }

    /// Whose strip has this key: a sheep's of the flock, or a candidate's.
    fn name_of_strip(&self, key: &str) -> Option<String> {
        let (_, flock) = self.flock();
        let manifest = flock.manifest();
        let keys = self.keys(manifest);
        let of_flock = manifest.sheep.iter().find(|sheep| {
            let genome = sheep.genome.as_ref().map(|genome| genome.inside(&self.folder));
            keys.strip(sheep.clip.as_ref(), genome.as_deref()).as_deref() == Some(key)
        });
        let candidates = self.stock.candidates.all(&self.stock.genomes);
        let found = || candidates.iter().find(|own| keys.strip(None, Some(&own.path)).as_deref() == Some(key));
        of_flock.map(|sheep| &sheep.id).or_else(|| found().map(|own| &own.id)).map(ToString::to_string)
    }

    /// Why the strip of `key` could not be made, if that was tried last.
    pub(crate) fn failed_strip(&self, key: &str) -> Option<String> {
        let own = key_of(Kind::Strip, key);
        let jobs = self.queue.jobs();
        jobs.into_iter().rev().find(|job| job.key.as_ref() == Some(&own))?.error
    }

    fn queue_media(self: &Arc<Self>, priority: Priority, kind: Kind, what: String, key: &str, make: Make) -> Job {
        let (shared, own) = (Arc::downgrade(self), key.to_owned());
        let work = move |progress: &Progress| {
            let workshop = shared.upgrade().ok_or("the studio has ended")?;
            let made = make(&workshop, &own, progress).map_err(|error| error.to_string())?;
            Ok(json!({ "key": own, "figures": made }))
        };
        let new = NewJob { key: Some(key_of(kind, key)), ..NewJob::new(priority, kind, what) };
        self.queue.add_job(new, Box::new(work))
    }

    /// The work of a job that an earlier run left; `None` if it cannot be made again.
    pub(crate) fn work_of(self: &Arc<Self>, kept: &Kept) -> Option<Work> {
        let path = ClipPath::new(kept.spec["path"].as_str()?).ok()?;
        (kept.kind == Kind::Render).then(|| self.work_of_clip(path, kept.spec["draft"].as_bool().unwrap_or(false)))
    }
}

/// The key of a job of this kind that makes the file of `key`.
fn key_of(kind: Kind, key: &str) -> String {
    format!("{kind:?} {key}")
}
