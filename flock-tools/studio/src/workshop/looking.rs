//! What requests read of the studio: the flock, its credits, the genome of a sheep, the whole state.
//!
//! Owns where each is found. Nothing here changes anything but what is remembered.
//!
//! Start at [`Workshop::state`].

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use flock::{Clip, Flock, Manifest, Measure, SheepId};
use operations::check;
use operations::credits::FlockCredits;
use operations::program::now;

use super::Workshop;
use crate::answer::{Problem, fatal};
use crate::document::{Revision, Snapshot};
use crate::jobs::{Job, Kind, State as JobState};
use crate::lock::locked;
use crate::media::RENDER_KEY;
use crate::store::clip_states::ClipStates;
use crate::store::stock::Stock;
use crate::views::state::{Capabilities, Head, PoolState, Sources, State, flock_part};
use crate::views::state_delta::StateAnswer;
use crate::views::walk::Walked;

impl Workshop {
    /// The document now.
    pub(crate) fn snapshot(&self) -> Snapshot {
        locked(&self.document).snapshot()
    }

    /// The flock as it is, with its revision.
    pub(crate) fn flock(&self) -> (Revision, Arc<Flock>) {
        let revision = locked(&self.document).revision().clone();
        let mut known = locked(&self.known_flock);
        if let Some((of, flock)) = known.as_ref().filter(|(of, _)| *of == revision) {
            return (of.clone(), Arc::clone(flock));
        }
        let Snapshot { revision, manifest, .. } = self.snapshot();
        let flock = Arc::new(Flock::new(manifest));
        *known = Some((revision.clone(), Arc::clone(&flock)));
        (revision, flock)
    }

    /// The credits of everything in the flock.
    /// Errors: If `credits.toml` is malformed.
    pub(crate) fn credits(&self, manifest: &Manifest) -> Result<FlockCredits, Problem> {
        let known = |genome: &flock::ClipPath| self.stock.genomes.facts(&genome.inside(&self.folder)).lineage.clone();
        FlockCredits::with_lineages(&self.folder, manifest, known).map_err(fatal)
    }

    /// The genome of a sheep of the flock, its pool, an archive or a brood.
    pub(crate) fn genome_of(&self, id: &str) -> Option<PathBuf> {
        let (_, flock) = self.flock();
        let own = flock.manifest().sheep.iter().find(|sheep| sheep.id.as_str() == id);
        let own = own.and_then(|sheep| sheep.genome.as_ref()).map(|genome| genome.inside(&self.folder));
        let dead = || self.stock.paths().remove(id);
        own.or_else(|| self.stock.candidate_path(id)).or_else(dead).filter(|path| path.is_file())
    }

    /// The genomes of all sheep of the flock, of its pool with the dead, and of an archive.
    pub(crate) fn genomes_by_id(&self) -> HashMap<String, PathBuf> {
        let mut all = self.stock.paths();
        let (_, flock) = self.flock();
        let own = flock.manifest().sheep.iter().filter_map(|sheep| Some((sheep, sheep.genome.as_ref()?)));
        all.extend(own.map(|(sheep, genome)| (sheep.id.as_str().to_owned(), genome.inside(&self.folder))));
        all
    }

    /// The state of clips beside their files.
    pub(crate) fn clip_states(&self) -> ClipStates {
        let jobs = self.queue.jobs();
        let rendered = jobs.iter().filter(|job| job.kind == Kind::Render && !job.state.is_over());
        let clip = |job: &Job| {
            let path = flock::ClipPath::new(job.key.as_deref()?.strip_prefix(RENDER_KEY)?).ok()?;
            let part = (job.state != JobState::Queued).then(|| job.done as f64 / job.of.max(1) as f64);
            Some((path, part))
        };
        ClipStates { jobs: rendered.filter_map(clip).collect(), damaged: locked(&self.checked).damaged() }
    }

    /// The whole state; `by` is what wants are compared with.
    /// Errors: If `credits.toml` is malformed.
    pub(crate) fn state(&self, by: Measure) -> Result<State, Problem> {
        let snapshot = self.snapshot();
        let (revision, flock) = self.flock();
        let manifest = flock.manifest();
        let credits = self.credits(manifest)?;
        let clips = self.clip_states();
        locked(&self.places).update(&flock);
        let mut faults = locked(&self.checked).faults(&flock, &revision);
        let Stock { genomes, candidates, .. } = &*self.stock;
        let undrawn = check::genomes::undrawn_by(&self.folder, manifest, |path| {
            let facts = genomes.facts(path);
            facts.unusable.clone().map_or_else(|| Ok(facts.undrawn.clone()), Err)
        });
        faults.extend(check::genomes::faults(&self.folder, manifest, &undrawn));
        let (all, votes, marks) = (candidates.all(genomes), candidates.votes(genomes), candidates.marks(genomes));
        let part = {
            let (joins, places) = (locked(&self.joins), locked(&self.places));
            let sources = Sources {
                folder: &self.folder,
                flock: &flock,
                by,
                genomes,
                credits: &credits,
                clips: &clips,
                joins: &joins,
                places: &places,
                votes: &votes,
                marks: &marks,
                notes: &snapshot.notes,
                keys: self.keys(manifest),
            };
            flock_part(&sources, &all, faults)
        };
        let Snapshot { undo, redo, .. } = snapshot;
        let fps = manifest.fps;
        let pool = candidates.folder().ok().flatten();
        let head = Head {
            revision,
            name: manifest.name.clone(),
            fps: [fps.num(), fps.den()],
            size: [manifest.size.0, manifest.size.1],
            by,
            now_ms: now::since_1970_ms(),
            undo,
            redo,
            jobs: self.queue.jobs(),
            paused: self.queue.is_paused(),
            pool: pool.map(|folder| PoolState { name: folder.pool().settings.name.clone() }),
            capabilities: Capabilities { gpu: false },
        };
        Ok(State { head, part })
    }

    /// The state for a page that has the one of the tag `since`.
    /// Errors: As of [`Workshop::state`].
    pub(crate) fn told(&self, by: Measure, since: Option<&str>) -> Result<StateAnswer, Problem> {
        let state = self.state(by)?;
        Ok(locked(&self.sent).answer(state, since))
    }

    /// Puts the keys of clips and previews into a walk.
    pub(crate) fn find_media(&self, walked: &mut Walked) {
        let (_, flock) = self.flock();
        let manifest = flock.manifest();
        let keys = self.keys(manifest);
        let loops: HashMap<&SheepId, &Clip> =
            manifest.sheep.iter().filter_map(|sheep| Some((&sheep.id, sheep.clip.as_ref()?))).collect();
        let transitions: HashMap<(&SheepId, &SheepId), &Clip> =
            manifest.transitions.iter().map(|own| ((&own.from, &own.to), &own.clip)).collect();
        // A walk plays the same clips again and again.
        let mut known: HashMap<&Clip, Option<String>> = HashMap::new();
        for own in &mut walked.clips {
            let clip = match (&own.sheep, &own.from, &own.to) {
                (Some(id), ..) => loops.get(id),
                (None, Some(from), Some(to)) => transitions.get(&(from, to)),
                (None, ..) => None,
            };
            let Some(clip) = clip else { continue };
            own.fragments = known.entry(clip).or_insert_with(|| keys.fragments(clip)).clone();
            if let (Some(from), Some(to), None) = (&own.from, &own.to, &own.fragments) {
                own.preview = keys.moving(from, to, own.frames);
            }
        }
    }
}
