//! What ffmpeg answers when it will not: a negative number.
//!
//! Owns telling the numbers apart. Never calls ffmpeg but for its words, through the fence.
//!
//! Next: `raw.rs`, where they come from; `clip.rs`, `probe.rs` and `session.rs`, which make errors of them.

use crate::raw;
use ffmpeg_next::ffi as av;
use std::ffi::c_int;
use std::fmt;
use std::io;

/// What ffmpeg answered, as its own negative number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Code(c_int);

impl Code {
    /// Out of memory: the only answer of a decoder that is not the clip's fault.
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
        f.write_str(&raw::words_for(self.0))
    }
}

impl std::error::Error for Code {}

impl From<Code> for String {
    fn from(code: Code) -> Self {
        code.to_string()
    }
}

/// `Ok` with ffmpeg's answer unless it is negative.
pub(crate) fn check(answer: c_int) -> Result<c_int, Code> {
    if answer < 0 { Err(Code::of(answer)) } else { Ok(answer) }
}
