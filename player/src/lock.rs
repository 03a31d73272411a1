//! Locks that survive a panic.
//!
//! Owns that a thread that panicked while it held a lock does not take the others with it: what it guards is whole after
//! every statement. Never waits for long: nobody holds one beyond a copy.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Locks `mutex`, also if a thread panicked that held it.
pub fn hold<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
