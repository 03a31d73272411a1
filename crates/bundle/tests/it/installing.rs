//! What a unit does with bundles, in order: install, try, keep, go back, clean up, mend.

use crate::careless::{BAD, Careless, Carelessness};
use crate::folders::files_in;
use crate::press::{Files, fetch, flock, key, playing, press, store, trust, unit, verified};
use bundle::{
    Admission, CURRENT, Consent, CurrentGeneration, LocalDisk, ObjectId, Refusal, STARTS, Sequence, Statement, Store,
    StoreError, Trust, TrustChange, Verdict, limits,
};
use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// Takes the bundle in `folder` all the way to its trial.
fn update(store: &mut Store, folder: &Path) -> u64 {
    let bundle = verified(folder, store.trust()).unwrap();
    assert_eq!(store.admit(bundle.seal(), &unit("lobby"), Consent::Newer).unwrap(), Admission::New);
    let fetched = fetch(store, folder, &bundle);
    store.install(&bundle).unwrap();
    fetched
}

#[test]
fn a_flock_travels_whole_and_only_what_is_new_is_fetched() {
    let (stick, unit) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (one, two) = (flock(20, 0), flock(20, 1));
    press(stick.path(), &one, &["lobby", "stairs"], 1, "artist");
    let mut store = store(unit.path());
    assert_eq!(playing(unit.path()), None);
    let all: usize = one.values().map(Vec::len).sum();
    assert_eq!(update(&mut store, stick.path()), all as u64);
    assert_eq!(playing(unit.path()), Some(one.clone()));
    store.accept().unwrap();
    press(stick.path(), &two, &[], 2, "artist");
    press(stick.path(), &two, &["lobby"], 2, "artist");
    assert_eq!(update(&mut store, stick.path()), two["loops/0.mp4"].len() as u64);
    assert_eq!(playing(unit.path()), Some(two));
    let shared = fs::metadata(unit.path().join("current/loops/7.mp4")).unwrap();
    assert_eq!((shared.nlink(), shared.mode() & 0o777), (3, 0o444), "one object, two generations");
}

#[test]
fn a_lost_trial_brings_the_last_good_flock_back_and_is_remembered() {
    let (stick, unit_folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let mut store = store(unit_folder.path());
    press(stick.path(), &flock(3, 0), &["lobby"], 1, "artist");
    update(&mut store, stick.path());
    store.accept().unwrap();
    press(stick.path(), &flock(3, 1), &["lobby"], 2, "artist");
    update(&mut store, stick.path());
    for _ in 0..STARTS {
        assert_eq!(store.record_start().unwrap(), Verdict::Open);
    }
    assert_eq!(store.record_start().unwrap(), Verdict::Lost);
    assert_eq!(playing(unit_folder.path()), Some(flock(3, 0)));
    let bad = verified(stick.path(), store.trust()).unwrap();
    let lobby = unit("lobby");
    assert!(matches!(store.admit(bad.seal(), &lobby, Consent::Newer), Err(Refusal::MarkedBad { .. })));
    assert_eq!(store.admit(bad.seal(), &lobby, Consent::Any).unwrap(), Admission::New);
    // Mended, it may come with the same number.
    press(stick.path(), &flock(3, 2), &["lobby"], 2, "artist");
    update(&mut store, stick.path());
    store.accept().unwrap();
    store.collect(None).unwrap();
    assert_eq!(playing(unit_folder.path()), Some(flock(3, 2)));
    assert_eq!(fs::read_dir(unit_folder.path().join("generations")).unwrap().count(), 2);
    // Of the flock that lost nothing is left, but for what the two that stay have too.
    let kept: BTreeSet<_> = [flock(3, 0), flock(3, 2)].into_iter().flat_map(Files::into_values).collect();
    let there: Vec<_> = files_in(&unit_folder.path().join("objects")).unwrap().into_values().collect();
    assert_eq!((there.len(), there.into_iter().collect()), (kept.len(), kept));
}

#[test]
fn what_is_not_newer_is_refused_for_each_key_by_itself() {
    let (stick, unit_folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let lobby = unit("lobby");
    let both = || Trust::of([key("artist").public(), key("spare").public()]);
    let mut store = Store::open(Box::new(LocalDisk::open(unit_folder.path()).unwrap()), both()).unwrap();
    press(stick.path(), &flock(2, 0), &[], 7, "artist");
    update(&mut store, stick.path());
    let admit = |store: &Store, sequence, who: &'static str, consent| {
        press(stick.path(), &flock(2, 1), &[], sequence, who);
        let bundle = verified(stick.path(), store.trust()).unwrap();
        store.admit(bundle.seal(), &lobby, consent)
    };
    assert!(admit(&store, 6, "artist", Consent::Newer).is_err(), "older than what is on trial");
    store.accept().unwrap();
    for sequence in [1, 6, 7] {
        let refused = admit(&store, sequence, "artist", Consent::Newer).unwrap_err();
        assert!(matches!(refused, Refusal::Older { floor: Sequence(7), .. }), "{refused}");
        assert_eq!(admit(&store, sequence, "artist", Consent::Any).unwrap(), Admission::New);
    }
    assert_eq!(admit(&store, 8, "artist", Consent::Newer).unwrap(), Admission::New);
    assert_eq!(admit(&store, 1, "spare", Consent::Newer).unwrap(), Admission::New);
    // The floor outlives the process and either copy of the state.
    drop(store);
    fs::write(unit_folder.path().join("state.1"), "").unwrap();
    let store = Store::open(Box::new(LocalDisk::open(unit_folder.path()).unwrap()), both()).unwrap();
    assert!(admit(&store, 7, "artist", Consent::Newer).is_err());
    // And both.
    drop(store);
    for slot in ["state.0", "state.1"] {
        fs::write(unit_folder.path().join(slot), "").unwrap();
    }
    let store = Store::open(Box::new(LocalDisk::open(unit_folder.path()).unwrap()), both()).unwrap();
    assert!(admit(&store, 7, "artist", Consent::Newer).is_err());
    assert_eq!(playing(unit_folder.path()), Some(flock(2, 0)));
}

#[test]
fn what_a_newer_program_has_written_is_kept_by_one_that_does_not_know_it() {
    let (stick, unit_folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let mut there = store(unit_folder.path());
    press(stick.path(), &flock(2, 0), &[], 7, "artist");
    update(&mut there, stick.path());
    there.accept().unwrap();
    press(stick.path(), &flock(2, 1), &[], 8, "artist");
    update(&mut there, stick.path());
    let word = Statement::Revoke(key("artist").public().id()).sign(key("artist")).unwrap();
    there.learn(&word).unwrap();
    drop(there);
    // What is to come, in every part of the state.
    let parts = [
        ("{", "\"moons\":{\"of\":[1,null]},"),
        ("\"good\":{", "\"phase\":\"full\","),
        ("\"trial\":{", "\"tide\":\"low\","),
        ("\"generation\":{", "\"wind\":3,"),
    ];
    let newer = |text: &str| {
        let body = text.split_once('\n').unwrap().1.trim_end().to_owned();
        let body = parts.iter().fold(body, |body, (part, more)| body.replacen(part, &format!("{part}{more}"), 1));
        let sum = ObjectId::of(format!("9 {body}").as_bytes());
        format!("dreams-state-1 9 {sum}\n{body}\n")
    };
    let slots = ["state.0", "state.1"].map(|name| unit_folder.path().join(name));
    for slot in &slots {
        fs::write(slot, newer(&fs::read_to_string(slot).unwrap())).unwrap();
    }
    let kept = |known: [bool; 4]| {
        for text in slots.each_ref().map(|slot| fs::read_to_string(slot).unwrap()) {
            assert_eq!(parts.map(|(_, more)| text.contains(more.trim_end_matches(','))), known, "{text}");
        }
    };
    let mut there = store(unit_folder.path());
    assert_eq!(there.state().floors[&key("artist").public().id()], Sequence(7));
    assert_eq!(there.trust().keys().count(), 0, "what was called back stays called back");
    there.record_start().unwrap();
    kept([true; 4]);
    // What is told of a generation goes with it.
    there.reject().unwrap();
    kept([true, true, false, false]);
    there.drop_good().unwrap();
    kept([true, false, false, false]);
}

#[test]
fn a_bundle_for_another_unit_is_refused_with_both_names() {
    let stick = tempfile::tempdir().unwrap();
    press(stick.path(), &flock(1, 0), &["attic", "stairs"], 1, "artist");
    let from = stick.path().join("seals");
    fs::copy(from.join("attic.seal"), from.join("lobby.seal")).unwrap();
    let bundle = verified(stick.path(), &trust()).unwrap();
    let unit_folder = tempfile::tempdir().unwrap();
    let refused = store(unit_folder.path()).admit(bundle.seal(), &unit("lobby"), Consent::Any).unwrap_err();
    assert_eq!(refused.to_string(), "the bundle is for `attic, stairs`, this unit is `lobby`");
}

#[test]
fn a_new_key_is_learned_once_and_kept() {
    let (stick, unit_folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    press(stick.path(), &flock(1, 0), &[], 1, "spare");
    let mut there = store(unit_folder.path());
    assert!(matches!(verified(stick.path(), there.trust()), Err(Refusal::UnknownKey { .. })));
    let word = Statement::Trust(key("spare").public()).sign(key("artist")).unwrap();
    assert_eq!(there.learn(&word).unwrap().news, [TrustChange::Trusted(key("spare").public().id())]);
    assert_eq!(there.learn(&word).unwrap().news, []);
    drop(there);
    let mut there = store(unit_folder.path());
    assert!(verified(stick.path(), there.trust()).is_ok());
    let word = Statement::Revoke(key("spare").public().id()).sign(key("spare")).unwrap();
    there.learn(&word).unwrap();
    drop(there);
    let there = store(unit_folder.path());
    assert!(matches!(verified(stick.path(), there.trust()), Err(Refusal::RevokedKey { .. })));
}

#[test]
fn what_fell_is_forgotten_and_what_a_key_said_is_kept_while_the_owner_has_taken_it_away() {
    let unit_folder = tempfile::tempdir().unwrap();
    let open = |names: &[&'static str]| {
        let pinned = Trust::of(names.iter().map(|name| key(name).public()));
        Store::open(Box::new(LocalDisk::open(unit_folder.path()).unwrap()), pinned).unwrap()
    };
    let (artist, word) = (key("artist").public().id(), Statement::Trust(key("stranger").public()));
    let words = ["artist", "spare"].map(|name| word.sign(key(name)).unwrap());
    assert_eq!(open(&["artist", "spare"]).learn(&words.concat()).unwrap().news.len(), 2);
    let mut there = open(&["artist"]);
    assert_eq!(there.trust().keys().count(), 2);
    let stolen = Statement::Stolen(artist, [].into()).sign(key("artist")).unwrap();
    let news = there.learn(&stolen).unwrap().news;
    assert_eq!(news, [TrustChange::Revoked(artist), TrustChange::Fallen(key("stranger").public().id())]);
    let kept = [&words[1], &stolen].map(|word| String::from_utf8(word.clone()).unwrap());
    assert_eq!((there.trust().keys().count(), &there.state().statements[..]), (0, &kept[..]));
    drop(there);
    let there = open(&["artist", "spare"]);
    let trusted: Vec<_> = there.trust().keys().map(bundle::PublicKey::id).collect();
    assert!(trusted.len() == 2 && !trusted.contains(&artist), "{trusted:?}");
}

#[test]
fn a_fetch_goes_on_where_it_was_and_damage_never_becomes_an_object() {
    let (stick, unit_folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let files = flock(4, 0);
    press(stick.path(), &files, &[], 1, "artist");
    let mut store = store(unit_folder.path());
    let bundle = verified(stick.path(), store.trust()).unwrap();
    assert!(matches!(store.install(&bundle), Err(StoreError::Missing { missing: 5, objects: 5 })));
    let wanted = store.plan(&bundle).unwrap().wanted;
    assert_eq!(wanted[0].path.as_str(), "flock.toml");
    let clip = wanted.iter().find(|wanted| wanted.path.as_str() == "loops/2.mp4").unwrap();
    let bytes = &files["loops/2.mp4"];
    for half in [&bytes[..100], &bytes[100..300]] {
        store.intake(clip).unwrap().append(half).unwrap();
    }
    let planned = store.plan(&bundle).unwrap();
    assert_eq!(planned.wanted.iter().find(|wanted| wanted.id == clip.id).unwrap().have, 300);
    assert_eq!(planned.to_fetch(), planned.bytes - 300);
    let intake = store.intake(clip).unwrap();
    assert!(matches!(intake.finish(), Err(StoreError::Incomplete { have: 300, .. })));
    let mut intake = store.intake(clip).unwrap();
    assert_eq!(intake.have(), 300);
    intake.append(&vec![7; bytes.len() - 300]).unwrap();
    assert!(matches!(intake.finish(), Err(StoreError::Damaged { .. })));
    let mut intake = store.intake(clip).unwrap();
    assert_eq!(intake.have(), 0, "what was damaged is not built upon");
    assert!(matches!(intake.append(&[&bytes[..], b"x"].concat()), Err(StoreError::TooLong { .. })));
    drop(intake);
    fetch(&store, stick.path(), &bundle);
    store.install(&bundle).unwrap();
    assert_eq!(playing(unit_folder.path()), Some(files));
}

#[test]
fn what_is_damaged_stays_in_its_place_until_what_was_fetched_again_takes_it() {
    let (stick, unit_folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let files = flock(5, 0);
    press(stick.path(), &files, &[], 1, "artist");
    let mut store = store(unit_folder.path());
    update(&mut store, stick.path());
    assert_eq!(store.scrub(|_| true).unwrap().whole, 6);
    let (clip, gone) = (unit_folder.path().join("current/loops/3.mp4"), unit_folder.path().join("current/loops/1.mp4"));
    fs::remove_file(gone).unwrap();
    // Rot: the same file, other bytes.
    let rot = fs::OpenOptions::new().write(true).open(&clip);
    std::os::unix::fs::FileExt::write_at(&rot.unwrap(), b"rot", 40).unwrap();
    let found = store.scrub(|_| true).unwrap();
    assert_eq!((found.whole, found.damaged.len(), found.damaged[0].path.as_str()), (5, 1, "loops/3.mp4"));
    assert!(fs::read(&clip).unwrap() != files["loops/3.mp4"], "the player meets it as it is");
    assert_eq!(store.missing().unwrap(), found.damaged);
    store.repair().unwrap();
    assert!(clip.exists(), "there is nothing yet that could take its place");
    let bundle = verified(stick.path(), store.trust()).unwrap();
    fetch(&store, stick.path(), &bundle);
    store.repair().unwrap();
    assert_eq!(playing(unit_folder.path()), Some(files));
    assert_eq!(store.missing().unwrap(), []);
}

/// Marks so many objects as unreadable; returns their paths and those of the marks.
fn spoil(store: &Path, count: usize) -> Vec<(PathBuf, PathBuf)> {
    let objects = files_in(&store.join("objects")).unwrap();
    let marked = |name: &String| {
        let object = store.join("objects").join(name);
        let mark = store.join("objects").join(format!("{name}{BAD}"));
        fs::write(&mark, "").unwrap();
        (object, mark)
    };
    objects.keys().take(count).map(marked).collect()
}

#[test]
fn unreadable_objects_stay_and_a_failing_disk_is_left_alone() {
    let (stick, unit_folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let files = flock(20, 0);
    press(stick.path(), &files, &[], 1, "artist");
    let disk = LocalDisk::open(unit_folder.path()).unwrap();
    let disk = Careless { disk, carelessness: Carelessness::BadSectors, meanwhile: |_| () };
    let mut store = Store::open(Box::new(disk), trust()).unwrap();
    update(&mut store, stick.path());
    let spoiled = spoil(unit_folder.path(), limits::UNREAD);
    let found = store.scrub(|_| true).unwrap();
    assert_eq!((found.is_failing, found.unread.len(), found.damaged.len()), (true, limits::UNREAD, 0));
    assert_eq!(playing(unit_folder.path()).as_ref(), Some(&files));
    assert!(spoiled.iter().all(|(object, _)| object.exists()), "a disk that fails is left as it is");
    // Fewer of them are fetched again, unless the disk gives them after all.
    fs::remove_file(&spoiled[0].1).unwrap();
    let found = store.scrub(|_| true).unwrap();
    assert_eq!((found.is_failing, found.unread.len()), (false, limits::UNREAD - 1));
    assert_eq!(playing(unit_folder.path()).as_ref(), Some(&files));
    let missing = store.missing().unwrap();
    assert_eq!(missing.len(), limits::UNREAD - 1);
    for wanted in &missing[1..] {
        fs::write(unit_folder.path().join(format!("aside/{}{BAD}", wanted.id)), "").unwrap();
    }
    assert_eq!(missing.iter().map(|wanted| store.restore(wanted).unwrap()).filter(|is_back| *is_back).count(), 1);
    assert_eq!(store.missing().unwrap().len(), limits::UNREAD - 2);
}

#[test]
fn an_object_of_another_kind_is_missing_not_unreadable() {
    let (stick, unit_folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let files = flock(20, 0);
    press(stick.path(), &files, &[], 1, "artist");
    let mut store = store(unit_folder.path());
    update(&mut store, stick.path());
    for name in files_in(&unit_folder.path().join("objects")).unwrap().keys() {
        let object = unit_folder.path().join("objects").join(name);
        fs::remove_file(&object).unwrap();
        fs::create_dir_all(object.join("of another program")).unwrap();
    }
    let found = store.scrub(|_| true).unwrap();
    assert_eq!((found.whole, found.is_failing, found.unread.len()), (0, false, 0));
    assert_eq!(store.missing().unwrap().len(), 21);
    let bundle = verified(stick.path(), store.trust()).unwrap();
    fetch(&store, stick.path(), &bundle);
    store.repair().unwrap();
    assert_eq!(store.scrub(|_| true).unwrap().whole, 21);
    assert_eq!(playing(unit_folder.path()), Some(files));
}

#[test]
fn a_flock_that_the_disk_lost_is_taken_again_from_its_own_stick() {
    let (stick, unit_folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let files = flock(3, 0);
    press(stick.path(), &files, &["lobby"], 5, "artist");
    let mut there = store(unit_folder.path());
    update(&mut there, stick.path());
    there.accept().unwrap();
    drop(there);
    for lost in ["objects", "generations/1/flock"] {
        fs::remove_dir_all(unit_folder.path().join(lost)).unwrap();
    }
    let mut there = store(unit_folder.path());
    assert_eq!((playing(unit_folder.path()), there.state().floors.len()), (None, 1), "what was played is known");
    update(&mut there, stick.path());
    there.accept().unwrap();
    assert_eq!(playing(unit_folder.path()), Some(files));
    // Nothing older is, and nothing else with the same number while it is there.
    for (sequence, edition) in [(4, 1), (5, 2)] {
        press(stick.path(), &flock(3, edition), &["lobby"], sequence, "artist");
        let other = verified(stick.path(), there.trust()).unwrap();
        let refused = there.admit(other.seal(), &unit("lobby"), Consent::Newer);
        assert!(matches!(refused, Err(Refusal::Older { .. })), "{sequence}");
    }
}

#[test]
fn a_second_updater_waits_outside() {
    let folder = tempfile::tempdir().unwrap();
    let first = LocalDisk::open(folder.path()).unwrap();
    assert_eq!(LocalDisk::open(folder.path()).unwrap_err().kind(), std::io::ErrorKind::WouldBlock);
    drop(first);
    LocalDisk::open(folder.path()).unwrap();
}

#[test]
fn the_player_judges_while_an_updater_is_at_work_and_neither_forgets_what_the_other_wrote() {
    let (stick, unit_folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let current = unit_folder.path().join(CURRENT);
    assert_eq!(CurrentGeneration::of(&current).unwrap_err().kind(), std::io::ErrorKind::NotFound);
    let mut store = store(unit_folder.path());
    press(stick.path(), &flock(3, 0), &[], 1, "artist");
    update(&mut store, stick.path());
    let first = CurrentGeneration::of(&current).unwrap().unwrap();
    let judge = first.recorder().unwrap();
    assert!(judge.is_on_trial(1) && !judge.is_on_trial(2));
    assert_eq!(judge.record_start(1).unwrap(), Verdict::Open);
    judge.reject(7).unwrap();
    judge.accept(1).unwrap();
    assert!(!judge.is_on_trial(1));
    // The updater still holds the lock, and knows nothing of it.
    press(stick.path(), &flock(3, 1), &[], 2, "artist");
    update(&mut store, stick.path());
    assert_eq!(store.state().good.as_ref().map(|good| good.number), Some(1));
    assert!(first.is_replaced() && first.folder().join("flock.toml").exists());
    let second = CurrentGeneration::of(&current).unwrap().unwrap();
    assert_eq!(second.number(), 2);
    for _ in 0..STARTS {
        assert_eq!(judge.record_start(2).unwrap(), Verdict::Open);
    }
    assert_eq!(judge.record_start(2).unwrap(), Verdict::Lost);
    assert!(second.is_replaced() && !first.is_replaced());
    assert_eq!(playing(unit_folder.path()), Some(flock(3, 0)));
}

#[test]
fn what_is_on_the_glass_stays_on_the_disk_until_the_player_has_changed_over() {
    let (stick, unit_folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let mut store = store(unit_folder.path());
    press(stick.path(), &flock(3, 0), &[], 1, "artist");
    update(&mut store, stick.path());
    let shown = CurrentGeneration::of(&unit_folder.path().join(CURRENT)).unwrap().unwrap();
    // Replaced before its trial was over: nothing else keeps it.
    press(stick.path(), &flock(3, 1), &[], 2, "artist");
    update(&mut store, stick.path());
    store.collect(None).unwrap();
    assert!(shown.folder().join("loops/0.mp4").exists());
    let folder = shown.folder();
    drop(shown);
    store.collect(None).unwrap();
    assert!(!folder.exists());
}

#[test]
fn a_flock_in_a_plain_folder_is_no_generation() {
    let folder = tempfile::tempdir().unwrap();
    assert!(CurrentGeneration::of(folder.path()).unwrap().is_none());
    fs::create_dir(folder.path().join(CURRENT)).unwrap();
    assert!(CurrentGeneration::of(&folder.path().join(CURRENT)).unwrap().is_none());
    let linked = folder.path().join("linked");
    fs::create_dir(&linked).unwrap();
    std::os::unix::fs::symlink("../somewhere/else", linked.join(CURRENT)).unwrap();
    assert!(CurrentGeneration::of(&linked.join(CURRENT)).unwrap().is_none());
}
