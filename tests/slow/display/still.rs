//! The still picture, for a unit whose player does not run.
//!
//! Owns the claim that it is held on a display, late or not. systemd starts it: `it/house/units.rs` checks when.

use crate::guest::{script, shell_words, succeed_in_virtual_time, word};
use claims::player_run::VKMS;
use claims::programs::{self, claims_folder};
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
