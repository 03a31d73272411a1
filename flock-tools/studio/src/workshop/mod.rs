//! What all requests of the studio share: the document, the queue, the events, and what is known of files.
//!
//! Owns them, and what the page is told when something has changed. `looking.rs` has what is read of them. Never knows a
//! request, nor what a job does.
//!
//! Start at [`Workshop::open`].

mod looking;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use flock::{Flock, Measure};
use operations::decoder::Decoder;
use operations::program::{Exit, Fatal, now};
use serde_json::{Value, json};

use crate::breeding::broods::Broods;
use crate::document::{Change, Document, DocumentError, OWN_FOLDER, Revision};
use crate::events::{EventKind, Hub};
use crate::jobs::{Job, NewJob, Progress, Queue, Settings, Work};
use crate::lock::locked;
use crate::media::{Keys, Media};
use crate::server::StudioError;
use crate::store::candidates::Candidates;
use crate::store::checked::Checked;
use crate::store::genomes::Genomes;
use crate::store::joins::JoinRecord;
use crate::store::places::Places;
use crate::store::shipping::Shipping;
use crate::store::stock::{Around, Stock};
use crate::views::state_delta::SentStates;

/// The list of jobs that a restart goes on with.
const JOBS: &str = "jobs.json";
/// The folder of the pool in that of the flock, if no other is named.
const POOL: &str = "pool";

/// Whose studio it is.
pub(crate) struct Opening<'a> {
    /// The folder of the flock.
    pub(crate) folder: &'a Path,
    /// The folder of its pool; one in that of the flock, if no other is named.
    pub(crate) pool: Option<PathBuf>,
    /// The folder of genomes from which sheep may come in.
    pub(crate) archive: Option<PathBuf>,
    /// Where bundles come from and go to.
    pub(crate) shipping: Shipping,
    /// How many clips are made at once.
    pub(crate) threads: usize,
    pub(crate) decoder: &'static dyn Decoder,
}

/// What all requests share. Locks are held for short: none while something is rendered, decoded or sent.
pub(crate) struct Workshop {
    /// The flock's folder, and the studio's own in it.
    pub(crate) folder: PathBuf,
    pub(crate) own: PathBuf,
    pub(crate) document: Mutex<Document>,
    pub(crate) hub: Arc<Hub>,
    pub(crate) queue: Queue,
    pub(crate) stock: Arc<Stock>,
    pub(crate) media: Media,
    pub(crate) joins: Mutex<JoinRecord>,
    pub(crate) places: Mutex<Places>,
    pub(crate) checked: Mutex<Checked>,
    /// What pages have of the state.
    pub(crate) sent: Mutex<SentStates>,
    pub(crate) shipping: Shipping,
    /// What differs from the last bundle, for a revision of the manifest.
    pub(crate) difference: Mutex<Option<(Revision, Value)>>,
    /// The flock of the last revision that was asked for.
    pub(crate) known_flock: Mutex<Option<(Revision, Arc<Flock>)>>,
}

impl Workshop {
    /// Opens a flock, and what an earlier studio left of it.
    /// Errors: If the manifest is malformed, or the studio's own folder cannot be made.
    pub(crate) fn open(opening: Opening<'_>) -> Result<Self, Fatal> {
        let Opening { folder, pool, archive, shipping, threads, decoder } = opening;
        let (folder, own) = (folder.to_owned(), folder.join(OWN_FOLDER));
        let candidates = Candidates::new(pool.unwrap_or_else(|| folder.join(POOL)), archive);
        let (genomes, broods) = (Genomes::default(), Mutex::new(Broods::open(&own)));
        let stock = Arc::new(Stock { folder: folder.clone(), decoder, genomes, candidates, broods });
        let around = Box::new(Around(Arc::clone(&stock)));
        let document = Document::open(&folder, around).map_err(document_fatal)?;
        let hub = Arc::new(Hub::new(rand::random()));
        let told = Arc::clone(&hub);
        let settings = Settings {
            threads,
            kept: Some(own.join(JOBS)),
            clock: now::since_start,
            listener: Box::new(move |job| told.send(EventKind::Job, &json!({ "job": job }))),
        };
        let start = |source| Fatal::new(Exit::Unreadable, StudioError::Start { source });
        Ok(Self {
            document: Mutex::new(document),
            hub,
            queue: Queue::open(settings).map_err(start)?,
            media: Media::open(&folder, &own),
            stock,
            joins: Mutex::new(JoinRecord::open(&own)),
            places: Mutex::new(Places::open(&own)),
            checked: Mutex::default(),
            sent: Mutex::new(SentStates::new(rand::random())),
            shipping,
            difference: Mutex::default(),
            known_flock: Mutex::default(),
            folder,
            own,
        })
    }

    /// Looks whether somebody else has edited the manifest, and tells the page.
    pub(crate) fn look(&self) {
        // Taken before the page is told: it may edit at once.
        let found = locked(&self.document).poll();
        match found {
            None => {}
            Some(Change::Edited) => self.tell_changed(),
            Some(Change::Unreadable { error }) => self.note(&format!("the flock cannot be read: {error}")),
        }
    }

    /// Lets go of what the studio keeps and nobody needs. Every picture and clip that the page may ask for has its key then.
    pub(crate) fn clear(&self) {
        let (_, flock) = self.flock();
        let (manifest, genomes) = (flock.manifest(), self.genomes_by_id());
        let keys = self.keys(manifest);
        for own in &manifest.transitions {
            keys.pair(&own.from, &own.to, own.clip.frames.0);
        }
        for genome in genomes.values() {
            keys.strip(None, Some(genome));
        }
        // Nothing goes while something of the flock cannot be read.
        if self.state(Measure::Visits).is_ok() {
            self.media.clear(now::system());
        }
    }

    /// The keys of pictures and clips for the flock of `manifest`.
    pub(crate) fn keys<'a>(&'a self, manifest: &'a flock::Manifest) -> Keys<'a> {
        Keys::new(&self.media, manifest)
    }

    /// The work that runs `run` with all that requests share, as long as the studio is there.
    pub(crate) fn work<F>(self: &Arc<Self>, run: F) -> Work
    where
        F: FnOnce(&Arc<Self>, &Progress) -> Result<Value, String> + Send + 'static,
    {
        let shared = Arc::downgrade(self);
        Box::new(move |progress| run(&shared.upgrade().ok_or("the studio has ended")?, progress))
    }

    /// Adds a job that runs `run`.
    pub(crate) fn add_job<F>(self: &Arc<Self>, new: NewJob, run: F) -> Job
    where
        F: FnOnce(&Arc<Self>, &Progress) -> Result<Value, String> + Send + 'static,
    {
        self.queue.add_job(new, self.work(run))
    }

    /// Tells the page a sentence.
    pub(crate) fn note(&self, text: &str) {
        self.hub.send(EventKind::Note, &json!({ "text": text }));
    }

    /// Tells the page that the manifest is another one. Its figures come with the state.
    pub(crate) fn tell_changed(&self) {
        let revision = locked(&self.document).revision().clone();
        self.hub.send(EventKind::Changed, &json!({ "revision": revision }));
    }

    /// Tells the page to fetch the state: something that is not in the manifest has changed.
    pub(crate) fn tell_all(&self) {
        self.hub.send(EventKind::State, &json!({}));
    }
}

/// Ends the command that cannot open a document.
fn document_fatal(error: DocumentError) -> Fatal {
    match error {
        DocumentError::Manifest(error) => error.into(),
        DocumentError::Taken { .. } => Fatal::new(Exit::No, error),
        DocumentError::Folder { .. } => Fatal::new(Exit::Unreadable, error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Workshop {
        /// That of the flock in `folder`, with nothing beside it.
        pub(crate) fn of_folder(folder: &Path) -> Arc<Self> {
            let shipping = Shipping::new(folder, &[], None, Vec::new(), None);
            let decoder = &operations::decoder::ffmpeg::Ffmpeg;
            let opening = Opening { folder, pool: None, archive: None, shipping, threads: 1, decoder };
            Arc::new(Self::open(opening).map_err(|fatal| fatal.in_words()).unwrap())
        }
    }
}
