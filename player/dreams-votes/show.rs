//! What would be sent, for people to read.
//!
//! Owns the printing and the copy for the owner: both are the bytes that the updater sends, and nothing else.

use crate::fatal::Fatal;
use std::io::{self, Write};
use std::path::Path;
use votes::{Store, Totals};

/// The name of the copy.
const FILE_NAME: &str = "votes.json";

/// Prints the totals in `store`.
/// Errors: [`Fatal`], also if there are none.
pub(crate) fn print(store: &Path) -> Result<(), Fatal> {
    let totals = totals(store)?.ok_or_else(|| Fatal::Nothing { store: store.to_owned() })?;
    writeln!(io::stdout(), "{}", totals.to_json()).map_err(Fatal::Unwritten)
}

/// Writes them to a file in `folder`, if there are some.
/// Errors: [`Fatal`]; the copy before stays.
pub(crate) fn copy(store: &Path, folder: &Path) -> Result<(), Fatal> {
    let Some(totals) = totals(store)? else { return Ok(()) };
    let path = folder.join(FILE_NAME);
    durable::write(&path, (totals.to_json() + "\n").as_bytes()).map_err(|source| Fatal::Copy { path, source })
}

fn totals(store: &Path) -> Result<Option<Totals>, Fatal> {
    Ok(Store::open(store)?.1.map(|ledger| ledger.sent()))
}
