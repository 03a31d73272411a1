//! What of genomes is not drawn.
//!
//! Owns the way to it from a genome of any species. `flame` makes the list; other species draw all that they read.
//! `program::reasons` has its form in answers.
//!
//! Start at [`undrawn`].

use std::path::Path;

use flame::genome::{Reasons, Unsupported};
use flame::{Flame, RenderError};
use species::Genome;

use crate::program::chain;

/// What of `genome` is not drawn.
pub fn undrawn(genome: &dyn Genome) -> Unsupported {
    genome.as_any().downcast_ref::<Flame>().map(|flame| flame.genome().unsupported()).unwrap_or_default()
}

/// What of the genome in `text`, which is that of the file at `path`, is not drawn. The colours that a flame only names need
/// not be at hand.
/// Errors: In words, if it is no genome.
pub fn of_text(path: &Path, text: &str) -> Result<Unsupported, String> {
    super::without_colours(path, text).map(|genome| undrawn(&*genome)).map_err(|error| chain(&*error))
}

/// Why a genome is refused, in words that say what is not drawn.
pub fn refusal(reasons: &Reasons) -> String {
    RenderError::Unsupported { reasons: reasons.clone() }.to_string()
}
