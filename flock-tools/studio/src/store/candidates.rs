//! Sheep that are not in the flock and may come in: those of its pool, and genomes of an archive.
//!
//! Owns what is known of them, read again when the pool's ledger or the archive has changed, and the artist's marks in the pool.
//!
//! Start at [`Candidates::all`].

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::SystemTime;

use ::breeding::{Event, Folder, LEDGER, Mark, Sheep};
use flock::SheepId;
use operations::breeding as pools;
use operations::program::Fatal;
use operations::species::endings;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::genomes::Genomes;
use crate::document::MarkKind;
use crate::lock::locked;

/// The most genomes of an archive that are looked at.
const MOST: usize = 20_000;
/// How deep folders of an archive may lie.
const DEPTH: usize = 3;

/// A sheep that may come into the flock.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Candidate {
    pub(crate) id: SheepId,
    /// Its genome's file.
    pub(crate) path: PathBuf,
    /// `pool` or `archive`.
    pub(crate) source: &'static str,
    /// Its species, by the ending of its files.
    pub(crate) species: Option<String>,
    pub(crate) licence: Option<String>,
    pub(crate) authors: Vec<String>,
    pub(crate) parents: Vec<String>,
    pub(crate) made_ms: Option<u64>,
}

/// The places that candidates are in.
#[derive(Debug)]
pub(crate) struct Candidates {
    /// The folder of the pool, whether there is one yet or not.
    pub(crate) pool: PathBuf,
    archive: Option<PathBuf>,
    known: Mutex<Option<Known>>,
}

/// What was read, and when the pool and the archive were changed last.
#[derive(Clone, Debug)]
struct Known {
    stamp: Stamp,
    all: Arc<Vec<Candidate>>,
    votes: Arc<VoteCounts>,
    marks: Arc<PoolMarks>,
}

/// Votes for and against, by the ids of sheep.
pub(crate) type VoteCounts = BTreeMap<String, [u64; 2]>;

/// The artist's marks in the pool, of all its sheep.
pub(crate) type PoolMarks = BTreeMap<SheepId, MarkKind>;

type Stamp = [Option<(u64, SystemTime)>; 2];

impl Candidates {
    /// Those of the pool in one folder and of the archive in another.
    pub(crate) fn new(pool: PathBuf, archive: Option<PathBuf>) -> Self {
        Self { pool, archive, known: Mutex::default() }
    }

    /// The pool, if there is one.
    /// Errors: If it cannot be read.
    pub(crate) fn folder(&self) -> Result<Option<Folder>, Fatal> {
        let is_there = self.pool.join(::breeding::SETTINGS).exists();
        is_there.then(|| pools::open(&self.pool)).transpose()
    }

    /// All of them, in the order of their ids; the pool's first. A pool that cannot be read has none: the page is told why
    /// when it breeds.
    pub(crate) fn all(&self, genomes: &Genomes) -> Arc<Vec<Candidate>> {
        self.known(genomes).all
    }

    /// The votes that the pool was told.
    pub(crate) fn votes(&self, genomes: &Genomes) -> Arc<VoteCounts> {
        self.known(genomes).votes
    }

    /// How the pool has marked its sheep.
    pub(crate) fn marks(&self, genomes: &Genomes) -> Arc<PoolMarks> {
        self.known(genomes).marks
    }

    /// Has the pool mark sheep of its own, as `dreams pool mark` does.
    /// Errors: If the pool cannot be opened for changes, or its ledger not be written.
    pub(crate) fn set_marks(&self, marks: &[(SheepId, MarkKind)]) -> Result<(), Fatal> {
        if marks.is_empty() {
            return Ok(());
        }
        let mut folder = pools::open_for_changes(&self.pool)?;
        let in_pool = |(id, kind): &(SheepId, MarkKind)| {
            let sheep = folder.pool().find(id.as_str())?;
            let mark = match kind {
                MarkKind::Kept => Mark::Keep,
                MarkKind::None => Mark::None,
                MarkKind::Rejected => Mark::Reject,
            };
            Ok((sheep.born.id, mark))
        };
        let marks = marks.iter().map(in_pool).collect::<Result<Vec<_>, Fatal>>()?;
        pools::set_marks(&mut folder, &marks)
    }

    fn known(&self, genomes: &Genomes) -> Known {
        let stamp = [Some(self.pool.join(LEDGER)), self.archive.clone()].map(|path| {
            let status = fs::metadata(path?).ok()?;
            Some((status.len(), status.modified().ok()?))
        });
        let mut known = locked(&self.known);
        if let Some(known) = known.as_ref().filter(|known| known.stamp == stamp) {
            return known.clone();
        }
        let folder = self.folder().ok().flatten();
        let mut all = folder.as_ref().map_or_else(Vec::new, of_pool);
        all.extend(self.archive.iter().flat_map(|archive| of_archive(archive, genomes)));
        let votes = Arc::new(folder.as_ref().map_or_else(VoteCounts::new, votes));
        let marks = Arc::new(folder.as_ref().map_or_else(PoolMarks::new, marks));
        known.insert(Known { stamp, all: Arc::new(all), votes, marks }).clone()
    }
}

fn marks(folder: &Folder) -> PoolMarks {
    let mark = |sheep: &Sheep| {
        let kind = match sheep.mark {
            Mark::Keep => MarkKind::Kept,
            Mark::None => MarkKind::None,
            Mark::Reject => MarkKind::Rejected,
        };
        Some((SheepId::new(&sheep.born.id.to_string()).ok()?, kind))
    };
    folder.pool().sheep().filter_map(mark).collect()
}

fn votes(folder: &Folder) -> VoteCounts {
    let mut counts = VoteCounts::new();
    for entry in folder.ledger().entries() {
        let Event::Votes { sheep, .. } = &entry.event else { continue };
        for (id, count) in sheep {
            let sum = counts.entry(id.clone()).or_default();
            *sum = [sum[0].saturating_add(count.up), sum[1].saturating_add(count.down)];
        }
    }
    counts
}

fn of_pool(folder: &Folder) -> Vec<Candidate> {
    let candidate = |sheep: &Sheep| {
        let born = &sheep.born;
        let path = folder.genome(born);
        Some(Candidate {
            id: SheepId::new(&born.id.to_string()).ok()?,
            made_ms: made_ms(&path),
            path,
            source: "pool",
            species: Some(born.species.clone()),
            licence: Some(born.licence.clone()).filter(|licence| !licence.is_empty()),
            authors: Vec::new(),
            parents: born.parents.iter().map(ToString::to_string).collect(),
        })
    };
    // Whoever was rejected is still there: the artist may take that back.
    let is_there = |sheep: &&Sheep| sheep.died.is_none() || sheep.mark == Mark::Reject;
    folder.pool().sheep().filter(is_there).filter_map(candidate).collect()
}

fn of_archive(archive: &Path, genomes: &Genomes) -> Vec<Candidate> {
    let mut files = Vec::new();
    list(archive, DEPTH, &mut files);
    let candidate = |path: &PathBuf| {
        let facts = genomes.facts(path);
        let lineage = facts.lineage.clone().unwrap_or_default();
        Some(Candidate {
            id: SheepId::new(path.file_stem()?.to_str()?).ok()?,
            path: path.clone(),
            source: "archive",
            species: facts.species.map(str::to_owned),
            licence: lineage.licence,
            authors: lineage.authors,
            parents: lineage.parents,
            made_ms: made_ms(path),
        })
    };
    let mut all: Vec<Candidate> = files.par_iter().filter_map(candidate).collect();
    all.sort_by(|a, b| a.id.cmp(&b.id).then_with(|| a.path.cmp(&b.path)));
    all.dedup_by(|a, b| a.id == b.id);
    all
}

/// The files of genomes in `folder`, and in folders in it.
fn list(folder: &Path, depth: usize, files: &mut Vec<PathBuf>) {
    let endings = endings();
    for entry in fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok) {
        let path = entry.path();
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        if path.is_dir() && depth > 0 && files.len() < MOST {
            list(&path, depth - 1, files);
        } else if endings.contains(&ending) && files.len() < MOST {
            files.push(path);
        }
    }
}

fn made_ms(path: &Path) -> Option<u64> {
    fs::metadata(path).and_then(|status| status.modified()).ok().map(super::clip_states::since_1970_ms)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_archive_has_its_genomes_by_their_names_and_a_missing_pool_has_none() {
        let scratch = tempfile::tempdir().unwrap();
        let genomes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../demo/genomes");
        let inner = scratch.path().join("1998");
        fs::create_dir(&inner).unwrap();
        fs::copy(genomes.join("orchid.flam3"), inner.join("orchid.flam3")).unwrap();
        fs::write(scratch.path().join("no id.flam3"), "<flame/>").unwrap();
        fs::write(scratch.path().join("notes.txt"), "<flame/>").unwrap();
        let candidates = Candidates::new(scratch.path().join("pool"), Some(scratch.path().to_owned()));
        let all = candidates.all(&Genomes::default());
        let told: Vec<_> = all.iter().map(|own| (own.id.as_str(), own.source, own.species.as_deref())).collect();
        assert_eq!(told, [("orchid", "archive", Some("flam3"))]);
        assert!(candidates.folder().unwrap().is_none());
    }
}
