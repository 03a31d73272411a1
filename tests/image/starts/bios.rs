//! A start of a unit's disk by BIOS, which it does not support.
//!
//! Owns the claim that the screen says so, and what to do.

use crate::machine::bios_screen::bios_screen;
use crate::unit::image;
use std::fs::File;
use std::io::Read;

/// More of the disk a BIOS does not read: its table, and what is in front of the first partition.
const BEGINNING: u64 = 1 << 20;

#[test]
fn a_start_by_bios_shows_one_sentence_and_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let beginning = folder.path().join("disk.img");
    let disk = File::open(image().join("disk.img")).unwrap();
    std::io::copy(&mut disk.take(BEGINNING), &mut File::create(&beginning).unwrap()).unwrap();
    let shown = bios_screen(folder.path(), &beginning, "UEFI.");
    let wanted = [
        "This picture starts with UEFI only.",
        "In the settings of this computer's firmware, switch from BIOS or Legacy to UEFI.",
    ];
    assert_eq!(shown, wanted);
}
