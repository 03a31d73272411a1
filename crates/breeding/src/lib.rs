//! How a pool of sheep evolves by what people like: lineage, ratings, broods, deaths, editions.
//!
//! Owns the rules, as functions of settings and of the events of a ledger; and the folder that keeps both. The same ledger
//! and seed give the same brood, on any number of threads. Never knows a genome: a [`Nursery`] makes and draws candidates.
//! Never reads a clock: days are arguments.
//!
//! | file | what is there |
//! |---|---|
//! | `id.rs`, `event.rs`, `traits.rs` | the names of sheep, what happens, figures as numbers |
//! | `ledger.rs`, `settings.rs`, `folder.rs` | the files |
//! | `pool.rs`, `rating.rs`, `niches.rs`, `census.rs` | what follows from the events |
//! | `births.rs`, `screening.rs`, `lookalikes.rs`, `brood.rs` | a brood: its plan, the guess of what will be liked, who is too like another, its births |
//! | `deaths.rs`, `elect.rs` | who dies, who goes to a unit |
//!
//! Start at [`Folder`], or at [`breed`].
#![forbid(unsafe_code)]

mod births;
mod brood;
mod census;
mod chance;
mod deaths;
mod elect;
mod error;
mod event;
mod folder;
mod id;
mod ledger;
mod lookalikes;
mod niches;
mod pool;
mod rating;
mod screening;
mod settings;
mod traits;

pub use births::{Birth, Operation, Order, Plan, plan};
pub use brood::{Brood, Made, Nursery, Refused, breed};
pub use census::Census;
pub use deaths::{Deaths, deaths, foreseen};
pub use elect::{Ballot, Elected, Reason, elect};
pub use error::BreedingError;
pub use event::{Born, Day, Entry, Event, Mark, Stamp, Waiting};
pub use folder::Folder;
pub use id::{Id, IdError, Origin};
pub use ledger::{LEDGER, Ledger};
pub use lookalikes::{CLONE, Lookalikes};
pub use niches::{Niche, Niches};
pub use pool::{Edition, News, Pool, Sheep};
pub use rating::{Count, Tally, Votes};
pub use screening::Liking;
pub use settings::{LicencePolicy, SETTINGS, Settings};
pub use traits::{Point, Scale, Traits};

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use crate::Origin;
    use crate::births::{LEAST_PARENTS, MOST_CHILDREN, TOURNAMENT, UNKNOWN};
    use crate::brood::TRIES;
    use crate::census::JUDGED;
    use crate::deaths::{CROWD, GOOD, YOUNG};
    use crate::elect::{LEAST_NEWCOMERS, LIKENESS, MOST_OF_FAMILY, MOST_OF_NICHE, NEWCOMER};
    use crate::lookalikes::CLONES;
    use crate::screening::{LEAST_JUDGED, MOST_DEAD};
    use crate::settings::Settings;
    use crate::traits::LEAST_SCALED;

    const GUIDE: &str = include_str!("../../../docs/breeding.md");

    #[test]
    fn the_numbers_in_the_guide_are_those_of_the_code() {
        let (_, table) = GUIDE.split_once("\n## The numbers\n").unwrap();
        let row = |line: &str| {
            let mut cells = line.strip_prefix("| `")?.split('|').map(|cell| cell.trim().trim_matches('`').to_owned());
            Some((cells.next()?, cells.next()?.parse::<f64>().unwrap()))
        };
        let told: BTreeMap<String, f64> = table.lines().filter_map(row).collect();
        let settings = Settings::new("meadow", Origin::of_bits(1), 1, &["plant"]);
        let are = [
            ("limit", settings.limit as f64),
            ("births", settings.births as f64),
            ("crossings", settings.crossings),
            ("mutations", settings.mutations),
            ("rebirths", settings.rebirths),
            ("bins", settings.bins as f64),
            ("screening", settings.screening as f64),
            ("screened", settings.screened),
            ("half_life_days", settings.half_life_days),
            ("due_votes", settings.due_votes as f64),
            ("TOURNAMENT", TOURNAMENT as f64),
            ("MOST_CHILDREN", MOST_CHILDREN),
            ("LEAST_PARENTS", LEAST_PARENTS as f64),
            ("JUDGED", JUDGED),
            ("UNKNOWN", UNKNOWN),
            ("LEAST_JUDGED", LEAST_JUDGED as f64),
            ("MOST_DEAD", MOST_DEAD as f64),
            ("TRIES", TRIES as f64),
            ("CLONES", CLONES),
            ("LEAST_SCALED", LEAST_SCALED as f64),
            ("YOUNG", f64::from(YOUNG)),
            ("GOOD", GOOD),
            ("CROWD", CROWD),
            ("MOST_OF_NICHE", MOST_OF_NICHE as f64),
            ("MOST_OF_FAMILY", MOST_OF_FAMILY),
            ("LEAST_NEWCOMERS", LEAST_NEWCOMERS),
            ("NEWCOMER", NEWCOMER),
            ("LIKENESS", LIKENESS),
        ];
        assert_eq!(told, are.into_iter().map(|(name, value)| (name.to_owned(), value)).collect());
        assert!(table.contains(&format!("`due_showings`, {}", settings.due_showings)));
    }
}
