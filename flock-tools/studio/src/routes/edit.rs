//! What changes the flock, and what the artist notes of it.
//!
//! Owns these handlers: an edit is made by the document, and the page is told by events, whichever page made it.
//!
//! Start at [`router`].

use std::sync::Arc;

use axum::Router;
use axum::extract::State;
use axum::http::StatusCode;
use axum::routing::post;
use flock::{Flock, Manifest, Measure, SheepId};
use serde_json::{Value, json};

use crate::answer::{Answer, Body, Problem, conflict, malformed, measure, of, refused};
use crate::document::{Applied, ApplyError, EditRequest, NoteError, NoteRequest, Revision, UndoError, Undone};
use crate::events::EventKind;
use crate::lock::locked;
use crate::requests::{EditsRequest, JoinMark, Marks, Pin, StepRequest, WhatIfRequest};
use crate::views::figures::{Figures, WhatIf};
use crate::views::state_delta::StateAnswer;
use crate::workshop::Workshop;

/// The routes.
pub(super) fn router() -> Router<Arc<Workshop>> {
    Router::new()
        .route("/api/edits", post(edit))
        .route("/api/whatif", post(what_if))
        .route("/api/undo", post(undo))
        .route("/api/redo", post(redo))
        .route("/api/marks", post(mark))
        .route("/api/pins", post(pin))
        .route("/api/joins/bad", post(mark_join))
}

/// The answer to edits that were made.
#[derive(Debug, serde::Serialize)]
struct Edited {
    revision: Revision,
    figures: Figures,
    said: String,
    merged: bool,
    no_longer_shown: Vec<SheepId>,
    undo: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    state: Option<StateAnswer>,
}

/// The answer to a step that was taken back, or done again.
#[derive(Debug, serde::Serialize)]
struct Gone {
    revision: Revision,
    said: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    state: Option<StateAnswer>,
}

async fn edit(State(workshop): State<Arc<Workshop>>, Body(request): Body<EditsRequest>) -> Answer<Edited> {
    let by = measure(request.by.as_deref())?;
    of(move || {
        let EditsRequest { revision, gesture, edits, force, since, .. } = request;
        if edits.is_empty() {
            return Err(malformed("no edit is named"));
        }
        let applied = locked(&workshop.document).apply(&edits, &revision, gesture.as_deref(), force);
        let Applied { revision, said, merged, no_longer_shown } =
            applied.map_err(|error| edit_problem(&workshop, error, by))?;
        workshop.tell_changed();
        let (_, flock) = workshop.flock();
        let (figures, undo) = (Figures::of_flock(&flock, by), workshop.snapshot().undo);
        let state = news(&workshop, by, since.as_deref());
        Ok(Edited { revision, figures, said, merged, no_longer_shown, undo, state })
    })
    .await
}

/// What is new to the page that asked, if it says what it has. What cannot be told now it fetches, and is told why not.
fn news(workshop: &Workshop, by: Measure, since: Option<&str>) -> Option<StateAnswer> {
    since.and_then(|since| workshop.told(by, Some(since)).ok())
}

async fn what_if(State(workshop): State<Arc<Workshop>>, Body(request): Body<WhatIfRequest>) -> Answer<Value> {
    let by = measure(request.by.as_deref())?;
    of(move || {
        let (_, before) = workshop.flock();
        let manifest = locked(&workshop.document).what_if(&request.edits);
        let manifest = manifest.map_err(|error| edit_problem(&workshop, error, by))?;
        let cost_s = cost(&workshop, &manifest, &request.edits);
        let told = WhatIf { cost_s, ..WhatIf::of(&before, &Flock::new(manifest), by) };
        let mut told = serde_json::to_value(told).unwrap_or_default();
        told["sequence"] = json!(request.sequence);
        Ok(told)
    })
    .await
}

/// Seconds that new transitions take to render; `None` if nothing is known of one, or if there are none.
fn cost(workshop: &Workshop, manifest: &Manifest, edits: &[EditRequest]) -> Option<f64> {
    let linked: Vec<(&SheepId, &SheepId)> = edits
        .iter()
        .filter_map(|edit| if let EditRequest::Link { from, to, .. } = edit { Some((from, to)) } else { None })
        .collect();
    let keys = workshop.keys(manifest);
    let of_one = |(from, to): &(&SheepId, &SheepId)| {
        let own = manifest.transitions.iter().find(|own| own.from == **from && own.to == **to)?;
        keys.cost_s(from, to, own.clip.frames.0)
    };
    if linked.is_empty() { None } else { linked.iter().map(of_one).sum() }
}

/// What is answered to edits that were not made.
fn edit_problem(workshop: &Workshop, error: ApplyError, by: Measure) -> Problem {
    let sentence = error.to_string();
    match error {
        ApplyError::Conflict { .. } => match workshop.state(by) {
            Ok(state) => conflict(sentence).with("state", state),
            Err(_) => conflict(sentence),
        },
        ApplyError::Disk(_) => Problem::new(StatusCode::INTERNAL_SERVER_ERROR, sentence),
        ApplyError::Empty => Problem::new(StatusCode::PRECONDITION_REQUIRED, sentence).with("no_longer_shown", [""; 0]),
        ApplyError::Manifest(_) | ApplyError::Refused { .. } => refused(sentence),
        ApplyError::Unshown { no_longer_shown } => {
            Problem::new(StatusCode::PRECONDITION_REQUIRED, sentence).with("no_longer_shown", no_longer_shown)
        }
    }
}

async fn undo(State(workshop): State<Arc<Workshop>>, Body(request): Body<StepRequest>) -> Answer<Gone> {
    of(move || {
        let undone = locked(&workshop.document).undo();
        went(&workshop, undone, &request)
    })
    .await
}

async fn redo(State(workshop): State<Arc<Workshop>>, Body(request): Body<StepRequest>) -> Answer<Gone> {
    of(move || {
        let done = locked(&workshop.document).redo();
        went(&workshop, done, &request)
    })
    .await
}

/// The answer to a step that was taken back, or done again.
fn went(workshop: &Workshop, step: Result<Undone, UndoError>, request: &StepRequest) -> Result<Gone, Problem> {
    let Undone { revision, said } = step.map_err(|error| {
        let sentence = error.to_string();
        match error {
            UndoError::Changed { .. } | UndoError::Nothing { .. } | UndoError::Pool { .. } => conflict(sentence),
            UndoError::Manifest(_) => refused(sentence),
            UndoError::Disk(_) => Problem::new(StatusCode::INTERNAL_SERVER_ERROR, sentence),
        }
    })?;
    workshop.tell_changed();
    Ok(Gone { revision, said, state: news(workshop, Measure::Visits, request.since.as_deref()) })
}

async fn mark(State(workshop): State<Arc<Workshop>>, Body(Marks { marks }): Body<Marks>) -> Answer<Value> {
    of(move || {
        let told: Vec<Value> =
            marks.iter().map(|own| json!({ "sheep": own.sheep, "mark": own.mark, "rating": own.rating })).collect();
        let notes =
            marks.into_iter().map(|own| NoteRequest::Mark { sheep: own.sheep, mark: own.mark, rating: own.rating });
        note(&workshop, &notes.collect::<Vec<_>>(), &json!({ "marks": told }))
    })
    .await
}

async fn pin(State(workshop): State<Arc<Workshop>>, Body(Pin { sheep, x, y }): Body<Pin>) -> Answer<Value> {
    of(move || {
        let at = x.zip(y).map(|(x, y)| [x, y]);
        let told = json!({ "pins": [{ "sheep": sheep, "x": x, "y": y }] });
        note(&workshop, &[NoteRequest::Pin { sheep, at }], &told)
    })
    .await
}

async fn mark_join(
    State(workshop): State<Arc<Workshop>>,
    Body(JoinMark { from, to, bad }): Body<JoinMark>,
) -> Answer<Value> {
    of(move || {
        let told = json!({ "joins": [{ "from": from, "to": to, "bad": bad }] });
        note(&workshop, &[NoteRequest::Join { from, to, bad }], &told)
    })
    .await
}

/// Makes notes, and tells the pages what they are.
fn note(workshop: &Workshop, notes: &[NoteRequest], told: &Value) -> Result<Value, Problem> {
    let said = locked(&workshop.document).note(notes, None).map_err(|error| {
        let sentence = error.to_string();
        match error {
            NoteError::Disk(_) => Problem::new(StatusCode::INTERNAL_SERVER_ERROR, sentence),
            NoteError::Pool { .. } => conflict(sentence),
            NoteError::Refused(_) => refused(sentence),
        }
    })?;
    workshop.hub.send(EventKind::Marks, told);
    let snapshot = workshop.snapshot();
    Ok(json!({ "said": said, "undo": snapshot.undo, "redo": snapshot.redo }))
}
