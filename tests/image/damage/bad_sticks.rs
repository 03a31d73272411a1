//! Sticks whose file systems are damaged.
//!
//! Owns a corpus of 210 file systems, by seed, thirty on each of seven sticks: 70 each of FAT, exFAT and ext4. The ext4
//! ones ask the kernel to panic at the first error. The service for sticks mounts each, and the updater reads it, while
//! the picture goes on. ext4 is included because an installer can allow it.
//!
//! Start at [`two_hundred_damaged_sticks_neither_halt_a_unit_nor_stop_its_picture`].

use crate::machine::PAUSE;
use crate::machine::picture::only_art;
use crate::starts::first_start::{MOVES, OFTEN, PlayingUnit, playing_unit};
use crate::unit::stick::exfat;
use claims::programs::succeed;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::fmt::Write as _;
use std::fs::{self, File};
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::process::Command;

/// Number of sticks, and of file systems on each, the kinds in turn.
const STICKS: u64 = 7;
const COUNT: u64 = 30;
/// Bytes of each.
const SIZE: u64 = 4 << 20;
/// The part of each that is read when it is mounted and listed: half of the damage is there.
const HEAD: u64 = 192 << 10;
/// In ext4's superblock: the offset of the behaviour on errors, and the value for a panic.
const ERRORS: (u64, [u8; 2]) = (1024 + 0x3c, [3, 0]);
/// For the unit's shell: allows ext4, too.
const ALLOWED: &str =
    "echo STICKS=vfat,exfat,ext4 > /run/sticks.conf && mount --bind /run/sticks.conf /etc/dreams/sticks.conf";
/// For the unit's shell: waits until every partition with a file system was handled. One that waits for the settings of its
/// stick is not active yet, and has a job.
const ALL_LOOKED_AT: &str = "sleep 5; udevadm settle -t 600; \
    while systemctl list-jobs --plain --no-legend 'dreams-*@sd*' | grep -q .; do sleep 2; done";
/// For the unit's shell: the number of partitions that were mounted.
const MOUNTED: &str = "journalctl --boot --output=cat --identifier=systemd | grep -c '^Finished dreams-update@'";

/// The files on each before it is damaged: some that an updater reads, and folders that it ignores.
fn lay(folder: &Path) {
    for name in ["seals", "objects/3f", "systems", "DCIM/100"] {
        fs::create_dir_all(folder.join(name)).unwrap();
    }
    for number in 0..20 {
        fs::write(folder.join(format!("seals/unit-{number}.seal")), "no seal\n".repeat(40)).unwrap();
        fs::write(folder.join(format!("DCIM/100/{number}.jpg")), vec![number; 9_000]).unwrap();
    }
    fs::write(folder.join("seals/all.seal"), "no seal\n".repeat(40)).unwrap();
    fs::write(folder.join("statements"), "no statement\n").unwrap();
}

/// One undamaged file system of each kind, in `folder`.
fn whole(folder: &Path) -> [Vec<u8>; 3] {
    let at = |name: &str| folder.join(name);
    fs::create_dir(at("tree")).unwrap();
    lay(&at("tree"));
    File::create(at("fat")).unwrap().set_len(SIZE).unwrap();
    succeed(Command::new("mkfs.vfat").arg(at("fat")));
    let copy = "mcopy -i \"$0\" -s -Q \"$1\"/* ::";
    succeed(Command::new("sh").args(["-c", copy]).args([at("fat"), at("tree")]));
    exfat::make(&at("exfat"), SIZE, &at("tree"));
    let mut ext4 = Command::new("mke2fs");
    // Without checksums, so that the kernel reads damaged structures instead of rejecting them.
    ext4.args(["-q", "-t", "ext4", "-O", "^metadata_csum,^has_journal", "-d"]).args([at("tree"), at("ext4")]);
    succeed(ext4.arg(format!("{}k", SIZE >> 10)));
    ["fat", "exfat", "ext4"].map(|name| fs::read(at(name)).unwrap())
}

/// Damages it: single bytes or runs of them, most of them at the beginning.
fn spoil(image: &mut [u8], random: &mut ChaCha8Rng) {
    for _ in 0..=random.next_u32() % 24 {
        let reach = if random.next_u32().is_multiple_of(2) { HEAD } else { SIZE };
        let at = (random.next_u64() % reach) as usize;
        let length = if random.next_u32().is_multiple_of(4) { random.next_u32() % 600 } else { 1 } as usize;
        let end = (at + length).min(image.len());
        random.fill_bytes(&mut image[at..end]);
    }
}

/// Writes stick number `stick` to `disk`: damaged copies of the `whole` file systems, each in a partition.
fn make(disk: &Path, stick: u64, whole: &[Vec<u8>; 3]) {
    let file = File::create(disk).unwrap();
    file.set_len((COUNT + 2) * SIZE).unwrap();
    let mut table = "label: gpt\n".to_owned();
    for number in 1..=COUNT {
        let start = number * SIZE / 512;
        writeln!(table, "start={start}, size={}, type=EBD0A0A2-B9E5-4433-87C0-68B6B72699C7", SIZE / 512).unwrap();
    }
    let script = disk.with_extension("sfdisk");
    fs::write(&script, table).unwrap();
    let label = "sfdisk --quiet \"$0\" < \"$1\"";
    succeed(Command::new("sh").args(["-c", label]).args([disk, &script]));
    for number in 1..=COUNT {
        let kind = (number % 3) as usize;
        let (mut image, mut random) = (whole[kind].clone(), ChaCha8Rng::seed_from_u64(stick * COUNT + number));
        spoil(&mut image, &mut random);
        if kind == 2 {
            let at = ERRORS.0 as usize;
            image[at..at + 2].copy_from_slice(&ERRORS.1);
        }
        file.write_all_at(&image, number * SIZE).unwrap();
    }
}

#[test]
fn two_hundred_damaged_sticks_neither_halt_a_unit_nor_stop_its_picture() {
    let PlayingUnit { snapshot, .. } = playing_unit();
    let (unit, mut machine) = snapshot.wake();
    let folder = unit.path("bad-sticks");
    fs::create_dir(&folder).unwrap();
    let whole = whole(&folder);
    machine.run(ALLOWED);
    for stick in 0..STICKS {
        let disk = folder.join(format!("{stick}.img"));
        make(&disk, stick, &whole);
        machine.plug(&disk);
        let mut looks = machine.watch_while(PAUSE, ALL_LOOKED_AT);
        machine.pull();
        looks.extend(machine.watch_move(PAUSE, MOVES));
        machine.take_stick();
        only_art(&looks, OFTEN);
    }
    let mounted: u64 = machine.run(MOUNTED).trim().parse().unwrap();
    println!("{mounted} of {} were mounted", STICKS * COUNT);
    assert!(3 * mounted >= STICKS * COUNT, "{mounted} were mounted: the corpus is no test");
    machine.run("! dmesg | grep -E 'BUG:|Oops|Call Trace|blocked for more than|Kernel panic'");
    machine.run("! grep /run/dreams-mounts/ /proc/mounts");
}
