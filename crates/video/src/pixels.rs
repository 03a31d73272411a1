//! Pixel formats and colours of imported pictures.
//!
//! Owns the table of layouts, colour matrices and chroma sites, and the way from them to display RGB. The size is kept.
//! Gamma and primaries are not converted: those of standard and high definition differ too little to be visible, and
//! HDR is refused by `foreign.rs`.
//!
//! Start at [`Layout::of`], then [`rgb`].

use crate::yuv::WEIGHTS;
use ffmpeg_next::color::{Range, Space};
use ffmpeg_next::frame::Video;
use ffmpeg_next::util::chroma::Location;

/// Where each of three samples of a pixel lies: Y, U, V, or R, G, B; gray has one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    /// Bits that count.
    depth: u32,
    is_rgb: bool,
    /// Luma samples for a chroma sample, across and down, as powers of two.
    chroma: [u32; 2],
    /// Samples are full range, whatever the file says.
    full: bool,
    samples: Vec<Sample>,
}

/// Where one kind of samples lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Sample {
    plane: usize,
    /// Bytes from the start of a row to the first one.
    first: usize,
    /// Bytes from one to the next.
    step: usize,
}

/// What the levels of luma and chroma mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Levels {
    /// Luma's weights of red and blue.
    weights: [f32; 2],
    pub(crate) full: bool,
}

impl Layout {
    /// The layout of the pixel format that ffmpeg calls `name`, whose chroma is shared by `1 << chroma` pixels across
    /// and down; `None` if it is not supported.
    pub(crate) fn of(name: &str, chroma: [u32; 2]) -> Option<Self> {
        planar(name, chroma).or_else(|| packed(name, chroma))
    }

    /// Whether these are samples as a flock's clips have them: 8-bit planes of 4:2:0.
    pub(crate) fn is_yuv420p(&self) -> bool {
        let planes = [0, 1, 2].map(|plane| Sample { plane, first: 0, step: 1 });
        self.depth == 8 && !self.is_rgb && self.chroma == [1, 1] && self.samples == planes
    }

    /// Planes that are read.
    pub(crate) fn planes(&self) -> usize {
        self.samples.iter().map(|sample| sample.plane + 1).max().unwrap_or(0)
    }
}

/// One plane for each kind of samples, as the name tells.
fn planar(name: &str, chroma: [u32; 2]) -> Option<Layout> {
    let (kind, rest) = ["yuvj", "yuva", "yuv", "gbrap", "gbrp", "gray"]
        .into_iter()
        .find_map(|kind| Some((kind, name.strip_prefix(kind)?)))?;
    let rest = if kind.starts_with("yuv") {
        rest.trim_start_matches(|c: char| c.is_ascii_digit()).strip_prefix('p')?
    } else {
        rest
    };
    let depth = match rest {
        "" => 8,
        deep => deep.strip_suffix("le")?.parse().ok().filter(|depth| (9..=16).contains(depth))?,
    };
    let step = if depth > 8 { 2 } else { 1 };
    let planes: &[usize] = match kind {
        "gray" => &[0],
        // Green comes first.
        "gbrp" | "gbrap" => &[2, 0, 1],
        _ => &[0, 1, 2],
    };
    let samples = planes.iter().map(|plane| Sample { plane: *plane, first: 0, step }).collect();
    Some(Layout { depth, is_rgb: kind.starts_with("gb"), chroma, full: kind == "yuvj", samples })
}

/// Samples that take turns.
fn packed(name: &str, chroma: [u32; 2]) -> Option<Layout> {
    let (is_rgb, step, firsts) = match name {
        "rgb24" => (true, 3, [0, 1, 2]),
        "bgr24" => (true, 3, [2, 1, 0]),
        "rgba" | "rgb0" => (true, 4, [0, 1, 2]),
        "bgra" | "bgr0" => (true, 4, [2, 1, 0]),
        "argb" | "0rgb" => (true, 4, [1, 2, 3]),
        "abgr" | "0bgr" => (true, 4, [3, 2, 1]),
        "yuyv422" => (false, 4, [0, 1, 3]),
        "uyvy422" => (false, 4, [1, 0, 2]),
        "yvyu422" => (false, 4, [0, 3, 1]),
        "nv12" | "nv16" | "nv24" | "nv21" | "nv42" => {
            let turned = usize::from(matches!(name, "nv21" | "nv42"));
            let sample = |plane, first, step| Sample { plane, first, step };
            let samples = vec![sample(0, 0, 1), sample(1, turned, 2), sample(1, 1 - turned, 2)];
            return Some(Layout { depth: 8, is_rgb: false, chroma, full: false, samples });
        }
        _ => return None,
    };
    let step_of = |at: usize| if !is_rgb && at == 0 { 2 } else { step };
    let samples = firsts.into_iter().enumerate().map(|(at, first)| Sample { plane: 0, first, step: step_of(at) });
    Some(Layout { depth: 8, is_rgb, chroma, full: false, samples: samples.collect() })
}

impl Levels {
    /// What the levels of `frame` mean; `None` if we cannot convert them to RGB. Where the file does not say, the size
    /// decides, as in other players: standard definition is BT.601, all else BT.709.
    #[expect(clippy::wildcard_enum_match_arm, reason = "the list grows with every version of ffmpeg")]
    pub(crate) fn of(frame: &Video, layout: &Layout) -> Option<Self> {
        let standard = frame.width() < 1280 && frame.height() <= 576;
        let weights = match frame.color_space() {
            Space::BT470BG | Space::SMPTE170M => [0.299, 0.114],
            Space::FCC => [0.30, 0.11],
            Space::SMPTE240M => [0.212, 0.087],
            Space::Unspecified | Space::Reserved if standard => [0.299, 0.114],
            // Of RGB there is nothing to turn.
            Space::BT709 | Space::Unspecified | Space::Reserved | Space::RGB => [WEIGHTS[0], WEIGHTS[2]],
            _ => return None,
        };
        let is_gray = layout.samples.len() == 1 && frame.color_range() == Range::Unspecified;
        let strange = frame.color_space() == Space::RGB && !layout.is_rgb;
        let full = layout.full || is_gray || frame.color_range() == Range::JPEG;
        (!strange).then_some(Self { weights, full })
    }

    /// Whether they are those of a flock's clips.
    pub(crate) fn is_bt709_limited(self) -> bool {
        self == Self { weights: [WEIGHTS[0], WEIGHTS[2]], full: false }
    }
}

/// The picture as display RGB: `[height][width][3]`, row-major, 0 to 1; limited range may exceed that slightly.
pub(crate) fn rgb(frame: &Video, layout: &Layout, levels: Levels) -> Vec<f32> {
    let (width, height) = (frame.width() as usize, frame.height() as usize);
    let planes: Vec<Plane> = (0..layout.samples.len()).map(|at| plane(frame, layout, at, levels.full)).collect();
    let site = site(frame.chroma_location(), layout.chroma);
    let across = Taps::of(width, planes.last().map_or(1, |plane| plane.width), layout.chroma[0], site[0]);
    let down = Taps::of(height, planes.last().map_or(1, Plane::height), layout.chroma[1], site[1]);
    let [red, blue] = levels.weights;
    let green = 1.0 - red - blue;
    let mut rgb = Vec::with_capacity(3 * width * height);
    for y in 0..height {
        for x in 0..width {
            let first = planes[0].samples[y * width + x];
            match &planes[..] {
                [_, g, b] if layout.is_rgb => rgb.extend([first, g.samples[y * width + x], b.samples[y * width + x]]),
                [_, u, v] => {
                    let chroma =
                        |plane: &Plane| down.mean(y, |row| across.mean(x, |at| plane.samples[row * plane.width + at]));
                    let (r, b) = (first + 2.0 * (1.0 - red) * chroma(v), first + 2.0 * (1.0 - blue) * chroma(u));
                    rgb.extend([r, (first - red * r - blue * b) / green, b]);
                }
                _ => rgb.extend([first; 3]),
            }
        }
    }
    rgb
}

/// One kind of samples: 0 to 1, chroma -0.5 to 0.5.
struct Plane {
    width: usize,
    samples: Vec<f32>,
}

impl Plane {
    fn height(&self) -> usize {
        self.samples.len() / self.width.max(1)
    }
}

/// The samples of kind `at`.
fn plane(frame: &Video, layout: &Layout, at: usize, full: bool) -> Plane {
    let is_chroma = at > 0 && !layout.is_rgb;
    let [across, down] = if is_chroma { layout.chroma } else { [0, 0] };
    let size = |side: u32, shift: u32| (side.div_ceil(1 << shift)) as usize;
    let (width, height) = (size(frame.width(), across), size(frame.height(), down));
    let most = ((1u32 << layout.depth) - 1) as f32;
    // One level of 8 bits.
    let unit = (1u32 << (layout.depth - 8)) as f32;
    let (zero, one) = match (layout.is_rgb || full, is_chroma) {
        (true, false) => (0.0, most),
        (true, true) => (128.0 * unit, most),
        (false, false) => (16.0 * unit, 219.0 * unit),
        (false, true) => (128.0 * unit, 224.0 * unit),
    };
    let sample = layout.samples[at];
    let stride = frame.stride(sample.plane);
    let rows = frame.data(sample.plane).chunks(stride).take(height);
    let read = |row: &[u8], x: usize| {
        let place = sample.first + x * sample.step;
        let level = if layout.depth > 8 { u16::from_le_bytes([row[place], row[place + 1]]) } else { row[place].into() };
        (f32::from(level) - zero) / one
    };
    Plane { width, samples: rows.flat_map(|row| (0..width).map(move |x| read(row, x))).collect() }
}

/// Where the first chroma sample sits, in luma samples across and down from the first of those.
fn site(location: Location, chroma: [u32; 2]) -> [f32; 2] {
    let middle = chroma.map(|shift| ((1u32 << shift) - 1) as f32 / 2.0);
    match location {
        Location::Center => middle,
        Location::Top => [middle[0], 0.0],
        Location::TopLeft => [0.0; 2],
        // The default since MPEG-2.
        Location::Unspecified | Location::Left => [0.0, middle[1]],
        Location::BottomLeft => [0.0, 2.0 * middle[1]],
        Location::Bottom => [middle[0], 2.0 * middle[1]],
    }
}

/// For every luma position along an axis the two chroma samples around it, and how much of the second.
struct Taps(Vec<(usize, usize, f32)>);

impl Taps {
    fn of(length: usize, chroma: usize, shift: u32, site: f32) -> Self {
        let tap = |at: usize| {
            let place = ((at as f32 - site) / (1u32 << shift) as f32).clamp(0.0, chroma.saturating_sub(1) as f32);
            let left = place as usize;
            (left, (left + 1).min(chroma.saturating_sub(1)), place - left as f32)
        };
        Self((0..length).map(tap).collect())
    }

    fn mean(&self, at: usize, sample: impl Fn(usize) -> f32) -> f32 {
        let (left, right, part) = self.0[at];
        if part == 0.0 { sample(left) } else { sample(left) * (1.0 - part) + sample(right) * part }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_known_by_their_names_and_others_are_not_guessed() {
        let depths = |name| Layout::of(name, [1, 1]).map(|layout| (layout.depth, layout.planes()));
        for (name, depth, planes) in [
            ("yuv420p", 8, 3),
            ("yuvj420p", 8, 3),
            ("yuva420p", 8, 3),
            ("yuv422p10le", 10, 3),
            ("gray16le", 16, 1),
            ("nv12", 8, 2),
        ] {
            assert_eq!(depths(name), Some((depth, planes)), "{name}");
        }
        for name in
            ["yuv420p10be", "pal8", "p010le", "bayer_rggb8", "gbrpf32le", "yuv", "vaapi", "gray10be", "rgb565le"]
        {
            assert_eq!(depths(name), None, "{name}");
        }
        assert!(Layout::of("yuv420p", [1, 1]).unwrap().is_yuv420p());
        assert!(
            !Layout::of("yuv422p", [1, 0]).unwrap().is_yuv420p() && !Layout::of("nv12", [1, 1]).unwrap().is_yuv420p()
        );
    }

    #[test]
    fn chroma_between_two_samples_is_their_mean_where_they_sit() {
        let taps = Taps::of(6, 3, 1, 0.0);
        let ramp = |taps: &Taps| (0..6).map(|at| taps.mean(at, |sample| sample as f32)).collect::<Vec<_>>();
        assert_eq!(ramp(&taps), [0.0, 0.5, 1.0, 1.5, 2.0, 2.0]);
        assert_eq!(ramp(&Taps::of(6, 3, 1, 0.5)), [0.0, 0.25, 0.75, 1.25, 1.75, 2.0]);
        assert_eq!(ramp(&Taps::of(6, 6, 0, 0.0)), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    }
}
