//! The guide from votes to the next flock does what it shows.
//!
//! Owns the claim that its commands print what stands below them, with a real player and a real `dreams-votes` on the way:
//! the flock that is elected is played, a button is pressed, and what the unit reports is taken in.

use crate::flocks::Flock;
use crate::player::votes::{UP, Voting};
use crate::programs::repository;
use crate::tools::tutorial::{follow_steps, steps};
use std::collections::HashMap;
use std::fs;

/// Where the unit's part is over, and the artist's goes on.
const TAKES_IN: &str = "dreams votes ";
/// Presses, and flips between two of them: more than a showing has.
const PRESSES: usize = 6;
const BETWEEN: usize = 60;

#[test]
fn from_votes_to_the_next_flock_is_what_the_guide_shows() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let steps = steps(&fs::read_to_string(repository().join("docs/breeding.md")).unwrap());
    let on_the_wall = steps.iter().position(|step| step.command.starts_with(TAKES_IN)).expect("votes are taken in");
    follow_steps(&steps[..on_the_wall], folder);

    let mut voting = Voting::beside(Flock { folder: folder.join("lobby"), shows: HashMap::new() });
    for _ in 0..PRESSES {
        voting.watch(BETWEEN);
        voting.press(UP);
    }
    // The last showing has to be over.
    voting.watch(4 * BETWEEN);
    let told = voting.shown();
    let sum =
        |kind: &str| told["sheep"].as_object().unwrap().values().map(|it| it[kind].as_u64().unwrap()).sum::<u64>();
    assert!(sum("up") >= 1 && sum("shown") >= sum("up"), "{told}");
    voting.end();
    fs::write(folder.join("votes.json"), told.to_string()).unwrap();

    follow_steps(&steps[on_the_wall..], folder);
}
