//! QEMU's process, its standard error, and the sockets that it connects to.
//!
//! Owns the end of the process together with its machine; a process that has ended by itself fails the claim at once,
//! with its standard error.

use claims::wait;
use std::fs::{self, File};
use std::io::ErrorKind;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

/// Seconds that QEMU may take to connect to a socket.
const PATIENCE_S: u32 = 300;

/// The process. It is killed when this is dropped.
pub(crate) struct Qemu {
    process: Child,
    said: Stderr,
}

/// The standard error of the process, in a file.
#[derive(Clone)]
pub(crate) struct Stderr(PathBuf);

impl Qemu {
    /// Starts `command`, with its standard error in the file `said`.
    pub(crate) fn start(command: &mut Command, said: PathBuf) -> Self {
        let process = command.stderr(Stdio::from(File::create(&said).unwrap())).spawn().expect("QEMU starts");
        Self { process, said: Stderr(said) }
    }

    /// Its standard error.
    pub(crate) fn said(&self) -> Stderr {
        self.said.clone()
    }

    /// Panics if it has ended.
    pub(crate) fn is_there(&mut self) {
        if self.process.try_wait().unwrap().is_some() {
            self.said.ended();
        }
    }
}

impl Stderr {
    /// Panics, since the process has ended.
    pub(crate) fn ended(&self) -> ! {
        panic!("QEMU has ended; it said: {}", fs::read_to_string(&self.0).unwrap_or_default().trim_end());
    }
}

/// A socket to which QEMU connects.
pub(crate) struct Socket {
    path: PathBuf,
    listener: UnixListener,
}

impl Socket {
    /// One that listens at `path`.
    pub(crate) fn new(path: PathBuf) -> Self {
        fs::remove_file(&path).ok();
        Self { listener: UnixListener::bind(&path).unwrap(), path }
    }

    /// QEMU's option for it.
    pub(crate) fn argument(&self, id: &str) -> String {
        format!("socket,id={id},path={}", self.path.display())
    }

    /// The connection, once `qemu` has made it.
    pub(crate) fn accept(self, qemu: &mut Qemu) -> UnixStream {
        self.listener.set_nonblocking(true).unwrap();
        let mut accepted = None;
        wait::until(&format!("QEMU connects to {}", self.path.display()), PATIENCE_S, || {
            qemu.is_there();
            match self.listener.accept() {
                Ok((stream, _)) => accepted = Some(stream),
                Err(error) => assert_eq!(error.kind(), ErrorKind::WouldBlock, "{error}"),
            }
            accepted.is_some()
        });
        accepted.expect("it was waited for")
    }
}

impl Drop for Qemu {
    fn drop(&mut self) {
        // It may have ended already.
        self.process.kill().ok();
        self.process.wait().ok();
    }
}

#[cfg(test)]
mod tests {
    use super::{Qemu, Socket};
    use crate::machine::monitor::Monitor;
    use crate::machine::serial::Serial;
    use serde_json::json;
    use std::io::Write;
    use std::os::unix::net::UnixStream;
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::process::Command;
    use std::time::Duration;

    /// The panic message of `claim`.
    fn fails(claim: impl FnOnce()) -> String {
        *catch_unwind(AssertUnwindSafe(claim)).unwrap_err().downcast::<String>().unwrap()
    }

    #[test]
    fn a_qemu_that_ends_before_or_after_it_has_called_is_told_at_once_with_what_it_said() {
        let folder = tempfile::tempdir().unwrap();
        let told = "QEMU has ended; it said: out of memory";
        let mut command = Command::new("sh");
        let mut qemu = Qemu::start(command.args(["-c", "echo out of memory >&2"]), folder.path().join("said"));
        let socket = Socket::new(folder.path().join("socket"));
        assert_eq!(fails(|| drop(socket.accept(&mut qemu))), told);

        let (mut theirs, ours) = UnixStream::pair().unwrap();
        writeln!(theirs, "{{\"QMP\":{{}}}}\n{{\"return\":{{}}}}").unwrap();
        let mut monitor = Monitor::new(ours, qemu.said());
        drop(theirs);
        assert_eq!(fails(|| drop(monitor.try_to("screendump", &json!({})))), told);

        let (theirs, ours) = UnixStream::pair().unwrap();
        let mut serial = Serial::new(ours, qemu.said());
        drop(theirs);
        assert_eq!(fails(|| serial.pass(Duration::from_hours(1))), told);
    }
}
