//! `flock-video`, the artist's command line with the decoder.
//!
//! Owns nothing but the name of the program. Never called by people: `flock` hands over to it. The table of contents is
//! `lib.rs`.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use flock_tools::Video;

fn main() -> ExitCode {
    flock_tools::run(Video::here())
}
