//! The opening: the first picture of the run, made ahead of the stream.
//!
//! Owns how it comes to the shelf, before the stream's frames. The stream brings it again. Never speaks of damage: the
//! stream meets the same packet and tells.
//!
//! Called by `clip_source.rs`, which has nothing else to do until there is a picture; `presenter.rs` lights what it gives.

use crate::pipeline::frame_queue::Given;
use crate::stream::scheduled_clip::{Shown, Still, Turn};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use video::Clip;

/// Who brings the opening.
#[derive(Debug)]
pub(crate) struct Herald {
    /// The shelf that the stream lays its frames on, too.
    pub(crate) frames: SyncSender<Given>,
    /// Whether every frame is hashed.
    pub(crate) is_hashed: bool,
}

impl Herald {
    /// Lays the first frame of `clip`, whose turn is the run's first, on the shelf; if there is no room, the stream has come
    /// already. Without a whole picture there is no opening, and the stream comes all the same.
    pub(crate) fn announce(self, clip: &Clip, turn: Arc<Turn>) {
        let Some(frame) = video::opening(clip) else { return };
        let still = Still::Decoded(frame);
        let hash = self.is_hashed.then(|| still.md5());
        self.frames.try_send(Given::Opening(Shown { still, turn: Some(turn), frame: 0, index: 0, hash })).ok();
    }
}

#[cfg(test)]
mod tests {
    use super::Herald;
    use crate::pipeline::clip_source::tests::{SIZE, encode};
    use crate::pipeline::frame_queue::Given;
    use crate::stream::scheduled_clip::tests::turns;
    use std::fs;
    use std::path::Path;
    use std::sync::Arc;
    use std::sync::mpsc::sync_channel;
    use timing::{FrameCount, Rate};
    use video::{Clip, ClipNumber, Form, Poll, Session};

    fn open(path: &Path) -> Clip {
        Clip::open(path, &Form { size: SIZE, fps: Rate::new(30, 1).unwrap() }, FrameCount(2)).unwrap()
    }

    fn announced(path: &Path, room: usize) -> Option<Given> {
        let (frames, shelf) = sync_channel(room);
        let turn = Arc::clone(&turns(1, 2)[0]);
        Herald { frames, is_hashed: true }.announce(&open(path), turn);
        shelf.try_recv().ok()
    }

    #[test]
    fn an_opening_is_the_streams_first_frame_to_the_bit_and_comes_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("clip.mp4");
        encode(&path);
        let Some(Given::Opening(opening)) = announced(&path, 1) else { panic!("no opening") };
        assert_eq!((opening.frame, opening.index), (0, 0));
        assert!(announced(&path, 0).is_none(), "where there is no room the stream has come");

        let mut session = Session::new(std::num::NonZero::<usize>::MIN).unwrap();
        assert_eq!(session.push(open(&path)), ClipNumber(0));
        session.finish();
        let Poll::Frame(first) = session.poll() else { panic!("no frame") };
        assert_eq!(opening.hash, Some(crate::stream::scheduled_clip::Still::Decoded(first).md5()));
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
        assert!(announced(&path, 1).is_none());
    }
}
