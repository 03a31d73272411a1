//! The decoder, as commands ask for it; and the line between the two programs.
//!
//! Owns [`Decoder`], what may be asked of clips, and how `flock`, which cannot answer that, gives its command to
//! `flock-video`, which can. Never judges what comes out.
//!
//! Start at [`Video::decoder`].

use std::env;
use std::io;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use flock::{Clip, Manifest};
use timing::FrameCount;
use video::{Form, Yuv420p};

use crate::bundles::pack;
use crate::clips::{self, Finding};
use crate::demo;
use crate::import;
use crate::joins::{self, Join, Judged};
use crate::page::{self, Pixels};
use crate::render;
use crate::report::{Exit, Fatal};

/// The program that has the decoder; it lies beside `flock`.
const PROGRAM: &str = "flock-video";

/// What takes a decoder, or an encoder. Only [`Ffmpeg`] does it, and only [`Video::here`] names that: the linker leaves
/// ffmpeg out of a program that does not call it.
pub(crate) trait Decoder: Sync {
    /// How many frames the file at `path` has, or why it cannot be a clip of a flock of this `form`.
    fn frames(&self, path: &Path, form: &Form) -> Result<FrameCount, String>;
    /// What is wrong with the clip in the file at `path`: its form, and whether it decodes.
    fn faults(&self, path: &Path, clip: &Clip, form: &Form) -> Vec<Finding>;
    /// The first frame of `clip`, shrunk to `size`, if it is there and in the flock's form.
    fn first_frame(&self, folder: &Path, clip: &Clip, form: &Form, size: (u32, u32)) -> Option<Pixels>;
    /// Every join of the flock in `folder`, judged. Shows its progress on a terminal.
    fn judge(&self, folder: &Path, manifest: &Manifest) -> Judged;
    /// The frames that meet at `join`; or why a clip cannot be decoded.
    fn meeting(&self, join: &Join, folder: &Path, manifest: &Manifest) -> Result<Vec<Yuv420p>, String>;
    /// The whole of `flock demo`, and below of other commands that are of no use without.
    fn demo(&self, args: &demo::Args) -> Result<Exit, Fatal>;
    /// `flock import`.
    fn import(&self, args: &import::Args) -> Result<Exit, Fatal>;
    /// `flock pack`, which checks the flock first.
    fn pack(&self, args: &pack::Args) -> Result<Exit, Fatal>;
    /// `flock render`.
    fn render(&self, args: &render::Args) -> Result<Exit, Fatal>;
}

/// The unit's own decoder.
pub(crate) struct Ffmpeg;

impl Decoder for Ffmpeg {
    fn frames(&self, path: &Path, form: &Form) -> Result<FrameCount, String> {
        clips::frames(path, form)
    }

    fn faults(&self, path: &Path, clip: &Clip, form: &Form) -> Vec<Finding> {
        clips::decoded(path, clip, form)
    }

    fn first_frame(&self, folder: &Path, clip: &Clip, form: &Form, size: (u32, u32)) -> Option<Pixels> {
        page::first_frame(folder, clip, form, size)
    }

    fn judge(&self, folder: &Path, manifest: &Manifest) -> Judged {
        joins::judge_with_bar(folder, manifest)
    }

    fn meeting(&self, join: &Join, folder: &Path, manifest: &Manifest) -> Result<Vec<Yuv420p>, String> {
        join.pictures(folder, manifest)
    }

    fn demo(&self, args: &demo::Args) -> Result<Exit, Fatal> {
        demo::run(args)
    }

    fn import(&self, args: &import::Args) -> Result<Exit, Fatal> {
        import::run(args)
    }

    fn pack(&self, args: &pack::Args) -> Result<Exit, Fatal> {
        pack::run(args)
    }

    fn render(&self, args: &render::Args) -> Result<Exit, Fatal> {
        render::run(args)
    }
}

/// Where the decoder is: in this program, or in the other one.
#[derive(Clone, Copy)]
pub struct Video(Option<&'static dyn Decoder>);

/// A program that could not be started.
#[derive(Debug, thiserror::Error)]
#[error("cannot start `{path}`, which opens clips")]
struct Unstarted {
    path: PathBuf,
    source: io::Error,
}

impl Video {
    /// In this program, which is then linked with ffmpeg.
    pub fn here() -> Self {
        Self(Some(&Ffmpeg))
    }

    /// In the other one.
    pub fn elsewhere() -> Self {
        Self(None)
    }

    /// The decoder. Where it is in the other program, that one takes over the whole command, from its beginning: so it
    /// is asked for before anything is written or said.
    ///
    /// # Errors
    /// If the other program cannot be started.
    pub(crate) fn decoder(self) -> Result<&'static dyn Decoder, Fatal> {
        self.0.ok_or_else(hand_over)
    }
}

/// Becomes the program that has the decoder, with the same command line. Returns only if that cannot be started.
fn hand_over() -> Fatal {
    let became = env::current_exe().map(|own| own.with_file_name(PROGRAM)).map_err(|source| (PROGRAM.into(), source));
    let (path, source) = match became {
        Ok(path) => {
            let source = Command::new(&path).args(env::args_os().skip(1)).exec();
            (path, source)
        }
        Err(error) => error,
    };
    Fatal::new(Exit::Unreadable, Unstarted { path, source }).hint("it belongs beside `flock`")
}
