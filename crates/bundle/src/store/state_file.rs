//! The form of the files that hold the state of a store.
//!
//! Owns the text with its number and its checksum. [`durable::Copies`] keeps two files that say the same: if one is
//! damaged, the other one still has every floor. Never knows what the state means.

use std::io;

use durable::Checksummed;

use crate::limits;
use crate::names::{ObjectId, parse_plain};
use crate::store::state::State;

/// The first word of each file.
const HEADING: &str = "dreams-state-1";

impl Checksummed for State {
    const FILES: [&'static str; 2] = ["state.0", "state.1"];
    const LIMIT: u64 = limits::STATE;

    fn to_file(&self, number: u64) -> io::Result<Vec<u8>> {
        let body = serde_json::to_string(self).map_err(io::Error::other)?;
        let text = format!("{HEADING} {number} {}\n{body}\n", ObjectId::of(format!("{number} {body}").as_bytes()));
        if text.len() as u64 > limits::STATE {
            return Err(durable::too_large(limits::STATE));
        }
        Ok(text.into_bytes())
    }

    fn from_file(bytes: &[u8]) -> Option<(u64, Self)> {
        let (head, body) = std::str::from_utf8(bytes).ok()?.split_once('\n')?;
        let body = body.strip_suffix('\n')?;
        let mut words = head.split(' ');
        let (heading, number, checksum) = (words.next()?, words.next()?, words.next()?);
        let is_whole = heading == HEADING
            && words.next().is_none()
            && ObjectId::parse(checksum) == Ok(ObjectId::of(format!("{number} {body}").as_bytes()));
        if is_whole { Some((parse_plain(number)?, serde_json::from_str(body).ok()?)) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::key::KeyId;
    use crate::names::Sequence;

    #[test]
    fn a_flipped_bit_anywhere_and_a_cut_anywhere_are_seen() {
        let floors = [(KeyId::parse("0123456789ABCDEF").unwrap(), Sequence(9))].into();
        let state = State { floors, newest: 9, ..State::default() };
        let whole = state.to_file(7).unwrap();
        assert_eq!(State::from_file(&whole), Some((7, state)));
        for bit in 0..whole.len() * 8 {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(State::from_file(&bytes), None, "bit {bit}");
        }
        for cut in 0..whole.len() {
            assert_eq!(State::from_file(&whole[..cut]), None, "cut at {cut}");
        }
    }
}
