//! Files that survive a power cut.
//!
//! Owns the order of the steps: write a new file, sync it, rename it, sync the folder. Every program that replaces a
//! file does it here. Never knows what the files mean.
//!
//! | module | owns |
//! |---|---|
//! | `storage` | what an atomic write needs of a disk, and a folder of this machine |
//! | `atomic` | the atomic write |
//! | `copies` | the newest of two copies of a state, each with a checksum |
//! | `frame` | the form of such a copy: number, state and checksum |
//! | `plain` | reading plain files only |
//! | `lock` | the end of a lock on a file |
//! | `flushed` | writing that stays out of the page cache |
#![forbid(unsafe_code)]

mod atomic;
mod copies;
mod flushed;
mod frame;
mod lock;
mod plain;
mod storage;

pub use atomic::{copy, persist, replace, save, sync_file_systems, sync_folder, sync_names, write, write_with_mode};
pub use copies::{Checksummed, Copies, Found};
pub use flushed::{FlushedWriter, drop_cache};
pub use frame::{framed, unframed};
pub use lock::Locked;
pub use plain::{open_plain, plain, read_all, read_plain, read_plain_text, too_large};
pub use storage::{Append, LocalFolder, Storage, parent};
