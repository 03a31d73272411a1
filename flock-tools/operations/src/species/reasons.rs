//! What of genomes is not drawn.
//!
//! Owns its form in answers, and the way to it from a genome of any species and from an error. `flame` makes the list; other
//! species draw all that they read.
//!
//! Start at [`undrawn`].

use std::error::Error;
use std::iter;
use std::path::Path;

use flame::genome::{Reason, Reasons, Unsupported};
use flame::{Flame, RenderError};
use serde::{Serialize, Serializer};
use species::Genome;

/// A reason in an answer.
#[derive(Serialize)]
struct ReasonAnswer<'r> {
    place: &'r str,
    name: &'r str,
    value: &'r str,
    why: &'static str,
}

impl<'r> ReasonAnswer<'r> {
    fn of(reason: &'r Reason) -> Self {
        let Reason { place, name, value, why } = reason;
        Self { place, name, value, why: why.word() }
    }
}

/// Writes `reasons` as an answer has them: a list of objects with `place`, `name`, `value`, and `why` in one word.
pub fn serialize<S: Serializer>(reasons: &Reasons, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(reasons.0.iter().map(ReasonAnswer::of))
}

/// What of `genome` is not drawn.
pub fn undrawn(genome: &dyn Genome) -> Unsupported {
    genome.as_any().downcast_ref::<Flame>().map(|flame| flame.genome().unsupported()).unwrap_or_default()
}

/// What of the genome in `text`, which is that of the file at `path`, is not drawn; nothing if it is no genome. The colours that
/// a flame only names need not be at hand.
pub fn of_text(path: &Path, text: &str) -> Unsupported {
    super::without_colours(path, text).map(|genome| undrawn(&*genome)).unwrap_or_default()
}

/// Why a genome is refused, in words that say what is not drawn.
pub fn refusal(reasons: &Reasons) -> String {
    RenderError::Unsupported { reasons: reasons.clone() }.to_string()
}

/// The reasons for which `error`, or one of its causes, refuses a genome.
pub fn reasons_of<'e>(error: &'e (dyn Error + 'static)) -> Option<&'e Reasons> {
    let all = iter::successors(Some(error), |error| (*error).source());
    let flames_own = |error: &'e (dyn Error + 'static)| match error.downcast_ref::<species::RenderError>() {
        Some(species::RenderError::Refused(refusal)) => refusal.downcast_ref::<RenderError>(),
        Some(species::RenderError::Stopped) => None,
        None => error.downcast_ref::<RenderError>(),
    };
    all.filter_map(flames_own)
        .find_map(|error| if let RenderError::Unsupported { reasons } = error { Some(reasons) } else { None })
}
