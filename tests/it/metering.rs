//! The memory and the processor time of a program.
//!
//! Owns the runner `metered.py`, which measures both, and the limit of memory for every program of a unit.
//!
//! Start at [`Meter::run`].

use claims::programs::repository;
use claims::wait;
use serde_json::{Value, json};
use std::io::{BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// The largest resident set of a program: half of a unit's memory.
pub(crate) const PEAK_KIB: u64 = 125_000;
/// Seconds after which a program is killed, since it hangs.
const HANGS_S: u32 = 120;

/// Runs programs, one after the other.
pub(crate) struct Meter {
    runner: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
}

/// The result of a program, and what it used.
#[derive(Debug)]
pub(crate) struct Measurement {
    /// Negative for a signal.
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
