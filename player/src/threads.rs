//! Threads with a name, which the kernel shows in its lists.
//!
//! Owns the error of one that cannot be started. Never decides what a thread does.

use std::io;
use std::thread::{Builder, JoinHandle};

/// A thread cannot be started.
#[derive(Debug, thiserror::Error)]
#[error("cannot start the {name} thread")]
pub struct ThreadError {
    name: &'static str,
    source: io::Error,
}

/// Starts a thread called `name` that does `work`.
///
/// # Errors
/// [`ThreadError`], if the machine is out of threads or memory.
pub fn start<T: Send + 'static>(
    name: &'static str,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<JoinHandle<T>, ThreadError> {
    Builder::new().name(name.to_owned()).spawn(work).map_err(|source| ThreadError { name, source })
}
