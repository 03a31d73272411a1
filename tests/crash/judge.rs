//! What must hold after a power cut.
//!
//! Owns the checks of one disk: it has a whole flock, the last one that was reported or the one that was being
//! installed; the owner's settings are whole, the reported ones or the next; the numbers and revoked keys that it
//! reported are still known; and the update then completes.
//!
//! Start at [`after`].

use crate::lives::{Edition, Lab, Way};
use crate::reports::{Progress, Step};
use crate::rig::Disk;
use crate::upkeep::{ROTTEN, Settings, rotten};
use bundle::{CURRENT, LocalDisk, Sequence, Store};
use claims::bundle_maker::{Files, files_in};
use std::path::Path;

/// Checks the disk after a cut that came at `so` in its script. With `completes`, installs the last flock in that way.
///
/// # Errors
/// What does not hold.
pub(crate) fn after(lab: &Lab, disk: &Disk, so: Progress, completes: Option<Way>) -> Result<(), String> {
    let mounted = disk.mount()?;
    let store = mounted.join("store");
    let verdict =
        has_a_whole_flock(lab, &store, so).and_then(|()| has_whole_settings(lab, &mounted, so)).and_then(|()| {
            match completes {
                Some(way) => goes_on(lab, &store, so, way),
                None => Ok(()),
            }
        });
    let errors = disk.errors();
    disk.unmount();
    if errors > 0 { Err(format!("ext4 found {errors} errors: {verdict:?}")) } else { verdict }
}

/// As the player finds it.
fn has_a_whole_flock(lab: &Lab, store: &Path, so: Progress) -> Result<(), String> {
    let found = plays(store);
    let told = so.many(Step::Edition);
    let allowed = lab.editions.iter().skip(told).take(1 + usize::from(so.is_at(Step::Edition)));
    let is_whole = |edition: &Edition| found.as_ref() == Some(&edition.files);
    let is_rotten = |edition: &Edition| so.may_rot() && found.as_ref() == Some(&rotted(&edition.files));
    if allowed.clone().any(|edition| is_whole(edition) || is_rotten(edition)) {
        return Ok(());
    }
    let which = lab.editions.iter().position(is_whole).map(|at| at + 1);
    let names = found.map(|files| files.into_keys().collect::<Vec<_>>());
    Err(format!("after {told} editions plays edition {which:?}, of {names:?}"))
}

/// The flock with the damaged clip.
fn rotted(files: &Files) -> Files {
    let mut files = files.clone();
    let clip = files.get_mut(ROTTEN).expect("every flock has it");
    rotten(clip);
    files
}

/// The owner's settings, as the player and the updater find them.
fn has_whole_settings(lab: &Lab, mounted: &Path, so: Progress) -> Result<(), String> {
    let told = so.many(Step::Owner);
    let allowed = || lab.settings.iter().skip(told).take(1 + usize::from(so.is_at(Step::Owner)));
    let found = Settings::in_folder(mounted);
    // They are two files: one may be the new one already, and the other the old one still.
    let is_kept = allowed().any(|settings| settings.kept == found.kept);
    let is_wifi = allowed().any(|settings| settings.wifi == found.wifi);
    if is_kept && is_wifi { Ok(()) } else { Err(format!("after {told} edits the settings are {found:?}")) }
}

/// As the updater finds it: opened, scrubbed, and brought up to date.
fn goes_on(lab: &Lab, store: &Path, so: Progress, way: Way) -> Result<(), String> {
    let open = || {
        let disk = LocalDisk::open(store).map_err(|error| format!("the store cannot be opened: {error}"))?;
        Store::open(Box::new(disk), lab.trust()).map_err(|error| format!("the store cannot be opened: {error:?}"))
    };
    let is_revoked = |store: &Store| store.trust().revoked().any(|id| id == lab.maker.stranger());
    let (floor, revoked) = {
        let _alone = lab.alone();
        let store = open()?;
        (store.state().floors.values().copied().max(), is_revoked(&store))
    };
    has_a_whole_flock(lab, store, so)?;
    // Each edition was won before the next one came, so that as many floors are certain as came before the last report.
    let told = so.many(Step::Edition);
    if floor < Some(Sequence(told.max(1) as u64)) {
        return Err(format!("after {told} editions the floor is {floor:?}"));
    }
    let must_be = so.many(Step::Revoked) > 0;
    if !revoked && must_be {
        return Err("the key that was called back is trusted again".to_owned());
    }
    if so.may_rot() {
        // The installed flock can be fetched again from its source.
        lab.update(store, &lab.editions[told].source(way), &["--scrub"])?;
    }
    let last = lab.editions.last().expect("there are some");
    let answer = lab.update(store, &last.source(way), &[])?;
    if plays(store).as_ref() != Some(&last.files) {
        return Err(format!("the next update leaves another flock, and says {answer}"));
    }
    let _alone = lab.alone();
    let store = open()?;
    if must_be && !is_revoked(&store) {
        return Err("the next update forgets the key that was called back".to_owned());
    }
    let scrubbed = store.scrub(|_| true).map_err(|error| format!("{error:?}"))?;
    let is_clean = scrubbed.damaged.is_empty() && scrubbed.unlisted.is_empty();
    if is_clean { Ok(()) } else { Err(format!("the next update leaves {scrubbed:?}")) }
}

/// The installed flock; `None` if there is none, or if it cannot be read.
fn plays(store: &Path) -> Option<Files> {
    files_in(&store.join(CURRENT)).ok()
}
