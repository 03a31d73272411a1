//! The only place where the artist's tools read clocks.
//!
//! Owns [`Stopwatch`], and the date in a bundle, which is for people to read. Nothing that the tools make depends on the
//! date.

use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime};

use rustix::event::poll;
use rustix::time::{ClockId, Timespec, clock_gettime};

/// Measures wall-clock and processor time.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    wall: Instant,
    cpu: Duration,
}

impl Stopwatch {
    /// Starts now.
    #[expect(clippy::disallowed_methods, reason = "the one place where this program reads the clock")]
    pub fn start() -> Self {
        Self { wall: Instant::now(), cpu: cpu() }
    }

    /// Since the start.
    pub fn wall(&self) -> Duration {
        self.wall.elapsed()
    }

    /// Processor time of all threads of this process since the start.
    pub fn cpu(&self) -> Duration {
        cpu().saturating_sub(self.cpu)
    }
}

/// The time, to the second, as `2026-03-01T12:00:00Z`.
#[expect(clippy::disallowed_methods, reason = "the one place where this program reads the clock")]
pub fn date() -> String {
    /// The last second that has four digits of year.
    const LAST: u64 = 253_402_300_799;
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    let seconds = Duration::from_secs(since.as_secs().min(LAST));
    humantime::format_rfc3339_seconds(SystemTime::UNIX_EPOCH + seconds).to_string()
}

/// Today, in whole days since 1 January 1970.
#[expect(clippy::disallowed_methods, reason = "the one place where this program reads the clock")]
pub fn day() -> u32 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    u32::try_from(since.as_secs() / votes::DAY_S).unwrap_or(u32::MAX)
}

/// Now, in milliseconds since 1 January 1970.
#[expect(clippy::disallowed_methods, reason = "the one place where this program reads the clock")]
pub fn since_1970_ms() -> u64 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_millis()).unwrap_or(u64::MAX)
}

/// Now, as files have it.
#[expect(clippy::disallowed_methods, reason = "the one place where this program reads the clock")]
pub fn system() -> SystemTime {
    SystemTime::now()
}

/// The time since it was asked for first.
pub fn since_start() -> Duration {
    static START: LazyLock<Stopwatch> = LazyLock::new(Stopwatch::start);
    START.wall()
}

/// Waits for the time `wait`, or until `stop` is set.
pub fn pause(wait: Duration, stop: &AtomicBool) {
    let tick = Timespec { tv_sec: 0, tv_nsec: 50_000_000 };
    let watch = Stopwatch::start();
    while watch.wall() < wait && !stop.load(Ordering::Relaxed) {
        // A signal ends the tick early.
        let _ = poll(&mut [], Some(&tick));
    }
}

/// Processor time of the calling thread since it began.
pub fn thread_cpu() -> Duration {
    duration(clock_gettime(ClockId::ThreadCPUTime))
}

fn cpu() -> Duration {
    duration(clock_gettime(ClockId::ProcessCPUTime))
}

fn duration(Timespec { tv_sec, tv_nsec }: Timespec) -> Duration {
    let part = |number: i64| u64::try_from(number).unwrap_or(0);
    Duration::from_secs(part(tv_sec)) + Duration::from_nanos(part(tv_nsec))
}
