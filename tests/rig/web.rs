//! A web server of static files, on this machine, which misbehaves as asked.
//!
//! Owns the counts of requests and of bytes sent. Never looks into a bundle.
//!
//! Start at [`WebServer::serve`].

use rustls::crypto::ring;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::{ServerConfig, ServerConnection, StreamOwned};
use std::fs;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// How a server behaves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Behaviour {
    /// As it should.
    Good,
    /// It sends so many bytes of each body, and closes the connection.
    Dies(usize),
    /// It announces more bytes than it sends.
    PromisesMore,
    /// It announces fewer bytes than it sends.
    PromisesLess,
    /// It sends random bytes after the body, without end.
    Endless,
    /// It sends ten bytes of an object per second.
    Drips,
    /// It ignores ranges, and sends whole files.
    Whole,
    /// It sends a range that begins a byte too late, and says so.
    WrongPart,
    /// It sends a range that begins a byte too early, and claims that it begins where it should.
    LyingPart,
    /// It answers with another page, as the portal of a hotel does.
    Portal,
    /// It answers everything with these header lines and this body.
    Says(&'static str, &'static [u8]),
    /// It sends a range that begins a byte too late, also if the whole is asked for.
    Astray,
    /// It answers that access is forbidden to what is not there, as object stores do.
    Bucket,
    /// It redirects to another address.
    Redirects(String),
    /// It answers with a server error.
    Fails,
    /// It answers that access is forbidden.
    Refuses,
}

/// The time between two bytes when it drips.
const DRIP: Duration = Duration::from_millis(100);

/// A running server. It ends when dropped.
pub struct WebServer {
    address: SocketAddr,
    scheme: &'static str,
    state: Arc<ServerState>,
    thread: Option<JoinHandle<()>>,
}

struct ServerState {
    folder: PathBuf,
    behaviour: Mutex<Behaviour>,
    asked: Mutex<Vec<String>>,
    /// What was sent here by POST.
    posted: Mutex<Vec<String>>,
    sent: AtomicU64,
    is_over: AtomicBool,
}

impl WebServer {
    /// Serves the files in `folder`.
    pub fn serve(folder: &Path, behaviour: Behaviour) -> Self {
        Self::start(folder, behaviour, None)
    }

    /// Serves the files in `folder` by TLS, with this certificate of `tests/fixtures/certificates`.
    pub fn serve_by_tls(folder: &Path, certificate: &str) -> Self {
        Self::start(folder, Behaviour::Good, Some(Arc::new(tls(certificate))))
    }

    fn start(folder: &Path, behaviour: Behaviour, tls: Option<Arc<ServerConfig>>) -> Self {
        let scheme = if tls.is_some() { "https" } else { "http" };
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let state = Arc::new(ServerState {
            folder: folder.to_owned(),
            behaviour: Mutex::new(behaviour),
            asked: Mutex::default(),
            posted: Mutex::default(),
            sent: AtomicU64::new(0),
            is_over: AtomicBool::new(false),
        });
        let served = Arc::clone(&state);
        let thread = thread::spawn(move || {
            for visitor in listener.incoming() {
                if served.is_over.load(Ordering::Relaxed) {
                    return;
                }
                let (served, tls, visitor) = (Arc::clone(&served), tls.clone(), visitor.unwrap());
                // Clients may close the connection early.
                thread::spawn(move || match tls {
                    Some(tls) => served.answer(StreamOwned::new(ServerConnection::new(tls).unwrap(), visitor)).ok(),
                    None => served.answer(visitor).ok(),
                });
            }
        });
        Self { address, scheme, state, thread: Some(thread) }
    }

    /// Its address.
    pub fn url(&self) -> String {
        format!("{}://{}", self.scheme, self.address)
    }

    /// Behaves so from now on.
    pub fn behave(&self, behaviour: Behaviour) {
        *self.state.behaviour.lock().unwrap() = behaviour;
    }

    /// What was sent here by POST since the last call.
    pub fn received(&self) -> Vec<String> {
        std::mem::take(&mut *self.state.posted.lock().unwrap())
    }

    /// The paths that were requested since the last call, and the bytes of bodies that were sent.
    pub fn heard(&self) -> (Vec<String>, u64) {
        (std::mem::take(&mut *self.state.asked.lock().unwrap()), self.state.sent.swap(0, Ordering::Relaxed))
    }
}

impl Drop for WebServer {
    fn drop(&mut self) {
        self.state.is_over.store(true, Ordering::Relaxed);
        // A last connection ends its `accept`.
        drop(TcpStream::connect(self.address));
        let thread = self.thread.take().expect("it is joined once");
        thread.join().unwrap();
    }
}

/// An answer.
struct Reply<'b> {
    status: &'static str,
    /// Further headers, each with its end of line.
    headers: String,
    /// The announced length, if any.
    promised: Option<usize>,
    body: &'b [u8],
    is_endless: bool,
    is_dripping: bool,
}

impl ServerState {
    fn answer(&self, visitor: impl Read + Write) -> io::Result<()> {
        let mut reader = BufReader::new(visitor);
        let (mut line, mut from, mut length) = (String::new(), 0, 0);
        reader.read_line(&mut line)?;
        let path = line.split(' ').nth(1).unwrap_or_default().trim_start_matches('/').to_owned();
        loop {
            let mut header = String::new();
            reader.read_line(&mut header)?;
            let header = header.trim().to_lowercase();
            if header.is_empty() {
                break;
            }
            if let Some(range) = header.strip_prefix("range: bytes=") {
                from = range.trim_end_matches('-').parse().unwrap();
            }
            if let Some(posted) = header.strip_prefix("content-length: ") {
                length = posted.parse().unwrap();
            }
        }
        if line.starts_with("POST ") {
            let mut body = String::new();
            reader.by_ref().take(length).read_to_string(&mut body)?;
            self.posted.lock().unwrap().push(body);
            let received = Reply {
                status: "204 No Content",
                headers: String::new(),
                promised: None,
                body: b"",
                is_endless: false,
                is_dripping: false,
            };
            return self.send(reader.get_mut(), &received);
        }
        self.asked.lock().unwrap().push(path.clone());
        let behaviour = self.behaviour.lock().unwrap().clone();
        let file = fs::read(self.folder.join(&path));
        self.send(reader.get_mut(), &reply(&behaviour, &path, file.as_deref().ok(), from))
    }

    fn send(&self, visitor: &mut impl Write, reply: &Reply<'_>) -> io::Result<()> {
        let promised = reply.promised.map(|length| format!("Content-Length: {length}\r\n")).unwrap_or_default();
        write!(visitor, "HTTP/1.1 {}\r\n{promised}{}Connection: close\r\n\r\n", reply.status, reply.headers)?;
        let mut body = reply.body;
        for byte in body.chunks(1).filter(|_| reply.is_dripping) {
            visitor.write_all(byte)?;
            thread::park_timeout(DRIP);
        }
        body = if reply.is_dripping { &[] } else { body };
        loop {
            visitor.write_all(body)?;
            self.sent.fetch_add(body.len() as u64, Ordering::Relaxed);
            if !reply.is_endless {
                return Ok(());
            }
            body = &[7; 4_096];
        }
    }
}

/// What a server with this certificate of `tests/fixtures/certificates` needs.
fn tls(certificate: &str) -> ServerConfig {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/certificates");
    let key = PrivateKeyDer::from_pem_file(fixtures.join("server.key")).unwrap();
    let certificate = CertificateDer::from_pem_file(fixtures.join(certificate)).unwrap();
    let config = ServerConfig::builder_with_provider(Arc::new(ring::default_provider()));
    let config = config.with_safe_default_protocol_versions().unwrap().with_no_client_auth();
    config.with_single_cert(vec![certificate], key).unwrap()
}

/// The answer of a server with this behaviour to a request for `path`, which holds `file`, from byte `from` on.
fn reply<'f>(behaviour: &Behaviour, path: &str, file: Option<&'f [u8]>, from: usize) -> Reply<'f> {
    let other = |status, headers: &str, body: &'f [u8]| Reply {
        status,
        headers: headers.to_owned(),
        promised: Some(body.len()),
        body,
        is_endless: false,
        is_dripping: false,
    };
    let part = |begins: usize, told: usize| {
        let bytes = file.unwrap_or_default();
        let range = format!("Content-Range: bytes {told}-{}/{}\r\n", bytes.len().saturating_sub(1), bytes.len());
        let is_part = (from > 0 || *behaviour == Behaviour::Astray) && *behaviour != Behaviour::Whole;
        let (status, range) = if is_part { ("206 Partial Content", &*range) } else { ("200 OK", "") };
        other(status, range, if is_part { &bytes[begins.min(bytes.len())..] } else { bytes })
    };
    match behaviour {
        Behaviour::Says(headers, body) => return other("200 OK", headers, body),
        Behaviour::Bucket if file.is_none() => return other("403 Forbidden", "", b"<Error>AccessDenied</Error>"),
        Behaviour::Portal => return other("200 OK", "Content-Type: text/html\r\n", b"<html>Welcome!</html>"),
        Behaviour::Redirects(to) => return other("302 Found", &format!("Location: {to}/{path}\r\n"), b""),
        Behaviour::Fails => return other("500 Internal Server Error", "", b"sorry"),
        Behaviour::Refuses => return other("403 Forbidden", "", b"no"),
        Behaviour::Good
        | Behaviour::Dies(_)
        | Behaviour::PromisesMore
        | Behaviour::PromisesLess
        | Behaviour::Endless
        | Behaviour::Drips
        | Behaviour::Whole
        | Behaviour::WrongPart
        | Behaviour::Astray
        | Behaviour::Bucket
        | Behaviour::LyingPart => {}
    }
    if file.is_none() {
        return other("404 Not Found", "", b"no");
    }
    let good = part(from, from);
    let length = good.body.len();
    match *behaviour {
        Behaviour::Dies(after) => Reply { body: &good.body[..after.min(length)], ..good },
        Behaviour::PromisesMore => Reply { promised: Some(length + 1_000), ..good },
        Behaviour::PromisesLess => Reply { promised: Some(length / 2), ..good },
        Behaviour::Drips => Reply { is_dripping: path.starts_with("objects/"), ..good },
        Behaviour::Endless => Reply { promised: None, is_endless: true, ..good },
        Behaviour::Astray if !path.starts_with("objects/") => other("200 OK", "", file.unwrap_or_default()),
        Behaviour::WrongPart | Behaviour::Astray => part(from + 1, from + 1),
        Behaviour::LyingPart => part(from.saturating_sub(1), from),
        Behaviour::Good
        | Behaviour::Whole
        | Behaviour::Bucket
        | Behaviour::Portal
        | Behaviour::Says(..)
        | Behaviour::Redirects(_)
        | Behaviour::Fails
        | Behaviour::Refuses => good,
    }
}
