//! Bundles and flocks as they lie in folders.
//!
//! Owns how a bundle is laid out by hand, and how a folder is read back. Shared with the claims of the whole project,
//! whose press has keys of its own.

use bundle::{Addressees, Contents, FileEntry, FilePath, Folder, ObjectId, SealBody, SecretKey, Sequence, UnitId};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::Path;

/// The files of a flock, by path.
type Files = BTreeMap<String, Vec<u8>>;

/// Lays a bundle of `files` into `folder`, signed with `key`, for `units`, or for all if there are none.
pub(crate) fn lay(key: &SecretKey, folder: &Path, files: &Files, units: &[&str], sequence: u64) {
    let entry = |(path, bytes): (&String, &Vec<u8>)| FileEntry {
        path: FilePath::new(path).unwrap(),
        id: ObjectId::of(bytes),
        size: bytes.len() as u64,
    };
    let contents = Contents::new(files.iter().map(entry).collect()).unwrap();
    let list = contents.to_text().into_bytes();
    let to = Folder::create(folder).unwrap();
    for bytes in files.values().chain([&list]) {
        to.put(&ObjectId::of(bytes), bytes.len() as u64, &mut &bytes[..], folder, &mut |_| ()).unwrap();
    }
    let letter = SealBody {
        flock: "aurora".to_owned(),
        addressees: Addressees::of(units.iter().map(|name| UnitId::new(name).unwrap())),
        sequence: Sequence(sequence),
        created: "2026-03-01T12:00:00Z".to_owned(),
        contents: ObjectId::of(&list),
        contents_size: list.len() as u64,
        statements: None,
    };
    to.put_seal(&letter.addressees, &letter.sign(key).unwrap()).unwrap();
}

/// Every file beneath `folder`.
///
/// # Errors
/// What the disk says.
pub(crate) fn files_in(folder: &Path) -> io::Result<Files> {
    let mut files = Files::new();
    walk(folder, "", &mut files)?;
    Ok(files)
}

fn walk(folder: &Path, at: &str, files: &mut Files) -> io::Result<()> {
    for entry in fs::read_dir(folder.join(at))? {
        let entry = entry?;
        let no_text = |name: std::ffi::OsString| io::Error::other(format!("`{}` is no text", name.display()));
        let name = entry.file_name().into_string().map_err(no_text)?;
        let path = if at.is_empty() { name } else { format!("{at}/{name}") };
        if entry.file_type()?.is_dir() {
            walk(folder, &path, files)?;
        } else {
            files.insert(path, fs::read(entry.path())?);
        }
    }
    Ok(())
}
