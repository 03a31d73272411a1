//! Input devices, read as the kernel writes them.
//!
//! Owns the form of an event, and that a device may be unplugged at any time: it is opened again when it is back; where any
//! device counts, those that are plugged in are found. Nothing is asked of a device; a pipe does as well. Never knows what a
//! key means: `crates/votes` and `dreams-install` do.
//!
//! # Source
//! `struct input_event` of `linux/input.h`: the time in seconds and microseconds since 1970, type and code of 16 bits each, a
//! value of 32.
//!
//! Start at [`InputDevices::read`].

use rustix::fs::OFlags;
use settings::ButtonDevice;
use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Read};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use timing::Nanos;
use tracing::info;

/// Bytes of the time of an event, and of a whole one.
const TIME: usize = 2 * size_of::<usize>();
const EVENT: usize = TIME + 8;
/// Events that are read at once, at most.
const AT_ONCE: usize = 64;
/// The time between two attempts to open a device.
const PAUSE_NS: u64 = 1_000_000_000;
/// Where the kernel has its input devices, and how their names begin.
pub const FOLDER: &str = "/dev/input";
const PREFIX: &str = "event";
/// Types of events: the end of a group, a key, a switch.
const EV_SYN: u16 = 0;
const EV_KEY: u16 = 1;
const EV_SW: u16 = 5;
/// The kernel dropped events.
const SYN_DROPPED: u16 = 3;

/// What a device says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
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

/// The devices that are read: one that may not be there, or all that are.
#[derive(Debug, Default)]
pub struct InputDevices {
    devices: Vec<InputDevice>,
    /// The folder of them, if all are read.
    folder: Option<PathBuf>,
    /// When that is looked through again.
    next: Nanos,
}

impl InputDevices {
    /// Those that a setting means, not opened yet.
    pub fn of(device: &ButtonDevice) -> Self {
        match device {
            ButtonDevice::At(path) => Self { devices: vec![InputDevice::new(path.clone(), true)], ..Self::default() },
            ButtonDevice::Any => Self::all_of(Path::new(FOLDER)),
        }
    }

    /// Every device in `folder`, at any time.
    pub fn all_of(folder: &Path) -> Self {
        Self { folder: Some(folder.to_owned()), ..Self::default() }
    }

    /// The open devices, to wait for; opens them at `now` if it is time.
    pub fn open(&mut self, now: Nanos) -> Vec<&File> {
        self.find(now);
        self.devices.iter_mut().filter_map(|device| device.open(now)).collect()
    }

    /// Finds what was plugged in since, where all devices are read; forgets what is gone.
    fn find(&mut self, now: Nanos) {
        let Some(folder) = self.folder.as_ref().filter(|_| now >= self.next) else { return };
        self.next = now.after(PAUSE_NS);
        let is_device = |path: &PathBuf| {
            path.file_name().and_then(|name| name.to_str()).is_some_and(|name| name.starts_with(PREFIX))
        };
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        let there: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(is_device).collect();
        // One that is gone is told as lost before it is forgotten.
        self.devices.retain(|device| device.file.is_some() || there.contains(&device.path));
        for path in there {
            if self.devices.iter().all(|device| device.path != path) {
                self.devices.push(InputDevice::new(path, false));
            }
        }
    }

    /// What they have to say, without waiting.
    pub fn read(&mut self) -> Vec<Input> {
        self.devices.iter_mut().flat_map(InputDevice::read).collect()
    }
}

/// A device that may not be there.
#[derive(Debug)]
struct InputDevice {
    path: PathBuf,
    file: Option<File>,
    /// Whether a switch counts as a key: a mat may be one, but so is the socket of a display.
    has_switches: bool,
    /// The beginning of an event.
    rest: Vec<u8>,
    /// When it is looked for again.
    next: Nanos,
    /// Whether it is there, as was said last.
    told: Option<bool>,
}

impl InputDevice {
    /// The device at `path`, not opened yet.
    fn new(path: PathBuf, has_switches: bool) -> Self {
        Self { path, file: None, has_switches, rest: Vec::new(), next: Nanos(0), told: None }
    }

    /// The open device, to wait for; opens it at `now` if it is time.
    fn open(&mut self, now: Nanos) -> Option<&File> {
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
    fn read(&mut self) -> Vec<Input> {
        let Some(file) = &mut self.file else { return Vec::new() };
        let mut buffer = [0; EVENT * AT_ONCE];
        match file.read(&mut buffer) {
            Ok(0) => self.lost(),
            Ok(length) => {
                self.rest.extend_from_slice(&buffer[..length]);
                let whole = self.rest.len() / EVENT * EVENT;
                let events = self.rest.drain(..whole);
                events.as_slice().chunks_exact(EVENT).filter_map(|event| input(event, self.has_switches)).collect()
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
fn input(event: &[u8], has_switches: bool) -> Option<Input> {
    let number = |at: usize| u16::from_ne_bytes([event[TIME + at], event[TIME + at + 1]]);
    let (kind, code) = (number(0), number(2));
    let value = i32::from_ne_bytes(event[TIME + 4..].try_into().ok()?);
    let word = |at: usize| Some(usize::from_ne_bytes(event[at..at + TIME / 2].try_into().ok()?) as u64);
    let at_us = word(0)?.saturating_mul(1_000_000).saturating_add(word(TIME / 2)?);
    match kind {
        EV_KEY => Some(Input::Key { code, value, at_us }),
        EV_SW if has_switches => Some(Input::Key { code, value, at_us }),
        EV_SYN if code == SYN_DROPPED => Some(Input::Lost),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{EVENT, Input, InputDevice, InputDevices, PAUSE_NS, TIME};
    use rustix::fs::{CWD, FileType, Mode, mknodat};
    use std::fs::{self, File, OpenOptions};
    use std::io::Write;
    use std::path::Path;
    use timing::Nanos;

    fn event(kind: u16, code: u16, value: i32) -> Vec<u8> {
        [&[7; TIME][..], &kind.to_ne_bytes(), &code.to_ne_bytes(), &value.to_ne_bytes()].concat()
    }

    #[test]
    fn a_device_is_read_event_by_event_and_opened_again_when_it_is_back() {
        assert_eq!(event(1, 103, 1).len(), EVENT);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("event3");
        let mut device = InputDevice::new(path.clone(), true);
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

    fn code(input: &Input) -> Option<u16> {
        match input {
            Input::Key { code, .. } => Some(*code),
            Input::Lost => None,
        }
    }

    /// A pipe at `path`, in place of a device that is plugged in.
    fn plugged_in(path: &Path) -> File {
        mknodat(CWD, path, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        OpenOptions::new().read(true).write(true).open(path).unwrap()
    }

    #[test]
    fn where_any_device_counts_those_that_are_plugged_in_are_found_and_those_that_are_gone_forgotten() {
        let folder = tempfile::tempdir().unwrap();
        let [pedal, remote, mouse] = ["event0", "event12", "mice"].map(|name| folder.path().join(name));
        let mut devices = InputDevices::all_of(folder.path());
        assert!(devices.open(Nanos(0)).is_empty());
        let (mut pedal_end, _mouse_end) = (plugged_in(&pedal), plugged_in(&mouse));
        assert_eq!(devices.open(Nanos(PAUSE_NS)).len(), 1, "the events of all mice are of another form");
        let mut remote_end = plugged_in(&remote);
        assert_eq!(devices.open(Nanos(2 * PAUSE_NS)).len(), 2);
        pedal_end.write_all(&event(1, 30, 1)).unwrap();
        remote_end.write_all(&[event(5, 2, 1), event(1, 352, 1)].concat()).unwrap();
        let mut codes: Vec<_> = devices.read().iter().map(code).collect();
        codes.sort_unstable();
        assert_eq!(codes, [Some(30), Some(352)], "keys of all devices, and no switch");
        drop(pedal_end);
        fs::remove_file(&pedal).unwrap();
        assert_eq!(devices.read(), [Input::Lost], "a key that was held is not held for ever");
        assert_eq!(devices.open(Nanos(3 * PAUSE_NS)).len(), 1);
        assert_eq!(devices.devices.len(), 1, "nobody waits for it");
    }
}
