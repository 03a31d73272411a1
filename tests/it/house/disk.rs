//! The partitions of a unit's disk, in several files.
//!
//! Owns the comparison of `image-build/disk.sfdisk`, which defines them, with all files that name a partition or rely
//! on its size.

use super::{facts::number_after, read};
use std::collections::BTreeMap;

/// Sectors in a MiB.
const SECTORS: u64 = 2_048;
/// MiB before the first partition and after the last one: the table and its copy.
const TABLES_MIB: u64 = 2;

/// Number, name and MiB of every partition that an image has.
fn partitions() -> BTreeMap<u64, (String, u64)> {
    let partition = |line: &str| {
        let number = line.split_once(" : size=")?.0.parse().ok()?;
        let name = line.split_once("name=")?.1.to_owned();
        Some((number, (name, number_after(line, "size=") as u64)))
    };
    read("image-build/disk.sfdisk").lines().filter_map(partition).collect()
}

/// The same with the partition that a unit makes itself: number and name.
fn names() -> BTreeMap<u64, String> {
    let made = number_after(&read("image-build/system/usr/lib/dreams/disk"), "flocks_number=") as u64;
    let mut names: BTreeMap<_, _> = partitions().into_iter().map(|(number, (name, _))| (number, name)).collect();
    assert_eq!(names.insert(made, "dreams_data".to_owned()), None, "the number {made} is free");
    names
}

#[test]
fn the_partitions_are_called_and_numbered_the_same_wherever_they_are_told() {
    let entered = read("image-build/system/usr/bin/dreams-data");
    assert!(entered.contains("echo \"$flocks_number : start=$start, size=$size, type=linux, name=dreams_data\""));

    let readme = read("image-build/README.md");
    let cells = readme.lines().filter_map(|line| line.strip_prefix("| ")?.split(" | ").next());
    let told = cells.flat_map(|cell| cell.split(", ")).filter_map(|told| {
        let (number, name) = told.split_once(" `dreams_")?;
        Some((number.parse().ok()?, format!("dreams_{}", name.trim_end_matches('`'))))
    });
    assert_eq!(told.collect::<BTreeMap<u64, _>>(), names(), "the table in `image-build/README.md`");

    let unit = read("tests/image/unit/mod.rs");
    let number = |key: &str| number_after(&unit, &format!("const {key}: u32 = ")) as u64;
    let tried = [
        (number("BOOT"), "boot"),
        (number("SLOT_A"), "a"),
        (number("SLOT_B"), "b"),
        (number("OWNER"), "owner"),
        (number("DATA"), "data"),
        (number("SPARE"), "spare"),
    ];
    for (number, name) in tried {
        assert_eq!(names().get(&number), Some(&format!("dreams_{name}")), "`tests/image/unit/mod.rs`");
    }
}

#[test]
fn the_least_disk_has_room_for_the_flocks() {
    let size = number_after(&read("image-build/disk.sfdisk"), "# size: ") as u64;
    let least = number_after(&read("image-build/system/usr/bin/dreams-data"), "[ $size -ge ") as u64 / SECTORS;
    let taken: u64 = partitions().values().map(|(_, mib)| mib).sum();
    assert!(taken + TABLES_MIB + least <= size, "{taken} MiB are taken, {least} MiB needed, of {size} MiB");
    assert!(read("image-build/disk.sfdisk").contains(&format!("it has at least {least} MiB")));
}

#[test]
fn both_boot_partitions_and_both_slots_are_alike_and_as_large_as_the_documents_say() {
    let size = |wanted: &str| partitions().into_values().find(|(name, _)| name == wanted).map(|(_, mib)| mib);
    assert!(size("dreams_boot").is_some() && size("dreams_boot") == size("dreams_spare"));
    assert!(size("dreams_a").is_some() && size("dreams_a") == size("dreams_b"));
    let readme = read("image-build/README.md");
    assert_eq!(Some(number_after(&readme, "It is 123 KB of ") as u64), size("dreams_boot"));
    let arm = number_after(&read("image-build/architecture"), "boot_mib=");
    assert_eq!(number_after(&readme, "so the boot partitions have "), arm, "of an image for ARM processors");
}
