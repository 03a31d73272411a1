//! What a unit shows without a player or without a flock of its own.
//!
//! Owns the claims on the still picture, and on the flock that stands in. systemd starts the still picture:
//! `house/units.rs` checks when.

use crate::flocks::SMALL;
use crate::guest::{script, shell_words, succeed_in_virtual_time, word};
use crate::player::flock_switch::{await_joins, edition, played};
use crate::player_run::{PlayerRun, VKMS};
use crate::programs::{self, claims_folder};
use crate::updates::sticks::Unit;
use rustix::process::Signal;
use std::collections::BTreeSet;
use std::fs;
use std::process::Command;

#[test]
fn a_still_picture_is_held_on_a_display_that_comes_late_and_ends_when_it_is_told() {
    let scratch = tempfile::tempdir_in(claims_folder()).unwrap();
    let list = scratch.path().join("scanned-out");
    let mut still = Command::new(programs::player());
    still.args(["--still", "--screen", VKMS]);
    let crc = "/sys/kernel/debug/dri/vkms/crtc-0/crc";
    let text = format!(
        "mv /dev/dri /dev/away; {still} & sleep 10; mv /dev/away /dev/dri; sleep 5; echo auto > {crc}/control; \
         head -n 20 {crc}/data > {list}; kill %1; wait %1",
        still = shell_words(&still),
        list = word(&list)
    );
    succeed_in_virtual_time(120, &script(&text));
    let text = fs::read_to_string(list).unwrap();
    let pictures: BTreeSet<_> = text.lines().filter_map(|line| line.split_once(' ')).map(|(_, crc)| crc).collect();
    assert_eq!(pictures.len(), 1, "twenty vblanks show one picture: {text}");
}

#[test]
fn another_flock_stands_in_until_the_units_own_can_be_read() {
    let flock = SMALL.flock();
    let unit = Unit::new();
    for (name, bytes) in edition(&flock, "spare") {
        let path = unit.path("spare").join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    let (own, spare) = (unit.path("store/current"), unit.path("spare"));
    let free = ["--screen", "virtual", "--clock", "free", "--hash", "--status", "off", "--seed", "5", "--spare"];
    let playing = PlayerRun::of(&own).with(&free).with(&[spare.to_str().unwrap()]);
    let mut running = playing.start();
    await_joins(&mut running, 10);
    unit.maker.bundle(&unit.stick(), &edition(&flock, "own"), &[], 1);
    unit.updated(&[]);
    running.await_line_with("own/");
    await_joins(&mut running, 10);
    running.signal(Signal::TERM);
    let (code, trace) = running.end_within(10);
    assert_eq!((code, trace.faults.len()), (Some(0), 0));
    let editions: Vec<_> = played(&flock, &trace).into_iter().map(|(edition, _)| edition).collect();
    let own = editions.iter().position(|edition| *edition == "own").expect("the path went over");
    assert!(own >= 10 && editions[own..].iter().all(|edition| *edition == "own"), "{editions:?}");

    fs::remove_file(unit.path("store/current")).unwrap();
    fs::create_dir(unit.path("store/current")).unwrap();
    fs::write(unit.path("store/current/flock.toml"), "rubbish").unwrap();
    let mut running = playing.start();
    await_joins(&mut running, 10);
    running.signal(Signal::TERM);
    let (code, trace) = running.end_within(10);
    assert_eq!(code, Some(0));
    assert!(played(&flock, &trace).iter().all(|(edition, _)| *edition == "spare"), "what is rubbish is not played");
}
