//! Which request is answered by what.
//!
//! Owns the handlers, a file for each part of the interface: they read the request, ask the rest of the studio, and say why not.
//! Never decides what an answer says.
//!
//! Start at [`all`].

mod breed;
mod edit;
mod jobs;
mod look;
mod media;
mod ship;

use std::sync::Arc;

use axum::Router;

use crate::workshop::Workshop;

/// All routes of the studio's interface.
pub(super) fn all(workshop: &Arc<Workshop>) -> Router {
    Router::new()
        .merge(look::router())
        .merge(edit::router())
        .merge(breed::router())
        .merge(jobs::router())
        .merge(media::router())
        .merge(ship::router())
        .with_state(Arc::clone(workshop))
}
