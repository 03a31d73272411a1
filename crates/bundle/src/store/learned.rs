//! What a store has learned about keys, for a program that may only read it.
//!
//! Owns that one question. Never locks, writes or repairs: an updater may be at work.
//!
//! Start at [`with_learned`].

use std::io;
use std::path::Path;

use durable::{Copies, Found};

use crate::store::disk::LocalDisk;
use crate::store::state::State;
use crate::store::{StoreError, at, trust_from};
use crate::trust::Trust;

/// The keys in `pinned`, with those that they have added and without those that were revoked, as far as the store at the
/// path `store` knows of it. Of a store that is not there it is `pinned`.
///
/// # Errors
/// [`StoreError::Disk`] if the store cannot be read, or both copies of its state are damaged: a revoked key could pass.
pub fn with_learned(pinned: &Trust, store: &Path) -> Result<Trust, StoreError> {
    let failed = |source| at("read the state of", &store.display().to_string())(source);
    let disk = match LocalDisk::open_shared(store) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(pinned.clone()),
        disk => disk.map_err(failed)?,
    };
    match Copies::<State>::read(&disk).1 {
        Found::Nothing => Ok(pinned.clone()),
        Found::State { state, .. } => Ok(trust_from(pinned, &state.statements)),
        Found::Damaged => Err(failed(io::Error::new(io::ErrorKind::InvalidData, "both copies are damaged"))),
        Found::Unreadable(source) => Err(failed(source)),
    }
}
