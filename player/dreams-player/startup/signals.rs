//! The signals that end a run.
//!
//! Owns the flag that they raise, and that a run ends within the second that is promised. Owns the interval of systemd's
//! watchdog, too. Never ends a run itself before [`GRACE`] is over.

use crate::fatal::Fatal;
use diagnostics::Exit;
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// How long a run may take to end after a signal.
const GRACE: Duration = Duration::from_millis(850);
/// How often the watchdog is fed in the time that it allows.
const WATCHDOG_PINGS: u32 = 3;

/// A flag that SIGINT, SIGTERM and SIGHUP raise. A run that has not ended [`GRACE`] later waits for a disk or a reader
/// that does not answer, and is ended: the place was kept at the last join, and the trace is whole as far as it was read.
pub(crate) fn stop_on_signals() -> Result<Arc<AtomicBool>, Fatal> {
    let stop = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&stop);
    let end = move || {
        raised.store(true, Ordering::Relaxed);
        thread::park_timeout(GRACE);
        process::exit(Exit::Fine as i32);
    };
    ctrlc::set_handler(end).map_err(Fatal::Signals)?;
    Ok(stop)
}

/// How often systemd's watchdog is fed; `None` where there is none.
pub(crate) fn watchdog_interval() -> Option<Duration> {
    sd_notify::watchdog_enabled().map(|allowed| allowed / WATCHDOG_PINGS)
}
