//! Sheep as they are named on a command line: by ids and globs, several at once.
//!
//! Owns the form of these words, and which sheep and transitions of a flock they mean. An id has none of the characters
//! `*`, `?`, `[` and `,`, so that no word has two meanings. Never edits.
//!
//! Start at [`Selector`], then [`Chosen`].

use std::collections::{BTreeSet, HashSet};
use std::path::PathBuf;

use flock::{EditError, Manifest, SheepId};
use glob::Pattern;
use operations::program::{Exit, Fatal};

use super::hints;
use crate::ids;

/// What the help of every command says about a word that names sheep.
pub(super) const FORM: &str = "an id, or a glob such as `24*`; several with commas between";

/// One word: ids and globs, with commas between several.
#[derive(Clone, Debug)]
pub(super) struct Selector {
    text: String,
    names: Vec<Name>,
}

#[derive(Clone, Debug)]
enum Name {
    Id(SheepId),
    Glob(Pattern),
}

/// The sheep of a flock that some words name.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    /// All of them.
    pub(super) sheep: BTreeSet<SheepId>,
    /// Those that are named by their ids.
    named: BTreeSet<SheepId>,
    /// The words.
    text: String,
}

/// Ordered pairs of sheep that some words name.
#[derive(Debug)]
pub(super) struct Pairs {
    /// The pairs that were meant.
    pub(super) pairs: BTreeSet<(SheepId, SheepId)>,
    /// How many were passed over.
    pub(super) passed_over: usize,
}

/// Words that name nothing that is there.
#[derive(Debug, thiserror::Error)]
enum SelectionError {
    #[error("no sheep matches `{glob}`")]
    NoMatch { glob: String },
    #[error("from `{from}` to `{to}` there is {why}")]
    NoPair { from: String, to: String, why: &'static str },
    #[error("no sheep is named before the {what} `{found}`")]
    NoSheep { what: &'static str, found: String },
    #[error("`{found}` is no {what}: {wanted}")]
    Number { what: &'static str, found: String, wanted: String },
    #[error("cannot link {found} pairs at once (limit {limit})")]
    TooMany { found: usize, limit: usize },
    #[error("{0}")]
    Word(String),
}

/// The most pairs that are linked at once.
const MOST_PAIRS: usize = 100_000;

/// Sheep, and a number behind them that is set for each.
#[derive(Debug, clap::Args)]
pub(super) struct NumberArgs {
    /// Folder of the flock
    pub(super) dir: PathBuf,
    #[arg(value_name = "ID", num_args = 1.., required = true, allow_negative_numbers = true, add = ids::completer())]
    words: Vec<String>,
    /// Answer with one JSON document
    #[arg(long)]
    pub(super) json: bool,
}

impl Selector {
    /// Reads a word.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let name = |name: &str| {
            if name.contains(['*', '?', '[']) {
                let told = |error: glob::PatternError| format!("glob `{name}` is malformed: {}", error.msg);
                return Pattern::new(name).map(Name::Glob).map_err(told);
            }
            SheepId::new(name).map(Name::Id).map_err(|error| error.to_string())
        };
        Ok(Self { text: text.to_owned(), names: text.split(',').map(name).collect::<Result<_, _>>()? })
    }
}

impl Chosen {
    /// The sheep of `manifest` that `words` name.
    /// Errors: If an id is not in the flock, or a glob matches none.
    pub(super) fn of<'w>(words: impl IntoIterator<Item = &'w Selector>, manifest: &Manifest) -> Result<Self, Fatal> {
        let ids: HashSet<&SheepId> = manifest.sheep.iter().map(|sheep| &sheep.id).collect();
        let words: Vec<&Selector> = words.into_iter().collect();
        let (mut sheep, mut named) = (BTreeSet::new(), BTreeSet::new());
        for name in words.iter().flat_map(|word| &word.names) {
            match name {
                Name::Id(id) if ids.contains(id) => {
                    sheep.insert(id.clone());
                    named.insert(id.clone());
                }
                Name::Id(id) => return Err(hints::refused(EditError::UnknownSheep { id: id.clone() }, manifest)),
                Name::Glob(glob) => {
                    let matching: Vec<_> = ids.iter().filter(|id| glob.matches(id.as_str())).collect();
                    if matching.is_empty() {
                        return Err(malformed(SelectionError::NoMatch { glob: glob.as_str().to_owned() }));
                    }
                    sheep.extend(matching.into_iter().map(|id| (*id).clone()));
                }
            }
        }
        let text = words.iter().map(|word| word.text.as_str()).collect::<Vec<_>>().join(" ");
        Ok(Self { sheep, named, text })
    }

    /// The sheep in words: one by its id, several by their number.
    pub(super) fn told(&self) -> String {
        match self.sheep.first() {
            Some(one) if self.sheep.len() == 1 => format!("sheep `{one}`"),
            _ => format!("{} sheep", self.sheep.len()),
        }
    }
}

impl Pairs {
    /// The transitions of `manifest` from `from` to `to`. One between two sheep that are both named by their ids must be
    /// there; of all others those that are there are meant.
    pub(super) fn linked(from: &Chosen, to: &Chosen, manifest: &Manifest) -> Result<Self, Fatal> {
        let is_meant = |(a, b): &(&SheepId, &SheepId)| from.sheep.contains(*a) && to.sheep.contains(*b);
        let there = manifest.transitions.iter().map(|t| (&t.from, &t.to)).filter(is_meant);
        let mut pairs: BTreeSet<_> = there.map(|(a, b)| (a.clone(), b.clone())).collect();
        // The edit tells which of these is not there.
        pairs.extend(from.named.iter().flat_map(|a| to.named.iter().map(move |b| (a.clone(), b.clone()))));
        Self { pairs, passed_over: 0 }.unless_empty(from, to, "no transition")
    }

    /// The pairs from `from` to `to` that `manifest` has no transition for. One of two sheep that are both named by their
    /// ids must be new; of all others the new ones are meant, and none from a sheep to itself.
    pub(super) fn unlinked(from: &Chosen, to: &Chosen, manifest: &Manifest) -> Result<Self, Fatal> {
        let found = from.sheep.len().saturating_mul(to.sheep.len());
        if found > MOST_PAIRS {
            return Err(malformed(SelectionError::TooMany { found, limit: MOST_PAIRS }));
        }
        let own = manifest.transitions.iter().filter(|t| from.sheep.contains(&t.from));
        let there: HashSet<_> = own.map(|t| (&t.from, &t.to)).collect();
        let is_named = |a: &SheepId, b: &SheepId| from.named.contains(a) && to.named.contains(b);
        let is_meant = |(a, b): &(&SheepId, &SheepId)| is_named(a, b) || (a != b && !there.contains(&(*a, *b)));
        let all = from.sheep.iter().flat_map(|a| to.sheep.iter().map(move |b| (a, b)));
        let pairs: BTreeSet<_> = all.filter(is_meant).map(|(a, b)| (a.clone(), b.clone())).collect();
        let passed_over = found - pairs.len();
        Self { pairs, passed_over }.unless_empty(from, to, "no new pair")
    }

    fn unless_empty(self, from: &Chosen, to: &Chosen, why: &'static str) -> Result<Self, Fatal> {
        let (a, b) = (from.text.clone(), to.text.clone());
        if self.pairs.is_empty() { Err(malformed(SelectionError::NoPair { from: a, to: b, why })) } else { Ok(self) }
    }

    /// The pair, if it is a single one.
    pub(super) fn single(&self) -> Option<&(SheepId, SheepId)> {
        self.pairs.first().filter(|_| self.pairs.len() == 1)
    }
}

impl NumberArgs {
    /// The sheep, and the `what` behind them as `number` reads it.
    pub(super) fn read<T>(
        &self,
        what: &'static str,
        number: impl Fn(&str) -> Result<T, String>,
    ) -> Result<(Vec<Selector>, T), Fatal> {
        let (last, names) = self.words.split_last().map_or(("", &[][..]), |(last, names)| (last.as_str(), names));
        let not_a_number = |wanted| malformed(SelectionError::Number { what, found: last.to_owned(), wanted });
        let number = number(last).map_err(not_a_number)?;
        if names.is_empty() {
            return Err(malformed(SelectionError::NoSheep { what, found: last.to_owned() }));
        }
        let selector = |name: &String| Selector::parse(name).map_err(|error| malformed(SelectionError::Word(error)));
        Ok((names.iter().map(selector).collect::<Result<_, _>>()?, number))
    }
}

fn malformed(error: impl std::error::Error + 'static) -> Fatal {
    Fatal::new(Exit::Malformed, error)
}
