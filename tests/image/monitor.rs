//! QEMU's monitor: what is done to a machine from outside.
//!
//! Owns the connection and its words (QMP). Never decides what to do.

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;

/// A connection to the monitor of one machine.
pub(crate) struct Monitor {
    to: UnixStream,
    from: BufReader<UnixStream>,
}

impl Monitor {
    /// Takes up the conversation on `stream`.
    pub(crate) fn new(stream: UnixStream) -> Self {
        let mut monitor = Self { from: BufReader::new(stream.try_clone().unwrap()), to: stream };
        monitor.line();
        monitor.ask("qmp_capabilities", &json!({}));
        monitor
    }

    /// Has the machine do `command`; what it answers.
    pub(crate) fn ask(&mut self, command: &str, arguments: &Value) -> Value {
        self.try_to(command, arguments).unwrap_or_else(|error| panic!("{command} {arguments}: {error}"))
    }

    /// The same, for what may be refused.
    pub(crate) fn try_to(&mut self, command: &str, arguments: &Value) -> Result<Value, String> {
        let request = json!({ "execute": command, "arguments": arguments });
        writeln!(self.to, "{request}").map_err(|error| error.to_string())?;
        loop {
            let line = self.line();
            if let Some(answer) = line.get("return") {
                return Ok(answer.clone());
            }
            if let Some(error) = line.get("error") {
                return Err(error.to_string());
            }
        }
    }

    fn line(&mut self) -> Value {
        let mut line = String::new();
        self.from.read_line(&mut line).unwrap();
        assert!(!line.is_empty(), "the machine has ended");
        serde_json::from_str(&line).unwrap()
    }
}
