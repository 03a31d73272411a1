//! The credits of a whole flock.
//!
//! Owns which word counts: an entry of `credits.toml` before the genome, and the file's `[default]` for what has no licence
//! and no other authors. A transition without an entry is made of the two sheep at its ends: it has the authors of both, and
//! both licences.
//!
//! Start at [`FlockCredits::of`].

use std::collections::{HashMap, HashSet};
use std::path::Path;

use ::species::Lineage;
use flame::genome::name_of;
use flock::{ClipPath, Manifest, Sheep, SheepId, excerpt};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde::Serialize;

use super::entry::{Said, Subject};
use super::file::CreditsFile;
use super::licence::{Licence, Sale};
use crate::program::Fatal;
use crate::species;

/// Who made a sheep or a transition, and under which licence it is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Credit {
    /// The nearest first: of a sheep, then of its ancestors.
    pub authors: Vec<String>,
    /// `null` if nothing says it.
    pub licence: Option<Licence>,
    /// What it was imported from.
    pub source: Option<String>,
    /// What it was bred from.
    pub parents: Vec<String>,
    /// What whoever shows it has to say.
    pub attribution: Option<String>,
}

/// The credits of everything in a flock.
#[derive(Debug)]
pub struct FlockCredits {
    /// In the order of the manifest.
    pub sheep: Vec<Credit>,
    /// In the order of the manifest.
    pub transitions: Vec<Credit>,
    /// What has an entry in the file and is not in the flock.
    pub strangers: Vec<Subject>,
}

/// A clip that may not be sold, or is not known to be.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NotForSale {
    /// The clip.
    pub clip: ClipPath,
    /// What it is under, if that is known.
    pub licence: Option<Licence>,
    /// Why it may not be sold.
    pub sale: Sale,
}

impl FlockCredits {
    /// The credits of the flock in `folder`. Genomes that cannot be read tell nothing: `dreams check` names them.
    /// Errors: If `credits.toml` is malformed.
    pub fn of(folder: &Path, manifest: &Manifest) -> Result<Self, Fatal> {
        Self::with_genomes(folder, manifest, |_, genome| lineage(folder, genome))
    }

    /// The same, with what `known` says of the lineage of each genome: for those who ask often.
    pub fn with_lineages(
        folder: &Path,
        manifest: &Manifest,
        known: impl Fn(&ClipPath) -> Option<Lineage> + Sync,
    ) -> Result<Self, Fatal> {
        Self::with_genomes(folder, manifest, |_, genome| known(genome))
    }

    /// The same, but a genome is read only where the file does not tell the licence: enough for what is asked of licences.
    pub fn of_licences(folder: &Path, manifest: &Manifest) -> Result<Self, Fatal> {
        let wants = |said: Option<&Said>| said.is_none_or(|said| said.licence.is_none());
        Self::with_genomes(folder, manifest, |said, genome| wants(said).then(|| lineage(folder, genome)).flatten())
    }

    fn with_genomes(
        folder: &Path,
        manifest: &Manifest,
        lineage: impl Fn(Option<&Said>, &ClipPath) -> Option<Lineage> + Sync,
    ) -> Result<Self, Fatal> {
        let file = CreditsFile::read(folder)?;
        let of_sheep = |sheep: &Sheep| {
            let said = file.said(&Subject::Sheep(sheep.id.clone()));
            let genome = sheep.genome.as_ref().and_then(|genome| lineage(said, genome));
            Credit::of_sheep(said, genome.unwrap_or_default(), file.default())
        };
        let sheep: Vec<Credit> = manifest.sheep.par_iter().map(of_sheep).collect();
        let ids: HashMap<&SheepId, &Credit> = manifest.sheep.iter().map(|sheep| &sheep.id).zip(&sheep).collect();
        let of_transition = |from: &SheepId, to: &SheepId| {
            let said = file.said(&Subject::Transition(from.clone(), to.clone()));
            Credit::of_transition(said, [from, to].map(|id| ids.get(id).copied()), file.default())
        };
        let transitions = manifest.transitions.iter().map(|t| of_transition(&t.from, &t.to)).collect();
        let named = file.named_in(manifest);
        let strangers = file.subjects().filter(|subject| !named.contains(subject)).cloned().collect();
        Ok(Self { sheep, transitions, strangers })
    }

    /// The clips that may not be sold, or are not known to be, in the order of the manifest. Each is named once.
    pub fn not_for_sale(&self, manifest: &Manifest) -> Vec<NotForSale> {
        let loops = manifest.sheep.iter().map(|sheep| sheep.clip.as_ref()).zip(&self.sheep);
        let transitions = manifest.transitions.iter().map(|transition| Some(&transition.clip)).zip(&self.transitions);
        let (mut found, mut named) = (Vec::new(), HashSet::new());
        for (clip, credit) in loops.chain(transitions).filter_map(|(clip, credit)| Some((clip?, credit))) {
            let sale = Sale::of(credit.licence.as_ref());
            if sale != Sale::Permitted && named.insert(&clip.path) {
                found.push(NotForSale { clip: clip.path.clone(), licence: credit.licence.clone(), sale });
            }
        }
        found
    }
}

impl NotForSale {
    /// As a line for people.
    pub fn line(&self) -> String {
        let licence =
            self.licence.as_ref().map_or("has no licence".to_owned(), |licence| format!("is under {licence}"));
        format!("`{}` {licence}: {}", self.clip, self.sale.in_words())
    }
}

impl Credit {
    /// Whether its licence is `wanted`: an SPDX identifier, with or without its version, or `none`.
    pub fn is_under(&self, wanted: &str) -> bool {
        self.licence.as_ref().map_or(wanted.eq_ignore_ascii_case("none"), |licence| licence.is(wanted))
    }

    fn of_sheep(said: Option<&Said>, genome: Lineage, default: &Said) -> Self {
        let said = said.cloned().unwrap_or_default();
        let licence = said.licence.or_else(|| Licence::read(genome.licence.as_deref()?));
        Self {
            authors: said.authors.unwrap_or(genome.authors),
            licence,
            source: said.source,
            parents: said.parents.unwrap_or(genome.parents),
            attribution: said.attribution,
        }
        .or_default(default)
    }

    fn of_transition(said: Option<&Said>, ends: [Option<&Credit>; 2], default: &Said) -> Self {
        let said = said.cloned().unwrap_or_default();
        let ends = ends.into_iter().flatten();
        let of_ends = || distinct(ends.clone().flat_map(|end| end.authors.iter().cloned()), name_of);
        let authors = said.authors.unwrap_or_else(of_ends);
        let both = || {
            let mut licences = ends.clone().map(|end| end.licence.clone());
            let (from, to) = (licences.next()??, licences.next()??);
            Some(from.and(&to))
        };
        let attributions = || distinct(ends.clone().filter_map(|end| end.attribution.clone()), |text| text);
        Self {
            authors,
            licence: said.licence.or_else(both),
            source: said.source,
            parents: Vec::new(),
            attribution: said.attribution.or_else(|| Some(attributions().join("; ")).filter(|text| !text.is_empty())),
        }
        .or_default(default)
    }

    /// With what the file says of everything, if it has no licence, and no other authors than those.
    fn or_default(self, default: &Said) -> Self {
        let known = default.authors.as_deref().unwrap_or_default();
        let is_known = |author: &String| known.iter().any(|known| name_of(known) == name_of(author));
        if self.licence.is_some() || !self.authors.iter().all(is_known) {
            return self;
        }
        let authors = if self.authors.is_empty() { known.to_vec() } else { self.authors };
        let attribution = self.attribution.or_else(|| default.attribution.clone());
        Self { authors, licence: default.licence.clone(), attribution, ..self }
    }

    /// What is known, in one line for people; names from genomes are made fit for a terminal.
    pub fn line(&self) -> String {
        let mut parts: Vec<String> = self.authors.iter().map(|author| excerpt(author)).collect();
        parts.extend(self.source.iter().map(|source| format!("from {}", excerpt(source))));
        if !self.parents.is_empty() {
            parts.push(format!("bred from {}", excerpt(&self.parents.join(" and "))));
        }
        parts.join(", ")
    }
}

/// What the genome at `path` says of its origin; `None` if it cannot be read.
fn lineage(folder: &Path, path: &ClipPath) -> Option<Lineage> {
    let path = path.inside(folder);
    species::lineage(&path, &species::text(&path).ok()?)
}

/// Those of `texts` whose `part` none before them has.
fn distinct(texts: impl Iterator<Item = String>, part: fn(&str) -> &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for text in texts {
        if found.iter().all(|other| part(other) != part(&text)) {
            found.push(text);
        }
    }
    found
}
