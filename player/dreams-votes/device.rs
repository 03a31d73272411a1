//! Input devices, read as the kernel writes them.
//!
//! Owns the form of an event, and that a device may be unplugged at any time: it is opened again when it is back. Nothing is
//! asked of a device; a pipe does as well. Never knows what a key means: `crates/votes` does.
//!
//! # Source
//! `struct input_event` of `linux/input.h`: the time in seconds and microseconds since 1970, type and code of 16 bits each, a
//! value of 32.
//!
//! Start at [`InputDevice::read`].

use rustix::fs::OFlags;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read};
use std::os::unix::fs::OpenOptionsExt;
use std::path::PathBuf;
use timing::Nanos;
use tracing::info;

/// Bytes of the time of an event, and of a whole one.
const TIME: usize = 2 * size_of::<usize>();
const EVENT: usize = TIME + 8;
/// Events that are read at once, at most.
const AT_ONCE: usize = 64;
/// The time between two attempts to open a device.
const PAUSE_NS: u64 = 1_000_000_000;
/// Types of events: the end of a group, a key, a switch.
const EV_SYN: u16 = 0;
const EV_KEY: u16 = 1;
const EV_SW: u16 = 5;
/// The kernel dropped events.
const SYN_DROPPED: u16 = 3;

/// What a device says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Input {
    /// A key or a switch has a value: 0 released, 1 pressed, 2 repeated.
    Key {
        /// Its code.
        code: u16,
        /// The value.
        value: i32,
        /// When the kernel saw it, in microseconds since 1970, by its clock.
        at_us: u64,
    },
    /// Events were lost, or the device is gone: nothing is known of its keys.
    Lost,
}

/// A device that may not be there.
#[derive(Debug)]
pub(crate) struct InputDevice {
    path: PathBuf,
    file: Option<File>,
    /// The beginning of an event.
    rest: Vec<u8>,
    /// When it is looked for again.
    next: Nanos,
    /// Whether it is there, as was said last.
    told: Option<bool>,
}

impl InputDevice {
    /// The device at `path`, not opened yet.
    pub(crate) fn new(path: PathBuf) -> Self {
        Self { path, file: None, rest: Vec::new(), next: Nanos(0), told: None }
    }

    /// The open device, to wait for; opens it at `now` if it is time.
    pub(crate) fn open(&mut self, now: Nanos) -> Option<&File> {
        if self.file.is_none() && now >= self.next {
            self.next = now.after(PAUSE_NS);
            let flags = (OFlags::NONBLOCK | OFlags::NOCTTY).bits().cast_signed();
            match OpenOptions::new().read(true).custom_flags(flags).open(&self.path) {
                Ok(file) => {
                    if self.told.replace(true) != Some(true) {
                        info!(path = %self.path.display(), "reading an input device");
                    }
                    self.file = Some(file);
                }
                Err(error) => {
                    if self.told.replace(false) != Some(false) {
                        info!(path = %self.path.display(), %error, "waiting for an input device");
                    }
                }
            }
        }
        self.file.as_ref()
    }

    /// What it has to say, without waiting.
    pub(crate) fn read(&mut self) -> Vec<Input> {
        let Some(file) = &mut self.file else { return Vec::new() };
        let mut buffer = [0; EVENT * AT_ONCE];
        match file.read(&mut buffer) {
            Ok(0) => self.lost(),
            Ok(length) => {
                self.rest.extend_from_slice(&buffer[..length]);
                let whole = self.rest.len() / EVENT * EVENT;
                self.rest.drain(..whole).as_slice().chunks_exact(EVENT).filter_map(input).collect()
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Vec::new(),
            Err(_) => self.lost(),
        }
    }

    fn lost(&mut self) -> Vec<Input> {
        self.file = None;
        self.rest.clear();
        vec![Input::Lost]
    }
}

/// What the bytes of an event say, if it is of interest.
fn input(event: &[u8]) -> Option<Input> {
    let number = |at: usize| u16::from_ne_bytes([event[TIME + at], event[TIME + at + 1]]);
    let (kind, code) = (number(0), number(2));
    let value = i32::from_ne_bytes(event[TIME + 4..].try_into().ok()?);
    let word = |at: usize| Some(usize::from_ne_bytes(event[at..at + TIME / 2].try_into().ok()?) as u64);
    let at_us = word(0)?.saturating_mul(1_000_000).saturating_add(word(TIME / 2)?);
    match kind {
        EV_KEY | EV_SW => Some(Input::Key { code, value, at_us }),
        EV_SYN if code == SYN_DROPPED => Some(Input::Lost),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{EVENT, Input, InputDevice, PAUSE_NS, TIME};
    use rustix::fs::{CWD, FileType, Mode, mknodat};
    use std::fs::OpenOptions;
    use std::io::Write;
    use timing::Nanos;

    fn event(kind: u16, code: u16, value: i32) -> Vec<u8> {
        [&[7; TIME][..], &kind.to_ne_bytes(), &code.to_ne_bytes(), &value.to_ne_bytes()].concat()
    }

    #[test]
    fn a_device_is_read_event_by_event_and_opened_again_when_it_is_back() {
        assert_eq!(event(1, 103, 1).len(), EVENT);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("event3");
        let mut device = InputDevice::new(path.clone());
        assert!(device.open(Nanos(0)).is_none() && device.read().is_empty());
        mknodat(CWD, &path, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        assert!(device.open(Nanos(PAUSE_NS - 1)).is_none(), "it is not looked for all the time");
        let mut far_end = OpenOptions::new().read(true).write(true).open(&path).unwrap();
        assert!(device.open(Nanos(PAUSE_NS)).is_some() && device.read().is_empty());
        let all = [event(1, 103, 1), event(0, 0, 0), event(4, 4, 9), event(5, 0, 1), event(0, 3, 0), event(1, 103, 0)]
            .concat();
        let mut told = Vec::new();
        for part in all.chunks(17) {
            far_end.write_all(part).unwrap();
            told.extend(device.read());
        }
        let seven = usize::from_ne_bytes([7; TIME / 2]) as u64;
        let at_us = seven.saturating_mul(1_000_000).saturating_add(seven);
        let key = |code, value| Input::Key { code, value, at_us };
        assert_eq!(told, [key(103, 1), key(0, 1), Input::Lost, key(103, 0)]);
        drop(far_end);
        assert_eq!((device.read(), device.read()), (vec![Input::Lost], vec![]), "it was unplugged");
        assert!(device.open(Nanos(2 * PAUSE_NS)).is_some(), "it is back");
    }
}
