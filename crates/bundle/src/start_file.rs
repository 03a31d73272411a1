//! What the firmware starts of a system: kernel, initramfs and command line in one file.
//!
//! Owns how such a file says which system it is and which root it was made with, and the sum by which it is known to be
//! whole. `image-build/stamp` writes that sum, and `image-build/chooser.c` checks it, too, before the file is started.
//! Never reads a file.
//!
//! Start at [`StartFile::read`].

use crate::names::{NameError, Version};

/// The words of the command line that tell the version, and the root that it was made with.
const VERSION: &[u8] = b"dreams.version=";
const ROOT: &[u8] = b"dreams.root=";
/// Where the sum stands, in the part of the file's head that nobody reads: this word, then the size of the file and its
/// CRC-32, both little endian. The file may have grown since: a signature stands behind it.
const STAMP_AT: usize = 0x28;
const STAMP_WORD: &[u8; 8] = b"dreams\0\0";
const STAMP_SIZE: usize = 16;
/// Where the file's head says where its next one begins; and, from there, the checksum and the pointer to a signature.
/// Who signs changes these two.
const HEAD_AT: usize = 0x3c;
const CHECKSUM: std::ops::Range<usize> = 88..92;
const SIGNATURE: std::ops::Range<usize> = 168..176;

/// What a start file says of itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StartFile {
    /// The version of its system.
    pub version: Version,
    /// What stands in the superblock of a slot that bears the root, in hex digits.
    pub slot: String,
    /// How many blocks of 4096 bytes the root has. Behind them stand the superblock and the tree of hashes.
    pub blocks: u64,
    /// The salt of every hash, in hex digits.
    pub salt: String,
    /// The hash of all hashes, in hex digits.
    pub hash: String,
}

/// Why a file is no start file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StartFileError {
    /// It names no system or no root.
    #[error("it does not say what system it starts")]
    Mute,
    /// It names a version which is none.
    #[error("it says that it is a version which is none")]
    Unversioned(#[source] NameError),
}

impl StartFile {
    /// What the start file `bytes` says of itself. Whether it is whole is another question: see [`is_whole`].
    ///
    /// # Errors
    /// [`StartFileError`] if it does not say it.
    pub fn read(bytes: &[u8]) -> Result<Self, StartFileError> {
        let version = word(bytes, VERSION).ok_or(StartFileError::Mute)?;
        let version = Version::parse(version).map_err(StartFileError::Unversioned)?;
        let words: Vec<_> = word(bytes, ROOT).ok_or(StartFileError::Mute)?.splitn(4, ':').collect();
        let [slot, blocks, salt, hash] = words[..] else { return Err(StartFileError::Mute) };
        let blocks = blocks.parse().map_err(|_| StartFileError::Mute)?;
        Ok(Self { version, slot: slot.to_owned(), blocks, salt: salt.to_owned(), hash: hash.to_owned() })
    }
}

/// Whether the bytes of a stamped file are those that it was stamped with.
#[must_use]
pub fn is_whole(bytes: &[u8]) -> bool {
    let number = |at: usize| bytes.get(at..)?.first_chunk().map(|number| u32::from_le_bytes(*number));
    let (Some(size), Some(sum), Some(head)) = (number(STAMP_AT + 8), number(STAMP_AT + 12), number(HEAD_AT)) else {
        return false;
    };
    let (size, head) = (size as usize, head as usize);
    if size > bytes.len() || !bytes[STAMP_AT..].starts_with(STAMP_WORD) {
        return false;
    }
    let stamped = &bytes[..size];
    // What the stamp does not count is counted as zeros.
    let holes = [STAMP_AT..STAMP_AT + STAMP_SIZE, head + CHECKSUM.start..head + CHECKSUM.end, {
        head + SIGNATURE.start..head + SIGNATURE.end
    }];
    let mut hasher = crc32fast::Hasher::new();
    let mut from = 0;
    for hole in holes {
        let (Some(before), Some(zeros)) = (stamped.get(from..hole.start), [0; STAMP_SIZE].get(..hole.len())) else {
            return false;
        };
        if hole.end > size {
            return false;
        }
        hasher.update(before);
        hasher.update(zeros);
        from = hole.end;
    }
    hasher.update(&stamped[from..]);
    hasher.finalize() == sum
}

/// What stands behind `key` in `bytes`, up to where the word ends.
fn word<'b>(bytes: &'b [u8], key: &[u8]) -> Option<&'b str> {
    let at = bytes.windows(key.len()).position(|window| window == key)? + key.len();
    let end = bytes[at..].iter().position(|byte| byte.is_ascii_whitespace() || *byte == 0)?;
    std::str::from_utf8(&bytes[at..at + end]).ok()
}

#[cfg(test)]
mod tests {
    use super::{HEAD_AT, STAMP_AT, STAMP_WORD, StartFile, StartFileError, is_whole};

    /// A file with the head that a stamped file has, and its sum, as `image-build/stamp` writes it.
    fn stamped() -> Vec<u8> {
        let mut bytes: Vec<u8> = (0_u32..1_000).flat_map(u32::to_le_bytes).collect();
        bytes[HEAD_AT..HEAD_AT + 4].copy_from_slice(&0x80_u32.to_le_bytes());
        let mut counted = bytes.clone();
        for hole in [0x28..0x38, 0xd8..0xdc, 0x128..0x130] {
            counted[hole].fill(0);
        }
        let stamp =
            [STAMP_WORD.as_slice(), &4_000_u32.to_le_bytes(), &crc32fast::hash(&counted).to_le_bytes()].concat();
        bytes[STAMP_AT..STAMP_AT + 16].copy_from_slice(&stamp);
        bytes
    }

    #[test]
    fn any_byte_that_changes_is_seen_but_for_what_a_signature_changes() {
        let whole = stamped();
        assert!(is_whole(&whole));
        for at in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 0x10;
            let is_signatures = (0xd8..0xdc).contains(&at) || (0x128..0x130).contains(&at);
            assert_eq!(is_whole(&damaged), is_signatures, "byte {at}");
        }
        assert!(is_whole(&[&whole[..], b"a signature"].concat()));
        for length in 0..whole.len() {
            assert!(!is_whole(&whole[..length]), "{length} bytes are left");
        }
        assert!(!is_whole(&vec![0; 4_096]));
    }

    #[test]
    fn a_start_file_says_which_system_and_which_root_it_starts() {
        let says = |text: &str| StartFile::read(format!("MZ\0quiet {text} gpt\0").as_bytes());
        let found = says("dreams.version=0.2.0 dreams.root=ab12:40:cd:ef").unwrap();
        assert_eq!((found.version.to_string(), found.blocks), ("0.2.0".to_owned(), 40));
        assert_eq!([found.slot, found.salt, found.hash], ["ab12", "cd", "ef"]);
        for mute in ["", "dreams.version=0.2.0", "dreams.root=a:2:b:c", "dreams.version=1 dreams.root=a:b:c:d"] {
            assert_eq!(says(mute), Err(StartFileError::Mute), "`{mute}`");
        }
        assert!(matches!(says("dreams.version=next dreams.root=a:2:b:c"), Err(StartFileError::Unversioned(_))));
    }
}
