//! Videos to import, frame by frame: any codec, container, size and pixel format that ffmpeg reads.
//!
//! Owns the reader for files that are imported into a flock, and its errors. Units do not use it: a flock's clips are
//! in the form, and `session.rs` reads them. Errors are reported instead of concealed, because a damaged source should
//! be fetched again, not copied.
//!
//! Start at [`ForeignVideo::open`]. Reading goes through `ffmpeg-next`'s safe layer; pixels are `pixels.rs`'s.

use crate::code;
use crate::length;
use crate::nal;
use crate::orientation::Orientation;
use crate::pixels::{self, Layout, Levels, Matrix, MatrixRule};
use crate::raw::{self, Demuxer};
use crate::yuv::Yuv420p;
use ffmpeg_next as ffmpeg;
use ffmpeg_next::codec::packet::side_data::Type;
use ffmpeg_next::color::TransferCharacteristic;
use ffmpeg_next::format::context::Input;
use ffmpeg_next::{Dictionary, Packet, Rational, codec, decoder, format, frame, media};
use std::fs::{self, File};
use std::io;
use std::os::fd::AsRawFd;
use std::path::Path;
use timing::{FrameCount, Rate};

/// The containers that are read: none that refer to other files or to a network.
const CONTAINERS: &str = "avi,mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,mpeg,mpegts,mpegvideo,m4v,ogg,flv,asf,nut,ivf,h264,\
                          hevc,obu,av1,mjpeg,vc1,dirac,yuv4mpegpipe,gif,apng,dv,mxf,swf,rm";

/// Tags about the file's encoding, which are wrong in a re-encoded copy.
const TECHNICAL_TAGS: &[&str] =
    &["encoder", "software", "major_brand", "minor_version", "compatible_brands", "duration", "creation_time"];

/// Longest tag that is kept, in bytes: enough for a licence text.
const MAX_TAG_BYTES: usize = 65_536;

/// Tolerance of a duration, in seconds: containers round times, and the last frame's duration is an estimate.
const DURATION_TOLERANCE_S: f64 = 0.2;

/// Largest side of a picture that is read, in pixels.
const MAX_SIDE: u32 = 16_384;

/// A video's properties, by its header.
#[derive(Clone, Debug, PartialEq)]
pub struct VideoInfo {
    /// The codec's short name: `mpeg4`.
    pub codec: String,
    /// Width and height in pixels as they are seen.
    pub size: (u32, u32),
    /// Width and height of a pixel as it is seen, relative to each other; `(1, 1)` where the file does not say.
    pub pixel: (u32, u32),
    /// How the container has its pictures turned and mirrored.
    pub orientation: Orientation,
    /// Frames per second on average; `None` where the file does not say.
    pub fps: Option<Rate>,
    /// Number of frames by its header, without those that an edit list hides. An AVI counts dropped frames, too.
    pub frames: Option<FrameCount>,
    /// Its length in seconds by its header.
    pub seconds: Option<f64>,
    /// The name of its colour matrix, as `bt709` or `smpte170m`; `gbr` of RGB; `None` where its header does not say.
    pub matrix: Option<&'static str>,
    /// Title, artist, copyright and the like, as `(key, value)`, in the file's order.
    pub tags: Vec<(String, String)>,
}

/// Why a video is not read, or not to its end. Messages follow a file's name: "`a.avi` is empty".
#[derive(Debug, thiserror::Error)]
pub enum ForeignError {
    /// Its colours are of another kind.
    #[error("has unsupported colours: {found}")]
    Colours {
        /// Of which.
        found: String,
    },
    /// The end of the file is missing.
    #[error("is cut short: {found} bytes (expected {expected})")]
    Cut {
        /// How long it should be by its header, in bytes.
        expected: u64,
        /// How long it is, in bytes.
        found: u64,
    },
    /// It does not decode cleanly, as far as its codec can tell.
    #[error("does not decode cleanly at frame {frame}: {reason}")]
    Decode {
        /// How many frames came before.
        frame: u32,
        /// The message of ffmpeg.
        reason: String,
    },
    /// It has no bytes.
    #[error("is empty")]
    Empty,
    /// Its frames are interlaced.
    #[error("is interlaced at frame {frame} (expected whole frames)")]
    Interlaced {
        /// The first such frame.
        frame: u32,
    },
    /// It is a folder or a device.
    #[error("is not a file")]
    NotAFile,
    /// It is no video that ffmpeg reads.
    #[error("is not a readable video: {reason}")]
    NotAVideo {
        /// The message of ffmpeg.
        reason: String,
    },
    /// It is missing, or the kernel refuses it.
    #[error("cannot be read")]
    Open {
        /// The kernel error.
        source: io::Error,
    },
    /// Its display matrix is not supported.
    #[error("is shown {found} (expected upright, turned by 90, 180 or 270 degrees, or mirrored)")]
    Orientation {
        /// How it is shown, in words.
        found: String,
    },
    /// Its pixel format is not supported.
    #[error("has an unsupported pixel format: `{found}`")]
    Pixels {
        /// Which, in ffmpeg's words.
        found: String,
    },
    /// It is shorter than its header says.
    #[error("ends after {found:.2} s (expected {expected:.2} s)")]
    Short {
        /// How long it should be, in seconds.
        expected: f64,
        /// How long it is, in seconds.
        found: f64,
    },
    /// Its pictures change their size, or are too large.
    #[error("has a frame {frame} of {}x{} pixels (expected {}x{})", .found.0, .found.1, .expected.0, .expected.1)]
    Size {
        /// The frame.
        frame: u32,
        /// The size in its header, or the maximum.
        expected: (u32, u32),
        /// As it is.
        found: (u32, u32),
    },
    /// Fewer frames were decoded than its header says.
    #[error("yields {found} frames when decoded (expected {expected})")]
    TooFew {
        /// The number in the header.
        expected: FrameCount,
        /// The number found.
        found: FrameCount,
    },
}

/// A video being read.
pub struct ForeignVideo {
    input: Input,
    decoder: decoder::Video,
    stream: usize,
    info: VideoInfo,
    rule: MatrixRule,
    /// How many frames must come.
    promised: Option<FrameCount>,
    /// The start of the stream, until its second keyframe.
    opening: Option<Opening>,
    /// Whether an edit list hides some of its frames.
    hides: bool,
    /// Pictures that come after the first keyframe and are shown before it: they refer to some before the beginning of
    /// the file, and are not played. Those that an edit list hides are not counted.
    leading: u32,
    /// Expected duration in seconds, where the file does not state a number of frames.
    lasts: Option<f64>,
    /// When what was read is over, in seconds.
    over: f64,
    delivered: u32,
}

/// The first group of pictures of a stream.
struct Opening {
    /// When its keyframe is shown, in ticks; `None` before the first packet.
    key: Option<i64>,
    /// Whether the keyframe is an H.264 picture that does not reset the decoder: the pictures after it may refer to some
    /// that were cut off, and ffmpeg plays them.
    open: bool,
}

/// One picture of it.
pub struct ForeignPicture {
    frame: frame::Video,
    orientation: Orientation,
    layout: Layout,
    levels: Levels,
}

impl ForeignVideo {
    /// Opens the video at `path` and reads its header.
    ///
    /// # Errors
    /// [`ForeignError`]; damage further inside shows when it is read.
    pub fn open(path: &Path) -> Result<Self, ForeignError> {
        raw::redirect_log();
        let file = check_file(path)?;
        let not = |error: ffmpeg::Error| ForeignError::NotAVideo { reason: code::text(error) };
        let options = Dictionary::from_iter([("protocol_whitelist", "file"), ("format_whitelist", CONTAINERS)]);
        // The safe layer takes names as text only; the kernel has another name for an open file.
        let name = path.to_str().map_or_else(|| format!("/proc/self/fd/{}", file.as_raw_fd()), str::to_owned);
        let input = format::input_with_dictionary(&format!("file:{name}"), options).map_err(not)?;
        let stream = input.streams().best(media::Type::Video).ok_or_else(|| not(ffmpeg::Error::StreamNotFound))?;
        let decoder = open_decoder(&stream).map_err(not)?;
        let orientation = orientation(&stream)?;
        let size = (decoder.width(), decoder.height());
        if size.0.max(size.1) > MAX_SIDE {
            return Err(ForeignError::Size { frame: 0, expected: (MAX_SIDE, MAX_SIDE), found: size });
        }
        let codec = decoder.id().name().to_owned();
        let pixel = orientation.swapped(positive(decoder.aspect_ratio()).unwrap_or((1, 1)));
        let rate = [stream.avg_frame_rate(), stream.rate()].into_iter().find_map(positive);
        let fps = rate.and_then(|(num, den)| Rate::new(num.into(), den.into()).ok());
        let shown = shown(path, &input, &stream);
        let hides = shown.is_some_and(|shown| i64::from(shown.0) < stream.frames());
        // Whether an AVI is complete is checked by its length alone: see `check_file`.
        let promised = shown.filter(|_| input.format().name() != "avi");
        let seconds = (input.duration() > 0).then(|| input.duration() as f64 / f64::from(ffmpeg::ffi::AV_TIME_BASE));
        // Matroska states no number of frames, and its duration is that of the longest stream.
        let lasts = seconds.filter(|_| shown.is_none() && input.nb_streams() == 1);
        let lasts = lasts.filter(|_| input.format().name().starts_with("matroska"));
        let matrix = pixels::matrix_name(decoder.color_space(), decoder.format());
        let rule = MatrixRule::Untagged(Matrix::by_size(size));
        let (size, tags) = (orientation.swapped(size), tags(&input));
        let info = VideoInfo { codec, size, pixel, orientation, fps, frames: shown, seconds, matrix, tags };
        let stream = stream.index();
        let opening = Some(Opening { key: None, open: false });
        let (over, leading, delivered) = (0.0, 0, 0);
        Ok(Self { input, decoder, stream, info, rule, promised, opening, hides, leading, lasts, over, delivered })
    }

    /// The same, its colours read as `rule` says. Without this the size decides where a file does not say, as in other
    /// players: [`Matrix::by_size`].
    #[must_use]
    pub fn with_matrix(self, rule: MatrixRule) -> Self {
        Self { rule, ..self }
    }

    /// What it tells of itself.
    pub fn info(&self) -> &VideoInfo {
        &self.info
    }

    /// Its next picture, in presentation order; `None` after the last one.
    ///
    /// # Errors
    /// [`ForeignError`] where it is damaged, or is of a kind that is not read. The reader cannot be used after that.
    pub fn picture(&mut self) -> Result<Option<ForeignPicture>, ForeignError> {
        let mut frame = frame::Video::empty();
        loop {
            match self.decoder.receive_frame(&mut frame) {
                Ok(()) => {
                    let picture = self.check_frame(frame)?;
                    self.delivered += 1;
                    return Ok(Some(picture));
                }
                Err(ffmpeg::Error::Eof) => return self.check_end().map(|()| None),
                Err(ffmpeg::Error::Other { errno: ffmpeg::error::EAGAIN }) => self.feed()?,
                Err(error) => return Err(self.failed(&code::text(error))),
            }
        }
    }

    /// Sends the next packet to the decoder, or the end of the stream.
    fn feed(&mut self) -> Result<(), ForeignError> {
        loop {
            let mut packet = Packet::empty();
            match packet.read(&mut self.input) {
                Ok(()) if packet.stream() != self.stream || packet.size() == 0 => (),
                Ok(()) if packet.is_corrupt() => return Err(self.failed(&"a packet is incomplete")),
                Ok(()) => {
                    self.over = self.over.max(self.end_of(&packet));
                    let forgiven = self.watch_opening(&packet);
                    return match self.decoder.send_packet(&packet) {
                        Err(_) if forgiven => Ok(()),
                        sent => sent.map_err(|error| self.failed(&code::text(error))),
                    };
                }
                Err(ffmpeg::Error::Eof) => {
                    return self.decoder.send_eof().map_err(|error| self.failed(&code::text(error)));
                }
                Err(error) => return Err(self.failed(&code::text(error))),
            }
        }
    }

    /// Takes note of a packet of the first group of pictures. Returns whether an error in it is none of the file: it
    /// refers to pictures that lay before the beginning of the file.
    fn watch_opening(&mut self, packet: &Packet) -> bool {
        let Some(opening) = &mut self.opening else { return false };
        let Some(key) = opening.key else {
            let is_open = packet.is_key() && self.decoder.id() == codec::Id::H264;
            opening.open = is_open && !packet.data().is_some_and(nal::has_idr);
            opening.key = Some(packet.pts().unwrap_or(i64::MIN));
            return opening.open;
        };
        if packet.is_key() {
            self.opening = None;
            return false;
        }
        if !self.hides && packet.pts().is_none_or(|pts| pts < key) {
            self.leading += 1;
        }
        opening.open
    }

    /// Checks that a picture is complete and supported.
    fn check_frame(&self, frame: frame::Video) -> Result<ForeignPicture, ForeignError> {
        let number = self.delivered;
        if frame.is_corrupt() || !frame.decode_error_flags().is_empty() {
            return Err(self.failed(&"parts of it cannot be decoded"));
        }
        if frame.is_interlaced() {
            return Err(ForeignError::Interlaced { frame: number });
        }
        let orientation = self.info.orientation;
        let found = orientation.swapped((frame.width(), frame.height()));
        if found != self.info.size {
            return Err(ForeignError::Size { frame: number, expected: self.info.size, found });
        }
        let layout = Layout::of(&frame).map_err(|found| ForeignError::Pixels { found })?;
        let colours = |found: String| ForeignError::Colours { found };
        let transfer = frame.color_transfer_characteristic();
        if [TransferCharacteristic::SMPTE2084, TransferCharacteristic::ARIB_STD_B67].contains(&transfer) {
            return Err(colours("high dynamic range".to_owned()));
        }
        let levels =
            Levels::of(&frame, &layout, self.rule).ok_or_else(|| colours(format!("{:?}", frame.color_space())))?;
        Ok(ForeignPicture { frame, orientation, layout, levels })
    }

    /// When the frame of a packet is over, in seconds.
    fn end_of(&self, packet: &Packet) -> f64 {
        let base = self.input.stream(self.stream).map_or(Rational::new(0, 1), |stream| stream.time_base());
        (packet.pts().unwrap_or(0) + packet.duration()) as f64 * f64::from(base)
    }

    /// Checks the number of frames or the duration against the header.
    fn check_end(&self) -> Result<(), ForeignError> {
        let found = FrameCount(self.delivered);
        match self.promised {
            Some(expected) if self.delivered.saturating_add(self.leading) < expected.0 => {
                Err(ForeignError::TooFew { expected, found })
            }
            None if self.lasts.is_some_and(|lasts| self.over < lasts - DURATION_TOLERANCE_S) => {
                Err(ForeignError::Short { expected: self.lasts.unwrap_or(0.0), found: self.over })
            }
            None if found == FrameCount(0) => Err(ForeignError::TooFew { expected: FrameCount(1), found }),
            Some(_) | None => Ok(()),
        }
    }

    fn failed(&self, reason: &impl ToString) -> ForeignError {
        ForeignError::Decode { frame: self.delivered, reason: reason.to_string() }
    }
}

impl VideoInfo {
    /// Width and height in pixels as they are stored: those by which players choose a matrix.
    pub fn stored_size(&self) -> (u32, u32) {
        self.orientation.swapped(self.size)
    }
}

impl ForeignPicture {
    /// Width and height in pixels as it is seen.
    pub fn size(&self) -> (u32, u32) {
        self.orientation.swapped((self.frame.width(), self.frame.height()))
    }

    /// The samples as a flock has them, in the same size; `None` if they are not 8-bit 4:2:0 with even sides and the chroma
    /// between two rows, or not upright: the chroma of a turned picture lies elsewhere. Samples of BT.709 limited range are
    /// not changed; those of other colours are converted.
    pub fn to_yuv420p(&self) -> Option<Yuv420p> {
        let is_upright = self.orientation == Orientation::UPRIGHT;
        is_upright.then(|| pixels::yuv420p(&self.frame, &self.layout, self.levels)).flatten()
    }

    /// The picture as it is seen, as display RGB: `[height][width][3]`, row-major, full range, gamma-coded; 0 to 1; limited
    /// range may exceed that slightly.
    pub fn to_rgb(&self) -> Vec<f32> {
        let stored = pixels::rgb(&self.frame, &self.layout, self.levels);
        self.orientation.seen(stored, (self.frame.width(), self.frame.height()))
    }
}

/// How the container has the pictures of `stream` turned and mirrored.
fn orientation(stream: &format::stream::Stream<'_>) -> Result<Orientation, ForeignError> {
    let matrix = stream.side_data().find(|data| data.kind() == Type::DisplayMatrix);
    let orientation = matrix.map_or(Ok(Orientation::UPRIGHT), |matrix| Orientation::of_matrix(matrix.data()));
    orientation.map_err(|found| ForeignError::Orientation { found })
}

/// A decoder for `stream`: with one thread and no error concealment, so that damage is reported at its frame.
fn open_decoder(stream: &format::stream::Stream<'_>) -> Result<decoder::Video, ffmpeg::Error> {
    let options = Dictionary::from_iter([("threads", "1"), ("err_detect", "+crccheck+bitstream+buffer+explode")]);
    let mut context = codec::Context::from_parameters(stream.parameters())?.decoder();
    context.set_packet_time_base(stream.time_base());
    let known = decoder::find(context.id()).ok_or(ffmpeg::Error::DecoderNotFound)?;
    context.open_as_with(known, options).and_then(decoder::Opened::video)
}

/// The number of frames that are shown, by the header: an edit list of an MP4 may hide some. Ogg tells it by its last page.
fn shown(path: &Path, input: &Input, stream: &format::stream::Stream<'_>) -> Option<FrameCount> {
    if stream.parameters().id() == codec::Id::THEORA {
        // Its clock ticks once a frame.
        return u32::try_from(stream.duration()).ok().filter(|frames| *frames > 0).map(FrameCount);
    }
    let frames = u32::try_from(stream.frames()).ok().filter(|frames| *frames > 0)?;
    if !input.format().name().starts_with("mov") {
        return Some(FrameCount(frames));
    }
    let samples = Demuxer::open(path).map(|demuxer| demuxer.samples()).unwrap_or_default();
    // The index is of another stream, or not read to its end.
    if samples.len() < frames as usize {
        return Some(FrameCount(frames));
    }
    u32::try_from(samples.iter().filter(|sample| sample.shown).count()).ok().map(FrameCount)
}

/// Checks that `path` is a file, is not empty, and is as long as its header says. Returns it, open.
fn check_file(path: &Path) -> Result<File, ForeignError> {
    let cannot = |source| ForeignError::Open { source };
    let kind = fs::metadata(path).map_err(cannot)?;
    if !kind.is_file() {
        return Err(ForeignError::NotAFile);
    }
    if kind.len() == 0 {
        return Err(ForeignError::Empty);
    }
    let file = File::open(path).map_err(cannot)?;
    match length::told(&file, kind.len()).map_err(cannot)? {
        Some(expected) if kind.len() < expected => Err(ForeignError::Cut { expected, found: kind.len() }),
        Some(_) | None => Ok(file),
    }
}

/// The file's tags about its origin.
fn tags(input: &Input) -> Vec<(String, String)> {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let tags = input.metadata();
    let told = tags.iter().map(|(key, value)| (text(key.as_bytes()), text(value.as_bytes())));
    told.filter(|(key, value)| {
        !TECHNICAL_TAGS.contains(&key.to_ascii_lowercase().as_str())
            && !value.is_empty()
            && value.len() <= MAX_TAG_BYTES
    })
    .collect()
}

/// Numerator and denominator of a fraction above 0.
fn positive(fraction: Rational) -> Option<(u32, u32)> {
    let part = |number: i32| u32::try_from(number).ok().filter(|number| *number > 0);
    part(fraction.numerator()).zip(part(fraction.denominator()))
}
