//! Makes clips in the flock's form.
//!
//! Owns the settings of x264 and of the MP4 file that give the flock's form, and that a file under its final name is
//! complete. Pictures and quality are arguments.
//!
//! The form is defined in `form.rs`; tests probe that our clips are in it.

use crate::code;
use crate::form::Form;
use crate::fragments;
use crate::raw;
use crate::yuv::Yuv420p;
use ffmpeg_next as ffmpeg;
use ffmpeg_next::{Dictionary, Packet, Rational, codec, format, frame};
use std::ffi::OsString;
use std::fs::{self, File};
use std::io;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use timing::{FrameCount, Rate};

/// Encoder threads. With more than one, x264's rate control depends on thread timing: one thread gives the same clip on
/// every run and machine.
const THREADS: &str = "1";

/// x264's presets. Presets and factors are checked here because x264 prints to stderr when it refuses one.
const PRESETS: [&str; 10] =
    ["ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow", "slower", "veryslow", "placebo"];

/// Most ticks of a second, and of a frame.
const MAX_TICKS: u32 = 1_000_000_000;

/// The quality and size of a clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality<'a> {
    /// x264's constant rate factor, above 0.0 (which would be lossless, and outside High) to 51.0; for art on a wall 16
    /// to 20, or 20 to 24 with [`Tuning::Gradients`].
    pub crf: f32,
    /// x264's preset: `ultrafast` to `placebo`.
    pub preset: &'a str,
    /// Which parts of a picture get more bits.
    pub tuning: Tuning,
    /// No second of the clip may take more bits than this, on average over two seconds.
    pub max_bits_per_second: Option<u32>,
}

/// Which parts of a picture get more bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tuning {
    /// Those that x264 prefers, which is made for film.
    Film,
    /// Dark ones and smooth ones. There x264 leaves blocks of one colour, which are seen at night, and removes the dither
    /// that would hide them.
    Gradients,
}

impl Tuning {
    /// The parameters of x264, which each begin with a colon.
    #[must_use]
    pub fn parameters(self) -> &'static str {
        match self {
            Self::Film => "",
            // Chosen by eye, on dark gradients at four times their brightness. Adaptive quantisation, for the dark ones above
            // all; finer colours; small coefficients, which are the dither, are kept; and moving parts lose less.
            Self::Gradients => {
                ":aq-mode=3:aq-strength=1.4:chroma-qp-offset=-4:trellis=0:deadzone-inter=6:deadzone-intra=6\
                 :no-dct-decimate=1:qcomp=0.8"
            }
        }
    }
}

/// Why a clip was not encoded. The file under its final name is unchanged.
#[derive(Debug, thiserror::Error)]
pub enum EncodeError {
    /// x264 or the MP4 muxer failed.
    #[error("cannot encode clip `{path}`: {step}: {reason}")]
    Encode {
        /// The clip.
        path: PathBuf,
        /// What was being done.
        step: &'static str,
        /// The message of ffmpeg.
        reason: String,
    },
    /// x264 has no such rate factor, or none within the form.
    #[error("cannot encode clip `{path}`: rate factor {found} is out of range (expected above 0, at most 51)")]
    Factor {
        /// The clip.
        path: PathBuf,
        /// The requested value.
        found: f32,
    },
    /// The name is not UTF-8.
    #[error("cannot encode clip `{path}`: the name is not UTF-8")]
    Name {
        /// The clip.
        path: PathBuf,
    },
    /// x264 has no such preset.
    #[error("cannot encode clip `{path}`: x264 has no preset `{found}` (expected one of {})", PRESETS.join(", "))]
    Preset {
        /// The clip.
        path: PathBuf,
        /// The requested value.
        found: String,
    },
    /// MP4 and ffmpeg count a second in ticks of at most 31 bits.
    #[error("cannot encode clip `{path}`: numerator or denominator of {found} frames per second is above {MAX_TICKS}")]
    Rate {
        /// The clip.
        path: PathBuf,
        /// The requested value.
        found: Rate,
    },
    /// A picture is not of the form's size.
    #[error("frame {frame} of clip `{path}` has {found_width}x{found_height} pixels (expected {width}x{height})")]
    Size {
        /// The clip.
        path: PathBuf,
        /// The frame, from 0.
        frame: u32,
        /// The form's width.
        width: u32,
        /// The form's height.
        height: u32,
        /// The picture's width.
        found_width: u32,
        /// The picture's height.
        found_height: u32,
    },
    /// The finished file could not be put in its place.
    #[error("cannot write clip `{path}`")]
    Write {
        /// The clip.
        path: PathBuf,
        /// The kernel error.
        source: io::Error,
    },
}

/// A clip being encoded. If it is dropped before [`Encoder::finish`], its temporary file is removed.
pub struct Encoder {
    path: PathBuf,
    part: Part,
    form: Form,
    video: codec::encoder::video::Encoder,
    output: format::context::Output,
    pushed: u32,
}

/// The file under its temporary name, removed unless it was kept.
struct Part {
    path: PathBuf,
    kept: bool,
}

impl Part {
    /// Creates the file of the clip `path`. It is created with a system call: its errors name the cause.
    fn create(path: &Path, form: &Form, quality: Quality<'_>) -> Result<(Self, File), EncodeError> {
        raw::redirect_log();
        Encoder::check(path, form, quality)?;
        let mut name: OsString = path.as_os_str().to_owned();
        name.push(".part");
        let part = Part { path: name.into(), kept: false };
        if part.path.to_str().is_none_or(|name| name.contains('\0')) {
            return Err(EncodeError::Name { path: path.to_owned() });
        }
        let file = File::create(&part.path);
        let file = file.map_err(|source| EncodeError::Write { path: path.to_owned(), source })?;
        Ok((part, file))
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        if !self.kept {
            // If that fails too, the file name still marks it as temporary.
            let _ = fs::remove_file(&self.path);
        }
    }
}

impl Encoder {
    /// Checks what can be checked before the first frame.
    ///
    /// # Errors
    /// [`EncodeError::Factor`], [`EncodeError::Preset`] or [`EncodeError::Rate`].
    pub fn check(path: &Path, form: &Form, quality: Quality<'_>) -> Result<(), EncodeError> {
        let path = || path.to_owned();
        if !PRESETS.contains(&quality.preset) {
            return Err(EncodeError::Preset { path: path(), found: quality.preset.to_owned() });
        }
        if !(quality.crf > 0.0 && quality.crf <= 51.0) {
            return Err(EncodeError::Factor { path: path(), found: quality.crf });
        }
        if form.fps.num().max(form.fps.den()) > MAX_TICKS {
            return Err(EncodeError::Rate { path: path(), found: form.fps });
        }
        Ok(())
    }

    /// Starts the clip `path` in the flock's form. It is written to `PATH.part` first.
    ///
    /// # Errors
    /// [`EncodeError`] if x264 does not know the preset, or the file cannot be created.
    pub fn create(path: &Path, form: &Form, quality: Quality<'_>) -> Result<Self, EncodeError> {
        Self::create_tagged(path, form, quality, &[])
    }

    /// Starts a clip as [`Encoder::create`] does, with tags, `(key, value)`, about its origin: title, artist,
    /// copyright, or any other. Keys and values are written unchanged.
    ///
    /// # Errors
    /// As [`Encoder::create`].
    pub fn create_tagged(
        path: &Path,
        form: &Form,
        quality: Quality<'_>,
        tags: &[(String, String)],
    ) -> Result<Self, EncodeError> {
        let (part, _) = Part::create(path, form, quality)?;
        let at = |step| move |error: ffmpeg::Error| EncodeError::encode(path, step, error);
        let video = x264(form, quality, None).map_err(at("start x264"))?;
        let mut output = format::output_as(&part.path, "mp4").map_err(at("open the file"))?;
        // `use_metadata_tags` writes any key; without it MP4 has about a dozen, and no licence among them.
        let flags = if tags.is_empty() { "+faststart" } else { "+faststart+use_metadata_tags" };
        // C strings end at a zero byte: such tags are left out.
        let told = tags.iter().filter(|(key, value)| !key.contains('\0') && !value.contains('\0'));
        output.set_metadata(told.map(|(key, value)| (key.as_str(), value.as_str())).collect());
        Self::start(path, part, form, video, output, &[("movflags", flags)])
    }

    /// Starts a clip that others read while it is written: `PATH.part` grows by a fragment as [`fragment`] writes it after
    /// every `group` frames (1 or more). The pictures take more bits than those of [`Encoder::create`].
    ///
    /// # Errors
    /// As [`Encoder::create`].
    ///
    /// [`fragment`]: crate::fragment
    pub fn create_growing(
        path: &Path,
        form: &Form,
        quality: Quality<'_>,
        group: NonZero<u32>,
    ) -> Result<Self, EncodeError> {
        let (part, file) = Part::create(path, form, quality)?;
        let at = |step| move |error: ffmpeg::Error| EncodeError::encode(path, step, error);
        let video = x264(form, quality, Some(group)).map_err(at("start x264"))?;
        let output = fragments::output(file).map_err(at("open the file"))?;
        let header = [("movflags", fragments::FLAGS), ("flush_packets", "1")];
        Self::start(path, part, form, video, output, &header)
    }

    /// Writes the header.
    fn start(
        path: &Path,
        part: Part,
        form: &Form,
        video: codec::encoder::video::Encoder,
        mut output: format::context::Output,
        header: &[(&str, &str)],
    ) -> Result<Self, EncodeError> {
        let at = |step| move |error: ffmpeg::Error| EncodeError::encode(path, step, error);
        let mut stream = output.add_stream_with(&video).map_err(at("add the stream"))?;
        stream.set_time_base(time_base(form));
        stream.set_avg_frame_rate(time_base(form).invert());
        let header = header.iter().copied().chain([("fflags", "+bitexact")]).collect();
        output.write_header_with(header).map_err(at("write the header"))?;
        Ok(Self { path: path.to_owned(), part, form: *form, video, output, pushed: 0 })
    }

    /// Adds the next frame.
    ///
    /// # Errors
    /// [`EncodeError::Size`] leaves the clip as it was; after any other error it cannot be finished.
    pub fn push(&mut self, picture: &Yuv420p) -> Result<(), EncodeError> {
        let (width, height) = self.form.size;
        let (found_width, found_height) = picture.size();
        if (width, height) != (found_width, found_height) {
            let (path, frame) = (self.path.clone(), self.pushed);
            return Err(EncodeError::Size { path, frame, width, height, found_width, found_height });
        }
        let mut frame = frame::Video::new(format::Pixel::YUV420P, width, height);
        for (plane, rows) in picture.planes().into_iter().enumerate() {
            let row = picture.strides()[plane];
            let stride = frame.stride(plane);
            for (to, from) in frame.data_mut(plane).chunks_mut(stride).zip(rows.chunks(row)) {
                to[..row].copy_from_slice(from);
            }
        }
        frame.set_pts(Some(self.pushed.into()));
        self.video.send_frame(&frame).map_err(|error| EncodeError::encode(&self.path, "encode", error))?;
        self.pushed += 1;
        self.write_packets()
    }

    /// Flushes x264, syncs the file and renames it to its final name. Returns its number of frames.
    ///
    /// # Errors
    /// [`EncodeError`]; a clip that had the name before is still there.
    pub fn finish(self) -> Result<FrameCount, EncodeError> {
        self.finish_with(durable::persist)
    }

    /// Finishes the clip as [`Encoder::finish`] does, but leaves it to the caller to sync it: for one who makes many
    /// clips and syncs them together.
    ///
    /// # Errors
    /// As [`Encoder::finish`].
    pub fn finish_unsynced(self) -> Result<FrameCount, EncodeError> {
        self.finish_with(|part, path| fs::rename(part, path))
    }

    fn finish_with(mut self, keep: impl Fn(&Path, &Path) -> io::Result<()>) -> Result<FrameCount, EncodeError> {
        self.video.send_eof().map_err(|error| EncodeError::encode(&self.path, "finish x264", error))?;
        self.write_packets()?;
        self.output.write_trailer().map_err(|error| EncodeError::encode(&self.path, "write the index", error))?;
        let Self { path, mut part, video, output, pushed, .. } = self;
        drop((video, output));
        keep(&part.path, &path).map_err(|source| EncodeError::Write { path, source })?;
        part.kept = true;
        Ok(FrameCount(pushed))
    }

    fn write_packets(&mut self) -> Result<(), EncodeError> {
        let failed = |error| EncodeError::encode(&self.path, "write a packet", error);
        let base = self.output.stream(0).map_or(time_base(&self.form), |stream| stream.time_base());
        let mut packet = Packet::empty();
        loop {
            match self.video.receive_packet(&mut packet) {
                Err(ffmpeg::Error::Eof | ffmpeg::Error::Other { errno: ffmpeg::error::EAGAIN }) => return Ok(()),
                taken => taken.map_err(|error| EncodeError::encode(&self.path, "take a packet", error))?,
            }
            packet.set_stream(0);
            packet.set_duration(1);
            packet.rescale_ts(time_base(&self.form), base);
            packet.write_interleaved(&mut self.output).map_err(failed)?;
        }
    }
}

impl EncodeError {
    fn encode(path: &Path, step: &'static str, error: ffmpeg::Error) -> Self {
        Self::Encode { path: path.to_owned(), step, reason: code::text(error) }
    }
}

/// Seconds per frame.
fn time_base(form: &Form) -> Rational {
    let int = |n: u32| i32::try_from(n).unwrap_or(i32::MAX);
    Rational::new(int(form.fps.den()), int(form.fps.num()))
}

/// x264, set to the flock's form; with a keyframe after every `group` frames, and without delay, if there is one.
fn x264(
    form: &Form,
    quality: Quality<'_>,
    group: Option<NonZero<u32>>,
) -> Result<codec::encoder::video::Encoder, ffmpeg::Error> {
    let x264 = codec::encoder::find_by_name("libx264").ok_or(ffmpeg::Error::EncoderNotFound)?;
    let mut video = codec::Context::new_with_codec(x264).encoder().video()?;
    video.set_width(form.size.0);
    video.set_height(form.size.1);
    video.set_format(format::Pixel::YUV420P);
    video.set_time_base(time_base(form));
    video.set_frame_rate(Some(time_base(form).invert()));
    video.set_aspect_ratio(Rational::new(1, 1));
    video.set_flags(codec::Flags::GLOBAL_HEADER);
    let mut options = Dictionary::from_iter([
        ("preset", quality.preset),
        ("profile", "high"),
        ("threads", THREADS),
        ("color_primaries", "bt709"),
        ("color_trc", "bt709"),
        ("colorspace", "bt709"),
        ("color_range", "tv"),
    ]);
    let tuning = quality.tuning.parameters();
    // 8x8dct: without it x264 marks the stream as Main. open-gop: off by default, but the form depends on it.
    // cpu-independent: else `mbtree` adds up otherwise on each kind of processor, and with AVX-512 reads memory that
    // nothing was written to (x264 0.164, seen with 64x36).
    let prompt = group.map_or_else(String::new, |group| {
        format!(":keyint={group}:min-keyint={group}:scenecut=0:bframes=0:rc-lookahead=0:sync-lookahead=0")
    });
    options.set("x264-params", &format!("repeat-headers=1:open-gop=0:8x8dct=1:cpu-independent=1{tuning}{prompt}"));
    options.set("crf", &quality.crf.to_string());
    if let Some(bits) = quality.max_bits_per_second {
        options.set("maxrate", &bits.to_string());
        options.set("bufsize", &bits.saturating_mul(2).min(i32::MAX.unsigned_abs()).to_string());
    }
    video.open_with(options)
}
