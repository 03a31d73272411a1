//! How a request is answered: off the threads that talk to pages, as JSON, or with a sentence that says why not.
//!
//! Owns these steps, which all handlers take.
//!
//! Start at [`of`].

use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{FromRequestParts, Query};
use axum::http::StatusCode;
use axum::http::request::Parts;
use flock::Measure;
use operations::program::Fatal;
use serde::Serialize;
use serde::de::DeserializeOwned;
use tokio::task::spawn_blocking;

use crate::answer::Problem;

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
