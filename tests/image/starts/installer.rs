//! The stick that installs a unit, in a whole machine.
//!
//! Owns the claim that nothing is written before Enter is pressed, and that the machine then starts from its own disk. The
//! cases in which there is something on the disk are in `tests/it/unit/installer.rs`.

use crate::machine::picture::only_art;
use crate::machine::{Machine, PAUSE, light_flock};
use crate::starts::first_start::{MOVES, OFTEN, PROVEN};
use crate::unit::Unit;
use claims::programs::{repository, succeed};
use std::fs::{self, File};
use std::os::unix::fs::{FileExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

const MIB: u64 = 1 << 20;
/// The luma of letters and of the ground, as the screen has them.
const LETTERS: std::ops::Range<u8> = 150..240;
/// A unit's partitions, in megabytes, as `image-build/disk.sfdisk` has them: of the slots until the spare one, and the length
/// of the boot partitions.
const SLOTS: u64 = 129;
const SPARE: u64 = 678;
const BOOT: u64 = 128;

/// The image of the stick.
fn image() -> PathBuf {
    let target = repository().join("target/image");
    let mut build = Command::new(repository().join("image-build/build"));
    build.arg(&target).args(["--profile", "bench", "--installer", "--flock"]).arg(light_flock());
    succeed(build.arg("--key").arg(repository().join("tests/fixtures/keys/artist.pub")));
    target.join(concat!("installer-bench-", env!("CARGO_PKG_VERSION"))).join("stick.img")
}

fn sum(file: &Path) -> Vec<u8> {
    succeed(Command::new("sha256sum").arg(file))
}

/// Whether these megabytes are the same in both files.
fn is_equal(one: (&Path, u64), other: (&Path, u64), mib: u64) -> bool {
    let [one, other] = [one, other].map(|(file, at)| (File::open(file).unwrap(), at));
    let read = |(file, at): &(File, u64), block: u64| {
        let mut bytes = vec![0; MIB as usize];
        file.read_exact_at(&mut bytes, (at + block) * MIB).unwrap();
        bytes
    };
    (0..mib).all(|block| read(&one, block) == read(&other, block))
}

/// Waits until the installer shows the page with this title; returns its text.
fn page(machine: &mut Machine, title: &str) -> String {
    let pages = "journalctl --boot --output=cat --unit=dreams-install";
    machine.watch_while(PAUSE, &format!("until {pages} | grep -q '^{title}: '; do sleep 1; done"));
    machine.run(&format!("{pages} | grep '^{title}: ' | tail -n 1"))
}

#[test]
fn a_stick_installs_a_unit_after_enter_and_never_before() {
    let unit = Unit::blank();
    let stick = unit.path("stick.img");
    succeed(Command::new("cp").arg("--sparse=always").args([&image(), &stick]));
    let before = sum(&stick);
    // The firmware finds nothing on the disk, and goes on to the stick.
    let words = [
        "-drive".to_owned(),
        format!("file={},if=none,id=image,format=raw", stick.display()),
        "-device".to_owned(),
        "usb-storage,id=stick,bus=xhci.0,drive=image,port=1".to_owned(),
    ];
    let mut machine = unit.start_with(&words);
    machine.await_shell();
    let text = page(&mut machine, "Install the picture");
    assert!(text.contains("(vda)") && text.contains("Everything on this disk will be lost."), "{text}");
    machine.watch_for(PAUSE, "large letters on a dark ground", |look| {
        look.other.is_some_and(|(_, brightest)| LETTERS.contains(&brightest))
    });
    machine.run("udevadm settle -t 240; ! grep ^/dev/sd /proc/mounts");
    machine.run(
        "! systemctl list-units --plain --no-legend 'dreams-*' | grep --invert-match 'dreams-\\(install\\|bench\\)[.]'",
    );
    // Long enough that Enter would count.
    machine.wait(Duration::from_secs(15));
    for key in ["spc", "delete", "1", "y"] {
        machine.press(&[key]);
    }
    machine.wait(Duration::from_secs(20));
    // It would check the stick first.
    machine.run("! journalctl --boot --output=cat --unit=dreams-install | grep '^Installing: '");
    assert_eq!(fs::metadata(unit.disk()).unwrap().blocks(), 0, "nothing is written without Enter");
    machine.press(&["ret"]);
    let text = page(&mut machine, "Installing");
    assert!(text.contains("(vda)"), "{text}");
    let text = page(&mut machine, "Installed");
    assert!(text.contains("Remove the stick; the picture starts."), "{text}");
    let disk = unit.disk();
    assert!(is_equal((&stick, SLOTS), (disk, SLOTS), SPARE + BOOT - SLOTS), "slots, settings and the spare partition");
    assert!(is_equal((&stick, SPARE), (disk, 1), BOOT), "what firmware starts");
    machine.pull();
    let mut looks = machine.await_shell();
    looks.extend(machine.watch_move(PAUSE, MOVES));
    looks.extend(machine.watch_while(PAUSE, PROVEN));
    let art: Vec<_> = looks.into_iter().skip_while(|look| !look.is_art()).collect();
    only_art(&art, OFTEN);
    machine.run("[ $(basename $(readlink -f /sys/class/block/dm-0/slaves/*/..)) = vda ] && ! grep -q dreams.install /proc/cmdline");
    machine.is_well();
    assert!(sum(&stick) == before, "the stick stays as it is");
}
