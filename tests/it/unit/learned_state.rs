//! What a unit has learned about numbers and keys survives the loss of the flocks' partition.
//!
//! Owns the claim on `dreams-learned`, tried with a real store and a file for the partition. When that partition is
//! made anew is tried in `tests/image/damage/flocks_disk.rs`.

use bundle::limits;
use claims::bundle_maker::rubbish;
use claims::programs::{repository, succeed};
use claims::unit::Unit;
use rustix::fs::{CWD, Mode, mkfifoat};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The size of the partition on a unit's disk.
const PARTITION: usize = 1 << 20;

fn learned(what: &str, device: &Path, store: &Path) {
    let script = repository().join("image-build/system/usr/bin/dreams-learned");
    succeed(Command::new("timeout").arg("20").arg(script).arg(what).args([device, store]));
}

#[test]
fn what_a_store_has_learned_comes_back_when_its_disk_is_made_anew() {
    let unit = Unit::new();
    let (device, store) = (unit.path("tries"), unit.path("store"));
    // Whatever lies there out of the box.
    fs::write(&device, vec![0xa5; PARTITION]).unwrap();
    fs::create_dir(&store).unwrap();
    learned("back", &device, &store);
    assert_eq!(fs::read_dir(&store).unwrap().count(), 0, "rubbish is nothing that was learned");
    let mut known = Vec::new();
    for sequence in [2, 1] {
        unit.maker.bundle(&unit.stick(), &rubbish(2, 500, sequence as usize), &[], sequence);
        unit.updated(&["--allow-older"]);
        let current = bundle::CurrentGeneration::of(&store.join(bundle::CURRENT)).unwrap().unwrap();
        current.recorder().unwrap().accept(current.number()).unwrap();
        learned("keep", &device, &store);
        known.push(fs::read(store.join("state.0")).unwrap());
    }
    let first_sector = &fs::read(&device).unwrap()[..512];
    assert_eq!((first_sector, fs::metadata(&device).unwrap().len()), (&[0xa5; 512][..], PARTITION as u64));
    // The disk is made anew.
    fs::remove_dir_all(&store).unwrap();
    fs::create_dir(&store).unwrap();
    learned("back", &device, &store);
    for slot in ["state.0", "state.1"] {
        assert!(fs::read(store.join(slot)).unwrap() == known[1], "{slot}");
    }
    // Whoever knows anything keeps it, also if only one of two copies is left.
    fs::write(store.join("state.0"), "rubbish").unwrap();
    fs::write(store.join("state.1"), known[0].as_slice()).unwrap();
    learned("back", &device, &store);
    assert_eq!(fs::read(store.join("state.1")).unwrap(), known[0]);
    for slot in ["state.0", "state.1"] {
        fs::write(store.join(slot), &known[1]).unwrap();
    }
    assert_eq!(unit.update(&[]).status.code(), Some(1), "nothing comes that was refused before");
    let text = fs::read_to_string(store.join("state.0")).unwrap();
    let state: Value = serde_json::from_str(text.split_once('\n').unwrap().1).unwrap();
    let floors: Vec<_> = state["floors"].as_object().unwrap().values().collect();
    assert_eq!((floors, &state["good"]), (vec![&2.into()], &Value::Null), "{state}");
}

#[test]
fn as_much_as_a_store_can_know_is_kept() {
    let scratch = tempfile::tempdir().unwrap();
    let (device, store) = (scratch.path().join("tries"), scratch.path().join("store"));
    fs::write(&device, vec![0; PARTITION]).unwrap();
    fs::create_dir(&store).unwrap();
    // All that keys may say, with room for how the state spells it, and for what else it holds.
    let most = "x".repeat(limits::LEARNED_STATEMENTS + limits::LEARNED_STATEMENTS / 16 + (48 << 10));
    let state = format!("dreams-state-1 0\n{most}\n");
    for slot in ["state.0", "state.1"] {
        fs::write(store.join(slot), &state).unwrap();
    }
    learned("keep", &device, &store);
    fs::remove_dir_all(&store).unwrap();
    fs::create_dir(&store).unwrap();
    learned("back", &device, &store);
    for slot in ["state.0", "state.1"] {
        assert!(fs::read_to_string(store.join(slot)).unwrap() == state, "{slot}");
    }
}

#[test]
fn links_and_pipes_in_the_place_of_the_state_are_neither_read_nor_written_through() {
    let scratch = tempfile::tempdir().unwrap();
    let at = |name: &str| scratch.path().join(name);
    let (device, store, elsewhere) = (at("tries"), at("store"), at("elsewhere"));
    fs::create_dir(&store).unwrap();
    let (state, secret) = ("dreams-state-1 0\nlearned\n", "dreams-state-1 0\nof another\n");
    let places = || ["state.0", "state.1"].map(|name| store.join(name));
    let link = |place: &Path| std::os::unix::fs::symlink(&elsewhere, place).unwrap();
    let pipe = |place: &Path| mkfifoat(CWD, place, Mode::RWXU).unwrap();
    let each = |act: &dyn Fn(&Path)| {
        for place in places() {
            act(&place);
        }
    };
    let removed = |place: &Path| fs::remove_file(place).unwrap();
    for put in [&link as &dyn Fn(&Path), &pipe] {
        // The store's user puts it there, and has the service start.
        fs::write(&device, vec![0xa5; PARTITION]).unwrap();
        fs::write(&elsewhere, secret).unwrap();
        each(put);
        learned("keep", &device, &store);
        assert!(fs::read(&device).unwrap() == vec![0xa5; PARTITION], "something was kept");
        // What was kept before comes back in its place.
        each(&removed);
        each(&|place| fs::write(place, state).unwrap());
        learned("keep", &device, &store);
        each(&removed);
        fs::write(&elsewhere, "of root").unwrap();
        each(put);
        learned("back", &device, &store);
        assert_eq!(fs::read_to_string(&elsewhere).unwrap(), "of root");
        for place in places() {
            assert!(fs::symlink_metadata(&place).unwrap().is_file(), "{}", place.display());
            assert_eq!(fs::read_to_string(&place).unwrap(), state);
            fs::remove_file(&place).unwrap();
        }
    }
}
