//! The only reader of the clock in the player and the updater.
//!
//! Owns [`now`], and the machine's age and its date; everything else takes the time as an argument. What must not err
//! goes by the first two: a unit's date may jump, or be 1970. None of the three asks `rustix` for a clock: it insists on
//! a vDSO that knows all clocks, and user-mode kernels have none.

use std::sync::LazyLock;
use std::time::{Instant, SystemTime};
use timing::Nanos;

/// Nanoseconds since the first call.
#[expect(clippy::disallowed_methods, reason = "the one place where this program reads the clock")]
pub fn now() -> Nanos {
    static FIRST: LazyLock<Instant> = LazyLock::new(Instant::now);
    let elapsed = Instant::now().saturating_duration_since(*FIRST).as_nanos();
    Nanos(u64::try_from(elapsed).unwrap_or(u64::MAX))
}

/// Seconds since the machine was started, asleep or not.
pub fn up_s() -> u64 {
    u64::try_from(rustix::system::sysinfo().uptime).unwrap_or_default()
}

/// Seconds since 1970, as the machine's clock has it, which may be wrong: `clock.rs` decides whether the time is known.
pub fn clock_s() -> u64 {
    clock_us() / 1_000_000
}

/// The same in microseconds.
#[expect(clippy::disallowed_methods, reason = "the one place where this program reads the clock")]
pub fn clock_us() -> u64 {
    let date = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    date.map_or(0, |date| u64::try_from(date.as_micros()).unwrap_or(u64::MAX))
}
