//! The status page: what is on the glass, for people and for machines.
//!
//! Owns the HTTP server and its addresses: `/` for people, `/status.json`, `/metrics` for monitoring, `/screen.jpg`.
//! Only looks: nothing here changes what is played, and a picture is encoded only when someone asks for it.
//! What is told stands in `facts.rs`, how machines read it in `metrics.rs`, how people see it in `page.html`.

mod facts;
mod jpeg;
mod metrics;

use crate::faults::Faults;
use crate::glass::Glass;
use crate::now::now;
use crate::report::chain;
use crate::settings::StatusAddress;
use facts::Facts;
use flock::Flock;
use rustix::process::setpriority_process;
use std::fs;
use std::io;
use std::net::TcpListener;
use std::os::unix::fs::FileTypeExt;
use std::os::unix::net::UnixListener;
use std::path::Path;
use std::sync::Arc;
use std::thread;
use timing::Nanos;
use tiny_http::{Header, Listener, Method, Request, Response, Server};
use tracing::{debug, info, warn};

/// The page for people. It asks for `/status.json` and `/screen.jpg`, and for nothing from elsewhere.
const PAGE: &str = include_str!("page.html");

/// How far the page stands back behind the frames, 0 to 19.
const NICENESS: i32 = 15;

/// All that the page can tell.
pub(crate) struct Page {
    flock: Arc<Flock>,
    glass: Arc<Glass>,
    faults: Faults,
    begun: Nanos,
}

impl Page {
    /// The page of a run that begins now.
    pub(crate) fn new(flock: &Arc<Flock>, glass: &Arc<Glass>, faults: &Faults) -> Self {
        Self { flock: Arc::clone(flock), glass: Arc::clone(glass), faults: faults.clone(), begun: now() }
    }

    fn facts(&self) -> Facts {
        Facts::gather(&self.flock, &self.glass, &self.faults, now().since(self.begun))
    }
}

/// Serves `page` at `address` for as long as the process lives. If that cannot be done the picture goes on without.
pub(crate) fn serve(address: &StatusAddress, page: Page) {
    let listener = match address {
        StatusAddress::Off => return,
        StatusAddress::Host(host) => TcpListener::bind(host).map(Listener::from),
        StatusAddress::Unix(path) => bind(path).map(Listener::from),
    };
    let server = listener.and_then(|listener| Server::from_listener(listener, None).map_err(io::Error::other));
    let served = server.and_then(|server| {
        // With port 0 the kernel has chosen one.
        let at = server.server_addr().to_ip().map_or_else(|| address.to_string(), |ip| format!("http://{ip}/"));
        let answer_all = move || {
            // Linux has a niceness per thread: where processors are short, frames come first.
            setpriority_process(None, NICENESS).ok();
            for request in server.incoming_requests() {
                answer(request, &page);
            }
        };
        thread::Builder::new().name("status".to_owned()).spawn(answer_all).map(|_| at)
    });
    match served {
        Ok(at) => info!(at, "status page is served"),
        Err(error) => warn!(%address, error = chain(&error), "no status page"),
    }
}

/// Binds a unix socket, in place of the one that a killed player left.
fn bind(path: &Path) -> io::Result<UnixListener> {
    if fs::symlink_metadata(path).is_ok_and(|found| found.file_type().is_socket()) {
        fs::remove_file(path)?;
    }
    UnixListener::bind(path)
}

fn answer(request: Request, page: &Page) {
    let path = request.url().split('?').next().unwrap_or_default();
    let (code, kind, body) = match (request.method(), path) {
        (Method::Get | Method::Head, "/") => (200, "text/html; charset=utf-8", PAGE.as_bytes().to_vec()),
        (Method::Get | Method::Head, "/status.json") => (200, "application/json", json(&page.facts())),
        (Method::Get | Method::Head, "/metrics") => (200, metrics::KIND, metrics::text(&page.facts()).into_bytes()),
        (Method::Get | Method::Head, "/screen.jpg") => match page.glass.view().shown {
            Some(shown) => (200, "image/jpeg", jpeg::encode(&shown.still.picture())),
            None => (503, "text/plain", b"nothing is lit yet\n".to_vec()),
        },
        (Method::Get | Method::Head, _) => (404, "text/plain", b"no such page\n".to_vec()),
        (_, _) => (405, "text/plain", b"this page can only be read\n".to_vec()),
    };
    let header = |name: &str, value: &str| Header::from_bytes(name, value).expect("our headers are plain ASCII");
    let response = Response::from_data(body)
        .with_status_code(code)
        .with_header(header("Content-Type", kind))
        .with_header(header("Cache-Control", "no-store"));
    if let Err(error) = request.respond(response) {
        debug!(error = chain(&error), "an answer was not wanted any more");
    }
}

fn json(facts: &Facts) -> Vec<u8> {
    serde_json::to_vec_pretty(facts).expect("facts are plain text and numbers")
}
