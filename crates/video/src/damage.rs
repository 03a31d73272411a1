//! What was wrong with a clip that was played all the same.
//!
//! Owns [`Damage`], the one vocabulary for it. Never decides what follows from it: the player strikes the clip, the
//! tools refuse it.
//!
//! Found by `session.rs`.

use timing::FrameCount;

/// One thing that was wrong with a clip. Frames are counted from 0 within the clip.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Damage {
    /// Parts of this frame were guessed.
    #[error("frame {frame} was decoded with errors")]
    Guessed {
        /// The frame.
        frame: u32,
    },
    /// A frame came that is not where, or not what, the clip's header promised; it was left out.
    #[error("frame {frame} does not belong: {reason}")]
    Misplaced {
        /// The frame as it called itself.
        frame: i64,
        /// What was wrong with it.
        reason: String,
    },
    /// The container's or the packet's own structure is broken there.
    #[error("the packet of frame {frame} is malformed")]
    Malformed {
        /// The frame.
        frame: u32,
    },
    /// Fewer frames came out than the header promised.
    #[error("{found} frames came out (expected {expected})")]
    TooFew {
        /// What the header promised.
        expected: FrameCount,
        /// What came out.
        found: FrameCount,
    },
    /// The decoder gave up on this frame.
    #[error("frame {frame} cannot be decoded: {reason}")]
    Undecodable {
        /// The frame.
        frame: u32,
        /// What ffmpeg said.
        reason: String,
    },
    /// The file cannot be read from there on, or not at all.
    #[error("cannot read frame {frame}: {reason}")]
    Unreadable {
        /// The first frame that is missing, in decoding order.
        frame: u32,
        /// What ffmpeg or the kernel said.
        reason: String,
    },
}
