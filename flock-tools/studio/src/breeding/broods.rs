//! The broods that were made in the studio, on the disk.
//!
//! Owns the folder `.studio/broods`: a folder for each brood, with the genomes of its cells and a record of what they are. A
//! brood whose making was interrupted is made to its end: the same wish gives the same children. Never makes a child.
//!
//! Start at [`Broods::open`].

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::children::Wish;

/// The folder in the studio's own folder.
const FOLDER: &str = "broods";
/// The record of a brood.
const RECORD: &str = "brood.json";
/// The most broods that the page is told of, the newest first.
const MOST_TOLD: usize = 200;
/// The operator of a cell that shows a parent.
pub(crate) const PARENT: &str = "parent";

/// A brood.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct BroodRecord {
    /// `b` and a number.
    pub(crate) id: String,
    /// The sheep that all are made of; none of strangers.
    pub(crate) parents: Vec<String>,
    /// The species of strangers, by the ending of its files.
    pub(crate) species: Option<String>,
    pub(crate) wish: Wish,
    /// When it was asked for, in milliseconds since 1970.
    pub(crate) at_ms: u64,
    /// The parents first.
    pub(crate) cells: Vec<Cell>,
}

/// A place in a brood.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Cell {
    /// That of the brood, a hyphen and a number; of a parent its own.
    pub(crate) id: String,
    pub(crate) parents: Vec<String>,
    /// The operator that made it; empty until then.
    pub(crate) op: String,
    /// The ending of its species; empty until it is made.
    pub(crate) species: String,
    pub(crate) state: CellState,
    /// Why there is nothing in it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) error: Option<String>,
}

/// What became of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum CellState {
    /// It waits.
    Queued,
    /// It is being made.
    Running,
    /// Its genome is there.
    There,
    /// Nothing could be made.
    Failed,
}

/// The broods of a flock's studio.
#[derive(Debug)]
pub(crate) struct Broods {
    folder: PathBuf,
    /// The oldest first.
    known: Vec<BroodRecord>,
}

impl Broods {
    /// The broods in the studio's own folder `own`. A record that cannot be read is passed over.
    pub(crate) fn open(own: &Path) -> Self {
        let folder = own.join(FOLDER);
        let entries = fs::read_dir(&folder).into_iter().flatten();
        let read = |path: PathBuf| serde_json::from_slice(&fs::read(path.join(RECORD)).ok()?).ok();
        let mut known: Vec<BroodRecord> =
            entries.filter_map(|entry| read(entry.ok()?.path())).filter(|it: &BroodRecord| is_name(&it.id)).collect();
        known.sort_by_key(|brood| (number(&brood.id), brood.at_ms));
        Self { folder, known }
    }

    /// Those that the page is told of, the newest first.
    pub(crate) fn newest(&self) -> impl Iterator<Item = &BroodRecord> {
        self.known.iter().rev().take(MOST_TOLD)
    }

    /// The brood `id`.
    pub(crate) fn find(&self, id: &str) -> Option<&BroodRecord> {
        self.known.iter().find(|brood| brood.id == id)
    }

    /// Those with cells that are not made yet.
    pub(crate) fn unfinished(&self) -> Vec<BroodRecord> {
        let waits = |cell: &Cell| matches!(cell.state, CellState::Queued | CellState::Running);
        self.known.iter().filter(|brood| brood.cells.iter().any(waits)).cloned().collect()
    }

    /// A new brood of `count` cells: the `parents`, with their species, and children that wait.
    /// Errors: If it cannot be written.
    pub(crate) fn begin(
        &mut self,
        parents: &[(String, String)],
        species: Option<String>,
        wish: Wish,
        count: usize,
        at_ms: u64,
    ) -> io::Result<BroodRecord> {
        let next = self.known.iter().map(|brood| number(&brood.id)).max().unwrap_or(0) + 1;
        let id = format!("b{next:04}");
        let ids: Vec<String> = parents.iter().map(|(id, _)| id.clone()).collect();
        let parent = |(id, species): &(String, String)| Cell {
            id: id.clone(),
            parents: Vec::new(),
            op: PARENT.to_owned(),
            species: species.clone(),
            state: CellState::There,
            error: None,
        };
        let child = |at: usize| Cell {
            id: format!("{id}-{at:02}"),
            parents: ids.clone(),
            op: String::new(),
            species: String::new(),
            state: CellState::Queued,
            error: None,
        };
        let children = (1..=count.saturating_sub(parents.len())).map(child);
        let cells = parents.iter().map(parent).chain(children).collect();
        let brood = BroodRecord { id, parents: ids, species, wish, at_ms, cells };
        fs::create_dir_all(self.folder.join(&brood.id))?;
        self.write(&brood)?;
        self.known.push(brood.clone());
        Ok(brood)
    }

    /// Keeps a genome that was made elsewhere in the studio, as a brood of one cell; returns the cell's id.
    /// Errors: If it cannot be written.
    pub(crate) fn keep_genome(&mut self, ending: &str, text: &str, at_ms: u64) -> io::Result<String> {
        let wish = Wish { strength: 0.5, locks: Vec::new(), seed: 0 };
        let brood = self.begin(&[], Some(ending.to_owned()), wish, 1, at_ms)?;
        let first = brood.cells.first().cloned().ok_or(io::ErrorKind::InvalidData)?;
        durable::write(&self.genome(&brood.id, &first.id, ending), text.as_bytes())?;
        let (id, op, species) = (first.id.clone(), "globe".to_owned(), ending.to_owned());
        self.set(&brood.id, Cell { op, species, state: CellState::There, ..first })?;
        Ok(id)
    }

    /// Sets a cell of a brood.
    /// Errors: If it cannot be written.
    pub(crate) fn set(&mut self, brood: &str, cell: Cell) -> io::Result<()> {
        let Some(known) = self.known.iter_mut().find(|known| known.id == brood) else { return Ok(()) };
        if let Some(own) = known.cells.iter_mut().find(|own| own.id == cell.id) {
            *own = cell;
        }
        let known = known.clone();
        self.write(&known)
    }

    /// The file of a cell's genome, of the species `ending`.
    pub(crate) fn genome(&self, brood: &str, cell: &str, ending: &str) -> PathBuf {
        self.folder.join(brood).join(format!("{cell}.{ending}"))
    }

    /// The child `id` of any brood, if it was made.
    pub(crate) fn find_cell(&self, id: &str) -> Option<Cell> {
        let brood = self.find(id.split_once('-')?.0)?;
        let is_own = |cell: &&Cell| cell.id == id && cell.op != PARENT && cell.state == CellState::There;
        brood.cells.iter().find(is_own).cloned()
    }

    /// Its genome.
    pub(crate) fn find_genome(&self, id: &str) -> Option<PathBuf> {
        let cell = self.find_cell(id)?;
        Some(self.genome(id.split_once('-')?.0, id, &cell.species))
    }

    fn write(&self, brood: &BroodRecord) -> io::Result<()> {
        let text = serde_json::to_vec(brood)?;
        durable::write(&self.folder.join(&brood.id).join(RECORD), &text)
    }
}

/// Whether `id` is that of a brood: it is part of a path.
fn is_name(id: &str) -> bool {
    id.strip_prefix('b').is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit()))
}

fn number(id: &str) -> u64 {
    id.trim_start_matches('b').parse().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wish() -> Wish {
        Wish { strength: 0.5, locks: Vec::new(), seed: 1 }
    }

    #[test]
    fn a_brood_is_the_same_after_a_restart_and_the_next_one_has_another_name() {
        let scratch = tempfile::tempdir().unwrap();
        let mut broods = Broods::open(scratch.path());
        let parents = [("orchid".to_owned(), "flam3".to_owned())];
        let first = broods.begin(&parents, None, wish(), 4, 5).unwrap();
        let ids: Vec<&str> = first.cells.iter().map(|cell| cell.id.as_str()).collect();
        assert_eq!(ids, ["orchid", "b0001-01", "b0001-02", "b0001-03"]);
        let done =
            Cell { op: "affine".into(), species: "flam3".into(), state: CellState::There, ..first.cells[2].clone() };
        broods.set(&first.id, done).unwrap();
        let mut again = Broods::open(scratch.path());
        assert_eq!(again.known, broods.known);
        assert_eq!(again.unfinished().len(), 1);
        assert!(again.find_genome("b0001-02").unwrap().ends_with("broods/b0001/b0001-02.flam3"));
        assert_eq!((again.find_genome("b0001-01"), again.find_genome("../x-1")), (None, None));
        assert_eq!(again.begin(&[], Some("expr".into()), wish(), 2, 6).unwrap().id, "b0002");
    }

    #[test]
    fn a_record_of_another_name_is_passed_over() {
        let scratch = tempfile::tempdir().unwrap();
        let mut broods = Broods::open(scratch.path());
        broods.begin(&[], Some("expr".into()), wish(), 2, 6).unwrap();
        let record = scratch.path().join("broods/b0001/brood.json");
        let text = fs::read_to_string(&record).unwrap();
        fs::write(&record, text.replacen("b0001", "../../x", 1)).unwrap();
        assert_eq!(Broods::open(scratch.path()).newest().count(), 0);
    }
}
