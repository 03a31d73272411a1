//! `dreams pool check`: faults of a pool.
//!
//! Owns the action: genomes against the ledger and, on demand, pictures of the living against what a brood accepts. Never
//! mends.

use ::breeding::{Born, Folder};
use flame::Backend;
use operations::breeding::nursery::figures;
use operations::breeding::{genome, open, waiting};
use operations::program::{Exit, Fatal, chain, print};
use operations::species as kinds;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use species::{FigureFault, Threads};

use super::pool::{Answer, PoolArgs};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: PoolArgs,
    /// Also draw every living sheep again, and name those that no brood would take: black, still, strobing, ...
    #[arg(long)]
    look: bool,
}

/// Runs the action.
pub(super) fn run(args: &Args, json: bool) -> Result<Exit, Fatal> {
    let folder = open(&args.common.pool)?;
    let mut faults: Vec<String> = folder
        .missing_genomes()
        .map(|born| format!("the genome of {} is missing: `{}`", born.id, folder.genome(born).display()))
        .collect();
    faults.extend(folder.pool().sheep().filter_map(|sheep| wrong_genome(&folder, &sheep.born)));
    faults.extend(waiting(&folder).err().map(|fatal| fatal.in_words()));
    if args.look {
        faults.extend(looks(&folder)?);
    }
    let exit = if faults.is_empty() { Exit::Fine } else { Exit::No };
    let none = || format!("no fault in {}", print::count(folder.pool().sheep().count(), "genome"));
    if json {
        print::json(&Answer { changed: false, sheep: Vec::new(), faults })?;
    } else {
        print::lines(if faults.is_empty() { vec![none()] } else { faults })?;
    }
    Ok(exit)
}

/// What is wrong with the genome of a sheep, if it is there.
fn wrong_genome(folder: &Folder, born: &Born) -> Option<String> {
    let path = folder.genome(born);
    if !path.is_file() {
        return None;
    }
    match kinds::read(&path, &Backend::default()) {
        Err(why) => Some(format!("the genome of {} is refused: {}", born.id, why.source)),
        Ok(genome) => {
            let said = genome.lineage().id;
            let is_own = said.as_deref() == Some(&born.id.to_string());
            let said = said.unwrap_or_else(|| "nobody".to_owned());
            (!is_own).then(|| format!("the genome of {} says that it is of {said}", born.id))
        }
    }
}

/// What is wrong with pictures of the living.
fn looks(folder: &Folder) -> Result<Vec<String>, Fatal> {
    let living: Vec<&Born> = folder.pool().living().map(|sheep| &sheep.born).collect();
    let look = |born: &&Born| {
        let genome = genome(folder, born).ok()?;
        let wrong = match figures(&*genome) {
            Err(error) => format!("not drawn: {}", chain(&error)),
            Ok(figures) => figures.faults().into_iter().map(FigureFault::name).collect::<Vec<_>>().join(", "),
        };
        (!wrong.is_empty()).then(|| format!("{} is {wrong}", born.id))
    };
    let threads = Threads::new(0).map_err(|error| Fatal::new(Exit::Unreadable, error))?;
    Ok(threads.run(|| living.par_iter().filter_map(look).collect()))
}
