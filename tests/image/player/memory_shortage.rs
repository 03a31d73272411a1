//! A program that uses up all memory.
//!
//! Owns the claims that the player's memory, with the files that the prelude read, stays in memory, and that its
//! protection is the reason.

use crate::machine::picture::only_art;
use crate::machine::{Machine, PAUSE};
use crate::starts::first_start::{OFTEN, playing_unit};

const SLICE: &str = "/sys/fs/cgroup/dreams.slice";
/// Uses memory until the kernel kills it.
const HOG: &str = "systemd-run --wait --quiet --property=OOMScoreAdjust=1000 tail /dev/zero; \
    dmesg | grep -q 'Out of memory: Killed process .* (tail)' && dmesg --clear";

/// A number of the slice, on a line of its own or after `key`.
fn read(machine: &mut Machine, file: &str, key: &str) -> u64 {
    let told = machine.run(&format!("sed -n 's/^{key}\\([0-9]*\\)$/\\1/p' {SLICE}/{file}"));
    told.trim().parse().unwrap_or_else(|_| panic!("{file} has a number behind `{key}`, found `{told}`"))
}

#[test]
fn a_program_that_takes_all_memory_takes_none_of_the_pictures() {
    let (_unit, mut machine) = playing_unit().snapshot.wake();
    for file in ["memory.min", "dreams-player.service/memory.min"] {
        assert_eq!(read(&mut machine, file, ""), 256 << 20, "{file}");
    }
    // The player's program and its libraries were read by the prelude, before systemd: they are charged here all the same.
    let programs = read(&mut machine, "memory.stat", "file ");
    assert!(programs > 16 << 20, "the slice has {programs} bytes of files");

    let looks = machine.watch_while(PAUSE, HOG);
    only_art(&looks, OFTEN);
    let read_again = read(&mut machine, "memory.stat", "workingset_refault_file ");
    assert_eq!(read_again, 0, "pages of the picture's files had to be read again");

    // The same without protection.
    machine.run(&format!("echo 0 > {SLICE}/memory.min && echo 0 > {SLICE}/dreams-player.service/memory.min"));
    machine.run(HOG);
    let read_again = read(&mut machine, "memory.stat", "workingset_refault_file ");
    assert!(read_again > 0, "without protection, pages have to be read again");
}
