//! The stream of events: what changed, as the page is told.
//!
//! Owns the numbers of the events and the last thousand of them, so that a page that was away for a moment is told what it
//! missed. One that was away for longer, or knew another start of the program, is told to fetch everything: no event can be
//! missed in silence. Never knows what the events mean.
//!
//! Start at [`Hub::send`]; a page's end is [`Subscription::next`].

#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::response::sse::{Event as Message, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Router, http};
use futures_util::stream::unfold;
use serde_json::Value;
use tokio::sync::watch;

use crate::answer::Problem;
use crate::lock::locked;

/// How many events are kept.
pub(crate) const KEPT: usize = 1000;
/// How many pages are told at once.
const MOST_PAGES: usize = 64;
/// A stream without an event says this often that it is alive.
const KEEP_ALIVE: Duration = Duration::from_secs(15);
/// What a page sends that was told something before.
const LAST: &str = "last-event-id";

/// What an event is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EventKind {
    /// The manifest has another revision.
    Changed,
    /// A job is new, goes on or is over.
    Job,
    /// What is seen in strips that are new.
    Looks,
    /// Marks, pins or bad joins.
    Marks,
    /// A sentence for the artist.
    Note,
    /// The page has missed something: it must fetch everything.
    State,
}

/// An event.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Event {
    /// Its number, as a page sends it back.
    pub(crate) id: String,
    /// What it is about.
    pub(crate) kind: EventKind,
    /// One JSON document.
    pub(crate) data: Arc<str>,
}

/// All events of one start of the program.
#[derive(Debug)]
pub(crate) struct Hub {
    /// Tells this start's numbers from those of another.
    start: u64,
    ring: Mutex<Ring>,
    newest: watch::Sender<u64>,
}

/// The last events. Their numbers are consecutive.
#[derive(Debug, Default)]
struct Ring {
    /// The number of the newest; 0 before the first.
    newest: u64,
    events: VecDeque<(EventKind, Arc<str>)>,
}

/// The events as one page is told them.
#[derive(Debug)]
pub(crate) struct Subscription {
    hub: Arc<Hub>,
    /// The number of the last event that the page knows; `None` if it must fetch everything.
    known: Option<u64>,
    newest: watch::Receiver<u64>,
}

impl EventKind {
    /// Its name in the stream.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Changed => "changed",
            Self::Job => "job",
            Self::Looks => "looks",
            Self::Marks => "marks",
            Self::Note => "note",
            Self::State => "state",
        }
    }
}

impl Hub {
    /// No event yet. `start` is another number at each start of the program, such as a random one.
    pub(crate) fn new(start: u64) -> Self {
        Self { start, ring: Mutex::default(), newest: watch::Sender::new(0) }
    }

    /// Tells all pages.
    pub(crate) fn send(&self, kind: EventKind, data: &Value) {
        let mut ring = self.ring();
        ring.newest += 1;
        ring.events.push_back((kind, data.to_string().into()));
        if ring.events.len() > KEPT {
            ring.events.pop_front();
        }
        self.newest.send_replace(ring.newest);
    }

    /// The events since the one with the id `last`. A page without one, or with one that is not known any more, is told
    /// [`EventKind::State`] first.
    pub(crate) fn subscribe(self: &Arc<Self>, last: Option<&str>) -> Subscription {
        let known =
            last.and_then(|last| last.split_once('-')).filter(|(start, _)| *start == format!("{:x}", self.start));
        let known = known.and_then(|(_, number)| number.parse().ok());
        let newest = self.ring().newest;
        let known = known.filter(|known| *known <= newest);
        Subscription { hub: Arc::clone(self), known, newest: self.newest.subscribe() }
    }

    /// How many pages are told.
    pub(crate) fn pages(&self) -> usize {
        self.newest.receiver_count()
    }

    /// The stream at `/events`.
    pub(crate) fn router(self: Arc<Self>) -> Router {
        Router::new().route("/events", get(stream)).with_state(self)
    }

    fn id(&self, number: u64) -> String {
        format!("{:x}-{number}", self.start)
    }

    fn ring(&self) -> MutexGuard<'_, Ring> {
        // Nothing panics while it holds the lock.
        locked(&self.ring)
    }
}

impl Subscription {
    /// The next event; waits for it.
    pub(crate) async fn next(&mut self) -> Event {
        loop {
            if let Some(event) = self.at_once() {
                return event;
            }
            // The sender lives as long as the hub, which this has.
            let _ = self.newest.changed().await;
        }
    }

    /// The next event, if there is one.
    pub(crate) fn at_once(&mut self) -> Option<Event> {
        self.newest.mark_unchanged();
        let ring = self.hub.ring();
        let oldest = ring.newest + 1 - ring.events.len() as u64;
        let number = match self.known {
            Some(known) if known == ring.newest => return None,
            Some(known) if known + 1 >= oldest => known + 1,
            Some(_) | None => {
                self.known = Some(ring.newest);
                return Some(Event { id: self.hub.id(ring.newest), kind: EventKind::State, data: "{}".into() });
            }
        };
        self.known = Some(number);
        let (kind, data) = ring.events[(number - oldest) as usize].clone();
        Some(Event { id: self.hub.id(number), kind, data })
    }
}

async fn stream(State(hub): State<Arc<Hub>>, headers: HeaderMap) -> Response {
    if hub.pages() >= MOST_PAGES {
        let error = format!("{MOST_PAGES} pages of this studio are open already");
        return Problem::new(StatusCode::TOO_MANY_REQUESTS, error).into_response();
    }
    let last = headers.get(LAST).and_then(|last: &http::HeaderValue| last.to_str().ok());
    let messages = unfold(hub.subscribe(last), |mut subscription| async move {
        let Event { id, kind, data } = subscription.next().await;
        Some((Ok::<_, Infallible>(Message::default().id(id).event(kind.name()).data(data)), subscription))
    });
    Sse::new(messages).keep_alive(KeepAlive::new().interval(KEEP_ALIVE)).into_response()
}
