//! Faults at the system calls of a program: it is killed at one, or the call fails.
//!
//! Owns the use of `strace` for that, for one call after the other. The claims judge what a program leaves.
//!
//! Start at [`at_every_step`].

use claims::programs::output;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// The kind of fault: the program is killed at the call, or the disk fails.
const WAYS: [&str; 2] = ["signal=KILL", "error=EIO"];

/// Runs `command` under `strace` with these options; the calls are written to `log`.
pub(crate) fn traced(command: &Command, log: &Path, options: &[&str]) -> Output {
    let mut strace = Command::new("strace");
    strace.args(["-f", "-qq", "-o"]).arg(log).args(options);
    output(strace.arg(command.get_program()).args(command.get_args()))
}

/// The same, with a fault of the kind `how` at the system call `call`, at the occurrences that `step` says.
pub(crate) fn broken(command: &Command, log: &Path, call: &str, how: &str, step: &str) -> Output {
    traced(command, log, &["-e", &format!("trace={call}"), "-e", &format!("inject={call}:{how}:when={step}")])
}

/// Runs the command that `prepare` makes with every kind of fault at every one of these calls, from the same state each
/// time; `judge` is called after each. Returns the number of faults.
pub(crate) fn at_every_step(
    calls: &[&str],
    log: &Path,
    prepare: impl Fn() -> Command,
    mut judge: impl FnMut(&str),
) -> usize {
    let mut count = 0;
    for call in calls {
        traced(&prepare(), log, &["-e", &format!("trace={call}")]);
        let said = fs::read_to_string(log).unwrap();
        let steps = said.lines().filter(|line| line.contains(&format!(" {call}("))).count();
        for (step, how) in (1..=steps).flat_map(|step| WAYS.map(|how| (step, how))) {
            broken(&prepare(), log, call, how, &step.to_string());
            judge(&format!("{how} at {call} {step}"));
            count += 1;
        }
    }
    count
}
