//! The kind of a file, by its name.
//!
//! Owns the names in Electric Sheep's content folders, and ours. Never opens a file.

use std::path::Path;

use flock::SheepId;

use crate::render::plan::ClipRole;

/// Endings of videos.
const VIDEOS: &[&str] = &[
    "3gp", "asf", "avi", "dv", "flv", "gif", "m4v", "mkv", "mov", "mp4", "mpeg", "mpg", "mts", "mxf", "nut", "ogv",
    "ts", "webm", "wmv", "y4m",
];
/// Endings of genomes.
const GENOMES: &[&str] = &["flam3", "flame"];
/// The ending in place of a clip that was voted down or deleted.
const TOMBSTONE: &str = "xxx";
/// The ending of a clip that is still being fetched.
const PARTIAL: &str = "tmp";

/// A kind of file.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum FileKind {
    /// A video of this loop or transition.
    Clip(ClipRole),
    /// flam3 genomes.
    Genomes,
    /// A video whose name does not say what it shows; why.
    Unclear(String),
    /// A file that is not imported.
    Other,
    /// A clip that was deleted; its name is left.
    Tombstone,
}

/// The kind of the file at `path`.
pub(super) fn file_kind(path: &Path) -> FileKind {
    let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
        return FileKind::Unclear("its name is not UTF-8".to_owned());
    };
    let (stem, ending) = name.rsplit_once('.').filter(|(stem, _)| !stem.is_empty()).unwrap_or((name, ""));
    match ending.to_ascii_lowercase().as_str() {
        TOMBSTONE => FileKind::Tombstone,
        PARTIAL if stem.contains('=') => FileKind::Unclear("it was not fetched to its end".to_owned()),
        ending if GENOMES.contains(&ending) => FileKind::Genomes,
        ending if VIDEOS.contains(&ending) => of_video(stem),
        _ => FileKind::Other,
    }
}

/// The clip from the sheep `from` to the sheep `to`.
pub(super) fn role(from: SheepId, to: SheepId) -> ClipRole {
    if from == to { ClipRole::Loop(from) } else { ClipRole::Transition(from, to) }
}

/// The id of the sheep that Electric Sheep calls `number` of `generation`: both are written with any number of zeros
/// before them.
pub(super) fn sheep(generation: &str, number: &str) -> Option<SheepId> {
    let plain = |digits: &str| {
        let is_number = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
        let short = digits.trim_start_matches('0');
        is_number.then(|| if short.is_empty() { "0" } else { short }.to_owned())
    };
    SheepId::new(&format!("{}.{}", plain(generation)?, plain(number)?)).ok()
}

fn of_video(stem: &str) -> FileKind {
    let unclear = |wanted: &str| FileKind::Unclear(format!("its name is `{stem}` (expected {wanted})"));
    match stem.split('=').collect::<Vec<_>>()[..] {
        [generation, id, first, last] => {
            let ends = sheep(generation, first).zip(sheep(generation, last));
            ends.filter(|_| sheep(generation, id).is_some()).map_or_else(
                || unclear("four numbers: GENERATION=ID=FIRST=LAST"),
                |(from, to)| FileKind::Clip(role(from, to)),
            )
        }
        [from, to] => match (SheepId::new(from), SheepId::new(to)) {
            (Ok(from), Ok(to)) => FileKind::Clip(role(from, to)),
            (Err(_), _) | (_, Err(_)) => unclear("two ids of sheep: FROM=TO"),
        },
        _ => unclear("GENERATION=ID=FIRST=LAST or FROM=TO, or the options --from and --to"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn id(text: &str) -> SheepId {
        SheepId::new(text).unwrap()
    }

    #[test]
    fn a_sheep_is_known_by_generation_and_number_whatever_zeros_stand_before_them() {
        let kind = |name: &str| file_kind(Path::new(name));
        assert_eq!(kind("mpeg/00202=67501=67501=67501.avi"), FileKind::Clip(ClipRole::Loop(id("202.67501"))));
        assert_eq!(kind("202=9=67501=00033.AVI"), FileKind::Clip(ClipRole::Transition(id("202.67501"), id("202.33"))));
        assert_eq!(kind("10247=0=00000=0.mp4"), FileKind::Clip(ClipRole::Loop(id("10247.0"))));
        assert_eq!(kind("ram=ewe.mkv"), FileKind::Clip(ClipRole::Transition(id("ram"), id("ewe"))));
        assert_eq!(kind("00202=67501=67501=67501.xxx"), FileKind::Tombstone);
        assert_eq!([kind("a.flam3"), kind("b.FLAME")], [FileKind::Genomes, FileKind::Genomes]);
        for other in ["list.xml", "frost.jpg", "readme", ".avi", "notes.txt", "x.tmp"] {
            assert_eq!(kind(other), FileKind::Other, "{other}");
        }
    }

    #[test]
    fn odd_names_are_not_guessed() {
        for odd in [
            "00202=67501=67501.avi",
            "00202=67501=67501=67501=1.avi",
            "00202=-1=67501=67501.avi",
            "00202=67501=67501=67501 (copy).avi",
            "202=1==3.avi",
            "a=b=c=d.avi",
            "ram=e we.avi",
            "=.mp4",
            "holiday.mp4",
            "00202=67501=67501=67501.avi.tmp",
        ] {
            assert!(matches!(file_kind(Path::new(odd)), FileKind::Unclear(_)), "{odd}");
        }
    }
}
