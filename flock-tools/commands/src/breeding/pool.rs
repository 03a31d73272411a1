//! `dreams pool`: new pools, their sheep, the artist's marks, merging.
//!
//! Owns the command and most of its actions: `add.rs` and `check.rs` have the others. Never breeds: `breed.rs` does.

use std::path::PathBuf;

use ::breeding::{Census, Folder, Id, LicencePolicy, Mark, Niche, Origin, Settings, Sheep};
use clap::builder::RangedU64ValueParser;
use operations::breeding::{genome, open, open_for_changes, set_marks, today};
use operations::program::{Exit, Fatal, print};
use operations::species::endings;
use species::{Genome, Rng, Threads};

use super::{add, check, sheet};

/// The stream of the random numbers of a pool's name.
const ORIGIN: u64 = 41;

/// Make a pool, look at it, bring in genomes, mark sheep, or merge two pools
///
/// A pool is a folder in which sheep are bred: genomes, and a ledger of all that happened to them. It is cheap: nothing is
/// rendered but small pictures. `dreams breed` adds broods, `dreams votes` takes in what people like, and `dreams elect`
/// makes a flock of the best.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  done; the pool has no fault
  1  the pool has a fault, a genome was refused, there is a pool already, or another program changes it
  2  the command line, the pool or a genome is wrong
  3  a file could not be read or written")]
pub struct Args {
    #[command(subcommand)]
    action: Action,
    /// Answer with one JSON document
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// Bring in genomes from elsewhere
    Add(add::Args),
    /// Look for faults: genomes that are missing, cannot be read, or are not what the ledger says
    Check(check::Args),
    /// Keep sheep, reject them, or take a mark back
    Mark(MarkArgs),
    /// Take in all that happened in another pool
    Merge(MergeArgs),
    /// Make a pool without sheep
    New(NewArgs),
    /// List the sheep: ratings, showings, votes, niches
    Show(ShowArgs),
}

#[derive(Debug, clap::Args)]
pub(super) struct PoolArgs {
    /// Folder of the pool
    pub(super) pool: PathBuf,
}

#[derive(Debug, clap::Args)]
struct MarkArgs {
    #[command(flatten)]
    common: PoolArgs,
    /// How the sheep are marked
    mark: MarkArg,
    /// Ids of sheep; without the pool's name at the end, too
    #[arg(required = true)]
    sheep: Vec<String>,
    /// Only print what would be marked
    #[arg(long)]
    dry_run: bool,
}

/// The artist's marks.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum MarkArg {
    /// Never dies, and counts as liked
    Keep,
    /// Dies, and never lives again
    Reject,
    /// No mark
    None,
}

#[derive(Debug, clap::Args)]
struct MergeArgs {
    #[command(flatten)]
    common: PoolArgs,
    /// Folder of the other pool, which stays as it is
    other: PathBuf,
    /// Only print what would be taken in
    #[arg(long)]
    dry_run: bool,
}

#[derive(Debug, clap::Args)]
struct NewArgs {
    #[command(flatten)]
    common: PoolArgs,
    /// The name of the pool [default: that of its folder]
    #[arg(long)]
    name: Option<String>,
    /// The species that are bred, by the endings of their files
    #[arg(long, value_name = "ENDING", value_delimiter = ',', default_values_t = endings().into_iter().map(str::to_owned))]
    #[arg(value_parser = ending)]
    species: Vec<String>,
    /// The most sheep that live
    #[arg(long, value_name = "N", default_value_t = Settings::limit())]
    #[arg(value_parser = RangedU64ValueParser::<usize>::new().range(Settings::LIMITS))]
    limit: usize,
    /// The seed of all broods, and of the pool's name in the ids of its sheep [default: by chance]. Two pools of one seed
    /// cannot be merged
    #[arg(long, value_parser = clap::value_parser!(u64).range(Settings::SEEDS))]
    seed: Option<u64>,
    /// Sheep with a non-commercial licence are never parents
    #[arg(long)]
    ours: bool,
}

#[derive(Debug, clap::Args)]
struct ShowArgs {
    #[command(flatten)]
    common: PoolArgs,
    /// Also the dead
    #[arg(long)]
    all: bool,
    /// Also write a contact sheet of the sheep, the best first, as PNG
    #[arg(long, value_name = "FILE")]
    sheet: Option<PathBuf>,
}

/// A sheep in an answer.
#[derive(serde::Serialize)]
struct SheepAnswer {
    id: Id,
    species: String,
    alive: bool,
    mark: Mark,
    rating: f64,
    uncertainty: f64,
    /// Votes for, less those against; and those that were to be expected from its showings.
    votes: f64,
    expected: f64,
    family: Id,
    niche: Niche,
    licence: String,
    operator: String,
}

/// The answer to `show --json`.
#[derive(serde::Serialize)]
struct ShowAnswer {
    name: String,
    origin: Origin,
    broods: u32,
    living: usize,
    dead: usize,
    families: usize,
    niches: usize,
    /// Genomes that wait to be strangers of the next broods.
    waiting: usize,
    /// Whether so much was heard from units that a brood is due.
    due: bool,
    sheep: Vec<SheepAnswer>,
}

/// The answer of the other actions.
#[derive(serde::Serialize)]
pub(super) struct Answer {
    pub(super) changed: bool,
    pub(super) sheep: Vec<Id>,
    pub(super) faults: Vec<String>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let json = args.json;
    match &args.action {
        Action::Add(args) => add::run(args, json),
        Action::Check(args) => check::run(args, json),
        Action::Mark(args) => mark(args, json),
        Action::Merge(args) => merge(args, json),
        Action::New(args) => create(args, json),
        Action::Show(args) => show(args, json),
    }
}

/// The ending of the files of a species.
fn ending(text: &str) -> Result<String, String> {
    let known = endings();
    let found = known.iter().find(|ending| ending.eq_ignore_ascii_case(text.trim_start_matches('.')));
    found.map(|ending| (*ending).to_owned()).ok_or_else(|| format!("wanted one of {}", known.join(", ")))
}

fn create(args: &NewArgs, json: bool) -> Result<Exit, Fatal> {
    let PoolArgs { pool } = &args.common;
    let named = || pool.file_name().map_or_else(|| "pool".to_owned(), |name| name.to_string_lossy().into_owned());
    let name = args.name.clone().unwrap_or_else(named);
    let seed = args.seed.unwrap_or_else(|| rand::random::<u32>().into());
    let species: Vec<&str> = args.species.iter().map(String::as_str).collect();
    let origin = args.seed.map_or_else(rand::random, |seed| Rng::stream(seed, ORIGIN).bits());
    let mut settings = Settings::new(&name, Origin::of_bits(origin), seed, &species);
    settings.limit = args.limit;
    settings.licence = if args.ours { LicencePolicy::Ours } else { LicencePolicy::Any };
    let folder = Folder::create(pool, &settings)?;
    if json {
        print::json(&ShowAnswer::of(&folder, false))?;
    } else {
        print::lines([format!("pool `{name}` is there, without sheep; it breeds {}", species.join(", "))])?;
        print::note("note: `dreams breed` fills it by chance; `dreams pool add` brings in genomes");
    }
    Ok(Exit::Fine)
}

fn mark(args: &MarkArgs, json: bool) -> Result<Exit, Fatal> {
    let PoolArgs { pool } = &args.common;
    let mut folder = if args.dry_run { open(pool)? } else { open_for_changes(pool)? };
    let find = |id: &String| folder.pool().find(id).map(|sheep| sheep.born.id).map_err(Fatal::from);
    let ids = args.sheep.iter().map(find).collect::<Result<Vec<Id>, Fatal>>()?;
    let (mark, word) = match args.mark {
        MarkArg::Keep => (Mark::Keep, "kept"),
        MarkArg::Reject => (Mark::Reject, "rejected"),
        MarkArg::None => (Mark::None, "no longer marked"),
    };
    if !args.dry_run {
        let marks: Vec<(Id, Mark)> = ids.iter().map(|id| (*id, mark)).collect();
        set_marks(&mut folder, &marks)?;
    }
    let verb = if args.dry_run { "would be" } else { "is" };
    tell(json, !args.dry_run, &ids, Vec::new(), |id| format!("{id} {verb} {word}"))
}

fn merge(args: &MergeArgs, json: bool) -> Result<Exit, Fatal> {
    let PoolArgs { pool } = &args.common;
    let mut folder = if args.dry_run { open(pool)? } else { open_for_changes(pool)? };
    let other = open(&args.other)?;
    let new: Vec<Id> =
        other.pool().sheep().map(|sheep| sheep.born.id).filter(|id| folder.pool().get(*id).is_none()).collect();
    if !args.dry_run {
        folder.merge(&other)?;
    }
    let verb = if args.dry_run { "would come" } else { "came" };
    tell(json, !args.dry_run, &new, Vec::new(), |id| format!("{id} {verb} from `{}`", args.other.display()))
}

pub(super) fn tell(
    json: bool,
    changed: bool,
    ids: &[Id],
    faults: Vec<String>,
    line: impl Fn(&Id) -> String,
) -> Result<Exit, Fatal> {
    if json {
        print::json(&Answer { changed, sheep: ids.to_vec(), faults })?;
    } else if ids.is_empty() {
        print::note("nothing is new");
    } else {
        print::lines(ids.iter().map(line))?;
    }
    Ok(Exit::Fine)
}

fn show(args: &ShowArgs, json: bool) -> Result<Exit, Fatal> {
    let PoolArgs { pool } = &args.common;
    let folder = open(pool)?;
    let answer = ShowAnswer::of(&folder, args.all);
    if let Some(path) = &args.sheet {
        let threads = Threads::new(0).map_err(|error| Fatal::new(Exit::Unreadable, error))?;
        let born = answer.sheep.iter().filter_map(|sheep| folder.pool().get(sheep.id)).map(|sheep| &sheep.born);
        let genomes = born.map(|born| Ok((born.id.to_string(), genome(&folder, born)?)));
        let genomes = genomes.collect::<Result<Vec<(String, Box<dyn Genome>)>, Fatal>>()?;
        let sheep: Vec<(String, &dyn Genome)> = genomes.iter().map(|(id, genome)| (id.clone(), &**genome)).collect();
        sheet::Sheet::of(&sheep, &threads)?.save(path).map_err(|source| Fatal::write(path, source))?;
    }
    if json {
        print::json(&answer)?;
    } else {
        print::lines(answer.lines())?;
        if answer.due {
            print::note("note: enough was heard from units; `dreams breed` makes the next brood");
        }
    }
    Ok(Exit::Fine)
}

impl ShowAnswer {
    fn of(folder: &Folder, all: bool) -> Self {
        let pool = folder.pool();
        let census = Census::of(pool, today());
        let answer = |sheep: &Sheep| {
            let tally = census.tally(sheep);
            let born = &sheep.born;
            SheepAnswer {
                id: born.id,
                species: born.species.clone(),
                alive: sheep.is_alive(),
                mark: sheep.mark,
                rating: tally.rating(),
                uncertainty: tally.uncertainty(),
                votes: tally.got,
                expected: tally.expected,
                family: sheep.family,
                niche: census.niche(sheep),
                licence: born.licence.clone(),
                operator: born.operator.clone(),
            }
        };
        let mut sheep: Vec<SheepAnswer> = pool.sheep().filter(|sheep| all || sheep.is_alive()).map(answer).collect();
        sheep.sort_by(|a, b| b.rating.total_cmp(&a.rating).then(a.id.cmp(&b.id)));
        let count = |mut values: Vec<String>| {
            values.sort_unstable();
            values.dedup();
            values.len()
        };
        let living = || sheep.iter().filter(|sheep| sheep.alive);
        Self {
            name: pool.settings.name.clone(),
            origin: pool.settings.origin,
            broods: pool.broods(),
            living: pool.living().count(),
            dead: pool.dead().len(),
            families: count(living().map(|sheep| sheep.family.to_string()).collect()),
            niches: count(living().map(|sheep| format!("{:?}", sheep.niche)).collect()),
            waiting: pool.waiting().count(),
            due: pool.is_due(),
            sheep,
        }
    }

    fn lines(&self) -> Vec<String> {
        let heading =
            format!("{:<20} {:>6} {:>8} {:>8}  {:<8} made by", "sheep", "rating", "votes", "expected", "mark");
        let line = |sheep: &SheepAnswer| {
            let mark = match (sheep.alive, sheep.mark) {
                (false, _) => "dead",
                (_, Mark::Keep) => "kept",
                _ => "-",
            };
            let SheepAnswer { id, rating, votes, expected, operator, .. } = sheep;
            format!("{:<20} {rating:>6.2} {votes:>8.1} {expected:>8.1}  {mark:<8} {operator}", id.to_string())
        };
        let sum = format!(
            "{} of {} live, {} dead, {}; {} in {}",
            self.living,
            self.name,
            self.dead,
            print::count(self.broods as usize, "brood"),
            if self.families == 1 { "1 family".to_owned() } else { format!("{} families", self.families) },
            print::count(self.niches, "niche"),
        );
        let waiting = match self.waiting {
            0 => None,
            count => {
                Some(format!("{} to be born", if count == 1 { "1 waits".to_owned() } else { format!("{count} wait") }))
            }
        };
        [heading].into_iter().chain(self.sheep.iter().map(line)).chain([sum]).chain(waiting).collect()
    }
}
