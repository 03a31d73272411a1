//! A file of genomes.
//!
//! Owns the reading of its genomes, their ids, and whether it is a transition: two flames, in a file that is called as
//! Electric Sheep calls a sheep or an edge, or FROM=TO. Of other species a file has one genome. An edge has a number of its own; its flames bear the names of the two
//! sheep, or, in the oldest generations, none. Never writes.
//!
//! Start at [`GenomeFile::read`].

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use ::species::{Lineage, Settings};
use flame::genome::{MARK, Origin, Part, Reasons, Unsupported};
use flame::{Backend, Genome};
use flock::{ClipHash, SheepId};
use operations::credits::Said;
use operations::flock_folder::paths;
use operations::program::{chain, print};
use operations::species;
use operations::species::reasons;

use super::file_kind;
use super::key_frames::{self, KeyFrames};
use super::names::id;
use crate::import::electric::ElectricName;

/// A file of genomes.
#[derive(Debug)]
pub(super) struct GenomeFile {
    pub(super) source: PathBuf,
    /// Whether it is the transition between the sheep of its two flames; else each genome is a sheep.
    pub(super) is_transition: bool,
    pub(super) genomes: Vec<NamedGenome>,
    /// Why other flames of it are left out.
    pub(super) left_out: Vec<LeftOut>,
    /// Whether its flames are the key frames of one animation.
    pub(super) is_animation: bool,
    /// What Electric Sheep calls the file.
    pub(super) electric: Option<ElectricName>,
}

/// A genome of a file.
#[derive(Debug)]
pub(super) struct NamedGenome {
    /// What it draws.
    pub(super) key: GenomeKey,
    /// What it says of its origin.
    pub(super) origin: Origin,
    /// The ending that its file has in a flock.
    pub(super) ending: &'static str,
    /// Its part of the file, byte for byte.
    pub(super) text: String,
    /// The id of its sheep.
    pub(super) id: SheepId,
    /// Whether Electric Sheep's name of the flame says so, or the ends in the name of the file.
    pub(super) is_certain: bool,
    /// What Electric Sheep calls the flame.
    pub(super) electric: Option<ElectricName>,
    /// What was read otherwise than it is written.
    pub(super) notes: Vec<String>,
    /// What it is drawn without.
    pub(super) without: Reasons,
}

/// Why a file or a flame is left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct LeftOut {
    /// In words.
    pub(super) reason: String,
    /// What it asks for that is not drawn.
    pub(super) reasons: Reasons,
}

/// What the command line says of reading.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reading {
    /// What becomes of files with the key frames of one animation; else they are left out.
    pub(super) key_frames: Option<KeyFrames>,
    /// Whether unknown variations are left out; else their flames are.
    pub(super) as_far_as_possible: bool,
}

/// A flame of a file.
struct ReadFlame {
    /// From 1.
    number: usize,
    genome: Genome,
    text: String,
    notes: Vec<String>,
    without: Reasons,
}

/// What a genome draws, whatever it is called and whoever made it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct GenomeKey(ClipHash);

impl From<String> for LeftOut {
    fn from(reason: String) -> Self {
        Self { reason, reasons: Reasons::default() }
    }
}

impl GenomeFile {
    /// Reads the file `source`; or says why it is left out.
    pub(super) fn read(source: &Path, reading: Reading) -> Result<Self, LeftOut> {
        let text = species::text(source).map_err(|why| {
            let hint = why.hint.map_or(String::new(), |hint| format!("; {hint}"));
            format!("cannot be read: {}{hint}", chain(&*why.source))
        })?;
        if !species::is_of_flames(source, &text) {
            return Ok(Self::of_other_species(source, text)?);
        }
        let parts = Genome::split(&text).map_err(|error| format!("is not readable: {}", chain(&error)))?;
        if parts.is_empty() {
            return Err(if text.contains("<IFS") { file_kind::CHAOTICA } else { "has no flame" }.to_owned().into());
        }
        let stem = source.file_stem().map(OsStr::to_string_lossy).unwrap_or_default();
        let electric = ElectricName::of_file(&stem);
        let is_transition = parts.len() == 2 && (electric.is_some() || ends(&stem, electric.as_ref()).is_some());
        let several = parts.len() > 1;
        let (mut flames, left_out) = sound(parts, reading.as_far_as_possible);
        if let Some(reason) = left_out.first().filter(|_| is_transition) {
            return Err(reason.clone());
        }
        let moments: Vec<&Genome> = flames.iter().map(|flame| &flame.genome).collect();
        let is_animation = !is_transition && left_out.is_empty() && key_frames::is_animation(&moments);
        match reading.key_frames {
            None if is_animation => return Err(key_frames::undecided(&moments).into()),
            Some(KeyFrames::First) if is_animation => flames.truncate(1),
            Some(_) | None => {}
        }
        // A file with the name of a loop is the sheep of that loop.
        let ends =
            ends(&stem, electric.as_ref()).filter(|(from, to)| is_transition || (flames.len() == 1 && from == to));
        let ends = ends.map_or(Vec::new(), |(from, to)| vec![from, to]);
        let several = several && !(is_animation && flames.len() == 1);
        let called = |(at, flame): (usize, ReadFlame)| called(flame, &stem, several, electric.as_ref(), ends.get(at));
        let mut genomes = flames.into_iter().enumerate().map(called).collect::<Result<Vec<_>, _>>()?;
        let is_loop = is_transition && genomes.iter().all(|flame| flame.is_certain && flame.id == genomes[0].id);
        if is_loop {
            genomes.truncate(1);
        }
        let (source, is_transition) = (source.to_owned(), is_transition && !is_loop);
        Ok(Self { source, is_transition, genomes, left_out, is_animation, electric })
    }

    /// A file with one genome of another species, which is called by its name or else by its file.
    fn of_other_species(source: &Path, text: String) -> Result<Self, String> {
        let genome = species::parse(source, &text, &Backend::default());
        let genome = genome.map_err(|why| format!("is not readable: {}", chain(&*why.source)))?;
        let stem = source.file_stem().map(OsStr::to_string_lossy).unwrap_or_default();
        let id = id(genome.name(), &stem, None);
        let (key, ending) = (GenomeKey::of(&*genome), species::ending(source, &text));
        let (origin, is_certain, electric) = (origin(&*genome), false, None);
        let (notes, without) = (Vec::new(), Reasons::default());
        let genomes = vec![NamedGenome { key, origin, ending, text, id, is_certain, electric, notes, without }];
        let (left_out, is_transition, is_animation) = (Vec::new(), false, false);
        Ok(Self { source: source.to_owned(), is_transition, genomes, left_out, is_animation, electric: None })
    }

    /// The file's name.
    pub(super) fn name(&self) -> Option<String> {
        self.source.file_name().map(|name| print::path(Path::new(name)))
    }

    /// What is known of the transition that it is. Authors and licence are those of its sheep.
    pub(super) fn said(&self) -> Said {
        let Some(name) = &self.electric else { return Said { source: self.name(), ..Said::default() } };
        Said { source: Some(name.source()), ..Said::default() }
    }
}

impl GenomeKey {
    fn of_flame(genome: &Genome) -> Self {
        Self::of_text(&genome.anonymous().to_xml())
    }

    /// That of a genome of another species, in pictures of any size.
    fn of(genome: &dyn ::species::Genome) -> Self {
        let settings = Settings {
            size: [1; 2],
            spp: None,
            psnr: None,
            supersample: None,
            temporal_samples: None,
            smooths: true,
            seed: 0,
        };
        Self::of_text(&genome.recipe(&settings).genome)
    }

    fn of_text(text: &str) -> Self {
        Self(ClipHash::of(text.as_bytes()).expect("bytes in memory can be read"))
    }

    /// That of the one genome in `text` with what it says of its origin, which is that of the file at `path`; `None` if
    /// there is none.
    pub(super) fn of_file(path: &Path, text: &str) -> Option<(Self, Origin)> {
        if species::is_of_flames(path, text) {
            let genome = Genome::parse(text).ok()?;
            return Some((Self::of_flame(&genome), genome.origin()));
        }
        let genome = species::parse(path, text, &Backend::default()).ok()?;
        Some((Self::of(&*genome), origin(&*genome)))
    }
}

/// The flames of `parts` that can be drawn, if need be without unknown variations; and why the others cannot.
fn sound(parts: Vec<Part<'_>>, as_far_as_possible: bool) -> (Vec<ReadFlame>, Vec<LeftOut>) {
    let is_only = parts.len() == 1;
    let (mut flames, mut left_out) = (Vec::new(), Vec::new());
    for (number, Part { genome, text, notes }) in (1..).zip(parts) {
        let flame = match genome {
            Ok(genome) => drawable(genome, text.into_owned(), as_far_as_possible),
            Err(error) => Err(format!("is not readable: {}", chain(&error)).into()),
        };
        match flame {
            Ok((genome, text, without)) => flames.push(ReadFlame { number, genome, text, notes, without }),
            Err(why) if is_only => left_out.push(why),
            Err(why) => left_out.push(LeftOut { reason: format!("flame {number} {}", why.reason), ..why }),
        }
    }
    (flames, left_out)
}

/// A flame with its text and what it is drawn without; or why it is left out.
fn drawable(genome: Genome, text: String, as_far_as_possible: bool) -> Result<(Genome, String, Reasons), LeftOut> {
    let found = genome.unsupported();
    let possible = found.clone().as_far_as_possible();
    let Unsupported { refused, without } = if as_far_as_possible { &possible } else { &found };
    if !refused.is_empty() {
        let hint = if possible.refused.is_empty() { "; --as-far-as-possible leaves the variations out" } else { "" };
        let reason = format!("cannot be drawn: {}{hint}", reasons::refusal(refused));
        return Err(LeftOut { reason, reasons: refused.clone() });
    }
    let without = without.clone();
    if found.refused.is_empty() {
        return Ok((genome, text, without));
    }
    let marked = genome.as_far_as_possible();
    let text = marked_text(&text, &genome, &marked, found.mark().as_deref());
    Ok((marked, text, without))
}

/// The `text` of `genome` with its mark; byte for byte, unless it had another mark.
fn marked_text(text: &str, genome: &Genome, marked: &Genome, names: Option<&str>) -> String {
    const TAG: &str = "<flame";
    let has_mark = genome.extra.iter().any(|(name, _)| name == MARK);
    match text.strip_prefix(TAG).zip(names).filter(|_| !has_mark) {
        Some((rest, names)) => format!("{TAG} {MARK}=\"{names}\"{rest}"),
        None => marked.to_xml(),
    }
}

/// A flame of a file with one or `several`, called by the name of the sheep that it is as the `end` of a transition, or by
/// its own, or by the name of the file, of which this is the `stem`; or why the file is left out.
fn called(
    flame: ReadFlame,
    stem: &str,
    several: bool,
    file: Option<&ElectricName>,
    end: Option<&SheepId>,
) -> Result<NamedGenome, String> {
    let ReadFlame { number, genome, text, notes, without } = flame;
    let name = key_frames::own_name(&genome);
    let own_name = name.and_then(ElectricName::of_flame);
    let own = own_name.as_ref().map(ElectricName::sheep);
    if let Some((own, end)) = own.as_ref().zip(end).filter(|(own, end)| own != end) {
        return Err(format!("flame {number} is `{own}` (expected `{end}`, by the name of the file)"));
    }
    let of_file = || file?.end_names()?.into_iter().nth(number - 1);
    let electric = own_name.or_else(|| end.and_then(|_| of_file()));
    let certain = end.cloned().or(own);
    let is_certain = certain.is_some();
    let id = certain.unwrap_or_else(|| id(name, stem, several.then_some(number)));
    let (key, origin, ending) = (GenomeKey::of_flame(&genome), genome.origin(), paths::GENOME);
    Ok(NamedGenome { key, origin, ending, text, id, is_certain, electric, notes, without })
}

/// What a genome of another species says of its origin.
fn origin(genome: &dyn ::species::Genome) -> Origin {
    let Lineage { authors, licence, parents, .. } = genome.lineage();
    Origin { authors, licence, parents, ..Origin::default() }
}

/// The sheep that the name of a file says it leads from and to.
fn ends(stem: &str, electric: Option<&ElectricName>) -> Option<(SheepId, SheepId)> {
    let of_ids = || {
        let (from, to) = stem.split_once('=')?;
        SheepId::new(from).ok().zip(SheepId::new(to).ok())
    };
    electric.map_or_else(of_ids, ElectricName::ends)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// Whether a file of this name is a transition, and the ids of its flames; or why it is left out.
    fn read(name: &str, flames: &[&str]) -> Result<(bool, Vec<String>), LeftOut> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        let xform = r#"<xform weight="1" color="0" linear="1" coefs="1 0 0 1 0 0"/>"#;
        let flames: Vec<String> = flames.iter().map(|name| format!("<flame name=\"{name}\">{xform}</flame>")).collect();
        fs::write(&path, format!("<flames>{}</flames>", flames.concat())).unwrap();
        let file = GenomeFile::read(&path, Reading::default())?;
        let ids = file.genomes.iter().map(|flame| flame.id.to_string()).collect();
        Ok((file.is_transition, ids))
    }

    #[test]
    fn two_flames_in_a_file_with_the_name_of_an_edge_are_a_transition() {
        let edge = ["electricsheep.242.00076", "electricsheep.242.00099"];
        let ids = |is_transition, ids: &[&str]| Ok((is_transition, ids.iter().map(ToString::to_string).collect()));
        for name in ["electricsheep.242.00172.flam3", "electricsheep.242.172.76.99.flam3", "242=172=76=99.flam3"] {
            assert_eq!(read(name, &edge), ids(true, &["242.76", "242.99"]), "{name}");
        }
        assert_eq!(read("242.76=242.99.flam3", &["", ""]), ids(true, &["242.76", "242.99"]));
        assert_eq!(read("electricsheep.165.00002.flam3", &["", ""]), ids(true, &["165.2.1", "165.2.2"]));
        assert_eq!(read("best.flam3", &edge), ids(false, &["242.76", "242.99"]), "a collection");
        assert_eq!(read("electricsheep.242.00172.flam3", &edge[..1]), ids(false, &["242.76"]));
        assert_eq!(read("242=76=76=76.flam3", &[""]), ids(false, &["242.76"]));
        assert_eq!(read("242=76=76=76.flam3", &[edge[0], edge[0]]), ids(false, &["242.76"]), "a loop");
        let other = read("242=172=76=98.flam3", &edge);
        assert_eq!(other.unwrap_err().reason, "flame 2 is `242.99` (expected `242.98`, by the name of the file)");
    }
}
