//! Pixel formats and colours of imported pictures.
//!
//! Owns the choice of a colour matrix, the chroma sites, and the ways from pictures to display RGB and to the pictures of
//! a flock. The size is kept. Gamma and primaries are not converted: those of standard and high definition differ too
//! little to be visible, and HDR is refused by `foreign.rs`.
//!
//! Start at [`Layout::of`], then [`rgb`] or [`yuv420p`].

use crate::raw;
use crate::yuv::{WEIGHTS, Yuv420p};
use ffmpeg_next::color::{Range, Space};
use ffmpeg_next::ffi as av;
use ffmpeg_next::format::Pixel;
use ffmpeg_next::frame::Video;
use ffmpeg_next::util::chroma::Location;

/// What is not read: palettes, samples in parts of bytes, memory of graphics cards, raw sensors, XYZ and floats.
const UNREAD: i64 = av::AV_PIX_FMT_FLAG_PAL as i64
    | av::AV_PIX_FMT_FLAG_BITSTREAM as i64
    | av::AV_PIX_FMT_FLAG_HWACCEL as i64
    | av::AV_PIX_FMT_FLAG_BAYER as i64
    | av::AV_PIX_FMT_FLAG_FLOAT as i64;

/// How luma and chroma are made of red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Matrix {
    /// That of standard definition, ITU-R BT.601.
    Bt601,
    /// That of high definition and of every flock, ITU-R BT.709.
    Bt709,
}

/// By which matrix a video is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatrixRule {
    /// By this one, whatever the file says.
    Always(Matrix),
    /// By the one that the file tells; where it tells none, by this one.
    Untagged(Matrix),
}

impl Matrix {
    /// The one that players assume for pictures of this width and height where the file does not tell: BT.601 of standard
    /// definition, BT.709 of all else.
    pub fn by_size((width, height): (u32, u32)) -> Self {
        if width < 1280 && height <= 576 { Self::Bt601 } else { Self::Bt709 }
    }

    /// Luma's weights of red and blue.
    fn weights(self) -> [f32; 2] {
        match self {
            Self::Bt601 => [0.299, 0.114],
            Self::Bt709 => [WEIGHTS[0], WEIGHTS[2]],
        }
    }
}

/// The name of the matrix that a header tells, `gbr` of pixels that have none, `None` where it tells nothing.
pub(crate) fn matrix_name(space: Space, format: Pixel) -> Option<&'static str> {
    let is_rgb = raw::pixel_format(format).is_some_and(|(flags, _)| is_set(flags, av::AV_PIX_FMT_FLAG_RGB.into()));
    if is_rgb { Some("gbr") } else { space.name().filter(|_| space != Space::Reserved) }
}

/// What the samples of a picture are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    /// Bits of the samples of each kind: Y, U, V, or R, G, B; gray has one kind.
    depths: Vec<u32>,
    is_rgb: bool,
    /// Luma samples for a chroma sample, across and down, as powers of two.
    chroma: [u32; 2],
    /// Samples are full range, whatever the file says.
    full: bool,
    /// Each kind has a plane of its own, of one byte for each sample, top row first.
    bytes: bool,
}

/// What the levels of luma and chroma mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Levels {
    /// Luma's weights of red and blue.
    weights: [f32; 2],
    full: bool,
}

impl Layout {
    /// The layout of `frame`.
    /// Errors: The name of its pixel format, if that is not supported.
    pub(crate) fn of(frame: &Video) -> Result<Self, String> {
        let name = frame.format().descriptor().map_or("unknown", |format| format.name());
        let format = frame.format().descriptor().zip(raw::pixel_format(frame.format()));
        let Some((descriptor, (flags, mut depths))) = format else { return Err(name.to_owned()) };
        // Of gray with alpha and of colours with alpha the last kind is the alpha.
        depths.truncate(if depths.len() < 3 { 1 } else { 3 });
        if is_set(flags, UNREAD) || name.starts_with("xyz") || depths.iter().any(|bits| !(1..=16).contains(bits)) {
            return Err(name.to_owned());
        }
        let is_rgb = is_set(flags, av::AV_PIX_FMT_FLAG_RGB.into());
        let is_planar = !is_rgb && is_set(flags, av::AV_PIX_FMT_FLAG_PLANAR.into()) && !name.starts_with("nv");
        let upright = |plane| plane < frame.planes() && isize::try_from(frame.stride(plane)).is_ok();
        let bytes = is_planar && depths.iter().all(|bits| *bits == 8) && (0..depths.len()).all(upright);
        let chroma = [descriptor.log2_chroma_w().into(), descriptor.log2_chroma_h().into()];
        Ok(Self { depths, is_rgb, chroma, full: name.starts_with("yuvj"), bytes })
    }
}

impl Levels {
    /// What the levels of `frame` mean, by `rule`; `None` if we cannot convert them to RGB.
    pub(crate) fn of(frame: &Video, layout: &Layout, rule: MatrixRule) -> Option<Self> {
        let weights = match (rule, frame.color_space()) {
            (MatrixRule::Always(matrix), _) | (MatrixRule::Untagged(matrix), Space::Unspecified | Space::Reserved) => {
                matrix.weights()
            }
            (_, Space::BT470BG | Space::SMPTE170M) => Matrix::Bt601.weights(),
            (_, Space::FCC) => [0.30, 0.11],
            (_, Space::SMPTE240M) => [0.212, 0.087],
            (_, Space::BT709) => Matrix::Bt709.weights(),
            // RGB has no matrix.
            _ if layout.is_rgb || frame.color_space() == Space::RGB => Matrix::Bt709.weights(),
            _ => return None,
        };
        let is_gray = layout.depths.len() == 1 && frame.color_range() == Range::Unspecified;
        let strange = frame.color_space() == Space::RGB && !layout.is_rgb;
        let full = layout.full || is_gray || frame.color_range() == Range::JPEG;
        (!strange).then_some(Self { weights, full })
    }

    /// Whether they are those of a flock's clips.
    fn is_bt709_limited(self) -> bool {
        self == Self { weights: Matrix::Bt709.weights(), full: false }
    }

    /// Red, green and blue of a luma of 0 and of chroma -0.5 to 0.5.
    fn rgb(self, luma: f32, [u, v]: [f32; 2]) -> [f32; 3] {
        let [red, blue] = self.weights;
        let (r, b) = (luma + 2.0 * (1.0 - red) * v, luma + 2.0 * (1.0 - blue) * u);
        [r, (luma - red * r - blue * b) / (1.0 - red - blue), b]
    }
}

/// The samples of `frame` in a flock's colours, if they are 8-bit 4:2:0; see [`crate::ForeignPicture::to_yuv420p`].
pub(crate) fn yuv420p(frame: &Video, layout: &Layout, levels: Levels) -> Option<Yuv420p> {
    if !layout.bytes || layout.depths.len() != 3 || layout.chroma != [1, 1] {
        return None;
    }
    let (width, height) = (frame.width(), frame.height());
    let planes = [0usize, 1, 2].map(|plane| {
        let half = u32::from(plane > 0);
        let (width, height) = ((width >> half) as usize, (height >> half) as usize);
        let mut samples = Vec::with_capacity(width * height);
        frame.data(plane).chunks(frame.stride(plane)).take(height).for_each(|row| samples.extend(&row[..width]));
        samples
    });
    if levels.is_bt709_limited() {
        return Yuv420p::of((width, height), planes);
    }
    let is_sited = [Location::Left, Location::Unspecified].contains(&frame.chroma_location());
    let is_even = width.is_multiple_of(2) && height.is_multiple_of(2);
    let turned = (is_sited && is_even).then(|| turned(width as usize / 2, &planes, levels))?;
    Yuv420p::of((width, height), turned)
}

/// The samples of 4:2:0 planes, with `width` samples of chroma in a row, turned from `levels` to those of a flock. Gray
/// stays gray in every matrix, so chroma is a sum of chroma, and luma is luma and a sum of the chroma at its place.
///
/// Every loop goes over slices of one length, so that the compiler makes vectors of it: it is done for each frame.
fn turned(width: usize, [luma, u, v]: &[Vec<u8>; 3], levels: Levels) -> [Vec<u8>; 3] {
    let flock = Matrix::Bt709.weights();
    let (zero, of_luma, of_chroma) = if levels.full { (0.0, 255.0, 255.0) } else { (16.0, 219.0, 224.0) };
    // Luma and chroma of a flock for one unit of chroma.
    let part = |chroma: [f32; 2]| {
        let [r, g, b] = levels.rgb(0.0, chroma);
        let y = flock[0] * r + (1.0 - flock[0] - flock[1]) * g + flock[1] * b;
        [219.0 * y, 112.0 * (b - y) / (1.0 - flock[1]), 112.0 * (r - y) / (1.0 - flock[0])].map(|sum| sum / of_chroma)
    };
    let (of_u, of_v) = (part([1.0, 0.0]), part([0.0, 1.0]));
    let sums = |kind: usize| {
        let (u_part, v_part) = (of_u[kind], of_v[kind]);
        let sum = move |(u, v): (&u8, &u8)| u_part * (f32::from(*u) - 128.0) + v_part * (f32::from(*v) - 128.0);
        u.iter().zip(v).map(sum)
    };
    let chroma = |kind: usize| sums(kind).map(|sum| (128.5 + sum) as u8).collect::<Vec<u8>>();
    let mut turned_luma = vec![0; luma.len()];
    let added: Vec<f32> = sums(0).collect();
    let (scale, rows) = (219.0 / of_luma, u.len() / width);
    let base = 16.5 - zero * scale;
    let (mut mixed, mut line) = (vec![0.0; width + 1], vec![0.0; 2 * width]);
    for (y, (to, from)) in turned_luma.chunks_exact_mut(2 * width).zip(luma.chunks_exact(2 * width)).enumerate() {
        // Chroma lies between two rows, and on every other column.
        let near = &added[y / 2 * width..][..width];
        let other = if y % 2 == 0 { (y / 2).saturating_sub(1) } else { (y / 2 + 1).min(rows - 1) };
        for (mixed, (near, far)) in mixed.iter_mut().zip(near.iter().zip(&added[other * width..])) {
            *mixed = 0.75 * near + 0.25 * far;
        }
        mixed[width] = mixed[width - 1];
        for (pair, (left, right)) in line.chunks_exact_mut(2).zip(mixed.iter().zip(&mixed[1..])) {
            pair.copy_from_slice(&[*left, 0.5 * (left + right)]);
        }
        for (to, (sample, added)) in to.iter_mut().zip(from.iter().zip(&line)) {
            *to = (base + scale * f32::from(*sample) + added) as u8;
        }
    }
    [turned_luma, chroma(1), chroma(2)]
}

/// The picture as display RGB: `[height][width][3]`, row-major, 0 to 1; limited range may exceed that slightly.
pub(crate) fn rgb(frame: &Video, layout: &Layout, levels: Levels) -> Vec<f32> {
    let (width, height) = (frame.width() as usize, frame.height() as usize);
    let planes: Vec<Plane> = (0..layout.depths.len()).map(|at| plane(frame, layout, at, levels.full)).collect();
    let site = site(frame.chroma_location(), layout.chroma);
    let across = Taps::of(width, planes.last().map_or(1, |plane| plane.width), layout.chroma[0], site[0]);
    let down = Taps::of(height, planes.last().map_or(1, Plane::height), layout.chroma[1], site[1]);
    let mut rgb = Vec::with_capacity(3 * width * height);
    let mut chroma = [vec![0.0; width], vec![0.0; width]];
    for y in 0..height {
        let first = planes[0].row(y);
        match &planes[..] {
            [_, g, b] if layout.is_rgb => {
                rgb.extend(first.iter().zip(g.row(y)).zip(b.row(y)).flat_map(|((r, g), b)| [*r, *g, *b]));
            }
            [_, u, v] => {
                for (line, plane) in chroma.iter_mut().zip([u, v]) {
                    let (above, below, part) = down.0[y];
                    let rows = plane.row(above).iter().zip(plane.row(below));
                    let mixed: Vec<f32> = rows.map(|(above, below)| above * (1.0 - part) + below * part).collect();
                    across.spread(&mixed, line);
                }
                let [u, v] = &chroma;
                rgb.extend(first.iter().zip(u).zip(v).flat_map(|((luma, u), v)| levels.rgb(*luma, [*u, *v])));
            }
            _ => rgb.extend(first.iter().flat_map(|level| [*level; 3])),
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

    fn row(&self, y: usize) -> &[f32] {
        &self.samples[y * self.width..][..self.width]
    }
}

/// The samples of kind `at`.
fn plane(frame: &Video, layout: &Layout, at: usize, full: bool) -> Plane {
    let is_chroma = at > 0 && !layout.is_rgb;
    let [across, down] = if is_chroma { layout.chroma } else { [0, 0] };
    let size = |side: u32, shift: u32| (side.div_ceil(1 << shift)) as usize;
    let (width, height) = (size(frame.width(), across), size(frame.height(), down));
    let most = ((1u32 << layout.depths[at]) - 1) as f32;
    // One level of 8 bits.
    let unit = (1u32 << layout.depths[at]) as f32 / 256.0;
    let (zero, one) = match (layout.is_rgb || full, is_chroma) {
        (true, false) => (0.0, most),
        (true, true) => (128.0 * unit, most),
        (false, false) => (16.0 * unit, 219.0 * unit),
        (false, true) => (128.0 * unit, 224.0 * unit),
    };
    let mut samples = Vec::with_capacity(width * height);
    if layout.bytes {
        let rows = frame.data(at).chunks(frame.stride(at)).take(height);
        samples.extend(rows.flat_map(|row| &row[..width]).map(|level| (f32::from(*level) - zero) / one));
    } else {
        let mut row = vec![0u16; width];
        for y in 0..height {
            raw::read_row(frame, at as u8, y as u32, &mut row);
            samples.extend(row.iter().map(|level| (f32::from(*level) - zero) / one));
        }
    }
    Plane { width, samples }
}

fn is_set(flags: u64, of: i64) -> bool {
    flags & of.unsigned_abs() != 0
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

    /// Sets every sample of `line` to the mean of the two around it.
    fn spread(&self, samples: &[f32], line: &mut [f32]) {
        for (to, (left, right, part)) in line.iter_mut().zip(&self.0) {
            *to = samples[*left] * (1.0 - part) + samples[*right] * part;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(format: Pixel) -> Result<Layout, String> {
        Layout::of(&Video::new(format, 16, 16))
    }

    #[test]
    fn formats_are_known_by_their_samples_and_others_are_named() {
        for (format, depth, kinds, bytes) in [
            (Pixel::YUV420P, 8, 3, true),
            (Pixel::YUVJ420P, 8, 3, true),
            (Pixel::YUVA420P, 8, 3, true),
            (Pixel::YUV422P10LE, 10, 3, false),
            (Pixel::YUV420P10BE, 10, 3, false),
            (Pixel::P010LE, 10, 3, false),
            (Pixel::GRAY16LE, 16, 1, false),
            (Pixel::NV12, 8, 3, false),
            (Pixel::RGB24, 8, 3, false),
            (Pixel::GBRP, 8, 3, false),
        ] {
            let layout = layout(format).unwrap();
            assert_eq!((layout.depths.len(), layout.bytes), (kinds, bytes), "{format:?}");
            assert_eq!(layout.depths, vec![depth; kinds], "{format:?}");
        }
        assert_eq!(layout(Pixel::RGB565LE).unwrap().depths, [5, 6, 5]);
        for (format, name) in
            [(Pixel::PAL8, "pal8"), (Pixel::BAYER_RGGB8, "bayer_rggb8"), (Pixel::GBRPF32LE, "gbrpf32le")]
        {
            assert_eq!(layout(format), Err(name.to_owned()));
        }
    }

    #[test]
    fn samples_turned_to_a_flocks_are_those_that_come_by_way_of_rgb() {
        for format in [Pixel::YUV420P, Pixel::YUVJ420P] {
            let mut frame = Video::new(format, 32, 16);
            for plane in 0..3 {
                let (stride, base) = (frame.stride(plane), [90, 110, 120][plane]);
                for (y, row) in frame.data_mut(plane).chunks_mut(stride).enumerate() {
                    row.iter_mut().enumerate().for_each(|(x, level)| *level = (base + x + 2 * y) as u8);
                }
            }
            let layout = Layout::of(&frame).unwrap();
            let levels = Levels::of(&frame, &layout, MatrixRule::Always(Matrix::Bt601)).unwrap();
            let found = yuv420p(&frame, &layout, levels).unwrap();
            let due = Yuv420p::from_rgb_f32(32, 16, &rgb(&frame, &layout, levels)).unwrap();
            for (found, due) in found.planes().into_iter().zip(due.planes()) {
                let off = found.iter().zip(due).map(|(found, due)| found.abs_diff(*due)).max().unwrap();
                assert!(off <= 1, "{format:?}: {off}");
            }
        }
    }

    #[test]
    fn chroma_between_two_samples_is_their_mean_where_they_sit() {
        let ramp = |taps: &Taps, samples: &[f32]| {
            let mut line = vec![0.0; 6];
            taps.spread(samples, &mut line);
            line
        };
        let three = [0.0, 1.0, 2.0];
        assert_eq!(ramp(&Taps::of(6, 3, 1, 0.0), &three), [0.0, 0.5, 1.0, 1.5, 2.0, 2.0]);
        assert_eq!(ramp(&Taps::of(6, 3, 1, 0.5), &three), [0.0, 0.25, 0.75, 1.25, 1.75, 2.0]);
        assert_eq!(ramp(&Taps::of(6, 6, 0, 0.0), &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    }
}
