//! Removal of unused files from a folder of bundles.
//!
//! Removes files of interrupted writers, objects that no bundle names any more, and damaged objects. The caller knows
//! which objects are needed.
//!
//! Start at [`Folder::sweep`].
#![allow(clippy::missing_errors_doc, reason = "every operation fails with `FolderError`")]

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::Path;

use crate::folder::parts::part_path;
use crate::folder::{Folder, FolderError, temporary};
use crate::limits;
use crate::names::ObjectId;

/// The folder of all objects.
const OBJECTS: &str = "objects";

/// What was removed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sweep {
    /// How many files.
    pub files: usize,
    /// How many bytes they had.
    pub bytes: u64,
}

impl Folder {
    /// The room that is left, in bytes.
    pub fn free_bytes(&self) -> Result<u64, FolderError> {
        let status = rustix::fs::fstatvfs(self).map_err(|error| self.unread("")(error.into()))?;
        Ok(status.f_bavail.saturating_mul(status.f_frsize))
    }

    /// Removes a damaged object.
    pub fn discard(&self, id: &ObjectId) -> Result<(), FolderError> {
        let path = id.path();
        self.clear(&path)?;
        for part in 0..limits::PARTS {
            let part = part_path(&path, part);
            if self.root.length(&part).map_err(self.unread(&part))?.is_none() {
                break;
            }
            self.clear(&part)?;
        }
        Ok(())
    }

    /// Removes files of interrupted writers, and every object that is not to be kept. There must be no other writer.
    /// Files with unknown names stay.
    pub fn sweep(&self, mut keep: impl FnMut(&ObjectId) -> bool) -> Result<Sweep, FolderError> {
        let mut swept = Sweep::default();
        for prefix in self.names(OBJECTS)? {
            let Some(prefix) = prefix.to_str().filter(|prefix| prefix.len() == 2) else { continue };
            let folder = format!("{OBJECTS}/{prefix}");
            for name in self.names(&folder)? {
                let Some(name) = name.to_str() else { continue };
                let Some((id, is_whole)) = object(prefix, name) else { continue };
                if is_whole && keep(&id) {
                    continue;
                }
                let path = format!("{folder}/{name}");
                let length = self.root.length(&path).map_err(self.unread(&path))?;
                self.clear(&path)?;
                swept.files += 1;
                swept.bytes += length.unwrap_or_default();
            }
        }
        Ok(swept)
    }

    /// The names in the folder `path`; none if there is no such folder.
    fn names(&self, path: &str) -> Result<Vec<OsString>, FolderError> {
        let folder = self.path.join(path);
        let list = || fs::read_dir(&folder)?.map(|entry| Ok(entry?.file_name())).collect::<io::Result<Vec<_>>>();
        match list() {
            Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => Ok(vec![]),
            names => names.map_err(self.unread(path)),
        }
    }

    fn unread(&self, path: &str) -> impl FnOnce(io::Error) -> FolderError {
        let path = self.path.join(Path::new(path));
        move |source| FolderError::Read { path, source }
    }
}

/// The object that the file `name` in the folder `prefix` is, or is a part of, and whether it has its final name.
fn object(prefix: &str, name: &str) -> Option<(ObjectId, bool)> {
    let (name, is_whole) = match name.strip_suffix(temporary("").as_str()) {
        Some(name) => (name, false),
        None => (name, true),
    };
    let (rest, part) = name.split_once('.').unwrap_or((name, "000"));
    let is_part = part.len() == 3 && part.bytes().all(|b| b.is_ascii_digit());
    let id = ObjectId::parse(&format!("{prefix}{rest}")).ok()?;
    is_part.then_some((id, is_whole))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_left_and_what_nobody_wants_goes_and_nothing_else() {
        let scratch = tempfile::tempdir().unwrap();
        let folder = Folder::create(scratch.path()).unwrap();
        assert_eq!(folder.sweep(|_| false).unwrap(), Sweep::default(), "an empty folder has nothing");
        let put = |bytes: &[u8]| {
            let id = ObjectId::of(bytes);
            folder.put(&id, bytes.len() as u64, &mut &bytes[..], scratch.path(), &mut |_| ()).unwrap();
            id
        };
        let (kept, old) = (put(b"kept"), put(b"old"));
        let beside = |id: &ObjectId, ending: &str| scratch.path().join(format!("{}{ending}", id.path()));
        let left = ObjectId::of(b"in parts");
        fs::create_dir_all(beside(&left, "").parent().unwrap()).unwrap();
        for (id, ending) in [(&kept, ".new"), (&left, ".000"), (&left, ".001"), (&left, ".002.new")] {
            fs::write(beside(id, ending), "left").unwrap();
        }
        let foreign = [beside(&kept, ".jpg"), beside(&kept, ".0000"), scratch.path().join("objects/holiday.jpg")];
        for path in &foreign {
            fs::write(path, "not ours").unwrap();
        }
        let again = folder.sweep(|id| *id == kept || *id == left).unwrap();
        assert_eq!(again, Sweep { files: 3, bytes: 3 + 4 + 4 });
        assert!(folder.holds(&kept, 4) && folder.holds(&left, 8) && !folder.holds(&old, 3));
        assert!(foreign.iter().all(|path| path.exists()));
        folder.discard(&left).unwrap();
        folder.discard(&left).unwrap();
        assert!(!folder.holds(&left, 8) && !beside(&left, ".001").exists());
        assert!(folder.free_bytes().unwrap() > 0);
    }

    #[test]
    fn a_link_that_a_kill_left_is_replaced_and_what_it_leads_to_is_not_written_to() {
        let scratch = tempfile::tempdir().unwrap();
        let (clip, folder) = (scratch.path().join("clip"), Folder::create(&scratch.path().join("bundle")).unwrap());
        fs::write(&clip, "the old clip").unwrap();
        let id = ObjectId::of(b"the new clip");
        let left = folder.path.join(temporary(&id.path()));
        fs::create_dir_all(left.parent().unwrap()).unwrap();
        fs::hard_link(&clip, &left).unwrap();
        folder.put(&id, 12, &mut &b"the new clip"[..], &clip, &mut |_| ()).unwrap();
        assert_eq!(fs::read_to_string(&clip).unwrap(), "the old clip");
        assert!(folder.holds(&id, 12));
    }

    #[test]
    fn an_object_with_a_second_name_is_replaced_by_a_file_of_its_own() {
        let scratch = tempfile::tempdir().unwrap();
        let (clip, folder) = (scratch.path().join("clip"), Folder::create(&scratch.path().join("bundle")).unwrap());
        fs::write(&clip, "the clip").unwrap();
        let id = ObjectId::of(b"the clip");
        let object = folder.path.join(id.path());
        fs::create_dir_all(object.parent().unwrap()).unwrap();
        fs::hard_link(&clip, &object).unwrap();
        assert!(!folder.holds(&id, 8));
        folder.put_file(&id, 8, &clip, &mut |_| ()).unwrap();
        fs::write(&object, "overwritten").unwrap();
        assert_eq!(fs::read_to_string(&clip).unwrap(), "the clip");
    }

    #[test]
    fn what_is_shared_is_looked_at_too() {
        let scratch = tempfile::tempdir().unwrap();
        let (clip, folder) = (scratch.path().join("clip"), Folder::create(&scratch.path().join("bundle")).unwrap());
        fs::write(&clip, "another clip").unwrap();
        let id = ObjectId::of(b"the new clip");
        let refused = folder.put_file(&id, 12, &clip, &mut |_| ()).unwrap_err();
        assert!(matches!(refused, FolderError::Changed { .. }), "{refused}");
        assert!(!folder.holds(&id, 12));
        assert_eq!(folder.sweep(|_| true).unwrap(), Sweep::default(), "no half is left");
    }
}
