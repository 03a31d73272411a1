//! Clips that are rendered, each by a job.
//!
//! Owns the way from a job to the renderer of `dreams render`, which keeps every finished frame: a clip that is cancelled,
//! or whose job ended with the program, goes on where it stopped. Never renders in another way.
//!
//! Start at [`Media::to_render`] and [`Media::render`].

use std::collections::HashSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use flame::Backend;
use flock::{ClipPath, Manifest, SheepId};
use operations::flock_folder::open;
use operations::program::{Fatal, chain};
use operations::render::make::{Outcome, RunOptions, Watch, make_watched};
use operations::render::plan::{ClipPlan, ClipRole, Look};
use operations::render::presets::Preset;
use operations::render::selection::{Request, Scope, Selection, SkippedClip};
use operations::render::shard::Part;
use operations::render::{hashes, machine};
use serde_json::{Value, json};
use video::Form;

use super::Media;
use super::stopping::with_flag;
use crate::jobs::Progress;
use crate::lock::locked;

/// What the key of a job begins with that renders a clip; its path follows.
pub(crate) const RENDER_KEY: &str = "render ";

/// Which clips are asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// All that are missing.
    Missing,
    /// The loop of a sheep, whether it is there or not.
    Loop(SheepId),
    /// A transition, whether it is there or not.
    Transition(SheepId, SheepId),
}

/// A clip to render.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ClipWork {
    pub(crate) path: ClipPath,
    /// For people: `the loop of orchid`.
    pub(crate) what: String,
    /// For the page: `{sheep}`, or `{from, to}`.
    pub(crate) about: Value,
    pub(crate) frames: u32,
    /// Seconds that it takes on all cores of this machine, by what small pictures took.
    pub(crate) cost_s: Option<f64>,
}

/// How clips are to look: as their genomes say, or as drafts.
pub(super) fn look(form: Form, is_draft: bool) -> Look {
    if is_draft { Preset::Draft.look(form) } else { Look::of_genomes(form) }
}

impl Media {
    /// The clips to render, loops first, and why others that are missing cannot be.
    /// Errors: A sentence, if nothing is known of what is wanted, or a genome cannot be read.
    pub(crate) fn to_render(
        &self,
        manifest: &Manifest,
        wanted: &Wanted,
        is_draft: bool,
    ) -> Result<(Vec<ClipWork>, Vec<String>), String> {
        let look = look(Form { size: manifest.size, fps: manifest.fps }, is_draft);
        let clip = match wanted {
            Wanted::Missing => None,
            Wanted::Loop(id) => {
                let sheep = manifest.sheep.iter().find(|sheep| sheep.id == *id);
                let clip = sheep.and_then(|sheep| sheep.clip.as_ref());
                Some(clip.ok_or_else(|| format!("the sheep `{id}` has no loop to render"))?)
            }
            Wanted::Transition(from, to) => {
                let own = manifest.transitions.iter().find(|own| own.from == *from && own.to == *to);
                Some(&own.ok_or_else(|| format!("there is no transition from `{from}` to `{to}`"))?.clip)
            }
        };
        let listed = clip.map(|clip| HashSet::from([clip.path.clone()]));
        let selection = self.select(manifest, listed.as_ref(), &look)?;
        let work = |plan: &ClipPlan| ClipWork {
            path: plan.path.clone(),
            what: words(&plan.role),
            about: about(&plan.role),
            frames: plan.frames.0,
            cost_s: self.cost_of_plan(manifest, plan, &look),
        };
        let left_out = selection.left_out.iter().map(SkippedClip::in_words).collect();
        Ok((selection.clips.iter().map(work).collect(), left_out))
    }

    /// Renders the clip at `path`, with every core, and writes its hash into the manifest. Frames of earlier runs are not
    /// rendered again. Does nothing to a clip that was rendered from the same genomes with the same look.
    /// Errors: A sentence. Frames that are finished are kept, also if the job is cancelled.
    pub(crate) fn render(&self, path: &ClipPath, is_draft: bool, progress: &Progress) -> Result<Value, String> {
        let sentence = |fatal: Fatal| fatal.in_words();
        let manifest = open::manifest(&self.folder).map_err(sentence)?;
        let look = look(Form { size: manifest.size, fps: manifest.fps }, is_draft);
        let selection = self.select(&manifest, Some(&HashSet::from([path.clone()])), &look)?;
        let Some(plan) = selection.clips.first() else {
            let why = selection.left_out.first().map(|skipped| skipped.reason.clone());
            return Err(why.unwrap_or_else(|| format!("the flock has no clip `{path}` any more")));
        };
        let threads = machine::frames_at_once(machine::cores(), selection.bytes).map_err(sentence)?;
        progress.log(&format!("{}: {} frames", words(&plan.role), plan.frames));
        let of_hashes: Mutex<Result<(), String>> = Mutex::new(Ok(()));
        let finished = |_: &ClipPlan, _| {
            let written = hashes::write_hashes(&self.folder).map_err(|fatal| fatal.in_words());
            *locked(&of_hashes) = written;
        };
        let made = with_flag(progress, |stop| {
            let follower = Follower { progress, stop };
            let stop = Arc::clone(stop);
            let options = RunOptions { threads, keep_frames: false, stop, part: Part::Whole, shows_progress: false };
            make_watched([plan], &look, &self.folder, &options, &finished, &follower)
        });
        let made = made.map_err(|error| chain(&error))?;
        of_hashes.into_inner().unwrap_or_else(PoisonError::into_inner)?;
        match made.outcomes.first() {
            Some(Outcome::Made(hash) | Outcome::UpToDate(hash)) => {
                Ok(json!({ "clip": path, "frames": made.frames, "hash": hash.to_string() }))
            }
            Some(Outcome::Busy) => Err("another process renders it".to_owned()),
            Some(Outcome::Rendered | Outcome::Unfinished) | None => {
                Err("it was stopped; the next run goes on with its finished frames".to_owned())
            }
        }
    }

    /// The clips at `paths`, or those that are missing.
    fn select(&self, manifest: &Manifest, paths: Option<&HashSet<ClipPath>>, look: &Look) -> Result<Selection, String> {
        let request = Request { sheep: &[], scope: paths.map_or(Scope::Missing, Scope::Listed) };
        let selection = Selection::new(&self.folder, manifest, &request, look, &Backend::default());
        selection.map_err(|fatal| fatal.in_words())
    }
}

/// Reports to a job how many frames are rendered; holds the renderer while the job is held, and stops it between two frames
/// once the job is cancelled.
struct Follower<'a> {
    progress: &'a Progress,
    stop: &'a AtomicBool,
}

impl Watch for Follower<'_> {
    fn hold(&self) {
        self.progress.wait_if_paused();
        self.stop.fetch_or(self.progress.is_cancelled(), Ordering::Relaxed);
    }

    fn rendered(&self, done: u64, of: u64) {
        self.progress.set(done, of);
        if done == of {
            self.progress.log("all frames are there; they are encoded");
        }
    }
}

/// The clip of `role`, for people.
fn words(role: &ClipRole) -> String {
    match role {
        ClipRole::Loop(id) => format!("the loop of {id}"),
        ClipRole::Transition(from, to) => format!("the transition from {from} to {to}"),
    }
}

/// The clip of `role`, for the page.
fn about(role: &ClipRole) -> Value {
    match role {
        ClipRole::Loop(id) => json!({ "sheep": id }),
        ClipRole::Transition(from, to) => json!({ "from": from, "to": to }),
    }
}
