//! The commands that edit a flock's manifest, and the list of its sheep.
//!
//! Owns what they have in common: the manifest is locked, edited, checked and saved, and the effect on the balance is
//! printed. All edits of one command are saved at once. An edit breaks a flock if a sheep that was shown no longer would
//! be; adding never does, since a sheep that is not yet linked is merely not shown. Each command has its own module.
//!
//! Start at [`EditSession`].

pub mod add;
pub mod drop;
mod files;
mod hints;
pub mod link;
pub mod list;
pub mod new;
pub mod prune;
pub mod rename;
pub mod repeat;
mod selection;
pub mod unlink;
pub mod want;
pub mod weight;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use flock::Draft;
use flock::{ClipPath, Edit, EditError, Fault, Flock, FlockShares, Manifest, Sheep, SheepId};
use operations::credits::{CreditsFile, Subject};
use operations::flock_folder::paths;
use operations::program::{Exit, Fatal, print};

use selection::Chosen;

/// The most faults that are printed after an edit; `dreams check` prints all.
const MOST_FAULTS: usize = 3;
/// The most files of a kind that are printed after an edit; `--json` tells all.
const MOST_FILES: usize = 10;
/// Worst ratios closer than this count as the same.
const SAME: f64 = 1e-9;

/// A flock that one command edits.
struct EditSession {
    folder: PathBuf,
    draft: Draft,
    before: FlockState,
    /// The flock's credits, or why they cannot be read; an edit that they do not concern does without them.
    credits: Result<CreditsFile, Fatal>,
    /// What has an entry there.
    credited: BTreeSet<Subject>,
}

/// The state of a flock, by its manifest alone.
struct FlockState {
    /// All its sheep.
    sheep: BTreeSet<SheepId>,
    /// The sheep that the walk plays.
    shown: BTreeSet<SheepId>,
    /// `None` while a sheep is never shown.
    worst_ratio: Option<f64>,
    faults: Vec<Fault>,
    /// The number of its sheep and transitions.
    entries: usize,
    /// Every file that the manifest names.
    files: BTreeSet<ClipPath>,
}

/// The flock before and after a command.
struct EditResult {
    folder: PathBuf,
    before: FlockState,
    after: FlockState,
    /// Whether the manifest was saved.
    changed: bool,
}

/// What the commands take alike that take something out.
#[derive(Debug, clap::Args)]
struct RemovalArgs {
    /// Delete their genomes and clips too, unless something else names them
    #[arg(long)]
    delete_files: bool,
    /// Do it even if that breaks the flock
    #[arg(long)]
    force: bool,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct Answer<'a> {
    /// Whether the manifest was saved: not if the edit was refused, or only proposed.
    changed: bool,
    /// `null` while a sheep is never shown, here and below.
    worst_ratio_before: Option<f64>,
    worst_ratio_after: Option<f64>,
    /// Those of the manifest after the edit: clips are not opened.
    faults: &'a [Fault],
    /// Sheep of the flock that were shown and no longer are.
    no_longer_shown: Vec<&'a SheepId>,
    /// Files that the manifest named, names no longer, and that are still there.
    unreferenced: Vec<&'a ClipPath>,
    /// Files that the manifest now names and that are not there yet.
    missing: Vec<&'a ClipPath>,
}

/// An edit that was refused.
#[derive(Debug, thiserror::Error)]
enum Refusal {
    #[error("{edit}, the flock would have no sheep")]
    Empty { edit: String },
    #[error("{edit}, {count} sheep that the walk shows would no longer be shown, `{first}` first")]
    Unshown { edit: String, count: usize, first: SheepId },
}

impl<'a> Answer<'a> {
    /// The answer without the files.
    fn of(changed: bool, before: &'a FlockState, after: &'a FlockState) -> Self {
        Self {
            changed,
            worst_ratio_before: before.worst_ratio,
            worst_ratio_after: after.worst_ratio,
            faults: &after.faults,
            no_longer_shown: lost(before, after),
            unreferenced: Vec::new(),
            missing: Vec::new(),
        }
    }
}

impl EditSession {
    /// Locks and reads the flock in `folder`, which may be without sheep.
    fn start(folder: &Path) -> Result<Self, Fatal> {
        let draft = Draft::lock(folder)?;
        let before = FlockState::of(draft.edit.shared_manifest());
        let credits = CreditsFile::read(folder);
        let credited = credits.as_ref().map_or_else(|_| BTreeSet::new(), |file| file.named_in(draft.edit.manifest()));
        Ok(Self { folder: folder.to_owned(), draft, before, credits, credited })
    }

    /// The manifest as edited so far.
    fn manifest(&self) -> &Manifest {
        self.draft.edit.manifest()
    }

    /// Makes an edit.
    fn edit(&mut self, edit: impl FnOnce(&mut Edit) -> Result<(), EditError>) -> Result<(), Fatal> {
        edit(&mut self.draft.edit).map_err(|error| hints::refused(error, self.manifest()))
    }

    /// Gives the credits of the sheep `old` to `new`.
    fn rename_credits(&mut self, old: &SheepId, new: &SheepId) -> Result<(), Fatal> {
        let mut file = CreditsFile::read(&self.folder)?;
        file.rename(old, new)?;
        self.credits = Ok(file);
        Ok(())
    }

    /// Saves a removal, and prints that it was `done`.
    /// Errors: If it breaks the flock, unless that is forced; `edit` begins the sentence.
    fn remove(self, edit: String, done: &str, args: &RemovalArgs) -> Result<Exit, Fatal> {
        self.refuse_breaking(edit, args)?;
        let result = self.save()?;
        if args.delete_files {
            result.delete_files()?;
        }
        result.print(done, args.json)
    }

    fn refuse_breaking(&self, edit: String, args: &RemovalArgs) -> Result<(), Fatal> {
        let after = FlockState::of(self.draft.edit.shared_manifest());
        let lost = lost(&self.before, &after);
        let refused = match lost.first() {
            _ if args.force => return Ok(()),
            _ if self.manifest().sheep.is_empty() => Refusal::Empty { edit },
            Some(first) => Refusal::Unshown { edit, count: lost.len(), first: (*first).clone() },
            None => return Ok(()),
        };
        if args.json {
            print::json(&Answer::of(false, &self.before, &after))?;
        }
        Err(Fatal::new(Exit::No, refused).hint("--force does it all the same"))
    }

    /// Saves the manifest, and takes what it has no longer out of the credits.
    /// Errors: If the credits are malformed and the edit concerns them; nothing is saved.
    fn save(self) -> Result<EditResult, Fatal> {
        let after = FlockState::of(self.draft.edit.shared_manifest());
        let shrinks = after.entries < self.before.entries;
        let credits = match self.credits {
            Err(fatal) if shrinks => return Err(fatal),
            Ok(mut file) => {
                let stays = file.named_in(self.draft.edit.manifest());
                file.remove(&self.credited.difference(&stays).cloned().collect())?;
                Some(file)
            }
            Err(_) => None,
        };
        let mut draft = self.draft;
        draft.writes([paths::CREDITS]);
        let turn = draft.save_and_hold()?;
        credits.map_or(Ok(()), |file| file.save())?;
        drop(turn);
        Ok(EditResult { folder: self.folder, before: self.before, after, changed: true })
    }

    /// What saving would do. The manifest stays as it was.
    fn preview(self) -> EditResult {
        let after = FlockState::of(self.draft.edit.shared_manifest());
        EditResult { folder: self.folder, before: self.before, after, changed: false }
    }

    /// That the sheep `chosen` have now what `has` says, and one sheep the figure `was` before.
    fn told(&self, chosen: &Chosen, has: &str, was: impl Fn(&Sheep) -> String) -> String {
        let own = self.manifest().sheep.iter().find(|sheep| chosen.sheep.contains(&sheep.id));
        match own.filter(|_| chosen.sheep.len() == 1) {
            Some(sheep) => format!("`{}` has {has}, was {}", sheep.id, was(sheep)),
            None => format!("{} have {has}", chosen.told()),
        }
    }
}

impl FlockState {
    fn of(manifest: Arc<Manifest>) -> Self {
        let flock = Flock::new(manifest);
        let manifest = flock.manifest();
        let genomes = manifest.sheep.iter().filter_map(|sheep| sheep.genome.as_ref());
        let files = manifest.clips().map(|clip| &clip.path).chain(genomes).cloned().collect();
        let faults = flock.faults().to_vec();
        let shown =
            flock.graph().sheep().filter(|_| flock.is_walkable()).map(|sheep| flock.id(sheep).clone()).collect();
        let worst_ratio = FlockShares::of(&flock).filter(|_| flock.is_walkable()).and_then(|shares| shares.worst_ratio);
        let sheep = manifest.sheep.iter().map(|sheep| sheep.id.clone()).collect();
        let entries = manifest.sheep.len() + manifest.transitions.len();
        Self { sheep, shown, worst_ratio, faults, entries, files }
    }
}

impl EditResult {
    /// Deletes the files that the manifest no longer names.
    fn delete_files(&self) -> Result<(), Fatal> {
        for path in self.unreferenced() {
            let path = path.inside(&self.folder);
            fs::remove_file(&path).map_err(|source| Fatal::file("delete", &path, source))?;
        }
        Ok(())
    }

    /// Prints what was `done`, its effect on the balance, and what the flock still lacks.
    fn print(&self, done: &str, json: bool) -> Result<Exit, Fatal> {
        if json {
            print::json(&self.answer())?;
            return Ok(Exit::Fine);
        }
        print::lines([done.to_owned(), balance(self.before.worst_ratio, self.after.worst_ratio)])?;
        note_files(&self.missing(), "not there yet; `dreams render` makes it", "not there yet");
        note_files(&self.unreferenced(), "no longer named, and still there", "no longer named, and still there");
        for fault in self.after.faults.iter().take(MOST_FAULTS) {
            print::note(&format!("note: {}", fault.message));
        }
        if let Some(more) = self.after.faults.len().checked_sub(MOST_FAULTS).filter(|more| *more > 0) {
            print::note(&format!("note: and {more} more, which `dreams check` names"));
        }
        Ok(Exit::Fine)
    }

    /// The answer with `--json`.
    fn answer(&self) -> Answer<'_> {
        let answer = Answer::of(self.changed, &self.before, &self.after);
        Answer { unreferenced: self.unreferenced(), missing: self.missing(), ..answer }
    }

    fn unreferenced(&self) -> Vec<&ClipPath> {
        let gone = self.before.files.difference(&self.after.files);
        gone.filter(|path| path.inside(&self.folder).is_file()).collect()
    }

    fn missing(&self) -> Vec<&ClipPath> {
        let new = self.after.files.difference(&self.before.files);
        new.filter(|path| !path.inside(&self.folder).exists()).collect()
    }
}

/// Notes that each of `files` is what `one` says, and what `all` says of those that are too many to be named.
fn note_files(files: &[&ClipPath], one: &str, all: &str) {
    for path in files.iter().take(MOST_FILES) {
        print::note(&format!("note: `{path}` is {one}"));
    }
    if let Some(more) = files.len().checked_sub(MOST_FILES).filter(|more| *more > 0) {
        print::note(&format!("note: and {more} more are {all}"));
    }
}

/// The sheep that were shown `before` and are not `after`, although the flock still has them.
fn lost<'a>(before: &'a FlockState, after: &'a FlockState) -> Vec<&'a SheepId> {
    before.shown.difference(&after.shown).filter(|id| after.sheep.contains(*id)).collect()
}

/// The worst ratio and what it was, in one line.
fn balance(before: Option<f64>, after: Option<f64>) -> String {
    let now = after.map_or("none while a sheep is never shown".to_owned(), |ratio| format!("{ratio:.3}"));
    let was = match (before, after) {
        (Some(before), Some(after)) if (before - after).abs() < SAME * after => ", as before".to_owned(),
        (Some(before), _) => format!(", was {before:.3}"),
        (None, Some(_)) => ", the first".to_owned(),
        (None, None) => String::new(),
    };
    format!("worst ratio of visits and want: {now}{was}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_balance_is_printed_with_what_it_was() {
        let text = |before, after| balance(before, after).split_once(": ").unwrap().1.to_owned();
        assert_eq!(text(None, None), "none while a sheep is never shown");
        assert_eq!(text(Some(2.0), None), "none while a sheep is never shown, was 2.000");
        assert_eq!(text(None, Some(1.25)), "1.250, the first");
        assert_eq!(text(Some(2.0), Some(1.25)), "1.250, was 2.000");
        assert_eq!(text(Some(1.25), Some(1.25 + 1e-12)), "1.250, as before");
    }
}
