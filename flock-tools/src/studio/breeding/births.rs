//! Broods that are made, and sheep of them that are accepted.
//!
//! Owns the jobs: the children of a brood on all cores, each told to the page as it is there; and the birth of accepted cells
//! in the pool, with their parents if it does not know them. The rules of a pool are those of the package `breeding`.
//!
//! Start at [`begin`].

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ::breeding::{Born, Brood, Folder, Id, Origin, Settings};
use ::studio::jobs::{Job, Kind, NewJob, Priority, Progress};
use flame::Backend;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde_json::{Value, json};
use species::{Genome, Lineage, Threads};

use super::broods::{BroodRecord, Cell, CellState};
use super::children::{Parent, Wish};
use crate::breeding::{nursery, open_for_changes, today};
use crate::program::chain;
use crate::species::{self as kinds, all, endings};
use crate::studio::requests::BreedRequest;
use crate::studio::workshop::{Workshop, locked};

/// Cells of a brood: as many as asked for, within these.
const CELLS: [usize; 2] = [2, 60];
const USUAL_CELLS: usize = 20;
/// The most parents of a brood.
const MOST_PARENTS: usize = 3;

/// Begins a brood: its record, and the job that makes it.
/// Errors: A sentence, if a parent has no genome or the record cannot be written.
pub(in crate::studio) fn begin(workshop: &Arc<Workshop>, request: &BreedRequest) -> Result<(Job, BroodRecord), String> {
    if request.parents.len() > MOST_PARENTS {
        return Err(format!("a brood has at most {MOST_PARENTS} parents, found {}", request.parents.len()));
    }
    let species = request.species.clone().filter(|_| request.parents.is_empty());
    if let Some(unknown) = species.as_deref().filter(|species| !endings().contains(species)) {
        return Err(format!("there is no species `{unknown}`: there are {}", endings().join(", ")));
    }
    let parents = request.parents.iter().map(|id| read_parent(workshop, id)).collect::<Result<Vec<_>, _>>()?;
    let named: Vec<(String, String)> = parents.iter().map(|own| (own.id.clone(), own.species.clone())).collect();
    let wish = Wish {
        strength: request.strength.unwrap_or(0.5),
        locks: request.locks.clone(),
        // Few enough digits that every reader of JSON holds it exactly.
        seed: request.seed.unwrap_or_else(|| rand::random::<u32>().into()),
    };
    let count = request.count.unwrap_or(USUAL_CELLS).clamp(CELLS[0].max(parents.len() + 1), CELLS[1]);
    let begun = locked(&workshop.stock.broods).begin(&named, species, wish, count, Workshop::now_ms());
    let brood = begun.map_err(|error| format!("cannot keep the brood: {error}"))?;
    Ok((queue(workshop, &brood), brood))
}

/// Queues the making of a brood.
pub(in crate::studio) fn queue(workshop: &Arc<Workshop>, brood: &BroodRecord) -> Job {
    let (id, shared) = (brood.id.clone(), Arc::downgrade(workshop));
    let new = NewJob {
        key: Some(format!("brood {id}")),
        ..NewJob::new(Priority::Interactive, Kind::Brood, format!("brood {id}"))
    };
    let work = move |progress: &Progress| {
        let workshop = shared.upgrade().ok_or("the studio has ended")?;
        make(&workshop, &id, progress)
    };
    workshop.queue.add_job(new, Box::new(work))
}

/// Makes the cells of a brood that wait.
fn make(workshop: &Arc<Workshop>, id: &str, progress: &Progress) -> Result<Value, String> {
    let brood = locked(&workshop.stock.broods).find(id).cloned().ok_or_else(|| format!("there is no brood `{id}`"))?;
    let parents = brood.parents.iter().map(|id| read_parent(workshop, id)).collect::<Result<Vec<_>, _>>()?;
    let species = all(&Backend::default());
    let waiting: Vec<(usize, &Cell)> = brood
        .cells
        .iter()
        .enumerate()
        .filter(|(_, cell)| matches!(cell.state, CellState::Queued | CellState::Running))
        .collect();
    let endings = endings();
    let of = waiting.len() as u64;
    let done = std::sync::atomic::AtomicU64::new(0);
    let make_one = |(at, cell): &(usize, &Cell)| {
        if progress.is_cancelled() {
            return Err("cancelled".to_owned());
        }
        let ending = brood.species.as_deref().unwrap_or(endings[at % endings.len()]);
        let child = brood.wish.child(&species, &parents, ending, *at as u64);
        let made = child.and_then(|child| {
            let lineage = Lineage {
                id: Some(cell.id.clone()),
                parents: child.parents.clone(),
                operator: Some(child.op.clone()),
                ..child.genome.lineage()
            };
            let path = locked(&workshop.stock.broods).genome(id, &cell.id, &child.species);
            let text = child.genome.with_lineage(&lineage).text();
            durable::write(&path, text.as_bytes()).map_err(|error| format!("cannot keep the genome: {error}"))?;
            let (op, parents, species) = (child.op, child.parents, child.species);
            Ok(Cell { op, parents, species, state: CellState::There, error: None, ..(*cell).clone() })
        });
        let cell = made.unwrap_or_else(|why| Cell { state: CellState::Failed, error: Some(why), ..(*cell).clone() });
        let kept = locked(&workshop.stock.broods).set(id, cell);
        progress.set(done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1, of);
        kept.map_err(|error| format!("cannot keep the brood: {error}"))
    };
    let threads = Threads::new(0).map_err(|error| error.to_string())?;
    threads.run(|| waiting.par_iter().try_for_each(make_one))?;
    Ok(json!({ "brood": id }))
}

/// The genome of a sheep of the flock, its pool, an archive or a brood, as a parent.
fn read_parent(workshop: &Workshop, id: &str) -> Result<Parent, String> {
    let path = workshop.genome_of(id).ok_or_else(|| format!("`{id}` has no genome"))?;
    let (genome, species) = read(&path)?;
    Ok(Parent { id: id.to_owned(), species, genome })
}

fn read(path: &Path) -> Result<(Box<dyn Genome>, String), String> {
    let refused = |why: kinds::Refused| format!("cannot use the genome `{}`: {}", path.display(), why.source);
    let text = kinds::text(path).map_err(refused)?;
    let genome = kinds::parse(path, &text, &Backend::default()).map_err(refused)?;
    Ok((genome, kinds::ending(path, &text).to_owned()))
}

/// Queues the birth of these cells in the pool, which is made if there is none.
pub(in crate::studio) fn queue_births(workshop: &Arc<Workshop>, cells: Vec<String>) -> Job {
    let shared = Arc::downgrade(workshop);
    let what = format!("{} into the pool", crate::program::print::count(cells.len(), "cell"));
    let work = move |progress: &Progress| {
        let workshop = shared.upgrade().ok_or("the studio has ended")?;
        let born = bear(&workshop, &cells, progress)?;
        workshop.tell_all();
        Ok(json!({ "born": born }))
    };
    workshop.queue.add_job(NewJob::new(Priority::Interactive, Kind::Brood, what), Box::new(work))
}

/// What is to be born: a genome, the ids of its parents as the studio knows them, its operator and its species.
struct Newborn {
    /// As the studio knows it.
    id: String,
    parents: Vec<String>,
    op: String,
    species: String,
    genome: Box<dyn Genome>,
}

/// Lets the cells be born in the pool, after those of their parents that it does not know. Returns their new ids.
fn bear(workshop: &Workshop, cells: &[String], progress: &Progress) -> Result<Vec<Id>, String> {
    let mut folder = pool_for_changes(&workshop.stock.candidates.pool)?;
    let mut newborns: Vec<Newborn> = Vec::new();
    for id in cells {
        let path = workshop.genome_of(id).ok_or_else(|| format!("`{id}` has no genome"))?;
        let (genome, species) = read(&path)?;
        let found = locked(&workshop.stock.broods).find_cell(id);
        let (parents, op) =
            found.map_or_else(|| (Vec::new(), nursery::IMPORT.to_owned()), |cell| (cell.parents, cell.op));
        for parent in &parents {
            let is_known = folder.pool().find(parent).is_ok() || newborns.iter().any(|own| own.id == *parent);
            if is_known || cells.contains(parent) {
                continue;
            }
            let path = workshop.genome_of(parent).ok_or_else(|| format!("`{parent}` has no genome"))?;
            let (genome, species) = read(&path)?;
            let (parents, op) = (Vec::new(), nursery::IMPORT.to_owned());
            newborns.push(Newborn { id: parent.clone(), parents, op, species, genome });
        }
        newborns.push(Newborn { id: id.clone(), parents, op, species, genome });
    }
    let of = newborns.len() as u64;
    let done = std::sync::atomic::AtomicU64::new(0);
    let figures = |own: &Newborn| {
        let found = nursery::figures(&*own.genome).map_err(|error| format!("`{}`: {error}", own.id));
        progress.set(done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1, of);
        found.map(|found| nursery::traits(&found))
    };
    let threads = Threads::new(0).map_err(|error| error.to_string())?;
    let figures = threads.run(|| newborns.par_iter().map(figures).collect::<Result<Vec<_>, String>>())?;
    let pool = folder.pool();
    let (brood, first) = (pool.next_brood(), pool.next_serial());
    let (origin, seed) = (pool.settings.origin, pool.settings.seed);
    let mut ids: BTreeMap<String, Id> = BTreeMap::new();
    let mut born = Vec::new();
    for ((serial, own), figures) in (first..).zip(newborns).zip(figures) {
        let id = Id { brood, serial, origin };
        let known = |parent: &String| ids.get(parent).copied().or_else(|| Some(pool.find(parent).ok()?.born.id));
        let parents = own.parents.iter().filter_map(known).collect();
        let licence = own.genome.lineage().licence.unwrap_or_default();
        ids.insert(own.id.clone(), id);
        let (operator, species, strength, waited) = (own.op, own.species, 1.0, None);
        born.push((Born { id, parents, operator, seed, species, figures, licence, strength, waited }, own.genome));
    }
    let brood = Brood { brood, seed, born, reborn: Vec::new(), missing: 0, refused: Vec::new() };
    let told = folder.bear(today(), &brood, |born, genome| nursery::text(born, &**genome));
    told.map_err(|error| chain(&error))?;
    Ok(cells.iter().filter_map(|id| ids.get(id).copied()).collect())
}

/// The pool in the folder at `path`, open for changes; made if there is none.
fn pool_for_changes(path: &PathBuf) -> Result<Folder, String> {
    if path.join(::breeding::SETTINGS).exists() {
        return open_for_changes(path).map_err(|fatal| fatal.in_words());
    }
    fs::create_dir_all(path).map_err(|error| format!("cannot make the pool `{}`: {error}", path.display()))?;
    let name = path.file_name().map_or_else(|| "pool".to_owned(), |name| name.to_string_lossy().into_owned());
    let settings = Settings::new(&name, Origin::of_bits(rand::random()), rand::random::<u32>().into(), &endings());
    Folder::create(path, &settings).map_err(|error| chain(&error))
}
