//! The files that are kept, each made once.
//!
//! Owns their names and the rule that two threads never make the same file. A file is there whole or not at all. Never knows
//! what is in one.
//!
//! Start at [`Cache::once`].

use std::collections::HashMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use operations::program::now;

use super::MediaError;
use super::limit::DAY;
use crate::lock::locked;

/// The folder of what is kept.
#[derive(Debug)]
pub(super) struct Cache {
    folder: PathBuf,
    /// The files that are made or waited for.
    busy: Mutex<HashMap<PathBuf, Arc<Mutex<()>>>>,
}

impl Cache {
    /// The cache in `folder`, which is made when it is needed.
    pub(super) fn open(folder: &Path) -> Self {
        Self { folder: folder.to_owned(), busy: Mutex::default() }
    }

    /// The path of the file of `key` whose name ends with `ending`. Keys are digits and letters.
    pub(super) fn path(&self, key: &str, ending: &str) -> PathBuf {
        // Thousands of files in one folder are slow to list.
        let part = key.get(..2).unwrap_or(key);
        self.folder.join(part).join(format!("{key}{ending}"))
    }

    /// Where it is.
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// The file of `key` with this ending, if it is there. It is used now.
    pub(super) fn find(&self, key: &str, ending: &str) -> Option<PathBuf> {
        Some(self.path(key, ending)).filter(|path| use_file(path))
    }

    /// The file of `key` with this ending; `make` writes it to the path that it is given, if it is not there. A second thread
    /// waits for the first.
    /// Errors: Those of `make`; the file is then not there.
    pub(super) fn once(
        &self,
        key: &str,
        ending: &str,
        make: impl FnOnce(&Path) -> Result<(), MediaError>,
    ) -> Result<PathBuf, MediaError> {
        let path = self.path(key, ending);
        let own = Arc::clone(self.busy().entry(path.clone()).or_default());
        let made = {
            let _alone = locked(&own);
            if use_file(&path) { Ok(()) } else { folder_of(&path).and_then(|()| make(&path)) }
        };
        let mut busy = self.busy();
        // The map and this thread have it: nobody else waits.
        if Arc::strong_count(&own) == 2 {
            busy.remove(&path);
        }
        made.map(|()| path)
    }

    fn busy(&self) -> std::sync::MutexGuard<'_, HashMap<PathBuf, Arc<Mutex<()>>>> {
        locked(&self.busy)
    }
}

/// Has `path` hold `bytes`.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), MediaError> {
    folder_of(path)?;
    durable::write(path, bytes).map_err(MediaError::file(path))
}

/// Whether the file at `path` is there. Its time of change is that of its last use, to the day.
fn use_file(path: &Path) -> bool {
    let Ok(status) = fs::metadata(path) else { return false };
    let now = now::system();
    let is_of_today = status.modified().is_ok_and(|time| now.duration_since(time).is_ok_and(|since| since < DAY));
    if !is_of_today {
        // Without it the file is made again sooner, and nothing else.
        let _ = File::options().append(true).open(path).and_then(|file| file.set_modified(now));
    }
    status.is_file()
}

fn folder_of(path: &Path) -> Result<(), MediaError> {
    let folder = path.parent().unwrap_or(path);
    fs::create_dir_all(folder).map_err(MediaError::file(folder))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};
    use std::thread;

    #[test]
    fn a_file_is_made_once_whoever_asks_and_again_after_a_failure() {
        let scratch = tempfile::tempdir().unwrap();
        let cache = Cache::open(&scratch.path().join("cache"));
        let failed = cache.once("abc", ".txt", |_| Err(MediaError::Cancelled));
        assert!(matches!(failed, Err(MediaError::Cancelled)) && cache.find("abc", ".txt").is_none());
        let made = AtomicU32::new(0);
        let make = |path: &Path| {
            made.fetch_add(1, Ordering::Relaxed);
            write(path, b"made")
        };
        thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| cache.once("abc", ".txt", make).unwrap());
            }
        });
        assert_eq!(made.into_inner(), 1);
        assert_eq!(fs::read(cache.find("abc", ".txt").unwrap()).unwrap(), b"made");
        assert!(cache.busy().is_empty());
    }

    #[test]
    fn a_file_that_is_used_is_as_new() {
        let scratch = tempfile::tempdir().unwrap();
        let cache = Cache::open(&scratch.path().join("cache"));
        let path = cache.once("abc", ".txt", |path| write(path, b"made")).unwrap();
        let long_ago = now::system() - 40 * DAY;
        let used = || fs::metadata(&path).unwrap().modified().unwrap();
        for use_it in [&(|| drop(cache.find("abc", ".txt"))) as &dyn Fn(), &|| {
            drop(cache.once("abc", ".txt", |_| Err(MediaError::Cancelled)));
        }] {
            File::options().append(true).open(&path).unwrap().set_modified(long_ago).unwrap();
            use_it();
            assert!(used() > long_ago + 39 * DAY);
        }
        assert_eq!(fs::read(&path).unwrap(), b"made");
    }
}
