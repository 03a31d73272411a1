//! The index of a clip, looked at before ffmpeg opens it.
//!
//! Owns its bounds: each box ends within the one around it, and each table has room for the entries that it counts. ffmpeg
//! takes memory for as many as are counted: for a count with one flipped bit that may be all that the machine has, or it
//! answers as a machine does that is short of memory, although no later attempt can succeed. Never reads the entries.
//!
//! Source: ISO/IEC 14496-12, 4.2 (boxes), 8.5 to 8.7 (tables); 14496-15, 5.3.4 (`avc1`).

use std::fs::File;
use std::io;
use std::ops::Range;
use std::os::unix::fs::FileExt;

/// The boxes that hold others, and how many bytes of their own come before those.
const CONTAINERS: [(&[u8; 4], u64); 11] = [
    (b"moov", 0),
    (b"mvex", 0),
    (b"trak", 0),
    (b"edts", 0),
    (b"mdia", 0),
    (b"minf", 0),
    (b"dinf", 0),
    (b"dref", 8),
    (b"stbl", 0),
    (b"stsd", 8),
    (b"avc1", 78),
];

/// The tables: how many bytes come before the count of the entries, and the fewest that an entry has.
const TABLES: [(&[u8; 4], u64, u64); 10] = [
    (b"elst", 4, 12),
    (b"dref", 4, 12),
    (b"stsd", 4, 8),
    (b"stts", 4, 8),
    (b"ctts", 4, 8),
    (b"stsc", 4, 12),
    (b"stsz", 8, 4),
    (b"stss", 4, 4),
    (b"stco", 4, 4),
    (b"co64", 4, 8),
];

/// The deepest that boxes are looked into: `avc1` lies at the seventh.
const DEPTH: u32 = 8;

/// Why no player should open the file.
#[derive(Debug, thiserror::Error)]
pub(crate) enum IndexError {
    #[error("its index cannot be read: {0}")]
    Read(#[from] io::Error),
    #[error("its box `{name}` has {found} bytes (expected {least} to {most})")]
    Box { name: String, found: u64, least: u64, most: u64 },
    #[error("its table `{name}` counts {found} entries (expected at most {most})")]
    Count { name: String, found: u64, most: u64 },
}

/// Looks at the index in a file of so many `bytes`. A file without an index is for ffmpeg to refuse, and one whose last
/// box was cut short, too.
pub(crate) fn check(file: &File, bytes: u64) -> Result<(), IndexError> {
    let mut at = 0;
    while let Some(found) = BoxHead::read(file, at..bytes)? {
        if found.size < found.head || found.size > bytes - at {
            break;
        }
        if &found.name == b"moov" {
            inside(file, &found, at, bytes, DEPTH)?;
        }
        at += found.size;
    }
    Ok(())
}

/// The beginning of a box.
struct BoxHead {
    name: [u8; 4],
    /// The bytes of size and name.
    head: u64,
    /// The bytes of the whole box.
    size: u64,
}

impl BoxHead {
    /// The box at the start of `room`; `None` if no box can begin there.
    fn read(file: &File, room: Range<u64>) -> io::Result<Option<Self>> {
        let left = room.end.saturating_sub(room.start);
        if left < 8 {
            return Ok(None);
        }
        let size = u64::from(number(file, room.start)?);
        let mut name = [0; 4];
        file.read_exact_at(&mut name, room.start + 4)?;
        Ok(Some(match size {
            // It goes on to the end of what is around it.
            0 => Self { name, head: 8, size: left },
            1 if left >= 16 => {
                let (high, low) = (number(file, room.start + 8)?, number(file, room.start + 12)?);
                Self { name, head: 16, size: u64::from(high) << 32 | u64::from(low) }
            }
            size => Self { name, head: 8, size },
        }))
    }

    fn named(&self) -> String {
        self.name.escape_ascii().to_string()
    }
}

/// Looks at the box `outer`, which begins at `at` and fits into what is around it, in a file of so many `bytes`.
fn inside(file: &File, outer: &BoxHead, at: u64, bytes: u64, depth: u32) -> Result<(), IndexError> {
    let (body, end) = (at + outer.head, at + outer.size);
    if let Some((_, before, each)) = TABLES.iter().find(|(name, ..)| **name == outer.name) {
        check_count(file, outer, body + before, end, *each, bytes)?;
    }
    let Some((_, own)) = CONTAINERS.iter().find(|(name, _)| **name == outer.name) else { return Ok(()) };
    if depth == 0 {
        return Ok(());
    }
    let mut at = body + own;
    while let Some(found) = BoxHead::read(file, at..end)? {
        let room = end - at;
        if found.size < found.head || found.size > room {
            return Err(IndexError::Box { name: found.named(), found: found.size, least: found.head, most: room });
        }
        inside(file, &found, at, bytes, depth - 1)?;
        at += found.size;
    }
    Ok(())
}

/// Checks the count at `at` in a table that ends at `end` and whose entries have at least `each` bytes.
fn check_count(file: &File, table: &BoxHead, at: u64, end: u64, each: u64, bytes: u64) -> Result<(), IndexError> {
    if at + 4 > end {
        let least = table.size + at + 4 - end;
        return Err(IndexError::Box { name: table.named(), found: table.size, least, most: bytes });
    }
    let found = u64::from(number(file, at)?);
    // Samples that are all of one size have no entries, but their bytes.
    let same = if &table.name == b"stsz" { u64::from(number(file, at - 4)?) } else { 0 };
    let most = bytes.checked_div(same).unwrap_or((end - at - 4) / each);
    if found > most { Err(IndexError::Count { name: table.named(), found, most }) } else { Ok(()) }
}

/// The number of four bytes at `at`, the highest first.
fn number(file: &File, at: u64) -> io::Result<u32> {
    let mut bytes = [0; 4];
    file.read_exact_at(&mut bytes, at)?;
    Ok(u32::from_be_bytes(bytes))
}
