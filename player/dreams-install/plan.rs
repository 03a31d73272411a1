//! What is copied from the stick to which place of a disk.
//!
//! Owns the places, in bytes, and what of an earlier unit stays. The stick has a unit's partitions, with two differences: the
//! first one is called `dreams_install` and starts the installer, and firmware starts from no other. A unit's first
//! partition is a copy of its last one. Pure; `copying.rs` acts.
//!
//! Start at [`Plan::new`].

use crate::table::{Copies, Partition, SECTOR, Table};

/// The stick's first partition, and a unit's.
pub(crate) const INSTALLER: &str = "dreams_install";
const BOOT: &str = "dreams_boot";
/// The same files as those of a unit's first partition.
const SPARE: &str = "dreams_spare";
/// The owner's settings.
const OWNER: &str = "dreams_owner";
/// The flocks; behind all others.
const DATA: &str = "dreams_data";
/// Its number, by which a unit finds it.
const DATA_NUMBER: usize = 6;
/// What is copied, in the order in which it is on the disk: from where on the stick, to where.
const PARTITIONS: [(&str, &str); 6] = [
    (SPARE, INSTALLER),
    ("dreams_a", "dreams_a"),
    ("dreams_b", "dreams_b"),
    (OWNER, OWNER),
    ("dreams_tries", "dreams_tries"),
    (SPARE, SPARE),
];
/// The least room for the flocks, and for the second copy of the table, in bytes.
const ROOM: u64 = 66 << 20;
/// Where the first two superblocks of the flocks' file system are, from the beginning of their partition, rounded down; and
/// how much is overwritten there, so that no earlier file system is found again. In bytes; see `lib/dreams/disk`.
const SUPERBLOCKS: [u64; 2] = [0, 32_768 * 4_096];
const WIPED: u64 = 1 << 20;

/// A copy of bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    pub(crate) from: u64,
    pub(crate) to: u64,
    pub(crate) length: u64,
    /// Whether the sum of the image has it: all but the owner's settings.
    pub(crate) is_summed: bool,
}

/// Everything that is written to a disk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Plan {
    pub(crate) parts: Vec<Part>,
    /// Places that are filled with zeros, and their length.
    pub(crate) wipes: Vec<(u64, u64)>,
    pub(crate) table: Copies,
}

/// How many bytes a disk must have for a unit from this stick; `None` if it is not such a stick.
pub(crate) fn needed(stick: &Table) -> Option<u64> {
    parts(stick).map(|_| stick.end_without(DATA) * SECTOR + ROOM)
}

/// Whether `disk` has a unit, whose flocks and settings can stay under a unit from `stick`.
pub(crate) fn has_unit(disk: &Table, stick: &Table) -> bool {
    let same_place = |name| disk.find(name).is_some() && disk.find(name) == stick.find(name);
    let is_behind = |data: u64| data >= stick.end_without(DATA) && disk.end_without(DATA) <= data;
    let is_found = |data: Partition| data.number == DATA_NUMBER && is_behind(data.start);
    same_place(OWNER) && disk.find(DATA).is_some_and(is_found)
}

impl Plan {
    /// For a disk of `bytes` bytes, at least [`needed`]. `earlier` is its table, if it has a unit whose flocks and settings
    /// stay. `None` if the stick is not one.
    pub(crate) fn new(stick: &Table, bytes: u64, earlier: Option<&Table>) -> Option<Self> {
        let mut parts = parts(stick)?;
        let sectors = bytes / SECTOR;
        let mut table = stick.clone();
        table.start_from(stick.find(INSTALLER)?.number, BOOT);
        table.start_from(stick.find(SPARE)?.number, SPARE);
        let mut wipes = Vec::new();
        if let Some(earlier) = earlier {
            table.take(DATA_NUMBER, earlier);
            parts.retain(|part| part.is_summed);
        } else {
            let flocks = stick.end_without(DATA).next_multiple_of(2_048) * SECTOR;
            let places = SUPERBLOCKS.map(|at| flocks + at).into_iter();
            wipes.extend(places.filter(|at| at + WIPED <= bytes).map(|at| (at, WIPED)));
        }
        Some(Self { parts, wipes, table: table.copies(sectors) })
    }
}

/// All partitions.
fn parts(stick: &Table) -> Option<Vec<Part>> {
    let part = |(from, to)| {
        let (from, to, is_summed) = (stick.find(from)?, stick.find(to)?, to != OWNER);
        (from.sectors == to.sectors).then_some(())?;
        Some(Part { from: from.start * SECTOR, to: to.start * SECTOR, length: to.sectors * SECTOR, is_summed })
    };
    PARTITIONS.into_iter().map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::{Plan, has_unit, needed};
    use crate::table::tests::table;
    use crate::table::{SECTOR, Table};

    const UNIT: [(usize, &str, u64, u64); 6] = [
        (1, "dreams_boot", 2_048, 4_095),
        (2, "dreams_a", 4_096, 6_143),
        (3, "dreams_b", 6_144, 8_191),
        (4, "dreams_owner", 8_192, 10_239),
        (5, "dreams_tries", 10_240, 10_241),
        (7, "dreams_spare", 10_242, 12_289),
    ];
    const DISK: u64 = 1 << 30;

    fn stick() -> Table {
        let mut partitions = UNIT;
        partitions[0].1 = "dreams_install";
        table(&partitions)
    }

    fn unit(data: (usize, &'static str, u64, u64)) -> Table {
        table(&[&UNIT[..], &[data]].concat())
    }

    #[test]
    fn a_disk_gets_a_copy_of_the_last_partition_as_its_first() {
        let plan = Plan::new(&stick(), DISK, None).unwrap();
        let copied: Vec<_> = plan.parts.iter().map(|part| (part.from / SECTOR, part.to / SECTOR)).collect();
        let same = |sector| (sector, sector);
        assert_eq!(copied, [(10_242, 2_048), same(4_096), same(6_144), same(8_192), same(10_240), same(10_242)]);
        assert_eq!(plan.parts.iter().filter(|part| !part.is_summed).count(), 1);
        let written = Table::parse(&plan.table.first).unwrap();
        assert!(UNIT.iter().all(|(number, name, ..)| written.find(name).is_some_and(|found| found.number == *number)));
        assert_eq!((written.find("dreams_install"), written.find("dreams_data")), (None, None));
        assert_eq!(plan.wipes, [(14_336 * SECTOR, 1 << 20), (14_336 * SECTOR + (128 << 20), 1 << 20)]);
    }

    #[test]
    fn the_flocks_and_settings_of_an_earlier_unit_stay() {
        let earlier = unit((6, "dreams_data", 14_336, 100_000));
        assert!(has_unit(&earlier, &stick()));
        let plan = Plan::new(&stick(), DISK, Some(&earlier)).unwrap();
        assert!(plan.wipes.is_empty() && plan.parts.len() == 5 && plan.parts.iter().all(|part| part.is_summed));
        let written = Table::parse(&plan.table.first).unwrap();
        assert_eq!(written.find("dreams_data"), earlier.find("dreams_data"));
        let ours = plan.parts.iter().all(|part| part.to + part.length <= 14_336 * SECTOR);
        assert!(ours, "nothing is written behind the unit's own partitions: {plan:?}");
    }

    #[test]
    fn flocks_in_another_place_cannot_stay() {
        for (other, why) in [
            (table(&UNIT), "no flocks"),
            (unit((6, "dreams_data", 12_000, 100_000)), "flocks where the unit is written"),
            (table(&[(6, "dreams_data", 14_336, 100_000)]), "flocks without settings"),
            (unit((8, "dreams_data", 14_336, 20_000)), "flocks that no unit finds"),
            (unit((6, "dreams_data", 12_290, 20_000)), ""),
        ] {
            assert_eq!(has_unit(&other, &stick()), why.is_empty(), "{why}");
        }
    }

    #[test]
    fn a_disk_that_is_no_installers_stick_has_no_plan() {
        assert_eq!(needed(&stick()), Some(12_290 * SECTOR + (66 << 20)));
        assert_eq!((needed(&table(&UNIT)), Plan::new(&table(&UNIT), DISK, None)), (None, None));
    }
}
