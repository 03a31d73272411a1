//! What the files of genomes say, read once.
//!
//! Owns the memory of species, lineages and what is not drawn, by file, size and time of change: a flock has thousands of genomes, and the page
//! asks after each edit. Never changes a file.
//!
//! Start at [`Genomes::facts`].

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::SystemTime;

use ::species::Lineage;
use flame::genome::Unsupported;
use operations::program::chain;
use operations::species::{self, reasons};

use crate::lock::locked;

/// What is known of a genome.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct GenomeFacts {
    /// Its species, by the ending of its files; `None` if the file is not there.
    pub(crate) species: Option<&'static str>,
    /// What it says of its origin; `None` if it is no genome.
    pub(crate) lineage: Option<Lineage>,
    /// What of it is not drawn.
    pub(crate) undrawn: Unsupported,
    /// Why its file is no genome, or cannot be read.
    pub(crate) unusable: Option<String>,
}

/// A file's size and when it was changed.
type Stamp = (u64, Option<SystemTime>);

/// The genomes that were read.
#[derive(Debug, Default)]
pub(crate) struct Genomes {
    known: Mutex<HashMap<PathBuf, (Stamp, Arc<GenomeFacts>)>>,
}

impl Genomes {
    /// What is known of the genome at `path`. Many threads may ask at once.
    pub(crate) fn facts(&self, path: &Path) -> Arc<GenomeFacts> {
        let status = match fs::metadata(path) {
            Ok(status) => status,
            Err(error) => return Arc::new(GenomeFacts::unusable(error.to_string())),
        };
        let stamp = (status.len(), status.modified().ok());
        let known = locked(&self.known).get(path).cloned();
        if let Some((_, facts)) = known.filter(|(known, _)| *known == stamp) {
            return facts;
        }
        let facts = Arc::new(read(path));
        let mut known = locked(&self.known);
        known.insert(path.to_owned(), (stamp, Arc::clone(&facts)));
        facts
    }
}

fn read(path: &Path) -> GenomeFacts {
    let text = match species::text(path) {
        Ok(text) => text,
        Err(why) => return GenomeFacts::unusable(chain(&*why.source)),
    };
    let (undrawn, unusable) = match reasons::of_text(path, &text) {
        Ok(undrawn) => (undrawn, None),
        Err(why) => (Unsupported::default(), Some(why)),
    };
    let (species, lineage) = (Some(species::ending(path, &text)), species::lineage(path, &text));
    GenomeFacts { species, lineage, undrawn, unusable }
}

impl GenomeFacts {
    fn unusable(why: String) -> Self {
        Self { unusable: Some(why), ..Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_genome_that_is_replaced_is_read_again() {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("a.flam3");
        let genomes = Genomes::default();
        assert_eq!(genomes.facts(&path).species, None);
        assert!(genomes.facts(&path).unusable.as_ref().is_some_and(|why| why.contains("No such file")));
        fs::write(&path, "<flame name=\"a\" nick=\"ada\"/>").unwrap();
        assert_eq!(genomes.facts(&path).species, Some("flam3"));
        fs::write(&path, "(expression 1 (picture x))").unwrap();
        assert_eq!(genomes.facts(&path).species, Some("expr"));
    }

    #[test]
    fn parents_are_told_of_every_species() {
        let scratch = tempfile::tempdir().unwrap();
        let texts = [
            ("a.flam3", "<flame name=\"c\"><edit><sheep gen=\"2\" id=\"7\"/></edit></flame>", "2.7"),
            ("a.expr", "(expression 1 (lineage (parents \"ram\")) (picture x))", "ram"),
        ];
        for (name, text, parent) in texts {
            let path = scratch.path().join(name);
            fs::write(&path, text).unwrap();
            let lineage = Genomes::default().facts(&path).lineage.clone().unwrap();
            assert_eq!(lineage.parents, [parent], "{name}");
        }
    }
}
