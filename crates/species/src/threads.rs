//! Threads to draw with.
//!
//! Owns the pool and the flag that stops it. Never draws.
//!
//! Start at [`Threads::new`].

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::{ThreadPool, ThreadPoolBuilder};

/// Threads of a renderer's own. How many they are changes no pixel.
#[derive(Debug)]
pub struct Threads {
    pool: ThreadPool,
    stop: Arc<AtomicBool>,
}

/// The system gives no threads.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot start {threads} threads: {reason}")]
pub struct ThreadsError {
    /// How many were asked for; 0 means one per core.
    pub threads: usize,
    /// The system error.
    pub reason: String,
}

impl Threads {
    /// So many threads; 0 takes as many as there are cores.
    ///
    /// # Errors
    /// [`ThreadsError`] if the system refuses them.
    pub fn new(threads: usize) -> Result<Threads, ThreadsError> {
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| ThreadsError { threads, reason: error.to_string() })?;
        Ok(Threads { pool, stop: Arc::default() })
    }

    /// The same threads, which stop within milliseconds once `stop` is set.
    #[must_use]
    pub fn with_stop_flag(self, stop: Arc<AtomicBool>) -> Threads {
        Threads { stop, ..self }
    }

    /// The flag that stops them.
    pub fn stop(&self) -> &AtomicBool {
        &self.stop
    }

    /// Whether they were told to stop.
    pub fn are_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Runs `work` on them: rayon's parallel iterators in it use these threads and no others.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.pool.install(work)
    }
}
