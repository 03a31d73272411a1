//! The form of a file that keeps a state: what it is, its number, its length, the state, and a checksum over all.
//!
//! Owns the layout: 8 bytes that name the kind of file and its version, the number and the length in 8 and 4 bytes, the
//! state, and the CRC-32 of everything before in 4 bytes; numbers begin with their lowest byte. Never knows what the state
//! means.
//!
//! Start at [`framed`].

use std::io;

/// The bytes before the state.
const HEAD: usize = 8 + 8 + 4;

/// The bytes of a file of the kind `magic`, with this number and state.
///
/// # Errors
/// The state has 4 GiB or more.
pub fn framed(magic: [u8; 8], number: u64, state: &[u8]) -> io::Result<Vec<u8>> {
    let length = u32::try_from(state.len()).map_err(io::Error::other)?;
    let mut bytes = [&magic[..], &number.to_le_bytes(), &length.to_le_bytes(), state].concat();
    bytes.extend_from_slice(&crc32fast::hash(&bytes).to_le_bytes());
    Ok(bytes)
}

/// The number and the state in the bytes of a file of the kind `magic`; `None` if they are not whole.
pub fn unframed(magic: [u8; 8], bytes: &[u8]) -> Option<(u64, &[u8])> {
    let (head, rest) = bytes.split_at_checked(HEAD)?;
    let number = u64::from_le_bytes(head[8..16].try_into().ok()?);
    let length = u32::from_le_bytes(head[16..].try_into().ok()?) as usize;
    let (state, tail) = rest.split_at_checked(length)?;
    let checksum = u32::from_le_bytes(tail.try_into().ok()?);
    let is_whole = head.starts_with(&magic) && checksum == crc32fast::hash(&bytes[..HEAD + length]);
    is_whole.then_some((number, state))
}

#[cfg(test)]
mod tests {
    use super::{framed, unframed};

    #[test]
    fn a_state_comes_back_and_no_changed_or_cut_byte_passes() {
        let file = framed(*b"d-tests\x01", 7, b"state").unwrap();
        assert_eq!(unframed(*b"d-tests\x01", &file), Some((7, &b"state"[..])));
        assert_eq!(unframed(*b"d-tests\x02", &file), None);
        for at in 0..file.len() {
            let mut changed = file.clone();
            changed[at] ^= 1;
            assert_eq!(unframed(*b"d-tests\x01", &changed), None, "byte {at}");
            assert_eq!(unframed(*b"d-tests\x01", &file[..at]), None, "cut at {at}");
        }
    }
}
