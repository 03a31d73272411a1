//! What is kept no longer.
//!
//! Owns the limits of the folder: what no key of this run of the program names goes a month after its last use, and copies
//! of clips go before they fill the disk. All of it can be made again. Never decides what the flock needs: whoever gives
//! keys does.
//!
//! Start at [`Media::clear`].

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use super::Media;
use super::clips::FRAGMENTS;

/// A use is noted to the day.
pub(super) const DAY: Duration = Duration::from_hours(24);
/// What has no key is kept so long after its last use.
const IDLE: Duration = Duration::from_hours(30 * 24);
/// The most bytes of copies of clips. One is made again in a moment, and a long walk makes one of every clip.
const MOST_COPIED: u64 = 16 << 30;

/// A file of the cache.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Kept {
    path: PathBuf,
    bytes: u64,
    /// How long ago it was used.
    idle: Duration,
}

impl Media {
    /// Deletes what was not used for a month at the time `now` and has no key that was given since the program began; then
    /// copies of clips, those used longest ago first, as long as there are more than the limit. Nothing goes that was used
    /// within a day.
    pub(crate) fn clear(&self, now: SystemTime) {
        let kept = files(self.cache.folder(), now);
        for path in surplus(kept, &|key| self.knows(key), MOST_COPIED) {
            // It goes the next time, if it can.
            let _ = fs::remove_file(path);
        }
    }
}

/// All files of the cache in `folder`.
fn files(folder: &Path, now: SystemTime) -> Vec<Kept> {
    let entries = |folder: &Path| fs::read_dir(folder).into_iter().flatten().flatten();
    let file = |entry: fs::DirEntry| {
        let status = entry.metadata().ok().filter(fs::Metadata::is_file)?;
        // What is of the future by a wrong clock was used just now.
        let idle = now.duration_since(status.modified().ok()?).unwrap_or_default();
        Some(Kept { path: entry.path(), bytes: status.len(), idle })
    };
    entries(folder).flat_map(|part| entries(&part.path()).filter_map(file).collect::<Vec<_>>()).collect()
}

/// The files that go. Those of one key are of use together: they go together, a month after the last use of any.
fn surplus(kept: Vec<Kept>, is_given: &dyn Fn(&str) -> bool, most_copied: u64) -> Vec<PathBuf> {
    let mut keys: HashMap<String, Vec<Kept>> = HashMap::new();
    for file in kept {
        keys.entry(key(&file.path)).or_default().push(file);
    }
    let is_idle = |files: &[Kept]| files.iter().all(|file| file.idle > IDLE);
    let (gone, stays): (Vec<_>, Vec<_>) = keys.into_iter().partition(|(key, files)| is_idle(files) && !is_given(key));
    let mut copies: Vec<Kept> = stays.into_iter().flat_map(|(_, files)| files).filter(is_copy).collect();
    copies.sort_by_key(|file| file.idle);
    let mut bytes = 0_u64;
    copies.retain(|file| {
        bytes = bytes.saturating_add(file.bytes);
        bytes > most_copied && file.idle > DAY
    });
    gone.into_iter().flat_map(|(_, files)| files).chain(copies).map(|file| file.path).collect()
}

/// The key of a file: what its name has before the first hyphen.
fn key(path: &Path) -> String {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    name.split('-').next().unwrap_or_default().to_owned()
}

fn is_copy(file: &Kept) -> bool {
    file.path.to_str().is_some_and(|path| path.ends_with(FRAGMENTS))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of the cache, so many days and a second after its last use.
    fn file(name: &str, bytes: u64, days: u32) -> Kept {
        Kept { path: PathBuf::from(name), bytes, idle: days * DAY + Duration::from_secs(1) }
    }

    fn gone(kept: &[Kept]) -> Vec<String> {
        let gone = surplus(kept.to_vec(), &|key| key.starts_with("given"), 100);
        let mut gone: Vec<String> = gone.iter().map(|path| path.display().to_string()).collect();
        gone.sort();
        gone
    }

    #[test]
    fn what_the_flock_no_longer_names_goes_a_month_after_its_last_use_and_no_sooner() {
        let kept = [
            file("given1-strip.jpg", 9, 400),
            file("old1-strip.jpg", 9, 30),
            file("old1-strip.json", 9, 31),
            file("old2-strip.jpg", 9, 29),
            file("old2-fragments.mp4", 9, 31),
            file("old2-codec.txt", 9, 31),
        ];
        assert_eq!(gone(&kept), ["old1-strip.jpg", "old1-strip.json"]);
    }

    #[test]
    fn copies_of_clips_go_above_the_limit_those_used_longest_ago_first_and_none_of_today() {
        let copies = |days: [u32; 4]| {
            let name = |at: usize| format!("given{at}-fragments.mp4");
            let copies: Vec<Kept> = (0..4).map(|at| file(&name(at), 40, days[at])).collect();
            let pictures = [file("given9-strip.jpg", 500, 9)];
            gone(&[&copies[..], &pictures].concat())
        };
        assert_eq!(copies([3, 1, 4, 2]), ["given0-fragments.mp4", "given2-fragments.mp4"]);
        assert_eq!(copies([0, 0, 0, 0]), [""; 0]);
    }
}
