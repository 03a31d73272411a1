//! The serial port of a machine: its shell in the profile `bench`.
//!
//! Owns the lines that come, and waiting for them. Never sends what it was not given.

use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

/// The port.
pub(crate) struct Serial {
    to: UnixStream,
    lines: Receiver<String>,
    /// What was said lately, to be told when something goes wrong.
    said: Vec<String>,
}

impl Serial {
    /// The port behind `stream`.
    pub(crate) fn new(stream: UnixStream) -> Self {
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
        Self { to: stream, lines, said: Vec::new() }
    }

    /// The next line, if one comes within `wait`.
    pub(crate) fn line(&mut self, wait: Duration) -> Option<String> {
        let line = self.lines.recv_timeout(wait).ok()?;
        self.said.push(line.clone());
        Some(line)
    }

    /// The lines up to one that begins with `word`, which comes within so many seconds of silence.
    pub(crate) fn until(&mut self, word: &str, seconds: u64) -> Vec<String> {
        let mut lines = Vec::new();
        loop {
            let Some(line) = self.line(Duration::from_secs(seconds)) else {
                let lately = self.said.iter().rev().take(20).rev().cloned().collect::<Vec<_>>().join("\n");
                panic!("no `{word}` for {seconds} s; lately: {lately}");
            };
            let is_it = line.starts_with(word);
            lines.push(line);
            if is_it {
                return lines;
            }
        }
    }

    /// Has the shell run `command`, without waiting.
    pub(crate) fn send(&mut self, command: &str) {
        writeln!(self.to, "{command}").unwrap();
    }

    /// Has the shell run `command`; what it says, and its exit status.
    pub(crate) fn run(&mut self, command: &str) -> (String, i32) {
        self.send(command);
        let mut lines = self.until("DONE ", 300);
        let status = lines.pop().and_then(|line| line["DONE ".len()..].parse().ok()).expect("a status");
        (lines.join("\n"), status)
    }
}
