//! The boot partitions: what the firmware starts lies on each.
//!
//! Owns the reading and the writing of their files. A file is put into its place whole or not at all, and was read back
//! from the disk before. Never decides what is to lie there: `plan.rs` does.
//!
//! Start at [`Boots::read`] and [`Boots::apply`].

use crate::fatal::{Answer, Fatal, at};
use crate::plan::{Entry, EntryName, Place, Step};
use bundle::{BootFiles, ENTRIES, SYSTEMS, StartFile, copy_folder, gather, lay_out};
use durable::{FlushedWriter, drop_cache, persist, sync_names};
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Component, Path, PathBuf};
use tracing::{info, warn};

/// The sums of the other files of a boot loader, as `sha256sum` writes them.
const SUMS: &str = "loader/sums";
/// How a file is called until it is whole.
const UNFINISHED: &str = "new";

/// The boot partitions, and what the boot loader on them should be.
#[derive(Debug)]
pub(crate) struct Boots<'o> {
    folders: Vec<&'o Path>,
    loader: &'o Path,
}

impl<'o> Boots<'o> {
    pub(crate) fn new(boot: &'o Path, spare: Option<&'o Path>, loader: &'o Path) -> Self {
        Self { folders: std::iter::once(boot).chain(spare).collect(), loader }
    }

    /// Takes away what was never ended, and what no entry starts.
    pub(crate) fn sweep(&self) -> Result<(), Fatal> {
        for folder in &self.folders {
            for path in files_below(folder)? {
                if path.extension().is_some_and(|ending| ending == UNFINISHED) {
                    fs::remove_file(&path).map_err(at("remove", &path))?;
                }
            }
            let started: BTreeSet<_> =
                names(&folder.join(ENTRIES))?.iter().map(|name| copy_folder(&name.version, name.copy)).collect();
            for path in listed(&folder.join(SYSTEMS))? {
                let is_started =
                    path.file_name().and_then(|name| name.to_str()).is_some_and(|name| started.contains(name));
                if path.is_dir() && !is_started {
                    remove_parts(&path)?;
                }
            }
        }
        Ok(())
    }

    /// Lays a boot loader anew that is damaged. A whole one stays as it is, whichever release it is of: it has started
    /// this unit.
    pub(crate) fn mend_loaders(&self, answer: &mut Answer) -> Result<(), Fatal> {
        for folder in &self.folders {
            if has_whole_loader(folder)? {
                continue;
            }
            for path in files_below(self.loader)? {
                let reference = read(&path)?;
                let there =
                    folder.join(path.strip_prefix(self.loader).expect("it lies below the folder that was listed"));
                if readable(&there)?.is_none_or(|found| found != reference) {
                    put(&reference, &there)?;
                    warn!(file = %there.display(), "repaired a damaged file of the boot loader");
                    answer.mended.push(there.display().to_string());
                }
            }
        }
        Ok(())
    }

    /// How many boot partitions there are.
    pub(crate) fn count(&self) -> usize {
        self.folders.len()
    }

    /// The entries that lie there.
    pub(crate) fn read(&self) -> Result<Vec<Entry>, Fatal> {
        let mut entries = Vec::new();
        for (boot, folder) in self.folders.iter().enumerate() {
            for name in names(&folder.join(ENTRIES))? {
                let place = Place { boot, name };
                let bytes = self.gathered(&place)?.filter(|bytes| lay_out(bytes, place.name.copy).is_some());
                let file = bytes.and_then(|bytes| StartFile::read(&bytes).ok());
                let file = file.filter(|file| file.version == place.name.version);
                entries.push(Entry { place, file });
            }
        }
        entries.sort_by(|one, other| one.place.cmp(&other.place));
        Ok(entries)
    }

    /// Does `steps`, in their order.
    pub(crate) fn apply(&self, steps: Vec<Step>, answer: &mut Answer) -> Result<(), Fatal> {
        for step in steps {
            match step {
                Step::Copy { to, from, was_damaged } => {
                    let path = self.entry(&to);
                    self.copy(&to, &from)?;
                    if was_damaged {
                        warn!(entry = %path.display(), "repaired a damaged boot entry");
                        answer.mended.push(path.display().to_string());
                    } else {
                        info!(entry = %path.display(), "a boot entry has another copy");
                    }
                }
                Step::Remove { place, was_damaged } => {
                    let path = self.entry(&place);
                    fs::remove_file(&path).map_err(at("remove", &path))?;
                    sync_names(&path).map_err(at("sync the folder of", &path))?;
                    let parts = self.parts(&place);
                    if parts.is_dir() {
                        remove_parts(&parts)?;
                    }
                    warn!(entry = %path.display(), was_damaged, "removed a boot entry that cannot be used");
                    if was_damaged {
                        answer.lost.push(path.display().to_string());
                    }
                }
                Step::Rename { place, to } => {
                    let path = self.entry(&place);
                    let to = self.entry(&Place { boot: place.boot, name: to });
                    persist(&path, &to).map_err(at("rename", &path))?;
                }
            }
        }
        Ok(())
    }

    /// Makes all that `to` starts what `from` starts; the entry comes last.
    fn copy(&self, to: &Place, from: &Place) -> Result<(), Fatal> {
        let damaged = || io::Error::new(ErrorKind::InvalidData, "it was whole before and is damaged now");
        let source = self.entry(from);
        let bytes = self.gathered(from)?.ok_or_else(damaged).map_err(at("read", &source))?;
        let BootFiles { entry, parts } =
            lay_out(&bytes, to.name.copy).ok_or_else(damaged).map_err(at("read", &source))?;
        for (path, part) in parts {
            put(part, &self.folders[to.boot].join(path))?;
        }
        put(entry.as_bytes(), &self.entry(to))
    }

    /// What an entry starts, with its text, as it travels; `None` if some of it is missing or can't be read.
    fn gathered(&self, place: &Place) -> Result<Option<Vec<u8>>, Fatal> {
        let entry = readable(&self.entry(place))?.and_then(|bytes| String::from_utf8(bytes).ok());
        let Some(entry) = entry else { return Ok(None) };
        let mut failed = None;
        let bytes = gather(&entry, place.name.copy, |path| {
            readable(&self.folders[place.boot].join(path)).unwrap_or_else(|fatal| {
                failed = Some(fatal);
                None
            })
        });
        failed.map_or(Ok(bytes), Err)
    }

    fn entry(&self, place: &Place) -> PathBuf {
        self.folders[place.boot].join(ENTRIES).join(place.name.to_string())
    }

    fn parts(&self, place: &Place) -> PathBuf {
        self.folders[place.boot].join(SYSTEMS).join(copy_folder(&place.name.version, place.name.copy))
    }
}

/// Whether every file of the boot loader on a boot partition is what the sums there say.
fn has_whole_loader(boot: &Path) -> Result<bool, Fatal> {
    let Some(sums) = readable(&boot.join(SUMS))?.and_then(|sums| String::from_utf8(sums).ok()) else {
        return Ok(false);
    };
    for line in sums.lines() {
        let Some((sum, name)) = line.split_once("  ") else { return Ok(false) };
        // A damaged name leads nowhere else.
        let is_plain = Path::new(name).components().all(|part| matches!(part, Component::Normal(_)));
        let found = if is_plain { readable(&boot.join(name))? } else { None };
        if found.is_none_or(|found| Sum(Sha256::digest(found).into()).to_string() != sum) {
            return Ok(false);
        }
    }
    Ok(!sums.is_empty())
}

/// A SHA-256, told in hex digits.
struct Sum([u8; 32]);

impl fmt::Display for Sum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// The names of the entries in a folder; it is made if it is missing.
fn names(folder: &Path) -> Result<Vec<EntryName>, Fatal> {
    let name = |path: &PathBuf| path.file_name().and_then(|name| name.to_str()).and_then(EntryName::parse);
    Ok(listed(folder)?.iter().filter_map(name).collect())
}

/// What is in a folder; it is made if it is missing.
fn listed(folder: &Path) -> Result<Vec<PathBuf>, Fatal> {
    fs::create_dir_all(folder).map_err(at("make", folder))?;
    let entries = fs::read_dir(folder).map_err(at("read", folder))?;
    entries.map(|entry| entry.map(|entry| entry.path()).map_err(at("read", folder))).collect()
}

/// Takes the parts of a copy away, and their folder.
fn remove_parts(folder: &Path) -> Result<(), Fatal> {
    for path in listed(folder)? {
        fs::remove_file(&path).map_err(at("remove", &path))?;
    }
    fs::remove_dir(folder).map_err(at("remove", folder))?;
    sync_names(folder).map_err(at("sync the folder of", folder))
}

/// Every file in a folder and the folders in it.
fn files_below(folder: &Path) -> Result<Vec<PathBuf>, Fatal> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(at("read", folder))? {
        let path = entry.map_err(at("read", folder))?.path();
        if path.is_dir() { files.extend(files_below(&path)?) } else { files.push(path) }
    }
    files.sort();
    Ok(files)
}

fn read(path: &Path) -> Result<Vec<u8>, Fatal> {
    fs::read(path).map_err(at("read", path))
}

/// What is in the file; `None` if it is not there or its disk does not give it back.
fn readable(path: &Path) -> Result<Option<Vec<u8>>, Fatal> {
    let read = || {
        let mut file = File::open(path)?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        drop_cache(&file)?;
        Ok(bytes)
    };
    match read() {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if is_damage(&error) => Ok(None),
        Err(error) => Err(at("read", path)(error)),
    }
}

/// Whether an error tells of a file that is damaged, and not of a program that may not read it.
fn is_damage(error: &io::Error) -> bool {
    error.kind() == ErrorKind::NotFound || error.raw_os_error() == Some(rustix::io::Errno::IO.raw_os_error())
}

/// Makes the file `path` hold `bytes`, whole or not at all.
fn put(bytes: &[u8], path: &Path) -> Result<(), Fatal> {
    let folder = path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder).map_err(at("make", folder))?;
    let unfinished = path.with_extension(UNFINISHED);
    let file = File::options().read(true).write(true).create(true).truncate(true).open(&unfinished);
    let file = file.map_err(at("write", &unfinished))?;
    let mut writer = FlushedWriter::new(&file);
    writer.write_all(bytes).and_then(|()| writer.flush()).map_err(at("write", &unfinished))?;
    if read(&unfinished)? != bytes {
        let other = io::Error::new(ErrorKind::InvalidData, "other bytes were read back than were written");
        return Err(at("read back", &unfinished)(other));
    }
    persist(&unfinished, path).map_err(at("make", path))
}
