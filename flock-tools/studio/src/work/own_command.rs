//! Commands of this program that a job runs: `pack`, `publish`, `diff`, `votes`.
//!
//! Owns how such a command is started, what of it the job's log gets, and how it is ended when the job is cancelled. The
//! passphrase of a key is asked on the terminal by the command itself: neither the page nor this module sees it.
//!
//! Start at [`run`].

use std::collections::BTreeSet;
use std::env;
use std::ffi::OsString;
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, MutexGuard};
use std::thread;
use std::time::Duration;

use operations::program::now;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

use crate::lock::locked;

/// How long it may take until a cancelled command is ended.
const TICK: Duration = Duration::from_millis(50);

/// The processes of commands that run.
static RUNNING: Mutex<BTreeSet<u32>> = Mutex::new(BTreeSet::new());

/// A command in the list of those that run, as long as this is there.
struct Running(u32);

/// The answer of this program's command `words` with `--json`, and whether it was yes. `log` gets its lines for people;
/// `is_cancelled` is asked while it runs.
/// Errors: A sentence, if it ended without an answer.
pub(crate) fn run(
    words: &[OsString],
    log: &(dyn Fn(&str) + Sync),
    is_cancelled: &dyn Fn() -> bool,
) -> Result<(Value, bool), String> {
    let program = env::current_exe().map_err(|error| format!("cannot find this program: {error}"))?;
    let mut command = Command::new(program);
    command.args(words).arg("--json").stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|error| format!("cannot start this program: {error}"))?;
    let _running = Running::of(child.id());
    let (out, err) = (child.stdout.take(), child.stderr.take());
    let ended = thread::scope(|scope| {
        let answer = scope.spawn(move || {
            let mut text = String::new();
            let read = out.map_or(Ok(0), |mut out| out.read_to_string(&mut text));
            read.map(|_| text)
        });
        scope.spawn(move || {
            for line in err.into_iter().flat_map(|err| BufReader::new(err).lines()).map_while(Result::ok) {
                log(&line);
            }
        });
        let status = loop {
            match child.try_wait() {
                Ok(None) if is_cancelled() => {
                    // It may have ended meanwhile.
                    let _ = child.kill();
                }
                Ok(None) => {}
                ended => break ended,
            }
            now::pause(TICK, &AtomicBool::new(false));
        };
        (status, answer.join())
    });
    let (Ok(Some(status)), Ok(Ok(text))) = ended else { return Err("the command ended without an answer".to_owned()) };
    if is_cancelled() {
        return Err("cancelled".to_owned());
    }
    let answer: Value = serde_json::from_str(&text).map_err(|_| "the command ended without an answer".to_owned())?;
    match status.code() {
        Some(0) => Ok((answer, true)),
        Some(1) if answer.get("error").is_none() => Ok((answer, false)),
        _ => Err(error_of(&answer)),
    }
}

/// Ends all commands that run: the studio ends.
pub(crate) fn end_all() {
    for id in running().iter() {
        if let Some(id) = i32::try_from(*id).ok().and_then(Pid::from_raw) {
            // It may have ended by itself.
            let _ = kill_process(id, Signal::TERM);
        }
    }
}

impl Running {
    fn of(id: u32) -> Self {
        running().insert(id);
        Self(id)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        running().remove(&self.0);
    }
}

fn running() -> MutexGuard<'static, BTreeSet<u32>> {
    locked(&RUNNING)
}

/// What went wrong, by the answer of a command that failed: its error with its causes.
fn error_of(answer: &Value) -> String {
    let error = answer.get("error").unwrap_or(answer);
    let message = error.get("message").or(Some(error)).and_then(Value::as_str).unwrap_or("the command failed");
    let causes = error.get("causes").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str);
    [message].into_iter().chain(causes).collect::<Vec<_>>().join(": ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn an_error_is_told_with_its_causes() {
        let answer = json!({"error": {"message": "cannot read `a.key`", "causes": ["no such file"], "exit": 3}});
        assert_eq!(error_of(&answer), "cannot read `a.key`: no such file");
        assert_eq!(error_of(&json!({})), "the command failed");
    }
}
