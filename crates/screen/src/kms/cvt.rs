//! Computed display timings, for displays that report none.
//!
//! Owns the formula. The kernel's test commit decides whether the driver accepts the mode.
//!
//! Start at [`cvt`].
//!
//! # Source
//! VESA Coordinated Video Timings (CVT) 1.2, with standard blanking for analogue and reduced blanking (version 1) for
//! digital displays.

use drm::control::{Mode, ModeFlags};

/// Pixels come in cells of so many.
const CELL: u32 = 8;
/// Rows of the porch before the vertical pulse.
const FRONT_PORCH: u32 = 3;
/// Rows of the porch after it, at the least.
const BACK_PORCH_LEAST: u32 = 6;
/// Step of the pixel clock in kilohertz.
const CLOCK_STEP_KHZ: f64 = 250.0;
/// Microseconds of vertical pulse and back porch at the least, with standard blanking.
const PULSE_AND_PORCH_US: f64 = 550.0;
/// Percent of a line's time, and the gradient of its blanking: `M'` and `C'` of the standard.
const BLANKING_GRADIENT: f64 = 300.0;
const BLANKING_OFFSET: f64 = 30.0;
const BLANKING_LEAST: f64 = 20.0;
/// Reduced blanking: microseconds of vertical, and pixels of horizontal blanking, of which the pulse.
const REDUCED_VERTICAL_US: f64 = 460.0;
const REDUCED_HORIZONTAL: u32 = 160;
const REDUCED_PULSE: u32 = 32;

/// The kind of blanking.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Blanking {
    /// As analogue displays need it.
    Standard,
    /// As much as a digital display needs.
    Reduced,
}

/// The timing of a mode of `size` at about `refresh_hz`.
///
/// * `size` — pixels across and down, 64 to 16384. Widths that are no multiple of eight keep their pixels, and are timed as
///   the next one that is.
/// * Returns a mode whose clock is a multiple of 250 kHz.
pub(crate) fn cvt((width, height): (u32, u32), refresh_hz: f64, blanking: Blanking) -> Mode {
    let cells = width.next_multiple_of(CELL);
    let pulse_rows = pulse_rows(cells, height);
    let line = |vertical_us: f64| (1e6 / refresh_hz - vertical_us) / f64::from(height + FRONT_PORCH);
    let (total_across, total_down, line_us, pulse) = match blanking {
        Blanking::Standard => {
            let line_us = line(PULSE_AND_PORCH_US);
            let rows = (PULSE_AND_PORCH_US / line_us) as u32 + 1;
            let rows = rows.max(pulse_rows + BACK_PORCH_LEAST);
            let percent = (BLANKING_OFFSET - BLANKING_GRADIENT * line_us / 1000.0).max(BLANKING_LEAST);
            let blank = f64::from(cells) * percent / (100.0 - percent);
            let blank = (blank / f64::from(2 * CELL)) as u32 * 2 * CELL;
            let total = cells + blank;
            (total, height + rows + FRONT_PORCH, line_us, (total * 8 / 100) / CELL * CELL)
        }
        Blanking::Reduced => {
            let line_us = (1e6 / refresh_hz - REDUCED_VERTICAL_US) / f64::from(height);
            let rows = (REDUCED_VERTICAL_US / line_us) as u32 + 1;
            let rows = rows.max(FRONT_PORCH + pulse_rows + BACK_PORCH_LEAST);
            (cells + REDUCED_HORIZONTAL, height + rows, line_us, REDUCED_PULSE)
        }
    };
    let khz = match blanking {
        Blanking::Standard => f64::from(total_across) * 1000.0 / line_us,
        Blanking::Reduced => refresh_hz * f64::from(total_across) * f64::from(total_down) / 1000.0,
    };
    let khz = (khz / CLOCK_STEP_KHZ).floor() * CLOCK_STEP_KHZ;
    let pulse_end = cells + (total_across - cells) / 2;
    let polarity = match blanking {
        Blanking::Standard => ModeFlags::NHSYNC | ModeFlags::PVSYNC,
        Blanking::Reduced => ModeFlags::PHSYNC | ModeFlags::NVSYNC,
    };
    let short = |pixels: u32| u16::try_from(pixels).unwrap_or(u16::MAX);
    let raw = drm_ffi::drm_mode_modeinfo {
        clock: khz as u32,
        hdisplay: short(width),
        hsync_start: short(pulse_end - pulse),
        hsync_end: short(pulse_end),
        htotal: short(total_across),
        vdisplay: short(height),
        vsync_start: short(height + FRONT_PORCH),
        vsync_end: short(height + FRONT_PORCH + pulse_rows),
        vtotal: short(total_down),
        vrefresh: refresh_hz.round() as u32,
        flags: polarity.bits(),
        name: name(width, height),
        ..Default::default()
    };
    raw.into()
}

/// Rows of the vertical pulse, by which displays detect the aspect ratio.
fn pulse_rows(width: u32, height: u32) -> u32 {
    let is = |across: u32, down: u32| height * across / down / CELL * CELL == width;
    match () {
        () if is(4, 3) => 4,
        () if is(16, 9) => 5,
        () if is(16, 10) => 6,
        () if is(5, 4) || is(15, 9) => 7,
        () => 10,
    }
}

/// `1280x720`, ended by a zero.
fn name(width: u32, height: u32) -> [std::ffi::c_char; 32] {
    let mut name = [0; 32];
    for (place, letter) in name.iter_mut().zip(format!("{width}x{height}").bytes()) {
        *place = std::ffi::c_char::from_ne_bytes([letter]);
    }
    name
}

#[cfg(test)]
mod tests {
    use super::{Blanking, cvt};
    use Blanking::{Reduced, Standard};

    type Row = ((u32, u32), Blanking, u32, [u16; 3], [u16; 3]);

    /// What X.Org's `cvt` prints for these: kilohertz, then start of the pulse, its end and the total, across and down.
    const PUBLISHED: [Row; 12] = [
        ((800, 600), Standard, 38_250, [832, 912, 1024], [603, 607, 624]),
        ((1024, 768), Standard, 63_500, [1072, 1176, 1328], [771, 775, 798]),
        ((1280, 720), Standard, 74_500, [1344, 1472, 1664], [723, 728, 748]),
        ((1280, 800), Standard, 83_500, [1352, 1480, 1680], [803, 809, 831]),
        ((1680, 1050), Standard, 146_250, [1784, 1960, 2240], [1053, 1059, 1089]),
        ((1920, 1080), Standard, 173_000, [2048, 2248, 2576], [1083, 1088, 1120]),
        ((1400, 1050), Reduced, 101_000, [1448, 1480, 1560], [1053, 1057, 1080]),
        ((1280, 800), Reduced, 71_000, [1328, 1360, 1440], [803, 809, 823]),
        ((1680, 1050), Reduced, 119_000, [1728, 1760, 1840], [1053, 1059, 1080]),
        ((1920, 1080), Reduced, 138_500, [1968, 2000, 2080], [1083, 1088, 1111]),
        ((1920, 1200), Reduced, 154_000, [1968, 2000, 2080], [1203, 1209, 1235]),
        ((2560, 1440), Reduced, 241_500, [2608, 2640, 2720], [1443, 1448, 1481]),
    ];

    #[test]
    fn published_timings_come_out() {
        for (size, blanking, khz, across, down) in PUBLISHED {
            let mode = cvt(size, 60.0, blanking);
            let (found_across, found_down) = (<[u16; 3]>::from(mode.hsync()), <[u16; 3]>::from(mode.vsync()));
            assert_eq!((mode.clock(), found_across, found_down), (khz, across, down), "{size:?} {blanking:?}");
            assert_eq!(mode.name().to_str().unwrap(), format!("{}x{}", size.0, size.1));
        }
    }

    #[test]
    fn a_width_that_is_no_multiple_of_eight_keeps_its_pixels() {
        let mode = cvt((1366, 768), 60.0, Reduced);
        assert_eq!((mode.size(), mode.hsync().2), ((1366, 768), 1368 + 160));
    }
}
