//! Changes bytes of a file.
//!
//! Owns the changes that need no knowledge of the content: in seals, lists, objects, statements, start files. Never
//! signs.

use super::{Detection, Dice, Stick};

/// Values at which text and number parsers fail.
const SPECIAL: &[u8] = b"\0\n\r\t /.\\-0\x7f\x80\xff";

/// Changes one file; returns what was done.
pub(super) fn change(stick: &mut Stick, dice: &mut Dice) -> (String, Detection) {
    let paths: Vec<String> = stick.0.keys().cloned().collect();
    let path = dice.of_these(&paths).clone();
    let good = stick.bytes(&path).to_vec();
    let (mut bytes, mut done) = (good.clone(), Vec::new());
    for _ in 0..=dice.below(3) {
        done.push(varied(&mut bytes, dice));
    }
    if bytes == good {
        bytes[0] ^= 1;
        done.push("a flipped bit at 0".to_owned());
    }
    stick.put(&path, bytes);
    (format!("`{path}`: {}", done.join(", ")), Detection::ByAllOrHarmless)
}

/// Makes one change to the bytes; returns what.
pub fn varied(bytes: &mut Vec<u8>, dice: &mut Dice) -> String {
    if bytes.is_empty() {
        bytes.push(7);
        return "a byte where none was".to_owned();
    }
    let (at, size) = (dice.below(bytes.len()), bytes.len());
    let length = (1 + dice.below(64)).min(size - at);
    match dice.below(8) {
        0 => {
            let bit = dice.below(8);
            bytes[at] ^= 1 << bit;
            format!("bit {bit} of byte {at} flipped")
        }
        1 => {
            bytes.truncate(at);
            format!("cut at {at}")
        }
        2 => {
            bytes.drain(at..at + length);
            format!("{length} bytes less at {at}")
        }
        3 => {
            let more = dice.bytes(length);
            bytes.splice(at..at, more);
            format!("{length} random bytes more at {at}")
        }
        4 => {
            let byte = *dice.of_these(SPECIAL);
            bytes.insert(at, byte);
            format!("byte {byte:#04x} more at {at}")
        }
        5 => {
            let again = bytes[at..at + length].to_vec();
            bytes.splice(at..at, again);
            format!("{length} bytes repeated at {at}")
        }
        6 => {
            bytes.rotate_left(at);
            format!("two blocks swapped at {at}")
        }
        _ => {
            let byte = *dice.of_these(SPECIAL);
            bytes[at..at + length].fill(byte);
            format!("{length} bytes at {at} become {byte:#04x}")
        }
    }
}
