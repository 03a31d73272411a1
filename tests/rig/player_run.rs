//! Runs of the player: its command line, and the running process.
//!
//! Owns a scratch folder for each: its state, its trace. A claim decides where it runs: here on the virtual screen, or
//! in a guest.
//!
//! Start at [`PlayerRun::of`].

use crate::programs;
use crate::trace::Trace;
use crate::wait::{self, ends_within};
use rustix::io::ioctl_fionread;
use rustix::pipe::fcntl_setpipe_size;
use rustix::process::{Pid, Resource, Rlimit, Signal, getrlimit, kill_process, prlimit};
use std::ffi::OsString;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::Arc;
use tempfile::TempDir;

/// The display of a guest.
pub const VKMS: &str = "kms:/dev/dri/by-driver/vkms";

/// The most seconds without a line of the trace.
const SILENCE_S: u32 = 300;
/// More bytes than a line of the trace has.
const LINE: u64 = 256;

/// A flock and options; started again, it continues where it was.
pub struct PlayerRun {
    scratch: Arc<TempDir>,
    options: Vec<OsString>,
}

impl PlayerRun {
    /// Plays the flock in `folder` with a state folder of its own.
    pub fn of(folder: &Path) -> Self {
        let scratch = Arc::new(tempfile::tempdir_in(programs::claims_folder()).unwrap());
        let mut options = vec!["--flock".into(), folder.into()];
        options.extend(["--state".into(), scratch.path().join("state").into()]);
        Self { scratch, options }
    }

    /// Adds options.
    #[must_use]
    pub fn with(mut self, options: &[&str]) -> Self {
        self.options.extend(options.iter().map(OsString::from));
        self
    }

    /// The command line, with a trace in the scratch folder and no status page.
    pub fn command(&self) -> Command {
        self.command_with_page("off")
    }

    /// The same with a status page at `address`.
    pub fn command_with_page(&self, address: &str) -> Command {
        let mut command = Command::new(programs::player());
        command.args(&self.options).args(["--status", address, "--trace"]).arg(self.path("trace"));
        command
    }

    /// A path in the scratch folder, which is removed with this value and the last player that it started.
    pub fn path(&self, name: &str) -> PathBuf {
        self.scratch.path().join(name)
    }

    /// The trace of [`Self::command`].
    pub fn trace(&self) -> Trace {
        Trace::read(&self.path("trace"))
    }

    /// Starts the player here, with its trace on a pipe.
    pub fn start(&self) -> RunningPlayer {
        let mut command = Command::new(programs::player());
        command.args(&self.options).args(["--trace", "/dev/stdout"]).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        let told = BufReader::new(child.stdout.take().expect("its standard output is piped"));
        RunningPlayer { child, told: Some(told), text: String::new(), _scratch: Arc::clone(&self.scratch) }
    }
}

/// A player that runs here. It is killed when dropped.
pub struct RunningPlayer {
    child: Child,
    told: Option<BufReader<ChildStdout>>,
    text: String,
    /// Where it keeps its state, for as long as it runs.
    _scratch: Arc<TempDir>,
}

impl RunningPlayer {
    /// Waits for `lines` more lines of the trace.
    pub fn await_lines(&mut self, lines: u64) {
        for line in 0..lines {
            let told = self.told.as_mut().expect("read to its end only by `end_within`");
            let next = wait::line("a line of the player's trace", SILENCE_S, told);
            self.text += &next;
            assert!(!next.is_empty(), "the player ended by itself after {line} lines: {}", self.text);
        }
    }

    /// Waits for a line of the trace with `words` in it.
    pub fn await_line_with(&mut self, words: &str) {
        let seen = |text: &str| text.lines().next_back().is_some_and(|line| line.contains(words));
        while !seen(&self.text) {
            self.await_lines(1);
        }
    }

    /// Waits for the next line of the trace, and returns it.
    pub fn next_line(&mut self) -> Trace {
        self.await_lines(1);
        let before = self.text.trim_end().rfind('\n').map_or(0, |end| end + 1);
        Trace::parse(&self.text[before..])
    }

    /// The next line of the trace, which comes within `seconds`; `None` if the player has ended. `what` happened before.
    pub fn line_within(&mut self, seconds: u32, what: &str) -> Option<String> {
        let told = self.told.as_mut().expect("read to its end only by `end_within`");
        let next = wait::line(&format!("a line of the player's trace after {what}"), seconds, told);
        (!next.is_empty()).then_some(next)
    }

    /// Reads the lines that are there already.
    pub fn catch_up(&mut self) {
        let is_there =
            |told: &BufReader<ChildStdout>| told.buffer().contains(&b'\n') || wait::is_ready(told.get_ref(), 0);
        while self.told.as_ref().is_some_and(is_there) && self.line_within(1, "all that was there").is_some() {}
    }

    /// Stops reading, and waits until the pipe is full: the player blocks in the middle of a line.
    pub fn stop_listening(&self) {
        let pipe = self.told.as_ref().expect("read to its end only by `end_within`").get_ref();
        let size = fcntl_setpipe_size(pipe, 4_096).unwrap() as u64;
        // A line goes in whole or not at all, so the last few bytes may stay free.
        wait::until("the pipe of the trace is full", SILENCE_S, || ioctl_fionread(pipe).unwrap() >= size - LINE);
    }

    /// Sets the player's soft limit of `resource`; returns the previous one.
    pub fn limit(&self, resource: Resource, current: Option<u64>) -> Option<u64> {
        let pid = Some(Pid::from_child(&self.child));
        // The hard limit stays what it is: ours, which the player inherited.
        let maximum = getrlimit(resource).maximum;
        prlimit(pid, resource, Rlimit { current, maximum }).unwrap().current
    }

    /// Sends a signal.
    pub fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).unwrap();
    }

    /// Waits for the end, at most `seconds`, without reading; returns the exit code and what there is of the trace.
    pub fn end_unread_within(self, seconds: u32) -> (Option<i32>, Trace) {
        assert!(ends_within(&self.child, seconds), "the player still runs after {seconds} s");
        self.end_within(seconds)
    }

    /// Waits for the end, at most `seconds`; returns the exit code (`None` if it was killed) and the whole trace.
    pub fn end_within(mut self, seconds: u32) -> (Option<i32>, Trace) {
        // The pipe must not hold up a player that tells more than it holds.
        let mut told = self.told.take().expect("read to its end only here");
        let rest = std::thread::spawn(move || {
            let mut rest = String::new();
            told.read_to_string(&mut rest).map(|_| rest)
        });
        assert!(ends_within(&self.child, seconds), "the player still runs after {seconds} s");
        let code = self.child.wait().unwrap().code();
        self.text += &rest.join().unwrap().unwrap();
        (code, Trace::parse(&self.text))
    }
}

impl Drop for RunningPlayer {
    fn drop(&mut self) {
        // Fails only if it has ended by itself.
        let _ended = self.child.kill();
        let _status = self.child.wait();
    }
}
