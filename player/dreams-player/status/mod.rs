//! The status page: what is on the glass, for people and for machines.
//!
//! Owns the page's addresses: `/` for people, `/status.json`, `/metrics` for monitoring, `/screen.jpg`, the same in a
//! small size, `/small.jpg`, for reports, and `/glass.json`, the part of `/status.json` that costs little, for `dreams-votes`. Only looks:
//! nothing here changes what is played, and a picture is encoded only when someone asks for it. The contents are
//! `facts.rs`, how machines read it in `metrics.rs`, how people see it in `page.html`; `server.rs` keeps strangers
//! from harm's way.

mod facts;
mod hosts;
mod http;
mod jpeg;
mod metrics;
mod server;
mod standing;

use crate::control::{DisplayTarget, FULL, Overlay, PaneBuffer};
use crate::recording::{Faults, SharedView};
use crate::settings::StatusAddress;
use crate::stream::Plan;
use diagnostics::chain;
use facts::{Facts, PowerFacts, SettingsFacts, Showing};
use flock::Flock;
use hosts::Hosts;
use http::Answer;
use player::{ClockReader, now};
use rustix::process::setpriority_process;
use screen::Picture;
use serde::Serialize;
use server::Server;
use std::fs;
use std::io::{self, ErrorKind};
use std::net::TcpListener;
use std::os::fd::OwnedFd;
use std::os::unix::fs::FileTypeExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use timing::Nanos;
use tracing::{info, warn};

/// The page for people. It asks for `/status.json` and `/screen.jpg`, and for nothing from elsewhere.
const PAGE: &str = include_str!("page.html");

/// How far the page stands back behind the frames, 0 to 19.
const NICENESS: i32 = 15;

/// All that the page can tell.
pub(crate) struct Page {
    /// The one at hand when the run began.
    pub(crate) flock: Arc<Flock>,
    pub(crate) view: Arc<SharedView>,
    pub(crate) plan: Arc<Plan>,
    pub(crate) overlay: Arc<Overlay>,
    pub(crate) faults: Faults,
    pub(crate) target: Arc<DisplayTarget>,
    pub(crate) begun: Nanos,
    /// Where the flock to be played is said to be.
    pub(crate) source: PathBuf,
}

impl Page {
    fn facts(&self) -> Facts {
        let facts = Facts::gather(&self.flock, &self.view, &self.plan, &self.faults, now().since(self.begun));
        let (generation, contact) = standing::read(&self.source, ClockReader::of_machine().read().known_s());
        let age_s = |at| now().since(at) / 1_000_000_000;
        let change = self.target.change();
        let settings = change.map(|change| SettingsFacts { age_s: age_s(change.at), changed: change.keys });
        let display_power = self.target.power.newest().map(|answer| PowerFacts {
            by: answer.means.to_string(),
            asked: if answer.is_on { "on" } else { "off" },
            error: answer.error,
        });
        Facts { generation, contact, settings, display_power, ..facts }
    }

    /// The picture on the glass, with what lies over it.
    fn picture(&self, encode: fn(&Picture<'_>) -> Vec<u8>) -> Answer {
        let Some(shown) = self.view.get().shown else {
            return Answer::refusal("503 Service Unavailable", "nothing is lit yet");
        };
        let (picture, mut buffer) = (shown.pixels.picture(), PaneBuffer::default());
        Answer::of("image/jpeg", encode(&self.overlay.get().over(&picture, FULL, &mut buffer)))
    }

    fn answer(&self, path: &str) -> Answer {
        match path {
            "/" => Answer::of("text/html; charset=utf-8", PAGE.as_bytes().to_vec()),
            "/status.json" => Answer::of("application/json", json(&self.facts())),
            "/glass.json" => Answer::of("application/json", json(&Showing::of(&self.view.get()))),
            "/metrics" => Answer::of(metrics::KIND, metrics::text(&self.facts()).into_bytes()),
            "/screen.jpg" => self.picture(jpeg::encode),
            "/small.jpg" => self.picture(jpeg::encode_small),
            _ => Answer::refusal("404 Not Found", "no such page"),
        }
    }
}

/// Serves `page` at `address` for as long as the process lives. If that cannot be done the picture goes on without.
pub(crate) fn serve(address: &StatusAddress, page: Page) {
    let bound = match address {
        StatusAddress::Off => return,
        StatusAddress::Host(host) => bind_host(host),
        StatusAddress::Unix(path) => bind_path(path).map(|listener| (OwnedFd::from(listener), address.to_string())),
    };
    let hosts = if matches!(address, StatusAddress::Unix(_)) { Hosts::Any } else { Hosts::Own };
    let served = bound.and_then(|(listener, at)| {
        let server = Server::new(listener, hosts, move |path: &str| page.answer(path))?;
        let answer_all = move || {
            // Linux has a niceness per thread: where processors are short, frames come first.
            setpriority_process(None, NICENESS).ok();
            server.run(now);
        };
        thread::Builder::new().name("status".to_owned()).spawn(answer_all).map(|_| at)
    });
    match served {
        Ok(at) => info!(at, "serving the status page"),
        Err(error) => warn!(%address, error = chain(&error), "cannot serve the status page"),
    }
}

/// Binds a loopback address, and says which: with port 0 the kernel chooses one.
fn bind_host(host: &str) -> io::Result<(OwnedFd, String)> {
    let listener = TcpListener::bind(host)?;
    let at = format!("http://{}/", listener.local_addr()?);
    Ok((listener.into(), at))
}

/// Binds a unix socket, in place of the one that a killed player left, but never of one that is listened to.
fn bind_path(path: &Path) -> io::Result<UnixListener> {
    let bound = UnixListener::bind(path);
    let is_taken = bound.as_ref().is_err_and(|error| error.kind() == ErrorKind::AddrInUse);
    if is_taken
        && UnixStream::connect(path).is_err_and(|error| error.kind() == ErrorKind::ConnectionRefused)
        && is_socket(path)?
    {
        fs::remove_file(path)?;
        return UnixListener::bind(path);
    }
    bound
}

fn is_socket(path: &Path) -> io::Result<bool> {
    Ok(fs::symlink_metadata(path)?.file_type().is_socket())
}

fn json(facts: &impl Serialize) -> Vec<u8> {
    serde_json::to_vec_pretty(facts).expect("facts are plain text and numbers")
}

#[cfg(test)]
mod tests {
    use super::bind_path;
    use std::fs;
    use std::io::ErrorKind;

    #[test]
    fn only_a_socket_that_nobody_listens_to_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("socket");
        let listening = bind_path(&path).unwrap();
        assert_eq!(bind_path(&path).unwrap_err().kind(), ErrorKind::AddrInUse);
        drop(listening);
        bind_path(&path).unwrap();

        fs::remove_file(&path).unwrap();
        fs::write(&path, "a file of the user").unwrap();
        assert_eq!(bind_path(&path).unwrap_err().kind(), ErrorKind::AddrInUse);
        assert_eq!(fs::read_to_string(&path).unwrap(), "a file of the user");
    }
}
