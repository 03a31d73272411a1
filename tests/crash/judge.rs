//! What must hold after a power cut.
//!
//! Owns the verdict over one disk: the unit has a whole flock, the last one that was reported or the one that was
//! coming; what it knows of floors is not less than what it said; and the update then completes by itself.
//!
//! Start at [`after`].

use crate::lives::{Edition, Lab};
use crate::rig::Disk;
use bundle::{CURRENT, LocalDisk, Sequence, Store};
use claims::press::{Files, files_in};
use std::path::Path;

/// Looks at the disk after a cut, when `told` installations had been reported. With `completes`, brings the last flock.
///
/// # Errors
/// What does not hold.
pub(crate) fn after(lab: &Lab, disk: &Disk, told: usize, completes: Option<&str>) -> Result<(), String> {
    let mounted = disk.mount()?;
    let store = mounted.join("store");
    let verdict = has_a_whole_flock(lab, &store, told).and_then(|()| match completes {
        Some(source) => goes_on(lab, &store, told, source),
        None => Ok(()),
    });
    let errors = disk.errors();
    disk.unmount();
    if errors > 0 { Err(format!("ext4 found {errors} errors: {verdict:?}")) } else { verdict }
}

/// As the player finds it.
fn has_a_whole_flock(lab: &Lab, store: &Path, told: usize) -> Result<(), String> {
    let found = plays(store);
    let allowed = lab.editions.iter().skip(told).take(2);
    let is_whole = |edition: &Edition| found.as_ref() == Some(&edition.files);
    if allowed.clone().any(is_whole) {
        return Ok(());
    }
    let which = lab.editions.iter().position(is_whole).map(|at| at + 1);
    let names = found.map(|files| files.into_keys().collect::<Vec<_>>());
    Err(format!("after {told} reports plays edition {which:?}, of {names:?}"))
}

/// As the updater finds it: opened, looked at again, and brought up to date.
fn goes_on(lab: &Lab, store: &Path, told: usize, source: &str) -> Result<(), String> {
    let open = || {
        let disk = LocalDisk::open(store).map_err(|error| format!("the store cannot be opened: {error}"))?;
        Store::open(Box::new(disk), lab.trust()).map_err(|error| format!("the store cannot be opened: {error:?}"))
    };
    let floor = {
        let _alone = lab.alone();
        open()?.state().floors.values().copied().max()
    };
    has_a_whole_flock(lab, store, told)?;
    // Each edition was won before the next one came, so that as many floors are certain as came before the last report.
    if floor < Some(Sequence(told.max(1) as u64)) {
        return Err(format!("after {told} reports the floor is {floor:?}"));
    }
    let answer = lab.update(store, source)?;
    if plays(store).as_ref() != lab.editions.last().map(|edition| &edition.files) {
        return Err(format!("the next update leaves another flock, and says {answer}"));
    }
    let _alone = lab.alone();
    let scrubbed = open()?.scrub(|_| true).map_err(|error| format!("{error:?}"))?;
    let is_clean = scrubbed.damaged.is_empty() && scrubbed.unlisted.is_empty();
    if is_clean { Ok(()) } else { Err(format!("the next update leaves {scrubbed:?}")) }
}

/// The flock that plays; `None` if there is none, or it cannot be read.
fn plays(store: &Path) -> Option<Files> {
    files_in(&store.join(CURRENT)).ok()
}
