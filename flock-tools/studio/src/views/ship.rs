//! What leaves the studio: faults, joins, credits and size of the flock, the keys that may sign it, and where it may go.
//!
//! Owns the answer. Keys and targets are found by `store`.
//!
//! Start at [`ShipState`].

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use flock::{Fault, Manifest};
use operations::credits::{FlockCredits, Licence};
use operations::flock_folder::paths::CREDITS;
use operations::program::print;
use serde_json::Value;

/// The most authors that are named under a licence.
const MOST_AUTHORS: usize = 50;

/// The answer.
#[derive(Debug, serde::Serialize)]
pub(crate) struct ShipState {
    pub(crate) faults: Vec<Fault>,
    /// `null` until joins were judged.
    pub(crate) joins: Option<JoinCount>,
    pub(crate) credits: Vec<LicenceState>,
    pub(crate) bytes: u64,
    pub(crate) files: usize,
    /// Whether something was packed.
    pub(crate) packed: bool,
    /// What differs from the last bundle; `null` if there is none, or if nobody has compared the flock as it is now.
    pub(crate) difference: Option<Value>,
    pub(crate) ready: bool,
    pub(crate) why_not: Vec<String>,
    pub(crate) keys: Vec<String>,
    pub(crate) targets: Vec<String>,
    pub(crate) outbox: String,
}

/// How many joins were judged.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct JoinCount {
    pub(crate) judged: usize,
    pub(crate) jumps: usize,
    /// The largest severity: above 1 it jumps.
    pub(crate) worst: f64,
}

/// What is under a licence.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct LicenceState {
    /// `null` is what has no licence.
    pub(crate) licence: Option<String>,
    pub(crate) sheep: usize,
    pub(crate) authors: Vec<String>,
}

/// The bytes and the number of the files that a bundle of the flock in `folder` has.
pub(crate) fn size(folder: &Path, manifest: &Manifest) -> (u64, usize) {
    let genomes = manifest.sheep.iter().filter_map(|sheep| sheep.genome.as_ref());
    let named = manifest.clips().map(|clip| &clip.path).chain(genomes).map(|path| path.inside(folder));
    let own = [flock::FILE_NAME, CREDITS].map(|name| folder.join(name));
    let mut paths: Vec<PathBuf> = named.chain(own).collect();
    paths.sort_unstable();
    paths.dedup();
    let sizes = paths.iter().filter_map(|path| fs::metadata(path).ok()).map(|status| status.len());
    sizes.fold((0, 0), |(bytes, files), own| (bytes + own, files + 1))
}

/// The licences in the flock, the most frequent first, with the authors of what is under each.
pub(crate) fn licences(credits: &FlockCredits) -> Vec<LicenceState> {
    let mut found: BTreeMap<Option<&str>, LicenceState> = BTreeMap::new();
    for credit in &credits.sheep {
        let licence = credit.licence.as_ref().map(Licence::as_str);
        let own = found.entry(licence).or_insert_with(|| LicenceState {
            licence: licence.map(str::to_owned),
            sheep: 0,
            authors: Vec::new(),
        });
        own.sheep += 1;
        for author in &credit.authors {
            if own.authors.len() < MOST_AUTHORS && !own.authors.contains(author) {
                own.authors.push(author.clone());
            }
        }
    }
    let mut all: Vec<LicenceState> = found.into_values().collect();
    all.sort_by_key(|own| std::cmp::Reverse(own.sheep));
    all
}

/// Why the flock cannot be packed: `missing` clips, `faults`, and joins that jump; empty if it can.
pub(crate) fn why_not(missing: usize, faults: &[Fault], joins: Option<&JoinCount>, keys: usize) -> Vec<String> {
    let mut why = Vec::new();
    if missing > 0 {
        let verb = if missing == 1 { "is" } else { "are" };
        why.push(format!("{} {verb} not rendered", print::count(missing, "clip")));
    }
    if let Some(first) = faults.first() {
        why.push(format!("{}: {}", print::count(faults.len(), "fault"), first.message));
    }
    if let Some(joins) = joins.filter(|joins| joins.jumps > 0) {
        why.push(format!("{} of {} joins jump", joins.jumps, joins.judged));
    }
    if keys == 0 {
        why.push("there is no key: `dreams keygen` makes one; it is looked for beside the flock's folder".to_owned());
    }
    why
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_keeps_a_flock_from_being_packed_is_told_in_sentences() {
        let joins = JoinCount { judged: 80, jumps: 2, worst: 1.4 };
        assert_eq!(why_not(3, &[], Some(&joins), 1), ["3 clips are not rendered", "2 of 80 joins jump"]);
        assert_eq!(why_not(1, &[], None, 1), ["1 clip is not rendered"]);
        assert_eq!(why_not(0, &[], Some(&JoinCount { jumps: 0, ..joins }), 1), [""; 0]);
    }
}
