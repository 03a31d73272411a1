//! The options that all commands which render share.
//!
//! Owns their words, ranges and defaults. Never renders.

use std::fs;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use crate::report::{Exit, Fatal};

/// What a machine lacks to render.
#[derive(Debug, thiserror::Error)]
enum Lack {
    #[error("a frame takes {needed} MB of memory, and {free} MB are free")]
    Memory { needed: u64, free: u64 },
    #[error("cannot listen to signals")]
    Signals { source: ctrlc::Error },
}

/// As many threads as there are cores.
pub(crate) fn cores() -> NonZeroUsize {
    thread::available_parallelism().unwrap_or(NonZeroUsize::MIN)
}

/// Samples per pixel.
pub(crate) fn samples(text: &str) -> Result<f64, String> {
    within(text, 0.01, 1e7)
}

/// x264's constant rate factor.
pub(crate) fn rate_factor(text: &str) -> Result<f32, String> {
    within(text, 0.1, 51.0).map(|number| number as f32)
}

/// A flag that SIGINT, SIGTERM or SIGHUP sets.
pub(crate) fn stop_on_signals() -> Result<Arc<AtomicBool>, Fatal> {
    let stop = Arc::new(AtomicBool::new(false));
    let heard = Arc::clone(&stop);
    ctrlc::set_handler(move || heard.store(true, Ordering::Relaxed))
        .map_err(|source| Fatal::new(Exit::Unreadable, Lack::Signals { source }))?;
    Ok(stop)
}

/// How many frames of `bytes` each can be rendered at once in the memory that is free: `threads` at most.
pub(crate) fn at_once(threads: NonZeroUsize, bytes: u64) -> Result<NonZeroUsize, Fatal> {
    let Some(free) = fs::read_to_string("/proc/meminfo").ok().and_then(|text| available(&text)) else {
        return Ok(threads);
    };
    // A twentieth is left to others.
    let room = free / 20 * 19 / bytes.max(1);
    let fitting = NonZeroUsize::new(usize::try_from(room).unwrap_or(usize::MAX));
    let lack = || Fatal::new(Exit::Unreadable, Lack::Memory { needed: bytes / 1_000_000, free: free / 1_000_000 });
    Ok(fitting.ok_or_else(|| lack().hint("smaller with --supersample 1"))?.min(threads))
}

fn within(text: &str, least: f64, most: f64) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (least..=most).contains(number));
    number.ok_or_else(|| format!("wanted a number from {least} to {most}"))
}

/// Bytes of memory that are free by the text of `/proc/meminfo`.
fn available(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix(" kB")?.parse::<u64>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_memory_is_read_as_the_kernel_tells_it() {
        let text = "MemTotal:       24576 kB\nMemFree: 1 kB\nMemAvailable:    2000 kB\n";
        assert_eq!(available(text), Some(2_048_000));
        assert_eq!(available("MemTotal: 3 kB\n"), None);
    }

    #[test]
    fn what_does_not_fit_into_memory_is_not_begun() {
        let threads = NonZeroUsize::new(64).unwrap();
        assert_eq!(at_once(threads, 1).unwrap(), threads);
        assert!(at_once(threads, u64::MAX / 2).is_err());
    }

    #[test]
    fn numbers_outside_their_ranges_are_refused() {
        for bad in ["0", "-1", "NaN", "inf", "1e9", ""] {
            assert!(samples(bad).is_err(), "{bad}");
            assert!(rate_factor(bad).is_err(), "{bad}");
        }
    }
}
