//! The store of a clip's rendered frames, so that no frame is rendered twice.
//!
//! Owns their files: planes as the encoder takes them, then the recipe of the pictures, the frame's number and a BLAKE3
//! digest of all of it, which reveals a file that a crash or a power cut left incomplete. A frame of another recipe is none.
//! Many processes may put frames at once. Never renders or encodes: `make.rs` and `clip_job.rs` do.
//!
//! Start at [`FrameStore::open`].

use std::fs;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use flock::ClipHash;
use video::Yuv420p;

/// The length of a hash as text.
const HASH: usize = "b3:".len() + 64;

/// The length of a frame's number as text.
const NUMBER: usize = 10;

/// The length of what follows the planes: the recipe, the number and the digest.
const TRAILER: usize = HASH + NUMBER + HASH;

/// The ending of a frame that is being written.
const PART: &str = "part";

/// Tells the unfinished files of this process from those of others, on this machine and on all.
static PROCESS: LazyLock<u64> = LazyLock::new(rand::random);

/// The frames of one clip, in a folder of their own.
#[derive(Debug)]
pub struct FrameStore {
    folder: PathBuf,
    size: (u32, u32),
    recipe: ClipHash,
}

impl FrameStore {
    /// The store in `folder` for frames of `size` rendered by `recipe`. Those rendered by another one are replaced.
    pub fn open(folder: &Path, size: (u32, u32), recipe: ClipHash) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        Ok(Self::at(folder, size, recipe))
    }

    /// The same, where nothing is to be written.
    pub fn at(folder: &Path, size: (u32, u32), recipe: ClipHash) -> Self {
        Self { folder: folder.to_owned(), size, recipe }
    }

    /// Frame `number`, if it was put here and is whole.
    /// Errors: The system's error for a frame that is there.
    pub fn get(&self, number: u32) -> io::Result<Option<Yuv420p>> {
        let mut bytes = Vec::new();
        match fs::File::open(self.path(number)).and_then(|mut file| file.read_to_end(&mut bytes)) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            read => read?,
        };
        let Some((told, digest)) = bytes.len().checked_sub(HASH).and_then(|end| bytes.split_at_checked(end)) else {
            return Ok(None);
        };
        let label = self.label(number);
        let Some(planes) = told.strip_suffix(label.as_bytes()) else { return Ok(None) };
        if digest != ClipHash::of(told)?.to_string().as_bytes() {
            return Ok(None);
        }
        Ok(Yuv420p::from_planes(self.size.0, self.size.1, planes).ok())
    }

    /// Whether frame `number` of this recipe was put here. Only its end is read: it may be damaged.
    pub fn has(&self, number: u32) -> bool {
        let label = || -> io::Result<Vec<u8>> {
            let mut file = fs::File::open(self.path(number))?;
            file.seek(SeekFrom::End(-(TRAILER as i64)))?;
            let mut label = vec![0; HASH + NUMBER];
            file.read_exact(&mut label)?;
            Ok(label)
        };
        label().is_ok_and(|label| label == self.label(number).as_bytes())
    }

    /// Stores `picture` as frame `number`.
    /// Errors: The system's error; the frame is then not there.
    pub fn put(&self, number: u32, picture: &Yuv420p) -> io::Result<()> {
        let mut bytes = picture.planes().concat();
        bytes.extend_from_slice(self.label(number).as_bytes());
        let digest = ClipHash::of(&bytes[..])?.to_string();
        bytes.extend_from_slice(digest.as_bytes());
        let part = part_of(&self.path(number));
        // Not synced, for there are thousands: `get` checks each frame, and a lost one is drawn again.
        fs::write(&part, bytes).and_then(|()| fs::rename(&part, self.path(number))).inspect_err(|_| {
            // If the disk is full, half a frame takes room.
            let _ = fs::remove_file(&part);
        })
    }

    /// Has the system look at the folder anew: a network file system remembers for a minute which files were not there, but
    /// forgets it when the folder is changed from here.
    pub fn refresh(&self) {
        let part = part_of(&self.folder.join("look"));
        // Where this fails the frames come to light later.
        let _ = fs::write(&part, []).and_then(|()| fs::remove_file(&part));
    }

    /// Deletes what processes that were killed left of frames. No other process may use the store meanwhile.
    pub fn sweep(&self) -> io::Result<()> {
        for entry in fs::read_dir(&self.folder)? {
            let entry = entry?;
            if entry.file_type()?.is_file() && entry.path().extension().is_some_and(|ending| ending == PART) {
                absent_is_fine(fs::remove_file(entry.path()))?;
            }
        }
        Ok(())
    }

    /// Deletes the frames.
    pub fn clear(&self) -> io::Result<()> {
        absent_is_fine(fs::remove_dir_all(&self.folder))
    }

    fn path(&self, number: u32) -> PathBuf {
        self.folder.join(format!("{number:06}.yuv"))
    }

    /// The text after the planes of frame `number`, without the digest.
    fn label(&self, number: u32) -> String {
        format!("{}{number:NUMBER$}", self.recipe)
    }
}

/// The file that becomes the frame at `path`, of this process alone.
pub fn part_of(path: &Path) -> PathBuf {
    path.with_extension(format!("{:016x}.{PART}", *PROCESS))
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
        assert_eq!([again.has(3), again.has(4)], [true, false]);
    }

    #[test]
    fn a_torn_or_changed_frame_is_no_frame() {
        let folder = tempfile::tempdir().unwrap();
        let store = FrameStore::open(folder.path(), (16, 16), stamp("a")).unwrap();
        store.put(0, &grey(70)).unwrap();
        let whole = fs::read(store.path(0)).unwrap();
        for length in [0, 1, 383, 384, 384 + TRAILER - HASH, whole.len() - 1] {
            fs::write(store.path(0), &whole[..length]).unwrap();
            assert!(store.get(0).unwrap().is_none(), "{length} bytes");
        }
        for at in [0, 100, 384 + 10, 384 + HASH + 3, whole.len() - 1] {
            let mut changed = whole.clone();
            changed[at] ^= 1;
            fs::write(store.path(0), &changed).unwrap();
            assert!(store.get(0).unwrap().is_none(), "byte {at}");
        }
    }

    #[test]
    fn a_frame_of_other_pictures_or_in_anothers_place_is_no_frame() {
        let folder = tempfile::tempdir().unwrap();
        let store = FrameStore::open(folder.path(), (16, 16), stamp("a")).unwrap();
        store.put(0, &grey(70)).unwrap();
        fs::copy(store.path(0), store.path(1)).unwrap();
        let other = FrameStore::open(folder.path(), (16, 16), stamp("b")).unwrap();
        assert!(other.get(0).unwrap().is_none() && store.get(1).unwrap().is_none());
        assert_eq!([store.has(0), store.has(1), other.has(0)], [true, false, false]);
        other.put(0, &grey(80)).unwrap();
        assert_eq!(other.get(0).unwrap().unwrap().planes(), grey(80).planes());
    }

    #[test]
    fn what_a_killed_process_left_of_a_frame_is_swept_away() {
        let folder = tempfile::tempdir().unwrap();
        let store = FrameStore::open(folder.path(), (16, 16), stamp("a")).unwrap();
        store.put(0, &grey(70)).unwrap();
        fs::write(folder.path().join("000001.0123456789abcdef.part"), "half").unwrap();
        store.sweep().unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        assert!(store.get(0).unwrap().is_some());
    }
}
