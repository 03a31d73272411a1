//! The credits of a flock on its page.
//!
//! Owns this part of the page's document. `operations::credits` finds the credits; `sheet/credits.js` draws.
//!
//! Start at [`CreditFacts::of`].

use std::collections::BTreeMap;
use std::path::Path;

use flock::Flock;
use operations::credits::{Credit, FlockCredits, Sale};
use operations::flock_folder::paths::CREDITS;
use operations::program::Fatal;

use super::large_facts::MOST_DRAWN;
use crate::credits::{LicenceCount, attributions, counts};

/// The most authors that are named, those of the most sheep first.
const MOST_AUTHORS: usize = 100;

/// Who made the flock, on the page.
#[derive(Debug, serde::Serialize)]
pub(super) struct CreditFacts {
    /// The most frequent first.
    licences: Vec<LicenceFacts>,
    /// With the number of their sheep, the most frequent first.
    authors: Vec<(String, usize)>,
    /// The number of authors that are not named.
    more_authors: usize,
    /// What whoever shows the flock has to say.
    attributions: Vec<String>,
    /// In the order of the page's sheep; empty if the page does not show each of them.
    sheep: Vec<Credit>,
}

/// A licence on the page.
#[derive(Debug, serde::Serialize)]
struct LicenceFacts {
    /// `None` is what has no licence.
    licence: Option<String>,
    sale: Sale,
    sheep: usize,
    transitions: usize,
}

impl CreditFacts {
    /// The credits of `flock` in `folder`; `None` if nothing is known of anything.
    /// Errors: If `credits.toml` is malformed.
    pub(super) fn of(folder: &Path, flock: &Flock) -> Result<Option<Self>, Fatal> {
        let has_genomes = flock.manifest().sheep.iter().any(|sheep| sheep.genome.is_some());
        if !has_genomes && !folder.join(CREDITS).exists() {
            return Ok(None);
        }
        let credits = FlockCredits::of(folder, flock.manifest())?;
        if credits.sheep.iter().chain(&credits.transitions).all(|credit| *credit == Credit::default()) {
            return Ok(None);
        }
        let mut authors: BTreeMap<&str, usize> = BTreeMap::new();
        for author in credits.sheep.iter().flat_map(|credit| &credit.authors) {
            *authors.entry(author).or_default() += 1;
        }
        let mut authors: Vec<(String, usize)> =
            authors.into_iter().map(|(author, sheep)| (author.to_owned(), sheep)).collect();
        authors.sort_by_key(|(_, sheep)| std::cmp::Reverse(*sheep));
        let more_authors = authors.len().saturating_sub(MOST_AUTHORS);
        authors.truncate(MOST_AUTHORS);
        let licence = |count: LicenceCount<'_>| LicenceFacts {
            licence: count.licence.map(ToString::to_string),
            sale: count.sale,
            sheep: count.sheep,
            transitions: count.transitions,
        };
        let whole = flock.whole();
        let shown = Some(whole.sheep()).filter(|_| whole.len() <= MOST_DRAWN).into_iter().flatten();
        Ok(Some(Self {
            licences: counts(&credits).into_iter().map(licence).collect(),
            authors,
            more_authors,
            attributions: attributions(&credits).into_iter().map(str::to_owned).collect(),
            sheep: shown.map(|sheep| credits.sheep[whole.sheep_in_manifest(sheep)].clone()).collect(),
        }))
    }
}
