//! Power cuts at the level of the disk's blocks.
//!
//! Owns the claim that the crash laboratory, `tests/crash`, finds no fault, and that it can find some.

use crate::guest::in_real_time;
use claims::programs;
use std::process::Command;

/// The number of different disks that are checked; `make crash` checks fifty times as many.
const STATES: u32 = 200;

#[test]
fn a_disk_that_loses_and_tears_what_was_not_flushed_leaves_a_whole_flock_and_the_update_completes() {
    let mut laboratory = Command::new(programs::laboratory());
    laboratory.arg(programs::updater()).arg(programs::owner()).arg(STATES.to_string());
    let said = in_real_time(900, &laboratory);
    let (found, error) = (String::from_utf8_lossy(&said.stdout), String::from_utf8_lossy(&said.stderr));
    assert!(said.status.success(), "{found}{error}");
    let whole = found.lines().filter(|line| line.ends_with(", 0 wrong"));
    let states = |line: &str| line.split([':', ' ']).find_map(|word| word.parse::<u32>().ok());
    assert!(whole.filter_map(states).sum::<u32>() >= STATES, "{found}");
    assert_eq!(found.matches("must be caught").count(), 4, "{found}");
}
