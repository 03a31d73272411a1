//! The species.
//!
//! Owns the one list of them: a new species is a line here. What is in a file, its first bytes tell, and its ending where they
//! do not. `text.rs` makes text of their bytes, `palettes.rs` finds the colours that flames only name, `reasons.rs` says what
//! of a genome is not drawn.
//!
//! Start at [`read`].

pub mod palettes;
pub mod reasons;
mod text;

use std::error::Error;
use std::ffi::OsStr;
use std::path::Path;

use agents::Agents;
use expression::Expressions;
use flame::{Backend, Flames, GenomeError};
use plant::Plants;
use species::{Breed, Genome, Lineage, Refusal, Species};

use crate::program::Exit;
use palettes::{PaletteError, coloured};
pub use text::{TextError, text};

/// All species, which can be rendered and bred. `backend` draws the samples of those that have noise.
pub fn all(backend: &Backend) -> [Box<dyn Breed>; 4] {
    list(Flames { backend: backend.clone(), coloured: |genome| coloured(genome).map_err(Refusal::from) })
}

fn list(flames: Flames) -> [Box<dyn Breed>; 4] {
    [Box::new(flames), Box::new(Expressions), Box::new(Agents), Box::new(Plants)]
}

/// A file without a genome that can be drawn.
#[derive(Debug)]
pub struct Refused {
    /// With which status a command ends.
    pub exit: Exit,
    /// Why.
    pub source: Box<dyn Error>,
    /// What to do about it.
    pub hint: Option<&'static str>,
}

/// The genome in the file at `path`.
pub fn read(path: &Path, backend: &Backend) -> Result<Box<dyn Genome>, Refused> {
    parse(path, &text(path)?, backend)
}

/// The genome in `text`, which is that of the file at `path`.
pub fn parse(path: &Path, text: &str, backend: &Backend) -> Result<Box<dyn Genome>, Refused> {
    let all = all(backend);
    of_text(&all, path, text).parse(text).map_err(|source| {
        let lacks_palette = source.downcast_ref::<PaletteError>().is_some();
        let several = matches!(source.downcast_ref(), Some(GenomeError::Count { found }) if *found > 1);
        Refused {
            exit: if lacks_palette { Exit::Unreadable } else { Exit::Malformed },
            source,
            hint: several.then_some("`dreams import` takes files with several flames"),
        }
    })
}

/// What the genome in `text`, which is that of the file at `path`, says of its origin; `None` if it is no genome. The colours
/// that a flame only names need not be at hand.
pub fn lineage(path: &Path, text: &str) -> Option<Lineage> {
    Some(without_colours(path, text).ok()?.lineage())
}

/// The genome in `text`, which is that of the file at `path`, without the colours that a flame only names.
fn without_colours(path: &Path, text: &str) -> Result<Box<dyn Genome>, Refusal> {
    let all = list(Flames { backend: Backend::default(), coloured: Ok });
    of_text(&all, path, text).parse(text)
}

/// Whether `text`, which is that of the file at `path`, is of flames: only those have files with more than one genome.
pub fn is_of_flames(path: &Path, text: &str) -> bool {
    ending(path, text) == endings()[0]
}

/// The ending that a file of `text` should have, which is that of the file at `path`.
pub fn ending(path: &Path, text: &str) -> &'static str {
    of_text(&all(&Backend::default()), path, text).ending()
}

/// The endings of files with genomes, without the dot.
pub fn endings() -> Vec<&'static str> {
    all(&Backend::default()).iter().map(|species| species.ending()).collect()
}

/// The species of `text`, which is that of the file at `path`. What nothing is known of is taken for a flame.
fn of_text<'a>(all: &'a [Box<dyn Breed>], path: &Path, text: &str) -> &'a dyn Species {
    let ending = path.extension().and_then(OsStr::to_str).unwrap_or_default();
    let begun = all.iter().find(|species| species.begins(text));
    let named = || all.iter().find(|species| species.ending().eq_ignore_ascii_case(ending));
    &**begun.or_else(named).unwrap_or(&all[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_bytes_tell_what_a_file_is_and_its_ending_where_they_do_not() {
        let all = all(&Backend::default());
        let of = |path: &str, text: &str| of_text(&all, Path::new(path), text).ending();
        assert_eq!(of("a.flam3", "<flame/>"), "flam3");
        assert_eq!(of("a.expr", " <flame/>"), "flam3", "an ending that lies");
        assert_eq!(of("a.flam3", "\n(expression 1 (picture x))"), "expr", "an ending that lies");
        assert_eq!([of("a.EXPR", "?"), of("a.txt", "?"), of("a", "")], ["expr", "flam3", "flam3"]);
        let mut endings = endings();
        endings.sort_unstable();
        endings.dedup();
        assert_eq!(endings.len(), all.len());
    }
}
