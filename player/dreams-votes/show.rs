//! What would be sent, for people to read.
//!
//! Owns the printing and the copy for the owner: both are the bytes that the updater sends, and nothing else. Totals that were
//! counted before a new ledger began stay in a file of their own, and are copied, too.

use crate::fatal::Fatal;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use votes::{Store, Totals};

/// The name of the copy.
const FILE_NAME: &str = "votes.json";
/// How the names of files of ledgers that ended begin and end.
const KEPT: [&str; 2] = ["votes-", ".json"];

/// Prints the totals in `store`.
/// Errors: [`Fatal`], also if there are none.
pub(crate) fn print(store: &Path) -> Result<(), Fatal> {
    let totals = totals(store)?.ok_or_else(|| Fatal::Nothing { store: store.to_owned() })?;
    writeln!(io::stdout(), "{}", totals.to_json()).map_err(Fatal::Unwritten)
}

/// Writes them to a file in `folder`, if there are some.
/// Errors: [`Fatal`]; the copy before stays.
pub(crate) fn copy(store: &Path, folder: &Path) -> Result<(), Fatal> {
    for kept in kept(store)? {
        let to = folder.join(kept.file_name().unwrap_or_default());
        // It never changes again.
        if !to.exists() {
            durable::copy(&kept, &to).map_err(|source| Fatal::Copy { path: to, source })?;
        }
    }
    let Some(totals) = totals(store)? else { return Ok(()) };
    write(folder.join(FILE_NAME), &totals)
}

/// Keeps the totals of a ledger that ends in a file of its own in `store`.
/// Errors: [`Fatal::Copy`].
pub(crate) fn keep(store: &Path, totals: &Totals) -> Result<(), Fatal> {
    write(store.join(format!("{}{}{}", KEPT[0], totals.ledger, KEPT[1])), totals)
}

fn write(path: PathBuf, totals: &Totals) -> Result<(), Fatal> {
    durable::write(&path, (totals.to_json() + "\n").as_bytes()).map_err(|source| Fatal::Copy { path, source })
}

/// The files of ledgers that ended.
fn kept(store: &Path) -> Result<Vec<PathBuf>, Fatal> {
    let failed = |source| Fatal::Copy { path: store.to_owned(), source };
    let is_kept = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str());
        name.is_some_and(|name| name.starts_with(KEPT[0]) && name.ends_with(KEPT[1]))
    };
    let mut found = Vec::new();
    for entry in fs::read_dir(store).map_err(failed)? {
        found.push(entry.map_err(failed)?.path());
    }
    Ok(found.into_iter().filter(is_kept).collect())
}

fn totals(store: &Path) -> Result<Option<Totals>, Fatal> {
    Ok(Store::open(store)?.1.map(|ledger| ledger.sent()))
}
