//! `dreams fleet`, running, and what units and strangers send to it.
//!
//! Owns the process and its address, requests written byte by byte, and a webhook that answers as it is ordered to. Never
//! opens a browser.
//!
//! Start at [`Fleet::of`] and [`Hook::answering`].

use crate::programs;
use crate::wait;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

/// How long it may take to start, and alarms to come, in seconds.
const PATIENCE_S: u32 = 30;
/// How long an answer may take: less than the server leaves to those who are slow.
const ANSWER: Duration = Duration::from_secs(10);

/// A server for the reports in a folder. It is killed when dropped.
pub struct Fleet {
    child: Child,
    /// Kept open: whoever prints to a closed pipe ends.
    _said: BufReader<ChildStdout>,
    /// `127.0.0.1:PORT`.
    pub place: String,
}

/// An answer: its status, its head in lower case, its body.
#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: String,
}

impl Fleet {
    /// Starts it for `folder`, with options.
    pub fn of(folder: &Path, options: &[&str]) -> Self {
        let mut dreams = Command::new(programs::dreams());
        dreams.arg("fleet").arg(folder).args(["--listen", "0"]).args(options);
        let mut child = dreams.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut said = BufReader::new(child.stdout.take().expect("it is piped"));
        let line = wait::line("the address of the fleet's page", PATIENCE_S, &mut said);
        let place = line.trim().strip_prefix("http://").and_then(|rest| rest.strip_suffix('/'));
        let place = place.unwrap_or_else(|| panic!("no address in `{line}`")).to_owned();
        Self { child, _said: said, place }
    }

    /// The number of its process.
    pub fn process(&self) -> u32 {
        self.child.id()
    }

    /// The answer to a request with these headers, besides `Host` and `Content-Length`.
    pub fn send(&self, line: &str, headers: &[(&str, &str)], body: &[u8]) -> Answer {
        let host =
            if headers.iter().any(|(name, _)| *name == "Host") { "" } else { &format!("Host: {}\r\n", self.place) };
        let headers: Vec<_> = headers.iter().map(|(name, value)| format!("{name}: {value}\r\n")).collect();
        let headers = headers.concat();
        let head = format!("{line} HTTP/1.1\r\n{host}{headers}Content-Length: {}\r\n\r\n", body.len());
        let mut stream = TcpStream::connect(&self.place).unwrap();
        stream.set_read_timeout(Some(ANSWER)).unwrap();
        // Of what is refused not everything may be read.
        let _ = stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(body));
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let answer = String::from_utf8_lossy(&answer).into_owned();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap_or_else(|| panic!("no answer to {line}: {answer}"));
        let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap();
        Answer { status, head: head.to_lowercase(), body: body.to_owned() }
    }

    /// The status of the answer to a report, and what it says.
    pub fn report(&self, report: &str) -> (u16, String) {
        let answer = self.send("POST /units", &[("Content-Type", "application/json")], report.as_bytes());
        (answer.status, answer.body)
    }

    /// Interrupts it; it ends within `seconds`, as it was ordered to.
    pub fn interrupt(mut self, seconds: u32) {
        kill_process(Pid::from_child(&self.child), Signal::INT).unwrap();
        let status = wait::ended("the fleet's server, interrupted", seconds, &mut self.child);
        assert_eq!(status.code(), Some(0));
    }

    /// What is at `path`.
    pub fn get(&self, path: &str) -> Answer {
        self.send(&format!("GET {path}"), &[], b"")
    }

    /// All units, by `/fleet.json`.
    pub fn units(&self) -> Value {
        serde_json::from_str(&self.get("/fleet.json").body).unwrap()
    }
}

impl Drop for Fleet {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A webhook.
pub struct Hook {
    place: String,
    received: Arc<Mutex<Vec<Value>>>,
}

impl Hook {
    /// A webhook that answers the first requests with these statuses, and all others with 200.
    pub fn answering(statuses: &'static [u16]) -> Self {
        Self::start(statuses.iter().copied().chain(std::iter::repeat(200)), Duration::ZERO)
    }

    /// A webhook that accepts nothing, and lets every request wait so long for that.
    pub fn refusing_after(pause: Duration) -> Self {
        Self::start(std::iter::repeat(503), pause)
    }

    fn start(statuses: impl Iterator<Item = u16> + Send + 'static, pause: Duration) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let place = listener.local_addr().unwrap().to_string();
        let received = Arc::new(Mutex::new(Vec::new()));
        let taken = Arc::clone(&received);
        thread::spawn(move || {
            for (visitor, status) in listener.incoming().zip(statuses) {
                let mut reader = BufReader::new(visitor.unwrap());
                let mut length = 0;
                loop {
                    let mut line = String::new();
                    reader.read_line(&mut line).unwrap();
                    if let Some(posted) = line.to_lowercase().strip_prefix("content-length: ") {
                        length = posted.trim().parse().unwrap();
                    }
                    if line.trim().is_empty() {
                        break;
                    }
                }
                let mut body = vec![0; length];
                reader.read_exact(&mut body).unwrap();
                taken.lock().unwrap().push(serde_json::from_slice(&body).unwrap());
                thread::park_timeout(pause);
                // Who was interrupted may be gone.
                let answer = format!("HTTP/1.1 {status} So\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
                let _ = reader.get_mut().write_all(answer.as_bytes());
            }
        });
        Self { place, received }
    }

    /// Its address.
    pub fn url(&self) -> String {
        format!("http://{}/hook", self.place)
    }

    /// The first alarms so far, with at least `count` of them.
    pub fn await_alarms(&self, count: usize) -> Vec<Value> {
        wait::until("alarms at the webhook", PATIENCE_S, || self.received.lock().unwrap().len() >= count);
        self.received()
    }

    /// All alarms so far.
    pub fn received(&self) -> Vec<Value> {
        self.received.lock().unwrap().clone()
    }
}
