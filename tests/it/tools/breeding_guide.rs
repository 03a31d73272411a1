//! The guide from votes to the next flock does what it shows.
//!
//! Owns the claim that its commands print what stands below them, with a real player and a real `dreams-votes` on the way:
//! the flock that is elected is played, a button is pressed, and what the unit reports is taken in; then a real
//! `dreams-update` takes the next flock from where it was published, and that one is played.

use crate::tools::tutorial::{follow_steps, steps};
use claims::flocks::Flock;
use claims::player_run::PlayerRun;
use claims::programs::{self, repository, succeed};
use claims::voting::{UP, Voting};
use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::process::Command;

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
    is_taken_and_played(folder);
}

/// The unit takes the second edition, and plays the clips that the artist's tools foretell.
fn is_taken_and_played(folder: &Path) {
    fs::create_dir(folder.join("keys")).unwrap();
    fs::copy(folder.join("artist.pub"), folder.join("keys/artist.pub")).unwrap();
    let mut update = Command::new(programs::updater());
    update.arg("--keys").arg(folder.join("keys")).args(["--unit", "lobby", "--store"]).arg(folder.join("store"));
    succeed(update.arg(folder.join("outbox")));
    let seed = ["--seed", "7"];
    let mut walk = Command::new(programs::dreams());
    let walked = succeed(walk.arg("walk").arg(folder.join("lobby")).args(seed).args(["--steps", "8"]));
    let walked = String::from_utf8(walked).unwrap();
    let clips: Vec<&str> = walked.lines().collect();
    let options = ["--screen", "virtual", "--clock", "free", "--clips", &clips.len().to_string()];
    let run = PlayerRun::of(&folder.join("store/current")).with(&seed).with(&options);
    succeed(&mut run.command());
    let trace = run.trace();
    let begun = trace.flips.iter().filter(|flip| flip.frame == 0).map(|flip| &*flip.clip);
    assert_eq!((trace.faults.len(), begun.collect::<Vec<_>>()), (0, clips), "{:?}", trace.faults);
}
