//! `dreams elect POOL DIR`: a flock of a pool's best.
//!
//! Owns the command: the choice is that of the package `breeding`, the transitions are those of `edition.rs`. With --write
//! it makes the flock, or brings one up to date that it made before. Never renders: `dreams render` does.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

use ::breeding::{Ballot, Born, Census, Event, Folder, Id, Pool, Reason, Sheep as BredSheep, elect};
use flock::Draft;
use flock::{Clip, ClipPath, Edit, FILE_NAME, MAX_FRAMES, Sheep, SheepId, Transition};
use operations::breeding as pools;
use operations::breeding::{genome, open_for_changes, today};
use operations::flock_folder::paths;
use operations::program::{Exit, Fatal, print};
use operations::render::estimate;
use operations::render::machine;
use operations::render::plan::{ClipPlan, Look, SheepMotion};
use timing::{FrameCount, Rate};
use video::Form;

use super::edition::{Bred, Member, links};
use crate::arguments;
use crate::curate::{add, link, new};

/// Bits of a second of a clip, by what was measured of the demo: 15 to 23 million.
const BITS_PER_SECOND: f64 = 19e6;

/// Make a flock of a pool's best sheep
///
/// First come the sheep that the artist keeps, then those with the best ratings; of what is alike, fewer. At most four
/// are of one niche, at most 15 % of one family, and at least 10 % are newcomers. Every sheep gets two transitions to it
/// and two from it: of sheep that look alike, and of relatives unless others are four times as like. A flock that is
/// there already is brought up to date: sheep that are no longer elected leave it, newcomers are linked, and so are those
/// that lose transitions by it. Without --write it only tells what would be done, and the cost of rendering.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the flock is as elected, or would be
  1  the folder is not empty and has no flock, or another program changes the pool
  2  the command line, the pool, a genome or the flock is wrong
  3  a file could not be read or written")]
pub struct Args {
    /// Folder of the pool
    pool: PathBuf,
    /// Folder of the flock; made where it is missing
    dir: PathBuf,
    /// How many sheep
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u16).range(1..))]
    sheep: u16,
    /// How many of them no other edition has
    #[arg(long, value_name = "K", default_value_t = 0)]
    unique: u16,
    /// The unit that the edition is for; the last one of the same name is replaced
    #[arg(long = "for", value_name = "UNIT", default_value = "flock")]
    edition: String,
    /// Width and height of a new flock, in pixels, both even
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = arguments::size)]
    size: (u32, u32),
    /// Frames per second of a new flock
    #[arg(long, value_name = "N[/D]", default_value = "30", value_parser = arguments::rate)]
    fps: Rate,
    #[arg(long, value_name = "N", default_value_t = add::FRAMES)]
    #[arg(help = "Frames of a loop", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_FRAMES)))]
    loop_frames: u32,
    #[arg(long, value_name = "N", default_value_t = link::FRAMES)]
    #[arg(help = "Frames of a transition", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_FRAMES)))]
    transition_frames: u32,
    /// Make the flock
    #[arg(long)]
    write: bool,
    /// Only tell what would be done: the default
    #[arg(long, conflicts_with = "write")]
    dry_run: bool,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// A pool without sheep that may be elected.
#[derive(Debug, thiserror::Error)]
#[error("pool `{pool}` has no sheep that may be elected")]
struct NobodyError {
    pool: PathBuf,
}

/// An elected sheep in the answer.
#[derive(serde::Serialize)]
struct ElectedAnswer {
    id: Id,
    why: &'static str,
    rating: f64,
    /// The rating less what its likeness to the ones before took.
    worth: f64,
    /// Whether the flock had it already.
    there: bool,
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct Answer {
    changed: bool,
    sheep: Vec<ElectedAnswer>,
    /// Sheep that leave the flock.
    left: Vec<String>,
    /// New transitions.
    transitions: Vec<[SheepId; 2]>,
    /// Clips to render.
    clips: usize,
    frames: u64,
    cpu_hours: f64,
    /// With all cores of this machine.
    hours: f64,
    gigabytes: f64,
}

/// What is to be done.
struct Plan<'a> {
    chosen: Vec<(ElectedAnswer, &'a Born)>,
    left: BTreeSet<SheepId>,
    transitions: Vec<(SheepId, SheepId)>,
    edit: Edit,
    draft: Option<Draft>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let mut folder = if args.write { open_for_changes(&args.pool)? } else { pools::open(&args.pool)? };
    let pool = folder.pool().clone();
    let ballot = Ballot { edition: args.edition.clone(), sheep: args.sheep.into(), unique: args.unique.into() };
    let census = Census::of(&pool, today());
    let elected = elect(&pool, &census, &ballot);
    let unique = elected.iter().filter(|elected| elected.reason == Reason::Unique).count();
    let chosen: Vec<(ElectedAnswer, &BredSheep)> = elected
        .iter()
        .filter_map(|elected| {
            let why = match elected.reason {
                Reason::Pinned => "kept",
                Reason::Rated => "rated",
                Reason::Unique => "unique",
            };
            let (id, rating, worth) = (elected.id, elected.rating, elected.worth);
            Some((ElectedAnswer { id, why, rating, worth, there: false }, pool.get(id)?))
        })
        .collect();
    if chosen.is_empty() {
        return Err(Fatal::new(Exit::Malformed, NobodyError { pool: args.pool.clone() }));
    }
    let plan = args.plan(&pool, chosen, &census)?;
    let answer = args.cost(&folder, &plan)?;
    if args.write {
        let ids = plan.chosen.iter().map(|(elected, _)| elected.id).collect();
        args.write(&folder, plan)?;
        let elected = Event::Elected { edition: args.edition.clone(), ids, unique };
        folder.tell(today(), vec![elected])?;
    }
    args.tell(&answer)
}

impl Args {
    fn plan<'a>(
        &self,
        pool: &Pool,
        chosen: Vec<(ElectedAnswer, &'a BredSheep)>,
        census: &Census,
    ) -> Result<Plan<'a>, Fatal> {
        let (edit, draft) = if self.dir.join(FILE_NAME).exists() {
            let draft = Draft::lock(&self.dir)?;
            (Edit::parse(draft.edit.text(), &self.dir.join(FILE_NAME))?, Some(draft))
        } else {
            (Edit::blank(&new::name_of(&self.dir), self.size, self.fps), None)
        };
        let manifest = edit.manifest();
        let wanted: BTreeSet<String> = chosen.iter().map(|(elected, _)| elected.id.to_string()).collect();
        // Sheep that the artist put in from elsewhere are no sheep of the pool, and stay.
        let is_of_pool = |id: &SheepId| id.as_str().parse().is_ok_and(|id: Id| pool.get(id).is_some());
        let (own, others): (Vec<_>, Vec<_>) = manifest.sheep.iter().partition(|sheep| !is_of_pool(&sheep.id));
        let left = others.iter().map(|sheep| &sheep.id).filter(|id| !wanted.contains(id.as_str())).cloned().collect();
        let has = |id: Id| manifest.sheep.iter().any(|sheep| sheep.id.as_str() == id.to_string());
        let bred = |(elected, sheep): &(ElectedAnswer, &'a BredSheep)| Member {
            id: sheep_id(elected.id),
            bred: Some(Bred { born: &sheep.born, point: census.point(&sheep.born.figures) }),
            is_there: has(elected.id),
        };
        // What cannot be rendered is not linked, nor what the artist has left without transitions.
        let is_linked = |id: &SheepId| manifest.transitions.iter().any(|it| it.from == *id || it.to == *id);
        let own = own.iter().filter(|sheep| sheep.genome.is_some() && is_linked(&sheep.id));
        let own = own.map(|sheep| Member { id: sheep.id.clone(), bred: None, is_there: true });
        let members: Vec<Member> = chosen.iter().map(bred).chain(own).collect();
        let there = manifest.transitions.iter().map(|it| (it.from.clone(), it.to.clone())).collect();
        let transitions = links(&members, &there);
        let there = |elected: ElectedAnswer| ElectedAnswer { there: has(elected.id), ..elected };
        let chosen = chosen.into_iter().map(|(elected, sheep)| (there(elected), &sheep.born)).collect();
        Ok(Plan { chosen, left, transitions, edit, draft })
    }

    /// What is to be rendered, and what that takes.
    fn cost(&self, folder: &Folder, plan: &Plan) -> Result<Answer, Fatal> {
        let form = Form { size: plan.edit.manifest().size, fps: plan.edit.manifest().fps };
        let look = Look::of_genomes(form);
        let motion = |genome| SheepMotion::new(genome, FrameCount(self.loop_frames));
        let mut motions: BTreeMap<SheepId, SheepMotion> = BTreeMap::new();
        for (elected, born) in &plan.chosen {
            motions.insert(sheep_id(elected.id), motion(genome(folder, born)?));
        }
        for sheep in &plan.edit.manifest().sheep {
            let is_linked = plan.transitions.iter().any(|(from, to)| [from, to].contains(&&sheep.id));
            if let Some(path) = sheep.genome.as_ref().filter(|_| is_linked && !motions.contains_key(&sheep.id)) {
                motions.insert(sheep.id.clone(), motion(pools::read(path.inside(&self.dir))?));
            }
        }
        let mut clips = Vec::new();
        for (elected, _) in plan.chosen.iter().filter(|(elected, _)| !elected.there) {
            let id = sheep_id(elected.id);
            let path = paths::of_loop(&id, paths::CLIP);
            let motion = &motions[&id];
            clips.push(ClipPlan::of_loop(id, motion, path, FrameCount(self.loop_frames), &look));
        }
        for (from, to) in &plan.transitions {
            let path = paths::of_transition(from, to, paths::CLIP);
            let ends = [&motions[from], &motions[to]];
            let ids = [from.clone(), to.clone()];
            clips.push(ClipPlan::of_transition(ids, ends, path, FrameCount(self.transition_frames), &look));
        }
        let frames: u64 = clips.iter().map(|clip| u64::from(clip.frames.0)).sum();
        let seconds = estimate::cpu_seconds(clips.iter().map(|clip| (clip, clip.frames.0)), &look);
        let cpu_hours = seconds.map_err(|error| Fatal::new(Exit::Malformed, error))? / 3600.0;
        let cores = machine::cores().get() as f64;
        let clip_seconds = frames as f64 * form.fps.den() as f64 / form.fps.num() as f64;
        let sheep = plan.chosen.iter().map(|(elected, _)| ElectedAnswer { ..*elected });
        Ok(Answer {
            changed: self.write,
            sheep: sheep.collect(),
            left: plan.left.iter().map(ToString::to_string).collect(),
            transitions: plan.transitions.iter().map(|(from, to)| [from.clone(), to.clone()]).collect(),
            clips: clips.len(),
            frames,
            cpu_hours,
            hours: cpu_hours / cores,
            gigabytes: clip_seconds * BITS_PER_SECOND / 8e9,
        })
    }

    /// Makes the flock, or brings it up to date. The manifest comes last.
    fn write(&self, folder: &Folder, plan: Plan) -> Result<(), Fatal> {
        let Plan { chosen, left, transitions, mut edit, draft } = plan;
        let broken = |error| Fatal::new(Exit::Malformed, error);
        let added: Vec<&Born> = chosen.iter().filter(|(elected, _)| !elected.there).map(|(_, born)| *born).collect();
        for born in &added {
            let id = sheep_id(born.id);
            let clip =
                Clip { path: paths::of_loop(&id, paths::CLIP), frames: FrameCount(self.loop_frames), hash: None };
            let genome = Some(paths::genome(&id, &born.species));
            edit.add_sheep(Sheep { id, clip: Some(clip), genome, want: 1.0, repeat: 1 }).map_err(broken)?;
        }
        for (from, to) in transitions {
            let path = paths::of_transition(&from, &to, paths::CLIP);
            let clip = Clip { path, frames: FrameCount(self.transition_frames), hash: None };
            edit.add_transition(Transition { from, to, clip, weight: 1.0 }).map_err(broken)?;
        }
        edit.drop_all(&left).map_err(broken)?;
        let fill = || {
            added.iter().try_for_each(|born| {
                let (from, to) =
                    (folder.genome(born), paths::genome(&sheep_id(born.id), &born.species).inside(&self.dir));
                let parent = to.parent().unwrap_or(&self.dir);
                let copied = fs::create_dir_all(parent).and_then(|()| durable::copy(&from, &to));
                copied.map_err(|source| Fatal::write(&to, source))
            })
        };
        match draft {
            None => new::start(&self.dir, &format!("{}{}", new::HEADING, edit.text()), fill),
            Some(mut draft) => {
                let places: Vec<ClipPath> =
                    added.iter().map(|born| paths::genome(&sheep_id(born.id), &born.species)).collect();
                draft.writes(places.iter().map(ClipPath::as_str));
                fill()?;
                draft.edit = edit;
                Ok(draft.save()?)
            }
        }
    }

    fn tell(&self, answer: &Answer) -> Result<Exit, Fatal> {
        if self.json {
            print::json(answer)?;
            return Ok(Exit::Fine);
        }
        let sheep = |elected: &ElectedAnswer| {
            let there = if elected.there { ", there already" } else { "" };
            format!("{} rating {:.2}, worth {:.2}, {}{there}", elected.id, elected.rating, elected.worth, elected.why)
        };
        let left = answer.left.iter().map(|id| format!("{id} leaves the flock"));
        let transition = |[from, to]: &[SheepId; 2]| format!("{from} to {to}");
        let Answer { clips, frames, cpu_hours, hours, gigabytes, .. } = answer;
        let sum = format!(
            "{} sheep, {} new transitions; {clips} clips to render: {frames} frames, {cpu_hours:.3} CPU hours, {hours:.3} \
             hours on this machine, about {gigabytes:.3} GB",
            answer.sheep.len(),
            answer.transitions.len()
        );
        print::lines(
            answer.sheep.iter().map(sheep).chain(left).chain(answer.transitions.iter().map(transition)).chain([sum]),
        )?;
        if !self.write {
            print::note("note: nothing was written; --write makes the flock");
        }
        Ok(Exit::Fine)
    }
}

fn sheep_id(id: Id) -> SheepId {
    SheepId::new(&id.to_string()).expect("the id of a pool's sheep has digits, letters, a dot and a hyphen")
}
