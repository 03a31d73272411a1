//! `dreams breed POOL`: a brood.
//!
//! Owns the command: its options, the order of births and deaths, and the answer. The same seed and ledger give the same
//! brood, whatever the number of threads and the date.

use std::collections::BTreeMap;
use std::fs::{self, OpenOptions};
use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use ::breeding::{Birth, Brood, Census, Event, Folder, Id, Operation, Order, Settings, breed, deaths, foreseen, plan};
use clap::builder::RangedU64ValueParser;
use operations::breeding::nursery::{self, Candidates, IMPORT, REFUSED};
use operations::breeding::{genome, open, open_for_changes, today, waiting};
use operations::program::{Exit, Fatal, print};
use operations::render::machine;
use operations::species::all;
use species::{Breed, Genome, Threads};

use super::sheet::Sheet;
use crate::arguments;

/// Breed a brood: sheep by crossing, by mutation and by chance
///
/// Parents are sheep that were liked more than others were at as many showings. Half of the births are the best of several
/// candidates, by what was liked before. What is black, still, strobing or too like another sheep is made again. In a pool
/// that is empty, all are made by chance. Afterwards sheep die that are liked least, while the pool has more than its limit;
/// their genomes stay.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the brood is in the pool, or would be
  1  some births did not take place: every candidate was refused; or another program changes the pool
  2  the command line, the pool or a genome is wrong
  3  a file could not be read or written")]
pub struct Args {
    /// Folder of the pool
    pool: PathBuf,
    /// How many births [default: the pool's]
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(Settings::BIRTHS))]
    brood: Option<usize>,
    /// The parents of all births: one id, or two with a comma between them
    #[arg(long, value_name = "A[,B]", value_parser = parents_of)]
    from: Option<Parents>,
    /// The operator that makes all of them, by its name: `--op list` lists them
    #[arg(long, value_name = "NAME")]
    op: Option<String>,
    /// Another seed than the pool's
    #[arg(long)]
    seed: Option<u64>,
    /// Candidates of each of the births that are the best of several; 1 chooses none
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(Settings::SCREENINGS))]
    screen: Option<usize>,
    /// How large mutations are: 1 is usual
    #[arg(long, value_name = "X", value_parser = arguments::positive)]
    strength: Option<f64>,
    /// Candidates made at once [default: one for each core]
    #[arg(long, value_name = "T", default_value_t = machine::cores(), value_parser = arguments::threads)]
    threads: NonZeroUsize,
    /// Also write a contact sheet of the brood, as PNG
    #[arg(long, value_name = "FILE")]
    sheet: Option<PathBuf>,
    /// Also write a contact sheet of the candidates that were refused, with what is wrong with each, as PNG
    #[arg(long, value_name = "FILE")]
    refused: Option<PathBuf>,
    /// Only print which births are planned and who would die; nothing is made. Which sheep die is a guess: nobody knows the
    /// newborn yet
    #[arg(long, conflicts_with_all = ["sheet", "refused"])]
    dry_run: bool,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// The ids of one or two sheep, as they were given.
#[derive(Clone, Debug)]
struct Parents(Vec<String>);

/// A parent whose licence the pool does not breed from.
#[derive(Debug, thiserror::Error)]
enum LicenceError {
    #[error("sheep `{id}` has no licence, and the pool breeds only those that may be sold")]
    Missing { id: Id },
    #[error("sheep `{id}` is under `{licence}`, and the pool breeds only those that may be sold")]
    NonCommercial { id: Id, licence: String },
}

/// An operator that no species of the pool has for so many parents.
#[derive(Debug, thiserror::Error)]
#[error("no operator `{name}` makes a child of {parents} {species}")]
struct OperatorError {
    name: String,
    parents: usize,
    species: String,
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct Answer {
    brood: u32,
    seed: u64,
    born: Vec<BirthAnswer>,
    reborn: Vec<Id>,
    died: Vec<Id>,
    /// Births that did not take place.
    missing: usize,
    /// What was wrong with refused candidates, and with how many.
    refused: BTreeMap<String, usize>,
    /// Whether all was only planned.
    dry_run: bool,
}

#[derive(serde::Serialize)]
struct BirthAnswer {
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<Id>,
    operator: String,
    parents: Vec<Id>,
    species: String,
    strength: f64,
    /// How many candidates it is the best of.
    #[serde(skip_serializing_if = "Option::is_none")]
    candidates: Option<usize>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    if args.op.as_deref() == Some("list") {
        return list_operators(args.json);
    }
    let mut folder = if args.dry_run { open(&args.pool)? } else { open_for_changes(&args.pool)? };
    let order = args.order(&folder)?;
    // Not of today: the same ledger gives the same brood.
    let census = Census::of(folder.pool(), folder.pool().last_day());
    if args.dry_run {
        return args.planned(&folder, &census, &order);
    }
    for sheet in [&args.sheet, &args.refused].into_iter().flatten() {
        may_be_written(sheet).map_err(|source| Fatal::write(sheet, source))?;
    }
    let candidates = Candidates::new(parents(&folder, &order)?, waiting(&folder)?, args.op.clone());
    let threads = Threads::new(args.threads.get()).map_err(|error| Fatal::new(Exit::Unreadable, error))?;
    let brood = threads.run(|| breed(folder.pool(), &census, &order, &candidates));
    folder.bear(today(), &brood, |born, genome| nursery::text(born, &**genome))?;
    let died = bury(&mut folder)?;
    args.write_sheets(&brood, &threads)?;
    args.answer(&brood, died)
}

impl Args {
    fn order(&self, folder: &Folder) -> Result<Order, Fatal> {
        let pool = folder.pool();
        let find = |id: &String| {
            let born = &pool.find(id)?.born;
            if pool.settings.licence.allows(&born.licence) {
                return Ok(born.id);
            }
            let (id, licence) = (born.id, born.licence.clone());
            let missing = licence.is_empty();
            let error =
                if missing { LicenceError::Missing { id } } else { LicenceError::NonCommercial { id, licence } };
            Err(Fatal::new(Exit::Malformed, error))
        };
        let parents = self.from().iter().map(find).collect::<Result<Vec<Id>, Fatal>>()?;
        let operation = self.op.as_deref().map(|name| self.operation(name, folder)).transpose()?;
        Ok(Order {
            births: self.brood,
            parents,
            operation,
            seed: self.seed,
            screening: self.screen,
            strength: self.strength,
        })
    }

    /// The parents that were named.
    fn from(&self) -> &[String] {
        self.from.as_ref().map_or(&[], |parents| &parents.0)
    }

    /// Whether the operator `name` is a mutation or a crossing, for the species of the pool.
    fn operation(&self, name: &str, folder: &Folder) -> Result<Operation, Fatal> {
        let species = &folder.pool().settings.species;
        let own = all(&flame::Backend::default()).into_iter().filter(|own| species.iter().any(|it| it == own.ending()));
        let found: Vec<usize> = own.filter_map(|own| own.operator(name).map(|operator| operator.parents)).collect();
        let wanted = if self.from().is_empty() { None } else { Some(self.from().len()) };
        let parents = found.iter().copied().find(|parents| wanted.is_none_or(|wanted| wanted == *parents));
        match parents {
            Some(1) => Ok(Operation::Mutation),
            Some(_) => Ok(Operation::Cross),
            None => {
                let (name, species) = (name.to_owned(), species.join(", "));
                let error = OperatorError { name, parents: wanted.unwrap_or(1), species };
                Err(Fatal::new(Exit::Malformed, error).hint("`dreams breed POOL --op list` lists all"))
            }
        }
    }

    fn planned(&self, folder: &Folder, census: &Census, order: &Order) -> Result<Exit, Fatal> {
        let plan = plan(folder.pool(), census, order);
        let died = foreseen(folder.pool(), &plan).ids;
        let born = plan.births.into_iter().map(|birth| planned(birth, self.op.as_deref())).collect();
        let (missing, refused) = (0, BTreeMap::new());
        self.tell(&Answer {
            brood: plan.brood,
            seed: plan.seed,
            born,
            reborn: plan.reborn,
            died,
            missing,
            refused,
            dry_run: true,
        })
    }

    fn answer(&self, brood: &Brood<Box<dyn Genome>>, died: Vec<Id>) -> Result<Exit, Fatal> {
        let born = brood.born.iter().map(|(born, _)| BirthAnswer {
            id: Some(born.id),
            operator: born.operator.clone(),
            parents: born.parents.clone(),
            species: born.species.clone(),
            strength: born.strength,
            candidates: None,
        });
        self.tell(&Answer {
            brood: brood.brood,
            seed: brood.seed,
            born: born.collect(),
            reborn: brood.reborn.clone(),
            died,
            missing: brood.missing,
            refused: brood.faults(),
            dry_run: false,
        })
    }

    fn write_sheets(&self, brood: &Brood<Box<dyn Genome>>, threads: &Threads) -> Result<(), Fatal> {
        let write = |path: &Path, sheep: Vec<(String, &dyn Genome)>| {
            Sheet::of(&sheep, threads)?.save(path).map_err(|source| Fatal::write(path, source))
        };
        if let Some(path) = &self.sheet {
            write(path, brood.born.iter().map(|(born, genome)| (born.id.to_string(), &**genome)).collect())?;
        }
        if let Some(path) = &self.refused {
            // What is not drawn has no picture.
            let drawn = brood.refused.iter().filter(|refused| !refused.faults.iter().any(|fault| fault == REFUSED));
            let named = drawn.filter_map(|refused| Some((refused.faults.join(", "), &**refused.candidate.as_ref()?)));
            write(path, named.collect())?;
        }
        Ok(())
    }

    fn tell(&self, answer: &Answer) -> Result<Exit, Fatal> {
        let exit = if answer.missing > 0 { Exit::No } else { Exit::Fine };
        if self.json {
            print::json(answer)?;
            return Ok(exit);
        }
        print::lines(answer.lines())?;
        if answer.missing > 0 {
            let most = answer.refused.iter().max_by_key(|(_, count)| **count);
            let why = most.map_or(String::new(), |(fault, count)| format!("; {count} candidates were {fault}"));
            print::note(&format!("note: {} did not take place{why}", print::count(answer.missing, "birth")));
        }
        Ok(exit)
    }
}

impl Answer {
    fn lines(&self) -> Vec<String> {
        let birth = |birth: &BirthAnswer| {
            let id = birth.id.map_or("-".to_owned(), |id| id.to_string());
            let parents: Vec<String> = birth.parents.iter().map(ToString::to_string).collect();
            let of = if parents.is_empty() { String::new() } else { format!(" of {}", parents.join(" and ")) };
            let best = birth.candidates.filter(|candidates| *candidates > 1);
            let best = best.map_or(String::new(), |candidates| format!(", the best of {candidates}"));
            format!("{id} {} by {}{of}{best}", birth.species, birth.operator)
        };
        let mut lines: Vec<String> = self.born.iter().map(birth).collect();
        let [born, lives, dies] = if self.dry_run {
            ["would be born", "would live again", "would die"]
        } else {
            ["born", "lives again", "died"]
        };
        lines.extend(self.reborn.iter().map(|id| format!("{id} {lives}")));
        lines.extend(self.died.iter().map(|id| format!("{id} {dies}; its genome stays")));
        lines.push(format!("brood {}: {} {born}, {} {dies}", self.brood, self.born.len(), self.died.len()));
        lines
    }
}

/// Whether a file can be written at `path`, without writing one: what is there stays.
fn may_be_written(path: &Path) -> io::Result<()> {
    let is_new = !path.exists();
    OpenOptions::new().append(true).create(true).open(path)?;
    if is_new { fs::remove_file(path) } else { Ok(()) }
}

/// One id, or two with a comma between them.
fn parents_of(text: &str) -> Result<Parents, String> {
    let ids: Vec<String> = text.split(',').map(|id| id.trim().to_owned()).collect();
    if ids.len() > 2 || ids.iter().any(String::is_empty) {
        return Err(format!("wanted one id, or two with a comma between them, found {}", ids.len()));
    }
    Ok(Parents(ids))
}

fn planned(birth: Birth, operator: Option<&str>) -> BirthAnswer {
    let operation = match birth.operation {
        Operation::Cross => "crossing",
        Operation::Mutation => "mutation",
        Operation::Stranger => "chance",
    };
    BirthAnswer {
        id: None,
        operator: birth.waited.map_or(operator.unwrap_or(operation), |_| IMPORT).to_owned(),
        parents: birth.parents,
        species: birth.species,
        strength: birth.strength,
        candidates: Some(birth.candidates),
    }
}

/// The genomes of all that may be parents.
fn parents(folder: &Folder, order: &Order) -> Result<BTreeMap<Id, Box<dyn Genome>>, Fatal> {
    let pool = folder.pool();
    let named = order.parents.iter().filter_map(|id| pool.get(*id));
    let sheep = pool.living().filter(|_| order.parents.is_empty()).chain(named);
    sheep.map(|sheep| Ok((sheep.born.id, genome(folder, &sheep.born)?))).collect()
}

/// Lets those die that have to, and tells which.
fn bury(folder: &mut Folder) -> Result<Vec<Id>, Fatal> {
    let census = Census::of(folder.pool(), folder.pool().last_day());
    let found = deaths(folder.pool(), &census);
    if found.beyond > 0 {
        let (over, limit) = (found.beyond, folder.pool().settings.limit);
        print::note(&format!("note: the pool has {over} sheep more than its limit of {limit}: no other may die yet"));
    }
    if !found.ids.is_empty() {
        folder.tell(today(), found.ids.iter().map(|id| Event::Died { id: *id }).collect())?;
    }
    Ok(found.ids)
}

/// An operator in the answer.
#[derive(serde::Serialize)]
struct OperatorAnswer {
    species: &'static str,
    name: &'static str,
    aliases: &'static [&'static str],
    parents: usize,
    does: &'static str,
}

fn list_operators(json: bool) -> Result<Exit, Fatal> {
    let of = |species: &dyn Breed| {
        let ending = species.ending();
        let operator = move |it: &species::Operator| OperatorAnswer {
            species: ending,
            name: it.name,
            aliases: it.aliases,
            parents: it.parents,
            does: it.does,
        };
        species.operators().iter().map(operator).collect::<Vec<_>>()
    };
    let operators: Vec<OperatorAnswer> =
        all(&flame::Backend::default()).iter().flat_map(|species| of(&**species)).collect();
    if json {
        print::json(&operators)?;
        return Ok(Exit::Fine);
    }
    print::lines(operators.iter().map(|it| {
        let aliases = if it.aliases.is_empty() { String::new() } else { format!(" ({})", it.aliases.join(", ")) };
        let parents = if it.parents == 1 { "one parent" } else { "two parents" };
        format!("{} {}{aliases}, of {parents}: {}", it.species, it.name, it.does)
    }))?;
    Ok(Exit::Fine)
}
