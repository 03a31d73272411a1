//! The import of genomes: each as a sheep, and files of Electric Sheep with two flames as transitions.
//!
//! Owns the file of a genome: a copy of its text, so that names, nicknames, licences and genealogy stay; and the
//! order: sheep before transitions, so that a sheep's own file is taken before the copy of it in a transition's. Never
//! renders. `genome_file.rs` reads the files and tells which kind they are.
//!
//! Start at [`import`].

use std::collections::{HashMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};

use flame::genome::{Origin, Reasons};
use flock::Draft;
use flock::{Clip, ClipPath, Sheep, SheepId, Transition};
use operations::credits::{Said, Subject};
use operations::flock_folder::paths;
use operations::program::{Exit, Fatal, print, reasons};
use operations::species;
use timing::FrameCount;

use super::SkippedFile;
use super::genome_file::{GenomeFile, GenomeKey, LeftOut, NamedGenome, Reading};
use super::names;
use super::names::Spellings;
use crate::import::electric::{ATTRIBUTION, ElectricName};

/// After so many sheep and transitions the manifest is saved, so that an interruption costs little.
const SAVED_AFTER: usize = 1000;

/// The number of the second genome of a name.
const FIRST: usize = 2;

/// A genome in the answer.
#[derive(Clone, Debug, serde::Serialize)]
pub(super) struct GenomeAnswer {
    #[serde(serialize_with = "print::serialize_path")]
    pub(super) source: PathBuf,
    pub(super) sheep: SheepId,
    pub(super) genome: ClipPath,
    /// `added`: as a new sheep; `given`: to a sheep without a genome; `replaced`: in place of another one; `stood`: the
    /// sheep had it already.
    pub(super) state: &'static str,
    /// What of it was read otherwise than it is written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) notes: Vec<String>,
    /// What it is drawn without.
    #[serde(skip_serializing_if = "Reasons::is_empty", serialize_with = "reasons::serialize")]
    pub(super) without: Reasons,
}

/// A transition in the answer.
#[derive(Clone, Debug, serde::Serialize)]
pub(super) struct TransitionAnswer {
    #[serde(serialize_with = "print::serialize_path")]
    pub(super) source: PathBuf,
    pub(super) from: SheepId,
    pub(super) to: SheepId,
    pub(super) clip: ClipPath,
    /// `added`, or `stood`: the flock had it already.
    pub(super) state: &'static str,
}

/// What became of all files with genomes.
#[derive(Debug, Default)]
pub(super) struct GenomesAnswer {
    pub(super) genomes: Vec<GenomeAnswer>,
    pub(super) transitions: Vec<TransitionAnswer>,
    pub(super) left_out: Vec<SkippedFile>,
    /// Files with the key frames of one animation, of which sheep were made.
    pub(super) key_frames: usize,
    /// What the names and the flames tell of authors and licences.
    pub(super) notes: Vec<(Subject, Said)>,
}

/// What the command line says of genomes.
#[derive(Clone, Copy, Debug)]
pub(super) struct GenomeChoices {
    /// Of the loops and transitions that are yet to be rendered.
    pub(super) frames: FrameCount,
    /// How files are read.
    pub(super) reading: Reading,
    /// Whether other genomes of sheep are replaced, but for those that were imported by the same run.
    pub(super) force: bool,
    /// Whether nothing is written.
    pub(super) dry: bool,
}

/// Imports every genome of the files `sources` into the flock in `folder`: as the genome of the sheep with its name, or as a
/// new sheep; and the transitions that some of them are. A genome whose name another one has gets a number. `answer` is
/// complete even if it fails. Ids that differ only in capitals count as one name: on many disks their files would be one.
/// Errors: Those that concern every other file, too.
pub(super) fn import(
    sources: &[PathBuf],
    folder: &Path,
    choices: GenomeChoices,
    answer: &mut GenomesAnswer,
) -> Result<(), Fatal> {
    if sources.is_empty() {
        return Ok(());
    }
    let mut import = GenomeImport::start(folder, choices, answer)?;
    let mut transitions = Vec::new();
    for source in sources {
        match GenomeFile::read(source, choices.reading) {
            Ok(file) if file.is_transition => transitions.push(source),
            Ok(file) => import.genomes(&file)?,
            Err(why) => import.skip(source, why),
        }
    }
    // Read again: of all these files only the names are kept meanwhile.
    for source in transitions {
        match GenomeFile::read(source, choices.reading) {
            Ok(file) => import.transition(&file)?,
            Err(why) => import.skip(source, why),
        }
    }
    import.save()
}

/// An import of genomes that is under way.
struct GenomeImport<'a> {
    folder: &'a Path,
    choices: GenomeChoices,
    draft: Draft,
    /// The sheep of the flock, with their genomes.
    sheep: HashMap<SheepId, Option<ClipPath>>,
    spellings: Spellings,
    transitions: HashSet<(SheepId, SheepId)>,
    /// The sheep by what their genomes draw: those of the flock once a flame has no name.
    by_genome: HashMap<GenomeKey, SheepId>,
    is_indexed: bool,
    /// The sheep whose genomes this run has imported, which are not replaced.
    imported: HashSet<SheepId>,
    numbers: Numbers,
    /// In a dry run, the genomes that it would have written.
    planned: HashMap<SheepId, Original>,
    /// Changes since the manifest was saved.
    unsaved: usize,
    answer: &'a mut GenomesAnswer,
}

/// The numbers of sheep with equal names.
#[derive(Default)]
struct Numbers {
    /// The next number to try, by name.
    next: HashMap<SheepId, usize>,
    /// The sheep that have a genome, by the name that it wants.
    known: HashMap<(SheepId, GenomeKey), SheepId>,
}

/// What the copies of a genome have in common with it.
struct Original {
    key: GenomeKey,
    author: Option<String>,
    licence: Option<String>,
}

/// What a flame became.
enum Outcome {
    Imported(&'static str, ClipPath),
    /// The sheep has another genome, in this file.
    Other(ClipPath),
}

impl<'a> GenomeImport<'a> {
    fn start(folder: &'a Path, choices: GenomeChoices, answer: &'a mut GenomesAnswer) -> Result<Self, Fatal> {
        let draft = Draft::lock(folder)?;
        let manifest = draft.edit.manifest();
        let sheep = manifest.sheep.iter().map(|sheep| (sheep.id.clone(), sheep.genome.clone())).collect();
        let spellings = manifest.sheep.iter().map(|sheep| sheep.id.clone()).collect();
        let transitions = manifest.transitions.iter().map(|t| (t.from.clone(), t.to.clone())).collect();
        Ok(Self {
            folder,
            choices,
            draft,
            sheep,
            spellings,
            transitions,
            by_genome: HashMap::new(),
            is_indexed: false,
            imported: HashSet::new(),
            numbers: Numbers::default(),
            planned: HashMap::new(),
            unsaved: 0,
            answer,
        })
    }

    fn skip(&mut self, source: &Path, why: LeftOut) {
        let LeftOut { reason, reasons } = why;
        self.answer.left_out.push(SkippedFile { reasons, ..SkippedFile::new(source, reason) });
    }

    /// Imports every genome of a file as a sheep.
    fn genomes(&mut self, file: &GenomeFile) -> Result<(), Fatal> {
        self.answer.key_frames += usize::from(file.is_animation);
        for why in &file.left_out {
            self.skip(&file.source, why.clone());
        }
        for flame in &file.genomes {
            let wanted = self.spellings.of(&flame.id);
            let outcome = if wanted == flame.id {
                self.flame(&wanted, flame, self.choices.force)?
            } else {
                // Another sheep, though not in every file system.
                Outcome::Other(self.place(&wanted, flame))
            };
            let (id, state, genome) = match outcome {
                Outcome::Imported(state, genome) => (wanted, state, genome),
                Outcome::Other(place) => self.numbered(flame, &wanted, &place)?,
            };
            self.tell(file, flame, id, state, genome);
        }
        self.save_some()
    }

    /// Makes a flame the genome of a sheep with its name and a number, as its name belongs to `other`, whose genome is in
    /// `place`: of the one that has this genome, or of a new one.
    fn numbered(
        &mut self,
        flame: &NamedGenome,
        other: &SheepId,
        place: &ClipPath,
    ) -> Result<(SheepId, &'static str, ClipPath), Fatal> {
        self.note_other(flame, other, place);
        if let Some(id) = self.numbers.known.get(&(flame.id.clone(), flame.key)).cloned()
            && let Outcome::Imported(state, genome) = self.flame(&id, flame, false)?
        {
            return Ok((id, state, genome));
        }
        loop {
            let next = self.numbers.next.entry(flame.id.clone()).or_insert(FIRST);
            let id = self.spellings.of(&names::numbered(&flame.id, *next));
            *next += 1;
            // A clip without a genome is of another sheep.
            if self.sheep.get(&id).is_some_and(Option::is_none) {
                continue;
            }
            match self.flame(&id, flame, false)? {
                Outcome::Imported(state, genome) => {
                    self.numbers.known.insert((flame.id.clone(), flame.key), id.clone());
                    return Ok((id, state, genome));
                }
                Outcome::Other(place) => self.note_other(flame, &id, &place),
            }
        }
    }

    /// Remembers which genome the sheep `id` has in `place`, as `flame` wanted its name.
    fn note_other(&mut self, flame: &NamedGenome, id: &SheepId, place: &ClipPath) {
        let planned = self.planned.get(id).map(|original| original.key);
        let place = place.inside(self.folder);
        let in_file = || Some(GenomeKey::of_file(&place, &species::text(&place).ok()?)?.0);
        if let Some(key) = planned.or_else(in_file) {
            self.numbers.known.entry((flame.id.clone(), key)).or_insert_with(|| id.clone());
        }
    }

    /// Imports a file of two flames as the transition between their sheep, which are added if the flock lacks them. Where
    /// the flock has another genome for one of them, that one counts: its loop was made from it.
    fn transition(&mut self, file: &GenomeFile) -> Result<(), Fatal> {
        let mut ids = Vec::new();
        for flame in &file.genomes {
            let known = if flame.is_certain { None } else { self.same(flame.key) };
            ids.push(known.unwrap_or_else(|| self.spellings.of(&flame.id)));
        }
        let [from, to] = &ids[..] else { return Ok(()) };
        if from == to {
            self.skip(&file.source, format!("both its flames are `{from}` (expected two sheep)").into());
            return Ok(());
        }
        for (flame, id) in file.genomes.iter().zip(&ids) {
            if let Outcome::Imported(state @ ("added" | "given"), genome) = self.flame(id, flame, false)? {
                self.tell(file, flame, id.clone(), state, genome);
            }
        }
        let (from, to) = (from.clone(), to.clone());
        let path = paths::of_transition(&from, &to, paths::CLIP);
        let is_new = self.transitions.insert((from.clone(), to.clone()));
        if is_new {
            let clip = Clip { path: path.clone(), frames: self.choices.frames, hash: None };
            let transition = Transition { from: from.clone(), to: to.clone(), clip, weight: 1.0 };
            let added = self.draft.edit.add_transition(transition);
            added.map_err(|error| Fatal::new(Exit::Malformed, error))?;
            self.unsaved += 1;
        }
        self.answer.notes.push((Subject::Transition(from.clone(), to.clone()), file.said()));
        let (source, state) = (file.source.clone(), if is_new { "added" } else { "stood" });
        self.answer.transitions.push(TransitionAnswer { source, from, to, clip: path, state });
        self.save_some()
    }

    /// Makes a flame the genome of the sheep `id`, if that has none or if it `replaces` another one.
    fn flame(&mut self, id: &SheepId, flame: &NamedGenome, replaces: bool) -> Result<Outcome, Fatal> {
        let there = self.sheep.get(id).cloned();
        let (is_known, own) = (there.is_some(), there.flatten());
        let path = self.place(id, flame);
        let place = path.inside(self.folder);
        let text = format!("{}\n", flame.text);
        let found = species::text(&place).ok();
        let is_written = found.as_ref().is_some_and(|found| found.trim_end() == text.trim_end());
        let replaces = replaces && !self.imported.contains(id);
        let is_copied = || match self.planned.get(id) {
            Some(original) => original.is_copied_by(&Original::of(flame.key, &flame.origin)),
            None => found.as_ref().is_some_and(|found| is_copy(flame, &place, found)),
        };
        let is_kept = is_written || (!replaces && is_copied());
        if !is_kept && !replaces && (own.is_some() || place.exists()) {
            return Ok(Outcome::Other(own.unwrap_or(path)));
        }
        if is_kept && own.as_ref() == Some(&path) {
            return Ok(Outcome::Imported("stood", path));
        }
        let state = match (is_known, &own) {
            (_, Some(_)) => "replaced",
            (true, None) => "given",
            (false, None) => "added",
        };
        if !self.choices.dry && !is_kept {
            write(&place, &text)?;
        }
        let edit = &mut self.draft.edit;
        let edited = if is_known {
            edit.set_genome(id, path.clone())
        } else {
            let clip = Clip { path: paths::of_loop(id, paths::CLIP), frames: self.choices.frames, hash: None };
            let sheep = Sheep { id: id.clone(), clip: Some(clip), genome: Some(path.clone()), want: 1.0, repeat: 1 };
            edit.add_sheep(sheep)
        };
        edited.map_err(|error| Fatal::new(Exit::Malformed, error))?;
        self.unsaved += 1;
        self.sheep.insert(id.clone(), Some(path.clone()));
        self.spellings.add(id);
        // In a dry run there will be no file in which it could be found.
        if self.is_indexed || self.choices.dry {
            self.by_genome.entry(flame.key).or_insert_with(|| id.clone());
        }
        if self.choices.dry {
            self.planned.insert(id.clone(), Original::of(flame.key, &flame.origin));
        }
        Ok(Outcome::Imported(state, path))
    }

    /// Where a flame is written as the genome of the sheep `id`.
    fn place(&self, id: &SheepId, flame: &NamedGenome) -> ClipPath {
        // A genome of another species gets a file with the ending of its own.
        let is_its_kind = |path: &ClipPath| !has_other_ending(path, flame.ending);
        let own = self.sheep.get(id).cloned().flatten();
        own.filter(is_its_kind).unwrap_or_else(|| paths::genome(id, flame.ending))
    }

    /// Adds a flame to the answer, with what is known of its origin.
    fn tell(&mut self, file: &GenomeFile, flame: &NamedGenome, id: SheepId, state: &'static str, genome: ClipPath) {
        let electric = flame.electric.as_ref().or(file.electric.as_ref());
        self.imported.insert(id.clone());
        self.answer.notes.push((Subject::Sheep(id.clone()), said_of(file, flame, electric)));
        let (source, notes, without) = (file.source.clone(), flame.notes.clone(), flame.without.clone());
        self.answer.genomes.push(GenomeAnswer { source, sheep: id, genome, state, notes, without });
    }

    /// The sheep of the flock that a genome with this `key` draws.
    fn same(&mut self, key: GenomeKey) -> Option<SheepId> {
        if !self.is_indexed {
            self.is_indexed = true;
            for (id, path) in self.sheep.iter().filter_map(|(id, path)| Some((id, path.as_ref()?))) {
                // What cannot be read is no genome that could be found.
                let place = path.inside(self.folder);
                let text = species::text(&place).ok();
                if let Some((key, _)) = text.and_then(|text| GenomeKey::of_file(&place, &text)) {
                    self.by_genome.entry(key).or_insert_with(|| id.clone());
                }
            }
        }
        self.by_genome.get(&key).cloned()
    }

    /// Saves the manifest if much has changed.
    fn save_some(&mut self) -> Result<(), Fatal> {
        if self.unsaved < SAVED_AFTER || self.choices.dry {
            return Ok(());
        }
        self.unsaved = 0;
        Ok(self.draft.save_and_go_on()?)
    }

    fn save(self) -> Result<(), Fatal> {
        if self.choices.dry || self.unsaved == 0 { Ok(()) } else { Ok(self.draft.save()?) }
    }
}

impl Original {
    fn of(key: GenomeKey, origin: &Origin) -> Self {
        Self { key, author: origin.authors.first().cloned(), licence: origin.licence.clone() }
    }

    /// Whether `other` draws the same, and names no other author or licence, where both name one.
    fn is_copied_by(&self, other: &Self) -> bool {
        let agree = |a: &Option<String>, b: &Option<String>| a.is_none() || b.is_none() || a == b;
        self.key == other.key && agree(&self.author, &other.author) && agree(&self.licence, &other.licence)
    }
}

/// Whether `text`, which is that of the file at `path`, has a copy of `genome`.
fn is_copy(genome: &NamedGenome, path: &Path, text: &str) -> bool {
    GenomeKey::of_file(path, text)
        .is_some_and(|(key, origin)| Original::of(key, &origin).is_copied_by(&Original::of(genome.key, &genome.origin)))
}

/// Whether the ending of `path` is that of a species whose files do not end in `ending`.
fn has_other_ending(path: &ClipPath, ending: &str) -> bool {
    let found = path.as_str().rsplit_once('.').map(|(_, found)| found);
    found.is_some_and(|found| found != ending && species::endings().contains(&found))
}

/// What is known of a flame besides what itself says.
fn said_of(file: &GenomeFile, flame: &NamedGenome, electric: Option<&ElectricName>) -> Said {
    let Some(name) = electric else { return Said { source: file.name(), ..Said::default() } };
    // The genome's own word counts, where it has one.
    let origin = &flame.origin;
    let licence = name.licence(Some(origin)).filter(|_| origin.licence.is_none());
    Said { licence, source: Some(name.source()), attribution: Some(ATTRIBUTION.to_owned()), ..Said::default() }
}

fn write(path: &Path, text: &str) -> Result<(), Fatal> {
    let parent = path.parent().unwrap_or(Path::new("."));
    let written = fs::create_dir_all(parent).and_then(|()| durable::save(path, text.as_bytes()));
    written.map_err(|source| Fatal::write(path, source))
}
