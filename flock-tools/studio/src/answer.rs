//! How a request is read and answered: off the threads that talk to pages, as JSON, or with a sentence that says why not.
//!
//! Owns these steps, which all handlers take; the form `{"error": "a sentence"}`, and that every refusal has it: also what
//! `axum` refuses by itself. Never says which requests are let in: `fence` does.
//!
//! Start at [`Problem`] and [`of`] for what is answered, at [`Body`] for what is read.

use axum::Json;
use axum::extract::rejection::{JsonRejection, QueryRejection};
use axum::extract::{FromRequest, FromRequestParts, Query, Request};
use axum::http::StatusCode;
use axum::http::request::Parts;
use axum::response::{IntoResponse, Response};
use flock::Measure;
use operations::program::Fatal;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use tokio::task::spawn_blocking;

/// A request that got nothing: the status, the sentence for the artist, and what the page needs besides.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Problem {
    status: StatusCode,
    body: Map<String, Value>,
}

/// The body of a request as JSON. What is malformed is answered with a [`Problem`] of 400, too much with 413.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Body<T>(pub(crate) T);

impl Problem {
    /// This status, with a sentence.
    pub(crate) fn new(status: StatusCode, error: impl Into<String>) -> Self {
        Self { status, body: Map::from_iter([("error".to_owned(), Value::String(error.into()))]) }
    }

    /// With `value` under `key`, too. A value that is no JSON is left out.
    #[must_use]
    pub(crate) fn with(mut self, key: &str, value: impl Serialize) -> Self {
        if let Ok(value) = serde_json::to_value(value) {
            self.body.insert(key.to_owned(), value);
        }
        self
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        (self.status, Json(self.body)).into_response()
    }
}

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for Body<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, state: &S) -> Result<Self, Problem> {
        let read: Result<Json<T>, JsonRejection> = Json::from_request(request, state).await;
        let refused = |refusal: JsonRejection| match refusal.status() {
            // To the page 422 is an edit that was understood and refused.
            StatusCode::UNPROCESSABLE_ENTITY => Problem::new(StatusCode::BAD_REQUEST, refusal.body_text()),
            status => Problem::new(status, refusal.body_text()),
        };
        read.map(|Json(body)| Self(body)).map_err(refused)
    }
}

/// What a handler answers.
pub(crate) type Answer<T> = Result<Json<T>, Problem>;

/// The query of a request. What is malformed is answered with a [`Problem`] of 400.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked<T>(pub(crate) T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequestParts<S> for Asked<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let read: Result<Query<T>, QueryRejection> = Query::from_request_parts(parts, state).await;
        read.map(|Query(asked)| Self(asked)).map_err(|refusal| malformed(refusal.body_text()))
    }
}

/// The answer of `work`, which may take long and read files.
pub(crate) async fn of<T, F>(work: F) -> Answer<T>
where
    T: Serialize + Send + 'static,
    F: FnOnce() -> Result<T, Problem> + Send + 'static,
{
    blocking(work).await.map(Json)
}

/// The result of `work`, as it is.
pub(crate) async fn blocking<T, F>(work: F) -> Result<T, Problem>
where
    T: Send + 'static,
    F: FnOnce() -> Result<T, Problem> + Send + 'static,
{
    let bug = |_| Problem::new(StatusCode::INTERNAL_SERVER_ERROR, "the program has a bug: this answer panicked");
    spawn_blocking(work).await.unwrap_or_else(|error| Err(bug(error)))
}

/// What was asked for is not there.
pub(crate) fn missing(what: impl Into<String>) -> Problem {
    Problem::new(StatusCode::NOT_FOUND, what)
}

/// What was asked for was understood and is refused.
pub(crate) fn refused(why: impl Into<String>) -> Problem {
    Problem::new(StatusCode::UNPROCESSABLE_ENTITY, why)
}

/// The request is malformed.
pub(crate) fn malformed(why: impl Into<String>) -> Problem {
    Problem::new(StatusCode::BAD_REQUEST, why)
}

/// It cannot be done as things are.
pub(crate) fn conflict(why: impl Into<String>) -> Problem {
    Problem::new(StatusCode::CONFLICT, why)
}

/// What would end a command.
#[expect(clippy::needless_pass_by_value, reason = "for `map_err`")]
pub(crate) fn fatal(fatal: Fatal) -> Problem {
    refused(fatal.in_words())
}

/// `visits`, which it is if nothing is said, or `time`.
pub(crate) fn measure(by: Option<&str>) -> Result<Measure, Problem> {
    match by {
        None | Some("visits") => Ok(Measure::Visits),
        Some("time") => Ok(Measure::Time),
        Some(other) => Err(malformed(format!("shares are of `visits` or of `time`, found `{other}`"))),
    }
}
