//! A copy of a clip that a browser takes in pieces: fragmented MP4, for Media Source Extensions.
//!
//! Owns the flags of ffmpeg's muxer for it. Packets are copied, none is decoded or encoded. Times begin at 0, each packet's
//! decoding time is that of its place, and where pictures are reordered composition offsets are negative: a clip then fills
//! exactly its frames, so that clips appended one after the other leave no hole.
//!
//! Start at [`fragment`]; `encoder.rs` writes new pictures in the same form.

use crate::code;
use crate::packets::codec;
use crate::probe::{self, ProbeError};
use crate::raw::redirect_log;
use ffmpeg_next as ffmpeg;
use ffmpeg_next::format::context::{Output, StreamIo};
use ffmpeg_next::{Dictionary, Packet, format, media};
use std::fs::{self, File};
use std::io;
use std::os::fd::AsRawFd;
use std::path::{Path, PathBuf};
use timing::FrameCount;

/// One fragment for each group of pictures, each readable without what follows it.
pub(crate) const FLAGS: &str = "+frag_keyframe+empty_moov+default_base_moof+negative_cts_offsets";

/// What a browser must know of a fragmented copy before it takes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fragments {
    /// The codec as RFC 6381 writes it: `avc1.640020`.
    pub codec: String,
    /// How many frames it shows.
    pub frames: FrameCount,
}

/// Why there is no fragmented copy. A file that had its name before is unchanged.
#[derive(Debug, thiserror::Error)]
pub enum FragmentError {
    /// The clip has pictures that are decoded and not shown: they would cover the end of the clip before it.
    #[error("clip `{path}` has {hidden} frames that its edit list hides")]
    Hidden {
        /// The clip.
        path: PathBuf,
        /// How many.
        hidden: usize,
    },
    /// ffmpeg failed.
    #[error("cannot copy the packets of clip `{path}`: {step}: {reason}")]
    Mux {
        /// The clip.
        path: PathBuf,
        /// What was being done.
        step: &'static str,
        /// The message of ffmpeg.
        reason: String,
    },
    /// The clip cannot be opened.
    #[error(transparent)]
    Probe(#[from] ProbeError),
    /// The copy could not be written.
    #[error("cannot write `{path}`")]
    Write {
        /// The copy.
        path: PathBuf,
        /// The kernel error.
        source: io::Error,
    },
}

/// Writes a fragmented copy of the clip at `path` to `copy`: first to `COPY.part`, which is then renamed.
///
/// # Errors
/// [`FragmentError`] if `path` is no whole H.264 clip, or `copy` cannot be written.
pub fn fragment(path: &Path, copy: &Path) -> Result<Fragments, FragmentError> {
    redirect_log();
    let opened = probe::open(path)?;
    let hidden = opened.demuxer.samples().iter().filter(|sample| !sample.shown).count();
    if hidden > 0 {
        return Err(FragmentError::Hidden { path: path.to_owned(), hidden });
    }
    let codec = codec(opened.demuxer.configuration()).unwrap_or_default();
    let frames = opened.probe.frames;
    let mut name = copy.as_os_str().to_owned();
    name.push(".part");
    let part = PathBuf::from(name);
    let write = |source| FragmentError::Write { path: copy.to_owned(), source };
    let file = File::create(&part).map_err(write)?;
    let copied = copy_packets(path, &opened.file, file);
    let copied = copied.and_then(|()| durable::persist(&part, copy).map_err(write));
    if copied.is_err() {
        // It is useless, and the disk may be full.
        let _ = fs::remove_file(&part);
    }
    copied.map(|()| Fragments { codec, frames })
}

/// Copies the packets of the video in `clip`, the open file at `path`, to `to`.
fn copy_packets(path: &Path, clip: &File, to: File) -> Result<(), FragmentError> {
    let at = |step| {
        move |error: ffmpeg::Error| FragmentError::Mux { path: path.to_owned(), step, reason: code::text(error) }
    };
    // The safe layer takes names as text only; the kernel has another name for an open file.
    let name = format!("file:/proc/self/fd/{}", clip.as_raw_fd());
    let options = Dictionary::from_iter([("protocol_whitelist", "file"), ("format_whitelist", "mov,mp4")]);
    let mut input = format::input_with_dictionary(&name, options).map_err(at("open it"))?;
    let stream = input.streams().best(media::Type::Video).ok_or_else(|| at("find the video")(missing()))?;
    let (index, from) = (stream.index(), stream.time_base());
    let mut output = output(to).map_err(at("open the copy"))?;
    let mut added = output.add_stream(ffmpeg::codec::Id::H264).map_err(at("add the stream"))?;
    added.set_parameters(stream.parameters());
    added.set_time_base(from);
    added.set_avg_frame_rate(stream.avg_frame_rate());
    let header = Dictionary::from_iter([("movflags", FLAGS), ("fflags", "+bitexact")]);
    output.write_header_with(header).map_err(at("write the header"))?;
    let base = output.stream(0).map_or(from, |stream| stream.time_base());
    let mut packet = Packet::empty();
    loop {
        match packet.read(&mut input) {
            Err(ffmpeg::Error::Eof) => break,
            read => read.map_err(at("read a packet"))?,
        }
        if packet.stream() == index {
            packet.set_stream(0);
            packet.set_position(-1);
            packet.rescale_ts(from, base);
            packet.write_interleaved(&mut output).map_err(at("write a packet"))?;
        }
    }
    output.write_trailer().map_err(at("write the end"))
}

/// A muxer of MP4 that writes to `file` and never goes back in it.
pub(crate) fn output(file: File) -> Result<Output, ffmpeg::Error> {
    format::output_to_stream(StreamIo::from_write(file)?, None, Some("mp4"))
}

fn missing() -> ffmpeg::Error {
    ffmpeg::Error::StreamNotFound
}
