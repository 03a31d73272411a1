//! The recovery policy after a failed commit or a lost event.
//!
//! Pure functions from an error to a recovery step; `recovery.rs` executes it.
//!
//! | step | when |
//! |---|---|
//! | continue | only the event was lost |
//! | retry at the next vblank | the kernel is busy or short of memory, and the watchdog has not timed out |
//! | blocking commit with a modeset | the flip did not happen, or commits failed until the watchdog timed out |
//! | next candidate | the kernel rejects this plane, format or mode, or its flips fail repeatedly |
//! | reopen the card | the blocking commit failed |
//! | stay dark, and retry with growing pauses | another process is DRM master, or the card or display is gone |

use rustix::io::Errno;
use std::io;
use std::time::Duration;

/// The meaning of a commit's error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CommitError {
    /// Too early, or short of memory: a retry may succeed.
    Busy,
    /// The card is no more.
    Gone,
    /// Another process is master.
    NotMaster,
    /// This will never work in this way.
    Refused,
    /// The driver failed.
    Broken,
}

impl CommitError {
    /// Classifies the error of a commit.
    pub(crate) fn of(error: &io::Error) -> Self {
        match error.raw_os_error().map(Errno::from_raw_os_error) {
            Some(Errno::BUSY | Errno::AGAIN | Errno::NOMEM | Errno::INTR) => Self::Busy,
            Some(Errno::ACCESS | Errno::PERM) => Self::NotMaster,
            Some(Errno::INVAL | Errno::RANGE | Errno::NOSPC | Errno::NOENT | Errno::OPNOTSUPP) => Self::Refused,
            Some(Errno::NODEV | Errno::NXIO | Errno::BADF) => Self::Gone,
            _ => Self::Broken,
        }
    }
}

/// The next step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RecoveryStep {
    /// Retry at the next vblank.
    Again,
    /// Commit the pending picture again, blocking, with a modeset if necessary.
    Relight,
    /// Choose another candidate.
    OtherWay,
    /// Close the card, open it again and start over.
    Reopen,
    /// Stay dark until the other process gives up DRM master.
    AwaitMaster,
    /// Stay dark until the card is back.
    AwaitCard,
}

/// How many flips in a row may fail before another candidate is chosen.
const MAX_RELIGHTS: u32 = 3;

/// After a flip was refused.
///
/// * `timed_out` — the watchdog's time is over.
/// * `in_a_row` — how many flips failed before this one, without a new picture in between.
pub(crate) fn flip_failed(trouble: CommitError, timed_out: bool, in_a_row: u32) -> RecoveryStep {
    match (trouble, timed_out) {
        (CommitError::Busy | CommitError::Broken, false) => RecoveryStep::Again,
        (CommitError::Busy | CommitError::Broken, true) => relight(in_a_row),
        (CommitError::Refused, _) if in_a_row >= MAX_RELIGHTS => RecoveryStep::OtherWay,
        (CommitError::Refused, _) => RecoveryStep::Relight,
        (CommitError::NotMaster, _) => RecoveryStep::AwaitMaster,
        (CommitError::Gone, _) => RecoveryStep::AwaitCard,
    }
}

/// After a blocking commit was rejected.
pub(crate) fn light_failed(trouble: CommitError, timed_out: bool) -> RecoveryStep {
    match (trouble, timed_out) {
        (CommitError::Busy, false) => RecoveryStep::Again,
        (CommitError::Busy, true) | (CommitError::Broken, _) => RecoveryStep::Reopen,
        (CommitError::Refused, _) => RecoveryStep::OtherWay,
        (CommitError::NotMaster, _) => RecoveryStep::AwaitMaster,
        (CommitError::Gone, _) => RecoveryStep::AwaitCard,
    }
}

/// After a flip's event did not arrive: `None` if only the event is missing.
///
/// * `moved` — vblanks have passed since. `current` — the plane's properties show our framebuffer.
/// * `in_a_row` — as for [`flip_failed`].
pub(crate) fn flip_overdue(moved: bool, current: bool, in_a_row: u32) -> Option<RecoveryStep> {
    if moved && current && in_a_row == 0 { None } else { Some(relight(in_a_row)) }
}

fn relight(in_a_row: u32) -> RecoveryStep {
    if in_a_row < MAX_RELIGHTS { RecoveryStep::Relight } else { RecoveryStep::Reopen }
}

/// How long the watchdog waits for an event that is due after `period`: four vblanks, and never less than 100 ms.
pub(crate) fn patience(period: Duration) -> Duration {
    (period * 4).max(Duration::from_millis(100))
}

/// The pause before try number `tries` to light a dark screen: 100 ms, doubling up to 1 s.
pub(crate) fn pause(tries: u32) -> Duration {
    Duration::from_millis(100 << tries.min(4)).min(Duration::from_secs(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trouble(errno: Errno) -> CommitError {
        CommitError::of(&errno.into())
    }

    #[test]
    fn the_watchdog_waits_four_vblanks_and_at_least_a_tenth_of_a_second() {
        assert_eq!(patience(Duration::from_millis(10)), Duration::from_millis(100));
        assert_eq!(patience(Duration::from_millis(40)), Duration::from_millis(160));
    }

    #[test]
    fn a_dark_screen_is_tried_at_growing_pauses_of_at_most_a_second() {
        let pauses: Vec<_> = (0..7).map(|tries| pause(tries).as_millis()).collect();
        assert_eq!(pauses, [100, 200, 400, 800, 1000, 1000, 1000]);
        assert_eq!(pause(u32::MAX), Duration::from_secs(1));
    }

    #[test]
    fn a_lost_event_is_forgiven_once() {
        assert_eq!(flip_overdue(true, true, 0), None);
        assert_eq!(flip_overdue(true, true, 1), Some(RecoveryStep::Relight));
        assert_eq!(flip_overdue(false, true, 0), Some(RecoveryStep::Relight));
        assert_eq!(flip_overdue(true, false, 0), Some(RecoveryStep::Relight));
        assert_eq!(flip_overdue(true, true, 3), Some(RecoveryStep::Reopen));
    }

    #[test]
    fn a_way_that_can_be_lit_and_never_flipped_is_left() {
        assert_eq!(flip_failed(trouble(Errno::INVAL), false, 0), RecoveryStep::Relight);
        assert_eq!(flip_failed(trouble(Errno::INVAL), false, 3), RecoveryStep::OtherWay);
        assert_eq!(flip_failed(trouble(Errno::IO), true, 3), RecoveryStep::Reopen);
    }

    #[test]
    fn another_master_is_waited_for_and_never_fought() {
        for errno in [Errno::ACCESS, Errno::PERM] {
            for timed_out in [false, true] {
                assert_eq!(flip_failed(trouble(errno), timed_out, 0), RecoveryStep::AwaitMaster);
                assert_eq!(light_failed(trouble(errno), timed_out), RecoveryStep::AwaitMaster);
            }
        }
    }

    #[test]
    fn a_busy_kernel_is_asked_again_until_the_watchdog_barks() {
        assert_eq!(flip_failed(trouble(Errno::BUSY), false, 0), RecoveryStep::Again);
        assert_eq!(flip_failed(trouble(Errno::BUSY), true, 0), RecoveryStep::Relight);
        assert_eq!(light_failed(trouble(Errno::BUSY), false), RecoveryStep::Again);
        assert_eq!(light_failed(trouble(Errno::BUSY), true), RecoveryStep::Reopen);
    }
}
