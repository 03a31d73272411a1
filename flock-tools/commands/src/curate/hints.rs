//! What to do about an edit that was refused.
//!
//! Owns the hints for the errors of edits. Never edits.

use flock::{EditError, Manifest, SheepId};
use operations::flock_folder::ids;
use operations::program::{Exit, Fatal};

/// The most transitions of a sheep that are all named.
const MOST_NAMED: usize = 8;

/// Ends a command because of `error`, with what to do about it in the flock of `manifest`.
pub(super) fn refused(error: EditError, manifest: &Manifest) -> Fatal {
    let hint = hint(&error, manifest);
    let fatal = Fatal::new(Exit::Malformed, error);
    if let Some(hint) = hint { fatal.hint(hint) } else { fatal }
}

fn hint(error: &EditError, manifest: &Manifest) -> Option<String> {
    match error {
        EditError::DuplicateSheep { id } => Some(format!(
            "`dreams want DIR {id} WANT` sets how often it is wished; `dreams drop DIR {id}` takes it out"
        )),
        EditError::DuplicateTransition { from, to } => Some(format!(
            "`dreams weight DIR {from} {to} WEIGHT` sets how readily it is taken; `dreams unlink DIR {from} {to}` takes it \
             out"
        )),
        EditError::Number { .. } | EditError::Repeat { .. } => None,
        EditError::UnknownSheep { id } => Some(ids::unknown(id, manifest)),
        EditError::UnknownTransition { from, to } => {
            let is_there = |id: &SheepId| manifest.sheep.iter().any(|sheep| sheep.id == *id);
            if let Some(unknown) = [from, to].into_iter().find(|id| !is_there(id)) {
                return Some(format!("`{unknown}` is not in the flock: {}", ids::unknown(unknown, manifest)));
            }
            let leads = manifest.transitions.iter().filter(|transition| transition.from == *from);
            let leads: Vec<String> = leads.map(|transition| format!("`{}`", transition.to)).collect();
            match leads.len() {
                0 => Some(format!("`{from}` leads nowhere yet")),
                1..=MOST_NAMED => Some(format!("`{from}` leads to {}", leads.join(", "))),
                count => Some(format!("`{from}` leads to {count} others")),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn a_transition_that_is_not_there_is_answered_with_those_that_are() {
        let mut text = "format = 1\nname = \"x\"\nsize = [64, 64]\nfps = [30, 1]\n".to_owned();
        for id in ["ram", "ewe", "kid"] {
            text = format!("{text}[[sheep]]\nid = \"{id}\"\n");
        }
        text += "[[transition]]\nfrom = \"ram\"\nto = \"ewe\"\nframes = 1\nclip = \"x\"\n";
        let manifest = Manifest::parse(&text, Path::new("flock.toml")).unwrap();
        let id = |text| SheepId::new(text).unwrap();
        let unknown = |from, to| EditError::UnknownTransition { from: id(from), to: id(to) };
        let hint = |error| hint(&error, &manifest).unwrap();
        assert_eq!(hint(unknown("ram", "kid")), "`ram` leads to `ewe`");
        assert_eq!(hint(unknown("kid", "ram")), "`kid` leads nowhere yet");
        assert_eq!(hint(unknown("ram", "kit")), "`kit` is not in the flock: did you mean `kid`?");
        let twice = hint(EditError::DuplicateTransition { from: id("ram"), to: id("ewe") });
        assert!(twice.starts_with("`dreams weight DIR ram ewe WEIGHT`"), "{twice}");
    }
}
