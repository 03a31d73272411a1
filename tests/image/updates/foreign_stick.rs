//! A stick with a file system of Windows.
//!
//! Owns the claim that the running picture says how it is formatted.

use crate::machine::PAUSE;
use crate::machine::picture::only_art;
use crate::owner::settings_error::has_notice;
use crate::starts::first_start::{OFTEN, playing_unit};
use std::fs;
use std::path::Path;

/// A stick with as much of NTFS as it takes for udev: the boot sector, and the marks of two records of its table.
fn stick(path: &Path) {
    let mut bytes = vec![0; 4 << 20];
    let mut put = |at: usize, what: &[u8]| bytes[at..at + what.len()].copy_from_slice(what);
    put(0, b"\xeb\x52\x90NTFS    ");
    // 512 bytes in a sector, 8 sectors in a cluster; a fixed disk; so many sectors.
    put(11, &[0x00, 0x02, 0x08]);
    put(21, &[0xf8]);
    put(0x28, &8191_u64.to_le_bytes());
    // The clusters of the table and of its copy; a record has 1024 bytes (2 to the 10th), a block of an index one cluster.
    put(0x30, &4_u64.to_le_bytes());
    put(0x38, &100_u64.to_le_bytes());
    put(0x40, &[0xf6]);
    put(0x44, &[0x01]);
    put(0x48, &0x1234_5678_90ab_cdef_u64.to_le_bytes());
    put(510, &[0x55, 0xaa]);
    for record in [0, 3] {
        put(4 * 8 * 512 + record * 1024, b"FILE");
    }
    fs::write(path, bytes).unwrap();
}

#[test]
fn a_stick_of_windows_is_named_on_the_running_picture_and_is_not_mounted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ntfs.img");
    stick(&path);
    let (_unit, mut machine) = playing_unit().snapshot.wake();
    machine.plug(&path);
    let sentence = "This stick is formatted as NTFS. This frame reads FAT32 and exFAT.";
    let notice = format!("until grep -qs '{sentence}' /run/dreams-update/notice; do sleep 1; done");
    let mut looks = machine.watch_while(PAUSE, &notice);
    looks.extend(machine.watch_for(PAUSE, "the notice", has_notice));
    only_art(&looks, OFTEN);
    machine.run("! grep /run/dreams-mounts/ /proc/mounts");
    machine.run("! systemctl list-units --all --plain --no-legend 'dreams-update@*' | grep sd");
    machine.is_well();
}
