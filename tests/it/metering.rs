//! What a program takes of memory and of processor time.
//!
//! Owns the runner in `metered.py`, which tells both, and how much memory any program of a unit may take.
//!
//! Start at [`Meter::run`].

use crate::programs::repository;
use claims::wait;
use serde_json::{Value, json};
use std::io::{BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// The most that a program may have in memory at once, its own text included: half of what a unit has.
pub(crate) const PEAK_KIB: u64 = 125_000;
/// Seconds after which a program is taken to hang, and killed.
const HANGS_S: u32 = 120;

/// Runs programs, one after the other.
pub(crate) struct Meter {
    runner: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
}

/// What a program did, and what it took.
#[derive(Debug)]
pub(crate) struct Measurement {
    /// Below 0 for a signal.
    pub(crate) code: i64,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
    pub(crate) peak_kib: u64,
    pub(crate) cpu_s: f64,
}

impl Meter {
    pub(crate) fn new() -> Self {
        let mut runner = Command::new("/usr/bin/python3");
        runner.arg(repository().join("tests/it/metered.py")).arg(HANGS_S.to_string());
        let mut runner = runner.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let (to, from) = (runner.stdin.take().unwrap(), BufReader::new(runner.stdout.take().unwrap()));
        Self { runner, to, from }
    }

    /// Runs the program that `words` begin with to its end.
    pub(crate) fn run(&mut self, words: &[&str]) -> Measurement {
        writeln!(self.to, "{}", json!(words)).unwrap();
        let line = wait::line(&format!("the end of {words:?}"), 2 * HANGS_S, &mut self.from);
        let told: Value = serde_json::from_str(&line).unwrap_or_else(|error| panic!("{words:?}: {error}: {line}"));
        let text = |key: &str| told[key].as_str().unwrap().to_owned();
        Measurement {
            code: told["code"].as_i64().unwrap(),
            stdout: text("stdout"),
            stderr: text("stderr"),
            peak_kib: told["peak_kib"].as_u64().unwrap(),
            cpu_s: told["cpu_s"].as_f64().unwrap(),
        }
    }
}

impl Drop for Meter {
    fn drop(&mut self) {
        self.runner.kill().ok();
        self.runner.wait().ok();
    }
}
