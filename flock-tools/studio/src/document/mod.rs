//! The flock as the studio edits it: the manifest with its revisions, undo, marks and notes.
//!
//! Owns that no edit is lost: every one is made on the manifest as it is on the disk, under the lock of the commands, and
//! can be undone over a restart and a kill. What the studio notes beside it stands in the folder `.studio`, which may be
//! deleted: that loses notes and undo, and no art. Never renders, and never opens a clip.
//!
//! Start at [`Document::open`], then [`Document::apply`] in `editing.rs`.

mod disk;
mod editing;
mod errors;
mod files;
mod history;
mod journal;
mod notes;
mod perform;
mod requests;
mod revision;
mod surroundings;
#[cfg(test)]
mod tests;
mod text_change;

use std::fs::{self, OpenOptions};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use durable::Locked;
use flock::{Draft, Edit, FILE_NAME, Manifest, ManifestError, SheepId, paths};

use disk::{Disk, JournalFile};
use history::{History, Step};
use journal::{Journal, Last};
use perform::is_but_for_hashes;

pub(crate) use errors::{ApplyError, DocumentError, NoteError, UndoError};
pub(crate) use notes::{Mark, MarkKind, Notes};
pub(crate) use requests::{EditRequest, NoteRequest};
pub(crate) use revision::Revision;
pub(crate) use surroundings::Surroundings;

/// The studio's own folder in that of the flock.
pub(crate) const OWN_FOLDER: &str = ".studio";
/// The files in it: the journal, and the one that is locked while a studio has the flock.
const JOURNAL: &str = "journal";
const LOCK: &str = "lock";
/// How many revisions are known to be ours, of those since somebody else's.
const MOST_REVISIONS: usize = 1000;

/// A flock's manifest, with what can be undone and what is noted.
pub(crate) struct Document {
    folder: PathBuf,
    around: Box<dyn Surroundings>,
    journal: Journal,
    /// The manifest as it was read or saved last.
    now: Read,
    /// Whether its text is that of the journal, but for hashes of clips.
    is_ours: bool,
    /// Our own revisions since somebody else changed the text; the last one is that of `now`.
    own: Vec<Revision>,
    /// Size, time and number of the manifest's file when it was looked at last.
    seen: Option<(u64, SystemTime, u64)>,
    /// Whether a text of somebody else was read that [`Document::poll`] has not told of.
    is_untold: bool,
    /// Locked while this is open.
    _lock: Locked,
}

/// A manifest's text and what it says.
#[derive(Clone, Debug)]
struct Read {
    revision: Revision,
    text: Arc<str>,
    manifest: Arc<Manifest>,
}

/// A document at one moment. Cloning it copies no text.
#[derive(Clone, Debug)]
pub(crate) struct Snapshot {
    /// The revision of the text.
    pub(crate) revision: Revision,
    /// What it says. It may have no sheep.
    pub(crate) manifest: Arc<Manifest>,
    /// All notes.
    pub(crate) notes: Arc<Notes>,
    /// What an undo would take back, in words.
    pub(crate) undo: Option<String>,
    /// What would be done again, in words.
    pub(crate) redo: Option<String>,
}

/// Edits that were made.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Applied {
    /// The revision after them.
    pub(crate) revision: Revision,
    /// What they did, in words.
    pub(crate) said: String,
    /// Whether somebody else had changed the flock meanwhile; that change is kept.
    pub(crate) merged: bool,
    /// Sheep that the walk showed and no longer shows.
    pub(crate) no_longer_shown: Vec<SheepId>,
}

/// A step that was undone, or done again.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Undone {
    /// The revision after it.
    pub(crate) revision: Revision,
    /// What it had done, in words.
    pub(crate) said: String,
}

/// What somebody else did to the manifest.
#[derive(Debug)]
pub(crate) enum Change {
    /// It has another text.
    Edited,
    /// It can no longer be read; the document stays at the text before.
    Unreadable {
        /// Why.
        error: ManifestError,
    },
}

impl std::fmt::Debug for Document {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Document").field("folder", &self.folder).finish_non_exhaustive()
    }
}

impl Document {
    /// Opens the flock in `folder`, with what an earlier studio left. `around` answers what lies beside the manifest.
    /// Errors: [`DocumentError`].
    pub(crate) fn open(folder: &Path, around: Box<dyn Surroundings>) -> Result<Self, DocumentError> {
        let journal = folder.join(OWN_FOLDER).join(JOURNAL);
        Self::open_on(folder, around, Box::new(JournalFile(journal)))
    }

    fn open_on(folder: &Path, around: Box<dyn Surroundings>, disk: Box<dyn Disk>) -> Result<Self, DocumentError> {
        // The manifest first: a folder without one is left as it is.
        let edit = Draft::lock(folder)?.edit;
        let now = Read::of(edit.text(), edit.shared_manifest());
        let own = folder.join(OWN_FOLDER);
        let cannot = |source| DocumentError::Folder { path: own.clone(), source };
        fs::create_dir_all(&own).map_err(cannot)?;
        let lock = OpenOptions::new().write(true).create(true).truncate(false).open(own.join(LOCK)).map_err(cannot)?;
        // On a file system without locks the artist must not open it twice.
        if let Err(fs::TryLockError::WouldBlock) = lock.try_lock() {
            return Err(DocumentError::Taken { folder: folder.to_owned() });
        }
        let was_done = |before: &History, after: &History| was_done(&now.text, before, after);
        let journal = Journal::open(&own.join(JOURNAL), disk, &now.text, was_done).map_err(cannot)?;
        let revisions = vec![now.revision.clone()];
        let (folder, is_ours) = (folder.to_owned(), is_but_for_hashes(&now.text, journal.history().text()));
        let (own, seen, is_untold) = (revisions, None, false);
        let mut document =
            Self { folder, around, journal, now, is_ours, own, seen, is_untold, _lock: Locked::new(lock) };
        document.mend_credits().map_err(cannot)?;
        Ok(document)
    }

    /// The document now.
    pub(crate) fn snapshot(&self) -> Snapshot {
        let history = self.journal.history();
        let Read { revision, manifest, .. } = self.now.clone();
        let may = |step: &&Arc<Step>| self.is_ours || step.text.is_none();
        let undo = history.undoes().filter(may).map(|step| step.said.clone());
        let redo = history.redoes().filter(may).map(|step| step.said.clone());
        Snapshot { revision, manifest, notes: Arc::clone(history.notes()), undo, redo }
    }

    /// The revision of the manifest as it was read or saved last.
    pub(crate) fn revision(&self) -> &Revision {
        &self.now.revision
    }

    /// Looks whether somebody else has changed the manifest since it was read or saved last. Cheap if nothing was written.
    pub(crate) fn poll(&mut self) -> Option<Change> {
        let path = self.folder.join(FILE_NAME);
        let is_untold = std::mem::take(&mut self.is_untold);
        // A file that is not there now may be there the next time: editors rename.
        let stamp = fs::metadata(&path).ok().and_then(|data| Some((data.len(), data.modified().ok()?, data.ino())));
        if stamp.is_none() || stamp == self.seen {
            return is_untold.then_some(Change::Edited);
        }
        self.seen = stamp;
        let read = fs::read_to_string(&path).map_err(|source| ManifestError::Read { path: path.clone(), source });
        match read.and_then(|text| Edit::parse(text, &path)) {
            Err(error) => Some(Change::Unreadable { error }),
            Ok(edit) => {
                self.see(&edit);
                (std::mem::take(&mut self.is_untold) || is_untold).then_some(Change::Edited)
            }
        }
    }

    /// The manifest's text is that of `edit`, whoever wrote it.
    fn see(&mut self, edit: &Edit) {
        let text = edit.text();
        if *text != *self.now.text {
            self.is_ours = is_but_for_hashes(&text, self.journal.history().text());
            self.now = Read::of(text, edit.shared_manifest());
            self.own = vec![self.now.revision.clone()];
            self.is_untold = true;
        }
    }

    /// Somebody ended a studio between the manifest and the credits: the credits follow.
    fn mend_credits(&mut self) -> io::Result<()> {
        let history = self.journal.history();
        if !self.is_ours {
            return Ok(());
        }
        let path = self.folder.join(paths::CREDITS);
        let Ok(text) = fs::read_to_string(&path) else { return Ok(()) };
        let done = history.undoes().and_then(|step| step.credits.as_ref()?.apply(&text));
        let undone = || history.redoes().and_then(|step| step.credits.as_ref()?.revert(&text));
        done.or_else(undone).map_or(Ok(()), |text| self.journal.disk().save(&path, &text))
    }
}

impl Read {
    fn of(text: String, manifest: Arc<Manifest>) -> Self {
        Self { revision: Revision::of(&text), text: text.into(), manifest }
    }
}

/// Whether the last entry of the journal, which leads from `before` to `after`, was done: the manifest's text is `now`.
fn was_done(now: &str, before: &History, after: &History) -> Last {
    if before.text() == after.text() || now == &**after.text() {
        return Last::Done;
    }
    let is_before = now == &**before.text() || after.before_last().is_some_and(|text| now == &*text);
    let is_after = || is_but_for_hashes(now, after.text());
    if is_before || (!is_after() && is_but_for_hashes(now, before.text())) { Last::NotDone } else { Last::Done }
}
