//! The import of flam3 genomes as sheep.
//!
//! Owns the id of a flame, and its file: a copy of its text, so that names, nicknames, licences and genealogy stay. Never
//! renders.
//!
//! Start at [`import`].

use std::fs;
use std::path::{Path, PathBuf};

use flame::Genome;
use flock::{Clip, ClipPath, Sheep, SheepId};
use timing::FrameCount;

use super::SkippedFile;
use super::file_kind::sheep;
use crate::flock_folder::Draft;
use crate::flock_folder::paths;
use crate::program::{Exit, Fatal, chain};

/// The beginning of Electric Sheep's names.
const ELECTRIC: &str = "electricsheep.";

/// A flame in the answer.
#[derive(Clone, Debug, serde::Serialize)]
pub(super) struct GenomeAnswer {
    pub(super) source: PathBuf,
    pub(super) sheep: SheepId,
    pub(super) genome: ClipPath,
    /// `added`: as a new sheep; `given`: to a sheep without a genome; `stood`: the sheep had it already.
    pub(super) state: &'static str,
}

/// Imports every flame of the file `source` into the flock in `folder`: as the genome of the sheep with its name, or as a
/// new sheep, whose loop of `frames` is yet to be rendered. With `dry` nothing is written.
/// Errors: Those that concern every other file, too.
pub(super) fn import(
    source: &Path,
    folder: &Path,
    frames: FrameCount,
    dry: bool,
) -> Result<(Vec<GenomeAnswer>, Vec<SkippedFile>), Fatal> {
    let skipped = |reason: String| SkippedFile { source: source.to_owned(), reason };
    let text = match fs::read_to_string(source) {
        Ok(text) => text,
        Err(error) => return Ok((Vec::new(), vec![skipped(format!("cannot be read: {error}"))])),
    };
    let flames = match Genome::split(&text) {
        Ok(flames) if flames.is_empty() => return Ok((Vec::new(), vec![skipped("has no flame".to_owned())])),
        Ok(flames) => flames,
        Err(error) => return Ok((Vec::new(), vec![skipped(format!("is not readable: {}", chain(&error)))])),
    };
    let (mut imported, mut refused) = (Vec::new(), Vec::new());
    let mut draft = Draft::lock(folder)?;
    for (at, (genome, text)) in flames.iter().enumerate() {
        let number = (flames.len() > 1).then_some(at + 1);
        let Some(id) = id(genome.name.as_deref(), source, number) else {
            refused.push(skipped(format!("flame {} has no name that a sheep can have", at + 1)));
            continue;
        };
        let path = paths::genome(&id, paths::GENOME);
        let answer = |state| GenomeAnswer { source: source.to_owned(), sheep: id.clone(), genome: path.clone(), state };
        let there = draft.edit.manifest().sheep.iter().find(|sheep| sheep.id == id);
        let own = there.and_then(|sheep| sheep.genome.as_ref()).map(|genome| genome.inside(folder));
        let place = own.clone().unwrap_or_else(|| path.inside(folder));
        let text = format!("{text}\n");
        let same = fs::read_to_string(&place).is_ok_and(|found| found.trim_end() == text.trim_end());
        if own.is_some() && same {
            imported.push(answer("stood"));
            continue;
        }
        if own.is_some() || (place.exists() && !same) {
            refused.push(skipped(format!(
                "flame {} is not the genome that `{id}` has in `{}`",
                at + 1,
                place.display()
            )));
            continue;
        }
        let state = if there.is_some() { "given" } else { "added" };
        if !dry {
            write(&place, &text)?;
        }
        let edited = if there.is_some() {
            draft.edit.set_genome(&id, path.clone())
        } else {
            let clip = Clip { path: paths::of_loop(&id, paths::CLIP), frames, hash: None };
            let sheep = Sheep { id: id.clone(), clip: Some(clip), genome: Some(path.clone()), want: 1.0, repeat: 1 };
            draft.edit.add_sheep(sheep)
        };
        edited.map_err(|error| Fatal::new(Exit::Malformed, error))?;
        imported.push(answer(state));
    }
    if !dry {
        draft.save()?;
    }
    Ok((imported, refused))
}

fn write(path: &Path, text: &str) -> Result<(), Fatal> {
    let parent = path.parent().unwrap_or(Path::new("."));
    let written = fs::create_dir_all(parent).and_then(|()| durable::save(path, text.as_bytes()));
    written.map_err(|source| Fatal::write(path, source))
}

/// The id of a flame: its name, in the letters that an id may have; without one, the file's, and the flame's number
/// where the file has several. Electric Sheep's names are those of its clips.
fn id(name: Option<&str>, file: &Path, number: Option<usize>) -> Option<SheepId> {
    let stem = || file.file_stem().and_then(|stem| stem.to_str());
    let numbered = |stem: &str| number.map_or(stem.to_owned(), |number| format!("{stem}.{number}"));
    let name = name.map(str::trim).filter(|name| !name.is_empty()).map(str::to_owned);
    let name = name.or_else(|| stem().map(numbered))?;
    if let Some((generation, number)) = name.strip_prefix(ELECTRIC).and_then(|rest| rest.split_once('.'))
        && let Some(id) = sheep(generation, number)
    {
        return Some(id);
    }
    let plain = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '-' };
    SheepId::new(&name.chars().map(plain).collect::<String>()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flame_is_called_by_its_name_or_else_by_its_file() {
        let id = |name, file, number| id(name, Path::new(file), number).map(|id| id.as_str().to_owned());
        assert_eq!(id(Some("electricsheep.247.00505"), "x.flam3", None).as_deref(), Some("247.505"));
        assert_eq!(id(None, "a/electricsheep.247.00505.flam3", None).as_deref(), Some("247.505"));
        assert_eq!(id(Some("Blue Dream #3"), "x.flam3", Some(3)).as_deref(), Some("Blue-Dream--3"));
        assert_eq!(id(Some(" "), "dir/best.flame", None).as_deref(), Some("best"));
        assert_eq!(id(None, "best.flame", Some(2)).as_deref(), Some("best.2"));
        assert_eq!(id(Some("electricsheep.x.y"), "best.flame", None).as_deref(), Some("electricsheep.x.y"));
        assert_eq!(id(Some(&"n".repeat(65)), "best.flame", None), None);
    }
}
