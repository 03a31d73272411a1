//! The memory and threads that rendering may take of this machine, and the signals that end it.
//!
//! Owns how much is free. Never renders.
//!
//! Start at [`frames_at_once`].

use std::fs;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use rustix::process::{Resource, getrlimit};

use crate::program::{Exit, Fatal};

/// Where control groups are found.
const GROUPS: &str = "/sys/fs/cgroup";

/// Why this machine cannot render.
#[derive(Debug, thiserror::Error)]
enum MachineError {
    #[error("a frame takes {needed} MB of memory, and {free} MB are free")]
    Memory { needed: u64, free: u64 },
    #[error("cannot install a signal handler")]
    Signals { source: ctrlc::Error },
}

/// The number of cores.
pub fn cores() -> NonZeroUsize {
    thread::available_parallelism().unwrap_or(NonZeroUsize::MIN)
}

/// A flag that SIGINT, SIGTERM or SIGHUP sets.
pub fn stop_on_signals() -> Result<Arc<AtomicBool>, Fatal> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed))
        .map_err(|source| Fatal::new(Exit::Unreadable, MachineError::Signals { source }))?;
    Ok(stop)
}

/// How many frames of `bytes` each can be rendered at once in the memory that is free: `threads` at most.
/// Errors: [`Fatal`] where there is no room for one.
pub fn frames_at_once(threads: NonZeroUsize, bytes: u64) -> Result<NonZeroUsize, Fatal> {
    room(threads, bytes, bytes, free())
}

/// How many threads can render one frame that takes `bytes`, and `more` for each thread more, in the memory that is free:
/// `threads` at most.
/// Errors: [`Fatal`] where there is no room for one.
pub fn threads_that_fit(threads: NonZeroUsize, bytes: u64, more: u64) -> Result<NonZeroUsize, Fatal> {
    room(threads, bytes, more, free())
}

/// How many fit into `free` bytes where the first takes `first` and every other one `next`: `most` at most.
fn room(most: NonZeroUsize, first: u64, next: u64, free: Option<u64>) -> Result<NonZeroUsize, Fatal> {
    let Some(free) = free else { return Ok(most) };
    // A twentieth is left to other programs.
    let Some(rest) = (free / 20 * 19).checked_sub(first) else {
        let error = MachineError::Memory { needed: first / 1_000_000, free: free / 1_000_000 };
        return Err(Fatal::new(Exit::Unreadable, error).hint("a smaller size or --supersample takes less"));
    };
    let more = usize::try_from(rest / next.max(1)).unwrap_or(usize::MAX);
    Ok(most.min(NonZeroUsize::MIN.saturating_add(more)))
}

/// Bytes of memory that this process may still take, by the kernel: of the machine, of its control groups (a container's or
/// a batch job's) and of its own limit.
fn free() -> Option<u64> {
    let machine = fs::read_to_string("/proc/meminfo").ok().and_then(|text| available(&text));
    let own = getrlimit(Resource::As).current;
    let groups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let group = Path::new(group(&groups)).ancestors().filter_map(|group| {
        let file = |name| fs::read_to_string(Path::new(GROUPS).join(group).join(name)).ok();
        allowance(&file("memory.max")?, &file("memory.stat")?)
    });
    group.chain(machine).chain(own).min()
}

/// The control group of this process by the text of `/proc/self/cgroup`, relative to [`GROUPS`].
fn group(text: &str) -> &str {
    text.lines().find_map(|line| line.strip_prefix("0::/")).unwrap_or_default()
}

/// Bytes that a control group leaves by the texts of its `memory.max` and `memory.stat`: what it holds of files can be
/// dropped. `None` where it has no limit.
fn allowance(most: &str, stat: &str) -> Option<u64> {
    let held = stat.lines().find_map(|line| line.strip_prefix("anon "))?.parse().ok()?;
    Some(most.trim().parse::<u64>().ok()?.saturating_sub(held))
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
    fn a_control_group_leaves_its_limit_less_what_it_holds_of_memory() {
        assert_eq!(allowance("5000\n", "anon 1200\nfile 3000\n"), Some(3800));
        assert_eq!(allowance("1000\n", "anon 1200\n"), Some(0));
        assert_eq!(allowance("max\n", "anon 1200\n"), None);
        assert_eq!(group("12:memory:/old\n0::/slice/job\n"), "slice/job");
        assert_eq!(group("0::/\n"), "");
        assert!(free() > Some(0));
    }

    #[test]
    fn what_does_not_fit_into_memory_is_not_begun() {
        let many = NonZeroUsize::new(64).unwrap();
        let fit = |first, next| room(many, first, next, Some(1_000)).ok().map(NonZeroUsize::get);
        assert_eq!([fit(950, 1_000), fit(950, 0), fit(350, 200), fit(0, 1)], [Some(1), Some(1), Some(4), Some(64)]);
        assert_eq!(fit(951, 1), None);
        assert_eq!(room(many, 1, 1, None).unwrap(), many);
    }
}
