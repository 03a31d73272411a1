//! The clock of these claims, read in one place.

use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// The time since the first call. A machine's own clock runs with it while it is not stopped.
#[expect(clippy::disallowed_methods, reason = "the one place where these claims read the clock")]
pub(crate) fn now() -> Duration {
    static BEGAN: LazyLock<Instant> = LazyLock::new(Instant::now);
    BEGAN.elapsed()
}
