//! Clips to render, as jobs.
//!
//! Owns the jobs: their keys, and what a restart goes on with. `media` makes the files. Never renders on a thread that
//! answers.
//!
//! Start at [`render`].

use std::sync::Arc;

use flock::{ClipPath, SheepId};
use serde_json::{Value, json};

use super::{checking, measuring};
use crate::answer::{Problem, malformed, refused};
use crate::jobs::{Job, Kept, Kind, NewJob, Priority, Work};
use crate::media::{RENDER_KEY, Wanted};
use crate::requests::JobRequest;
use crate::workshop::Workshop;

/// Queues what is asked for, or only tells what it costs.
/// Errors: If nothing is named, if it is not in the flock, or if a genome cannot be read.
pub(crate) fn render(workshop: &Arc<Workshop>, request: &JobRequest) -> Result<Value, Problem> {
    match request.kind.as_str() {
        "measure" => return Ok(json!({ "jobs": [measuring::queue(workshop)] })),
        "render" => {}
        other => {
            return Err(malformed(format!("jobs that can be asked for are `measure` and `render`, found `{other}`")));
        }
    }
    let id = |text: &String| SheepId::new(text).map_err(|error| malformed(error.to_string()));
    let wanted = match (&request.sheep, &request.from, &request.to) {
        (Some(sheep), None, None) => Wanted::Loop(id(sheep)?),
        (None, Some(from), Some(to)) => Wanted::Transition(id(from)?, id(to)?),
        (None, None, None) if request.all_missing => Wanted::Missing,
        _ => return Err(malformed("what is to be rendered: a sheep, a transition, or all that is missing?")),
    };
    let (_, flock) = workshop.flock();
    let found = workshop.media.to_render(flock.manifest(), &wanted, request.draft);
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
            workshop.queue.add_job(new, work_of_clip(workshop, clip.path, request.draft))
        })
        .collect();
    workshop.tell_all();
    Ok(json!({ "jobs": jobs, "cost_s": cost_s, "clips": count, "left_out": left_out }))
}

fn work_of_clip(workshop: &Arc<Workshop>, path: ClipPath, is_draft: bool) -> Work {
    workshop.work(move |workshop, progress| {
        let rendered = workshop.media.render(&path, is_draft, progress);
        workshop.look();
        workshop.tell_all();
        if rendered.is_ok() {
            judge_joins_of(workshop, &path);
        }
        rendered
    })
}

/// Queues a look at the joins of a transition that was rendered.
fn judge_joins_of(workshop: &Arc<Workshop>, path: &ClipPath) {
    let (_, flock) = workshop.flock();
    let own = flock.manifest().transitions.iter().find(|own| own.clip.path == *path);
    if let Some(own) = own {
        checking::queue_joins(workshop, own.from.clone(), own.to.clone());
    }
}

/// The work of a job that an earlier run left; `None` if it cannot be made again.
pub(crate) fn work_of(workshop: &Arc<Workshop>, kept: &Kept) -> Option<Work> {
    let path = ClipPath::new(kept.spec["path"].as_str()?).ok()?;
    (kept.kind == Kind::Render).then(|| work_of_clip(workshop, path, kept.spec["draft"].as_bool().unwrap_or(false)))
}
