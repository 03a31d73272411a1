//! The state of every clip: whether it is there, on its way, or not.
//!
//! Owns how it is found: by the file, by the jobs that render, and by the faults that the last check found. Opens no clip:
//! the page asks for thousands after each edit.
//!
//! Start at [`ClipStates::of`].

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use flock::{Clip, ClipPath};

/// The state of a clip, by its name on the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum ClipState {
    /// The sheep has no loop.
    None,
    /// It is not there.
    Missing,
    /// A job will render it.
    Queued,
    /// A job renders it.
    Rendering,
    /// It is there.
    There,
    /// The last check found that it is not what the manifest says, or does not decode.
    Damaged,
}

/// A clip's file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClipFile {
    pub(crate) state: ClipState,
    /// The part of its frames that are rendered, of a clip that is being rendered.
    pub(crate) percent: Option<f64>,
    pub(crate) bytes: Option<u64>,
    /// When it was changed, in milliseconds since 1970.
    pub(crate) made_ms: Option<u64>,
}

/// What is known of clips beside their files.
#[derive(Clone, Debug, Default)]
pub(crate) struct ClipStates {
    /// Clips that jobs render, with the part that is done; `None` of those that wait.
    pub(crate) jobs: BTreeMap<ClipPath, Option<f64>>,
    /// Clips that the last check found to be damaged.
    pub(crate) damaged: BTreeSet<ClipPath>,
}

impl ClipStates {
    /// The state of `clip` of the flock in `folder`.
    pub(crate) fn of(&self, folder: &Path, clip: Option<&Clip>) -> ClipFile {
        let Some(clip) = clip else {
            return ClipFile { state: ClipState::None, percent: None, bytes: None, made_ms: None };
        };
        let file = fs::metadata(clip.path.inside(folder)).ok().filter(fs::Metadata::is_file);
        let (state, percent) = match (self.jobs.get(&clip.path), &file) {
            (Some(Some(part)), _) => (ClipState::Rendering, Some((100.0 * part).floor())),
            (Some(None), _) => (ClipState::Queued, None),
            (None, None) => (ClipState::Missing, None),
            (None, Some(_)) if self.damaged.contains(&clip.path) => (ClipState::Damaged, None),
            (None, Some(_)) => (ClipState::There, None),
        };
        let bytes = file.as_ref().map(fs::Metadata::len);
        ClipFile { state, percent, bytes, made_ms: file.and_then(|file| file.modified().ok()).map(since_1970_ms) }
    }
}

/// `time` in milliseconds since 1970; 0 before.
pub(crate) fn since_1970_ms(time: SystemTime) -> u64 {
    time.duration_since(UNIX_EPOCH).map_or(0, |since| u64::try_from(since.as_millis()).unwrap_or(u64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use timing::FrameCount;

    #[test]
    fn a_clip_is_what_its_job_says_then_what_the_check_says_then_what_the_folder_says() {
        let scratch = tempfile::tempdir().unwrap();
        let path = ClipPath::new("a.mp4").unwrap();
        let clip = Clip { path: path.clone(), frames: FrameCount(9), hash: None };
        let mut states = ClipStates::default();
        let state = |states: &ClipStates| states.of(scratch.path(), Some(&clip)).state;
        assert_eq!(states.of(scratch.path(), None).state, ClipState::None);
        assert_eq!(state(&states), ClipState::Missing);
        fs::write(scratch.path().join("a.mp4"), b"12345").unwrap();
        assert_eq!((state(&states), states.of(scratch.path(), Some(&clip)).bytes), (ClipState::There, Some(5)));
        states.damaged.insert(path.clone());
        assert_eq!(state(&states), ClipState::Damaged);
        states.jobs.insert(path.clone(), None);
        assert_eq!(state(&states), ClipState::Queued);
        states.jobs.insert(path, Some(0.437));
        assert_eq!(states.of(scratch.path(), Some(&clip)).percent, Some(43.0));
        assert_eq!(state(&states), ClipState::Rendering);
    }
}
