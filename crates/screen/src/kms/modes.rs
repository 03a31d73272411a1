//! The modes of a display to try, and their order.
//!
//! Owns the order of preference among modes, and the default modes for displays that report none. Pure functions.
//! Placement is chosen in `choose.rs`.
//!
//! Start at [`Modes::of`].

use super::candidate::mode_size;
use super::card::Connector;
use super::cvt::{Blanking, cvt};
use crate::output::RequestedMode;
use drm::control::{Mode, ModeFlags, ModeTypeFlags};
use std::cmp::Reverse;
use timing::Rate;

/// How many modes are tried besides the requested one, the native one and that of the picture's size.
const MAX_OTHER_MODES: usize = 2;
/// The size for a display that reports no modes: almost every one accepts it.
const UNKNOWN: RequestedMode = RequestedMode { size: (1024, 768), refresh: None };
/// Tolerance of a listed refresh: `59.94` matches 60000/1001, but not 60.
const SAME_REFRESH: f64 = 0.0004;
/// Tolerance of a computed refresh: pixel clocks come in steps.
const NEAR_REFRESH: f64 = 0.01;
/// Default vblanks per second.
const USUAL_HZ: f64 = 60.0;

/// The modes to try at one connector.
#[derive(Debug)]
pub(super) struct Modes {
    /// The one that the owner asks for.
    pub(super) requested: Option<Mode>,
    /// The panel's own number of pixels.
    pub(super) native: Option<Mode>,
    /// The picture's own size.
    pub(super) exact: Option<Mode>,
    /// Others, the best first.
    pub(super) others: Vec<Mode>,
}

impl Modes {
    /// The modes of `connector` for upright pictures of `size` at `fps`. For each size the best refresh is taken: a
    /// multiple of the frame rate, then the display's preferred one, then the one that changes the speed least.
    pub(super) fn of(connector: &Connector, size: (u32, u32), fps: Rate, requested: Option<RequestedMode>) -> Self {
        let mut listed: Vec<Mode> = connector.modes.iter().copied().filter(|mode| refresh(mode).is_some()).collect();
        let requested = requested.map(|requested| asked_for(&listed, requested, fps, connector.is_analogue()));
        if listed.is_empty() && requested.is_none() {
            listed.push(computed(UNKNOWN, connector.is_analogue()));
        }
        listed.sort_by_cached_key(|mode| rank(mode, fps));
        let native = native_size(&connector.modes).and_then(|size| first_of(&listed, size));
        let exact = first_of(&listed, size);
        let mut others: Vec<Mode> = Vec::new();
        listed.sort_by_cached_key(|mode| {
            let (width, height) = mode_size(mode);
            let holds = width >= size.0 && height >= size.1;
            (is_interlaced(mode), !holds, Reverse(u64::from(width) * u64::from(height)), rank(mode, fps))
        });
        for mode in listed {
            let is_known = others.iter().chain(&native).chain(&exact).any(|known| mode_size(known) == mode_size(&mode));
            if !is_known && others.len() < MAX_OTHER_MODES {
                others.push(mode);
            }
        }
        Self { requested, native, exact, others }
    }
}

/// Whether `mode` counts as the `requested` one.
pub(super) fn is_near(mode: &Mode, requested: RequestedMode) -> bool {
    is_within(mode, requested, NEAR_REFRESH)
}

fn is_within(mode: &Mode, requested: RequestedMode, tolerance: f64) -> bool {
    let off = |wanted: Rate| (hertz(mode) / (f64::from(wanted.num()) / f64::from(wanted.den())) - 1.0).abs();
    mode_size(mode) == requested.size && requested.refresh.is_none_or(|wanted| off(wanted) <= tolerance)
}

/// The best listed mode that matches `requested`; else a computed one.
fn asked_for(listed: &[Mode], requested: RequestedMode, fps: Rate, is_analogue: bool) -> Mode {
    let matching = listed.iter().filter(|mode| is_within(mode, requested, SAME_REFRESH));
    matching.min_by_key(|mode| rank(mode, fps)).copied().unwrap_or_else(|| computed(requested, is_analogue))
}

fn computed(requested: RequestedMode, is_analogue: bool) -> Mode {
    let blanking = if is_analogue { Blanking::Standard } else { Blanking::Reduced };
    let hertz = requested.refresh.map_or(USUAL_HZ, |rate| f64::from(rate.num()) / f64::from(rate.den()));
    cvt(requested.size, hertz, blanking)
}

fn first_of(ranked: &[Mode], size: (u32, u32)) -> Option<Mode> {
    ranked.iter().find(|mode| mode_size(mode) == size && !is_interlaced(mode)).copied()
}

/// The size of the mode that the display prefers; without one, of its largest.
fn native_size(modes: &[Mode]) -> Option<(u32, u32)> {
    let preferred = modes.iter().find(|mode| is_preferred(mode));
    let largest = || {
        modes.iter().filter(|mode| !is_interlaced(mode)).max_by_key(|mode| {
            let (width, height) = mode_size(mode);
            u64::from(width) * u64::from(height)
        })
    };
    preferred.or_else(largest).map(mode_size)
}

/// Among modes of one size, the best first.
fn rank(mode: &Mode, fps: Rate) -> (bool, bool, bool, u64, u64) {
    let rate = refresh(mode);
    let locked = rate.and_then(|rate| rate.multiple_of(fps));
    let fps_hz = f64::from(fps.num()) / f64::from(fps.den());
    let off_speed = locked.map_or(0.0, |times| (hertz(mode) / (fps_hz * f64::from(times)) - 1.0).abs());
    let off_usual = (hertz(mode) - USUAL_HZ).abs();
    (is_interlaced(mode), locked.is_none(), !is_preferred(mode), (off_speed * 1e6) as u64, (off_usual * 1e3) as u64)
}

fn is_preferred(mode: &Mode) -> bool {
    mode.mode_type().contains(ModeTypeFlags::PREFERRED)
}

/// Whether it is interlaced or doublescan.
fn is_interlaced(mode: &Mode) -> bool {
    mode.flags().intersects(ModeFlags::INTERLACE | ModeFlags::DBLSCAN)
}

fn hertz(mode: &Mode) -> f64 {
    refresh(mode).map_or(0.0, |rate| f64::from(rate.num()) / f64::from(rate.den()))
}

/// Vblanks per second from the pixel clock, exactly; `None` for an invalid mode.
///
/// # Source
/// `drm_mode_vrefresh` in the kernel's `drm_modes.c`, without its rounding.
pub(crate) fn refresh(mode: &Mode) -> Option<Rate> {
    let (total, flags) = (u64::from(mode.hsync().2) * u64::from(mode.vsync().2), mode.flags());
    let fields = if flags.contains(ModeFlags::INTERLACE) { 2 } else { 1 };
    let doubled = if flags.contains(ModeFlags::DBLSCAN) { 2 } else { 1 };
    let scans = u64::from(mode.vscan().max(1));
    Rate::new(u64::from(mode.clock()) * 1000 * fields, total * doubled * scans).ok()
}
