//! The power fails, the process dies, the disk is full: at every single operation on the disk.
//!
//! A unit's life is three updates: one that plays, one that does not, one that does. It is ended at each operation, by a
//! power cut in many forms, by a kill, by an error; then looked at, and then lived to its end.

use crate::careless::{Careless, Carelessness};
use crate::model::{ModelDisk, Trouble};
use crate::press::{Files, flock, press, trust, unit, verified};
use bundle::{Admission, CURRENT, Consent, Disk, FetchItem, Refusal, Sequence, Store, StoreError, VerifiedBundle};
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::sync::OnceLock;

/// What a unit has told its owner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Told {
    Installed(usize),
    Lost,
    Won(usize),
}

/// The bundles of a life, with their content. The second one does not play.
struct Edition {
    bundle: VerifiedBundle,
    files: Files,
    plays: bool,
}

fn editions() -> &'static [Edition] {
    static EDITIONS: OnceLock<Vec<Edition>> = OnceLock::new();
    let make = |number: usize| {
        let (folder, files) = (tempfile::tempdir().unwrap(), flock(3, number));
        press(folder.path(), &files, &["lobby"], number as u64, "artist");
        Edition { bundle: verified(folder.path(), &trust()).unwrap(), files, plays: number != 2 }
    };
    EDITIONS.get_or_init(|| (1..=3).map(make).collect())
}

/// Lives a unit's life, from wherever it stands, and tells of it.
fn live(disk: Box<dyn Disk>, told: &mut Vec<Told>) -> Result<(), StoreError> {
    let mut store = Store::open(disk, trust())?;
    for (index, edition) in editions().iter().enumerate() {
        match store.admit(edition.bundle.seal(), &unit("lobby"), Consent::Newer) {
            Ok(Admission::New) => {
                store.collect(Some(&edition.bundle))?;
                fetch(&store, edition)?;
                store.install(&edition.bundle)?;
                told.push(Told::Installed(index));
            }
            Ok(Admission::OnTrial) => {}
            Ok(Admission::Kept | Admission::Plays) | Err(Refusal::Older { .. } | Refusal::MarkedBad { .. }) => continue,
            Err(refused) => panic!("{refused}"),
        }
        store.record_start()?;
        if edition.plays {
            store.accept()?;
            told.push(Told::Won(index));
        } else {
            store.reject()?;
            told.push(Told::Lost);
        }
        store.collect(None)?;
    }
    Ok(())
}

fn fetch(store: &Store, edition: &Edition) -> Result<(), StoreError> {
    store.plan(&edition.bundle)?.wanted.iter().try_for_each(|wanted| fetch_one(store, wanted, edition))
}

fn fetch_one(store: &Store, wanted: &FetchItem, edition: &Edition) -> Result<(), StoreError> {
    let bytes = &edition.files[wanted.path.as_str()];
    loop {
        let mut intake = store.intake(wanted)?;
        for chunk in bytes[intake.have() as usize..].chunks(900) {
            intake.append(chunk)?;
        }
        match intake.finish() {
            // What a power cut left of it was rubbish: from the beginning.
            Err(StoreError::Damaged { .. }) => {}
            done => break done.map(drop),
        }
    }
}

/// Whether what plays on `disk` may play there, after this was told: something whole, and nothing that was undone.
fn may_play(disk: &ModelDisk, told: &[Told]) -> Result<(), String> {
    let allowed: &[Option<usize>] = match told.last() {
        None => &[None, Some(0)],
        Some(Told::Installed(0)) => &[Some(0)],
        Some(Told::Won(0)) => &[Some(0), Some(1)],
        Some(Told::Installed(1)) => &[Some(1), Some(0)],
        Some(Told::Lost) => &[Some(0), Some(2)],
        Some(Told::Installed(_) | Told::Won(_)) => &[Some(2)],
    };
    let found = disk.tree(CURRENT);
    let which = found.as_ref().map(|files| editions().iter().position(|edition| edition.files == *files));
    match which {
        Some(None) => Err(format!("after {told:?} plays a mixture of {:?}", found.map(|files| files.len()))),
        None if allowed.contains(&None) => Ok(()),
        Some(which) if allowed.contains(&which) => Ok(()),
        which => Err(format!("after {told:?} plays {which:?}")),
    }
}

/// Looks at a disk after trouble, as the player finds it and as the updater does, and lives on to the end.
fn check(disk: &ModelDisk, told: &[Told]) -> Result<(), String> {
    may_play(disk, told)?;
    let store = Store::open(Box::new(disk.clone()), trust()).map_err(|error| format!("{error:?}"))?;
    may_play(disk, told)?;
    let signer = editions()[0].bundle.seal().signer();
    let floor = store.state().floors.get(&signer).copied();
    let won = told.iter().rev().find_map(|told| match told {
        Told::Won(index) => Some(Sequence(*index as u64 + 1)),
        Told::Installed(_) | Told::Lost => None,
    });
    if floor < won {
        return Err(format!("after {told:?} the floor is {floor:?}"));
    }
    drop(store);
    live(Box::new(disk.clone()), &mut Vec::new()).map_err(|error| format!("{error:?}"))?;
    let store = Store::open(Box::new(disk.clone()), trust()).map_err(|error| format!("{error:?}"))?;
    let scrubbed = store.scrub(|_| true).unwrap();
    if disk.tree(CURRENT).as_ref() != Some(&editions()[2].files) || !scrubbed.damaged.is_empty() {
        let plays = disk.tree(CURRENT).map(|files| files.into_keys().collect::<Vec<_>>());
        return Err(format!("after {told:?} the life ends with {plays:?}, {scrubbed:?}"));
    }
    Ok(())
}

/// So many operations a whole life takes.
fn length() -> u64 {
    let disk = ModelDisk::new(None);
    let mut told = Vec::new();
    live(Box::new(disk.clone()), &mut told).unwrap();
    assert_eq!(told.len(), 6, "{told:?}");
    let operations = disk.operations();
    check(&disk, &told).unwrap();
    operations
}

#[test]
fn a_power_cut_or_a_kill_at_every_operation_leaves_a_whole_flock_and_loses_nothing_that_was_told() {
    let length = length();
    for at in 0..length {
        let disk = ModelDisk::new(Some((at, Trouble::Death)));
        let mut told = Vec::new();
        live(Box::new(disk.clone()), &mut told).unwrap_err();
        check(&disk.after_a_kill(), &told).unwrap_or_else(|fault| panic!("killed at {at} of {length}: {fault}"));
        for seed in 0..10 {
            let cut = disk.after_a_power_cut(seed);
            check(&cut, &told).unwrap_or_else(|fault| panic!("cut at {at} of {length}, seed {seed}: {fault}"));
        }
    }
}

/// A unit looks through its store, in which a clip is damaged, and fetches that again.
fn mend(disk: Box<dyn Disk>, edition: &Edition) -> Result<(), StoreError> {
    let store = Store::open(disk, trust())?;
    store.scrub(|_| true)?;
    for wanted in store.missing()? {
        if !store.restore(&wanted)? {
            fetch_one(&store, &wanted, edition)?;
        }
    }
    store.repair()?;
    store.collect(None)
}

#[test]
fn a_look_and_its_mending_cut_short_at_every_operation_take_no_file_from_the_flock_that_plays() {
    let (clip, edition) = ("loops/1.mp4", &editions()[0]);
    let whole = ModelDisk::new(None);
    let mut store = Store::open(Box::new(whole.clone()), trust()).unwrap();
    fetch(&store, edition).unwrap();
    store.install(&edition.bundle).unwrap();
    store.accept().unwrap();
    drop(store);
    // All that was done before is on the disk.
    let rotten = whole.with(None);
    rotten.rot(&format!("generations/1/flock/{clip}"));
    let damaged = rotten.tree(CURRENT).unwrap();
    assert_ne!(damaged, edition.files);
    let plays_all = |disk: &ModelDisk, case: &str| {
        let found = disk.tree(CURRENT).unwrap_or_default();
        let is_there = |(path, bytes): (&String, &Vec<u8>)| {
            found.get(path).is_some_and(|found| found == bytes || *found == damaged[path])
        };
        assert!(edition.files.iter().all(is_there), "{case}: of the flock there is {:?}", found.keys());
    };
    let disk = rotten.with(None);
    mend(Box::new(disk.clone()), edition).unwrap();
    assert_eq!(disk.tree(CURRENT).as_ref(), Some(&edition.files));
    assert_eq!(disk.tree("aside"), Some(Files::new()), "nothing is put aside any more");
    let length = disk.operations();
    for at in 0..length {
        for trouble in [Trouble::Death, Trouble::Once(ErrorKind::Other)] {
            let disk = rotten.with(Some((at, trouble)));
            mend(Box::new(disk.clone()), edition).ok();
            let cuts = (0..10)
                .map(|seed| (format!("{trouble:?} at {at} of {length}, seed {seed}"), disk.after_a_power_cut(seed)));
            for (case, cut) in cuts.chain([(format!("{trouble:?} at {at} of {length}"), disk.after_a_kill())]) {
                plays_all(&cut, &case);
                mend(Box::new(cut.clone()), edition).unwrap_or_else(|error| panic!("{case}: {error:?}"));
                assert!(cut.tree(CURRENT).as_ref() == Some(&edition.files), "{case}: the clip is still damaged");
            }
        }
    }
}

#[test]
fn a_full_disk_and_a_failing_one_at_every_operation_cost_neither_picture_nor_progress() {
    let length = length();
    for at in 0..length {
        for kind in [ErrorKind::StorageFull, ErrorKind::Other] {
            let disk = ModelDisk::new(Some((at, Trouble::Once(kind))));
            let mut told = Vec::new();
            // What fails for good and what is passed over are both fine.
            let ended = live(Box::new(disk.clone()), &mut told);
            assert!(ended.is_err() || disk.operations() > at);
            check(&disk, &told).unwrap_or_else(|fault| panic!("{kind:?} at {at} of {length}: {fault}"));
        }
    }
}

#[test]
fn a_missing_sync_and_a_write_in_place_would_be_noticed() {
    for carelessness in Carelessness::ALL {
        let mut faults: BTreeMap<String, usize> = BTreeMap::new();
        for at in 0..length() {
            let disk = ModelDisk::new(Some((at, Trouble::Death)));
            let mut told = Vec::new();
            let careless = Careless { disk: disk.clone(), carelessness, meanwhile: |_| () };
            live(Box::new(careless), &mut told).ok();
            for seed in 0..10 {
                let checked = check(&disk.after_a_power_cut(seed), &told);
                *faults.entry(checked.err().unwrap_or_default()).or_default() += 1;
            }
        }
        faults.remove("");
        let caught: usize = faults.values().sum();
        assert!(caught >= 5, "{carelessness:?} was caught {caught} times");
    }
}
