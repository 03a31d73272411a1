//! The boot partitions: what the firmware starts lies on each.
//!
//! Owns the reading and the writing of their files. A file is put into its place whole or not at all, and was read back
//! from the disk before. Never decides what is to lie there: `plan.rs` does.
//!
//! Start at [`Boots::read`] and [`Boots::apply`].

use crate::plan::{Entry, EntryName, Step};
use crate::report::{Answer, Fatal, at};
use crate::steady::{Steady, forget, sync_folder};
use bundle::{StartFile, is_whole};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};
use tracing::{info, warn};

/// Where the boot loader looks for what to start.
const ENTRIES: &str = "EFI/Linux";
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

    pub(crate) fn has_spare(&self) -> bool {
        self.folders.len() > 1
    }

    /// Takes away what was never ended.
    pub(crate) fn sweep(&self) -> Result<(), Fatal> {
        for folder in &self.folders {
            for path in files_below(folder)? {
                if path.extension().is_some_and(|ending| ending == UNFINISHED) {
                    fs::remove_file(&path).map_err(at("remove", &path))?;
                }
            }
        }
        Ok(())
    }

    /// Lays a file of the boot loader anew where it is damaged or missing. A whole one stays as it is, whichever release it
    /// is of: it has started this unit.
    pub(crate) fn mend_loaders(&self, answer: &mut Answer) -> Result<(), Fatal> {
        for path in files_below(self.loader)? {
            let reference = read(&path)?;
            let below = path.strip_prefix(self.loader).expect("it lies below the folder that was listed");
            for folder in &self.folders {
                let there = folder.join(below);
                let is_good = readable(&there)?.is_some_and(|found| found == reference || is_whole(&found));
                if !is_good {
                    put(&reference, &there)?;
                    warn!(file = %there.display(), "a file of the boot loader was damaged: it is mended");
                    answer.mended.push(there.display().to_string());
                }
            }
        }
        Ok(())
    }

    /// The start files that lie there.
    pub(crate) fn read(&self) -> Result<Vec<Entry>, Fatal> {
        let mut entries = Vec::new();
        for (boot, folder) in self.folders.iter().enumerate() {
            let folder = folder.join(ENTRIES);
            fs::create_dir_all(&folder).map_err(at("make", &folder))?;
            for found in fs::read_dir(&folder).map_err(at("read", &folder))? {
                let text = found.map_err(at("read", &folder))?.file_name();
                let Some(name) = text.to_str().and_then(EntryName::parse) else { continue };
                let bytes = readable(&folder.join(&name.text))?.filter(|bytes| is_whole(bytes));
                let file = bytes.and_then(|bytes| StartFile::read(&bytes).ok());
                let file = file.filter(|file| file.version == name.version);
                entries.push(Entry { boot, name, file });
            }
        }
        entries.sort_by(|one, other| (one.boot, &one.name.text).cmp(&(other.boot, &other.name.text)));
        Ok(entries)
    }

    /// Does `steps`, in their order.
    pub(crate) fn apply(&self, steps: Vec<Step>, answer: &mut Answer) -> Result<(), Fatal> {
        for step in steps {
            match step {
                Step::Copy { boot, name, from, from_name, was_damaged } => {
                    let (to, from) = (self.entry(boot, &name), self.entry(from, &from_name));
                    put(&read(&from)?, &to)?;
                    if was_damaged {
                        warn!(file = %to.display(), "a start file was damaged: it is mended");
                        answer.mended.push(to.display().to_string());
                    } else {
                        info!(file = %to.display(), "a start file has a spare copy");
                    }
                }
                Step::Remove { boot, name, was_damaged } => {
                    let path = self.entry(boot, &name);
                    fs::remove_file(&path).map_err(at("remove", &path))?;
                    sync(&path)?;
                    warn!(file = %path.display(), was_damaged, "a start file that can't be used is gone");
                    if was_damaged {
                        answer.lost.push(path.display().to_string());
                    }
                }
                Step::Rename { boot, name, to } => {
                    let (path, to) = (self.entry(boot, &name), self.entry(boot, &to));
                    fs::rename(&path, &to).map_err(at("rename", &path))?;
                    sync(&to)?;
                }
            }
        }
        Ok(())
    }

    fn entry(&self, boot: usize, name: &str) -> PathBuf {
        self.folders[boot].join(ENTRIES).join(name)
    }
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
        forget(&file)?;
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
    let mut steady = Steady::new(&file);
    steady.write(bytes, 0).and_then(|()| steady.flush()).map_err(at("write", &unfinished))?;
    if read(&unfinished)? != bytes {
        let other = io::Error::new(ErrorKind::InvalidData, "what was written is not what is read back");
        return Err(at("read back", &unfinished)(other));
    }
    fs::rename(&unfinished, path).map_err(at("make", path))?;
    sync(path)
}

fn sync(path: &Path) -> Result<(), Fatal> {
    let folder = path.parent().unwrap_or(Path::new("."));
    sync_folder(folder).map_err(at("sync", folder))
}
