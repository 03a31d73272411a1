//! DDC/CI: the commands of a display on the I2C bus of its cable.
//!
//! Owns the form of its messages, and the control `D6` of a display, its power mode. Mode 4 is used for off, from which a
//! display wakes by a command or by a signal; not mode 5, after which many wake by their button only.
//!
//! Start at [`switch`]. Source: VESA DDC/CI 1.1, chapters 4 and 6; VESA MCCS 2.2, control `D6`.

use super::PowerError;
use crate::raw::set_i2c_address;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;
use std::thread;
use std::time::Duration;

/// The address of a display, in seven bits; with the bit for writing, as checksums count it.
const ADDRESS: usize = 0x37;
const DESTINATION: u8 = 0x6e;
/// The address of the host in messages, and the one that the checksum of an answer begins with.
const HOST: u8 = 0x51;
const VIRTUAL_HOST: u8 = 0x50;
/// The bit that the length of a message has set.
const LENGTH: u8 = 0x80;
/// Operations: read a control, its answer, and set a control.
const GET: u8 = 0x01;
const ANSWER: u8 = 0x02;
const SET: u8 = 0x03;
/// The control for the power mode, and its values.
const POWER_MODE: u8 = 0xd6;
const ON: u16 = 1;
const OFF: u16 = 4;
/// How long a display needs after a command, and until an answer is there.
const AFTER_SET: Duration = Duration::from_millis(50);
const AFTER_GET: Duration = Duration::from_millis(40);

/// The bytes to and from one display.
pub(super) trait Bus {
    /// Sends a message.
    fn write(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Fills `answer`.
    fn read(&mut self, answer: &mut [u8]) -> io::Result<()>;

    /// Waits.
    fn pause(&mut self, time: Duration);
}

/// An I2C bus of the kernel, set to the address of a display.
pub(super) struct DisplayBus(File);

impl DisplayBus {
    /// The bus `file` at `path`.
    pub(super) fn new(file: File, path: &Path) -> Result<Self, PowerError> {
        match set_i2c_address(&file, ADDRESS) {
            Ok(()) => Ok(Self(file)),
            Err(source) => Err(PowerError::Open { path: path.to_owned(), source }),
        }
    }
}

impl Bus for DisplayBus {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.write_all(bytes)
    }

    fn read(&mut self, answer: &mut [u8]) -> io::Result<()> {
        self.0.read_exact(answer)
    }

    fn pause(&mut self, time: Duration) {
        thread::park_timeout(time);
    }
}

/// What a display says of its power mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    /// This one.
    Known(u16),
    /// It does not have this control, or does not report its value.
    Unknown,
}

/// Asks a display to switch on or off. Off is done when the display has acknowledged the command; on, when it says so.
/// Errors: [`PowerError`].
pub(super) fn switch(bus: &mut impl Bus, is_on: bool) -> Result<(), PowerError> {
    let sent = bus.write(&set(if is_on { ON } else { OFF }));
    sent.map_err(|source| PowerError::Send { message: "set power mode", source })?;
    bus.pause(AFTER_SET);
    if !is_on {
        return Ok(());
    }
    let asked = bus.write(&message(&[GET, POWER_MODE]));
    asked.map_err(|source| PowerError::Send { message: "get power mode", source })?;
    bus.pause(AFTER_GET);
    let unanswered = PowerError::Unanswered { message: "get power mode" };
    let mut bytes = [0; 11];
    if bus.read(&mut bytes).is_err() {
        return Err(unanswered);
    }
    match answer(&bytes) {
        Some(Mode::Known(ON) | Mode::Unknown) => Ok(()),
        Some(Mode::Known(mode)) => Err(PowerError::Unchanged { mode }),
        None => Err(unanswered),
    }
}

/// The message that sets the power mode.
fn set(mode: u16) -> Vec<u8> {
    let [high, low] = mode.to_be_bytes();
    message(&[SET, POWER_MODE, high, low])
}

/// A message to a display: who sends it, its length, its content, and the checksum.
fn message(content: &[u8]) -> Vec<u8> {
    let mut bytes = vec![HOST, LENGTH | content.len() as u8];
    bytes.extend(content);
    bytes.push(bytes.iter().fold(DESTINATION, |sum, byte| sum ^ byte));
    bytes
}

/// What the answer of a display says of its power mode; `None` if it is no such answer.
fn answer(bytes: &[u8; 11]) -> Option<Mode> {
    let [source, length, operation, result, control, _, _, _, high, low, checksum] = *bytes;
    let sum = bytes[..10].iter().fold(VIRTUAL_HOST, |sum, byte| sum ^ byte);
    let head = [source, length, operation, control];
    if head != [DESTINATION, LENGTH | 8, ANSWER, POWER_MODE] || sum != checksum {
        return None;
    }
    Some(if result == 0 { Mode::Known(u16::from_be_bytes([high, low])) } else { Mode::Unknown })
}

#[cfg(test)]
mod tests {
    use super::{Bus, OFF, ON, message, set, switch};
    use crate::power::PowerError;
    use std::io::{self, ErrorKind};
    use std::time::Duration;

    /// A display on a bus, which understands messages as the standard has them.
    #[derive(Debug, Default)]
    struct Display {
        mode: u16,
        /// It takes no message at all: it is gone, or in deep sleep.
        is_deaf: bool,
        /// It takes messages, and does nothing of what they say.
        is_stubborn: bool,
        /// It does not report its power mode.
        is_secretive: bool,
        /// The bit of its answer that is turned over on the way.
        flipped: Option<usize>,
        answer: Vec<u8>,
        pauses: Duration,
    }

    impl Bus for Display {
        fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
            if self.is_deaf {
                return Err(ErrorKind::NotConnected.into());
            }
            let [0x51, length, operation, 0xd6, rest @ ..] = bytes else {
                panic!("no message to control D6: {bytes:x?}")
            };
            assert_eq!(bytes.iter().fold(0x6e, |sum, byte| sum ^ byte), 0, "{bytes:x?} has a wrong checksum");
            assert_eq!(usize::from(length & 0x7f) + 3, bytes.len(), "{bytes:x?} has a wrong length");
            match (operation, rest) {
                (3, [high, low, _]) if !self.is_stubborn => self.mode = u16::from_be_bytes([*high, *low]),
                (3, _) => {}
                (1, [_]) => {
                    let result = u8::from(self.is_secretive);
                    let [high, low] = if self.is_secretive { [0, 0] } else { self.mode.to_be_bytes() };
                    self.answer = vec![0x6e, 0x88, 2, result, 0xd6, 1, 0, 5, high, low];
                    self.answer.push(self.answer.iter().fold(0x50, |sum, byte| sum ^ byte));
                }
                _ => panic!("an unknown message {bytes:x?}"),
            }
            Ok(())
        }

        fn read(&mut self, answer: &mut [u8]) -> io::Result<()> {
            assert!(self.pauses >= Duration::from_millis(40), "an answer takes 40 ms");
            if let Some(bit) = self.flipped {
                self.answer[bit / 8] ^= 1 << (bit % 8);
            }
            answer.copy_from_slice(&self.answer);
            Ok(())
        }

        fn pause(&mut self, time: Duration) {
            self.pauses += time;
        }
    }

    #[test]
    fn messages_are_byte_for_byte_those_of_the_standard() {
        assert_eq!(set(ON), [0x51, 0x84, 0x03, 0xd6, 0x00, 0x01, 0x6f]);
        assert_eq!(set(OFF), [0x51, 0x84, 0x03, 0xd6, 0x00, 0x04, 0x6a]);
        // The example of DDC/CI 1.1, 4.3: read the luminance.
        assert_eq!(message(&[0x01, 0x10]), [0x51, 0x82, 0x01, 0x10, 0xac]);
    }

    #[test]
    fn a_display_is_switched_off_and_on_and_says_so() {
        let mut display = Display { mode: 1, ..Display::default() };
        switch(&mut display, false).unwrap();
        assert_eq!(display.mode, 4, "off, so that a command wakes it");
        switch(&mut display, true).unwrap();
        assert_eq!(display.mode, 1);
        let mut secretive = Display { is_secretive: true, ..Display::default() };
        assert!(switch(&mut secretive, true).is_ok() && secretive.mode == 1, "its acknowledgement is enough");
    }

    #[test]
    fn a_display_that_does_not_follow_is_an_error_to_try_again() {
        let mut deaf = Display { is_deaf: true, ..Display::default() };
        for is_on in [true, false] {
            assert!(matches!(switch(&mut deaf, is_on), Err(PowerError::Send { message: "set power mode", .. })));
        }
        let mut stubborn = Display { mode: 4, is_stubborn: true, ..Display::default() };
        assert!(matches!(switch(&mut stubborn, true), Err(PowerError::Unchanged { mode: 4 })));
    }

    #[test]
    fn an_answer_with_any_bit_turned_over_is_no_answer() {
        for bit in 0..88 {
            let mut display = Display { flipped: Some(bit), ..Display::default() };
            let refused = switch(&mut display, true);
            assert!(matches!(refused, Err(PowerError::Unanswered { .. })), "bit {bit}: {refused:?}");
        }
    }
}
