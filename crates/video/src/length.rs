//! The length that a video file should have, by its own structure.
//!
//! Owns what containers tell of their length where ffmpeg reads a file that was cut short without an error: AVI, Matroska,
//! MPEG transport streams and Ogg. Never decodes.
//!
//! Start at [`told`].

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;

/// Bytes at the beginning of a file that are read.
const HEAD: usize = 1024;
/// The longest page of an Ogg file, in bytes.
const PAGE: u64 = 65_307;
/// The bytes before the table of a page's segments.
const PAGE_HEADER: usize = 27;
/// Lengths of packets in a transport stream, and where the first byte of each, 0x47, lies.
const PACKETS: [(usize, usize); 2] = [(188, 0), (192, 4)];

/// The length that `file` should have, which has `found` bytes; `None` where its container does not tell.
/// Errors: The system's, if it cannot be read.
pub(crate) fn told(file: &File, found: u64) -> io::Result<Option<u64>> {
    let head = read(file, 0, HEAD)?;
    if head.starts_with(b"OggS") {
        let start = found.saturating_sub(2 * PAGE);
        let tail = read(file, start, 2 * PAGE as usize)?;
        return Ok(last_page(&tail).map(|end| start + end));
    }
    Ok(riff(&head).or_else(|| matroska(&head)).or_else(|| transport(&head, found)))
}

/// Up to `most` bytes from `start`.
fn read(file: &File, start: u64, most: usize) -> io::Result<Vec<u8>> {
    let mut bytes = vec![0; most];
    let mut done = 0;
    while done < most {
        match file.read_at(&mut bytes[done..], start + done as u64) {
            Ok(0) => break,
            Ok(more) => done += more,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => (),
            Err(error) => return Err(error),
        }
    }
    bytes.truncate(done);
    Ok(bytes)
}

/// An AVI begins with `RIFF` and how many bytes follow.
fn riff(head: &[u8]) -> Option<u64> {
    let size = head.strip_prefix(b"RIFF")?.first_chunk()?;
    Some(u64::from(u32::from_le_bytes(*size)) + 8)
}

/// A Matroska file has a header and one segment, each with an id and its length.
fn matroska(head: &[u8]) -> Option<u64> {
    let (length, field) = variable(head.strip_prefix(&[0x1a, 0x45, 0xdf, 0xa3])?)?;
    let segment = usize::try_from(length).ok()?.checked_add(4 + field)?;
    let (length, field) = variable(head.get(segment..)?.strip_prefix(&[0x18, 0x53, 0x80, 0x67])?)?;
    length.checked_add((segment + 4 + field) as u64)
}

/// A number of variable length, and its bytes; `None` if it stands for an unknown one. RFC 8794, section 4.
fn variable(bytes: &[u8]) -> Option<(u64, usize)> {
    let field = bytes.first()?.leading_zeros() as usize + 1;
    let whole = bytes.get(..field).filter(|_| field <= 8)?;
    let number = whole.iter().fold(0u64, |number, byte| number << 8 | u64::from(*byte));
    let ones = (1u64 << (7 * field)) - 1;
    (number & ones != ones).then_some((number & ones, field))
}

/// A transport stream is made of whole packets.
fn transport(head: &[u8], found: u64) -> Option<u64> {
    let is = |(packet, first): &&(usize, usize)| (0..4).all(|at| head.get(first + at * packet) == Some(&0x47));
    let (packet, _) = PACKETS.iter().find(is)?;
    Some(found.next_multiple_of(*packet as u64))
}

/// Where the last page that begins in `tail` ends.
fn last_page(tail: &[u8]) -> Option<u64> {
    let start = tail.windows(4).rposition(|four| four == b"OggS")?;
    let segments = usize::from(*tail.get(start + PAGE_HEADER - 1)?);
    let lengths = tail.get(start + PAGE_HEADER..start + PAGE_HEADER + segments)?;
    let body: u64 = lengths.iter().map(|length| u64::from(*length)).sum();
    Some((start + PAGE_HEADER + segments) as u64 + body)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_container_tells_how_long_its_file_is() {
        assert_eq!(riff(b"RIFF\x10\0\0\0AVI "), Some(24));
        let ebml = [0x1a, 0x45, 0xdf, 0xa3, 0x82, 0, 0, 0x18, 0x53, 0x80, 0x67];
        assert_eq!(matroska(&[&ebml[..], &[0x41, 0x00]].concat()), Some(7 + 4 + 2 + 256));
        assert_eq!(matroska(&[&ebml[..], &[0x01, 255, 255, 255, 255, 255, 255, 255]].concat()), None, "not known");
        let packets: Vec<u8> = (0..800).map(|at| if at % 188 == 0 { 0x47 } else { 0 }).collect();
        assert_eq!(transport(&packets, 800), Some(940));
        assert_eq!(transport(&packets, 752), Some(752));
        let page = [b"OggS", &[0; 22][..], &[2, 255, 10]].concat();
        assert_eq!(last_page(&page), Some(29 + 265));
        for other in [&b""[..], b"RIFF", b"\x1a\x45\xdf\xa3", b"OggS", b"ftyp"] {
            assert_eq!((riff(other), matroska(other), transport(other, 4)), (None, None, None));
        }
    }
}
