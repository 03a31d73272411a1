//! What to light: connector, CRTC, plane, mode, format, placement.
//!
//! Owns the order of preference, as pure functions of a survey. Never talks to the kernel: `bring_up.rs` tries the
//! candidates in this order with a test commit, and takes the first that the kernel accepts.
//!
//! Start at [`candidates`].

use super::card::{Connector, Crtc, Id, Plane, PlaneFormat, Survey};
use crate::paint::Format;
use drm::control::{Mode, ModeFlags, ModeTypeFlags};
use timing::Rate;

/// How many modes of one connector are tried before the next connector.
const MODES_TRIED: usize = 3;
/// How far a refresh may be off a multiple of the frame rate and still count as one: the pixel clock is in whole
/// kilohertz, so 59.94 Hz of the mode lists is a few millionths off 60000/1001.
const MULTIPLE_TOLERANCE: f64 = 200e-6;

/// How the picture lies on the mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Placement {
    /// Pixel by pixel.
    Exact,
    /// The plane scales it, its proportions kept, to fill the mode.
    Scaled,
    /// Unscaled in the middle of a black buffer of the mode's size.
    Centred,
}

/// How many framebuffers the buffers lie in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Framebuffers {
    /// One for all, one below the other. It stays on the plane, and a flip moves the plane's window. To atomic drivers
    /// that is a flip as any other, event and damage included; those that map what they light at each flip, as vkms
    /// does, find it mapped already.
    Shared,
    /// One each.
    Own,
}

/// One way to light the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Candidate {
    pub(crate) connector: Id,
    pub(crate) crtc: Id,
    pub(crate) plane: Id,
    pub(crate) mode: Mode,
    pub(crate) format: PlaneFormat,
    pub(crate) placement: Placement,
    pub(crate) framebuffers: Framebuffers,
}

impl Candidate {
    /// The buffer's size for pictures of `size`.
    pub(crate) fn buffer_size(&self, size: (u32, u32)) -> (u32, u32) {
        match self.placement {
            Placement::Exact | Placement::Scaled => size,
            // Planes of 4:2:0 are even.
            Placement::Centred => (mode_size(&self.mode).0 & !1, mode_size(&self.mode).1 & !1),
        }
    }

    /// Where the whole buffer lands on the mode: left, top, width, height.
    pub(crate) fn destination(&self, size: (u32, u32)) -> (u32, u32, u32, u32) {
        let (width, height) = mode_size(&self.mode);
        match self.placement {
            Placement::Exact => (0, 0, width, height),
            Placement::Centred => (0, 0, width & !1, height & !1),
            Placement::Scaled => {
                let wide = u64::from(width) * u64::from(size.1) > u64::from(height) * u64::from(size.0);
                let fit =
                    |across: u32, of: u32, by: u32| (u64::from(across) * u64::from(of) / u64::from(by)) as u32 & !1;
                let (w, h) =
                    if wide { (fit(height, size.0, size.1), height) } else { (width, fit(width, size.1, size.0)) };
                ((width - w) / 4 * 2, (height - h) / 4 * 2, w, h)
            }
        }
    }
}

/// Every way to light pictures of `size` at `fps`, best first; empty if nothing is plugged in.
pub(crate) fn candidates(survey: &Survey, size: (u32, u32), fps: Rate) -> Vec<Candidate> {
    let mut connectors: Vec<&Connector> =
        survey.connectors.iter().filter(|connector| connector.connected && !connector.modes.is_empty()).collect();
    connectors.sort_by_key(|connector| {
        let exact = connector.modes.iter().any(|mode| mode_size(mode) == size);
        (!exact, connector.properties.object("CRTC_ID").is_none(), connector.id)
    });
    let mut ways = Vec::new();
    for connector in connectors {
        for mode in modes(&connector.modes, size, fps).into_iter().take(MODES_TRIED) {
            for crtc in crtcs(survey, connector) {
                for plane in planes(survey, crtc) {
                    let (connector, crtc) = (connector.id, crtc.id);
                    ways.extend(images(plane, &mode, size).into_iter().map(|(format, placement, framebuffers)| {
                        Candidate { connector, crtc, plane: plane.id, mode, format, placement, framebuffers }
                    }));
                }
            }
        }
    }
    ways
}

/// The modes, best first: progressive; the picture's own size; large enough for it; the display's preferred size;
/// a refresh that is a multiple of `fps`; preferred; close to 60 Hz; large.
fn modes(modes: &[Mode], size: (u32, u32), fps: Rate) -> Vec<Mode> {
    let preferred = |mode: &Mode| mode.mode_type().contains(ModeTypeFlags::PREFERRED);
    let native = modes.iter().find(|mode| preferred(mode)).map(mode_size);
    let mut ranked: Vec<Mode> = modes.iter().copied().filter(|mode| refresh(mode).is_some()).collect();
    ranked.sort_by_cached_key(|mode| {
        let (width, height) = mode_size(mode);
        let rate = refresh(mode).map_or(0.0, |rate| f64::from(rate.num()) / f64::from(rate.den()));
        let woven = mode.flags().intersects(ModeFlags::INTERLACE | ModeFlags::DBLSCAN);
        let exact = (width, height) == size;
        let holds = width >= size.0 && height >= size.1;
        let even = is_multiple(rate, f64::from(fps.num()) / f64::from(fps.den()));
        let off_sixty_mhz = ((rate - 60.0).abs() * 1000.0) as u64;
        let area = u64::from(width) * u64::from(height);
        let native = native == Some((width, height));
        (woven, !exact, !holds, !native, !even, !preferred(mode), off_sixty_mhz, u64::MAX - area)
    });
    ranked
}

fn is_multiple(refresh: f64, fps: f64) -> bool {
    let times = (refresh / fps).round();
    times >= 1.0 && (refresh / (times * fps) - 1.0).abs() <= MULTIPLE_TOLERANCE
}

/// Pixels across and down.
pub(crate) fn mode_size(mode: &Mode) -> (u32, u32) {
    (u32::from(mode.size().0), u32::from(mode.size().1))
}

/// Vblanks per second from the pixel clock, exactly; `None` for a mode that makes no sense.
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

/// The CRTCs that can drive `connector`, the one that does so first.
fn crtcs<'a>(survey: &'a Survey, connector: &Connector) -> Vec<&'a Crtc> {
    let current = connector.properties.object("CRTC_ID");
    let mut able: Vec<_> = survey.crtcs.iter().filter(|crtc| connector.crtcs >> crtc.index & 1 == 1).collect();
    able.sort_by_key(|crtc| (Some(crtc.id) != current, crtc.properties.value("ACTIVE") == 1, crtc.index));
    able
}

/// The primary planes of `crtc`, the one that it shows first. An overlay would need a primary below it on most
/// hardware: we leave them dark.
fn planes<'a>(survey: &'a Survey, crtc: &Crtc) -> Vec<&'a Plane> {
    let primary = |plane: &Plane| {
        let kind = plane.properties.get("type");
        kind.is_some_and(|kind| kind.value == 1)
    };
    let mut able: Vec<_> =
        survey.planes.iter().filter(|plane| plane.crtcs >> crtc.index & 1 == 1 && primary(plane)).collect();
    able.sort_by_key(|plane| {
        let at = plane.properties.object("CRTC_ID");
        (at != Some(crtc.id), at.is_some(), plane.id)
    });
    able
}

/// The buffers that `plane` may show, best first. YUV only where the plane says by which matrix it converts. RGB only in
/// framebuffers of their own: some drivers that take nothing else (bochs, qxl) have no window to move, and do not say so.
fn images(plane: &Plane, mode: &Mode, size: (u32, u32)) -> Vec<(PlaneFormat, Placement, Framebuffers)> {
    let coloured = colours(plane).is_some();
    let takes = |format: Format| plane.formats.iter().copied().find(|taken| taken.format == format);
    let formats = || Format::ALL.into_iter().filter(move |format| coloured || !format.is_yuv()).filter_map(takes);
    let framed = |format: PlaneFormat| {
        let shared = format.format.is_yuv().then_some(Framebuffers::Shared);
        shared.into_iter().chain([Framebuffers::Own]).map(move |framebuffers| (format, framebuffers))
    };
    let placed =
        |placement| formats().flat_map(framed).map(move |(format, framebuffers)| (format, placement, framebuffers));
    if mode_size(mode) == size {
        placed(Placement::Exact).collect()
    } else {
        placed(Placement::Scaled).chain(placed(Placement::Centred)).collect()
    }
}

/// The plane's settings for our colours, BT.709 and limited range, as (property, value); `None` if it has no such.
pub(crate) fn colours(plane: &Plane) -> Option<[(Id, u64); 2]> {
    let matrix = plane.properties.choice("COLOR_ENCODING", "ITU-R BT.709 YCbCr")?;
    let range = plane.properties.choice("COLOR_RANGE", "YCbCr limited range")?;
    Some([matrix, range])
}

#[cfg(test)]
mod tests {
    use super::super::specimen::{ModeRow, mode, plane, properties};
    use super::*;

    const P: ModeFlags = ModeFlags::empty();
    const HD60: ModeRow = (1280, 720, 74_250, 1650, 750, P, false);
    const HD5994: ModeRow = (1280, 720, 74_176, 1650, 750, P, false);
    const HD50: ModeRow = (1280, 720, 74_250, 1980, 750, P, false);
    const FULL60: ModeRow = (1920, 1080, 148_500, 2200, 1125, P, true);
    const FULL_I: ModeRow = (1920, 1080, 74_250, 2200, 1125, ModeFlags::INTERLACE, false);
    const WXGA60: ModeRow = (1366, 768, 85_500, 1792, 796, P, true);
    const VGA: ModeRow = (640, 480, 25_200, 800, 525, P, false);

    fn hz(n: u64, d: u64) -> Rate {
        Rate::new(n, d).unwrap()
    }

    /// The best of `rows` for 1280x720 at `fps`, as text.
    fn best(rows: &[ModeRow], fps: Rate) -> String {
        let list: Vec<Mode> = rows.iter().map(|&row| mode(row)).collect();
        let (size, rate) = (mode_size(&modes(&list, (1280, 720), fps)[0]), refresh(&modes(&list, (1280, 720), fps)[0]));
        format!("{}x{}@{}", size.0, size.1, rate.unwrap())
    }

    #[test]
    fn the_pictures_own_size_comes_first_then_a_multiple_of_its_rate() {
        let all = [FULL60, HD5994, HD50, HD60, VGA, FULL_I];
        assert_eq!(best(&all, hz(30, 1)), "1280x720@60");
        assert_eq!(best(&all, hz(25, 1)), "1280x720@50");
        assert_eq!(best(&all, hz(30_000, 1001)), "1280x720@148352/2475");
        assert_eq!(best(&all, hz(24, 1)), "1280x720@60");
    }

    #[test]
    fn without_it_the_displays_preferred_size_comes_first_and_interlace_last() {
        assert_eq!(best(&[VGA, FULL_I, FULL60], hz(30, 1)), "1920x1080@60");
        assert_eq!(best(&[VGA, WXGA60], hz(30, 1)), "1366x768@2671875/44576");
        assert_eq!(best(&[FULL_I, VGA], hz(30, 1)), "640x480@60");
    }

    #[test]
    fn refresh_counts_fields_and_doubled_lines() {
        let rate = |row: ModeRow| refresh(&mode(row)).unwrap();
        assert_eq!(rate(FULL_I), hz(60, 1));
        assert_eq!(rate((640, 240, 25_200, 800, 525, ModeFlags::DBLSCAN, false)), hz(30, 1));
        assert_eq!(refresh(&mode((640, 480, 0, 800, 525, P, false))), None);
        assert_eq!(refresh(&mode((640, 480, 25_200, 0, 525, P, false))), None);
    }

    #[test]
    fn a_plane_without_a_colour_matrix_gets_rgb() {
        let (hd, size) = (mode(HD60), (1280, 720));
        let formats = |kind| {
            let images = images(&plane(Id(1), properties(kind, |_| 0)), &hd, size);
            let named =
                images.iter().map(|(format, _, framebuffers)| format!("{} {framebuffers:?}", format.format.name()));
            named.collect::<Vec<_>>()
        };
        assert_eq!(formats('p'), ["YU12 Shared", "YU12 Own", "NV12 Shared", "NV12 Own", "XR24 Own"]);
        assert_eq!(formats('o'), ["XR24 Own"]);
    }

    #[test]
    fn another_size_is_scaled_in_proportion_or_centred() {
        let way = |row, placement| Candidate {
            connector: Id(1),
            crtc: Id(2),
            plane: Id(3),
            mode: mode(row),
            format: PlaneFormat { format: Format::Yu12, explicit: true },
            placement,
            framebuffers: Framebuffers::Own,
        };
        let size = (1280, 720);
        assert_eq!(way(FULL60, Placement::Scaled).destination(size), (0, 0, 1920, 1080));
        assert_eq!(way(VGA, Placement::Scaled).destination(size), (0, 60, 640, 360));
        assert_eq!(way(FULL60, Placement::Scaled).destination((960, 1080)), (480, 0, 960, 1080));
        assert_eq!(way(WXGA60, Placement::Centred).destination(size), (0, 0, 1366, 768));
        assert_eq!(way(WXGA60, Placement::Centred).buffer_size(size), (1366, 768));
    }
}
