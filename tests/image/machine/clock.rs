//! The one place of these claims that reads the clock.

use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// The time since the claims began. A machine's own clock runs with it, as long as it is not stopped.
#[expect(clippy::disallowed_methods, reason = "the one place where these claims read the clock")]
pub(crate) fn now() -> Duration {
    static BEGAN: LazyLock<Instant> = LazyLock::new(Instant::now);
    BEGAN.elapsed()
}
