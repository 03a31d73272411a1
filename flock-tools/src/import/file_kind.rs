//! What a file's name says of it.
//!
//! Owns the names of Electric Sheep's content folders, and ours. Never opens a file.

use std::path::Path;

use flock::SheepId;

use crate::render::plan::Shows;

/// What the names of videos end in.
const VIDEOS: &[&str] = &[
    "3gp", "asf", "avi", "dv", "flv", "gif", "m4v", "mkv", "mov", "mp4", "mpeg", "mpg", "mts", "mxf", "nut", "ogv",
    "ts", "webm", "wmv", "y4m",
];
/// What the names of genomes end in.
const GENOMES: &[&str] = &["flam3", "flame"];
/// What takes the place of a clip that was voted down or deleted.
const TOMBSTONE: &str = "xxx";
/// A clip that is still being fetched.
const PARTIAL: &str = "tmp";

/// What a name says.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Named {
    /// A video of this.
    Clip(Shows),
    /// flam3 genomes.
    Genomes,
    /// A video, but nobody knows of what; why.
    Odd(String),
    /// Nothing that is imported.
    Other,
    /// A clip that is no longer there.
    Tombstone,
}

/// What the name of `path` says.
pub(super) fn named(path: &Path) -> Named {
    let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
        return Named::Odd("its name is not UTF-8".to_owned());
    };
    let (stem, ending) = name.rsplit_once('.').filter(|(stem, _)| !stem.is_empty()).unwrap_or((name, ""));
    match ending.to_ascii_lowercase().as_str() {
        TOMBSTONE => Named::Tombstone,
        PARTIAL if stem.contains('=') => Named::Odd("it was not fetched to its end".to_owned()),
        ending if GENOMES.contains(&ending) => Named::Genomes,
        ending if VIDEOS.contains(&ending) => of_video(stem),
        _ => Named::Other,
    }
}

/// What is shown between the sheep `from` and `to`.
pub(super) fn shows(from: SheepId, to: SheepId) -> Shows {
    if from == to { Shows::Loop(from) } else { Shows::Transition(from, to) }
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

fn of_video(stem: &str) -> Named {
    let odd = |wanted: &str| Named::Odd(format!("its name is `{stem}` (expected {wanted})"));
    match stem.split('=').collect::<Vec<_>>()[..] {
        [generation, id, first, last] => {
            let ends = sheep(generation, first).zip(sheep(generation, last));
            ends.filter(|_| sheep(generation, id).is_some()).map_or_else(
                || odd("four numbers: GENERATION=ID=FIRST=LAST"),
                |(from, to)| Named::Clip(shows(from, to)),
            )
        }
        [from, to] => match (SheepId::new(from), SheepId::new(to)) {
            (Ok(from), Ok(to)) => Named::Clip(shows(from, to)),
            (Err(_), _) | (_, Err(_)) => odd("two ids of sheep: FROM=TO"),
        },
        _ => odd("GENERATION=ID=FIRST=LAST or FROM=TO, or to be told --from and --to"),
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
        let named = |name: &str| named(Path::new(name));
        assert_eq!(named("mpeg/00202=67501=67501=67501.avi"), Named::Clip(Shows::Loop(id("202.67501"))));
        assert_eq!(named("202=9=67501=00033.AVI"), Named::Clip(Shows::Transition(id("202.67501"), id("202.33"))));
        assert_eq!(named("10247=0=00000=0.mp4"), Named::Clip(Shows::Loop(id("10247.0"))));
        assert_eq!(named("ram=ewe.mkv"), Named::Clip(Shows::Transition(id("ram"), id("ewe"))));
        assert_eq!(named("00202=67501=67501=67501.xxx"), Named::Tombstone);
        assert_eq!([named("a.flam3"), named("b.FLAME")], [Named::Genomes, Named::Genomes]);
        for other in ["list.xml", "frost.jpg", "readme", ".avi", "notes.txt", "x.tmp"] {
            assert_eq!(named(other), Named::Other, "{other}");
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
            assert!(matches!(named(Path::new(odd)), Named::Odd(_)), "{odd}");
        }
    }
}
