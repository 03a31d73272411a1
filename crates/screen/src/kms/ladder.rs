//! What to do about trouble.
//!
//! Owns the recovery ladder, as pure functions: what failed, and how, gives what to do. Never acts; `recovery.rs` does.
//!
//! | rung | when |
//! |---|---|
//! | go on | the event was lost, the picture is there |
//! | try again at the next vblank | the kernel was busy or short of memory, and the watchdog has not barked |
//! | light it anew, waiting | the flip did not happen, or the next one failed for longer than the watchdog waits |
//! | try another way | the kernel refuses this plane, format or mode, or its flips again and again |
//! | reopen the card | lighting it anew failed |
//! | stay dark, and try with growing pauses | another process is master, the card or the display is gone |

use rustix::io::Errno;
use std::io;
use std::time::Duration;

/// What an error means to us.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trouble {
    /// Too early, or short of memory: the same may work in a moment.
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

impl Trouble {
    /// What `error` of a commit means.
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

/// What to do next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rung {
    /// The same again at the next vblank.
    Again,
    /// The pending picture once more, waiting until it is on the glass, with a mode set if need be.
    Relight,
    /// This way is closed: choose another.
    OtherWay,
    /// Close the card, open it, build everything anew.
    Reopen,
    /// Stay dark until another process lets go of the card.
    AwaitMaster,
    /// Stay dark until the card is back.
    AwaitCard,
}

/// How many flips in a row may go wrong before lighting anew is no cure.
const RELIT_IN_A_ROW: u32 = 3;

/// After a flip was refused.
///
/// * `barked` — the watchdog has waited long enough for it.
/// * `in_a_row` — how many flips went wrong before this one, without one that brought another picture.
pub(crate) fn flip_failed(trouble: Trouble, barked: bool, in_a_row: u32) -> Rung {
    match (trouble, barked) {
        (Trouble::Busy | Trouble::Broken, false) => Rung::Again,
        (Trouble::Busy | Trouble::Broken, true) => relight(in_a_row),
        (Trouble::Refused, _) if in_a_row >= RELIT_IN_A_ROW => Rung::OtherWay,
        (Trouble::Refused, _) => Rung::Relight,
        (Trouble::NotMaster, _) => Rung::AwaitMaster,
        (Trouble::Gone, _) => Rung::AwaitCard,
    }
}

/// After lighting, for the first time or anew, was refused.
pub(crate) fn light_failed(trouble: Trouble, barked: bool) -> Rung {
    match (trouble, barked) {
        (Trouble::Busy, false) => Rung::Again,
        (Trouble::Busy, true) | (Trouble::Broken, _) => Rung::Reopen,
        (Trouble::Refused, _) => Rung::OtherWay,
        (Trouble::NotMaster, _) => Rung::AwaitMaster,
        (Trouble::Gone, _) => Rung::AwaitCard,
    }
}

/// After a flip's event did not come: `None` if all is well but the event.
///
/// * `moved` — vblanks have passed since. `current` — the kernel's books show our framebuffer.
/// * `in_a_row` — as for [`flip_failed`].
pub(crate) fn flip_overdue(moved: bool, current: bool, in_a_row: u32) -> Option<Rung> {
    if moved && current && in_a_row == 0 { None } else { Some(relight(in_a_row)) }
}

fn relight(in_a_row: u32) -> Rung {
    if in_a_row < RELIT_IN_A_ROW { Rung::Relight } else { Rung::Reopen }
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

    fn trouble(errno: Errno) -> Trouble {
        Trouble::of(&errno.into())
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
        assert_eq!(flip_overdue(true, true, 1), Some(Rung::Relight));
        assert_eq!(flip_overdue(false, true, 0), Some(Rung::Relight));
        assert_eq!(flip_overdue(true, false, 0), Some(Rung::Relight));
        assert_eq!(flip_overdue(true, true, 3), Some(Rung::Reopen));
    }

    #[test]
    fn a_way_that_can_be_lit_and_never_flipped_is_left() {
        assert_eq!(flip_failed(trouble(Errno::INVAL), false, 0), Rung::Relight);
        assert_eq!(flip_failed(trouble(Errno::INVAL), false, 3), Rung::OtherWay);
        assert_eq!(flip_failed(trouble(Errno::IO), true, 3), Rung::Reopen);
    }

    #[test]
    fn another_master_is_waited_for_and_never_fought() {
        for errno in [Errno::ACCESS, Errno::PERM] {
            for barked in [false, true] {
                assert_eq!(flip_failed(trouble(errno), barked, 0), Rung::AwaitMaster);
                assert_eq!(light_failed(trouble(errno), barked), Rung::AwaitMaster);
            }
        }
    }

    #[test]
    fn a_busy_kernel_is_asked_again_until_the_watchdog_barks() {
        assert_eq!(flip_failed(trouble(Errno::BUSY), false, 0), Rung::Again);
        assert_eq!(flip_failed(trouble(Errno::BUSY), true, 0), Rung::Relight);
        assert_eq!(light_failed(trouble(Errno::BUSY), false), Rung::Again);
        assert_eq!(light_failed(trouble(Errno::BUSY), true), Rung::Reopen);
    }
}
