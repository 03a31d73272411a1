//! Which connections are held, and which one makes room for another.
//!
//! Owns that strangers shut no page out, however many connections they hold: those of the artist's pages have places of
//! their own, and of the others the one that has said nothing whole for the longest goes when there are too many. A
//! connection is a stranger's until a page of this session has asked on it. Never reads a socket: `server` does.
//!
//! Start at [`Connections::enter`].

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use tokio::sync::Notify;

use crate::lock::locked;

/// The most connections of pages that keep their places. Those beyond are held like those of strangers.
const MOST_OF_PAGES: usize = 256;
/// The most connections of strangers at once.
pub(crate) const MOST_OF_STRANGERS: usize = 256;

/// All connections of a server.
#[derive(Debug, Default)]
pub(crate) struct Connections {
    held: Mutex<Held>,
}

/// Each connection, by what asks it to leave.
#[derive(Debug, Default)]
struct Held {
    pages: Vec<Arc<Notify>>,
    /// The one that has said nothing whole for the longest comes first.
    strangers: VecDeque<Arc<Notify>>,
}

/// The place of a connection. It is free when this is dropped.
#[derive(Debug)]
pub(crate) struct Place {
    connections: Arc<Connections>,
    leave: Arc<Notify>,
}

impl Connections {
    /// The place of a new connection, which is a stranger's. If there are too many of those, one of them is asked to leave.
    pub(crate) fn enter(self: &Arc<Self>) -> Arc<Place> {
        let leave = Arc::new(Notify::new());
        let mut held = locked(&self.held);
        held.strangers.push_back(Arc::clone(&leave));
        if held.strangers.len() > MOST_OF_STRANGERS
            && let Some(silent) = held.strangers.pop_front()
        {
            silent.notify_one();
        }
        drop(held);
        Arc::new(Place { connections: Arc::clone(self), leave })
    }
}

impl Held {
    /// Takes the connection out of those of strangers; `None` if it is not among them.
    fn take(&mut self, leave: &Arc<Notify>) -> Option<Arc<Notify>> {
        let at = self.strangers.iter().position(|one| Arc::ptr_eq(one, leave))?;
        self.strangers.remove(at)
    }
}

impl Place {
    /// The head of a request has come whole.
    pub(crate) fn heard(&self) {
        let mut held = locked(&self.connections.held);
        if let Some(own) = held.take(&self.leave) {
            held.strangers.push_back(own);
        }
    }

    /// A page of this session asks on the connection: no stranger takes its place from now on.
    pub(crate) fn keep(&self) {
        let mut held = locked(&self.connections.held);
        if held.pages.len() < MOST_OF_PAGES
            && let Some(own) = held.take(&self.leave)
        {
            held.pages.push(own);
        }
    }

    /// Waits until another connection needs the place.
    pub(crate) async fn needed(&self) {
        self.leave.notified().await;
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut held = locked(&self.connections.held);
        held.take(&self.leave);
        held.pages.retain(|one| !Arc::ptr_eq(one, &self.leave));
    }
}
