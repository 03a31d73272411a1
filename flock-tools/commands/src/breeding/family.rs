//! `dreams family POOL ID`: ancestors and children of a sheep.
//!
//! Owns the command and its answer.

use std::path::PathBuf;

use ::breeding::{Id, Pool, Sheep};
use operations::breeding::open;
use operations::program::{Exit, Fatal, print};

/// Print the ancestors and the children of a sheep
///
/// Each with how it was made, its licence, and whether it lives.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  its family is printed
  1  does not occur
  2  the command line or the pool is wrong, or there is no such sheep
  3  a file could not be read")]
pub struct Args {
    /// Folder of the pool
    pool: PathBuf,
    /// The sheep
    sheep: String,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// A relative in the answer.
#[derive(serde::Serialize)]
struct Relative {
    id: Id,
    parents: Vec<Id>,
    operator: String,
    species: String,
    licence: String,
    alive: bool,
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct Answer {
    sheep: Relative,
    /// The founder that it descends from.
    family: Id,
    /// The nearest first.
    ancestors: Vec<Relative>,
    children: Vec<Relative>,
}

impl Relative {
    fn of(sheep: &Sheep) -> Self {
        let born = &sheep.born;
        Self {
            id: born.id,
            parents: born.parents.clone(),
            operator: born.operator.clone(),
            species: born.species.clone(),
            licence: born.licence.clone(),
            alive: sheep.is_alive(),
        }
    }

    fn line(&self) -> String {
        let parents: Vec<String> = self.parents.iter().map(ToString::to_string).collect();
        let of = if parents.is_empty() { String::new() } else { format!(" of {}", parents.join(" and ")) };
        let dead = if self.alive { "" } else { ", dead" };
        let licence = if self.licence.is_empty() { "no licence" } else { &self.licence };
        format!("{} {} by {}{of}, {licence}{dead}", self.id, self.species, self.operator)
    }
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let folder = open(&args.pool)?;
    let answer = answer(folder.pool(), &args.sheep)?;
    if args.json {
        print::json(&answer)?;
        return Ok(Exit::Fine);
    }
    let under = |heading: &str, all: &[Relative]| {
        let heading = if all.is_empty() { None } else { Some(heading.to_owned()) };
        heading.into_iter().chain(all.iter().map(|relative| format!("  {}", relative.line()))).collect::<Vec<_>>()
    };
    let own = [answer.sheep.line(), format!("family {}", answer.family)];
    let rest = [under("ancestors", &answer.ancestors), under("children", &answer.children)].concat();
    print::lines(own.into_iter().chain(rest))?;
    Ok(Exit::Fine)
}

fn answer(pool: &Pool, id: &str) -> Result<Answer, Fatal> {
    let sheep = pool.find(id)?;
    Ok(Answer {
        sheep: Relative::of(sheep),
        family: sheep.family,
        ancestors: pool.ancestors(sheep.born.id).into_iter().map(Relative::of).collect(),
        children: pool.children(sheep.born.id).map(Relative::of).collect(),
    })
}
