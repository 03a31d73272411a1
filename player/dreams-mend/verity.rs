//! Whether a slot holds the root that a start file was made with, bit by bit.
//!
//! Owns the form of a slot: the blocks of the root, a superblock, and the tree of hashes, as `veritysetup format` writes
//! them and the kernel's dm-verity reads them. Never writes.
//!
//! # Source
//! The kernel's `Documentation/admin-guide/device-mapper/verity.rst`, and the `DMVerity` format of cryptsetup's wiki.

use bundle::StartFile;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;

/// Bytes of a block, of the root and of its tree.
pub(crate) const BLOCK: usize = 4096;
const HASH: usize = 32;
/// How much is read at once.
const BLOCKS_AT_ONCE: usize = 256;
const SUPERBLOCK: usize = 512;

/// A root as its start file describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Root {
    name: [u8; 16],
    blocks: u64,
    salt: Vec<u8>,
    hash: [u8; HASH],
}

impl Root {
    /// `None` if `file` does not describe one.
    pub(crate) fn of(file: &StartFile) -> Option<Self> {
        Some(Self {
            name: from_hex(&file.slot)?.try_into().ok()?,
            blocks: file.blocks,
            salt: from_hex(&file.salt).filter(|salt| salt.len() <= 256)?,
            hash: from_hex(&file.hash)?.try_into().ok()?,
        })
    }

    /// Bytes of a slot that are used.
    pub(crate) fn size(&self) -> u64 {
        let tree: u64 = self.levels().iter().sum();
        (self.blocks + 1 + tree) * BLOCK as u64
    }

    /// Where its superblock begins in a slot, in bytes. A slot without one is never started.
    pub(crate) fn superblock_at(&self) -> u64 {
        self.blocks * BLOCK as u64
    }

    /// Whether the superblock in `slot` bears its name. One that cannot be read bears none.
    pub(crate) fn is_named_in(&self, slot: &File) -> io::Result<bool> {
        let mut found = [0; 16];
        let read = slot.read_exact_at(&mut found, self.superblock_at() + 16);
        damaged_is_false(read.map(|()| found == self.name))
    }

    /// Whether every bit of it is in `slot`. A block that cannot be read is damaged.
    pub(crate) fn is_whole_in(&self, slot: &File) -> io::Result<bool> {
        damaged_is_false(self.verify(slot))
    }

    fn verify(&self, slot: &File) -> io::Result<bool> {
        let mut superblock = [0; SUPERBLOCK];
        slot.read_exact_at(&mut superblock, self.superblock_at())?;
        if superblock != self.superblock() {
            return Ok(false);
        }
        let mut hashes = self.hashes(slot, 0, self.blocks)?;
        // The tree begins with its root: the level of the data's own hashes is the last.
        let levels = self.levels();
        for (level, count) in levels.iter().enumerate() {
            hashes.resize(*count as usize * BLOCK, 0);
            let above: u64 = levels[level + 1..].iter().sum();
            let at = self.blocks + 1 + above;
            if !is_found(slot, at, &hashes)? {
                return Ok(false);
            }
            hashes = hashes.chunks(BLOCK).flat_map(|block| self.digest(block)).collect();
        }
        Ok(hashes == self.hash)
    }

    /// How many blocks each level of the tree has, from the hashes of the data to the one block at the top.
    fn levels(&self) -> Vec<u64> {
        let per_block = (BLOCK / HASH) as u64;
        let mut levels = vec![self.blocks.div_ceil(per_block)];
        while levels[levels.len() - 1] > 1 {
            levels.push(levels[levels.len() - 1].div_ceil(per_block));
        }
        levels
    }

    /// The hashes of so many blocks of `slot`, one behind the other.
    fn hashes(&self, slot: &File, from: u64, blocks: u64) -> io::Result<Vec<u8>> {
        let mut hashes = Vec::with_capacity(blocks as usize * HASH);
        let mut buffer = vec![0; BLOCKS_AT_ONCE * BLOCK];
        let mut at = from;
        while at < from + blocks {
            let count = BLOCKS_AT_ONCE.min((from + blocks - at) as usize);
            let read = &mut buffer[..count * BLOCK];
            slot.read_exact_at(read, at * BLOCK as u64)?;
            hashes.extend(read.chunks(BLOCK).flat_map(|block| self.digest(block)));
            at += count as u64;
        }
        Ok(hashes)
    }

    fn digest(&self, block: &[u8]) -> [u8; HASH] {
        Sha256::new().chain_update(&self.salt).chain_update(block).finalize().into()
    }

    fn superblock(&self) -> [u8; SUPERBLOCK] {
        let mut bytes = [0; SUPERBLOCK];
        let mut put = |at: usize, what: &[u8]| bytes[at..at + what.len()].copy_from_slice(what);
        put(0, b"verity\0\0");
        put(8, &1_u32.to_le_bytes());
        // The salt comes before the data.
        put(12, &1_u32.to_le_bytes());
        put(16, &self.name);
        put(32, b"sha256");
        put(64, &(BLOCK as u32).to_le_bytes());
        put(68, &(BLOCK as u32).to_le_bytes());
        put(72, &self.blocks.to_le_bytes());
        put(80, &(self.salt.len() as u16).to_le_bytes());
        put(88, &self.salt);
        bytes
    }
}

/// What was found; no, if the disk does not give it back.
fn damaged_is_false(found: io::Result<bool>) -> io::Result<bool> {
    let is_damage = |error: &io::Error| {
        error.kind() == io::ErrorKind::UnexpectedEof
            || error.raw_os_error() == Some(rustix::io::Errno::IO.raw_os_error())
    };
    found.or_else(|error| if is_damage(&error) { Ok(false) } else { Err(error) })
}

/// Whether these bytes stand in `slot` from the block `at` on.
fn is_found(slot: &File, at: u64, bytes: &[u8]) -> io::Result<bool> {
    let mut found = vec![0; BLOCKS_AT_ONCE * BLOCK];
    for (number, wanted) in bytes.chunks(found.len()).enumerate() {
        let found = &mut found[..wanted.len()];
        slot.read_exact_at(found, (at + (number * BLOCKS_AT_ONCE) as u64) * BLOCK as u64)?;
        if found != wanted {
            return Ok(false);
        }
    }
    Ok(true)
}

fn from_hex(text: &str) -> Option<Vec<u8>> {
    let digit = |byte: u8| char::from(byte).to_digit(16).map(|digit| digit as u8);
    let pair = |pair: &[u8]| Some(digit(pair[0])? << 4 | digit(*pair.get(1)?)?);
    text.as_bytes().chunks(2).map(pair).collect()
}
