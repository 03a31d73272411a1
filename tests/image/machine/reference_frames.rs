//! The frames of a flock, as they look on the screen.
//!
//! Owns the comparison: a look that is not a whole frame, from the first row to the last, is no frame, whether black,
//! text, or halves of two frames. Only a notice, and the mark that acknowledges a vote, may cover a part, in their places. `ffmpeg` decodes the clips.
//!
//! Start at [`ReferenceFrames::of`] and [`ReferenceFrames::find`].

use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;

/// The size of the screen, in pixels.
pub(crate) const SIZE: (usize, usize) = (1280, 720);
/// Every how many columns and rows a pixel is compared: closer than letters are high.
const STEP: (usize, usize) = (20, 6);
/// The greatest difference of a colour: the player calculates in integers, and rounds.
const TOLERANCE: u8 = 2;
/// Where a notice may lie: left, top, right and bottom.
const NOTICE: [usize; 4] = [16, 600, 752, 704];
/// The greys of a notice's pane, letters and line.
const GREYS: [u8; 3] = [16, 63, 203];
/// The least number of compared pixels of these greys that make a notice.
const PANE: usize = 60;
/// Where the mark that acknowledges a vote may lie: left, top, right and bottom.
const MARK: [usize; 4] = [1_212, 652, 1_252, 692];
/// The grey of its middle, and the number of compared pixels that it has there.
const MARK_GREY: u8 = 214;
const MARK_MIDDLE: usize = 4;
/// Compared columns and rows in a cell: a scaled picture is compared by the mean colours of cells.
const CELL: (usize, usize) = (8, 10);
/// The greatest difference of a cell's mean colour: a pixel of a scaled picture is a mean of several pixels, of which
/// one is compared.
const CELL_TOLERANCE: f32 = 10.0;
/// While a picture is copied over the one before, the screen may show parts of this many successive frames.
const TORN: usize = 3;

/// Seconds that the decoding of one clip may take.
const LONGEST_S: &str = "600";

/// The compared pixels of a picture: red, green and blue, row by row.
#[derive(Clone, PartialEq, Eq)]
pub(crate) struct Samples(Vec<[u8; 3]>);

/// The frames of one flock.
pub(crate) struct ReferenceFrames {
    frames: Vec<Frame>,
}

struct Frame {
    place: Place,
    samples: Samples,
    cells: Vec<[f32; 3]>,
}

impl Frame {
    fn new(place: Place, samples: Samples) -> Self {
        Self { place, cells: samples.cells(), samples }
    }
}

/// Which frame it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) flock: Arc<str>,
    pub(crate) clip: Arc<str>,
    pub(crate) frame: usize,
    /// Whether a notice lies over it.
    pub(crate) has_notice: bool,
    /// Whether the mark that acknowledges a vote does.
    pub(crate) has_mark: bool,
}

/// The pixels that are looked at, as column and row.
fn grid() -> impl Iterator<Item = (usize, usize)> {
    (STEP.1 / 2..SIZE.1).step_by(STEP.1).flat_map(|y| (STEP.0 / 2..SIZE.0).step_by(STEP.0).map(move |x| (x, y)))
}

fn is_within([left, top, right, bottom]: [usize; 4], (x, y): (usize, usize)) -> bool {
    (left..right).contains(&x) && (top..bottom).contains(&y)
}

/// Whether a sample is nearly this grey.
fn is_grey([red, green, blue]: [u8; 3], grey: u8) -> bool {
    red.abs_diff(green) <= 1 && green.abs_diff(blue) <= 1 && grey.abs_diff(red) <= 2
}

impl Samples {
    /// Of a picture with the pixels `colour`.
    pub(crate) fn of(colour: impl Fn(usize, usize) -> [u8; 3]) -> Self {
        Self(grid().map(|(x, y)| colour(x, y)).collect())
    }

    /// Of a decoded frame: three planes, BT.709, limited range.
    fn of_planes(planes: &[u8]) -> Self {
        let (luma, chroma) = planes.split_at(SIZE.0 * SIZE.1);
        let (blue, red) = chroma.split_at(SIZE.0 * SIZE.1 / 4);
        Self::of(|x, y| {
            let at = y / 2 * (SIZE.0 / 2) + x / 2;
            let luma = (f64::from(luma[y * SIZE.0 + x]) - 16.0) * 255.0 / 219.0;
            let [u, v] = [blue[at], red[at]].map(|sample| (f64::from(sample) - 128.0) * 255.0 / 224.0);
            [luma + 1.5748 * v, luma - 0.187_324 * u - 0.468_124 * v, luma + 1.8556 * u]
                .map(|light| light.round() as u8)
        })
    }

    /// The mean colours of the cells, row by row.
    fn cells(&self) -> Vec<[f32; 3]> {
        let across = SIZE.0.div_ceil(STEP.0);
        let rows: Vec<_> = self.0.chunks(across).collect();
        let cell = |rows: &[&[[u8; 3]]], column: usize| {
            let samples = || rows.iter().flat_map(|row| &row[column..across.min(column + CELL.0)]);
            let count = samples().count() as f32;
            [0, 1, 2].map(|colour| samples().map(|sample| f32::from(sample[colour])).sum::<f32>() / count)
        };
        let columns = || (0..across).step_by(CELL.0);
        rows.chunks(CELL.1).flat_map(|rows| columns().map(|column| cell(rows, column)).collect::<Vec<_>>()).collect()
    }

    /// Whether they match those of `frame` where `counts` is true.
    fn are(&self, frame: &Self, counts: impl Fn((usize, usize)) -> bool) -> bool {
        let alike = |ours: &[u8; 3], theirs: &[u8; 3]| {
            ours.iter().zip(theirs).all(|(ours, theirs)| ours.abs_diff(*theirs) <= TOLERANCE)
        };
        // In columns: the rows of a dark border are alike in all frames.
        let mut pairs = self.0.iter().zip(&frame.0).zip(grid());
        pairs.all(|((ours, theirs), at)| alike(ours, theirs) || !counts(at))
    }

    fn have_notice(&self) -> bool {
        self.within(NOTICE).filter(|sample| GREYS.iter().any(|grey| is_grey(*sample, *grey))).count() >= PANE
    }

    fn have_mark(&self) -> bool {
        self.within(MARK).filter(|sample| is_grey(*sample, MARK_GREY)).count() == MARK_MIDDLE
    }

    /// Those of this part of the picture.
    fn within(&self, part: [usize; 4]) -> impl Iterator<Item = [u8; 3]> {
        self.0.iter().zip(grid()).filter(move |(_, at)| is_within(part, *at)).map(|(sample, _)| *sample)
    }
}

impl ReferenceFrames {
    /// The frames of the flock in `folder`.
    pub(crate) fn of(folder: &Path) -> Self {
        let manifest = std::fs::read_to_string(folder.join("flock.toml")).unwrap();
        let manifest: toml::Table = manifest.parse().unwrap();
        let flock: Arc<str> = manifest["name"].as_str().unwrap().into();
        let mut frames = Vec::new();
        let items = ["sheep", "transition"].into_iter().flat_map(|list| manifest[list].as_array().unwrap());
        for clip in items.filter_map(|item| item.get("clip")) {
            let clip: Arc<str> = clip.as_str().unwrap().into();
            for (frame, samples) in decoded(&folder.join(&*clip)).into_iter().enumerate() {
                let (flock, clip) = (Arc::clone(&flock), Arc::clone(&clip));
                let place = Place { flock, clip, frame, has_notice: false, has_mark: false };
                frames.push(Frame::new(place, samples));
            }
        }
        Self { frames }
    }

    /// The frame that `samples` match, searched from `near` on; `near` becomes its number.
    pub(crate) fn find(&self, samples: &Samples, near: &mut usize) -> Option<Place> {
        let order = || (0..self.frames.len()).map(|at| (at + *near) % self.frames.len());
        let place = |found: usize| self.frames[found].place.clone();
        if let Some(found) = order().find(|at| samples.are(&self.frames[*at].samples, |_| true)) {
            *near = found;
            return Some(place(found));
        }
        let (has_notice, has_mark) = (samples.have_notice(), samples.have_mark());
        if !has_notice && !has_mark {
            return None;
        }
        let counts = |at| !(has_notice && is_within(NOTICE, at) || has_mark && is_within(MARK, at));
        let found = order().find(|at| samples.are(&self.frames[*at].samples, counts))?;
        *near = found;
        Some(Place { has_notice, has_mark, ..place(found) })
    }

    /// The frame that `samples` of a scaled picture are most like: the mean colour of each cell is nearly the same.
    pub(crate) fn find_scaled(&self, samples: &Samples) -> Option<Place> {
        let cells = samples.cells();
        let off = |frame: &Frame| {
            let pairs = cells.iter().flatten().zip(frame.cells.iter().flatten());
            let off = pairs.map(|(ours, theirs)| (ours - theirs).abs());
            off.fold((0.0_f32, 0.0_f32), |(most, sum), off| (most.max(off), sum + off))
        };
        let fitting =
            self.frames.iter().map(|frame| (off(frame), frame)).filter(|((most, _), _)| *most <= CELL_TOLERANCE);
        let best = fitting.min_by(|((_, one), _), ((_, other), _)| one.total_cmp(other))?;
        Some(best.1.place.clone())
    }

    /// The frame that was being copied over the one before when `samples` were taken: the mean colour of each cell is
    /// nearly within those of successive frames of a clip.
    pub(crate) fn find_torn(&self, samples: &Samples) -> Option<Place> {
        let cells = samples.cells();
        let fits = |frames: &[Frame]| {
            cells.iter().enumerate().all(|(at, cell)| {
                (0..3).all(|colour| {
                    let lights = || frames.iter().map(|frame| frame.cells[at][colour]);
                    let (least, most) = (lights().fold(f32::MAX, f32::min), lights().fold(f32::MIN, f32::max));
                    (least - CELL_TOLERANCE..=most + CELL_TOLERANCE).contains(&cell[colour])
                })
            })
        };
        let of_one_clip = |frames: &&[Frame]| frames[0].place.clip == frames[TORN - 1].place.clip;
        let found = self.frames.windows(TORN).filter(of_one_clip).find(|frames| fits(frames))?;
        Some(found[TORN - 1].place.clone())
    }
}

/// The samples of every frame of `clip`.
fn decoded(clip: &Path) -> Vec<Samples> {
    let mut ffmpeg = Command::new("timeout");
    ffmpeg.args([LONGEST_S, "ffmpeg", "-v", "error", "-nostdin", "-i"]).arg(clip).stdout(Stdio::piped());
    ffmpeg.args(["-an", "-pix_fmt", "yuv420p", "-fps_mode", "passthrough", "-f", "rawvideo", "-"]);
    let mut running = ffmpeg.spawn().expect("ffmpeg starts");
    let mut pictures = running.stdout.take().unwrap();
    let mut planes = vec![0; SIZE.0 * SIZE.1 * 3 / 2];
    let mut samples = Vec::new();
    while pictures.read_exact(&mut planes).is_ok() {
        samples.push(Samples::of_planes(&planes));
    }
    assert!(running.wait().unwrap().success() && !samples.is_empty(), "`{}` cannot be decoded", clip.display());
    samples
}

#[cfg(test)]
mod tests {
    use super::{Frame, Place, ReferenceFrames, SIZE, Samples};
    use std::sync::Arc;

    fn picture(number: usize, x: usize, y: usize) -> [u8; 3] {
        [(x / 5 + number * 40) as u8, (y / 3) as u8, 90]
    }

    fn reference() -> ReferenceFrames {
        let (flock, clip) = ("demo".into(), "loop".into());
        let place = |frame| Place {
            flock: Arc::clone(&flock),
            clip: Arc::clone(&clip),
            frame,
            has_notice: false,
            has_mark: false,
        };
        let frame = |number| Frame::new(place(number), Samples::of(|x, y| picture(number, x, y)));
        ReferenceFrames { frames: (0..4).map(frame).collect() }
    }

    fn found(colour: impl Fn(usize, usize) -> [u8; 3]) -> Option<(usize, bool)> {
        let place = reference().find(&Samples::of(colour), &mut 2)?;
        Some((place.frame, place.has_notice))
    }

    #[test]
    fn a_frame_is_found_with_and_without_a_notice() {
        assert_eq!(found(|x, y| picture(1, x, y)), Some((1, false)));
        assert_eq!(found(|x, y| picture(3, x, y).map(|light| light.saturating_add(1))), Some((3, false)));
        let pane = |x, y| (20..500).contains(&x) && (650..702).contains(&y);
        assert_eq!(found(|x, y| if pane(x, y) { [16; 3] } else { picture(1, x, y) }), Some((1, true)));
    }

    #[test]
    fn a_frame_is_found_with_the_mark_in_its_corner_and_no_other_dot() {
        let with_dot = |left: usize, radius: usize| {
            let dot = move |x: usize, y: usize| x.abs_diff(left).pow(2) + y.abs_diff(672).pow(2) <= radius.pow(2);
            let samples = Samples::of(|x, y| if dot(x, y) { [214; 3] } else { picture(1, x, y) });
            reference().find(&samples, &mut 2).map(|place| (place.frame, place.has_mark))
        };
        assert_eq!(with_dot(1_232, 11), Some((1, true)));
        assert_eq!(with_dot(1_232, 40), None, "it is too large");
        assert_eq!(with_dot(1_150, 11), None, "it lies elsewhere");
    }

    #[test]
    fn black_and_text_and_halves_of_two_frames_are_no_frame() {
        assert_eq!(found(|_, _| [0; 3]), None);
        let is_letter = |x: usize, y: usize| x < 300 && y < 16 && (x + y).is_multiple_of(3);
        assert_eq!(found(|x, y| if is_letter(x, y) { [170; 3] } else { picture(2, x, y) }), None);
        assert_eq!(found(|x, y| picture(if y < SIZE.1 / 2 { 1 } else { 2 }, x, y)), None);
        let elsewhere = |x, y| (20..500).contains(&x) && (50..102).contains(&y);
        assert_eq!(found(|x, y| if elsewhere(x, y) { [16; 3] } else { picture(1, x, y) }), None);
    }

    #[test]
    fn a_scaled_frame_is_found_and_nothing_else_is() {
        let scaled = |colour: &dyn Fn(usize, usize) -> [u8; 3]| {
            reference().find_scaled(&Samples::of(colour)).map(|place| place.frame)
        };
        // Two pixels in one.
        assert_eq!(scaled(&|x, y| picture(1, x / 2 * 2, y / 2 * 2)), Some(1));
        assert_eq!(scaled(&|x, y| picture(3, x, y).map(|light| light.saturating_add(4))), Some(3));
        assert_eq!(scaled(&|_, _| [0; 3]), None);
        assert_eq!(scaled(&|x, y| if x < 320 && y < 32 { [170; 3] } else { picture(2, x, y) }), None, "letters");
        assert_eq!(scaled(&|x, y| picture(if y < SIZE.1 / 2 { 1 } else { 2 }, x, y)), None);
    }

    #[test]
    fn parts_of_successive_frames_are_a_torn_frame_and_nothing_else_is() {
        let torn = |colour: &dyn Fn(usize, usize) -> [u8; 3]| {
            reference().find_torn(&Samples::of(colour)).map(|place| place.frame)
        };
        assert_eq!(torn(&|x, y| picture(if y < SIZE.1 / 2 { 3 } else { 2 }, x, y)), Some(3));
        assert_eq!(torn(&|x, y| picture(if y < SIZE.1 / 2 { 3 } else { 0 }, x, y)), None, "not successive");
        assert_eq!(torn(&|_, _| [0; 3]), None);
        assert_eq!(torn(&|x, y| if y < SIZE.1 / 2 { [0; 3] } else { picture(2, x, y) }), None, "half dark");
        assert_eq!(torn(&|x, y| if x < 320 && y < 32 { [170; 3] } else { picture(2, x, y) }), None, "letters");
    }
}
