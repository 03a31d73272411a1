//! Locks whose value is whole whatever became of the thread that had it.
//!
//! Owns one function. Never waits for anything else.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// The value behind `mutex`. A thread that panicked while it had it has left it whole.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
