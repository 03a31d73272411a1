//! The queue: what runs, what it costs, pause and cancel; clips to render, and previews.
//!
//! Owns these handlers. What a job does, `media` knows.
//!
//! Start at [`router`].

use std::sync::Arc;

use axum::Router;
use axum::extract::{Path, State};
use axum::routing::{delete, get, post};
use serde_json::{Value, json};

use crate::answer::{Answer, Body, conflict, missing, of};
use crate::jobs::JobId;
use crate::requests::{JobRequest, Pause, PreviewRequest};
use crate::work::{clips, previews};
use crate::workshop::Workshop;

/// The routes.
pub(super) fn router() -> Router<Arc<Workshop>> {
    Router::new()
        .route("/api/jobs", get(jobs).post(begin))
        .route("/api/jobs/pause", post(pause))
        .route("/api/jobs/{id}", delete(cancel))
        .route("/api/jobs/{id}/pause", post(pause_one))
        .route("/api/previews", post(preview))
}

async fn jobs(State(workshop): State<Arc<Workshop>>) -> Answer<Value> {
    of(move || Ok(json!({ "jobs": workshop.queue.jobs(), "paused": workshop.queue.is_paused() }))).await
}

async fn begin(State(workshop): State<Arc<Workshop>>, Body(request): Body<JobRequest>) -> Answer<Value> {
    of(move || clips::render(&workshop, &request)).await
}

async fn preview(State(workshop): State<Arc<Workshop>>, Body(request): Body<PreviewRequest>) -> Answer<Value> {
    of(move || previews::preview(&workshop, &request)).await
}

async fn pause(State(workshop): State<Arc<Workshop>>, Body(Pause { paused }): Body<Pause>) -> Answer<Value> {
    of(move || {
        workshop.queue.pause(paused);
        workshop.tell_all();
        Ok(json!({ "paused": paused }))
    })
    .await
}

async fn pause_one(
    State(workshop): State<Arc<Workshop>>,
    Path(id): Path<JobId>,
    Body(Pause { paused }): Body<Pause>,
) -> Answer<Value> {
    of(move || {
        let job = workshop.queue.pause_job(id, paused).ok_or_else(|| missing(format!("there is no job {id}")))?;
        if paused && !job.paused {
            let why = if job.state.is_over() { "is over" } else { "has no steps between which it could stand still" };
            return Err(conflict(format!("`{}` {why}", job.what)));
        }
        Ok(json!({ "job": job }))
    })
    .await
}

async fn cancel(State(workshop): State<Arc<Workshop>>, Path(id): Path<JobId>) -> Answer<Value> {
    of(move || {
        let is_known = workshop.queue.cancel(id);
        is_known.then(|| json!({ "cancelled": id })).ok_or_else(|| missing(format!("there is no job {id}")))
    })
    .await
}
