//! `dreams pool add`: genomes from elsewhere.
//!
//! Owns the action: which files a pool takes, and whether their sheep live in it at once or wait to be strangers of its
//! next broods. The artist chose them: what is wrong with their pictures is told, and they are taken all the same, unless the
//! artist asks for what a brood asks.

use std::path::{Path, PathBuf};

use ::breeding::{Born, CLONE, Event, Folder, Id, Lookalikes, Pool, Traits, Waiting};
use flame::Backend;
use operations::breeding::nursery::{self, IMPORT, figures, traits};
use operations::breeding::{open, open_for_changes, today};
use operations::program::{Exit, Fatal, print};
use operations::species as kinds;
use species::{FigureFault, Genome, Threads};

use super::pool::{Answer, PoolArgs, tell};
use super::sheet::Sheet;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: PoolArgs,
    /// Genomes: flames (.flam3), expressions (.expr), globes of agents (.agents), plants (.plant)
    #[arg(required = true)]
    genomes: Vec<PathBuf>,
    /// Let them wait: they are the first strangers of the next broods, instead of sheep made by chance
    #[arg(long)]
    as_strangers: bool,
    /// Bring in none that no brood would take: black, still, strobing, ..., or too like another sheep
    #[arg(long)]
    strict: bool,
    /// Also write a contact sheet of those, with what is wrong with each, as PNG
    #[arg(long, value_name = "FILE", requires = "strict")]
    refused: Option<PathBuf>,
    /// Only print what would be brought in
    #[arg(long)]
    dry_run: bool,
}

/// A genome that a pool does not take.
#[derive(Debug, thiserror::Error)]
enum AddError {
    #[error("`{path}` is not a genome that can be drawn")]
    Genome { path: PathBuf, source: Box<dyn std::error::Error> },
    #[error("`{path}` is a {found}, the pool breeds {expected}")]
    Species { path: PathBuf, found: String, expected: String },
}

/// A genome that a pool takes, or could take.
struct Found {
    path: PathBuf,
    text: String,
    genome: Box<dyn Genome>,
    species: String,
    figures: Traits,
    faults: Vec<&'static str>,
}

/// Runs the action.
pub(super) fn run(args: &Args, json: bool) -> Result<Exit, Fatal> {
    let PoolArgs { pool } = &args.common;
    let mut folder = if args.dry_run { open(pool)? } else { open_for_changes(pool)? };
    let read = |path: &PathBuf| Found::read(path, folder.pool());
    let mut found: Vec<Found> = args.genomes.iter().map(read).collect::<Result<_, Fatal>>()?;
    if args.strict {
        name_clones(&mut found, folder.pool());
    }
    let told = found
        .iter()
        .flat_map(|it| it.faults.iter().map(|fault| format!("`{}` is {fault}", it.path.display())).collect::<Vec<_>>());
    let faults: Vec<String> = told.collect();
    for fault in &faults {
        let so = if args.strict { "it is not brought in" } else { "it is brought in all the same" };
        print::note(&format!("note: {fault}; {so}"));
    }
    let (refused, taken): (Vec<Found>, Vec<Found>) =
        found.into_iter().partition(|it| args.strict && !it.faults.is_empty());
    if let Some(path) = &args.refused {
        draw(&refused, path)?;
    }
    let done = if args.as_strangers {
        args.wait(&mut folder, taken, faults, json)
    } else {
        args.bear(&mut folder, taken, faults, json)
    }?;
    Ok(if refused.is_empty() { done } else { Exit::No })
}

/// Names those that are too like a living sheep, or one before them.
fn name_clones(found: &mut [Found], pool: &Pool) {
    let mut known = Lookalikes::of(pool);
    for it in found.iter_mut().filter(|it| it.faults.is_empty()) {
        if known.have(&it.species, &it.figures) {
            it.faults.push(CLONE);
        } else {
            known.add(&it.species, &it.figures);
        }
    }
}

/// Writes a sheet of those that are not brought in.
fn draw(refused: &[Found], path: &Path) -> Result<(), Fatal> {
    let threads = Threads::new(0).map_err(|error| Fatal::new(Exit::Unreadable, error))?;
    let name = |it: &Found| {
        let stem = it.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        format!("{stem}: {}", it.faults.join(", "))
    };
    let named: Vec<(String, &dyn Genome)> = refused.iter().map(|it| (name(it), &*it.genome)).collect();
    Sheet::of(&named, &threads)?.save(path).map_err(|source| Fatal::write(path, source))
}

impl Args {
    /// Lets the sheep live in the pool.
    fn bear(&self, folder: &mut Folder, found: Vec<Found>, faults: Vec<String>, json: bool) -> Result<Exit, Fatal> {
        let pool = folder.pool();
        let (brood, first) = (pool.next_brood(), pool.next_serial());
        let born = |(serial, found): (u32, Found)| {
            let born = Born {
                id: Id { brood, serial, origin: pool.settings.origin },
                parents: Vec::new(),
                operator: IMPORT.to_owned(),
                seed: pool.settings.seed,
                licence: found.licence(),
                species: found.species,
                figures: found.figures,
                strength: 1.0,
                waited: None,
            };
            (born, found.genome)
        };
        let born: Vec<(Born, Box<dyn Genome>)> = (first..).zip(found).map(born).collect();
        if !self.dry_run {
            folder.bring_in(today(), &born, |born, genome| nursery::text(born, &**genome))?;
        }
        let ids: Vec<Id> = born.iter().map(|(born, _)| born.id).collect();
        let verb = if self.dry_run { "would be" } else { "is" };
        tell(json, !self.dry_run, &ids, faults, |id| format!("{id} {verb} in the pool"))
    }

    /// Lets the genomes wait for the next broods.
    fn wait(&self, folder: &mut Folder, found: Vec<Found>, faults: Vec<String>, json: bool) -> Result<Exit, Fatal> {
        let paths: Vec<PathBuf> = found.iter().map(|found| found.path.clone()).collect();
        let waiting = |found: Found| Waiting {
            licence: found.licence(),
            species: found.species,
            figures: found.figures,
            genome: found.text,
        };
        if !self.dry_run {
            folder.tell(today(), found.into_iter().map(waiting).map(Event::Waits).collect())?;
        }
        if json {
            print::json(&Answer { changed: !self.dry_run, sheep: Vec::new(), faults })?;
        } else {
            let verb = if self.dry_run { "would wait" } else { "waits" };
            print::lines(paths.iter().map(|path| format!("`{}` {verb} for the next brood", path.display())))?;
        }
        Ok(Exit::Fine)
    }
}

impl Found {
    /// Reads a genome, and looks at it.
    fn read(path: &Path, pool: &Pool) -> Result<Self, Fatal> {
        let malformed = |source| Fatal::new(Exit::Malformed, AddError::Genome { path: path.to_owned(), source });
        let text = kinds::text(path)
            .map_err(|why| Fatal::new(why.exit, AddError::Genome { path: path.to_owned(), source: why.source }))?;
        let genome = kinds::parse(path, &text, &Backend::default()).map_err(|why| malformed(why.source))?;
        let species = kinds::ending(path, &text).to_owned();
        let bred = &pool.settings.species;
        if !bred.contains(&species) {
            let (found, expected) = (format!(".{species}"), bred.join(", "));
            return Err(Fatal::new(Exit::Malformed, AddError::Species { path: path.to_owned(), found, expected }));
        }
        let looked = figures(&*genome).map_err(|error| malformed(error.into()))?;
        let (figures, faults) = (traits(&looked), looked.faults().into_iter().map(FigureFault::name).collect());
        Ok(Self { path: path.to_owned(), text, genome, species, figures, faults })
    }

    fn licence(&self) -> String {
        self.genome.lineage().licence.unwrap_or_default()
    }
}
