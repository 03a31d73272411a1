//! `dreams rename`: another id for a sheep.
//!
//! Owns the command and the order of its steps: files get their new names, the manifest is saved, the old names are removed.
//! So at every moment the files that the manifest names are there.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use flock::SheepId;
use operations::program::{Exit, Fatal, print};

use super::EditSession;
use super::files;
use crate::ids;

/// Give a sheep another id
///
/// Its transitions follow, and so do its credits, and the names of its genome and clips where they are named after it. In
/// the manifest, only these ids and paths change.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the sheep is renamed
  1  another file has the new name, or the credits have an entry for it; nothing was changed
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// Its id
    #[arg(value_parser = SheepId::new, add = ids::completer())]
    old: SheepId,
    /// Its new id
    #[arg(value_parser = SheepId::new)]
    new: SheepId,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// Why a file was not renamed.
#[derive(Debug, thiserror::Error)]
enum RenameError {
    #[error("cannot rename `{old}` to `{new}`")]
    Move { old: PathBuf, new: PathBuf, source: io::Error },
    #[error("cannot rename `{old}` to `{new}`: another file has that name")]
    Occupied { old: PathBuf, new: PathBuf },
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let Args { old, new, .. } = args;
    let mut session = EditSession::start(&args.dir)?;
    let mut moves = BTreeMap::new();
    session.edit(|edit| {
        moves = edit.rename_with_files(old, new)?;
        Ok(())
    })?;
    session.rename_credits(old, new)?;
    let there: Vec<_> = moves.iter().filter(|(old, _)| old.inside(&args.dir).exists()).collect();
    session.draft.writes(there.iter().map(|(_, new)| new.as_str()));
    for (old, new) in &there {
        copy(&old.inside(&args.dir), &new.inside(&args.dir))?;
    }
    let count = there.len();
    let result = session.save()?;
    result.delete_files()?;
    let files = match count {
        0 => String::new(),
        count => format!(", and {}", print::count(count, "file")),
    };
    result.print(&format!("renamed `{old}` to `{new}`{files}"), args.json)
}

/// Copies the file `old` to `new`, for a moment or for good: a sheep of another name may have the same clip. A hard link
/// would give one file to both.
fn copy(old: &Path, new: &Path) -> Result<(), Fatal> {
    let (from, to) = (old.to_owned(), new.to_owned());
    let cannot =
        |source| Fatal::new(Exit::Unreadable, RenameError::Move { old: from.clone(), new: to.clone(), source });
    if new.exists() {
        // An interrupted run may have left the same file.
        let same = files::same_bytes(old, new).map_err(cannot)?;
        let occupied = RenameError::Occupied { old: old.to_owned(), new: new.to_owned() };
        return if same { Ok(()) } else { Err(Fatal::new(Exit::No, occupied)) };
    }
    durable::copy(old, new).map_err(cannot)
}
