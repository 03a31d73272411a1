//! How work that takes a flag to stop follows a job that may be cancelled.
//!
//! Owns the thread that carries the one to the other: a renderer looks at its flag between few samples, and sets it itself
//! when it fails, which must not pass for a cancelled job. Never cancels a job.
//!
//! Start at [`with_flag`].

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use operations::program::now;

use super::MediaError;
use crate::jobs::Progress;

/// The longest time until a cancelled job stops.
const LOOK: Duration = Duration::from_millis(50);

/// Runs `work` with a flag that is set once the job of `progress` is cancelled.
pub(super) fn with_flag<T>(progress: &Progress, work: impl FnOnce(&Arc<AtomicBool>) -> T) -> T {
    let (flag, over) = (Arc::new(AtomicBool::new(false)), AtomicBool::new(false));
    thread::scope(|scope| {
        scope.spawn(|| {
            while !over.load(Ordering::Relaxed) {
                flag.fetch_or(progress.is_cancelled(), Ordering::Relaxed);
                now::pause(LOOK, &over);
            }
        });
        let _over = RaisedAtEnd(&over);
        work(&flag)
    })
}

/// Errors: [`MediaError::Cancelled`] if the job is cancelled. Waits while it is held.
pub(super) fn go_on(progress: &Progress) -> Result<(), MediaError> {
    progress.wait_if_paused();
    if progress.is_cancelled() { Err(MediaError::Cancelled) } else { Ok(()) }
}

/// Ends the thread also where the work panics.
struct RaisedAtEnd<'a>(&'a AtomicBool);

impl Drop for RaisedAtEnd<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cancelled_job_raises_the_flag_and_another_does_not() {
        let progress = Progress::detached();
        assert!(!with_flag(&progress, |flag| flag.load(Ordering::Relaxed)));
        let waited = with_flag(&progress, |flag| {
            progress.cancel();
            now::pause(Duration::from_secs(10), flag);
            flag.load(Ordering::Relaxed)
        });
        assert!(waited);
        assert!(matches!(go_on(&progress), Err(MediaError::Cancelled)));
    }
}
