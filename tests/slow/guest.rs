//! A guest with a real KMS display, for as long as one command runs.
//!
//! Owns the runner `tests/vkms/run` and the number of guests that run at once. In virtual time a guest is
//! deterministic: its clock moves only while all its processes sleep.
//!
//! Start at [`in_virtual_time`].

use claims::programs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::{Condvar, Mutex};

/// Guests that may run at once: each keeps one processor busy.
const AT_ONCE: usize = 2;

static RUNNING: Mutex<usize> = Mutex::new(0);
static ENDED: Condvar = Condvar::new();

/// A place among the running guests, released when dropped.
struct Place;

impl Place {
    fn take() -> Self {
        let running = RUNNING.lock().unwrap();
        *ENDED.wait_while(running, |running| *running >= AT_ONCE).unwrap() += 1;
        Self
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        *RUNNING.lock().unwrap() -= 1;
        ENDED.notify_one();
    }
}

/// Runs `command` in a guest with virtual time, for at most `limit_s` seconds of real time. The output is the guest's
/// console; the exit status is the command's.
pub(crate) fn in_virtual_time(limit_s: u32, command: &Command) -> Output {
    in_time("virtual", limit_s, command)
}

/// The same in real time, with one processor: two processors of a guest wait for each other whenever this machine
/// interrupts one.
pub(crate) fn in_real_time(limit_s: u32, command: &Command) -> Output {
    in_time("real", limit_s, command)
}

fn in_time(time: &str, limit_s: u32, command: &Command) -> Output {
    let _place = Place::take();
    let mut run = Command::new(programs::repository().join("tests/vkms/run"));
    run.args(["--time", time, "--cpus", "1", "--limit", &limit_s.to_string(), "--"]);
    run.arg(command.get_program()).args(command.get_args());
    programs::output(&mut run)
}

/// As [`in_virtual_time`], for a command that must succeed; returns its console.
pub(crate) fn succeed_in_virtual_time(limit_s: u32, command: &Command) -> String {
    let said = in_virtual_time(limit_s, command);
    let console = String::from_utf8_lossy(&said.stdout).into_owned();
    let complaint = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.success(), "{command:?} ended with {} in the guest: {console}{complaint}", said.status);
    console
}

/// A shell script as a command.
pub(crate) fn script(text: &str) -> Command {
    let mut bash = Command::new("bash");
    bash.args(["-euc", text]);
    bash
}

/// `path`, quoted as a word of such a script.
pub(crate) fn word(path: &Path) -> String {
    format!("'{}'", path.to_str().expect("claims use plain names").replace('\'', r"'\''"))
}

/// `command` as a line of such a script; `$name` in it is the script's variable.
pub(crate) fn shell_words(command: &Command) -> String {
    let words = [command.get_program()].into_iter().chain(command.get_args());
    let quoted: Vec<_> = words.map(|word| format!("\"{}\"", word.to_str().expect("claims use plain names"))).collect();
    quoted.join(" ")
}

#[test]
fn a_guest_has_a_vkms_display_and_time_that_costs_nothing() {
    let console =
        succeed_in_virtual_time(60, &script("sleep 3600; modetest -M vkms -c | grep 1280x720; echo up $SECONDS"));
    assert!(console.contains("1280x720 60.00"), "{console}");
    assert!(console.contains("up 3600"), "{console}");
}

#[test]
fn a_guest_ends_with_the_exit_status_of_its_command() {
    assert_eq!(in_virtual_time(60, &script("exit 7")).status.code(), Some(7));
}
