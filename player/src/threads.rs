//! Threads with a name, and the locks between them.
//!
//! Owns the error of a thread that cannot be started, and that one which panicked while it held a lock does not take the
//! others with it. Never decides what a thread does.

use std::io;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};

/// A thread cannot be started.
#[derive(Debug, thiserror::Error)]
#[error("cannot start the {name} thread")]
pub struct ThreadError {
    name: &'static str,
    source: io::Error,
}

/// Starts a thread called `name` that does `work`.
/// Errors: [`ThreadError`], if the machine is out of threads or memory.
pub fn start<T: Send + 'static>(
    name: &'static str,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<JoinHandle<T>, ThreadError> {
    Builder::new().name(name.to_owned()).spawn(work).map_err(|source| ThreadError { name, source })
}

/// Locks `mutex`, also if a thread panicked that held it: what it guards is whole after every statement.
pub fn hold<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
