//! Damage found in a clip while it is played.
//!
//! Owns [`Damage`]. What follows is decided elsewhere: the player leaves the clip out, the tools refuse it.
//!
//! Found by `session.rs`.

use timing::FrameCount;

/// One thing that was wrong with a clip. Frames are counted from 0 within the clip.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Damage {
    /// Parts of this frame are concealed errors.
    #[error("frame {frame} was decoded with errors")]
    Guessed {
        /// The frame.
        frame: u32,
    },
    /// A frame whose number or size contradicts the clip's header; it was left out.
    #[error("frame {frame} does not match the clip's header: {reason}")]
    Misplaced {
        /// The frame number in its packet.
        frame: i64,
        /// The cause.
        reason: String,
    },
    /// The container's or the packet's own structure is broken there.
    #[error("the packet of frame {frame} is malformed")]
    Malformed {
        /// The frame.
        frame: u32,
    },
    /// Fewer frames were decoded than the header says.
    #[error("{found} frames were decoded (expected {expected})")]
    TooFew {
        /// The number in the header.
        expected: FrameCount,
        /// The number found.
        found: FrameCount,
    },
    /// The decoder gave up on this frame.
    #[error("frame {frame} cannot be decoded: {reason}")]
    Undecodable {
        /// The frame.
        frame: u32,
        /// The message of ffmpeg.
        reason: String,
    },
    /// The file cannot be read from this frame on.
    #[error("cannot read frame {frame}: {reason}")]
    Unreadable {
        /// The first frame that is missing, in decoding order.
        frame: u32,
        /// The message of ffmpeg or the kernel.
        reason: String,
    },
}
