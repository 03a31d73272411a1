//! Other people's videos, frame by frame: whatever codec, container, size and pixels ffmpeg reads.
//!
//! Owns the reader for files that are brought into a flock, and everything that may be wrong with them. Never meets a
//! unit: what a flock plays is in the form, and `session.rs` reads it. Errors are told by the decoder, not concealed:
//! a clip that is damaged is to be fetched again, not copied with its damage.
//!
//! Start at [`Foreign::open`]. Reading goes through `ffmpeg-next`'s safe layer; pixels are `pixels.rs`'s.

use crate::pixels::{self, Layout, Levels};
use crate::raw;
use crate::yuv::Yuv420p;
use ffmpeg_next as ffmpeg;
use ffmpeg_next::color::TransferCharacteristic;
use ffmpeg_next::format::context::Input;
use ffmpeg_next::{Dictionary, Packet, Rational, codec, decoder, format, frame, media};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;
use timing::{FrameCount, Rate};

/// What is read: containers of video. None that lead to other files or to a network.
const CONTAINERS: &str = "avi,mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,mpeg,mpegts,mpegvideo,m4v,ogg,flv,asf,nut,ivf,h264,\
                          hevc,obu,av1,yuv4mpegpipe,gif,apng,dv,mxf,swf,rm";

/// Tags that tell how the file was made, which is no longer true of a copy in another form.
const TECHNICAL: &[&str] =
    &["encoder", "software", "major_brand", "minor_version", "compatible_brands", "duration", "creation_time"];

/// Longest tag that is kept, in bytes: a licence, not a picture.
const LONGEST_TAG: usize = 65_536;

/// By how much a length in seconds may be off: containers round times, and the last frame's length is a guess.
const ROUNDED_S: f64 = 0.2;

/// Largest side of a picture that is read, in pixels.
const LARGEST_SIDE: u32 = 16_384;

/// What a video tells of itself, before it is decoded.
#[derive(Clone, Debug, PartialEq)]
pub struct About {
    /// The codec's short name: `mpeg4`.
    pub codec: String,
    /// Width and height in pixels as they are stored.
    pub size: (u32, u32),
    /// Width and height of a pixel, relative to each other; `(1, 1)` where nothing is told.
    pub pixel: (u32, u32),
    /// Frames per second on average; `None` where nothing is told.
    pub fps: Option<Rate>,
    /// How many frames its header tells of. An AVI counts those that were left out, too.
    pub frames: Option<FrameCount>,
    /// Title, artist, copyright and the like, as `(key, value)`, in the file's order.
    pub tags: Vec<(String, String)>,
}

/// Why a video is not read, or not to its end. Messages follow a file's name: "`a.avi` is empty".
#[derive(Debug, thiserror::Error)]
pub enum ForeignError {
    /// Its colours are of another kind.
    #[error("has colours that are not read: {found}")]
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
        /// What ffmpeg said.
        reason: String,
    },
    /// It has no bytes.
    #[error("is empty")]
    Empty,
    /// Its frames are two fields of different moments.
    #[error("is interlaced at frame {frame} (expected whole frames)")]
    Interlaced {
        /// The first such frame.
        frame: u32,
    },
    /// ffmpeg takes names as text.
    #[error("has a name that is not UTF-8")]
    Name,
    /// It is a folder or a device.
    #[error("is not a file")]
    NotAFile,
    /// It is no video that ffmpeg reads.
    #[error("is not a video that can be read: {reason}")]
    NotAVideo {
        /// What ffmpeg said.
        reason: String,
    },
    /// It is missing, or the kernel refuses it.
    #[error("cannot be read")]
    Open {
        /// What the kernel said.
        source: io::Error,
    },
    /// Its pixels are in an order that is not known here.
    #[error("has pixels in a format that is not read: `{found}`")]
    Pixels {
        /// Which, in ffmpeg's words.
        found: String,
    },
    /// It is over before its header said.
    #[error("is over after {found:.2} s (expected {expected:.2} s)")]
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
        /// As its header has it, or the most there may be.
        expected: (u32, u32),
        /// As it is.
        found: (u32, u32),
    },
    /// Fewer frames came out than its header promised.
    #[error("yields {found} frames when decoded (expected {expected})")]
    TooFew {
        /// What the header promised.
        expected: FrameCount,
        /// What came out.
        found: FrameCount,
    },
}

/// A video being read.
pub struct Foreign {
    input: Input,
    decoder: decoder::Video,
    stream: usize,
    about: About,
    /// How many frames must come.
    promised: Option<FrameCount>,
    /// How long it must be, where it is told nothing but that, in seconds.
    lasts: Option<f64>,
    /// When what was read is over, in seconds.
    over: f64,
    delivered: u32,
}

/// One picture of it.
pub struct ForeignPicture {
    frame: frame::Video,
    layout: Layout,
    levels: Levels,
}

impl Foreign {
    /// Opens the video at `path` and reads its header.
    ///
    /// # Errors
    /// [`ForeignError`]; damage further inside shows when it is read.
    pub fn open(path: &Path) -> Result<Self, ForeignError> {
        raw::hush();
        look(path)?;
        let name = path.to_str().filter(|name| !name.contains('\0')).ok_or(ForeignError::Name)?;
        let not = |error: ffmpeg::Error| ForeignError::NotAVideo { reason: error.to_string() };
        let options = Dictionary::from_iter([("protocol_whitelist", "file"), ("format_whitelist", CONTAINERS)]);
        let input = format::input_with_dictionary(&format!("file:{name}"), options).map_err(not)?;
        let stream = input.streams().best(media::Type::Video).ok_or_else(|| not(ffmpeg::Error::StreamNotFound))?;
        let context = codec::Context::from_parameters(stream.parameters()).map_err(not)?;
        let codec = context.id().name().to_owned();
        // One thread, and no concealment: what is damaged is told where it is.
        let options = Dictionary::from_iter([("threads", "1"), ("err_detect", "+crccheck+bitstream+buffer+explode")]);
        let mut context = context.decoder();
        context.set_packet_time_base(stream.time_base());
        let known = decoder::find(context.id()).ok_or_else(|| not(ffmpeg::Error::DecoderNotFound))?;
        let decoder = context.open_as_with(known, options).and_then(decoder::Opened::video).map_err(not)?;
        let size = (decoder.width(), decoder.height());
        if size.0.max(size.1) > LARGEST_SIDE {
            return Err(ForeignError::Size { frame: 0, expected: (LARGEST_SIDE, LARGEST_SIDE), found: size });
        }
        let pixel = positive(decoder.aspect_ratio()).unwrap_or((1, 1));
        let rate = [stream.avg_frame_rate(), stream.rate()].into_iter().find_map(positive);
        let fps = rate.and_then(|(num, den)| Rate::new(num.into(), den.into()).ok());
        let frames = u32::try_from(stream.frames()).ok().filter(|frames| *frames > 0).map(FrameCount);
        // That an AVI is whole is known by its length alone: see `look`.
        let promised = frames.filter(|_| input.format().name() != "avi");
        // Matroska tells no number of frames; of several streams any may be the longest.
        let lasts = (input.duration() > 0 && frames.is_none() && input.nb_streams() == 1)
            .then(|| input.duration() as f64 / f64::from(ffmpeg::ffi::AV_TIME_BASE));
        let lasts = lasts.filter(|_| input.format().name().starts_with("matroska"));
        let about = About { codec, size, pixel, fps, frames, tags: tags(&input) };
        let stream = stream.index();
        Ok(Self { input, decoder, stream, about, promised, lasts, over: 0.0, delivered: 0 })
    }

    /// What it tells of itself.
    pub fn about(&self) -> &About {
        &self.about
    }

    /// Its next picture, in the order of showing; `None` once all have come, as many as its header promised.
    ///
    /// # Errors
    /// [`ForeignError`] where it is damaged, or is of a kind that is not read. It is of no more use then.
    pub fn picture(&mut self) -> Result<Option<ForeignPicture>, ForeignError> {
        let mut frame = frame::Video::empty();
        loop {
            match self.decoder.receive_frame(&mut frame) {
                Ok(()) => {
                    let picture = self.judged(frame)?;
                    self.delivered += 1;
                    return Ok(Some(picture));
                }
                Err(ffmpeg::Error::Eof) => return self.ended().map(|()| None),
                Err(ffmpeg::Error::Other { errno: ffmpeg::error::EAGAIN }) => self.feed()?,
                Err(error) => return Err(self.failed(&error)),
            }
        }
    }

    /// Gives the decoder the next packet, or tells it that there is none.
    fn feed(&mut self) -> Result<(), ForeignError> {
        loop {
            let mut packet = Packet::empty();
            match packet.read(&mut self.input) {
                Ok(()) if packet.stream() != self.stream || packet.size() == 0 => (),
                Ok(()) if packet.is_corrupt() => return Err(self.failed(&"its bytes are not all there")),
                Ok(()) => {
                    self.over = self.over.max(self.end_of(&packet));
                    return self.decoder.send_packet(&packet).map_err(|error| self.failed(&error));
                }
                Err(ffmpeg::Error::Eof) => return self.decoder.send_eof().map_err(|error| self.failed(&error)),
                Err(error) => return Err(self.failed(&error)),
            }
        }
    }

    /// A picture that is whole and that we can read.
    fn judged(&self, frame: frame::Video) -> Result<ForeignPicture, ForeignError> {
        let number = self.delivered;
        if frame.is_corrupt() || !frame.decode_error_flags().is_empty() {
            return Err(self.failed(&"parts of it would be guessed"));
        }
        if frame.is_interlaced() {
            return Err(ForeignError::Interlaced { frame: number });
        }
        let found = (frame.width(), frame.height());
        if found != self.about.size {
            return Err(ForeignError::Size { frame: number, expected: self.about.size, found });
        }
        let descriptor = frame.format().descriptor();
        let name = descriptor.map_or("unknown", |descriptor| descriptor.name());
        let shared = descriptor.map_or([0; 2], |format| [format.log2_chroma_w().into(), format.log2_chroma_h().into()]);
        let unread = || ForeignError::Pixels { found: name.to_owned() };
        let layout = Layout::of(name, shared).ok_or_else(unread)?;
        // Rows from the bottom up are told by negative distances.
        let upright = |plane| plane < frame.planes() && isize::try_from(frame.stride(plane)).is_ok();
        if !(0..layout.planes()).all(upright) {
            return Err(ForeignError::Pixels { found: format!("{name}, bottom row first") });
        }
        let colours = |found: String| ForeignError::Colours { found };
        let transfer = frame.color_transfer_characteristic();
        if [TransferCharacteristic::SMPTE2084, TransferCharacteristic::ARIB_STD_B67].contains(&transfer) {
            return Err(colours("high dynamic range".to_owned()));
        }
        let levels = Levels::of(&frame, &layout).ok_or_else(|| colours(format!("{:?}", frame.color_space())))?;
        Ok(ForeignPicture { frame, layout, levels })
    }

    /// When the frame of a packet is over, in seconds.
    fn end_of(&self, packet: &Packet) -> f64 {
        let base = self.input.stream(self.stream).map_or(Rational::new(0, 1), |stream| stream.time_base());
        (packet.pts().unwrap_or(0) + packet.duration()) as f64 * f64::from(base)
    }

    /// Whether all came that was promised.
    fn ended(&self) -> Result<(), ForeignError> {
        let found = FrameCount(self.delivered);
        match self.promised {
            Some(expected) if found < expected => Err(ForeignError::TooFew { expected, found }),
            None if self.lasts.is_some_and(|lasts| self.over < lasts - ROUNDED_S) => {
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

impl ForeignPicture {
    /// Width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.frame.width(), self.frame.height())
    }

    /// The very samples, where they are of the kind that a flock's clips have and their sides are even: nothing is
    /// converted then, so nothing is lost.
    pub fn as_it_is(&self) -> Option<Yuv420p> {
        if !self.layout.is_yuv420p() || !self.levels.are_the_flocks() {
            return None;
        }
        let (width, height) = self.size();
        let rows = |plane: usize| {
            let half = u32::from(plane > 0);
            let rows = self.frame.data(plane).chunks(self.frame.stride(plane)).take((height >> half) as usize);
            rows.flat_map(move |row| &row[..(width >> half) as usize]).copied()
        };
        let samples: Vec<u8> = (0..3).flat_map(rows).collect();
        Yuv420p::from_planes(width, height, &samples).ok()
    }

    /// The picture as display RGB: `[height][width][3]`, row-major, full range, gamma-coded; 0 to 1 but for the little
    /// that limited levels have to spare.
    pub fn to_rgb(&self) -> Vec<f32> {
        pixels::rgb(&self.frame, &self.layout, self.levels)
    }
}

/// Whether there is a file with bytes at `path`, and all of them as far as its head tells.
fn look(path: &Path) -> Result<(), ForeignError> {
    let cannot = |source| ForeignError::Open { source };
    let kind = fs::metadata(path).map_err(cannot)?;
    if !kind.is_file() {
        return Err(ForeignError::NotAFile);
    }
    if kind.len() == 0 {
        return Err(ForeignError::Empty);
    }
    let mut head = Vec::new();
    File::open(path).and_then(|file| file.take(8).read_to_end(&mut head)).map_err(cannot)?;
    // An AVI begins with `RIFF` and how many bytes follow. ffmpeg would read what is left of it without a word.
    if let [b'R', b'I', b'F', b'F', size @ ..] = &head[..]
        && let Ok(size) = <[u8; 4]>::try_from(size)
    {
        let expected = u64::from(u32::from_le_bytes(size)) + 8;
        if kind.len() < expected {
            return Err(ForeignError::Cut { expected, found: kind.len() });
        }
    }
    Ok(())
}

/// What the file tells of its origin.
fn tags(input: &Input) -> Vec<(String, String)> {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let tags = input.metadata();
    let told = tags.iter().map(|(key, value)| (text(key.as_bytes()), text(value.as_bytes())));
    told.filter(|(key, value)| {
        !TECHNICAL.contains(&key.to_ascii_lowercase().as_str()) && !value.is_empty() && value.len() <= LONGEST_TAG
    })
    .collect()
}

/// Numerator and denominator of a fraction above 0.
fn positive(fraction: Rational) -> Option<(u32, u32)> {
    let part = |number: i32| u32::try_from(number).ok().filter(|number| *number > 0);
    part(fraction.numerator()).zip(part(fraction.denominator()))
}
