//! Chromium, told what to do by its debugging pipe.
//!
//! Owns the process and the messages: JSON that ends with a zero byte, on the descriptors 3 and 4 of Chromium, which the
//! shell makes of its standard input and output. Never knows what a page shows: that is [`super::page`].
//!
//! Start at [`Browser::start`] and [`Browser::call`].

use crate::wait;
use serde_json::{Value, json};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::rc::Rc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;
use tempfile::TempDir;

/// The longest time for an answer of Chromium, in seconds.
pub const PATIENCE_S: u32 = 90;

/// What Chromium is started with: no sandbox, since claims run as root; no services that ask for anything elsewhere.
const OPTIONS: [&str; 12] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-extensions",
    "--disable-sync",
    "--autoplay-policy=no-user-gesture-required",
    "--hide-scrollbars",
    "--force-color-profile=srgb",
    "--remote-debugging-pipe",
];

/// A running Chromium, shared by its pages. It ends when the last of them is dropped.
#[derive(Clone)]
pub struct Browser {
    connection: Rc<RefCell<Connection>>,
}

/// Something that happened in a page.
pub struct Event {
    session: String,
    pub method: String,
    pub params: Value,
}

struct Connection {
    child: Child,
    to: ChildStdin,
    from: Receiver<Value>,
    events: VecDeque<Event>,
    last: u64,
    profile: TempDir,
}

impl Browser {
    /// Starts Chromium, where every name leads to this machine.
    pub fn start() -> Self {
        let profile = tempfile::tempdir().unwrap();
        let mut shell = Command::new("sh");
        shell.args(["-c", "exec chromium \"$@\" 3<&0 4>&1 </dev/null >&2", "chromium"]).args(OPTIONS);
        shell.arg(format!("--user-data-dir={}", profile.path().display()));
        shell.args(["--host-resolver-rules=MAP * 127.0.0.1", "about:blank"]);
        let log = File::create(profile.path().join("log")).unwrap();
        let mut child = shell.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(log).spawn().unwrap();
        let to = child.stdin.take().expect("it is piped");
        let mut told = BufReader::new(child.stdout.take().expect("it is piped"));
        let (sender, from) = channel();
        thread::spawn(move || {
            let mut message = Vec::new();
            while told.read_until(0, &mut message).is_ok_and(|bytes| bytes > 0) {
                message.pop();
                let value = serde_json::from_slice(&message).expect("Chromium speaks JSON");
                if sender.send(value).is_err() {
                    return;
                }
                message.clear();
            }
        });
        let connection = Connection { child, to, from, events: VecDeque::new(), last: 0, profile };
        let browser = Self { connection: Rc::new(RefCell::new(connection)) };
        browser.call("", "Browser.getVersion", &json!({}));
        browser
    }

    /// What `method` answers in `session`, which is empty for the browser itself.
    pub fn call(&self, session: &str, method: &str, params: &Value) -> Value {
        self.attempt(session, method, params).unwrap_or_else(|error| panic!("{method} {params}: {error}"))
    }

    /// The same; an error is Chromium's, in its words.
    ///
    /// # Errors
    /// What the browser complains of.
    pub fn attempt(&self, session: &str, method: &str, params: &Value) -> Result<Value, String> {
        let mut connection = self.connection.borrow_mut();
        let id = connection.send(session, method, params);
        let mut answer = None;
        wait::until(&format!("Chromium's answer to {method} {params}"), PATIENCE_S, || {
            answer = connection.receive(id);
            answer.is_some()
        });
        let mut answer = answer.expect("it was waited for");
        match answer.get("error") {
            Some(error) => Err(error["message"].as_str().unwrap_or_default().to_owned()),
            None => Ok(answer["result"].take()),
        }
    }

    /// What has happened in `session` since the last call, and was heard of.
    pub fn events(&self, session: &str) -> Vec<Event> {
        let mut connection = self.connection.borrow_mut();
        connection.receive(0);
        let (of_it, others) = connection.events.drain(..).partition(|event| event.session == session);
        connection.events = others;
        Vec::from(of_it)
    }
}

impl Connection {
    /// Sends a message; returns its number.
    fn send(&mut self, session: &str, method: &str, params: &Value) -> u64 {
        self.last += 1;
        let mut message = json!({ "id": self.last, "method": method, "params": params });
        if !session.is_empty() {
            message["sessionId"] = session.into();
        }
        let sent = self.to.write_all(format!("{message}\0").as_bytes()).and_then(|()| self.to.flush());
        sent.unwrap_or_else(|error| panic!("Chromium does not listen: {error}; it said {}", self.log()));
        self.last
    }

    /// Takes what has come; returns the answer to message `id` if that is among it.
    fn receive(&mut self, id: u64) -> Option<Value> {
        loop {
            let message = match self.from.try_recv() {
                Ok(message) => message,
                Err(TryRecvError::Empty) => return None,
                Err(TryRecvError::Disconnected) => panic!("Chromium has ended; it said {}", self.log()),
            };
            if message["id"] == id {
                return Some(message);
            }
            if let Some(method) = message["method"].as_str() {
                let session = message["sessionId"].as_str().unwrap_or_default().to_owned();
                self.events.push_back(Event { session, method: method.to_owned(), params: message["params"].clone() });
            }
        }
    }

    fn log(&self) -> String {
        fs::read_to_string(self.profile.path().join("log")).unwrap_or_default()
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.last += 1;
        let bye = json!({ "id": self.last, "method": "Browser.close" });
        // It may have ended already.
        self.to.write_all(format!("{bye}\0").as_bytes()).ok();
        if !wait::ends_within(&self.child, 20) {
            self.child.kill().ok();
        }
        self.child.wait().ok();
    }
}
