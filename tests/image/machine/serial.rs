//! The serial port of a machine, with its shell in the profile `bench`.
//!
//! Owns the lines that it prints, and the wait for them.

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
    /// The lines so far, printed when a claim fails.
    said: Vec<String>,
    qemu: Stderr,
}

impl Serial {
    /// The port behind `stream`, of the QEMU with the standard error `qemu`.
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

    /// Waits for `time`, or until the next line.
    pub(crate) fn pass(&mut self, time: Duration) {
        self.line(time);
    }

    /// The last lines.
    pub(crate) fn lately(&self) -> String {
        let from = self.said.len().saturating_sub(20);
        format!("it said lately: {}", self.said[from..].join("\n"))
    }

    /// The exit status of the last command.
    pub(crate) fn status(&self) -> i32 {
        let told = self.said.iter().rev().find_map(|line| line.strip_prefix("DONE "));
        told.and_then(|status| status.parse().ok()).expect("a status was told")
    }

    /// Sends `command` to the shell, without waiting.
    pub(crate) fn send(&mut self, command: &str) {
        if writeln!(self.to, "{command}").is_err() {
            self.qemu.ended();
        }
    }

    /// Runs `command` in the shell; returns its output and its exit status.
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
