//! The studio, running, and a client of it that can forge what it likes.
//!
//! Owns the process, its address and its session, and requests written byte by byte. Never opens a browser: that is
//! [`super::browser`].
//!
//! Start at [`Studio::of`], [`Studio::ask`] and [`Studio::forge`].

use crate::programs;
use crate::wait;
use serde_json::{Value, json};
use std::fs;
use std::io::{BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::Duration;

/// How long the studio may take to start, and to answer, in seconds.
const PATIENCE_S: u32 = 60;

/// A studio of one flock. It is killed when dropped.
pub struct Studio {
    child: Child,
    /// Kept open: whoever prints to a closed pipe ends.
    _told: BufReader<ChildStdout>,
    pub folder: PathBuf,
    pub port: u16,
    token: String,
    cookie: String,
    secret: String,
    look: String,
}

/// An answer: its status, its head in lower case, its body.
#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: Vec<u8>,
}

impl Answer {
    /// The body as JSON.
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body)
            .unwrap_or_else(|error| panic!("{} is no JSON: {error}", String::from_utf8_lossy(&self.body)))
    }

    /// The value of a header, by its name in lower case.
    pub fn header(&self, name: &str) -> Option<&str> {
        let mut lines = self.head.lines().filter_map(|line| line.split_once(": "));
        lines.find(|(named, _)| *named == name).map(|(_, value)| value)
    }
}

impl Studio {
    /// Starts the studio of the flock in `folder`.
    pub fn of(folder: &Path) -> Self {
        Self::with(folder, &[])
    }

    /// The same with options.
    pub fn with(folder: &Path, options: &[&str]) -> Self {
        let mut dreams = Command::new(programs::dreams());
        dreams.arg("studio").arg(folder).arg("--no-open").args(options);
        Self::begin(folder, dreams.stdin(Stdio::null()))
    }

    /// The same at a terminal of its own.
    pub fn at_terminal(folder: &Path, options: &[&str]) -> Self {
        let (dreams, folder_text) = (programs::dreams().display().to_string(), folder.display().to_string());
        let words = [&[dreams.as_str(), "studio", &folder_text, "--no-open"], options].concat();
        // For the shell, so that a path may have spaces.
        let quoted: Vec<String> = words.iter().map(|word| format!("'{word}'")).collect();
        let mut socat = Command::new("socat");
        socat.args(["-", "SYSTEM:eval exec $STUDIO,pty,setsid,ctty,stderr,echo=0"]).env("STUDIO", quoted.join(" "));
        Self::begin(folder, socat.stdin(Stdio::piped()))
    }

    /// Types `text` at its terminal.
    pub fn type_at_terminal(&mut self, text: &str) {
        let terminal = self.child.stdin.as_mut().expect("it has a terminal");
        terminal.write_all(text.as_bytes()).and_then(|()| terminal.flush()).unwrap();
    }

    fn begin(folder: &Path, command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut told = BufReader::new(child.stdout.take().expect("it is piped"));
        let line = wait::line("the address of the studio", PATIENCE_S, &mut told);
        let address = line.trim().rsplit(' ').next().unwrap_or_default();
        let (place, token) = address.split_once("/#").unwrap_or_else(|| panic!("no address in `{line}`"));
        let port = place.strip_prefix("http://127.0.0.1:").and_then(|port| port.parse().ok());
        let port = port.unwrap_or_else(|| panic!("no port in `{line}`"));
        let (folder, token) = (folder.to_owned(), token.to_owned());
        let (cookie, secret, look) = (String::new(), String::new(), String::new());
        let mut studio = Self { child, _told: told, folder, port, token, cookie, secret, look };
        studio.begin_session();
        studio
    }

    /// Kills it with SIGKILL and starts it again, on the same port.
    pub fn kill_and_restart(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
        let new = Self::with(&self.folder, &["--port", &self.port.to_string()]);
        *self = new;
    }

    /// The address that it has printed, which opens the page.
    pub fn address(&self) -> String {
        format!("{}/#{}", self.origin(), self.token)
    }

    /// The same without the path and the token.
    pub fn origin(&self) -> String {
        format!("http://127.0.0.1:{}", self.port)
    }

    fn begin_session(&mut self) {
        let body = json!({ "token": self.token }).to_string();
        let request = format!(
            "POST /session HTTP/1.1\r\nHost: {{host}}\r\nOrigin: {{origin}}\r\nContent-Type: application/json\r\n\
             Content-Length: {}\r\n\r\n{body}",
            body.len()
        );
        let answer = self.forge(&request);
        assert_eq!(answer.status, 200, "{answer:?}");
        let cookie = answer.header("set-cookie").expect("a session has a cookie");
        cookie.split(';').next().unwrap_or_default().clone_into(&mut self.cookie);
        let told = answer.json();
        told["secret"].as_str().expect("a session has a secret").clone_into(&mut self.secret);
        told["look"].as_str().expect("a session has what pictures are asked for with").clone_into(&mut self.look);
    }

    /// The answer to a request as the page sends it.
    pub fn ask(&self, method: &str, path: &str, body: Option<&Value>) -> Answer {
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: {{host}}\r\nCookie: {{cookie}}\r\nX-Studio-Secret: {{secret}}\r\n"
        );
        if method == "GET" {
            return self.forge(&(head + "\r\n"));
        }
        let text = body.map(Value::to_string).unwrap_or_default();
        let kind = "Origin: {origin}\r\nContent-Type: application/json\r\n";
        self.forge(&format!("{head}{kind}Content-Length: {}\r\n\r\n{text}", text.len()))
    }

    /// What is at `path`, as JSON.
    pub fn get(&self, path: &str) -> Value {
        let answer = self.ask("GET", path, None);
        assert_eq!(answer.status, 200, "GET {path}: {}", String::from_utf8_lossy(&answer.body));
        answer.json()
    }

    /// The answer to `body` at `path`, which must succeed; null if it has none.
    pub fn post(&self, path: &str, body: &Value) -> Value {
        let answer = self.ask("POST", path, Some(body));
        let is_fine = (200..300).contains(&answer.status);
        assert!(is_fine, "POST {path} {body}: {} {}", answer.status, String::from_utf8_lossy(&answer.body));
        if answer.body.is_empty() { Value::Null } else { answer.json() }
    }

    /// The answer to `request`, byte by byte but for its holes: `{host}`, `{port}`, `{origin}`, `{cookie}`, `{secret}`,
    /// `{look}`, `{token}`. A `Connection: close` is added.
    pub fn forge(&self, request: &str) -> Answer {
        self.forge_at("127.0.0.1", request)
    }

    /// The same to another address of this machine.
    pub fn forge_at(&self, address: &str, request: &str) -> Answer {
        let mut request = request.replacen("\r\n", "\r\nConnection: close\r\n", 1);
        let host = format!("127.0.0.1:{}", self.port);
        let holes = [
            ("{host}", host),
            ("{port}", self.port.to_string()),
            ("{origin}", self.origin()),
            ("{cookie}", self.cookie.clone()),
            ("{secret}", self.secret.clone()),
            ("{look}", self.look.clone()),
            ("{token}", self.token.clone()),
        ];
        for (hole, value) in holes {
            request = request.replace(hole, &value);
        }
        let mut stream = TcpStream::connect((address, self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(PATIENCE_S.into()))).unwrap();
        // Who refuses a request by its head closes the connection before all of the body is sent.
        stream.write_all(request.as_bytes()).ok();
        let mut all = Vec::new();
        // A connection may end by a reset: that is how a body that is not wanted is refused. What came before counts.
        stream.read_to_end(&mut all).ok();
        let end = all.windows(4).position(|four| four == b"\r\n\r\n").unwrap_or_else(|| panic!("no head: {request}"));
        let head = String::from_utf8_lossy(&all[..end]).to_lowercase();
        let status =
            head.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("a head begins with a status");
        let body = all.split_off(end + 4);
        let is_in_chunks = head.contains("transfer-encoding: chunked");
        Answer { status, head, body: if is_in_chunks { joined(&body) } else { body } }
    }

    /// The manifest's bytes.
    pub fn manifest(&self) -> String {
        fs::read_to_string(self.folder.join("flock.toml")).unwrap()
    }

    /// Makes `edits` on the manifest of `revision`, as one gesture of its own; returns the answer.
    pub fn edit(&self, revision: &Value, edits: &Value) -> Value {
        self.post("/api/edits", &json!({ "revision": revision, "gesture": null, "edits": edits, "force": true }))
    }
}

/// The body that `chunks` are of.
fn joined(mut chunks: &[u8]) -> Vec<u8> {
    let mut body = Vec::new();
    while let Some(end) = chunks.windows(2).position(|two| two == b"\r\n") {
        let length = std::str::from_utf8(&chunks[..end]).ok().and_then(|hex| usize::from_str_radix(hex, 16).ok());
        let from = end + 2;
        let Some(length) = length.filter(|length| *length > 0 && from + length <= chunks.len()) else { break };
        body.extend(&chunks[from..from + length]);
        chunks = &chunks[(from + length + 2).min(chunks.len())..];
    }
    body
}

impl Drop for Studio {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}
