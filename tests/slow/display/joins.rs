//! A thousand joins on a real display, with every frame at its vblank.
//!
//! Owns the claim that no frame is missing, repeated, black or late at a join.

use crate::guest::succeed_in_virtual_time;
use claims::flocks::JOINS;
use claims::player_run::{PlayerRun, VKMS};
use claims::trace::{End, Trace};

/// Clips played: one more than joins.
const CLIPS: usize = 1_001;

#[test]
fn a_thousand_joins_show_every_frame_once_and_in_time() {
    let flock = JOINS.flock();
    let clips = flock.walk("7", CLIPS);
    let due = flock.frames(&clips);
    let playing = PlayerRun::of(&flock.folder).with(&["--screen", VKMS, "--seed", "7", "--hash"]);
    let playing = playing.with(&["--clips", &CLIPS.to_string()]);
    succeed_in_virtual_time(240, &playing.command());
    let trace = playing.trace();

    for (place, (flip, (clip, frame, hash))) in trace.flips.iter().zip(&due).enumerate() {
        let lit = (flip.clip.as_str(), flip.frame, flip.hash.as_deref());
        assert_eq!(lit, (*clip, *frame, Some(*hash)), "flip {place} shows another frame than the walk has there");
    }
    assert_eq!(trace.flips.len(), due.len(), "flips");
    let joins: Vec<_> = clips.windows(2).map(|pair| (pair[0].clone(), pair[1].clone())).collect();
    assert_eq!(trace.joins, joins);
    let counts = End { flips: due.len() as u64, late: 0, repeated: 0, skipped: 0, joins: CLIPS as u64 - 1, faults: 0 };
    assert_eq!(trace.end, Some(counts));
    assert_eq!(trace.faults, []);
    on_the_beat(&trace, (30, 1));
}

/// Checks the vblank of every flip, however many joins lie between, and the clock against the counter. Where the
/// refresh is within 1 % of a multiple of the frame rate, every frame is shown for that many vblanks. Elsewhere frame n
/// of a run is shown at the vblank nearest to `n * refresh / fps` after the first, halves downwards.
pub(crate) fn on_the_beat(trace: &Trace, fps: (u64, u64)) {
    let refresh = trace.refresh();
    let (up, down) = (refresh.0 * fps.1, refresh.1 * fps.0);
    let nearest = (up + down / 2) / down;
    let is_locked = nearest > 0 && up.abs_diff(nearest * down) * 100 <= nearest * down;
    let first = &trace.flips[0];
    for (n, flip) in (0u64..).zip(&trace.flips) {
        let due = if is_locked { n * nearest } else { (2 * n * up).saturating_sub(down).div_ceil(2 * down) };
        let lit = u64::from(flip.vblank.wrapping_sub(first.vblank));
        assert_eq!(lit, due, "frame {n} ({} {}) is lit that many vblanks after the first", flip.clip, flip.frame);
        assert_eq!(flip.late, 0, "frame {n} ({} {}) is late", flip.clip, flip.frame);
        let due_ns = u128::from(lit) * 1_000_000_000 * u128::from(refresh.1) / u128::from(refresh.0);
        let off_ns = u128::from(flip.t_ns - first.t_ns).abs_diff(due_ns);
        assert!(off_ns < 1_000_000, "frame {n} is {off_ns} ns off the beat");
    }
}
