//! The sheep beside the flock, and what the document asks of them.
//!
//! Owns where the genome of a candidate lies, and how it comes into the flock's folder. Never edits the manifest: the document
//! does.
//!
//! Start at [`Stock::candidate_path`]; the document asks by [`Around`].

use std::collections::{BTreeSet, HashMap};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use flock::{Clip, ClipHash, Manifest, Sheep, SheepId};
use operations::check::clips;
use operations::credits::{CreditsFile, Subject};
use operations::decoder::Decoder;
use operations::flock_folder::paths;
use operations::species::{self, reasons};
use timing::FrameCount;
use video::Form;

use super::candidates::Candidates;
use super::genomes::Genomes;
use crate::breeding::broods::Broods;
use crate::document::{EditRequest, MarkKind, Surroundings};
use crate::lock::locked;

/// What is known of genomes, in the flock and beside it.
pub(crate) struct Stock {
    /// The flock's folder.
    pub(crate) folder: PathBuf,
    pub(crate) decoder: &'static dyn Decoder,
    pub(crate) genomes: Genomes,
    pub(crate) candidates: Candidates,
    pub(crate) broods: Mutex<Broods>,
}

/// What the document asks.
pub(crate) struct Around(pub(crate) Arc<Stock>);

impl Stock {
    /// The genome of a sheep that is not in the flock: of its pool, an archive or a brood.
    pub(crate) fn candidate_path(&self, id: &str) -> Option<PathBuf> {
        let of_brood = locked(&self.broods).find_genome(id);
        let all = self.candidates.all(&self.genomes);
        let found = || all.iter().find(|own| own.id.as_str() == id).map(|own| own.path.clone());
        of_brood.or_else(found).filter(|path| path.is_file())
    }

    /// The genomes of all candidates, and of the dead of the pool.
    pub(crate) fn paths(&self) -> HashMap<String, PathBuf> {
        let candidates = self.candidates.all(&self.genomes);
        let own = candidates.iter().map(|own| (own.id.as_str().to_owned(), own.path.clone()));
        let mut all: HashMap<String, PathBuf> = own.collect();
        if let Some(folder) = self.candidates.folder().ok().flatten() {
            all.extend(folder.pool().sheep().map(|sheep| (sheep.born.id.to_string(), folder.genome(&sheep.born))));
        }
        all
    }

    fn genome(&self, id: &SheepId) -> Result<PathBuf, String> {
        self.candidate_path(id.as_str()).ok_or_else(|| format!("there is no candidate `{id}`"))
    }
}

impl Surroundings for Around {
    fn candidate(&self, id: &SheepId, manifest: &Manifest) -> Result<Sheep, String> {
        let path = self.0.genome(id)?;
        let facts = self.0.genomes.facts(&path);
        let ending = facts.species.ok_or_else(|| format!("`{id}` has no genome"))?;
        if let Some(why) = &facts.unusable {
            return Err(format!("the genome of `{id}` is unusable: {why}"));
        }
        let refused = &facts.undrawn.refused;
        if !refused.is_empty() {
            return Err(format!("`{id}` cannot be drawn: {}", reasons::refusal(refused)));
        }
        let clip = Clip { path: paths::of_loop(id, paths::CLIP), frames: usual_loop(manifest), hash: None };
        let clip = self.clip(clip, manifest)?;
        let genome = Some(paths::genome(id, ending));
        Ok(Sheep { id: id.clone(), clip: Some(clip), genome, want: 1.0, repeat: 1 })
    }

    fn place(&self, sheep: &Sheep) -> Result<(), String> {
        let Some(genome) = &sheep.genome else { return Ok(()) };
        let (from, to) = (self.0.genome(&sheep.id)?, genome.inside(&self.0.folder));
        let text = species::text(&from).map_err(|why| format!("cannot read `{}`: {}", from.display(), why.source))?;
        if to.exists() {
            let same = species::text(&to).is_ok_and(|there| there == text);
            return if same { Ok(()) } else { Err(format!("`{genome}` is another file already")) };
        }
        let parent = to.parent().unwrap_or(Path::new("."));
        let placed = fs::create_dir_all(parent).and_then(|()| durable::write(&to, text.as_bytes()));
        placed.map_err(|error| format!("cannot write `{genome}`: {error}"))
    }

    fn clip(&self, clip: Clip, manifest: &Manifest) -> Result<Clip, String> {
        let file = clip.path.inside(&self.0.folder);
        if !file.exists() {
            return Ok(clip);
        }
        let form = Form { size: manifest.size, fps: manifest.fps };
        let frames = clips::frames(&file, &form, self.0.decoder);
        let frames: FrameCount = frames.map_err(|why| format!("clip `{}` is there and {why}", clip.path))?;
        let hash = File::open(&file).and_then(ClipHash::of);
        let hash = hash.map_err(|error| format!("cannot read `{}`: {error}", clip.path))?;
        Ok(Clip { frames, hash: Some(hash), ..clip })
    }

    fn credits(
        &self,
        text: &str,
        edits: &[EditRequest],
        before: &Manifest,
        after: &Manifest,
    ) -> Result<String, String> {
        let mut file = CreditsFile::of_text(text).map_err(|fatal| fatal.in_words())?;
        let credited: BTreeSet<Subject> = file.named_in(before);
        for edit in edits {
            if let EditRequest::Rename { sheep, to } = edit {
                file.rename(sheep, to).map_err(|fatal| fatal.in_words())?;
                file = CreditsFile::of_text(file.text()).map_err(|fatal| fatal.in_words())?;
            }
        }
        let stays = file.named_in(after);
        file.remove(&credited.difference(&stays).cloned().collect()).map_err(|fatal| fatal.in_words())?;
        Ok(file.text().to_owned())
    }

    fn mark(&self, id: &SheepId) -> Option<MarkKind> {
        self.0.candidates.marks(&self.0.genomes).get(id).copied()
    }

    fn set_marks(&self, marks: &[(SheepId, MarkKind)]) -> Result<(), String> {
        self.0.candidates.set_marks(marks).map_err(|fatal| fatal.in_words())
    }
}

/// Frames of a loop that is yet to be rendered: as those of the flock have in the middle.
fn usual_loop(manifest: &Manifest) -> FrameCount {
    let loops = manifest.sheep.iter().filter_map(|sheep| sheep.clip.as_ref());
    let mut frames: Vec<FrameCount> = loops.map(|clip| clip.frames).collect();
    frames.sort_unstable();
    frames.get(frames.len() / 2).copied().unwrap_or(FrameCount(flock::paths::LOOP_FRAMES))
}

#[cfg(test)]
mod tests {
    use super::*;
    use operations::decoder::ffmpeg::Ffmpeg;

    fn stock(folder: &Path, archive: &Path) -> Around {
        let candidates = Candidates::new(folder.join("pool"), Some(archive.to_owned()));
        let (genomes, broods) = (Genomes::default(), Mutex::new(Broods::open(&folder.join(".studio"))));
        Around(Arc::new(Stock { folder: folder.to_owned(), decoder: &Ffmpeg, genomes, candidates, broods }))
    }

    #[test]
    fn a_candidate_comes_in_with_its_genome_and_never_over_another_file() {
        let scratch = tempfile::tempdir().unwrap();
        let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../demo");
        let manifest = Manifest::read(&demo.join("small")).unwrap();
        let around = stock(scratch.path(), &demo.join("genomes"));
        let id = SheepId::new("orchid").unwrap();
        let sheep = around.candidate(&id, &manifest).unwrap();
        let clip = sheep.clip.clone().unwrap();
        assert_eq!((clip.path.as_str(), clip.frames), ("loops/orchid.mp4", usual_loop(&manifest)));
        assert!(!scratch.path().join("genomes").exists(), "a what-if writes nothing");
        around.place(&sheep).unwrap();
        around.place(&sheep).unwrap();
        let there = fs::read(scratch.path().join("genomes/orchid.flam3")).unwrap();
        assert_eq!(there, fs::read(demo.join("genomes/orchid.flam3")).unwrap());
        fs::write(scratch.path().join("genomes/orchid.flam3"), "mine").unwrap();
        assert!(around.place(&sheep).unwrap_err().contains("another file"));
        assert!(around.candidate(&SheepId::new("nobody").unwrap(), &manifest).is_err());
    }

    #[test]
    fn credits_follow_a_renamed_sheep_and_go_with_one_that_is_dropped() {
        let head = "format = 1\nname = \"x\"\nsize = [64, 64]\nfps = [30, 1]\n";
        let manifest = |ids: &[&str]| {
            let sheep: Vec<String> = ids.iter().map(|id| format!("[[sheep]]\nid = \"{id}\"\n")).collect();
            Manifest::parse(&format!("{head}{}", sheep.concat()), Path::new("flock.toml")).unwrap()
        };
        let text = "# mine\n[[sheep]]\nid = \"a\"\nauthors = [\"Ada\"]\n\n[[sheep]]\nid = \"b\"\nauthors = [\"Bo\"]\n";
        let scratch = tempfile::tempdir().unwrap();
        let around = stock(scratch.path(), scratch.path());
        let id = |text| SheepId::new(text).unwrap();
        let renamed = [EditRequest::Rename { sheep: id("a"), to: id("c") }];
        let after = around.credits(text, &renamed, &manifest(&["a", "b"]), &manifest(&["c", "b"])).unwrap();
        assert_eq!(after, text.replacen("\"a\"", "\"c\"", 1));
        let dropped = [EditRequest::Drop { sheep: id("b") }];
        let after = around.credits(text, &dropped, &manifest(&["a", "b"]), &manifest(&["a"])).unwrap();
        assert!(after.starts_with("# mine\n[[sheep]]\nid = \"a\"") && !after.contains("Bo"), "{after}");
    }
}
