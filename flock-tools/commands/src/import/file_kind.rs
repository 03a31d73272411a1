//! The kind of a file, by its name.
//!
//! Owns the names in Electric Sheep's content folders, and ours. Never opens a file.

use std::ffi::OsStr;
use std::path::Path;

use flock::SheepId;
use operations::program::print;
use operations::render::plan::ClipRole;
use operations::species;

use crate::import::electric::ElectricName;

/// Endings of videos.
const VIDEOS: &[&str] = &[
    "264", "265", "3g2", "3gp", "apng", "asf", "avc", "avi", "divx", "dv", "f4v", "flv", "gif", "h264", "h265", "hevc",
    "ivf", "m1v", "m2t", "m2ts", "m2v", "m4v", "mj2", "mjpeg", "mjpg", "mkv", "mov", "mp4", "mpe", "mpeg", "mpg",
    "mpv", "mts", "mxf", "nut", "obu", "ogm", "ogv", "ogx", "qt", "rm", "rmvb", "swf", "ts", "vob", "webm", "wmv",
    "xvid", "y4m",
];
/// An ending of flames besides that of the species.
const FLAME: &str = "flame";
/// The ending of `JWildfire`'s movies, in which flames lie.
const MOVIE: &str = "jwfmovie";
/// The ending of Chaotica's files.
const CHAOS: &str = "chaos";
/// Why a file of Chaotica is left out.
pub(super) const CHAOTICA: &str =
    "is a file of Chaotica, a format that is not read (expected flam3 XML); import the `.flame` file of the same flame";
/// The ending in place of a clip that was voted down or deleted.
const TOMBSTONE: &str = "xxx";
/// Endings of clips that are still being fetched.
const PARTIAL: &[&str] = &["aria2", "crdownload", "download", "filepart", "part", "partial", "tmp"];
/// Endings of pictures and texts about a clip.
const BESIDE: &[&str] = &[
    "db", "htm", "html", "ini", "jpeg", "jpg", "json", "log", "md5", "nfo", "png", "sha1", "srt", "torrent", "txt",
    "url", "xml",
];

/// A kind of file.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum FileKind {
    /// A video of this loop or transition.
    Clip(ClipRole, Origin),
    /// Genomes.
    Genomes,
    /// A video whose name does not say what it shows; why.
    Unclear(String),
    /// A file that is not imported.
    Other,
    /// A clip that was deleted; its name is left.
    Tombstone,
}

/// Who made a clip, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// The renderers of Electric Sheep.
    ElectricSheep,
    /// Not known.
    Unknown,
}

/// The kind of the file at `path`.
pub(super) fn file_kind(path: &Path) -> FileKind {
    // No name of a clip has other letters: what is lost here makes it unclear.
    let name = path.file_name().map(OsStr::to_string_lossy).unwrap_or_default();
    let (stem, ending) = name.rsplit_once('.').filter(|(stem, _)| !stem.is_empty()).unwrap_or((&name, ""));
    let ending = &*ending.to_ascii_lowercase();
    let unclear = |why: String| FileKind::Unclear(why);
    if ending == TOMBSTONE {
        FileKind::Tombstone
    } else if PARTIAL.contains(&ending) && stem.contains('=') {
        unclear("it was not fetched to its end".to_owned())
    } else if ending == CHAOS {
        unclear(CHAOTICA.to_owned())
    } else if [FLAME, MOVIE].contains(&ending) || species::endings().contains(&ending) {
        FileKind::Genomes
    } else if VIDEOS.contains(&ending) {
        let told = path.file_stem().map(|stem| print::path(Path::new(stem))).unwrap_or_default();
        of_video(stem).unwrap_or_else(|wanted| unclear(format!("its name is `{told}` (expected {wanted})")))
    } else if !BESIDE.contains(&ending) && matches!(of_video(stem), Ok(FileKind::Clip(_, Origin::ElectricSheep))) {
        unclear(format!("its ending is `{ending}` (expected that of a video)"))
    } else {
        FileKind::Other
    }
}

/// Who made the clip at `path`, by its name.
pub(super) fn origin(path: &Path) -> Origin {
    match file_kind(path) {
        FileKind::Clip(_, origin) => origin,
        FileKind::Genomes | FileKind::Unclear(_) | FileKind::Other | FileKind::Tombstone => Origin::Unknown,
    }
}

/// The clip from the sheep `from` to the sheep `to`.
pub(super) fn role(from: SheepId, to: SheepId) -> ClipRole {
    if from == to { ClipRole::Loop(from) } else { ClipRole::Transition(from, to) }
}

/// The clip of a video by its name without the ending; or which name was expected.
fn of_video(stem: &str) -> Result<FileKind, &'static str> {
    match stem.split('=').collect::<Vec<_>>()[..] {
        [_, _, _, _] => {
            let ends = ElectricName::of_file(stem).and_then(|name| name.ends());
            let (from, to) = ends.ok_or("four numbers: GENERATION=ID=FIRST=LAST")?;
            Ok(FileKind::Clip(role(from, to), Origin::ElectricSheep))
        }
        [from, to] => match (SheepId::new(from), SheepId::new(to)) {
            (Ok(from), Ok(to)) => Ok(FileKind::Clip(role(from, to), Origin::Unknown)),
            (Err(_), _) | (_, Err(_)) => Err("two ids of sheep: FROM=TO"),
        },
        _ => Err("GENERATION=ID=FIRST=LAST or FROM=TO, or the options --from and --to"),
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
        let electric = |role| FileKind::Clip(role, Origin::ElectricSheep);
        assert_eq!(kind("mpeg/00202=67501=67501=67501.avi"), electric(ClipRole::Loop(id("202.67501"))));
        assert_eq!(kind("202=9=67501=00033.AVI"), electric(ClipRole::Transition(id("202.67501"), id("202.33"))));
        assert_eq!(kind("10247=0=00000=0.m2v"), electric(ClipRole::Loop(id("10247.0"))));
        let ram = ClipRole::Transition(id("ram"), id("ewe"));
        assert_eq!(kind("ram=ewe.mkv"), FileKind::Clip(ram, Origin::Unknown));
        assert_eq!(kind("00202=67501=67501=67501.xxx"), FileKind::Tombstone);
        for genomes in ["a.flam3", "b.FLAME", "c.expr", "d.jwfmovie"] {
            assert_eq!(kind(genomes), FileKind::Genomes, "{genomes}");
        }
        for other in ["list.xml", "frost.jpg", "readme", ".avi", "notes.txt", "x.tmp", "202=1=1=1.jpg", "a=b.bak"] {
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
            "00202=67501=67501=67501",
            "00202=67501=67501=67501.old",
            "._00202=67501=67501=67501.avi",
            "works.chaos",
        ] {
            assert!(matches!(file_kind(Path::new(odd)), FileKind::Unclear(_)), "{odd}");
        }
    }
}
