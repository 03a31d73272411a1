//! Real display modes, and how many vblanks a frame of each rate stays lit on them.
//!
//! Owns the table, each row with the timing that its standard publishes: VESA DMT and CVT (with reduced blanking: RB),
//! and CTA-861 (CEA). The expected values are written down, not computed; 0 means that the cadence alternates.

use super::Cadence;
use crate::Rate;

/// A mode's name, its pixel clock in kHz, its total width and height in pixels, and the vblanks of a frame at each of
/// [`RATES`].
type Row = (&'static str, u64, u64, u64, [u32; 9]);

/// Frames per second.
const RATES: [(u64, u64); 9] =
    [(20, 1), (24_000, 1_001), (24, 1), (25, 1), (30_000, 1_001), (30, 1), (50, 1), (60_000, 1_001), (60, 1)];

#[rustfmt::skip]
const MODES: [Row; 35] = [
    ("DMT 640x480@60", 25_175, 800, 525, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("DMT 800x600@60", 40_000, 1056, 628, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("DMT 1024x768@60", 65_000, 1344, 806, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("DMT 1024x768@75", 78_750, 1312, 800, [0, 0, 0, 3, 0, 0, 0, 0, 0]),
    ("DMT 1280x1024@60", 108_000, 1688, 1066, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("DMT 1280x1024@75", 135_000, 1688, 1066, [0, 0, 0, 3, 0, 0, 0, 0, 0]),
    ("DMT 1366x768@60", 85_500, 1792, 798, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("CVT 1280x720@60", 74_500, 1664, 748, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("CVT 1280x800@60", 83_500, 1680, 831, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("CVT 1920x1080@60", 173_000, 2576, 1120, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("CVT 1920x1080@75", 220_750, 2608, 1128, [0, 0, 0, 3, 0, 0, 0, 0, 0]),
    ("CVT-RB 1280x720@60", 64_000, 1440, 741, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("CVT-RB 1280x800@60", 71_000, 1440, 823, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("CVT-RB 1920x1080@60", 138_500, 2080, 1111, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("CVT-RB 1920x1200@60", 154_000, 2080, 1235, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("CVT-RB 2560x1440@60", 241_500, 2720, 1481, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("CVT-RB 3840x2160@60", 533_000, 4000, 2222, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("CEA 1280x720@50", 74_250, 1980, 750, [0, 0, 0, 2, 0, 0, 1, 0, 0]),
    ("CEA 1280x720@59.94", 74_176, 1650, 750, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("CEA 1280x720@60", 74_250, 1650, 750, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("CEA 1920x1080@23.98", 74_176, 2750, 1125, [0, 1, 1, 0, 0, 0, 0, 0, 0]),
    ("CEA 1920x1080@24", 74_250, 2750, 1125, [0, 1, 1, 0, 0, 0, 0, 0, 0]),
    ("CEA 1920x1080@25", 74_250, 2640, 1125, [0, 0, 0, 1, 0, 0, 0, 0, 0]),
    ("CEA 1920x1080@30", 74_250, 2200, 1125, [0, 0, 0, 0, 1, 1, 0, 0, 0]),
    ("CEA 1920x1080@50", 148_500, 2640, 1125, [0, 0, 0, 2, 0, 0, 1, 0, 0]),
    ("CEA 1920x1080@59.94", 148_352, 2200, 1125, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("CEA 1920x1080@60", 148_500, 2200, 1125, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("CEA 1920x1080@100", 297_000, 2640, 1125, [5, 0, 0, 4, 0, 0, 2, 0, 0]),
    ("CEA 1920x1080@119.88", 296_703, 2200, 1125, [6, 5, 5, 0, 4, 4, 0, 2, 2]),
    ("CEA 1920x1080@120", 297_000, 2200, 1125, [6, 5, 5, 0, 4, 4, 0, 2, 2]),
    ("CEA 3840x2160@24", 297_000, 5500, 2250, [0, 1, 1, 0, 0, 0, 0, 0, 0]),
    ("CEA 3840x2160@30", 297_000, 4400, 2250, [0, 0, 0, 0, 1, 1, 0, 0, 0]),
    ("CEA 3840x2160@50", 594_000, 5280, 2250, [0, 0, 0, 2, 0, 0, 1, 0, 0]),
    ("CEA 3840x2160@60", 594_000, 4400, 2250, [3, 0, 0, 0, 2, 2, 0, 1, 1]),
    ("a panel 1920x1080@144", 333_216, 2000, 1157, [0, 6, 6, 0, 0, 0, 0, 0, 0]),
];

#[test]
fn every_frame_is_lit_equally_long_on_real_modes_near_a_multiple() {
    for (name, kilohertz, width, height, expected) in MODES {
        let refresh = Rate::new(kilohertz * 1000, width * height).unwrap();
        for ((num, den), expected) in RATES.into_iter().zip(expected) {
            let mut cadence = Cadence::new(Rate::new(num, den).unwrap(), refresh);
            // An hour of frames: the slowest reported slip is one frame in some minutes.
            let holds: Vec<u32> = (0..3600 * num / den).map(|_| cadence.hold()).collect();
            let is_even = holds.iter().all(|held| *held == holds[0]);
            assert_eq!(is_even, expected > 0, "{num}/{den} on {name}");
            assert!(expected == 0 || holds[0] == expected, "{num}/{den} on {name}: {} vblanks", holds[0]);
        }
    }
}
