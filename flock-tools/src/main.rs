//! `flock`, the artist's command line.
//!
//! Owns nothing but the name of the program: linked without ffmpeg, it answers at once. Never opens a clip:
//! `flock-video` takes over the commands that have to. The table of contents is `lib.rs`.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use flock_tools::Video;

fn main() -> ExitCode {
    flock_tools::run(Video::elsewhere())
}
