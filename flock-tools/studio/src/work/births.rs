//! Broods that are made, and sheep of them that are accepted.
//!
//! Owns the jobs: the children of a brood on all cores, each told to the page as it is there; and the birth of accepted
//! cells in the pool, with those of their ancestors that it does not know. A sheep is known by its genome, whatever it is
//! called. The rules of a pool are those of the package `breeding`.
//!
//! Start at [`begin`].

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ::breeding::{Born, Brood, Folder, Id, Origin, Settings};
use flame::Backend;
use operations::breeding::{nursery, open_for_changes, today};
use operations::program::{chain, now, print};
use operations::species::{self as kinds, all, endings};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde_json::{Value, json};
use species::{Genome, Lineage, Threads};

use crate::breeding::broods::{BroodRecord, Cell, CellState};
use crate::breeding::children::{Parent, Wish};
use crate::jobs::{Job, Kind, NewJob, Priority, Progress};
use crate::lock::locked;
use crate::requests::BreedRequest;
use crate::workshop::Workshop;

/// Cells of a brood: as many as asked for, within these.
const CELLS: [usize; 2] = [2, 60];
const USUAL_CELLS: usize = 20;
/// The most parents of a brood.
const MOST_PARENTS: usize = 3;

/// Begins a brood: its record, and the job that makes it.
/// Errors: A sentence, if a parent has no genome or the record cannot be written.
pub(crate) fn begin(workshop: &Arc<Workshop>, request: &BreedRequest) -> Result<(Job, BroodRecord), String> {
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
    let begun = locked(&workshop.stock.broods).begin(&named, species, wish, count, now::since_1970_ms());
    let brood = begun.map_err(|error| format!("cannot keep the brood: {error}"))?;
    Ok((queue(workshop, &brood), brood))
}

/// Queues the making of a brood.
pub(crate) fn queue(workshop: &Arc<Workshop>, brood: &BroodRecord) -> Job {
    let id = brood.id.clone();
    let new = NewJob {
        key: Some(format!("brood {id}")),
        ..NewJob::new(Priority::Interactive, Kind::Brood, format!("brood {id}"))
    };
    workshop.add_job(new, move |workshop, progress| make(workshop, &id, progress))
}

/// Makes the cells of a brood that wait.
fn make(workshop: &Workshop, id: &str, progress: &Progress) -> Result<Value, String> {
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
pub(crate) fn queue_births(workshop: &Arc<Workshop>, cells: Vec<String>) -> Job {
    let what = format!("{} into the pool", print::count(cells.len(), "cell"));
    workshop.add_job(NewJob::new(Priority::Interactive, Kind::Brood, what), move |workshop, progress| {
        let born = bear(workshop, &cells, progress)?;
        workshop.tell_all();
        Ok(json!({ "born": born }))
    })
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

impl Newborn {
    /// The sheep `id` of a brood, with its parents and its operator; or of the flock or an archive, without.
    /// Errors: If it has no genome, or one that cannot be read.
    fn read(workshop: &Workshop, id: &str) -> Result<Self, String> {
        let path = workshop.genome_of(id).ok_or_else(|| format!("`{id}` has no genome"))?;
        let (genome, species) = read(&path)?;
        let found = locked(&workshop.stock.broods).find_cell(id);
        let import = || (Vec::new(), nursery::IMPORT.to_owned());
        let (parents, op) = found.map_or_else(import, |cell| (cell.parents, cell.op));
        Ok(Self { id: id.to_owned(), parents, op, species, genome })
    }
}

/// The sheep of a pool by their genomes, and by what the studio calls them.
struct KnownSheep {
    /// By the text of the genome without its lineage, which is another one in a brood, in the flock and in the pool.
    by_text: HashMap<String, Id>,
    /// By the ids that the studio has for them.
    by_name: BTreeMap<String, Id>,
}

impl KnownSheep {
    /// Those of the pool in `folder`. A genome that cannot be read is that of nobody.
    fn of(folder: &Folder) -> Self {
        let sheep: Vec<&Born> = folder.pool().sheep().map(|sheep| &sheep.born).collect();
        let text = |born: &&Born| Some((bare(&*read(&folder.genome(born)).ok()?.0), born.id));
        let texts: Vec<Option<(String, Id)>> = sheep.par_iter().map(text).collect();
        let mut by_text = HashMap::new();
        for (text, id) in texts.into_iter().flatten() {
            by_text.entry(text).or_insert(id);
        }
        Self { by_text, by_name: BTreeMap::new() }
    }

    /// The sheep that the studio calls `name`: one that is known by it, or whose id in the pool it is.
    fn find(&self, name: &str, folder: &Folder) -> Option<Id> {
        self.by_name.get(name).copied().or_else(|| Some(folder.pool().find(name).ok()?.born.id))
    }
}

/// The text of a genome without its lineage.
fn bare(genome: &dyn Genome) -> String {
    genome.with_lineage(&Lineage::default()).text()
}

/// Those of the cells that the pool does not know, each after those of its ancestors that it does not know either. What
/// is found in the pool by its genome is `known` by its name afterwards. An ancestor whose genome nobody has any more is
/// left out, and the log says so.
/// Errors: If a cell has no genome, or one that cannot be read.
fn unknown(
    workshop: &Workshop,
    folder: &Folder,
    cells: &[String],
    known: &mut KnownSheep,
    progress: &Progress,
) -> Result<Vec<Newborn>, String> {
    let (mut newborns, mut seen) = (Vec::new(), BTreeSet::new());
    // The last is looked at first; a sheep comes back when its parents are done.
    let mut open: Vec<(String, Option<Newborn>)> = cells.iter().rev().map(|id| (id.clone(), None)).collect();
    while let Some((id, ready)) = open.pop() {
        if let Some(newborn) = ready {
            newborns.push(newborn);
            continue;
        }
        if known.find(&id, folder).is_some() || !seen.insert(id.clone()) {
            continue;
        }
        let newborn = match Newborn::read(workshop, &id) {
            Err(why) if !cells.contains(&id) => {
                progress.log(&format!("{why}: its children are accepted without it"));
                continue;
            }
            newborn => newborn?,
        };
        if let Some(found) = known.by_text.get(&bare(&*newborn.genome)) {
            known.by_name.insert(id, *found);
            continue;
        }
        let parents: Vec<String> = newborn.parents.iter().rev().cloned().collect();
        open.push((id, Some(newborn)));
        open.extend(parents.into_iter().map(|parent| (parent, None)));
    }
    Ok(newborns)
}

/// Lets the cells be born in the pool, after those of their ancestors that it does not know. Returns the ids of the cells
/// there.
fn bear(workshop: &Workshop, cells: &[String], progress: &Progress) -> Result<Vec<Id>, String> {
    let mut folder = pool_for_changes(&workshop.stock.candidates.pool)?;
    let threads = Threads::new(0).map_err(|error| error.to_string())?;
    let mut known = threads.run(|| KnownSheep::of(&folder));
    let newborns = unknown(workshop, &folder, cells, &mut known, progress)?;
    let of = newborns.len() as u64;
    let done = std::sync::atomic::AtomicU64::new(0);
    let figures = |own: &Newborn| {
        let found = nursery::figures(&*own.genome).map_err(|error| format!("`{}`: {error}", own.id));
        progress.set(done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1, of);
        found.map(|found| nursery::traits(&found))
    };
    let figures = threads.run(|| newborns.par_iter().map(figures).collect::<Result<Vec<_>, String>>())?;
    let pool = folder.pool();
    let (brood, first) = (pool.next_brood(), pool.next_serial());
    let (origin, seed) = (pool.settings.origin, pool.settings.seed);
    let mut born = Vec::new();
    for ((serial, own), figures) in (first..).zip(newborns).zip(figures) {
        let id = Id { brood, serial, origin };
        let parents = own.parents.iter().filter_map(|parent| known.find(parent, &folder)).collect();
        let licence = own.genome.lineage().licence.unwrap_or_default();
        known.by_name.insert(own.id, id);
        let (operator, species, strength, waited) = (own.op, own.species, 1.0, None);
        born.push((Born { id, parents, operator, seed, species, figures, licence, strength, waited }, own.genome));
    }
    if !born.is_empty() {
        let brood = Brood { brood, seed, born, reborn: Vec::new(), missing: 0, refused: Vec::new() };
        let told = folder.bear(today(), &brood, |born, genome| nursery::text(born, &**genome));
        told.map_err(|error| chain(&error))?;
    }
    Ok(cells.iter().filter_map(|id| known.find(id, &folder)).collect())
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write;
    use std::time::Duration;

    /// How each sheep of a pool came, by its id: the operator and the parents.
    type Origins = BTreeMap<String, (String, Vec<String>)>;

    /// A studio of a flock of one sheep of each species, and its folder.
    fn studio() -> (tempfile::TempDir, Arc<Workshop>) {
        let scratch = tempfile::tempdir().unwrap();
        let genomes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../demo/genomes");
        let mut text = "format = 1\nname = \"small\"\nsize = [64, 36]\nfps = [30, 1]\n".to_owned();
        for name in ["lagoon.expr", "orchid.flam3", "linden.plant", "gilt.agents"] {
            fs::copy(genomes.join(name), scratch.path().join(name)).unwrap();
            let id = name.split('.').next().unwrap();
            write!(text, "[[sheep]]\nid = \"{id}\"\ngenome = \"{name}\"\n").unwrap();
        }
        fs::write(scratch.path().join(flock::FILE_NAME), text).unwrap();
        let workshop = Workshop::of_folder(scratch.path());
        (scratch, workshop)
    }

    /// A brood of `parents` whose first child is the expression `text`, made by `op`; returns its id.
    fn brood(workshop: &Workshop, parents: &[&str], op: &str, text: &str) -> String {
        let parents: Vec<(String, String)> = parents.iter().map(|id| ((*id).to_owned(), "expr".to_owned())).collect();
        let wish = Wish { strength: 0.5, locks: Vec::new(), seed: 1 };
        let mut broods = locked(&workshop.stock.broods);
        let made = broods.begin(&parents, None, wish, parents.len() + 1, 1).unwrap();
        let cell = made.cells.last().unwrap().clone();
        let lineage = Lineage { id: Some(cell.id.clone()), parents: cell.parents.clone(), ..Lineage::default() };
        let path = broods.genome(&made.id, &cell.id, "expr");
        fs::write(&path, text).unwrap();
        let (genome, _) = read(&path).unwrap();
        fs::write(&path, genome.with_lineage(&lineage).text()).unwrap();
        let (id, op, species) = (cell.id.clone(), op.to_owned(), "expr".to_owned());
        broods.set(&made.id, Cell { op, species, state: CellState::There, ..cell }).unwrap();
        id
    }

    /// Accepts cells; returns the ids that they have in the pool, and how each sheep of it came: its operator and its
    /// parents.
    fn accept(workshop: &Arc<Workshop>, cells: &[&str]) -> (Vec<String>, Origins) {
        let job = queue_births(workshop, cells.iter().map(|id| (*id).to_owned()).collect());
        assert!(workshop.queue.wait_until(Duration::from_mins(5), |jobs| jobs.iter().all(|job| job.state.is_over())));
        let job = workshop.queue.job(job.id).unwrap();
        assert_eq!(job.error, None);
        let folder = workshop.stock.candidates.folder().map_err(|fatal| fatal.in_words()).unwrap().unwrap();
        let text = |id: &Id| id.to_string();
        let told = |born: &Born| (born.operator.clone(), born.parents.iter().map(text).collect());
        let all = folder.pool().sheep().map(|sheep| (text(&sheep.born.id), told(&sheep.born))).collect();
        let born = job.result.unwrap()["born"].as_array().unwrap().clone();
        (born.iter().map(|id| id.as_str().unwrap().to_owned()).collect(), all)
    }

    const FIRST: &str = "(expression 1 (picture (+ .5 (* .4 (sin (+ (* 4 (bw-noise .5 1)) (wave 1 0)))))))\n";
    const SECOND: &str = "(expression 1 (picture (+ .5 (* .3 (sin (+ (* 3 (bw-noise .5 1)) (wave 1 0)))))))\n";
    const THIRD: &str = "(expression 1 (picture (+ .5 (* .2 (sin (+ (* 5 (bw-noise .5 1)) (wave 1 0)))))))\n";

    #[test]
    fn an_accepted_child_has_its_true_parents_and_no_sheep_comes_into_the_pool_twice() {
        let (_scratch, workshop) = studio();
        let child = brood(&workshop, &["lagoon"], "number", FIRST);
        let grandchild = brood(&workshop, &[&child, "lagoon"], "graft", SECOND);
        let sibling = brood(&workshop, &[&child], "wrap", THIRD);
        let (born, pool) = accept(&workshop, &[&grandchild]);
        let of = |op: &str| pool.iter().filter(|(_, own)| own.0 == op).map(|(id, _)| id.clone()).collect::<Vec<_>>();
        let ([lagoon], [parent], [accepted]) = (&of("import")[..], &of("number")[..], &of("graft")[..]) else {
            panic!("{pool:?}");
        };
        assert_eq!((pool.len(), &born[..]), (3, std::slice::from_ref(accepted)));
        assert_eq!(pool[accepted].1, [parent.clone(), lagoon.clone()]);
        assert_eq!(pool[parent].1, std::slice::from_ref(lagoon));
        assert_eq!(pool[lagoon].1.len(), 0);
        // What came as an ancestor is what its own acceptance finds, also by another brood.
        let (born, pool) = accept(&workshop, &[&child, &sibling]);
        assert_eq!((pool.len(), &born[0]), (4, parent));
        assert_eq!(pool[&born[1]], ("wrap".to_owned(), vec![parent.clone()]));
        assert_eq!(accept(&workshop, &[&grandchild]), (vec![accepted.clone()], pool));
    }

    #[test]
    fn a_sheep_of_any_species_is_known_in_the_pool_by_its_genome() {
        let (_scratch, workshop) = studio();
        let all = ["lagoon", "orchid", "linden", "gilt"];
        let (born, pool) = accept(&workshop, &all);
        assert_eq!((born.len(), pool.len()), (4, 4));
        assert_eq!(accept(&workshop, &all), (born, pool));
    }

    #[test]
    fn a_child_is_accepted_without_an_ancestor_that_nobody_has_any_more() {
        let (scratch, workshop) = studio();
        let child = brood(&workshop, &["lagoon"], "number", FIRST);
        let grandchild = brood(&workshop, &[&child], "graft", SECOND);
        fs::remove_file(scratch.path().join("lagoon.expr")).unwrap();
        let (born, pool) = accept(&workshop, &[&grandchild]);
        assert_eq!((born.len(), pool.len()), (1, 2));
        assert_eq!(pool[&born[0]].1.len(), 1);
        let log = workshop.queue.jobs().into_iter().flat_map(|job| job.log).collect::<String>();
        assert!(log.contains("`lagoon` has no genome"), "{log}");
    }
}
