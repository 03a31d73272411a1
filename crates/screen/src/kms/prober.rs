//! Probes a connector on another thread: displays may answer slowly.
//!
//! Owns the thread and its answers. The kernel probes only for the DRM master, so the thread has a copy of the card's
//! descriptor.
//!
//! Start at [`Prober::start`].

use super::card::{Connector, Id};
use super::properties::PropertyCache;
use super::reading::read_connector;
use drm::Device as Basic;
use drm::control::{Device as Control, ResourceHandles};
use rustix::event::{EventfdFlags, eventfd};
use rustix::io::{Errno, read, write};
use std::fs::File;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

/// A thread that probes connectors of one card. It ends when this is dropped.
pub(super) struct Prober {
    asked: Sender<Id>,
    answers: Receiver<Result<Connector, Errno>>,
    /// Readable while there may be an answer.
    event_fd: OwnedFd,
}

/// The card, for the thread.
struct Card(File);

impl AsFd for Card {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

impl Basic for Card {}
impl Control for Card {}

impl Prober {
    /// Starts the thread for the open `card`.
    /// Errors: There are no more descriptors or threads.
    pub(super) fn start(card: &File) -> io::Result<Self> {
        let card = Card(card.try_clone()?);
        let event_fd = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?;
        let ringing = event_fd.try_clone()?;
        let (asked, questions) = channel::<Id>();
        let (answer, answers) = channel();
        let work = move || {
            let mut cache = PropertyCache::default();
            let resources: io::Result<ResourceHandles> = card.resource_handles();
            for connector in questions {
                let mut read = |resources| read_connector(&card, connector, resources, &mut cache);
                let errno = |error: &io::Error| Errno::from_io_error(error).unwrap_or(Errno::IO);
                let found = resources.as_ref().map_err(errno).and_then(|all| read(all).map_err(|error| errno(&error)));
                if answer.send(found).is_err() || write(&ringing, &1u64.to_ne_bytes()).is_err() {
                    return;
                }
            }
        };
        thread::Builder::new().name("probe".to_owned()).spawn(work)?;
        Ok(Self { asked, answers, event_fd })
    }

    /// Has `connector` probed, soon.
    pub(super) fn ask(&self, connector: Id) {
        // If the thread is gone it has panicked, which was logged.
        self.asked.send(connector).ok();
    }

    /// The next answer, if there is one.
    pub(super) fn answer(&self) -> Option<Result<Connector, Errno>> {
        let mut count = [0; 8];
        read(&self.event_fd, &mut count).ok();
        self.answers.try_recv().ok()
    }

    /// Readable while there may be an answer.
    pub(super) fn event_fd(&self) -> BorrowedFd<'_> {
        self.event_fd.as_fd()
    }
}
