//! Transitions that are worth adding, with what they cost.
//!
//! Owns the form in which the page tells them, and up to which size of flock they are looked for unasked. The choice is
//! the flock crate's, the cost `balance/cost.rs`'s. Nothing is measured, so that the same flock gives the same page.
//!
//! Start at [`Suggested::of`].

use std::path::Path;

use flock::{Flock, SheepId, Suggestion, Terms};

use crate::balance::cost::{self, Cost};

/// How many are told, unless somebody says.
pub(super) const USUAL: usize = 5;
/// Above so many sheep none, unless somebody says: the search would take as long as all the rest of the page.
pub(super) const MOST_SHEEP: usize = 200;

/// The transitions, each the best one after those before it.
#[derive(Debug, serde::Serialize)]
pub(super) struct Suggested(Vec<Advised>);

#[derive(Debug, serde::Serialize)]
struct Advised {
    /// By their places on the page.
    from: usize,
    to: usize,
    /// The balance's with this and those before it; `None` while a sheep is never shown.
    worst_ratio: Option<f64>,
    #[serde(flatten)]
    cost: Cost,
}

impl Suggested {
    /// Up to `count` transitions, or as many as is usual for `flock`; `folder` is looked at for what they cost beyond
    /// their length. `None` if none were looked for.
    pub(super) fn of(flock: &Flock, folder: Option<&Path>, count: Option<usize>) -> Option<Self> {
        let usual = if flock.whole().len() <= MOST_SHEEP { USUAL } else { 0 };
        let count = count.unwrap_or(usual);
        let add = (count > 0).then(|| Suggestion::to_add(flock, Terms::default(), count)).flatten()?;
        let costs = match folder {
            Some(folder) => cost::without_measurement(&add, flock, folder),
            None => add.iter().map(|add| cost::plain(add, flock)).collect(),
        };
        let place = |id: &SheepId| flock.whole().find(id).map(flock::SheepIx::index);
        let advised = |(add, cost): (&Suggestion, Cost)| {
            Some(Advised { from: place(&add.from)?, to: place(&add.to)?, worst_ratio: add.worst_ratio, cost })
        };
        Some(Self(add.iter().zip(costs).filter_map(advised).collect()))
    }
}
