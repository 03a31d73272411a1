//! The properties of a clip, read from its file.
//!
//! Owns [`Probe`]: the header, the container's index, the first access unit and, on request, every packet. Only
//! [`decode_whole`] decodes pictures: it runs the whole clip through a session as a unit does.
//!
//! Next: `form.rs` compares a probe with the flock's form.

use crate::clip::Clip;
use crate::code::Code;
use crate::damage::Damage;
use crate::form::COLOUR;
use crate::index;
use crate::nal::{self, Kind};
use crate::raw::{Demuxer, Packet};
use crate::session::{Poll, Session};
use crate::sps::Sps;
use rustix::io::Errno;
use std::fs::{self, File};
use std::io;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use timing::{FrameCount, Rate};

/// One sample of a clip as the container's index lists it.
pub(crate) struct Sample {
    /// First byte in the file.
    pub(crate) offset: u64,
    /// Bytes in the file.
    pub(crate) bytes: u64,
    /// Decoding time in ticks of the demuxer's time base.
    pub(crate) dts: i64,
    /// Whether it is shown: an edit list may discard it.
    pub(crate) shown: bool,
    /// Whether decoding can start there.
    pub(crate) key: bool,
}

/// What a clip is.
#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "independent findings, each compared on its own")]
pub struct Probe {
    /// The codec's short name: `h264`. The fields below it are only filled for H.264.
    pub codec: String,
    /// The profile's name: `High`, `Main`, `Constrained Baseline`, else `profile N`.
    pub profile: String,
    /// `yuv420p`, else chroma format and depth in words.
    pub pixel_format: String,
    /// Visible width and height, by the stream's own parameter set where it has one.
    pub size: (u32, u32),
    /// Frames per second; `None` where frames are not evenly spaced.
    pub fps: Option<Rate>,
    /// How many frames are shown.
    pub frames: FrameCount,
    /// Whether the first access unit is an IDR picture.
    pub starts_with_idr: bool,
    /// Whether that access unit carries its parameter sets.
    pub parameter_sets_in_band: bool,
    /// Primaries, transfer, matrix and range: `bt709 bt709 bt709 limited`.
    pub colour: String,
    /// Whether every picture is a whole frame.
    pub progressive: bool,
    /// Whether pixels are square, or their shape is not stated.
    pub square_pixels: bool,
    /// Whether the parameter set states how many pictures the decoder must hold back.
    pub reorder_told: bool,
    /// Whether every GOP is closed, as far as the packets read can tell.
    pub closed_gop: bool,
}

/// Why a file cannot be probed.
#[derive(Debug, thiserror::Error)]
pub enum ProbeError {
    /// It has no bytes.
    #[error("clip `{path}` is empty")]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// It is a folder, a device or the like.
    #[error("clip `{path}` is not a file but a {found}")]
    NotAFile {
        /// The path.
        path: PathBuf,
        /// What it is.
        found: &'static str,
    },
    /// It is no MP4 file with a video stream, or its header is damaged.
    #[error("clip `{path}` is not an MP4 video: {reason}")]
    NotAVideo {
        /// The file.
        path: PathBuf,
        /// The message of ffmpeg.
        reason: String,
    },
    /// It is missing, or the kernel refuses it.
    #[error("cannot open clip `{path}`")]
    Open {
        /// The file.
        path: PathBuf,
        /// The kernel error.
        source: io::Error,
    },
    /// Its packets cannot be read.
    #[error("cannot read clip `{path}` at frame {frame}: {reason}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The first frame that cannot be read, in decoding order.
        frame: u32,
        /// The message of ffmpeg.
        reason: String,
    },
    /// The end of the file is missing.
    #[error("clip `{path}` is cut short: {found} bytes (expected at least {expected})")]
    Truncated {
        /// The file.
        path: PathBuf,
        /// Where its last packet ends by its own index, in bytes.
        expected: u64,
        /// How long it is, in bytes.
        found: u64,
    },
}

/// Reads the properties of the clip at `path` from its header and all its packets. Nothing is decoded.
///
/// # Errors
/// [`ProbeError`] if it is no complete video file. See [`Probe`] for whether it is in the form.
pub fn probe(path: &Path) -> Result<Probe, ProbeError> {
    let mut opened = open(path)?;
    let mut scan = Scan { shown: Vec::new(), closed_gop: opened.probe.closed_gop };
    let mut packet = opened.first;
    let mut index = 0u32;
    loop {
        scan.packet(&mut packet).map_err(|reason| unreadable(path, index, reason))?;
        index += 1;
        if !opened.demuxer.read(&mut packet).map_err(|code| unreadable(path, index, code))? {
            break;
        }
    }
    if !scan.evenly_spaced() {
        opened.probe.fps = None;
    }
    opened.probe.frames = FrameCount(u32::try_from(scan.shown.len()).unwrap_or(u32::MAX));
    opened.probe.closed_gop = scan.closed_gop;
    Ok(opened.probe)
}

/// Decodes the whole clip as a unit does, and returns the number of frames.
///
/// # Errors
/// The first [`Damage`]: a frame that cannot be decoded, has concealed errors, or is missing.
pub fn decode_whole(path: &Path, threads: NonZero<usize>) -> Result<FrameCount, Damage> {
    let unreadable = |reason: String| Damage::Unreadable { frame: 0, reason };
    let mut session = Session::new(threads).map_err(|error| unreadable(error.to_string()))?;
    session.push(Clip::open_any(path).map_err(|error| unreadable(error.to_string()))?);
    session.finish();
    loop {
        match session.poll() {
            Poll::Frame(_) | Poll::Starved => (),
            Poll::ClipEnd { frames, damage, .. } => return damage.into_iter().next().map_or(Ok(frames), Err),
            Poll::Finished => return Err(unreadable("no frame was decoded".into())),
            Poll::Failed(error) => return Err(unreadable(error.to_string())),
        }
    }
}

/// An open clip: header, index and first packet are read.
pub(crate) struct OpenedClip {
    pub(crate) demuxer: Demuxer,
    pub(crate) first: Packet,
    pub(crate) probe: Probe,
    pub(crate) file: File,
}

/// Opens `path` and reads header, index and first packet.
pub(crate) fn open(path: &Path) -> Result<OpenedClip, ProbeError> {
    let (file, bytes) = open_file(path)?;
    let not_a_video = |code: Code| ProbeError::NotAVideo { path: path.to_owned(), reason: code.to_string() };
    index::check(&file, bytes)
        .map_err(|error| ProbeError::NotAVideo { path: path.to_owned(), reason: error.to_string() })?;
    let mut demuxer = Demuxer::open(path).map_err(|code| match code.system() {
        Some(source) if is_shortage(&source) => ProbeError::Open { path: path.to_owned(), source },
        _ => not_a_video(code),
    })?;
    let samples = demuxer.samples();
    let expected = samples.iter().map(|s| s.offset.saturating_add(s.bytes)).max().unwrap_or(0);
    if expected > bytes {
        return Err(ProbeError::Truncated { path: path.to_owned(), expected, found: bytes });
    }
    let mut first = Packet::new().map_err(not_a_video)?;
    if !demuxer.read(&mut first).map_err(|code| unreadable(path, 0, code))? {
        return Err(unreadable(path, 0, "no packets"));
    }
    let times: Vec<i64> = samples.iter().map(|sample| sample.dts).collect();
    let shown = samples.iter().filter(|sample| sample.shown).count();
    let unit = first.bytes_mut().map_err(|code| unreadable(path, 0, code))?;
    let look = FirstAccessUnit::at(unit, demuxer.configuration());
    let sps = look.sps.as_ref();
    let pixel = sps.and_then(|sps| sps.pixel);
    let probe = Probe {
        codec: demuxer.codec(),
        profile: sps.map_or("unknown".into(), profile),
        pixel_format: sps.map_or("unknown".into(), pixel_format),
        size: sps.map_or_else(|| demuxer.size(), |sps| sps.size),
        fps: rate(&times, demuxer.time_base()),
        frames: FrameCount(u32::try_from(shown).unwrap_or(u32::MAX)),
        starts_with_idr: look.idr,
        parameter_sets_in_band: look.in_band,
        colour: sps.map_or("unknown".into(), colour),
        progressive: sps.is_some_and(|sps| sps.progressive),
        square_pixels: pixel.is_none_or(|(width, height)| width == height),
        reorder_told: sps.is_some_and(|sps| sps.reorder.is_some()),
        closed_gop: true,
    };
    Ok(OpenedClip { demuxer, first, probe, file })
}

/// Opens a regular, non-empty file; returns its size.
fn open_file(path: &Path) -> Result<(File, u64), ProbeError> {
    let cannot = |source| ProbeError::Open { path: path.to_owned(), source };
    let kind = fs::metadata(path).map_err(cannot)?;
    if !kind.is_file() {
        let found = if kind.is_dir() { "folder" } else { "device" };
        return Err(ProbeError::NotAFile { path: path.to_owned(), found });
    }
    if kind.len() == 0 {
        return Err(ProbeError::Empty { path: path.to_owned() });
    }
    Ok((File::open(path).map_err(cannot)?, kind.len()))
}

/// Whether the error is a shortage of descriptors or memory, which may pass.
pub fn is_shortage(error: &io::Error) -> bool {
    let found = error.raw_os_error().map(Errno::from_raw_os_error);
    matches!(found, Some(Errno::MFILE | Errno::NFILE | Errno::NOMEM))
}

fn unreadable(path: &Path, frame: u32, reason: impl Into<String>) -> ProbeError {
    ProbeError::Read { path: path.to_owned(), frame, reason: reason.into() }
}

/// The properties in the first access unit.
struct FirstAccessUnit {
    idr: bool,
    in_band: bool,
    sps: Option<Sps>,
}

impl FirstAccessUnit {
    /// Reads the first packet and its parameter set, or else the one in the configuration record.
    fn at(packet: &[u8], configuration: &[u8]) -> Self {
        let units = || nal::units(packet).filter_map(Result::ok);
        let has = |kind| units().any(|unit| nal::kind(unit) == kind);
        let own = units().find(|unit| nal::kind(unit) == Kind::Sps);
        // avcC: five bytes, a count, then a 16-bit length before each set. ISO/IEC 14496-15, 5.3.3.1.
        let stored = configuration.get(8..);
        Self { idr: has(Kind::Idr), in_band: own.is_some() && has(Kind::Pps), sps: own.or(stored).and_then(Sps::parse) }
    }
}

/// The properties of all packets together.
struct Scan {
    /// Presentation times of the shown frames, in ticks.
    shown: Vec<i64>,
    closed_gop: bool,
}

impl Scan {
    fn packet(&mut self, packet: &mut Packet) -> Result<(), Code> {
        if !packet.is_discarded() {
            self.shown.push(packet.pts().unwrap_or(i64::MIN));
        }
        let units = nal::units(packet.bytes_mut()?).filter_map(Result::ok).map(nal::kind);
        let (mut idr, mut recovery) = (false, false);
        for kind in units {
            match kind {
                Kind::Idr => idr = true,
                Kind::Sei { recovery: true } => recovery = true,
                Kind::Sei { recovery: false } | Kind::Slice | Kind::Sps | Kind::Pps | Kind::Other => (),
            }
        }
        self.closed_gop &= idr || !recovery;
        Ok(())
    }

    /// Whether the shown frames, put in order, are one step apart throughout.
    fn evenly_spaced(&mut self) -> bool {
        self.shown.sort_unstable();
        let mut steps = self.shown.windows(2).map(|pair| pair[1].checked_sub(pair[0]));
        let first = steps.next();
        first.is_none_or(|first| first > Some(0) && steps.all(|step| step == first))
    }
}

/// The rate of frames decoded at `times`, `base` seconds apart; `None` if they are not evenly spaced.
fn rate(times: &[i64], (num, den): (u32, u32)) -> Option<Rate> {
    let step = times.get(1)?.checked_sub(*times.first()?)?;
    let even = times.windows(2).all(|pair| pair[1].checked_sub(pair[0]) == Some(step));
    let step = u64::try_from(step).ok()?.checked_mul(num.into())?;
    even.then(|| Rate::new(den.into(), step).ok()).flatten()
}

fn profile(sps: &Sps) -> String {
    match (sps.profile, sps.within_main) {
        (100, _) => "High".into(),
        (77, _) => "Main".into(),
        (66, true) => "Constrained Baseline".into(),
        (66, false) => "Baseline".into(),
        (other, _) => format!("profile {other}"),
    }
}

fn pixel_format(sps: &Sps) -> String {
    match (sps.chroma, sps.depth) {
        (1, (8, 8)) => "yuv420p".into(),
        (chroma, (luma, _)) => {
            let name = ["4:0:0", "4:2:0", "4:2:2", "4:4:4"].get(chroma as usize).unwrap_or(&"unknown");
            format!("{name} {luma} bit")
        }
    }
}

fn colour(sps: &Sps) -> String {
    let name = |code: &u32| match code {
        1 => "bt709".into(),
        2 => "untold".into(),
        other => format!("code {other}"),
    };
    let [primaries, transfer, matrix] = sps.colour.each_ref().map(name);
    let range = if sps.full_range { "full" } else { "limited" };
    let told = format!("{primaries} {transfer} {matrix} {range}");
    debug_assert!(sps.colour != [1; 3] || sps.full_range || told == COLOUR);
    told
}
