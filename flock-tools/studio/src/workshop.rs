//! What all requests of the studio share: the document, the queue, the events, and what is known of files.
//!
//! Owns them, and what the page is told when something has changed. `looking.rs` has what is read of them.
//!
//! Start at [`Workshop::open`].

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use flock::{Flock, Measure};
use operations::decoder::Decoder;
use operations::flock_folder::open;
use operations::program::{Exit, Fatal, now};
use serde_json::{Value, json};

use super::breeding::births;
use super::breeding::broods::Broods;
use super::command::{Args, StudioError};
use super::media::Media;
use super::store::candidates::Candidates;
use super::store::genomes::Genomes;
use super::store::joins::JoinRecord;
use super::store::places::Places;
use super::store::stock::{Around, Stock};
use super::views::ship::Shipping;
use super::views::state_delta::SentStates;
use super::work::checking::Checked;
use crate::document::{Change, Document, DocumentError, OWN_FOLDER, Revision};
use crate::events::{EventKind, Hub};
use crate::jobs::{Queue, Settings};

/// The list of jobs that a restart goes on with.
const JOBS: &str = "jobs.json";
/// The folder of the pool in that of the flock, if no other is named.
const POOL: &str = "pool";

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
    /// Opens the flock that `args` name, and what an earlier studio left of it.
    /// Errors: If the manifest is malformed, or the studio's own folder cannot be made.
    pub(crate) fn open(args: &Args, decoder: &'static dyn Decoder) -> Result<Self, Fatal> {
        let folder = args.dir.clone();
        let own = folder.join(OWN_FOLDER);
        let candidates = Candidates::new(args.pool.clone().unwrap_or_else(|| folder.join(POOL)), args.archive.clone());
        let (genomes, broods) = (Genomes::default(), Mutex::new(Broods::open(&own)));
        let stock = Arc::new(Stock { folder: folder.clone(), decoder, genomes, candidates, broods });
        let around = Box::new(Around(Arc::clone(&stock)));
        let document = Document::open(&folder, around).map_err(document_fatal)?;
        let hub = Arc::new(Hub::new(rand::random()));
        let told = Arc::clone(&hub);
        let settings = Settings {
            threads: usize::from(args.jobs),
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
            shipping: args.shipping(),
            difference: Mutex::default(),
            known_flock: Mutex::default(),
            folder,
            own,
        })
    }

    /// Goes on with the jobs that an earlier run left.
    pub(crate) fn go_on(self: &Arc<Self>) {
        for brood in locked(&self.stock.broods).unfinished() {
            births::queue(self, &brood);
        }
        for kept in self.queue.left() {
            match self.work_of(&kept) {
                Some(work) => drop(self.queue.go_on(&kept, work)),
                None => self.queue.forget(&kept),
            }
        }
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

    /// Now, in milliseconds since 1970.
    pub(crate) fn now_ms() -> u64 {
        now::since_1970_ms()
    }
}

/// Ends the command that cannot open a document.
fn document_fatal(error: DocumentError) -> Fatal {
    match error {
        DocumentError::Manifest(error) => open::manifest_fatal(error),
        DocumentError::Taken { .. } => Fatal::new(Exit::No, error),
        DocumentError::Folder { .. } => Fatal::new(Exit::Unreadable, error),
    }
}

/// The value behind `mutex`. A thread that panicked while it had it has left it whole.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
