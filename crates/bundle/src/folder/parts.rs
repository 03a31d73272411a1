//! Objects above the file size limit of a file system.
//!
//! Splits them into parts, names the parts and reads them as one file. A clip may be larger than the 4 GiB limit of
//! FAT, which most sticks have. The folder writes the parts.
//!
//! Start at [`parts`] and [`Parts::open`].

use std::fs::File;
use std::io::{self, Read};

use crate::beneath::Root;
use crate::limits;

/// The largest part that is written to FAT, which ends at 4 GiB - 1.
pub(super) const FAT_LARGEST: u64 = 2 << 30;

/// A reader of an object's parts.
pub(super) struct Parts<'f> {
    root: &'f Root,
    path: String,
    next: u32,
    open: Option<File>,
}

impl<'f> Parts<'f> {
    /// Opens the parts of the object at `path` for reading from byte `from` of `size` on.
    pub(super) fn open(root: &'f Root, path: String, from: u64, size: u64) -> io::Result<Self> {
        let mut parts = Self { root, path, next: 0, open: None };
        parts.skip(from, size)?;
        Ok(parts)
    }

    /// Skips to byte `from` of `size`.
    fn skip(&mut self, from: u64, size: u64) -> io::Result<()> {
        let mut rest = from;
        loop {
            let mut file = self.root.file(&part_path(&self.path, self.next))?;
            self.next += 1;
            let length = file.metadata()?.len();
            if rest < length || (rest == length && from == size) {
                io::Seek::seek(&mut file, io::SeekFrom::Start(rest))?;
                self.open = Some(file);
                return Ok(());
            }
            rest -= length;
        }
    }
}

impl Read for Parts<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while let Some(file) = &mut self.open {
            let count = file.read(buffer)?;
            if count > 0 || buffer.is_empty() {
                return Ok(count);
            }
            self.open = match self.root.file(&part_path(&self.path, self.next)) {
                Ok(file) if self.next < limits::PARTS => Some(file),
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                Ok(_) | Err(_) => None,
            };
            self.next += 1;
        }
        Ok(0)
    }
}

/// The files of an object of `size` bytes, with their lengths.
pub(super) fn parts(path: &str, size: u64, largest: u64) -> Vec<(String, u64)> {
    if size <= largest {
        return vec![(path.to_owned(), size)];
    }
    let count = size.div_ceil(largest);
    let part = |at: u64| (part_path(path, u32::try_from(at).unwrap_or(u32::MAX)), largest.min(size - at * largest));
    (0..count).map(part).collect()
}

pub(super) fn part_path(path: &str, part: u32) -> String {
    format!("{path}.{part:03}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::{Folder, PutMethod};
    use crate::names::ObjectId;
    use crate::source::Source;
    use std::path::Path;

    /// The folder at `path` as if its file system held no more than `largest` bytes in a file.
    fn small(path: &Path, largest: u64) -> Folder {
        Folder { largest, ..Folder::create(path).unwrap() }
    }

    #[test]
    fn what_a_file_system_cannot_hold_in_one_is_cut_and_read_as_one_from_any_byte_on() {
        let scratch = tempfile::tempdir().unwrap();
        let clip = scratch.path().join("clip");
        for (size, names) in [(9, 1), (10, 1), (11, 2), (20, 2), (25, 3)] {
            let bytes: Vec<u8> = (0..size).collect();
            std::fs::write(&clip, &bytes).unwrap();
            let (id, size) = (ObjectId::of(&bytes), u64::from(size));
            let mut folder = small(&scratch.path().join(format!("stick {size}")), 10);
            assert!(!folder.holds(&id, size));
            folder.put_file(&id, size, &clip, &mut |_| ()).unwrap();
            assert_eq!(folder.put_file(&id, size, &clip, &mut |_| ()).unwrap(), PutMethod::Kept);
            assert!(folder.holds(&id, size) && !folder.holds(&id, size + 1));
            let there = std::fs::read_dir(folder.path().join(id.path()).parent().unwrap()).unwrap().count();
            assert_eq!(there, names, "{size} bytes");
            for from in 0..=size {
                let mut read = Vec::new();
                folder.object(&id, size, from).unwrap().read_to_end(&mut read).unwrap();
                assert_eq!(read, bytes[usize::try_from(from).unwrap()..], "{size} bytes from {from} on");
            }
        }
    }

    #[test]
    fn what_does_not_fit_into_four_gib_is_cut_where_fat_holds_it() {
        let size = (4 << 30) + 5;
        let cut: Vec<u64> = parts("clip", size, FAT_LARGEST).into_iter().map(|(_, length)| length).collect();
        assert_eq!(cut, [2 << 30, 2 << 30, 5]);
        let largest = parts("clip", limits::FILE, FAT_LARGEST);
        assert!(largest.len() <= limits::PARTS as usize, "all of the largest clip can be read back");
        assert!(largest.iter().all(|(_, length)| *length < (4 << 30) - 1));

        // As a stick has it, but for holes in the place of pictures.
        let scratch = tempfile::tempdir().unwrap();
        let mut folder = Folder::create(scratch.path()).unwrap();
        let id = ObjectId::of(b"not read");
        std::fs::create_dir_all(scratch.path().join(id.path()).parent().unwrap()).unwrap();
        for (part, length) in parts(&id.path(), size, FAT_LARGEST) {
            File::create(scratch.path().join(part)).unwrap().set_len(length).unwrap();
        }
        assert!(folder.holds(&id, size));
        for from in [0, (2 << 30) - 1, 2 << 30, (4 << 30) - 1, 4 << 30, size] {
            let mut first = Vec::new();
            folder.object(&id, size, from).unwrap().take(10).read_to_end(&mut first).unwrap();
            assert_eq!(first.len() as u64, (size - from).min(10), "from {from} on");
        }
    }
}
