//! The only reader of the clock in the player and the updater.
//!
//! Owns [`now`]; everything else takes the time as an argument. Monotonic: a unit's date may jump.

use std::sync::LazyLock;
use std::time::Instant;
use timing::Nanos;

/// Nanoseconds since the first call. By the standard library and not `rustix`, which insists on a vDSO that knows
/// the clock: user-mode kernels have none.
#[expect(clippy::disallowed_methods, reason = "the one place where this program reads the clock")]
pub fn now() -> Nanos {
    static FIRST: LazyLock<Instant> = LazyLock::new(Instant::now);
    let elapsed = Instant::now().saturating_duration_since(*FIRST).as_nanos();
    Nanos(u64::try_from(elapsed).unwrap_or(u64::MAX))
}
