//! Receives reports, and answers with page, metrics and JSON.
//!
//! Owns the routes, the headers of every answer, and how much strangers may cost: the number of connections, each of which
//! is one request, its time, the bytes of a report, and how many are read at once. Never reads a report: `desk` does.
//!
//! Start at [`router`] and [`serve`].

use std::future::Future;
use std::io;
use std::net::TcpListener as StdListener;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

use axum::body::to_bytes;
use axum::extract::{Path, Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HeaderName, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
    X_FRAME_OPTIONS,
};
use axum::http::{HeaderValue, Method, StatusCode};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Json, Router};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use operations::program::now;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Semaphore;
use tokio::task::{JoinSet, spawn_blocking};
use tokio::time::{sleep, timeout};

use crate::desk::{Desk, Rejected};
use crate::doors::Doors;
use crate::facts::MOST_BYTES;
use crate::metrics;
use crate::page::{CODE, Form, LOOK, page};
use crate::record::UnitView;

/// The most connections at once; a further one waits.
const MOST_CONNECTIONS: usize = 256;
/// The most reports that are received at once: so many that a few slow senders keep no other out.
const MOST_REPORTS: usize = 64;
/// The longest time of a connection, and until it has sent the head of its request.
const LONGEST: Duration = Duration::from_secs(30);
const LONGEST_HEAD: Duration = Duration::from_secs(10);
/// The most bytes of a head.
const MOST_HEAD_BYTES: usize = 16 << 10;
/// How long what is being answered may take once the server is to end.
const LAST_ANSWERS: Duration = Duration::from_millis(500);
/// How long nothing is accepted after the system could not.
const REST: Duration = Duration::from_millis(100);

/// What the page may load and run.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; \
     base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// What is the same on every answer. A picture may be kept: its address changes with each report.
const ALWAYS: [(HeaderName, &str); 6] = [
    (CONTENT_SECURITY_POLICY, POLICY),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (REFERRER_POLICY, "no-referrer"),
    (X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (X_FRAME_OPTIONS, "DENY"),
];

/// What all requests share.
struct App {
    desk: Arc<Desk>,
    doors: Doors,
    reports: Semaphore,
    /// One report is read after the other, on one thread: the allocator keeps memory for each thread.
    reading: Semaphore,
}

/// All units, as JSON.
#[derive(serde::Serialize)]
struct Units {
    ok: bool,
    units: Vec<UnitView>,
}

/// The routes of a server.
pub(crate) fn router(desk: Arc<Desk>, doors: Doors) -> Router {
    let app = Arc::new(App { desk, doors, reports: Semaphore::new(MOST_REPORTS), reading: Semaphore::new(1) });
    let asset = |kind: &'static str, text: &'static str| get(move || async move { ([(CONTENT_TYPE, kind)], text) });
    Router::new()
        .route("/", get(show).post(receive))
        .route("/fleet.json", get(json).post(receive))
        .route("/metrics", get(measure).post(receive))
        .route("/fleet.css", asset("text/css; charset=utf-8", LOOK))
        .route("/fleet.js", asset("text/javascript; charset=utf-8", CODE))
        .route("/picture/{unit}", get(picture).post(receive))
        .fallback(elsewhere)
        .layer(middleware::from_fn_with_state(Arc::clone(&app), guard))
        .with_state(app)
}

/// Lets a request in or not, and puts the headers on whatever is answered.
async fn guard(State(app): State<Arc<App>>, request: Request, next: Next) -> Response {
    let (parts, body) = request.into_parts();
    let mut response = match app.doors.check(&parts) {
        Ok(()) => next.run(Request::from_parts(parts, body)).await,
        Err(refusal) => refusal.into_response(),
    };
    for (name, value) in ALWAYS {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response.headers_mut().entry(CACHE_CONTROL).or_insert(HeaderValue::from_static("no-store"));
    response
}

impl App {
    fn views(&self) -> Vec<UnitView> {
        self.desk.views(now_s())
    }
}

async fn show(State(app): State<Arc<App>>) -> Response {
    let address = |view: &UnitView| {
        view.arrived_s.filter(|_| view.has_picture).map(|at| format!("picture/{}?at={at}", view.unit))
    };
    let text = page(&app.views(), Form::Served, address);
    ([(CONTENT_TYPE, "text/html; charset=utf-8")], text).into_response()
}

async fn json(State(app): State<Arc<App>>) -> Response {
    let units = app.views();
    Json(Units { ok: units.iter().all(|view| view.ok), units }).into_response()
}

async fn measure(State(app): State<Arc<App>>) -> Response {
    ([(CONTENT_TYPE, metrics::KIND)], metrics::text(&app.views(), &app.desk.counts)).into_response()
}

async fn picture(State(app): State<Arc<App>>, Path(unit): Path<String>) -> Response {
    let headers = [(CONTENT_TYPE, "image/jpeg"), (CACHE_CONTROL, "private, max-age=604800, immutable")];
    match app.desk.picture(&unit) {
        Some(bytes) => (headers, bytes).into_response(),
        None => (StatusCode::NOT_FOUND, "no unit of this name has sent a picture\n").into_response(),
    }
}

/// Any other path: a report may be sent there.
async fn elsewhere(app: State<Arc<App>>, request: Request) -> Response {
    if request.method() == Method::POST {
        receive(app, request).await
    } else {
        (StatusCode::NOT_FOUND, "there is nothing of this name\n").into_response()
    }
}

async fn receive(State(app): State<Arc<App>>, request: Request) -> Response {
    // It is never closed.
    let _permit = app.reports.acquire().await;
    let Ok(bytes) = to_bytes(request.into_body(), MOST_BYTES).await else {
        let error = format!("a report has at most {MOST_BYTES} bytes\n");
        return (StatusCode::PAYLOAD_TOO_LARGE, error).into_response();
    };
    let _reading = app.reading.acquire().await;
    let desk = Arc::clone(&app.desk);
    match spawn_blocking(move || desk.receive(&bytes, now_s())).await {
        Ok(Ok(())) => StatusCode::NO_CONTENT.into_response(),
        Ok(Err(rejected)) => (status(&rejected), format!("{rejected}\n")).into_response(),
        Err(_) => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
    }
}

fn status(rejected: &Rejected) -> StatusCode {
    match rejected {
        Rejected::Disk(_) => StatusCode::INSUFFICIENT_STORAGE,
        Rejected::Many { .. } | Rejected::Unknown { .. } => StatusCode::FORBIDDEN,
        Rejected::Report(_) => StatusCode::BAD_REQUEST,
    }
}

fn now_s() -> u64 {
    now::since_1970_ms() / 1000
}

/// Answers with `router` until `stop` is there, then finishes what is being answered, for half a second.
/// Errors: If the socket cannot be used.
pub(crate) async fn serve(listener: StdListener, router: Router, stop: impl Future<Output = ()>) -> io::Result<()> {
    listener.set_nonblocking(true)?;
    let listener = TcpListener::from_std(listener)?;
    let places = Arc::new(Semaphore::new(MOST_CONNECTIONS));
    let (mut stop, mut connections) = (pin!(stop), JoinSet::new());
    loop {
        let accepting = async {
            let place = Arc::clone(&places).acquire_owned().await;
            (place, listener.accept().await)
        };
        let (place, accepted) = tokio::select! {
            accepted = accepting => accepted,
            () = stop.as_mut() => break,
        };
        while connections.try_join_next().is_some() {}
        let Ok((stream, _)) = accepted else {
            // Such as without a free descriptor: soon there may be one.
            sleep(REST).await;
            continue;
        };
        let router = router.clone();
        connections.spawn(async move {
            // A connection that takes longer is closed.
            let _ = timeout(LONGEST, answer(stream, router)).await;
            drop(place);
        });
    }
    // What takes longer is cut off.
    let _ = timeout(LAST_ANSWERS, async { while connections.join_next().await.is_some() {} }).await;
    Ok(())
}

async fn answer(stream: TcpStream, router: Router) {
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(LONGEST_HEAD).max_buf_size(MOST_HEAD_BYTES).keep_alive(false);
    // Errors on a connection are the other end's.
    let _ = http.serve_connection(TokioIo::new(stream), TowerToHyperService::new(router)).await;
}
