//! Why genomes are refused, as answers have it.
//!
//! Owns the form of reasons in JSON, and the way to them from an error. `flame` makes the list of a genome.
//!
//! Start at [`reasons_of`].

use std::error::Error;
use std::iter;

use flame::RenderError;
use flame::genome::{Reason, Reasons};
use serde::{Serialize, Serializer};

/// A reason in an answer.
#[derive(Serialize)]
struct ReasonAnswer<'r> {
    place: &'r str,
    name: &'r str,
    value: &'r str,
    /// Of an unknown parameter.
    #[serde(skip_serializing_if = "Option::is_none")]
    variation: Option<&'r str>,
    why: &'static str,
}

impl<'r> ReasonAnswer<'r> {
    fn of(reason: &'r Reason) -> Self {
        let Reason { place, name, value, variation, why } = reason;
        Self { place, name, value, variation: variation.as_deref(), why: why.word() }
    }
}

/// Writes `reasons` as an answer has them: a list of objects with `place`, `name`, `value`, and `why` in one word.
pub fn serialize<S: Serializer>(reasons: &Reasons, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(reasons.0.iter().map(ReasonAnswer::of))
}

/// The reasons for which `error`, or one of its causes, refuses a genome.
pub fn reasons_of<'e>(error: &'e (dyn Error + 'static)) -> Option<&'e Reasons> {
    let all = iter::successors(Some(error), |error| (*error).source());
    let flames_own = |error: &'e (dyn Error + 'static)| match error.downcast_ref::<species::RenderError>() {
        Some(species::RenderError::Refused(refusal)) => refusal.downcast_ref::<RenderError>(),
        Some(species::RenderError::Stopped) => None,
        None => error.downcast_ref::<RenderError>(),
    };
    all.filter_map(flames_own).find_map(|error| {
        let RenderError::Unsupported { reasons } = error else { return None };
        Some(reasons)
    })
}
