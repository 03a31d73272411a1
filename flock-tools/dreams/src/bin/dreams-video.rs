//! `dreams-video`, the artist's command line with ffmpeg.
//!
//! Owns the name of the program. `dreams` starts it with its own command line. The table of contents is `lib.rs`.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use dreams::FfmpegPart;

fn main() -> ExitCode {
    dreams::run(Some(FfmpegPart::linked()))
}
