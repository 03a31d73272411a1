//! Limits on untrusted data.
//!
//! Owns every limit on sizes and counts. Data above a limit is refused before more of it is read. Data within the
//! limits is read in less than 128 MB of memory, half of what a unit has: `tests/it/updates/memory_limits.rs` measures it. Each
//! reader enforces its limits.

/// Bytes of a seal: signature and text.
pub const SEAL: u64 = 16 << 10;
/// Bytes of the owner's file in signed settings, and of every other file of settings.
pub const SETTINGS: u64 = 64 << 10;
/// Units that one seal names.
pub const UNITS: usize = 128;
/// Seals in one folder.
pub const SEALS: usize = 10_000;
/// Bytes of a unit's name.
pub const UNIT_NAME: usize = 64;
/// Bytes of a flock's name in a seal.
pub const FLOCK_NAME: usize = 128;
/// Bytes of the list of files.
pub const CONTENTS: u64 = 4 << 20;
/// Files of a bundle.
pub const FILES: usize = 20_000;
/// Bytes of a file's path.
pub const PATH: usize = 255;
/// Parts of a file's path.
pub const PATH_PARTS: usize = 8;
/// Bytes of a file.
pub const FILE: u64 = 64 << 30;
/// Bytes of all files of a bundle together, counted once for each path.
pub const TOTAL: u64 = 4 << 40;
/// Bytes of `flock.toml`.
pub const FLOCK_TOML: u64 = flock::UNIT_BYTES;
/// Bytes of a `flock.toml`, or of its head, that is not in the plain form and has to be parsed as a TOML document.
pub const FLOCK_DOCUMENT: u64 = flock::UNIT_DOCUMENT_BYTES;
/// Bytes of each half of a system.
pub const SYSTEM: u64 = 1 << 30;
/// Numbers of a system's version.
pub const VERSION: usize = 4;
/// Bytes of a public key's file.
pub const PUBLIC_KEY: u64 = 1 << 10;
/// Bytes of a secret key's file.
pub const SECRET_KEY: u64 = 4 << 10;
/// Bytes of the statements about keys that a bundle carries.
pub const STATEMENTS: u64 = 256 << 10;
/// Bytes of the statements that a unit keeps. Owners' keys may still revoke themselves, and others, beyond it.
pub const LEARNED_STATEMENTS: usize = 384 << 10;
/// Other keys that statements of one owner's key may name.
pub const QUOTA: usize = 64;
/// Other keys that statements of one added key may name.
pub const ADDED_QUOTA: usize = 16;
/// Other keys that statements of all added keys together may name.
pub const SHARED_QUOTA: usize = 64;
/// Keys that a revocation keeps.
pub const KEPT: usize = 8;
/// Revocations of one key by the same signer that keep different keys.
pub const REVISIONS: usize = 2;
/// Keys in a folder of trusted keys.
pub const TRUSTED_KEYS: usize = 64;
/// Bytes of the comment that a signature covers.
pub const COMMENT: usize = 256;
/// Bytes of the state of a store.
pub const STATE: u64 = 1 << 20;
/// Unreadable objects after which the disk counts as failing.
pub const UNREAD: usize = 8;
/// Parts of an object above the file size limit of a file system.
pub const PARTS: u32 = 1000;
