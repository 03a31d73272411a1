//! A file of genomes.
//!
//! Owns the reading of its genomes, their ids, and whether it is a transition: two flames, in a file that is called as
//! Electric Sheep calls a sheep or an edge, or FROM=TO. Of other species a file has one genome. An edge has a number of its own; its flames bear the names of the two
//! sheep, or, in the oldest generations, none. Never writes.
//!
//! Start at [`GenomeFile::read`].

use std::fs;
use std::path::{Path, PathBuf};

use ::species::{Lineage, Settings};
use flame::genome::Origin;
use flame::{Backend, Genome};
use flock::{ClipHash, SheepId};
use operations::credits::Said;
use operations::flock_folder::paths;
use operations::program::{chain, print};
use operations::species;

use crate::import::electric::ElectricName;

/// A file of genomes.
#[derive(Debug)]
pub(super) struct GenomeFile {
    pub(super) source: PathBuf,
    /// Whether it is the transition between the sheep of its two flames; else each genome is a sheep.
    pub(super) is_transition: bool,
    /// At least one.
    pub(super) genomes: Vec<NamedGenome>,
    /// What Electric Sheep calls the file.
    pub(super) electric: Option<ElectricName>,
}

/// A genome of a file.
#[derive(Debug)]
pub(super) struct NamedGenome {
    /// From 1.
    pub(super) number: usize,
    /// What it draws.
    pub(super) key: GenomeKey,
    /// What it says of its origin.
    pub(super) origin: Origin,
    /// The ending that its file has in a flock.
    pub(super) ending: &'static str,
    /// Its part of the file, byte for byte.
    pub(super) text: String,
    /// The id of its sheep; `None` if its name is no id.
    pub(super) id: Option<SheepId>,
    /// Whether Electric Sheep's name of the flame says so, or the ends in the name of the file.
    pub(super) is_certain: bool,
    /// What Electric Sheep calls the flame.
    pub(super) electric: Option<ElectricName>,
}

/// What a genome draws, whatever it is called and whoever made it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct GenomeKey(ClipHash);

impl GenomeFile {
    /// Reads the file `source`; or says why it is left out.
    pub(super) fn read(source: &Path) -> Result<Self, String> {
        let text = fs::read_to_string(source).map_err(|error| format!("cannot be read: {error}"))?;
        if !species::is_of_flames(source, &text) {
            return Self::of_other_species(source, text);
        }
        let flames = Genome::split(&text).map_err(|error| format!("is not readable: {}", chain(&error)))?;
        if flames.is_empty() {
            return Err("has no flame".to_owned());
        }
        let stem = source.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let electric = ElectricName::of_file(stem);
        let is_transition = flames.len() == 2 && (electric.is_some() || ends(stem, electric.as_ref()).is_some());
        // A file with the name of a loop is the sheep of that loop.
        let ends =
            ends(stem, electric.as_ref()).filter(|(from, to)| is_transition || (flames.len() == 1 && from == to));
        let ends = ends.map_or(Vec::new(), |(from, to)| vec![from, to]);
        let several = flames.len() > 1;
        let named = |(at, (genome, text)): (usize, (Genome, &str))| {
            let name = genome.name.as_deref().map(str::trim).filter(|name| !name.is_empty());
            let own_name = name.and_then(ElectricName::of_flame);
            let own = own_name.as_ref().map(ElectricName::sheep);
            if let Some((own, end)) = own.as_ref().zip(ends.get(at)).filter(|(own, end)| own != end) {
                return Err(format!("flame {} is `{own}` (expected `{end}`, by the name of the file)", at + 1));
            }
            let of_file = || electric.as_ref()?.end_names()?.into_iter().nth(at);
            let electric = own_name.or_else(|| ends.get(at).and_then(|_| of_file()));
            let certain = ends.get(at).cloned().or(own);
            let is_certain = certain.is_some();
            let id = certain.or_else(|| id(name, stem, several.then_some(at + 1)));
            let (key, origin) = (GenomeKey::of_flame(&genome), genome.origin());
            let (number, text) = (at + 1, text.to_owned());
            Ok(NamedGenome { number, key, origin, ending: paths::GENOME, text, id, is_certain, electric })
        };
        let mut genomes = flames.into_iter().enumerate().map(named).collect::<Result<Vec<_>, _>>()?;
        let is_loop = is_transition && genomes.iter().all(|flame| flame.is_certain && flame.id == genomes[0].id);
        if is_loop {
            genomes.truncate(1);
        }
        Ok(Self { source: source.to_owned(), is_transition: is_transition && !is_loop, genomes, electric })
    }

    /// A file with one genome of another species, which is called by its name or else by its file.
    fn of_other_species(source: &Path, text: String) -> Result<Self, String> {
        let genome = species::parse(source, &text, &Backend::default());
        let genome = genome.map_err(|why| format!("is not readable: {}", chain(&*why.source)))?;
        let stem = source.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let id = id(genome.name().map(str::trim).filter(|name| !name.is_empty()), stem, None);
        let (key, ending) = (GenomeKey::of(&*genome), species::ending(source, &text));
        let (number, origin, is_certain, electric) = (1, origin(&*genome), false, None);
        let genomes = vec![NamedGenome { number, key, origin, ending, text, id, is_certain, electric }];
        Ok(Self { source: source.to_owned(), is_transition: false, genomes, electric: None })
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

/// The id of a flame: its name, in the letters that an id may have; without one, the file's `stem`, and the flame's number
/// where the file has several. Electric Sheep's names are those of its clips.
fn id(name: Option<&str>, stem: &str, number: Option<usize>) -> Option<SheepId> {
    let told = name.unwrap_or(stem);
    let told = ElectricName::of_file(told).map_or(told.to_owned(), |name| name.sheep().to_string());
    let told = number.filter(|_| name.is_none()).map_or(told.clone(), |number| format!("{told}.{number}"));
    let plain = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '-' };
    SheepId::new(&told.chars().map(plain).collect::<String>()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flame_is_called_by_its_name_or_else_by_its_file() {
        let id = |name, stem, number| id(name, stem, number).map(|id| id.as_str().to_owned());
        assert_eq!(id(Some("electricsheep.247.00505"), "x", None).as_deref(), Some("247.505"));
        assert_eq!(id(None, "electricsheep.247.00505", None).as_deref(), Some("247.505"));
        assert_eq!(id(None, "electricsheep.165.00002", Some(2)).as_deref(), Some("165.2.2"));
        assert_eq!(id(Some("Blue Dream #3"), "x", Some(3)).as_deref(), Some("Blue-Dream--3"));
        assert_eq!(id(None, "best", Some(2)).as_deref(), Some("best.2"));
        assert_eq!(id(Some("electricsheep.x.y"), "best", None).as_deref(), Some("electricsheep.x.y"));
        assert_eq!(id(Some(&"n".repeat(65)), "best", None), None);
    }

    /// Whether a file of this name is a transition, and the ids of its flames; or why it is left out.
    fn read(name: &str, flames: &[&str]) -> Result<(bool, Vec<String>), String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        let xform = r#"<xform weight="1" color="0" linear="1" coefs="1 0 0 1 0 0"/>"#;
        let flames: Vec<String> = flames.iter().map(|name| format!("<flame name=\"{name}\">{xform}</flame>")).collect();
        fs::write(&path, format!("<flames>{}</flames>", flames.concat())).unwrap();
        let file = GenomeFile::read(&path)?;
        let ids = file.genomes.iter().map(|flame| flame.id.as_ref().unwrap().to_string()).collect();
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
        assert_eq!(other.unwrap_err(), "flame 2 is `242.99` (expected `242.98`, by the name of the file)");
    }
}
