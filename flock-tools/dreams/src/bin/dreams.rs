//! `dreams`, the artist's command line.
//!
//! Owns the name of the program. It is linked without ffmpeg and so answers at once; `dreams-video` takes over the
//! commands that open clips. The table of contents is `lib.rs`.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    dreams::run(None)
}
