//! The store of a clip's rendered frames, so that no frame is rendered twice.
//!
//! Owns their files: planes as the encoder takes them, then their BLAKE3 digest, which reveals a file that a
//! crash or a power cut left incomplete. Never renders or encodes: `make.rs` and `clip_job.rs` do.
//!
//! Start at [`FrameStore::open`].

use std::fs;
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

use flock::ClipHash;
use video::Yuv420p;

/// The file with the recipe of the frames in a folder.
const STAMP: &str = "pictures";

/// The length of a digest as text.
const DIGEST: usize = "b3:".len() + 64;

/// The frames of one clip, in a folder of their own.
pub(crate) struct FrameStore {
    folder: PathBuf,
    size: (u32, u32),
}

impl FrameStore {
    /// The store in `folder` for frames of `size` rendered by `recipe`. Frames rendered by another one are deleted.
    pub(crate) fn open(folder: &Path, size: (u32, u32), recipe: ClipHash) -> io::Result<Self> {
        let stamp = folder.join(STAMP);
        if fs::read_to_string(&stamp).ok() != Some(recipe.to_string()) {
            absent_is_fine(fs::remove_dir_all(folder))?;
            fs::create_dir_all(folder)?;
            fs::write(stamp, recipe.to_string())?;
        }
        Ok(Self { folder: folder.to_owned(), size })
    }

    /// Frame `number`, if it was put here and is whole.
    /// Errors: The system's error for a frame that is there.
    pub(crate) fn get(&self, number: u32) -> io::Result<Option<Yuv420p>> {
        let mut bytes = Vec::new();
        match fs::File::open(self.path(number)).and_then(|mut file| file.read_to_end(&mut bytes)) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            read => read?,
        };
        let Some((planes, digest)) = bytes.len().checked_sub(DIGEST).and_then(|end| bytes.split_at_checked(end)) else {
            return Ok(None);
        };
        if digest != ClipHash::of(planes)?.to_string().as_bytes() {
            return Ok(None);
        }
        Ok(Yuv420p::from_planes(self.size.0, self.size.1, planes).ok())
    }

    /// Stores `picture` as frame `number`.
    /// Errors: The system's error; the frame is then not there.
    pub(crate) fn put(&self, number: u32, picture: &Yuv420p) -> io::Result<()> {
        let mut bytes = picture.planes().concat();
        let digest = ClipHash::of(&bytes[..])?.to_string();
        bytes.extend_from_slice(digest.as_bytes());
        let path = self.path(number);
        // Not synced, for there are thousands: `get` checks each frame, and a lost one is drawn again.
        let part = path.with_extension("part");
        fs::write(&part, bytes).and_then(|()| fs::rename(&part, path)).inspect_err(|_| {
            // If the disk is full, half a frame takes room.
            let _ = fs::remove_file(&part);
        })
    }

    /// Deletes the frames.
    pub(crate) fn clear(&self) -> io::Result<()> {
        absent_is_fine(fs::remove_dir_all(&self.folder))
    }

    fn path(&self, number: u32) -> PathBuf {
        self.folder.join(format!("{number:06}.yuv"))
    }
}

/// Removing what is not there is no error.
fn absent_is_fine(done: io::Result<()>) -> io::Result<()> {
    match done {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(luma: u8) -> Yuv420p {
        Yuv420p::from_planes(16, 16, &[luma; 384]).unwrap()
    }

    fn stamp(text: &str) -> ClipHash {
        ClipHash::of(text.as_bytes()).unwrap()
    }

    #[test]
    fn a_frame_comes_back_as_it_was_put() {
        let folder = tempfile::tempdir().unwrap();
        let store = FrameStore::open(folder.path(), (16, 16), stamp("a")).unwrap();
        store.put(3, &grey(70)).unwrap();
        let again = FrameStore::open(folder.path(), (16, 16), stamp("a")).unwrap();
        assert_eq!(again.get(3).unwrap().unwrap().planes(), grey(70).planes());
        assert!(again.get(4).unwrap().is_none());
    }

    #[test]
    fn a_torn_or_changed_frame_is_no_frame() {
        let folder = tempfile::tempdir().unwrap();
        let store = FrameStore::open(folder.path(), (16, 16), stamp("a")).unwrap();
        store.put(0, &grey(70)).unwrap();
        let whole = fs::read(store.path(0)).unwrap();
        for length in [0, 1, 383, 384, whole.len() - 1] {
            fs::write(store.path(0), &whole[..length]).unwrap();
            assert!(store.get(0).unwrap().is_none(), "{length} bytes");
        }
        let mut changed = whole;
        changed[100] ^= 1;
        fs::write(store.path(0), &changed).unwrap();
        assert!(store.get(0).unwrap().is_none());
    }

    #[test]
    fn frames_of_other_pictures_are_thrown_away() {
        let folder = tempfile::tempdir().unwrap();
        FrameStore::open(folder.path(), (16, 16), stamp("a")).unwrap().put(0, &grey(70)).unwrap();
        let other = FrameStore::open(folder.path(), (16, 16), stamp("b")).unwrap();
        assert!(other.get(0).unwrap().is_none());
    }
}
