//! The first start of a unit: from power to the picture, and nothing else on the screen.
//!
//! Owns the claims on an undisturbed unit: what it shows, its size, its programs, its open ports. Hands a snapshot of
//! the unit that plays to the other claims.
//!
//! Start at [`playing_unit`].

use crate::machine::clock::now;
use crate::machine::open_ports::open_ports;
use crate::machine::picture::{Look, only_art};
use crate::machine::{Machine, PAUSE};
use crate::unit::path::Path;
use crate::unit::stick::{AUTUMN, Stick};
use crate::unit::{Snapshot, Unit, image};
use claims::programs::{repository, succeed};
use std::os::unix::fs::MetadataExt;
use std::path::PathBuf;
use std::process::Command;
use std::sync::LazyLock;
use std::time::Duration;

/// The least number of looks per second, on a busy machine; `display/picture_gaps.rs` looks more often.
pub(crate) const OFTEN: f64 = 1.0;

/// The number of changes of the picture that prove that it plays.
pub(crate) const MOVES: u32 = 20;

/// Waits until a start has proved itself: after a hundred frames.
pub(crate) const PROVEN: &str = "until [ \"$(systemctl show -P SubState dreams-good)\" = exited ]; do sleep 1; done";

/// Waits until all services are up.
pub(crate) const UP: &str = "until systemctl --quiet is-active multi-user.target; do sleep 1; done";

/// A unit after its first start.
pub(crate) struct PlayingUnit {
    /// The looks on the way.
    looks: Vec<Look>,
    /// The time to its first frame.
    pub(crate) start: Duration,
    /// It plays.
    pub(crate) snapshot: Snapshot,
    /// The place in its walk at that moment.
    pub(crate) path: Path,
    /// A stick whose key its owner trusts.
    pub(crate) stick: Stick,
}

/// The unit that all other claims begin with; it is started once.
pub(crate) fn playing_unit() -> &'static PlayingUnit {
    static PLAYING_UNIT: LazyLock<PlayingUnit> = LazyLock::new(|| {
        let unit = Unit::new();
        let stick = Stick::new(&unit.path(""));
        unit.lay_for_owner(&stick.owner);
        let began = now();
        let mut machine = unit.start();
        let mut looks = machine.await_shell();
        looks.extend(machine.watch_move(PAUSE, 3 * MOVES));
        // This machine is slower than any unit: with the usual weight the player would use all of it.
        machine.run("systemctl set-property --runtime dreams.slice CPUWeight=20 && udevadm settle -t 240");
        is_as_it_should_be(&mut machine);
        let mut path = Path::told(&machine.run("dreams-status; echo"));
        path.may_go_to(AUTUMN, &unit.path(AUTUMN));
        machine.watch_move(PAUSE, 2).iter().for_each(|look| path.saw(look));
        let start = looks.iter().find(|look| look.is_art()).expect("art is lit").at.saturating_sub(began);
        println!("lit after {start:.1?}; frozen at {path}");
        PlayingUnit { looks, start, snapshot: unit.freeze(machine), path, stick }
    });
    &PLAYING_UNIT
}

fn is_as_it_should_be(machine: &mut Machine) {
    let root = machine.run("grep ' / ' /proc/mounts");
    assert!(root.contains("/dev/dm-0 / erofs ro,"), "the root is verified: {root}");
    assert!(machine.serial.run("touch /usr/bin/dreams-player").1 != 0, "the root is read-only");
    let size: u64 = machine.run("findmnt --noheadings --bytes --output SIZE /var/lib/dreams").trim().parse().unwrap();
    assert!(size > 400 << 20, "the disk of the flocks takes the rest of the disk, found {size} bytes");
    assert_eq!(machine.run("cat /proc/swaps | wc -l"), "1", "no swap");
    machine.is_well();
    assert_eq!(machine.run("ls /usr/sbin/agetty /usr/sbin/sshd /usr/bin/login 2> /dev/null; true"), "");
    assert_eq!(open_ports(machine), [""; 0], "no port is open to the network");
    // What its owner has set is taken in, beside the player.
    machine.run("until [ -e /var/lib/dreams/owner/dreams.toml ]; do sleep 1; done");
    // The log outlives a start: it goes over from memory to the disk.
    machine.run("until [ -e /var/lib/dreams/journal/system.journal ]; do sleep 1; done");
    assert_eq!(machine.run("findmnt --noheadings --output FSTYPE /var/log/journal/*"), "ext4");
    machine.run("udevadm verify --resolve-names=never /usr/lib/udev/rules.d/8?-dreams-*.rules");
    println!("{}", machine.run("systemd-analyze blame | head -n 20"));
}

#[test]
fn the_system_is_small() {
    let mb = |file: PathBuf| std::fs::metadata(file).unwrap().len() as f64 / 1e6;
    let root = mb(image().join("root.img"));
    let initramfs = mb(image().with_file_name("initramfs").join("initramfs"));
    // The written blocks of the disk; compressed they are fewer.
    let disk = std::fs::metadata(image().join("disk.img")).unwrap().blocks() as f64 * 512.0 / 1e6;
    let sizes = format!("a root of {root} MB, an initramfs of {initramfs} MB, {disk} MB of the disk");
    assert!(root <= 220.0 && initramfs <= 3.0 && disk <= 500.0, "{sizes}");
    let bytes = |mb: f64| (mb * 1e6).round();
    let written = std::fs::read_to_string(image().join("sizes")).unwrap();
    assert_eq!(written, format!("{} root.img\n{} initramfs\n", bytes(root), bytes(initramfs)), "the build tells them");
}

#[test]
fn the_programs_of_a_unit_are_the_ones_that_are_tried() {
    let (_unit, mut machine) = playing_unit().snapshot.wake();
    let sum = |folder: &str, names: &str| format!("cd {folder} && sha256sum {names}");
    let tried = std::env::var("DREAMS_PROGRAMS").map_or_else(|_| repository().join("target/unit/bin"), PathBuf::from);
    for (folder, names) in [("bin", "dreams-player dreams-update dreams-owner"), ("lib/dreams-player", "*.so.*")] {
        let there = machine.run(&sum(&format!("/usr/{folder}"), names));
        let here = tried.with_file_name(folder);
        let here = succeed(Command::new("sh").args(["-c", &sum(&format!("'{}'", here.display()), names)]));
        assert_eq!(there, String::from_utf8(here).unwrap().trim());
    }
    assert!(machine.run("grep -c '^ffmpeg-source' /usr/share/dreams/packages").starts_with('1'));
}

#[test]
fn from_power_to_art_and_nothing_else_ever() {
    only_art(&playing_unit().looks, OFTEN);
}
