//! The text console that the player was started on.
//!
//! Sets it to graphics mode while the picture is lit, so that no text is drawn; releases the display when another
//! console is activated, and takes it back later; restores the console at the end. A player that is started as a
//! service has no console.
//!
//! Start at [`Console::take`].
//!
//! # Source
//! `console_ioctl(4)`: `KDSETMODE`, `VT_SETMODE` with `VT_PROCESS`, `VT_RELDISP`.

use crate::raw::{VT_ACKNOWLEDGED, VT_ALLOWED, answer_switch, set_graphics, set_switching};
use rustix::event::{EventfdFlags, eventfd};
use rustix::fs::{FileType, fstat, major, minor};
use rustix::io::{read, write};
use signal_hook::consts::{SIGUSR1, SIGUSR2};
use signal_hook::iterator::{Handle, Signals};
use std::fs::File;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::mpsc::{Receiver, channel};
use std::thread;

/// The major number of terminals, and the minor number of the first serial one.
const TTY_MAJOR: u32 = 4;
const FIRST_SERIAL: u32 = 64;

/// A requested console switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Switch {
    /// To another console: close the display, then call [`Console::release`].
    Away,
    /// This one again.
    Back,
}

/// The console, in graphics mode.
pub(crate) struct Console {
    file: File,
    switches: Receiver<Switch>,
    /// Readable when there may be a switch.
    event_fd: OwnedFd,
    signals: Handle,
}

impl Console {
    /// Sets the console on standard input to graphics mode; `None` if that is not a console.
    pub(crate) fn take() -> io::Result<Option<Self>> {
        let input = io::stdin();
        let stat = fstat(&input)?;
        let is_device = FileType::from_raw_mode(stat.st_mode) == FileType::CharacterDevice;
        let is_console = is_device && major(stat.st_rdev) == TTY_MAJOR && minor(stat.st_rdev) < FIRST_SERIAL;
        if !is_console {
            return Ok(None);
        }
        let file = File::from(input.as_fd().try_clone_to_owned()?);
        let event_fd = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?;
        let (ringing, (sender, switches)) = (event_fd.try_clone()?, channel());
        let mut caught = Signals::new([SIGUSR1, SIGUSR2])?;
        let signals = caught.handle();
        let listen = move || {
            for signal in caught.forever() {
                let switch = if signal == SIGUSR1 { Switch::Away } else { Switch::Back };
                if sender.send(switch).is_err() || write(&ringing, &1u64.to_ne_bytes()).is_err() {
                    return;
                }
            }
        };
        thread::Builder::new().name("console".to_owned()).spawn(listen)?;
        let console = Self { file, switches, event_fd, signals };
        // In this order: from the first call on, switches need our permission.
        set_switching(&console.file, Some((SIGUSR1, SIGUSR2)))?;
        set_graphics(&console.file, true)?;
        Ok(Some(console))
    }

    /// The next switch, if there is one.
    pub(crate) fn switch(&self) -> Option<Switch> {
        let mut count = [0; 8];
        read(&self.event_fd, &mut count).ok();
        let switch = self.switches.try_recv().ok()?;
        if switch == Switch::Back
            && let Err(error) = answer_switch(&self.file, VT_ACKNOWLEDGED)
        {
            tracing::warn!(%error, "cannot acquire the console again");
        }
        Some(switch)
    }

    /// Allows the switch to the other console.
    pub(crate) fn release(&self) {
        if let Err(error) = answer_switch(&self.file, VT_ALLOWED) {
            tracing::warn!(%error, "cannot release the console");
        }
    }

    /// Readable when there may be a switch.
    pub(crate) fn event_fd(&self) -> BorrowedFd<'_> {
        self.event_fd.as_fd()
    }
}

impl Drop for Console {
    fn drop(&mut self) {
        self.signals.close();
        let restored = set_graphics(&self.file, false).and_then(|()| set_switching(&self.file, None));
        if let Err(error) = restored {
            tracing::warn!(%error, "cannot restore the console");
        }
    }
}
