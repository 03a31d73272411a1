//! The work on the disk: check the stick, write, compare.
//!
//! Owns the order. The stick is read through and compared with the sum of its image before the first byte is written. The
//! table comes last: until then the disk has its earlier one. What was written is read back from the disk itself. Opens
//! nothing, and decides nothing.
//!
//! Start at [`install`].

use crate::plan::{Part, Plan};
use crate::table::SECTOR;
use rustix::fs::{Advice, fadvise};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;

/// Bytes that are read and written at once.
const BLOCK: u64 = 4 << 20;

/// The SHA-256 of what all disks get alike: all but the owner's settings.
pub(crate) type Sum = [u8; 32];

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    Check,
    Write,
    Compare,
}

/// Why a disk was not installed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error("the disk is not the one that was asked for any more")]
    Changed,
    #[error("the disk has other bytes than were written to it")]
    Differs,
    #[error("cannot open the disk")]
    Open(#[source] io::Error),
    #[error("cannot read the stick")]
    Read(#[source] io::Error),
    #[error("the stick has other bytes than its image")]
    Stick,
    #[error("cannot write to the disk, or read from it")]
    Write(#[source] io::Error),
}

/// Writes `plan` from `stick` to `disk`, and compares. Calls `report` with the phase, and with how much of it is done, in
/// thousandths.
/// Errors: [`Failure`]. Before the first writing only [`Failure::Read`] and [`Failure::Stick`].
pub(crate) fn install(
    stick: &File,
    disk: &File,
    plan: &Plan,
    sum: &Sum,
    report: &dyn Fn(Phase, u16),
) -> Result<(), Failure> {
    let of_stick = |part: &Part| part.from;
    let found = sum_of(stick, plan, of_stick, &|done| report(Phase::Check, done)).map_err(Failure::Read)?;
    if found != *sum {
        return Err(Failure::Stick);
    }
    write(stick, disk, plan, &|done| report(Phase::Write, done))?;
    forget(disk).map_err(Failure::Write)?;
    let of_disk = |part: &Part| part.to;
    let found = sum_of(disk, plan, of_disk, &|done| report(Phase::Compare, done)).map_err(Failure::Write)?;
    if found != *sum || !is_equal(stick, disk, plan)? {
        return Err(Failure::Differs);
    }
    let tables = [(&plan.table.second, plan.table.second_at), (&plan.table.first, 0)];
    for (bytes, at) in tables {
        disk.write_all_at(bytes, at).and_then(|()| disk.sync_all()).map_err(Failure::Write)?;
    }
    forget(disk).map_err(Failure::Write)?;
    for (bytes, at) in tables {
        let mut there = vec![0; bytes.len()];
        disk.read_exact_at(&mut there, at).map_err(Failure::Write)?;
        if there != *bytes {
            return Err(Failure::Differs);
        }
    }
    Ok(())
}

/// The sum of the summed parts on `device`, each of which begins `at` there.
fn sum_of(device: &File, plan: &Plan, at: impl Fn(&Part) -> u64, report: &dyn Fn(u16)) -> io::Result<Sum> {
    let mut sum = Sha256::new();
    let parts = plan.parts.iter().filter(|part| part.is_summed);
    let all: u64 = parts.clone().map(|part| part.length).sum();
    let mut done = 0;
    for part in parts {
        for (from, length) in blocks(part.length) {
            let block = read(device, at(part) + from, length)?;
            sum.update(&block);
            done += length;
            report(thousandths(done, all));
        }
    }
    Ok(sum.finalize().into())
}

/// Writes all parts and wipes, and waits until the disk has them.
fn write(stick: &File, disk: &File, plan: &Plan, report: &dyn Fn(u16)) -> Result<(), Failure> {
    let all: u64 = plan.parts.iter().map(|part| part.length).sum();
    let mut done = 0;
    for part in &plan.parts {
        for (from, length) in blocks(part.length) {
            let block = read(stick, part.from + from, length).map_err(Failure::Read)?;
            disk.write_all_at(&block, part.to + from).map_err(Failure::Write)?;
            // So that the bar shows what the disk has, and memory is not filled with what it has not.
            disk.sync_data().map_err(Failure::Write)?;
            done += length;
            report(thousandths(done, all));
        }
    }
    for (at, length) in &plan.wipes {
        disk.write_all_at(&vec![0; *length as usize], *at).map_err(Failure::Write)?;
    }
    disk.sync_all().map_err(Failure::Write)
}

/// Whether the parts without a sum are on the disk as they are on the stick.
fn is_equal(stick: &File, disk: &File, plan: &Plan) -> Result<bool, Failure> {
    for part in plan.parts.iter().filter(|part| !part.is_summed) {
        for (from, length) in blocks(part.length) {
            let there = read(disk, part.to + from, length).map_err(Failure::Write)?;
            if there != read(stick, part.from + from, length).map_err(Failure::Read)? {
                return Ok(false);
            }
        }
    }
    Ok(true)
}

/// Has the kernel forget what it has in memory of the disk, so that it is read from there.
fn forget(disk: &File) -> io::Result<()> {
    disk.sync_all()?;
    Ok(fadvise(disk, 0, None, Advice::DontNeed)?)
}

fn read(device: &File, at: u64, length: u64) -> io::Result<Vec<u8>> {
    let mut block = vec![0; length as usize];
    device.read_exact_at(&mut block, at).map(|()| block)
}

/// The blocks of so many bytes: where each begins, and its length.
fn blocks(length: u64) -> impl Iterator<Item = (u64, u64)> {
    debug_assert!(length.is_multiple_of(SECTOR));
    (0..length).step_by(BLOCK as usize).map(move |from| (from, BLOCK.min(length - from)))
}

fn thousandths(done: u64, all: u64) -> u16 {
    (done * 1_000 / all.max(1)) as u16
}
