//! An edit of a flock is killed.
//!
//! Owns the claim that the next edit removes what it left half-written, and nothing of the artist's.

use crate::syscall_faults::at_every_step;
use claims::bundle_maker::files_in;
use claims::flocks::SMALL;
use claims::programs::{self, succeed};
use std::fs;
use std::path::Path;
use std::process::Command;

/// The calls at which an edit writes.
const CHANGES: [&str; 5] = ["copy_file_range", "fsync", "rename", "unlink", "write"];
/// Files of the artist's own, which are called like those of a killed edit; sorted.
const OWN: [&str; 3] = ["loops/other.mp4.new", "loops/z9.mp4.new", "notes.new"];
const CREDITS: &str = "[[sheep]]\nid = \"s1\"\nlicence = \"CC0-1.0\"\nauthors = [\"Ada\"]\n";

/// Whether a file has the name of one that is not written to its end.
fn is_half_written(name: &str) -> bool {
    name.rsplit_once('.').is_some_and(|(_, ending)| ending == "new")
}

/// The names of the files in `flock` that no flock has.
fn left(flock: &Path) -> Vec<String> {
    let names = files_in(flock).unwrap().into_keys();
    names.filter(|name| is_half_written(name) || name.contains(".flock-edit")).collect()
}

#[test]
fn the_next_edit_removes_what_a_killed_one_left_and_no_file_of_the_artists() {
    let scratch = tempfile::tempdir().unwrap();
    let (flock, first) = (scratch.path().join("flock"), scratch.path().join("first"));
    succeed(Command::new("cp").arg("-r").arg(SMALL.flock().folder).arg(&first));
    fs::create_dir_all(first.join("loops")).unwrap();
    fs::write(first.join("credits.toml"), CREDITS).unwrap();
    for own in OWN {
        fs::write(first.join(own), own).unwrap();
    }
    let genome = scratch.path().join("waves.expr");
    fs::write(&genome, "(expression 1 (picture (+ 0.5 (* 0.3 (sin (+ (* 3 x) (wave 1 0)))))))").unwrap();
    let dreams = |words: &[&str]| {
        let mut dreams = Command::new(programs::dreams());
        dreams.args(&words[..1]).arg(&flock).args(&words[1..]);
        dreams
    };
    let genome = genome.to_str().unwrap();
    let mut was_left = 0;
    for words in [&["rename", "s1", "t1"][..], &["add", "t2", "--genome", genome, "--no-loop"]] {
        let prepare = || {
            fs::remove_dir_all(&flock).ok();
            succeed(Command::new("cp").arg("-r").arg(&first).arg(&flock));
            dreams(words)
        };
        let faults = at_every_step(&CHANGES, &scratch.path().join("calls"), prepare, |step| {
            was_left += left(&flock).iter().filter(|name| is_half_written(name)).count() - OWN.len();
            succeed(&mut dreams(&["want", "s0", "2"]));
            assert_eq!(left(&flock), OWN, "{words:?}, {step}");
        });
        assert!(faults >= 8, "{words:?}: {faults} faults");
    }
    assert!(was_left >= 8, "only {was_left} half-written files were left");
}
