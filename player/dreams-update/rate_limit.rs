//! How fast an update may read.
//!
//! Owns a limit of bytes a second, kept on average from the first byte. Never reads a clock: the time comes in.

use std::time::Duration;
use timing::Nanos;

/// How far behind the limit may be made up for: after a pause, no rush.
const BURST: Duration = Duration::from_secs(1);

/// A limit of bytes a second.
#[derive(Clone, Debug)]
pub(crate) struct RateLimit {
    /// `None` for no limit.
    bytes_per_s: Option<u64>,
    /// When the bytes that were read so far are within the limit.
    due: Nanos,
}

impl RateLimit {
    /// So many KiB a second, from `now` on; 0 for no limit.
    pub(crate) fn new(kib_per_s: u64, now: Nanos) -> Self {
        Self { bytes_per_s: (kib_per_s > 0).then_some(kib_per_s << 10), due: now }
    }

    /// How long to wait after `bytes` were read, at `now`.
    pub(crate) fn after(&mut self, bytes: u64, now: Nanos) -> Duration {
        let Some(rate) = self.bytes_per_s else { return Duration::ZERO };
        let cost = u128::from(bytes) * 1_000_000_000 / u128::from(rate);
        let burst = u64::try_from(BURST.as_nanos()).unwrap_or(u64::MAX);
        let begun = self.due.0.max(now.0.saturating_sub(burst));
        self.due = Nanos(begun.saturating_add(u64::try_from(cost).unwrap_or(u64::MAX)));
        Duration::from_nanos(self.due.0.saturating_sub(now.0))
    }
}

#[cfg(test)]
mod tests {
    use super::RateLimit;
    use std::time::Duration;
    use timing::Nanos;

    const SECOND: u64 = 1_000_000_000;

    #[test]
    fn the_limit_is_kept_on_average_and_a_pause_is_not_made_up_for() {
        let mut rate_limit = RateLimit::new(100, Nanos(0));
        let mut now = 0;
        for _ in 0..50 {
            let wait = rate_limit.after(64 << 10, Nanos(now));
            now += u64::try_from(wait.as_nanos()).unwrap();
        }
        assert_eq!(now, 32 * SECOND, "50 times 64 KiB at 100 KiB a second");
        now += 3_600 * SECOND;
        assert_eq!(rate_limit.after(100 << 10, Nanos(now)), Duration::ZERO);
        assert_eq!(rate_limit.after(100 << 10, Nanos(now)), Duration::from_secs(1));
    }

    #[test]
    fn without_a_limit_nobody_waits() {
        let mut rate_limit = RateLimit::new(0, Nanos(0));
        assert_eq!(rate_limit.after(u64::MAX, Nanos(0)), Duration::ZERO);
    }
}
