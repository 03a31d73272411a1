//! One decoded frame and its place in the stream.
//!
//! Owns [`Frame`], a shared handle on ffmpeg's own buffer: no pixel is copied between the decoder and the screen. The
//! buffer lives as long as the frame, also after the session has ended.
//!
//! Made by `session.rs`.

use crate::quantiser;
use crate::raw::Picture;
use crate::session::ClipNumber;
use std::fmt;
use std::sync::Arc;
use timing::FrameIndex;

/// One decoded frame: 8-bit planar 4:2:0, BT.709, limited range. Clones share the picture.
#[derive(Clone)]
pub struct Frame {
    pub(crate) picture: Arc<Picture>,
    pub(crate) index: FrameIndex,
    pub(crate) clip: ClipNumber,
    pub(crate) in_clip: u32,
    pub(crate) last: bool,
    pub(crate) damaged: bool,
}

impl Frame {
    /// Its place among all frames of the session: 0, 1, 2, ... without gaps, across clips.
    pub fn index(&self) -> FrameIndex {
        self.index
    }

    /// The clip it belongs to.
    pub fn clip(&self) -> ClipNumber {
        self.clip
    }

    /// Its place in its clip, from 0. Where a damaged clip lost frames there are gaps.
    pub fn in_clip(&self) -> u32 {
        self.in_clip
    }

    /// Whether it is the clip's last frame by the header's count. In a damaged clip that frame may be missing:
    /// [`crate::Poll::ClipEnd`] always comes.
    pub fn last(&self) -> bool {
        self.last
    }

    /// Visible width and height, the same for all frames of a flock.
    pub fn size(&self) -> (u32, u32) {
        self.picture.size()
    }

    /// Y, U and V, each from its first to its last visible byte. Rows are [`Frame::strides`] apart; the last row has
    /// no padding after it.
    pub fn planes(&self) -> [&[u8]; 3] {
        self.picture.planes()
    }

    /// Bytes from one row to the next of Y, U and V.
    pub fn strides(&self) -> [usize; 3] {
        self.picture.strides()
    }

    /// H.264's quantisation parameter, 0 to 51, the mean of all blocks: how coarsely it is encoded. `None` unless its
    /// session is one [`with quantisers`](crate::Session::with_quantisers).
    pub fn quantiser(&self) -> Option<f32> {
        quantiser::mean(self.picture.encoding())
    }

    /// Whether errors in it were concealed. With more than one thread a nearby frame of the same clip may carry the mark.
    pub fn is_damaged(&self) -> bool {
        self.damaged
    }
}

impl fmt::Debug for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { index, clip, in_clip, last, damaged, picture: _ } = self;
        write!(
            f,
            "Frame {{ index: {}, clip: {}, in_clip: {in_clip}, last: {last}, damaged: {damaged} }}",
            index.0, clip.0
        )
    }
}
