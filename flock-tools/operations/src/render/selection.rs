//! The selection of a flock's clips to render.
//!
//! Owns the choice: which clips are missing or were rendered from something else, which of them can be rendered, and why the
//! others cannot: they are left out, whatever is wrong with their genomes. Never renders and never decodes a clip: `dreams check` judges it. A clip that the tools did not render, or
//! did not leave so, is the artist's own and counts as made.
//!
//! Start at [`Selection::new`].

use std::collections::{HashMap, HashSet};
use std::error::Error;
use std::path::Path;

use flame::Backend;
use flame::genome::Reasons;
use flock::{Clip, ClipPath, FILE_NAME, Manifest, Sheep, SheepId};
use timing::FrameCount;

use super::clip_job::{hash_of, recorded};
use super::plan::{ClipPlan, ClipRole, Look, SheepMotion};
use crate::flock_folder::ids;
use crate::program::reasons::{reasons_of, serialize};
use crate::program::{Exit, Fatal, chain};
use crate::species;

/// The clips to render, and the missing ones that cannot be rendered.
pub struct Selection {
    /// Loops first, in the order of the manifest.
    pub clips: Vec<ClipPlan>,
    /// Those of them that are there, rendered from another recipe.
    pub changed: HashSet<ClipPath>,
    /// Clips that cannot be rendered: missing ones, and those whose genome has become unusable since.
    pub left_out: Vec<SkippedClip>,
    /// Most memory that a frame takes, in bytes.
    pub bytes: u64,
}

/// A clip that cannot be rendered.
#[derive(Debug, serde::Serialize)]
pub struct SkippedClip {
    /// Which.
    pub clip: ClipPath,
    /// Whether an older one is there.
    #[serde(skip)]
    pub is_there: bool,
    /// The status of a command that was asked for it.
    #[serde(skip)]
    pub exit: Exit,
    /// Why, for people.
    pub reason: String,
    /// What a genome of it asks for that is not drawn.
    #[serde(skip_serializing_if = "Reasons::is_empty", serialize_with = "serialize")]
    pub reasons: Reasons,
}

/// Why a clip cannot be rendered.
#[derive(Clone)]
struct Obstacle {
    reason: String,
    reasons: Reasons,
    exit: Exit,
    /// Whether a genome is there and cannot be used. A clip that was rendered from it is out of date, perhaps.
    is_of_genome: bool,
}

/// The clips that are asked for.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// The loops of these sheep and the transitions at them; all clips if there are none.
    pub sheep: &'a [SheepId],
    /// Which of their clips.
    pub scope: Scope<'a>,
}

/// Which clips are selected.
#[derive(Clone, Copy)]
pub enum Scope<'a> {
    /// All, those that are there too.
    All,
    /// Those that are not there, and those that the tools rendered from another recipe.
    Changed,
    /// Just these, those that are there too.
    Listed(&'a HashSet<ClipPath>),
    /// Those that are not there.
    Missing,
}

/// A sheep that was asked for and is not there.
#[derive(Debug, thiserror::Error)]
#[error("the flock `{flock}` has no sheep `{id}`")]
struct UnknownSheep {
    flock: String,
    id: SheepId,
}

/// The genomes of the flock, each read once.
struct Genomes<'a> {
    folder: &'a Path,
    look: &'a Look,
    backend: &'a Backend,
    /// The first sheep of each id counts.
    sheep: HashMap<&'a SheepId, &'a Sheep>,
    /// The length of the turn of a sheep without a loop.
    usual: FrameCount,
    read: HashMap<&'a SheepId, SheepMotion>,
    /// Those that cannot be used.
    refused: HashMap<&'a SheepId, Obstacle>,
}

impl Selection {
    /// The clips of `request` in the flock in `folder`, whose manifest is `manifest`, for the given `look`, drawn by
    /// `backend`.
    /// A genome that is missing, torn or not drawn leaves out its own clips alone.
    /// Errors: [`Fatal`] if a sheep is not in the flock.
    pub fn new(
        folder: &Path,
        manifest: &Manifest,
        request: &Request<'_>,
        look: &Look,
        backend: &Backend,
    ) -> Result<Self, Fatal> {
        let mut genomes = Genomes::new(folder, manifest, look, backend);
        if let Some(id) = request.sheep.iter().find(|id| !genomes.sheep.contains_key(id)) {
            let (flock, id) = (manifest.name.clone(), id.clone());
            let hint = ids::unknown(&id, manifest);
            return Err(Fatal::new(Exit::Malformed, UnknownSheep { flock, id }).hint(hint));
        }
        let picked = |id: &SheepId| request.sheep.is_empty() || request.sheep.contains(id);
        let mut selection = Self { clips: Vec::new(), changed: HashSet::new(), left_out: Vec::new(), bytes: 0 };
        let mut paths = Paths::of(manifest);
        for (role, clip) in shown(manifest) {
            let is_picked = match &role {
                ClipRole::Loop(id) => picked(id),
                ClipRole::Transition(from, to) => picked(from) || picked(to),
            };
            let is_there = clip.path.inside(folder).exists();
            let record = recorded(folder, &clip.path).filter(|_| is_there);
            let is_in_scope = match request.scope {
                Scope::All => true,
                Scope::Changed => !is_there || record.is_some(),
                Scope::Listed(paths) => paths.contains(&clip.path),
                Scope::Missing => !is_there,
            };
            if !is_picked || !is_in_scope {
                continue;
            }
            let refused = paths.refuse(&clip.path);
            let planned = refused.map_or_else(|| genomes.plan(&role, clip), Err);
            let (plan, bytes) = match planned {
                Ok(planned) => planned,
                Err(Obstacle { reason, reasons, exit, is_of_genome }) => {
                    // The genome of one that is there may have been taken away on purpose.
                    if !is_there || is_of_genome || matches!(request.scope, Scope::All) {
                        let clip = clip.path.clone();
                        selection.left_out.push(SkippedClip { clip, is_there, exit, reason, reasons });
                    }
                    continue;
                }
            };
            let is_changed = record.is_some_and(|(recipe, _)| recipe != plan.recipe);
            if is_there && matches!(request.scope, Scope::Changed) {
                let as_left = |(_, hash)| hash_of(&clip.path.inside(folder)).is_ok_and(|found| found == hash);
                if !is_changed || !record.is_some_and(as_left) {
                    continue;
                }
            }
            if is_changed {
                selection.changed.insert(clip.path.clone());
            }
            selection.bytes = selection.bytes.max(bytes);
            selection.clips.push(plan);
        }
        Ok(selection)
    }

    /// The status of a command that has rendered all the others: the gravest of those left out.
    pub fn exit(&self) -> Exit {
        self.left_out.iter().map(|one| one.exit).max_by_key(|&exit| exit as u8).unwrap_or(Exit::Fine)
    }
}

impl SkippedClip {
    /// Says for people what becomes of the clip, and why.
    pub fn in_words(&self) -> String {
        let Self { clip, is_there, reason, .. } = self;
        let state = if *is_there { "stays as it is" } else { "is missing" };
        format!("`{clip}` {state} and cannot be rendered: {reason}")
    }
}

impl From<String> for Obstacle {
    fn from(reason: String) -> Self {
        Self { reason, reasons: Reasons::default(), exit: Exit::No, is_of_genome: false }
    }
}

impl Obstacle {
    /// The genome in the file `file` of the sheep `id` cannot be used.
    fn of_genome(file: &ClipPath, id: &SheepId, exit: Exit, source: &(dyn Error + 'static)) -> Self {
        let (reasons, exit) = match reasons_of(source) {
            Some(reasons) => (reasons.clone(), Exit::No),
            None => (Reasons::default(), exit),
        };
        let reason = format!("genome `{file}` of sheep `{id}` cannot be drawn: {}", chain(source));
        Self { reason, reasons, exit, is_of_genome: true }
    }
}

/// Every clip of the flock and its role, loops first. Of duplicates the first counts, as in the walk.
pub fn shown(manifest: &Manifest) -> impl Iterator<Item = (ClipRole, &Clip)> {
    let mut sheep = HashSet::new();
    let mut pairs = HashSet::new();
    let loops = manifest.sheep.iter().filter(move |it| sheep.insert(&it.id));
    let loops = loops.filter_map(|it| Some((ClipRole::Loop(it.id.clone()), it.clip.as_ref()?)));
    let transitions = manifest.transitions.iter().filter(move |it| pairs.insert((&it.from, &it.to)));
    loops.chain(transitions.map(|it| (ClipRole::Transition(it.from.clone(), it.to.clone()), &it.clip)))
}

/// The paths where no clip may be written.
struct Paths<'a> {
    /// The number of loops and transitions that have the clip.
    serves: HashMap<&'a ClipPath, usize>,
    genomes: HashSet<&'a ClipPath>,
}

impl<'a> Paths<'a> {
    fn of(manifest: &'a Manifest) -> Self {
        let mut serves = HashMap::new();
        for (_, clip) in shown(manifest) {
            *serves.entry(&clip.path).or_insert(0) += 1;
        }
        Self { serves, genomes: manifest.sheep.iter().filter_map(|sheep| sheep.genome.as_ref()).collect() }
    }

    /// Why nothing is rendered to `path`.
    fn refuse(&mut self, path: &ClipPath) -> Option<Obstacle> {
        if path.as_str() == FILE_NAME || self.genomes.contains(path) {
            return Some("its path is that of the manifest or of a genome".to_owned().into());
        }
        (self.serves.get(path) > Some(&1)).then(|| "more than one loop or transition has it".to_owned().into())
    }
}

impl<'a> Genomes<'a> {
    fn new(folder: &'a Path, manifest: &'a Manifest, look: &'a Look, backend: &'a Backend) -> Self {
        let mut sheep = HashMap::new();
        for one in &manifest.sheep {
            sheep.entry(&one.id).or_insert(one);
        }
        Self {
            folder,
            look,
            backend,
            sheep,
            usual: usual_turn(manifest),
            read: HashMap::new(),
            refused: HashMap::new(),
        }
    }

    /// The plan of a clip and the memory that a frame of it takes, in bytes; or why there is none.
    fn plan(&mut self, role: &ClipRole, clip: &Clip) -> Result<(ClipPlan, u64), Obstacle> {
        let (ids, path, frames) = (role.sheep(), clip.path.clone(), clip.frames);
        for id in ids {
            self.read(id)?;
        }
        let ends = ids.map(|id| &self.read[id]);
        let plan = match role.clone() {
            ClipRole::Loop(id) => ClipPlan::of_loop(id, ends[0], path, frames, self.look),
            ClipRole::Transition(from, to) => ClipPlan::of_transition([from, to], ends, path, frames, self.look),
        };
        let demand =
            plan.demand(self.look).map_err(|error| Obstacle { exit: Exit::Malformed, ..chain(&error).into() })?;
        Ok((plan, demand.bytes))
    }

    /// Reads the genome of the sheep `id`, once.
    /// Errors: The obstacle if it has none, or one that is missing, torn or not drawn.
    fn read(&mut self, id: &SheepId) -> Result<(), Obstacle> {
        if self.read.contains_key(id) {
            return Ok(());
        }
        let Some((&id, &sheep)) = self.sheep.get_key_value(id) else {
            return Err(format!("sheep `{id}` is not in the flock").into());
        };
        let Some(file) = &sheep.genome else { return Err(format!("sheep `{id}` has no genome").into()) };
        if let Some(obstacle) = self.refused.get(id) {
            return Err(obstacle.clone());
        }
        match self.motion(sheep, file) {
            Ok(motion) => drop(self.read.insert(id, motion)),
            Err((exit, source)) => {
                let obstacle = Obstacle::of_genome(file, id, exit, &*source);
                self.refused.insert(id, obstacle.clone());
                return Err(obstacle);
            }
        }
        Ok(())
    }

    /// The motion of `sheep`, whose genome is in the file `file`.
    fn motion(&self, sheep: &Sheep, file: &ClipPath) -> Result<SheepMotion, (Exit, Box<dyn Error>)> {
        let genome = species::read(&file.inside(self.folder), self.backend).map_err(|why| (why.exit, why.source))?;
        let motion = SheepMotion::new(genome, sheep.clip.as_ref().map_or(self.usual, |clip| clip.frames));
        motion.demand(self.look).map_err(|error| (Exit::Malformed, error.into()))?;
        Ok(motion)
    }
}

/// The frames in which a sheep without a loop turns once, so that transitions to it and from it meet in speed: the most
/// frequent length of loops in the flock, the longer of two; without any loop, twice the longest transition.
pub fn usual_turn(manifest: &Manifest) -> FrameCount {
    let mut counts: HashMap<u32, usize> = HashMap::new();
    for clip in manifest.sheep.iter().filter_map(|sheep| sheep.clip.as_ref()) {
        *counts.entry(clip.frames.0).or_insert(0) += 1;
    }
    let longest = manifest.transitions.iter().map(|transition| transition.clip.frames.0).max();
    let usual = counts.into_iter().max_by_key(|&(frames, count)| (count, frames)).map(|(frames, _)| frames);
    FrameCount(usual.unwrap_or(2 * longest.unwrap_or(1)))
}

/// The length of the transition in the middle, or the one that `dreams link` gives.
pub fn usual_frames(manifest: &Manifest) -> u32 {
    let mut frames: Vec<u32> = manifest.transitions.iter().map(|transition| transition.clip.frames.0).collect();
    frames.sort_unstable();
    frames.get(frames.len() / 2).copied().unwrap_or(flock::paths::TRANSITION_FRAMES)
}
