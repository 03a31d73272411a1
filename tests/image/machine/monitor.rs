//! QEMU's monitor.
//!
//! Owns the connection and its protocol, QMP.

use crate::machine::qemu::Stderr;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, ErrorKind, Write};
use std::os::unix::net::UnixStream;
use std::time::Duration;

/// How long an answer may take.
const PATIENCE: Duration = Duration::from_mins(5);

/// A connection to the monitor of one machine.
pub(crate) struct Monitor {
    to: UnixStream,
    from: BufReader<UnixStream>,
    said: Stderr,
}

impl Monitor {
    /// Opens the conversation on `stream`; `said` is the standard error of that QEMU.
    pub(crate) fn new(stream: UnixStream, said: Stderr) -> Self {
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut monitor = Self { from: BufReader::new(stream.try_clone().unwrap()), to: stream, said };
        monitor.line("its greeting");
        monitor.ask("qmp_capabilities", &json!({}));
        monitor
    }

    /// Runs `command`, which must succeed; returns its answer.
    pub(crate) fn ask(&mut self, command: &str, arguments: &Value) -> Value {
        self.try_to(command, arguments).unwrap_or_else(|error| panic!("{command} {arguments}: {error}"))
    }

    /// The same for a command that may fail. Panics if QEMU has ended.
    pub(crate) fn try_to(&mut self, command: &str, arguments: &Value) -> Result<Value, String> {
        let request = json!({ "execute": command, "arguments": arguments });
        if writeln!(self.to, "{request}").is_err() {
            self.said.ended();
        }
        loop {
            let line = self.line(command);
            if let Some(answer) = line.get("return") {
                return Ok(answer.clone());
            }
            if let Some(error) = line.get("error") {
                return Err(error.to_string());
            }
            // Where a claim fails, it is good to know that the machine has started once more.
            if line["event"] == "RESET" && line["data"]["guest"] == true {
                println!("the system has reset the machine");
            }
        }
    }

    /// The next message; `what` is waited for.
    fn line(&mut self, what: &str) -> Value {
        let mut line = String::new();
        match self.from.read_line(&mut line) {
            Ok(1..) => serde_json::from_str(&line).unwrap(),
            Err(error) if error.kind() == ErrorKind::WouldBlock => panic!("QEMU's monitor does not answer: {what}"),
            Ok(_) | Err(_) => self.said.ended(),
        }
    }
}
