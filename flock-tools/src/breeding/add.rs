//! `dreams pool add`: genomes from elsewhere.
//!
//! Owns the action: which files a pool takes, and whether their sheep live in it at once or wait to be strangers of its
//! next broods. The artist chose them: what is wrong with their pictures is told, and they are taken all the same.

use std::path::{Path, PathBuf};

use ::breeding::{Born, Event, Folder, Id, Pool, Traits, Waiting};
use flame::Backend;
use species::{FigureFault, Genome};

use super::nursery::{self, IMPORT, figures, traits};
use super::pool::{Answer, PoolArgs, tell};
use super::{fatal, open, open_for_changes, today};
use crate::program::{Exit, Fatal, print};
use crate::species as kinds;

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

/// A genome that a pool takes.
struct Found {
    text: String,
    genome: Box<dyn Genome>,
    species: String,
    figures: Traits,
    faults: Vec<FigureFault>,
}

/// Runs the action.
pub(super) fn run(args: &Args, json: bool) -> Result<Exit, Fatal> {
    let PoolArgs { pool } = &args.common;
    let mut folder = if args.dry_run { open(pool)? } else { open_for_changes(pool)? };
    let found: Vec<Found> =
        args.genomes.iter().map(|path| Found::read(path, folder.pool())).collect::<Result<_, Fatal>>()?;
    let told = args.genomes.iter().zip(&found).flat_map(|(path, found)| {
        found.faults.iter().map(move |fault| format!("`{}` is {}", path.display(), fault.name()))
    });
    let faults: Vec<String> = told.collect();
    for fault in &faults {
        print::note(&format!("note: {fault}; it is brought in all the same"));
    }
    if args.as_strangers {
        args.wait(&mut folder, found, faults, json)
    } else {
        args.bear(&mut folder, found, faults, json)
    }
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
            folder.bring_in(today(), &born, |born, genome| nursery::text(born, &**genome)).map_err(fatal)?;
        }
        let ids: Vec<Id> = born.iter().map(|(born, _)| born.id).collect();
        let verb = if self.dry_run { "would be" } else { "is" };
        tell(json, !self.dry_run, &ids, faults, |id| format!("{id} {verb} in the pool"))
    }

    /// Lets the genomes wait for the next broods.
    fn wait(&self, folder: &mut Folder, found: Vec<Found>, faults: Vec<String>, json: bool) -> Result<Exit, Fatal> {
        let waiting = |found: Found| Waiting {
            licence: found.licence(),
            species: found.species,
            figures: found.figures,
            genome: found.text,
        };
        if !self.dry_run {
            folder.tell(today(), found.into_iter().map(waiting).map(Event::Waits).collect()).map_err(fatal)?;
        }
        if json {
            print::json(&Answer { changed: !self.dry_run, sheep: Vec::new(), faults })?;
        } else {
            let verb = if self.dry_run { "would wait" } else { "waits" };
            print::lines(self.genomes.iter().map(|path| format!("`{}` {verb} for the next brood", path.display())))?;
        }
        Ok(Exit::Fine)
    }
}

impl Found {
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
        let figures = figures(&*genome).map_err(|error| malformed(error.into()))?;
        Ok(Self { text, genome, species, figures: traits(&figures), faults: figures.faults() })
    }

    fn licence(&self) -> String {
        self.genome.lineage().licence.unwrap_or_default()
    }
}
