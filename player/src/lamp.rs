//! The lamp: a thread that sees to it that the picture is as bright as the hour wants it.
//!
//! Owns when it looks: every second. What the hour wants is `hours.rs`; the flip thread takes it from the glass and tells
//! the screen. Never touches a screen.
//!
//! Start at [`start`].

use crate::glass::Glass;
use crate::hours::Day;
use crate::report::Fatal;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

/// Between two looks.
const OFTEN: Duration = Duration::from_secs(1);

/// Makes `glass` as bright as `day` wants it at `clock`, now and for as long as the process lives.
///
/// # Errors
/// [`Fatal`] if the thread cannot be started.
pub(crate) fn start(day: Day, glass: Arc<Glass>, clock: fn() -> u64) -> Result<(), Fatal> {
    glass.set_light(day.light(clock()));
    let work = move || {
        loop {
            thread::park_timeout(OFTEN);
            glass.set_light(day.light(clock()));
        }
    };
    let thread = thread::Builder::new().name("lamp".to_owned()).spawn(work);
    thread.map(drop).map_err(|source| Fatal::Thread { name: "lamp", source })
}
