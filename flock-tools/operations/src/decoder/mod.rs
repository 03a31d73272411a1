//! The decoder that commands use, and which of the two programs has one.
//!
//! Owns [`Decoder`], the line between `dreams` and `dreams-video`: `dreams` has none, and gives its whole command to
//! `dreams-video`. Never judges a clip and knows no command. `ffmpeg.rs` is the one decoder there is.
//!
//! Start at [`DecoderHandle::get`].

pub mod ffmpeg;
pub mod thumbnail;

use std::env;
use std::io;
use std::ops::Range;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use flock::Clip;
use timing::FrameCount;
use video::{Form, Probe, ProbeError, Yuv420p};

use crate::program::{Exit, Fatal};

/// The program that has the decoder, in the same folder as `dreams`.
const PROGRAM: &str = "dreams-video";

/// Some frames of a clip.
pub type Excerpt<'a> = (&'a Clip, Range<u32>);

/// A decoded frame.
pub struct DecodedFrame {
    /// What it shows.
    pub picture: Yuv420p,
    /// H.264's quantisation parameter, the mean of its blocks; `None` if the decoder does not tell.
    pub quantiser: Option<f32>,
}

/// Reads clips. The one implementation is [`ffmpeg::Ffmpeg`]: the linker leaves ffmpeg out of a program that does not
/// name it.
pub trait Decoder: Sync {
    /// The header, the index and the packets of the file at `path`.
    fn probe(&self, path: &Path) -> Result<Probe, ProbeError>;

    /// Decodes the whole file at `path` on one thread. Returns the number of frames, or the first damage.
    fn decode(&self, path: &Path) -> Result<FrameCount, String>;

    /// Decodes `excerpts` of clips in `folder` one after the other in one session, as a unit does, and gives `each`
    /// frame with the index of its excerpt. Returns for every excerpt whether all of it came.
    fn play(
        &self,
        folder: &Path,
        form: &Form,
        excerpts: &[Excerpt],
        each: &mut dyn FnMut(usize, DecodedFrame),
    ) -> Vec<Result<(), String>>;
}

/// The decoder of this program, if it has one.
#[derive(Clone, Copy)]
pub struct DecoderHandle(pub Option<&'static dyn Decoder>);

impl DecoderHandle {
    /// The decoder. A command asks for it before it writes or prints anything: where this program has none,
    /// `dreams-video` runs the whole command from its beginning.
    /// Errors: If `dreams-video` cannot be started.
    pub fn get(self) -> Result<&'static dyn Decoder, Fatal> {
        self.0.ok_or_else(hand_over)
    }
}

/// `dreams-video`, which could not be started.
#[derive(Debug, thiserror::Error)]
#[error("cannot start `{path}`, the program that reads clips")]
struct StartError {
    path: PathBuf,
    source: io::Error,
}

/// Replaces this process by `dreams-video`, with the same command line. Returns only if that cannot be started.
pub fn hand_over() -> Fatal {
    let path = match env::current_exe() {
        Ok(own) => own.with_file_name(PROGRAM),
        Err(source) => return start_fatal(PROGRAM.into(), source),
    };
    let source = Command::new(&path).args(env::args_os().skip(1)).exec();
    start_fatal(path, source)
}

fn start_fatal(path: PathBuf, source: io::Error) -> Fatal {
    Fatal::new(Exit::Unreadable, StartError { path, source }).hint("it belongs beside `dreams`")
}
