//! A web server of static files, on this machine, with whatever manners are asked for.
//!
//! Owns the count of what was asked and sent. Never looks into a bundle.
//!
//! Start at [`Web::serve`].

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
pub enum Manners {
    /// As it should.
    Good,
    /// It sends so many bytes of each body, and dies.
    Dies(usize),
    /// It promises more than it has.
    PromisesMore,
    /// It promises less than it sends.
    PromisesLess,
    /// It sends rubbish behind what was asked for, for ever.
    Endless,
    /// It sends ten bytes of an object a second.
    Drips,
    /// It knows no parts: always everything.
    Whole,
    /// It sends the part behind the one that was asked for, and says so.
    WrongPart,
    /// It sends the wrong part, and says that it is the right one.
    LyingPart,
    /// It is no server of ours: the portal of a hotel.
    Portal,
    /// It sends everyone elsewhere.
    Redirects(String),
    /// It is out of order.
    Fails,
    /// It lets nobody in.
    Refuses,
}

/// From one byte to the next where it drips.
const DRIP: Duration = Duration::from_millis(100);

/// A server at work. It ends when dropped.
pub struct Web {
    address: SocketAddr,
    inside: Arc<Inside>,
    thread: Option<JoinHandle<()>>,
}

struct Inside {
    folder: PathBuf,
    manners: Mutex<Manners>,
    asked: Mutex<Vec<String>>,
    /// What was sent here.
    posted: Mutex<Vec<String>>,
    sent: AtomicU64,
    is_over: AtomicBool,
}

impl Web {
    /// Serves what lies in `folder`.
    pub fn serve(folder: &Path, manners: Manners) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let inside = Arc::new(Inside {
            folder: folder.to_owned(),
            manners: Mutex::new(manners),
            asked: Mutex::default(),
            posted: Mutex::default(),
            sent: AtomicU64::new(0),
            is_over: AtomicBool::new(false),
        });
        let served = Arc::clone(&inside);
        let thread = thread::spawn(move || {
            for visitor in listener.incoming() {
                if served.is_over.load(Ordering::Relaxed) {
                    return;
                }
                let served = Arc::clone(&served);
                // Visitors that leave in the middle are what this is about.
                thread::spawn(move || served.answer(&visitor.unwrap()).ok());
            }
        });
        Self { address, inside, thread: Some(thread) }
    }

    /// Its address.
    pub fn url(&self) -> String {
        format!("http://{}", self.address)
    }

    /// Behaves so from now on.
    pub fn behave(&self, manners: Manners) {
        *self.inside.manners.lock().unwrap() = manners;
    }

    /// What was sent here by POST since the last time.
    pub fn received(&self) -> Vec<String> {
        std::mem::take(&mut *self.inside.posted.lock().unwrap())
    }

    /// What was asked for since the last time, and how many bytes of bodies were sent.
    pub fn heard(&self) -> (Vec<String>, u64) {
        (std::mem::take(&mut *self.inside.asked.lock().unwrap()), self.inside.sent.swap(0, Ordering::Relaxed))
    }
}

impl Drop for Web {
    fn drop(&mut self) {
        self.inside.is_over.store(true, Ordering::Relaxed);
        // The last visitor, so that it looks up.
        drop(TcpStream::connect(self.address));
        let thread = self.thread.take().expect("it is joined once");
        thread.join().unwrap();
    }
}

/// What is sent.
struct Reply<'b> {
    status: &'static str,
    /// Further headers, each with its end of line.
    headers: String,
    /// The length that is promised; `None` for nothing said.
    promised: Option<usize>,
    body: &'b [u8],
    is_endless: bool,
    is_dripping: bool,
}

impl Inside {
    fn answer(&self, visitor: &TcpStream) -> io::Result<()> {
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
            reader.take(length).read_to_string(&mut body)?;
            self.posted.lock().unwrap().push(body);
            let received = Reply {
                status: "204 No Content",
                headers: String::new(),
                promised: None,
                body: b"",
                is_endless: false,
                is_dripping: false,
            };
            return self.send(visitor, &received);
        }
        self.asked.lock().unwrap().push(path.clone());
        let manners = self.manners.lock().unwrap().clone();
        let file = fs::read(self.folder.join(&path));
        self.send(visitor, &reply(&manners, &path, file.as_deref().ok(), from))
    }

    fn send(&self, mut visitor: &TcpStream, reply: &Reply<'_>) -> io::Result<()> {
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

/// What a server of these manners answers who asks for `path`, which holds `file`, from byte `from` on.
fn reply<'f>(manners: &Manners, path: &str, file: Option<&'f [u8]>, from: usize) -> Reply<'f> {
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
        let is_part = from > 0 && *manners != Manners::Whole;
        let (status, range) = if is_part { ("206 Partial Content", &*range) } else { ("200 OK", "") };
        other(status, range, if is_part { &bytes[begins.min(bytes.len())..] } else { bytes })
    };
    match manners {
        Manners::Portal => return other("200 OK", "Content-Type: text/html\r\n", b"<html>Welcome!</html>"),
        Manners::Redirects(to) => return other("302 Found", &format!("Location: {to}/{path}\r\n"), b""),
        Manners::Fails => return other("500 Internal Server Error", "", b"sorry"),
        Manners::Refuses => return other("403 Forbidden", "", b"no"),
        Manners::Good
        | Manners::Dies(_)
        | Manners::PromisesMore
        | Manners::PromisesLess
        | Manners::Endless
        | Manners::Drips
        | Manners::Whole
        | Manners::WrongPart
        | Manners::LyingPart => {}
    }
    if file.is_none() {
        return other("404 Not Found", "", b"no");
    }
    let good = part(from, from);
    let length = good.body.len();
    match *manners {
        Manners::Dies(after) => Reply { body: &good.body[..after.min(length)], ..good },
        Manners::PromisesMore => Reply { promised: Some(length + 1_000), ..good },
        Manners::PromisesLess => Reply { promised: Some(length / 2), ..good },
        Manners::Drips => Reply { is_dripping: path.starts_with("objects/"), ..good },
        Manners::Endless => Reply { promised: None, is_endless: true, ..good },
        Manners::WrongPart => part(from + 1, from + 1),
        Manners::LyingPart => part(from.saturating_sub(1), from),
        Manners::Good
        | Manners::Whole
        | Manners::Portal
        | Manners::Redirects(_)
        | Manners::Fails
        | Manners::Refuses => good,
    }
}
