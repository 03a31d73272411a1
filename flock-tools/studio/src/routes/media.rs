//! Pictures and clips, by their keys.
//!
//! Owns these handlers. A key stands for content that never changes, so a browser may keep what it got; what is not made yet
//! is queued, and the page is told by the event of its job.
//!
//! Start at [`router`].

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::{Path, State};
use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE, RETRY_AFTER};
use axum::http::{HeaderName, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use axum::routing::get;

use crate::answer::{Asked, Problem, blocking, malformed, missing, refused};
use crate::media::MediaError;
use crate::requests::{MiddleQuery, PacketsQuery, PreviewQuery};
use crate::work::previews;
use crate::workshop::Workshop;

/// How long a request waits for a strip. A browser has six connections to a host, which must not all wait.
const PATIENCE: Duration = Duration::from_secs(1);
/// How often it looks meanwhile.
const LOOK: Duration = Duration::from_millis(50);
/// What content that never changes is kept by.
const FOR_EVER: &str = "private, max-age=31536000, immutable";
const JPEG: &str = "image/jpeg";
const MP4: &str = "video/mp4";
const BYTES: &str = "application/octet-stream";
/// The codec of a clip, and whether a growing one is whole.
const CODEC: HeaderName = HeaderName::from_static("x-codec");
const WHOLE: HeaderName = HeaderName::from_static("x-whole");

/// The routes.
pub(super) fn router() -> Router<Arc<Workshop>> {
    Router::new()
        .route("/media/strip/{key}", get(strip))
        .route("/media/poster/{key}", get(poster))
        .route("/media/fragments/{key}", get(fragments))
        .route("/media/packets/{key}", get(packets))
        .route("/media/middle/{key}", get(middle))
        .route("/media/preview/{key}", get(preview))
}

async fn strip(State(workshop): State<Arc<Workshop>>, Path(key): Path<String>) -> Result<Response, Problem> {
    let find = || {
        let (workshop, key) = (Arc::clone(&workshop), key.clone());
        blocking(move || workshop.media.find_strip(&key).map(|path| read(&path)).transpose())
    };
    if let Some(bytes) = find().await? {
        return Ok(kept(JPEG, bytes));
    }
    if !workshop.media.knows(&key) {
        return Err(missing("nothing has this key any more"));
    }
    if let Some(error) = previews::failed_strip(&workshop, &key) {
        return Err(refused(error));
    }
    previews::queue_strip(&workshop, &key);
    let mut waited = Duration::ZERO;
    while waited < PATIENCE {
        tokio::time::sleep(LOOK).await;
        waited += LOOK;
        if let Some(bytes) = find().await? {
            return Ok(kept(JPEG, bytes));
        }
    }
    // Not an error: the page asks again when the job's event comes.
    Ok((StatusCode::ACCEPTED, [(RETRY_AFTER, "1"), (CACHE_CONTROL, "no-store")]).into_response())
}

async fn poster(State(workshop): State<Arc<Workshop>>, Path(key): Path<String>) -> Result<Response, Problem> {
    let bytes = blocking(move || read(&workshop.media.poster(&key).map_err(problem)?)).await?;
    Ok(kept(JPEG, bytes))
}

async fn fragments(State(workshop): State<Arc<Workshop>>, Path(key): Path<String>) -> Result<Response, Problem> {
    let found = move || {
        let (path, codec) = workshop.media.fragments(&key).map_err(problem)?;
        Ok((read(&path)?, codec))
    };
    let (bytes, codec) = blocking(found).await?;
    Ok(([(CODEC, codec)], kept(MP4, bytes)).into_response())
}

async fn packets(
    State(workshop): State<Arc<Workshop>>,
    Path(key): Path<String>,
    Asked(PacketsQuery { from, to }): Asked<PacketsQuery>,
) -> Result<Response, Problem> {
    if from >= to {
        return Err(malformed(format!("frames are from one to a later one, found {from} to {to}")));
    }
    let bytes = blocking(move || workshop.media.packets(&key, from..to).map_err(problem)).await?;
    Ok(kept(BYTES, bytes))
}

async fn middle(
    State(workshop): State<Arc<Workshop>>,
    Path(key): Path<String>,
    Asked(MiddleQuery { at }): Asked<MiddleQuery>,
) -> Result<Response, Problem> {
    let find = move || {
        let path = workshop.media.find_middle(&key, at).ok_or_else(|| missing("this picture is not drawn yet"))?;
        read(&path)
    };
    Ok(kept(JPEG, blocking(find).await?))
}

async fn preview(
    State(workshop): State<Arc<Workshop>>,
    Path(key): Path<String>,
    Asked(PreviewQuery { from }): Asked<PreviewQuery>,
) -> Result<Response, Problem> {
    let find = move || {
        let found = workshop.media.moving(&key, from.unwrap_or(0));
        let (bytes, is_whole) = found.ok_or_else(|| missing("this preview is not begun yet"))?;
        Ok((bytes, is_whole))
    };
    let (bytes, is_whole) = blocking(find).await?;
    let whole = HeaderValue::from_static(if is_whole { "1" } else { "0" });
    Ok(([(CONTENT_TYPE, HeaderValue::from_static(MP4)), (WHOLE, whole)], bytes).into_response())
}

/// Content that never changes.
fn kept(kind: &'static str, bytes: Vec<u8>) -> Response {
    ([(CONTENT_TYPE, kind), (CACHE_CONTROL, FOR_EVER)], bytes).into_response()
}

fn read(path: &PathBuf) -> Result<Vec<u8>, Problem> {
    fs::read(path).map_err(|error| missing(format!("cannot read what was made: {error}")))
}

#[expect(clippy::needless_pass_by_value, reason = "for `map_err`")]
fn problem(error: MediaError) -> Problem {
    let status = match &error {
        MediaError::Unknown { .. } => StatusCode::NOT_FOUND,
        MediaError::Cancelled => StatusCode::SERVICE_UNAVAILABLE,
        MediaError::File { .. } | MediaError::Refused { .. } => StatusCode::UNPROCESSABLE_ENTITY,
    };
    Problem::new(status, error.to_string())
}
