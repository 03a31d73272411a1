//! The usual paths of a flock's files, and what is usual of a clip that is yet to be rendered.
//!
//! Owns the folders and the names that the tools give; a manifest may name any others. Never touches a file.

use crate::manifest::{ClipPath, SheepId};

/// Frames of a loop that is yet to be rendered, by default: 26 seconds at 30 per second.
pub const LOOP_FRAMES: u32 = 768;
/// Frames of a transition that is yet to be rendered, by default: 13 seconds at 30 per second.
pub const TRANSITION_FRAMES: u32 = 384;
/// The folders of a new flock.
pub const FOLDERS: [&str; 3] = ["genomes", "loops", "transitions"];
/// The file that says who made what, beside the manifest.
pub const CREDITS: &str = "credits.toml";
/// The ending of clips.
pub const CLIP: &str = "mp4";
/// The ending of genomes.
pub const GENOME: &str = "flam3";

/// The genome of the sheep `id`.
pub fn genome(id: &SheepId, ending: &str) -> ClipPath {
    path(&format!("genomes/{id}.{ending}"))
}

/// The loop of the sheep `id`.
pub fn of_loop(id: &SheepId, ending: &str) -> ClipPath {
    path(&format!("loops/{id}.{ending}"))
}

/// The transition from `from` to `to`.
pub fn of_transition(from: &SheepId, to: &SheepId, ending: &str) -> ClipPath {
    path(&format!("transitions/{from}={to}.{ending}"))
}

/// `path` with the sheep `old` called `new`, if it has the usual name, in any folder.
pub fn renamed(path: &ClipPath, old: &SheepId, new: &SheepId) -> Option<ClipPath> {
    let (folder, name) = path.as_str().rsplit_once('/').map_or(("", path.as_str()), |(folder, name)| (folder, name));
    let (stem, ending) = name.rsplit_once('.')?;
    let ids: Vec<&str> = stem.split('=').collect();
    if ids.len() > 2 || !ids.contains(&old.as_str()) {
        return None;
    }
    let ids: Vec<&str> = ids.into_iter().map(|id| if id == old.as_str() { new.as_str() } else { id }).collect();
    let slash = if folder.is_empty() { "" } else { "/" };
    ClipPath::new(&format!("{folder}{slash}{}.{ending}", ids.join("="))).ok()
}

fn path(text: &str) -> ClipPath {
    ClipPath::new(text).expect("ids have no characters that a path cannot have")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_renamed_with_its_sheep_where_it_bears_its_name() {
        let id = |text| SheepId::new(text).unwrap();
        let renamed = |path: &str| {
            let path = renamed(&ClipPath::new(path).unwrap(), &id("1.2"), &id("ram"));
            path.map(|path| path.as_str().to_owned())
        };
        assert_eq!(renamed("loops/1.2.mp4").as_deref(), Some("loops/ram.mp4"));
        assert_eq!(renamed("1.2=1.2.mp4").as_deref(), Some("ram=ram.mp4"));
        assert_eq!(renamed("a/b/x=1.2.mp4").as_deref(), Some("a/b/x=ram.mp4"));
        for other in ["loops/1.2", "loops/1.2.3.mp4", "1.2/x.mp4", "loops/a1.2.mp4", "a=b=1.2.mp4"] {
            assert_eq!(renamed(other), None, "{other}");
        }
        assert_eq!(of_transition(&id("a"), &id("b"), CLIP).as_str(), "transitions/a=b.mp4");
    }
}
