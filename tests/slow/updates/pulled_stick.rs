//! A stick is unplugged while it is read, again and again.
//!
//! Owns the claim that the update continues where it was. The stick is a network block device of a guest with virtual
//! time; `pulled_stick.py` serves it and disconnects. Reads that only fail are in `interruptions.rs`.

use crate::guest::{script, succeed_in_virtual_time, word};
use claims::bundle_maker::{BundleMaker, files_in, rubbish};
use claims::programs::{claims_folder, repository, succeed, updater};
use serde_json::Value;
use std::fs::{self, File};
use std::process::Command;

/// The number of times, and the bytes read before each: the seal and the list, and a little of the flock.
const PULLS: usize = 100;
const GIVEN: usize = 72_000;
/// The flock, which needs a little more than that.
const CLIPS: usize = 40;
const CLIP_BYTES: usize = 72_000;
/// The bytes of the stick, and the number of network block devices of a guest.
const STICK: u64 = 8 << 20;
const DEVICES: usize = 16;

/// The number after `key` in an updater's log or answer.
fn figure(said: &str, key: &str) -> Option<u64> {
    let behind = said.split(key).nth(1)?.trim_start_matches(['"', '=', ':', ' ']);
    behind[..behind.find(|c: char| !c.is_ascii_digit())?].parse().ok()
}

#[test]
fn a_stick_pulled_a_hundred_times_is_read_on_from_where_it_was_and_no_byte_twice() {
    let folder = tempfile::tempdir_in(claims_folder()).unwrap();
    let at = |name: &str| folder.path().join(name);
    let (maker, files) = (BundleMaker::with_new_keys(), rubbish(CLIPS, CLIP_BYTES, 0));
    maker.bundle(&at("bundle"), &files, &[], 1);
    fs::rename(maker.keys(), at("keys")).unwrap();
    File::create(at("stick")).unwrap().set_len(STICK).unwrap();
    // Without the file of orphans, which newer releases make, and a mount reads to its end each time.
    let layout = ["-q", "-t", "ext4", "-O", "^orphan_file", "-d"];
    succeed(Command::new("mke2fs").args(layout).args([at("bundle"), at("stick")]));
    let text = format!(
        "mkdir /tmp/stick\n\
         /usr/bin/python3 {pulling} {DEVICES} {stick} {GIVEN} {PULLS} bash -c 'rm -f /tmp/notice; \"$@\"; status=$?; \
         echo; cat /tmp/notice; exit $status' update {updater} --unit lobby --store /tmp/store --keys {keys} \
         --notice /tmp/notice --json /tmp/stick\n\
         rm -r {plays}; cp -r /tmp/store/current/ {plays}",
        pulling = word(&repository().join("tests/it/updates/pulled_stick.py")),
        stick = word(&at("stick")),
        updater = word(&updater()),
        keys = word(&at("keys")),
        plays = word(&at("bundle")),
    );
    let console = succeed_in_virtual_time(300, &script(&text));

    let attempts: Vec<Value> = console.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    assert_eq!(attempts.len(), PULLS + 1, "{console}");
    let mut fetched = 0;
    for (number, attempt) in attempts.iter().enumerate() {
        let said = attempt["said"].as_str().unwrap();
        let is_last = number == PULLS;
        assert_eq!(attempt["status"], if is_last { 0 } else { 3 }, "{number}: {said}");
        let told = if is_last {
            "The new flock is here. You may remove the stick."
        } else {
            "The stick could not be read to its end. Put it in again, and the rest follows."
        };
        assert!(said.contains(told), "{number}: {said}");
        fetched +=
            figure(said, "fetched_bytes").unwrap_or_else(|| panic!("attempt {number} brings nothing: {attempt}"));
    }
    assert_eq!(files_in(&at("bundle")).unwrap(), files, "what plays then");
    let content: usize = files.values().map(Vec::len).sum();
    assert_eq!(fetched, content as u64, "no byte was fetched twice");
}
