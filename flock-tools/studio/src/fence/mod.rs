//! Which requests are let in.
//!
//! Owns the fence around the studio's server: every page that a browser of this machine shows, and every user of the
//! machine, can reach its port. Before anything is routed, a request must name this server by an address or as
//! `localhost`, which stops names that lead here (DNS rebinding); for more than the page's own files it needs the
//! cookie and the secret that the server gives for the token in its address; a change must also come from our own page and
//! be JSON. A request takes a permit when all this is known of it. Never looks into a body.
//!
//! # Source
//! RFC 9110; Fetch metadata request headers (W3C). The order is that of [`Fence::judge`].
//!
//! Start at [`layer`].

mod headers;
mod secrets;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::time::Duration;

use axum::body::Body as Bytes;
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::header::{ALLOW, CONTENT_LENGTH, CONTENT_TYPE, COOKIE, HOST, HeaderName, ORIGIN, SET_COOKIE};
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::post;
use axum::{Json, Router};
use serde::{Deserialize, Serialize};
use tokio::sync::Semaphore;
use tokio::time::timeout;

use crate::answer::{Body, Problem};
use crate::connections::Place;
pub(crate) use secrets::Secrets;

/// The most bytes of a body, unless a route allows more.
pub(crate) const MOST_BYTES: usize = 1 << 20;
/// The most bytes of any body.
pub(crate) const MOST_IMPORTED_BYTES: usize = 4 << 20;
/// The most bytes of a path with its query.
const LONGEST_PATH: usize = 2048;
/// The most bytes of the body with the token.
const MOST_TOKEN_BYTES: usize = 1 << 10;
/// The most requests of pages at once.
const MOST_REQUESTS: usize = 64;
/// The longest time until a request is answered, its body included.
const LONGEST: Duration = Duration::from_secs(30);
/// What a page sends with every question.
static SECRET: HeaderName = HeaderName::from_static("x-studio-secret");
/// Where a browser says that a request comes from.
static FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");
static FETCH_MODE: HeaderName = HeaderName::from_static("sec-fetch-mode");
/// The member of the query that stands for it where an element asks, which sends no header.
const LOOK: &str = "look=";
/// Where a page listens.
const EVENTS: &str = "/events";
/// Where a page tells the token.
const SESSION: &str = "/session";
/// What may be asked.
const METHODS: &str = "GET, HEAD, POST, DELETE";

/// The fence of one server.
#[derive(Debug)]
pub(crate) struct Fence {
    port: u16,
    secrets: Secrets,
    requests: Semaphore,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Token {
    token: String,
}

#[derive(Serialize)]
struct Session<'s> {
    secret: &'s str,
    look: &'s str,
}

/// Who asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Caller {
    /// A page of this session.
    Page,
    /// Anybody, for what anybody may have.
    Stranger,
}

/// Puts `fence` around all routes of `inside`, with the route of the session, the limits and the headers of every answer.
pub(crate) fn layer(inside: Router, fence: Arc<Fence>) -> Router {
    let begin = post(begin_session).layer(DefaultBodyLimit::max(MOST_TOKEN_BYTES));
    let session = Router::new().route(SESSION, begin).with_state(Arc::clone(&fence));
    let missing = || async { Problem::new(StatusCode::NOT_FOUND, "there is nothing of this name") };
    inside
        .merge(session)
        .fallback(missing)
        .method_not_allowed_fallback(|| async { not_allowed() })
        .layer(DefaultBodyLimit::max(MOST_BYTES))
        .layer(middleware::from_fn_with_state(fence, pass))
}

impl Fence {
    /// The fence of the server at `port`.
    pub(crate) fn new(port: u16, secrets: Secrets) -> Self {
        Self { port, secrets, requests: Semaphore::new(MOST_REQUESTS) }
    }

    /// The address for the artist. The token stands behind `#`, which browsers neither send nor log elsewhere.
    pub(crate) fn address(&self) -> String {
        format!("http://127.0.0.1:{}/#{}", self.port, self.secrets.token)
    }

    /// The name of the cookie. Browsers keep one jar for all ports, so that two studios must not share a name.
    pub(crate) fn cookie_name(&self) -> String {
        format!("dreams-studio-{}", self.port)
    }

    /// Admits a request and returns who asks, or refuses it. The order matters: a request from elsewhere learns nothing but
    /// that.
    /// Errors: What is answered instead.
    fn judge(&self, request: &Parts) -> Result<Caller, Problem> {
        let host = self.host(request)?;
        let changes = match request.method {
            Method::GET | Method::HEAD => false,
            Method::POST | Method::DELETE => true,
            _ => return Err(not_allowed()),
        };
        plain_path(request)?;
        let path = request.uri.path();
        from_our_page(request, &host, changes)?;
        let is_public = path == "/" || path.starts_with("/app/") || path == SESSION;
        if !is_public {
            self.admit_session(request, path, changes)?;
        }
        if changes {
            may_change(request)?;
        }
        Ok(if is_public { Caller::Stranger } else { Caller::Page })
    }

    /// The host that the request names, in lower case, if it is ours.
    fn host(&self, request: &Parts) -> Result<String, Problem> {
        let misdirected = || Problem::new(StatusCode::MISDIRECTED_REQUEST, "this server has another name");
        let mut named = request.headers.get_all(HOST).iter();
        let host = named.next().and_then(|host| host.to_str().ok()).map(str::to_ascii_lowercase);
        let host = host.filter(|host| self.is_ours(host)).ok_or_else(misdirected)?;
        let another = request.uri.authority().is_some_and(|named| !named.as_str().eq_ignore_ascii_case(&host));
        if named.next().is_some() || another { Err(misdirected()) } else { Ok(host) }
    }

    fn is_ours(&self, host: &str) -> bool {
        ["127.0.0.1", "localhost", "[::1]"].iter().any(|name| *host == format!("{name}:{}", self.port))
    }

    fn has_cookie(&self, headers: &HeaderMap) -> bool {
        let name = self.cookie_name();
        let pairs = headers.get_all(COOKIE).iter().flat_map(|all| all.as_bytes().split(|byte| *byte == b';'));
        let values = pairs.filter_map(|pair| pair.trim_ascii().strip_prefix(name.as_bytes())?.strip_prefix(b"="));
        // The first one counts, as it does for browsers.
        values.take(1).any(|value| secrets::is(&self.secrets.cookie, value))
    }

    /// Refuses whoever was not told the token, and whoever has only the cookie, which a browser sends to every port of this
    /// machine.
    fn admit_session(&self, request: &Parts, path: &str, changes: bool) -> Result<(), Problem> {
        if !self.has_cookie(&request.headers) {
            let how = "this page knows no session: open the address that `dreams studio` has printed";
            return Err(Problem::new(StatusCode::UNAUTHORIZED, how));
        }
        let given = only(&request.headers, &SECRET).map_or(&b""[..], HeaderValue::as_bytes);
        let is_for_elements = !changes && (path == EVENTS || path.starts_with("/media/"));
        let mut asked = request.uri.query().unwrap_or_default().split('&');
        let look = asked.find_map(|member| member.strip_prefix(LOOK)).filter(|_| is_for_elements);
        let has_look = look.is_some_and(|look| secrets::is(&self.secrets.look, look.as_bytes()));
        if has_look || secrets::is(&self.secrets.page, given) {
            return Ok(());
        }
        let how = "the cookie alone reads and changes nothing: this needs what only a page of this session knows";
        Err(Problem::new(StatusCode::FORBIDDEN, how))
    }
}

/// Judges a request, has it answered in time, and puts the headers on whatever is answered. A stranger takes no permit and
/// needs none: one connection asks one thing at a time, and `connections` bounds those.
async fn pass(State(fence): State<Arc<Fence>>, request: Request, next: Next) -> Response {
    let (parts, body) = request.into_parts();
    let mut response = match fence.judge(&parts) {
        Ok(Caller::Page) => {
            if let Some(place) = parts.extensions.get::<Arc<Place>>() {
                place.keep();
            }
            answer(&fence, Request::from_parts(parts, body), next).await
        }
        Ok(Caller::Stranger) => in_time(next.run(Request::from_parts(parts, body))).await,
        Err(problem) => problem.into_response(),
    };
    headers::put(response.headers_mut());
    if response.status() == StatusCode::METHOD_NOT_ALLOWED {
        response.headers_mut().insert(ALLOW, HeaderValue::from_static(METHODS));
    }
    response
}

async fn answer(fence: &Fence, request: Request<Bytes>, next: Next) -> Response {
    let Ok(_permit) = fence.requests.try_acquire() else {
        let error = format!("{MOST_REQUESTS} requests are being answered already");
        return Problem::new(StatusCode::TOO_MANY_REQUESTS, error).into_response();
    };
    in_time(next.run(request)).await
}

async fn in_time(answer: impl Future<Output = Response>) -> Response {
    let late = |_| Problem::new(StatusCode::REQUEST_TIMEOUT, "the request took longer than 30 seconds").into_response();
    timeout(LONGEST, answer).await.unwrap_or_else(late)
}

/// Takes the token of the address, and gives the cookie and what a page asks with.
async fn begin_session(State(fence): State<Arc<Fence>>, Body(Token { token }): Body<Token>) -> Response {
    let Fence { secrets: all, .. } = &*fence;
    if !secrets::is(&all.token, token.as_bytes()) {
        let error =
            "this is not the address of this start of the studio: open the one that `dreams studio` has printed";
        return Problem::new(StatusCode::UNAUTHORIZED, error).into_response();
    }
    let cookie = format!("{}={}; HttpOnly; SameSite=Strict; Path=/", fence.cookie_name(), all.cookie);
    ([(SET_COOKIE, cookie)], Json(Session { secret: &all.page, look: &all.look })).into_response()
}

/// Refuses paths that our own page never asks for: all names here are of plain letters.
fn plain_path(request: &Parts) -> Result<(), Problem> {
    let path = request.uri.path();
    let is_plain = |part: &str| part != "." && part != ".." && !part.is_empty();
    let parts = path.strip_prefix('/').map(|rest| rest.split('/'));
    let is_fine = parts.is_some_and(|mut parts| path == "/" || parts.all(is_plain));
    let length = request.uri.path_and_query().map_or(0, |all| all.as_str().len());
    if is_fine && length <= LONGEST_PATH && !path.contains(['%', '\\', '\0']) {
        return Ok(());
    }
    Err(Problem::new(StatusCode::NOT_FOUND, "this path is not one of the studio's"))
}

/// Refuses changes that are no JSON, and those that are too large.
fn may_change(request: &Parts) -> Result<(), Problem> {
    if !only(&request.headers, &CONTENT_TYPE).is_some_and(is_json) {
        return Err(Problem::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, "a change must be `application/json`"));
    }
    let length = request.headers.get(CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
    if length.is_some_and(|length| length > MOST_IMPORTED_BYTES as u64) {
        let error = format!("a request has at most {MOST_IMPORTED_BYTES} bytes");
        return Err(Problem::new(StatusCode::PAYLOAD_TOO_LARGE, error));
    }
    Ok(())
}

/// Refuses what a browser sends for another page than ours; to look at the page itself one may come from anywhere.
fn from_our_page(request: &Parts, host: &str, changes: bool) -> Result<(), Problem> {
    let elsewhere = || Problem::new(StatusCode::FORBIDDEN, "this request comes from another page");
    let header = |name| only(&request.headers, name).map(HeaderValue::as_bytes);
    let origin = format!("http://{host}");
    let is_own = |given: &[u8]| given == origin.as_bytes();
    let has_origin = request.headers.contains_key(ORIGIN);
    if (changes || has_origin) && !header(&ORIGIN).is_some_and(is_own) {
        return Err(elsewhere());
    }
    let navigates = request.uri.path() == "/" && header(&FETCH_MODE) == Some(b"navigate");
    match header(&FETCH_SITE) {
        None if request.headers.contains_key(&FETCH_SITE) => Err(elsewhere()),
        None | Some(b"same-origin") => Ok(()),
        Some(b"none") if !changes => Ok(()),
        Some(_) if navigates && !changes => Ok(()),
        Some(_) => Err(elsewhere()),
    }
}

/// The value of a header that stands there once.
fn only<'h>(headers: &'h HeaderMap, name: &HeaderName) -> Option<&'h HeaderValue> {
    let mut values = headers.get_all(name).iter();
    values.next().filter(|_| values.next().is_none())
}

fn is_json(value: &HeaderValue) -> bool {
    let mut parts = value.as_bytes().split(|byte| *byte == b';').map(<[u8]>::trim_ascii);
    let is_json = parts.next().is_some_and(|kind| kind.eq_ignore_ascii_case(b"application/json"));
    is_json && parts.all(|parameter| parameter.eq_ignore_ascii_case(b"charset=utf-8"))
}

fn not_allowed() -> Problem {
    Problem::new(StatusCode::METHOD_NOT_ALLOWED, "this method is not allowed here")
}
