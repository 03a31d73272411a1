//! The first frame of the run, decoded ahead of the stream.
//!
//! Owns how it gets into the queue before the stream's frames. The stream brings it again. Never reports damage: the
//! stream decodes the same packet and does that.
//!
//! `clip_source.rs` calls it, which has nothing else to do until there is a picture; `presenter.rs` shows it.

use crate::pipeline::frame_queue::NextFrame;
use crate::stream::{Frame, Pixels, ScheduledClip};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use video::Clip;

/// Sends the first frame.
#[derive(Debug)]
pub(crate) struct FirstFrame {
    /// The queue of the stream's frames.
    pub(crate) frames: SyncSender<NextFrame>,
    /// Whether every frame is hashed.
    pub(crate) is_hashed: bool,
}

impl FirstFrame {
    /// Puts the first frame of `clip`, the run's first, into the queue; if there is no room, the stream has come already.
    /// If the picture is not whole nothing is sent, and the stream comes all the same.
    pub(crate) fn send(self, clip: &Clip, scheduled: Arc<ScheduledClip>) {
        let Some(frame) = video::first_frame(clip) else { return };
        let pixels = Pixels::Decoded(frame);
        let hash = self.is_hashed.then(|| pixels.md5());
        self.frames
            .try_send(NextFrame::First(Frame { pixels, scheduled: Some(scheduled), in_clip: 0, index: 0, hash }))
            .ok();
    }
}

#[cfg(test)]
mod tests {
    use super::FirstFrame;
    use crate::pipeline::frame_queue::NextFrame;
    use crate::pipeline::grey_clip::{SIZE, encode};
    use crate::stream::scheduled_clip::tests::scheduled_clips;
    use std::fs;
    use std::path::Path;
    use std::sync::Arc;
    use std::sync::mpsc::sync_channel;
    use timing::{FrameCount, Rate};
    use video::{Clip, ClipNumber, Form, Poll, Session};

    fn open(path: &Path) -> Clip {
        Clip::open(path, &Form { size: SIZE, fps: Rate::new(30, 1).unwrap() }, FrameCount(2)).unwrap()
    }

    fn sent(path: &Path, room: usize) -> Option<NextFrame> {
        let (frames, queue) = sync_channel(room);
        let scheduled = Arc::clone(&scheduled_clips(1, 2)[0]);
        FirstFrame { frames, is_hashed: true }.send(&open(path), scheduled);
        queue.try_recv().ok()
    }

    #[test]
    fn an_opening_is_the_streams_first_frame_to_the_bit_and_comes_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("clip.mp4");
        encode(&path);
        let Some(NextFrame::First(first)) = sent(&path, 1) else { panic!("no first frame") };
        assert_eq!((first.in_clip, first.index), (0, 0));
        assert!(sent(&path, 0).is_none(), "where there is no room the stream has come");

        let mut session = Session::new(std::num::NonZero::<usize>::MIN).unwrap();
        assert_eq!(session.push(open(&path)), ClipNumber(0));
        session.finish();
        let Poll::Frame(streamed) = session.poll() else { panic!("no frame") };
        assert_eq!(first.hash, Some(crate::stream::Pixels::Decoded(streamed).md5()));
    }

    #[test]
    fn a_first_picture_that_is_not_whole_is_no_opening() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("clip.mp4");
        encode(&path);
        let mut bytes = fs::read(&path).unwrap();
        // The last bytes of the first picture: its slice stands right before the second one's.
        let data = bytes.windows(4).position(|name| name == b"mdat").unwrap() + 4;
        let slice =
            (data..bytes.len() - 5).find(|at| bytes[*at + 4] & 0x1f == 5 && bytes[*at..*at + 2] == [0, 0]).unwrap();
        let length = u32::from_be_bytes(bytes[slice..slice + 4].try_into().unwrap()) as usize;
        bytes[slice + 8..slice + 4 + length].fill(0xff);
        fs::write(&path, bytes).unwrap();
        assert!(sent(&path, 1).is_none());
    }
}
