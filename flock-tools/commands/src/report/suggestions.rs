//! Transitions that are worth adding, with their costs.
//!
//! Owns this part of the page's document, and the default number of transitions. The flock crate chooses them;
//! `render/cost.rs` of `operations` estimates the cost. Nothing is measured, so that the same flock gives the same page.
//!
//! Start at [`SuggestionList::of`].

use std::path::Path;

use flock::{Flock, SheepId, Suggestion, Terms};
use operations::render::cost::{self, Cost};

/// The default number of transitions.
pub(super) const USUAL: usize = 5;
/// With more sheep the default is 0: the search would take as long as all the rest of the page.
pub(super) const MOST_SHEEP: usize = 200;

/// The transitions, each the best one after those before it.
#[derive(Debug, serde::Serialize)]
pub(super) struct SuggestionList(Vec<TransitionAdvice>);

#[derive(Debug, serde::Serialize)]
struct TransitionAdvice {
    /// By their indices on the page.
    from: usize,
    to: usize,
    /// The balance's with this and those before it; `None` while a sheep is never shown.
    worst_ratio: Option<f64>,
    #[serde(flatten)]
    cost: Cost,
}

impl SuggestionList {
    /// Up to `count` transitions, or the default number; their costs beyond their length are estimated from the files in
    /// `folder`. `None` if the number is 0.
    pub(super) fn of(flock: &Flock, folder: Option<&Path>, terms: Terms, count: Option<usize>) -> Option<Self> {
        let usual = if flock.whole().len() <= MOST_SHEEP { USUAL } else { 0 };
        let count = count.unwrap_or(usual);
        let add = (count > 0).then(|| Suggestion::to_add(flock, terms, count)).flatten()?;
        let costs = match folder {
            Some(folder) => cost::without_measurement(&add, flock, folder),
            None => add.iter().map(|add| cost::plain(add, flock)).collect(),
        };
        let place = |id: &SheepId| flock.whole().find(id).map(flock::SheepIx::index);
        let advised = |(add, cost): (&Suggestion, Cost)| {
            let worst_ratio = add.worst(terms.by);
            Some(TransitionAdvice { from: place(&add.from)?, to: place(&add.to)?, worst_ratio, cost })
        };
        Some(Self(add.iter().zip(costs).filter_map(advised).collect()))
    }
}
