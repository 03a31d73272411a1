//! The serial port of a machine: its shell in the profile `bench`.
//!
//! Owns the lines that come, and waiting for them. Never sends what it was not given.

use crate::machine::clock::now;
use crate::machine::qemu::Stderr;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

/// The longest that a command may take.
const PATIENCE: Duration = Duration::from_mins(20);
/// The longest that it may say nothing.
const SILENCE: Duration = Duration::from_mins(5);

/// The port.
pub(crate) struct Serial {
    to: UnixStream,
    lines: Receiver<String>,
    /// What was said lately, to be told when something goes wrong.
    said: Vec<String>,
    qemu: Stderr,
}

impl Serial {
    /// The port behind `stream`, of a QEMU that says `qemu` itself.
    pub(crate) fn new(stream: UnixStream, qemu: Stderr) -> Self {
        let from = BufReader::new(stream.try_clone().unwrap());
        let (sender, lines) = channel();
        thread::spawn(move || {
            for line in from.split(b'\n').map_while(Result::ok) {
                let line = String::from_utf8_lossy(&line).trim_end().to_owned();
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        Self { to: stream, lines, said: Vec::new(), qemu }
    }

    /// The next line, if one comes within `wait`.
    pub(crate) fn line(&mut self, wait: Duration) -> Option<String> {
        match self.lines.recv_timeout(wait) {
            Ok(line) => {
                self.said.push(line.clone());
                Some(line)
            }
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => self.qemu.ended(),
        }
    }

    /// Lets this much time pass, or as much as goes by until the next line.
    pub(crate) fn pass(&mut self, time: Duration) {
        self.line(time);
    }

    /// What was said lately.
    pub(crate) fn lately(&self) -> String {
        let from = self.said.len().saturating_sub(20);
        format!("it said lately: {}", self.said[from..].join("\n"))
    }

    /// The exit status that the shell has told last.
    pub(crate) fn status(&self) -> i32 {
        let told = self.said.iter().rev().find_map(|line| line.strip_prefix("DONE "));
        told.and_then(|status| status.parse().ok()).expect("a status was told")
    }

    /// Has the shell run `command`, without waiting.
    pub(crate) fn send(&mut self, command: &str) {
        if writeln!(self.to, "{command}").is_err() {
            self.qemu.ended();
        }
    }

    /// Has the shell run `command`; what it says, and its exit status.
    pub(crate) fn run(&mut self, command: &str) -> (String, i32) {
        self.send(command);
        let (end, mut lines) = (now() + PATIENCE, Vec::new());
        while let Some(line) = self.line(SILENCE.min(end.saturating_sub(now()))) {
            if line.starts_with("DONE ") {
                return (lines.join("\n"), self.status());
            }
            lines.push(line);
        }
        panic!("`{command}` does not end; {}", self.lately());
    }
}
