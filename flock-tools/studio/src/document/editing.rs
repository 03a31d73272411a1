//! Edits, undo and notes of a document.
//!
//! Owns the order: the manifest is locked, read, edited and judged; then the journal says what will be done, and then it is
//! done. Whatever ends the program in between, the next start knows whether the manifest was saved.
//!
//! Start at [`Document::apply`].

use std::fs;
use std::io;
use std::path::Path;
use std::sync::Arc;

use flock::{ClipPath, Draft, Edit, FILE_NAME, Manifest, ManifestError, SheepId, paths};

use super::disk::Disk;
use super::errors::{ApplyError, NoteError, UndoError};
use super::files::copy_renamed;
use super::history::{History, Record, Step};
use super::notes::{MarkKind, NoteChange, marked};
use super::perform::{Needs, lost, perform, with_hashes};
use super::requests::{EditRequest, NoteRequest, said_of_edits, said_of_notes};
use super::text_change::TextChange;
use super::{Applied, Document, MOST_REVISIONS, Read, Revision, Undone};

/// The texts to save: the manifest's, and the credits' if they change.
#[derive(Debug)]
struct Texts {
    manifest: Option<Read>,
    credits: Option<String>,
}

/// Which way a step is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    Undo,
    Redo,
}

impl Document {
    /// The manifest as it would be with `edits`. Nothing is written.
    /// Errors: [`ApplyError::Refused`].
    pub(crate) fn what_if(&self, edits: &[EditRequest]) -> Result<Arc<Manifest>, ApplyError> {
        let mut edit = Edit::parse(self.now.text.to_string(), Path::new(FILE_NAME))?;
        perform(edits, &mut edit, &*self.around)?;
        Ok(edit.shared_manifest())
    }

    /// Makes `edits`, all or none, on the manifest as it is on the disk, and saves it. `base` is the revision that they were
    /// meant for. Edits of the same `gesture` are undone at once. With `force` sheep may go off the wall.
    /// Errors: [`ApplyError`]; nothing is changed then.
    pub(crate) fn apply(
        &mut self,
        edits: &[EditRequest],
        base: &Revision,
        gesture: Option<&str>,
        force: bool,
    ) -> Result<Applied, ApplyError> {
        let mut draft = Draft::lock(&self.folder)?;
        self.see(&draft.edit);
        let (merged, before) = (!self.own.contains(base), self.now.clone());
        let is_late = *base != before.revision;
        let needs = match perform(edits, &mut draft.edit, &*self.around) {
            Err(ApplyError::Refused { error }) if is_late => return Err(ApplyError::Conflict { error }),
            performed => performed?,
        };
        let manifest = draft.edit.shared_manifest();
        let no_longer_shown = lost(&before.manifest, &manifest);
        if !force && manifest.sheep.is_empty() && !before.manifest.sheep.is_empty() {
            return Err(ApplyError::Empty);
        }
        if !force && !no_longer_shown.is_empty() {
            return Err(ApplyError::Unshown { no_longer_shown });
        }
        let said = said_of_edits(edits);
        let text = draft.edit.text();
        if *text != *before.text {
            let read = read_back(text, &manifest)?;
            let credits = self.credits_after(edits, &before.manifest, &manifest)?;
            let refused = |error| ApplyError::Refused { error };
            let genomes = needs.added.iter().filter_map(|sheep| sheep.genome.as_ref());
            let files = genomes.chain(needs.renamed.values()).map(ClipPath::as_str);
            draft.writes(files.chain(credits.is_some().then_some(paths::CREDITS)));
            needs.added.iter().try_for_each(|sheep| self.around.place(sheep)).map_err(refused)?;
            copy_renamed(&self.folder, &needs.renamed).map_err(refused)?;
            self.write_step(&said, gesture, &needs, read, credits)?;
        }
        Ok(Applied { revision: self.now.revision.clone(), said, merged, no_longer_shown })
    }

    /// Takes the last step back.
    /// Errors: [`UndoError`]; nothing is changed then.
    pub(crate) fn undo(&mut self) -> Result<Undone, UndoError> {
        self.go(Way::Undo)
    }

    /// Does again the step that was taken back last.
    /// Errors: [`UndoError`]; nothing is changed then.
    pub(crate) fn redo(&mut self) -> Result<Undone, UndoError> {
        self.go(Way::Redo)
    }

    /// Makes notes, which can be undone as edits can; marks of sheep of a pool are marks of the pool. Returns what was done, in
    /// words.
    /// Errors: [`NoteError`]; nothing is changed then.
    pub(crate) fn note(&mut self, requests: &[NoteRequest], gesture: Option<&str>) -> Result<String, NoteError> {
        let (history, said) = (self.journal.history(), said_of_notes(requests));
        let notes = history.notes().changes(requests, |sheep| self.around.mark(sheep))?;
        if !notes.is_empty() {
            let joined = history.joins(gesture);
            let marks = self.marks_of_pool(&notes, Way::Redo);
            let step = Step { said: said.clone(), gesture: gesture.map(str::to_owned), notes, ..Step::default() };
            let record = Record::Step { step, joined };
            self.journal
                .write(record, |_, _| self.around.set_marks(&marks).map_err(|error| NoteError::Pool { error }))?;
        }
        Ok(said)
    }

    /// Writes the step that led from the text as it is to `read`, and saves it.
    fn write_step(
        &mut self,
        said: &str,
        gesture: Option<&str>,
        needs: &Needs,
        read: Read,
        credits: Option<(TextChange, String)>,
    ) -> Result<(), ApplyError> {
        let history = self.journal.history();
        let is_ours = self.is_ours;
        let gap = if is_ours { None } else { TextChange::between(history.text(), &self.now.text) };
        let from = if is_ours { history.text() } else { &self.now.text };
        let text = TextChange::between(from, &read.text);
        let joined = is_ours && credits.is_none() && history.joins(gesture);
        let mut known = (**history.notes()).clone();
        let mut notes = Vec::new();
        for (old, new) in &needs.ids {
            let changes = known.renamed(old, new);
            for change in &changes {
                known.apply(change);
            }
            notes.extend(changes);
        }
        let (change, credits) = credits.unzip();
        let (said, gesture) = (said.to_owned(), gesture.map(str::to_owned));
        let step = Step { said, gesture, gap, text, credits: change, notes };
        self.save(Record::Step { step, joined }, Texts { manifest: Some(read), credits })?;
        Ok(())
    }

    fn go(&mut self, way: Way) -> Result<Undone, UndoError> {
        let mut draft = Draft::lock(&self.folder)?;
        self.see(&draft.edit);
        let step = self.step_to(way)?;
        let history = self.journal.history();
        if step.text.is_some() && !self.is_ours {
            return Err(UndoError::Changed { file: FILE_NAME });
        }
        let turn = |change: &TextChange, text: &str| match way {
            Way::Undo => change.revert(text),
            Way::Redo => change.apply(text),
        };
        let manifest = step.text.as_ref().map(|change| self.turned(turn(change, history.text())));
        let credits = match &step.credits {
            None => None,
            Some(change) => {
                let changed = || UndoError::Changed { file: paths::CREDITS };
                let text = fs::read_to_string(self.folder.join(paths::CREDITS)).map_err(|_| changed())?;
                Some(turn(change, &text).ok_or_else(changed)?)
            }
        };
        let record = match way {
            Way::Undo => Record::Undo,
            Way::Redo => Record::Redo,
        };
        if step.text.is_none() && step.credits.is_none() {
            let marks = self.marks_of_pool(&step.notes, way);
            self.journal
                .write(record, |_, _| self.around.set_marks(&marks).map_err(|error| UndoError::Pool { error }))?;
        } else {
            draft.writes(credits.is_some().then_some(paths::CREDITS));
            self.save(record, Texts { manifest: manifest.transpose()?, credits })?;
        }
        drop(draft);
        Ok(Undone { revision: self.now.revision.clone(), said: step.said.clone() })
    }

    /// The marks that the pool gets by `changes`. What somebody else has marked since stays.
    fn marks_of_pool(&self, changes: &[NoteChange], way: Way) -> Vec<(SheepId, MarkKind)> {
        let turned = |[was, is]: [MarkKind; 2]| if way == Way::Undo { (is, was) } else { (was, is) };
        let ways = marked(changes).into_iter().map(|(sheep, kinds)| (sheep, turned(kinds)));
        let own = ways.filter(|(sheep, (from, _))| self.around.mark(sheep) == Some(*from));
        own.map(|(sheep, (_, to))| (sheep.clone(), to)).collect()
    }

    /// The step that is taken back, or done again.
    fn step_to(&self, way: Way) -> Result<Arc<Step>, UndoError> {
        let history = self.journal.history();
        let (step, what) = match way {
            Way::Undo if history.is_at_gap() => return Err(UndoError::Changed { file: FILE_NAME }),
            Way::Undo => (history.undoes(), "undo"),
            Way::Redo => (history.redoes(), "redo"),
        };
        step.cloned().ok_or(UndoError::Nothing { what })
    }

    /// `text` of the journal as a manifest, with the hashes of clips that the manifest has now.
    fn turned(&self, text: Option<String>) -> Result<Read, UndoError> {
        let text = text.ok_or(UndoError::Changed { file: FILE_NAME })?;
        let text = with_hashes(&text, &self.now.manifest).unwrap_or(text);
        let manifest = Edit::parse(text.clone(), Path::new(FILE_NAME))?.shared_manifest();
        Ok(Read::of(text, manifest))
    }

    /// Has the journal say what is done, and saves `texts`. The manifest is locked.
    fn save(&mut self, record: Record, texts: Texts) -> io::Result<()> {
        let Texts { manifest, credits } = texts;
        let (path, of_credits) = (self.folder.join(FILE_NAME), self.folder.join(paths::CREDITS));
        let before = Arc::clone(&self.now.text);
        self.journal.write(record, |disk: &dyn Disk, _: &History| {
            if let Some(read) = &manifest {
                // A write that fails in its last step, to sync the folder, has been made.
                let is_made = |_: &io::Error| fs::read_to_string(&path).is_ok_and(|text| *text == *read.text);
                disk.save(&path, &read.text).or_else(|error| if is_made(&error) { Ok(()) } else { Err(error) })?;
            }
            let saved = credits.map_or(Ok(()), |text| disk.save(&of_credits, &text));
            if saved.is_err() && manifest.is_some() {
                // The two files belong together. If this fails, too, the next start has the credits follow.
                let _ = disk.save(&path, &before);
            }
            saved
        })?;
        if let Some(read) = manifest {
            self.own.push(read.revision.clone());
            let surplus = self.own.len().saturating_sub(MOST_REVISIONS);
            self.own.drain(..surplus);
            (self.now, self.is_ours) = (read, true);
        }
        Ok(())
    }

    /// What becomes of the credits, and their text then; `None` if they stay as they are.
    fn credits_after(
        &self,
        edits: &[EditRequest],
        before: &Manifest,
        after: &Manifest,
    ) -> Result<Option<(TextChange, String)>, ApplyError> {
        if !edits.iter().any(concerns_credits) {
            return Ok(None);
        }
        let text = match fs::read_to_string(self.folder.join(paths::CREDITS)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            read => read?,
        };
        let new = self.around.credits(&text, edits, before, after).map_err(|error| ApplyError::Refused { error })?;
        Ok(TextChange::between(&text, &new).map(|change| (change, new)))
    }
}

/// The text of an edited manifest, which must read back as it was edited.
fn read_back(text: String, manifest: &Arc<Manifest>) -> Result<Read, ManifestError> {
    let path = Path::new(FILE_NAME);
    let read = Edit::parse(text.clone(), path)?.shared_manifest();
    if read == *manifest {
        return Ok(Read::of(text, read));
    }
    let source = io::Error::other("the edited text does not read back as the edited manifest");
    Err(ManifestError::Read { path: path.to_owned(), source })
}

fn concerns_credits(edit: &EditRequest) -> bool {
    match edit {
        EditRequest::Drop { .. }
        | EditRequest::Prune { .. }
        | EditRequest::Rename { .. }
        | EditRequest::Unlink { .. } => true,
        EditRequest::Add { .. }
        | EditRequest::Link { .. }
        | EditRequest::Repeat { .. }
        | EditRequest::Want { .. }
        | EditRequest::Weight { .. }
        | EditRequest::Weights { .. } => false,
    }
}
