//! What to do about ids that no sheep of a flock has.
//!
//! Owns the proposals. Never changes a flock.

use diagnostics::did_you_mean;
use flock::{Manifest, SheepId};

/// The most sheep that are all named where none is similar.
const FEW: usize = 8;

/// What to do about `id`, which no sheep of `manifest` has.
pub fn unknown(id: &SheepId, manifest: &Manifest) -> String {
    let ids = || manifest.sheep.iter().map(|sheep| sheep.id.as_str());
    if let Some(question) = did_you_mean(id.as_str(), ids()) {
        return question;
    }
    match manifest.sheep.len() {
        0 => "it has no sheep yet; `dreams add` puts them in".to_owned(),
        1..=FEW => format!("it has {}", ids().map(|id| format!("`{id}`")).collect::<Vec<_>>().join(", ")),
        _ => "`dreams list` names its sheep".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const HEAD: &str = "format = 1\nname = \"x\"\nsize = [64, 64]\nfps = [30, 1]\n";

    #[test]
    fn an_id_that_no_sheep_has_is_answered_with_those_that_it_may_be() {
        let hint = |ids: &[&str]| {
            let sheep: Vec<_> = ids.iter().map(|id| format!("[[sheep]]\nid = \"{id}\"\n")).collect();
            let sheep = sheep.concat();
            unknown(
                &SheepId::new("orchad").unwrap(),
                &Manifest::parse(&format!("{HEAD}{sheep}"), Path::new("x")).unwrap(),
            )
        };
        assert_eq!(hint(&["rose", "orchid"]), "did you mean `orchid`?");
        assert_eq!(hint(&["rose", "fern"]), "it has `rose`, `fern`");
        assert_eq!(hint(&["a1", "a2", "a3", "a4", "a5", "a6", "a7", "a8", "a9"]), "`dreams list` names its sheep");
    }
}
