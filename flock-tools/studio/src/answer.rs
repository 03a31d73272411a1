//! Errors as the page reads them, and the bodies of requests.
//!
//! Owns the form `{"error": "a sentence"}`, and that every refusal has it: also what `axum` refuses by itself. Never says
//! which requests are let in: `fence` does.
//!
//! Start at [`Problem`] for what is answered, at [`Body`] for what is read.

use axum::Json;
use axum::extract::rejection::JsonRejection;
use axum::extract::{FromRequest, Request};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

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
