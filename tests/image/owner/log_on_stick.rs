//! A stick that asks for the unit's log.
//!
//! Owns the claims on it: the file that asks, what is written then, and that nothing else is written.

use crate::machine::picture::only_art;
use crate::machine::{Machine, PAUSE};
use crate::owner::settings_error::has_notice;
use crate::starts::first_start::{OFTEN, playing_unit};
use crate::unit::stick::exfat;
use claims::programs::{output, succeed};
use std::fs;
use std::path::Path;
use std::process::Command;

/// For the unit's shell: waits until it is done with the stick, and prints the result.
const IS_THROUGH: &str = "until \
    [ $(systemctl list-units --all --plain --no-legend 'dreams-[us]*@sda.service' | grep -c exited) = 2 ] && \
    [ -z \"$(systemctl list-jobs --plain --no-legend | grep dreams-log)\" ]; do sleep 1; done";

/// An empty stick with this file on it.
fn stick(path: &Path, file: &str) {
    fs::File::create(path).unwrap().set_len(64 << 20).unwrap();
    succeed(Command::new("mkfs.vfat").args(["-F", "32"]).arg(path));
    let empty = path.with_extension("empty");
    fs::write(&empty, "").unwrap();
    succeed(Command::new("mcopy").arg("-i").arg(path).arg(&empty).arg(format!("::{file}")));
}

/// The same with exFAT, on which the file is not empty.
fn exfat_stick(path: &Path, file: &str) {
    let folder = path.with_extension("files");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join(file), "please").unwrap();
    exfat::make(path, 64 << 20, &folder);
}

/// Has the unit see the stick, until it is done with it, and pulls it. Returns whether there was a notice.
fn show(machine: &mut Machine, stick: &Path) -> bool {
    machine.plug_to_write(stick);
    let mut looks = machine.watch_while(PAUSE, IS_THROUGH);
    looks.extend(machine.watch_move(PAUSE, 5));
    only_art(&looks, OFTEN);
    machine.run("! grep /run/dreams-mounts/ /proc/mounts");
    machine.pull();
    machine.take_stick();
    looks.iter().any(has_notice)
}

/// The files on the stick after it was in the unit, and whether there was a notice.
fn put_in(machine: &mut Machine, stick: &Path) -> (Vec<String>, bool) {
    let is_told = show(machine, stick);
    // A file system that was not closed says so.
    assert_eq!(output(Command::new("fsck.vfat").arg("-n").arg(stick)).status.code(), Some(0), "it is whole");
    let listed = output(Command::new("mdir").args(["-b", "-i"]).arg(stick));
    let mut names: Vec<_> = String::from_utf8(listed.stdout).unwrap().lines().map(str::to_owned).collect();
    names.sort();
    (names, is_told)
}

#[test]
fn a_stick_that_asks_for_the_log_gets_it_and_any_other_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let [asks, other, exfat] = ["asks.img", "other.img", "exfat.img"].map(|name| folder.path().join(name));
    stick(&asks, "dreams-log.txt");
    stick(&other, "holiday.jpg");
    exfat_stick(&exfat, "dreams-log");
    let before = fs::read(&other).unwrap();
    let (_unit, mut machine) = playing_unit().snapshot.wake();
    assert_eq!(put_in(&mut machine, &other), (vec!["::/holiday.jpg".to_owned()], false));
    assert!(fs::read(&other).unwrap() == before, "not a byte is written");

    machine.run("logger --tag=stranger \"$(printf 'a bell: \\a, and red: \\033[31m')\"");
    let (names, is_told) = put_in(&mut machine, &asks);
    let said = machine.run("journalctl --no-pager --quiet --unit=dreams-log@sda --output=cat");
    let [log, asked] = &names[..] else { panic!("{names:?}: {said}") };
    assert!(is_told, "that it may be removed: {said}");
    assert!(asked == "::/dreams-log.txt" && log.starts_with("::/dreams-log-lobby-"), "{names:?}");
    let read = succeed(Command::new("mtype").arg("-i").arg(&asks).arg(log));
    for wanted in ["ID=dreams", "dreams-player", "systemd", "a bell: , and red: [31m"] {
        assert!(String::from_utf8_lossy(&read).contains(wanted), "{wanted}: {}", String::from_utf8_lossy(&read));
    }
    assert!(read.iter().all(|byte| matches!(byte, b'\t' | b'\n' | b' '..=b'~')), "text, and nothing else");

    show(&mut machine, &exfat);
    succeed(Command::new("fsck.exfat").arg("-n").arg(&exfat));
    let bytes = fs::read(&exfat).unwrap();
    let contains = |part: &[u8]| bytes.windows(part.len()).any(|window| window == part);
    assert!(contains(&read[..read.iter().position(|byte| *byte == b'\n').unwrap()]), "how the other log begins");
    assert!(contains(b"a bell: , and red: [31m"), "what was logged");
    machine.is_well();
}
