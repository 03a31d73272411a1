//! ffmpeg's error codes.
//!
//! Owns the conversion of the negative numbers that ffmpeg returns; their text comes from ffmpeg, through `raw.rs`.
//!
//! Next: `raw.rs`, where they come from; `clip.rs`, `probe.rs`, `session.rs`, `foreign.rs` and `encoder.rs`, which make
//! errors of them.

use crate::raw;
use ffmpeg_next::ffi as av;
use std::ffi::c_int;
use std::fmt;
use std::io;

/// An error code of ffmpeg, negative.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Code(c_int);

impl Code {
    /// Out of memory: the only error of a decoder that the clip does not cause.
    pub(crate) const NO_MEMORY: Self = Self(av::AVERROR(av::ENOMEM));
    /// A path or number that ffmpeg cannot take.
    pub(crate) const INVALID: Self = Self(av::AVERROR(av::EINVAL));

    pub(crate) fn of(answer: c_int) -> Self {
        Self(answer)
    }

    /// The system's error behind it, if it is one.
    pub(crate) fn system(self) -> Option<io::Error> {
        (-4_095..0).contains(&self.0).then(|| io::Error::from_raw_os_error(-self.0))
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&raw::error_text(self.0))
    }
}

impl std::error::Error for Code {}

impl From<Code> for String {
    fn from(code: Code) -> Self {
        code.to_string()
    }
}

/// ffmpeg's message for an error of `ffmpeg-next`, whose own messages are empty until all of ffmpeg is initialised.
pub(crate) fn text(error: ffmpeg_next::Error) -> String {
    raw::error_text(error.into())
}

/// `Ok` with ffmpeg's return value unless it is negative.
pub(crate) fn check(answer: c_int) -> Result<c_int, Code> {
    if answer < 0 { Err(Code::of(answer)) } else { Ok(answer) }
}
