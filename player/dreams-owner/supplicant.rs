//! `wpa_supplicant`: started for one radio, and listened to.
//!
//! Owns its process and the socket of its events. Never interprets them: `link.rs` does.
//!
//! Start at [`Supplicant::start`].

use std::fs;
use std::io::{self, ErrorKind};
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::Duration;

/// Between two looks whether it is ready.
const OFTEN: Duration = Duration::from_millis(100);
/// So many of them at most: half a minute.
const LOOKS: u32 = 300;
/// The longest event, in bytes.
const LONGEST: usize = 4096;

/// One that runs. It ends when this is dropped.
#[derive(Debug)]
pub(super) struct Supplicant {
    process: Child,
    socket: UnixDatagram,
    /// Our end of it.
    path: PathBuf,
}

impl Supplicant {
    /// Starts one for the radio `interface` with the file `settings`, and asks it for events through its socket in the
    /// folder `control`.
    /// Errors: What the system says, also if it ends at once or does not answer.
    pub(super) fn start(interface: &str, settings: &Path, control: &Path) -> io::Result<Self> {
        let path = control.join(format!("{interface}.dreams"));
        let there = control.join(interface);
        for left in [&path, &there] {
            match fs::remove_file(left) {
                Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
                Ok(()) | Err(_) => {}
            }
        }
        let socket = UnixDatagram::bind(&path)?;
        let mut command = Command::new("wpa_supplicant");
        command.arg("-i").arg(interface).arg("-D").arg("nl80211").arg("-c").arg(settings);
        let unstarted =
            |error: io::Error| io::Error::new(error.kind(), format!("cannot run `wpa_supplicant`: {error}"));
        let process = command.stdin(Stdio::null()).spawn().map_err(unstarted)?;
        let mut supplicant = Self { process, socket, path };
        supplicant.attach(&there)?;
        Ok(supplicant)
    }

    fn attach(&mut self, there: &Path) -> io::Result<()> {
        self.socket.set_read_timeout(Some(OFTEN))?;
        for _ in 0..LOOKS {
            if let Some(status) = self.ended()? {
                return Err(io::Error::other(format!("`wpa_supplicant` ended at once: {status}")));
            }
            if self.socket.connect(there).and_then(|()| self.socket.send(b"ATTACH")).is_ok() {
                while let Some(told) = self.told()? {
                    if told.trim() == "OK" {
                        return Ok(());
                    }
                }
            }
            thread::park_timeout(OFTEN);
        }
        Err(io::Error::new(ErrorKind::TimedOut, "`wpa_supplicant` does not answer"))
    }

    /// Its next event, if one comes within `time`.
    pub(super) fn told_within(&self, time: Duration) -> io::Result<Option<String>> {
        self.socket.set_read_timeout(Some(time))?;
        self.told()
    }

    fn told(&self) -> io::Result<Option<String>> {
        let mut bytes = [0; LONGEST];
        match self.socket.recv(&mut bytes) {
            Ok(count) => Ok(Some(String::from_utf8_lossy(&bytes[..count]).into_owned())),
            Err(error) if [ErrorKind::WouldBlock, ErrorKind::TimedOut].contains(&error.kind()) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// How it ended, if it has.
    pub(super) fn ended(&mut self) -> io::Result<Option<ExitStatus>> {
        self.process.try_wait()
    }
}

impl Drop for Supplicant {
    fn drop(&mut self) {
        // Whatever has ended already has ended.
        self.process.kill().ok();
        self.process.wait().ok();
        fs::remove_file(&self.path).ok();
    }
}
