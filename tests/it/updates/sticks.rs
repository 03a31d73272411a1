//! Updates from a stick: a flock is installed whole, or the unit keeps the one that it has.
//!
//! Owns the claims on `dreams-update` with a stick: what it installs, what it refuses and with which words.
//! Interruptions are in `interruptions.rs`.
//!
//! Start at [`Unit`].

use claims::bundle_maker::{Files, rubbish};
use claims::programs::{self, json, output};
use claims::unit::Unit;
use claims::wait;
use rustix::fs::{FlockOperation, flock};
use rustix::process::{Pid, Signal, kill_process};
use std::fs;
use std::io::BufReader;
use std::path::Path;
use std::process::{Command, Stdio};

#[test]
fn a_stick_brings_a_flock_and_the_next_one_only_what_is_new() {
    let unit = Unit::new();
    let (one, two) = (rubbish(20, 30_000, 0), rubbish(20, 30_000, 1));
    unit.maker.bundle(&unit.stick(), &one, &["lobby", "stairs"], 1);
    let answer = unit.updated(&[]);
    let all: usize = one.values().map(Vec::len).sum();
    assert_eq!(
        (&answer["outcome"], &answer["flock"], &answer["sequence"]),
        (&"installed".into(), &"aurora".into(), &1.into())
    );
    assert_eq!((answer["fetched"].as_u64(), answer["fetched_bytes"].as_u64()), (Some(21), Some(all as u64)));
    assert_eq!(unit.playing(), Some(one));
    assert_eq!(unit.notice().as_deref(), Some("The new flock is here. You may remove the stick."));

    let answer = unit.updated(&[]);
    assert_eq!((&answer["outcome"], answer["fetched_bytes"].as_u64()), (&"no-news".into(), Some(0)));
    assert_eq!(unit.notice().as_deref(), Some("This flock is here already. You may remove the stick."));

    unit.maker.bundle(&unit.stick(), &two, &[], 2);
    unit.maker.bundle(&unit.stick(), &two, &["lobby"], 2);
    let answer = unit.updated(&[]);
    assert_eq!((answer["sequence"].as_u64(), answer["fetched_bytes"].as_u64()), (Some(2), Some(30_000)));
    assert_eq!(unit.playing(), Some(two));
    let plain = output(unit.update_from(Some(&unit.stick())).arg("--scrub"));
    assert_eq!(plain.status.code(), Some(0), "every byte of the store is what it should be");
    assert_eq!(json(&plain)["missing"], 0);
}

#[test]
fn a_stick_put_in_while_another_one_is_read_waits_for_its_turn_and_is_not_lost() {
    let unit = Unit::new();
    let (one, two) = (rubbish(20, 30_000, 0), rubbish(20, 30_000, 1));
    unit.maker.bundle(&unit.stick(), &one, &[], 1);
    unit.maker.bundle(&unit.path("second"), &two, &[], 2);
    // Half a megabyte at 100 KiB a second: long enough that the second one comes meanwhile.
    let slow = unit.path("update.toml");
    fs::write(&slow, "bandwidth_kib = 100\n").unwrap();
    let mut first = unit.update_from(Some(&unit.stick())).arg("--config").arg(slow).spawn().unwrap();
    wait::until("the first stick is read", 60, || unit.notice().is_some());
    let answer = output(&mut unit.update_from(Some(&unit.path("second"))));
    assert_eq!(answer.status.code(), Some(0), "{}", String::from_utf8_lossy(&answer.stderr));
    assert!(first.try_wait().unwrap().is_some_and(|ended| ended.success()), "the first one was read to its end before");
    let answer = json(&answer);
    let found = (answer["outcome"].as_str(), answer["sequence"].as_u64(), answer["fetched"].as_u64());
    assert_eq!(found, (Some("installed"), Some(2), Some(1)), "only what the first one did not have");
    assert_eq!(unit.playing(), Some(two));
}

#[test]
fn a_stick_that_waits_for_another_ends_when_it_is_pulled_and_a_look_on_a_schedule_does_not_wait() {
    let unit = Unit::new();
    unit.maker.bundle(&unit.stick(), &rubbish(3, 5_000, 0), &[], 1);
    fs::create_dir(unit.path("store")).unwrap();
    let lock = fs::File::create(unit.path("store/lock")).unwrap();
    flock(&lock, FlockOperation::LockExclusive).unwrap();
    let said = unit.update(&["--schedule", unit.path("schedule").to_str().unwrap()]);
    assert_eq!(said.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&said.stderr).contains("another update is at work"));

    let mut waiting = unit.update_from(Some(&unit.stick())).stderr(Stdio::piped()).spawn().unwrap();
    let mut told = BufReader::new(waiting.stderr.take().unwrap());
    let line = wait::line("that it waits", 60, &mut told);
    assert!(line.contains("waiting for another update"), "{line}");
    kill_process(Pid::from_child(&waiting), Signal::TERM).unwrap();
    assert_eq!(wait::ended("the update that waits", 60, &mut waiting).code(), Some(3));
    assert_eq!(unit.playing(), None);
}

/// A stick that is refused.
struct Refusal<'p> {
    case: &'static str,
    prepare: Box<dyn Fn(&Path) + 'p>,
    reserve_mib: u64,
    code: i32,
    /// What standard error says.
    said: &'static str,
    /// The beginning of the notice.
    told: &'static str,
}

/// Gives each stick to a unit that plays `good`.
fn refuses(unit: &Unit, good: &Files, refusals: &[Refusal<'_>]) {
    unit.maker.bundle(&unit.stick(), good, &[], 7);
    unit.updated(&[]);
    for Refusal { case, prepare, reserve_mib, code, said, told } in refusals {
        fs::remove_dir_all(unit.stick()).unwrap();
        prepare(&unit.stick());
        let config = unit.path("update.toml");
        fs::write(&config, format!("reserve_mib = {reserve_mib}\n")).unwrap();
        let output = unit.update(&["--config", config.to_str().unwrap()]);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(*code), "{case}: {error}");
        assert!(output.stdout.is_empty(), "{case}: complaints go to standard error");
        assert!(error.contains(said) && error.contains("\nhint: "), "{case}: {error}");
        assert!(unit.notice().unwrap().starts_with(told), "{case}: {:?}", unit.notice());
        assert_eq!(unit.playing().as_ref(), Some(good), "{case}");
    }
}

#[test]
fn a_stick_that_is_refused_changes_nothing_and_says_why_in_one_sentence() {
    let unit = Unit::new();
    let (maker, other) = (&unit.maker, rubbish(3, 5_000, 1));
    let refusals = [
        Refusal {
            case: "for other units",
            prepare: Box::new(|stick| maker.bundle(stick, &other, &["attic", "stairs"], 9)),
            reserve_mib: 0,
            code: 1,
            said: "none for `lobby`",
            told: "This stick is for attic, stairs. This frame is lobby.",
        },
        Refusal {
            case: "readdressed",
            prepare: Box::new(|stick| {
                maker.bundle(stick, &other, &["stairs"], 9);
                fs::rename(stick.join("seals/stairs.seal"), stick.join("seals/lobby.seal")).unwrap();
            }),
            reserve_mib: 0,
            code: 1,
            said: "is for `stairs`, this unit is `lobby`",
            told: "This stick is for stairs. This frame is lobby.",
        },
        Refusal {
            case: "forged",
            prepare: Box::new(|stick| maker.forgery(stick, &other, &["lobby"], 9)),
            reserve_mib: 0,
            code: 1,
            said: "is not trusted (trusted: ",
            told: "This flock is not signed by anybody whom this frame trusts.",
        },
        Refusal {
            case: "older",
            prepare: Box::new(|stick| maker.bundle(stick, &other, &[], 6)),
            reserve_mib: 0,
            code: 1,
            said: "has sequence 6, but this unit has already played 7 of key",
            told: "This flock is number 6. This frame has already played number 7.",
        },
    ];
    refuses(&unit, &rubbish(3, 5_000, 0), &refusals);
}

#[test]
fn a_stick_that_turns_out_bad_changes_nothing_and_says_why_in_one_sentence() {
    let unit = Unit::new();
    let (maker, other) = (&unit.maker, rubbish(3, 5_000, 1));
    let clip = object(&other["loops/0.mp4"]);
    let refusals = [
        Refusal {
            case: "too large",
            prepare: Box::new(|stick| maker.bundle(stick, &rubbish(1, 9_000, 1), &[], 9)),
            reserve_mib: 1 << 20,
            code: 1,
            said: "there is no room",
            told: "There is no room for this flock: ",
        },
        Refusal {
            case: "no flock",
            prepare: Box::new(|stick| {
                let toml = Files::from([("flock.toml".to_owned(), b"format = 2\n".to_vec())]);
                maker.bundle(stick, &toml, &[], 9);
            }),
            reserve_mib: 0,
            code: 1,
            said: "`format`",
            told: "This flock is damaged, or was made wrongly.",
        },
        Refusal {
            case: "without a clip",
            prepare: Box::new(|stick| {
                maker.bundle(stick, &other, &[], 9);
                fs::remove_file(stick.join(&clip)).unwrap();
            }),
            reserve_mib: 0,
            code: 3,
            said: "cannot read `loops/0.mp4`",
            told: "The stick could not be read to its end. Put it in again, and the rest follows.",
        },
        Refusal {
            case: "damaged",
            prepare: Box::new(|stick| {
                maker.bundle(stick, &other, &[], 9);
                fs::write(stick.join(&clip), vec![7; 5_000]).unwrap();
            }),
            reserve_mib: 0,
            code: 3,
            said: "`loops/0.mp4` was received damaged",
            told: "This stick is damaged: loops/0.mp4 is not what it should be.",
        },
    ];
    refuses(&unit, &rubbish(3, 5_000, 0), &refusals);
}

/// The path in a bundle of an object with these bytes.
pub(crate) fn object(bytes: &[u8]) -> String {
    bundle::ObjectId::of(bytes).path()
}

#[test]
fn a_stick_without_any_bundle_is_nobodys_business() {
    let unit = Unit::new();
    for name in ["IMG_0001.JPG", "seals.txt", "objects"] {
        fs::write(unit.stick().join(name), "holiday").unwrap();
    }
    assert_eq!(unit.updated(&[])["outcome"], "no-bundle");
    assert_eq!(unit.notice(), None);
    assert_eq!(unit.playing(), None);
}

#[test]
fn the_owner_may_go_back_on_the_machine_itself() {
    let unit = Unit::new();
    let (old, new) = (rubbish(2, 2_000, 0), rubbish(2, 2_000, 1));
    unit.maker.bundle(&unit.stick(), &new, &[], 2);
    unit.updated(&[]);
    unit.maker.bundle(&unit.stick(), &old, &[], 1);
    assert_eq!(unit.update(&[]).status.code(), Some(1));
    assert_eq!(unit.updated(&["--allow-older"])["sequence"], 1);
    assert_eq!(unit.playing(), Some(old));
}

#[test]
fn a_new_key_travels_with_the_bundle_that_it_has_signed() {
    let unit = Unit::new();
    let files = rubbish(2, 2_000, 0);
    unit.maker.forgery(&unit.stick(), &files, &[], 1);
    assert_eq!(unit.update(&[]).status.code(), Some(1));
    unit.maker.vouch(&unit.stick());
    assert_eq!(unit.updated(&[])["outcome"], "installed");
    assert_eq!(unit.playing(), Some(files));
}

#[test]
fn what_rots_in_the_store_stays_until_it_was_fetched_again() {
    let unit = Unit::new();
    let files = rubbish(5, 20_000, 0);
    unit.maker.bundle(&unit.stick(), &files, &[], 1);
    unit.updated(&[]);
    let clip = unit.path("store/current/loops/3.mp4");
    // Rot: the same file, other bytes; a rewritten file would be another one.
    let rotten = unit.path("store").join(object(&files["loops/3.mp4"]));
    rot(&rotten);
    let damaged = fs::read(&clip).unwrap();
    let gone = unit.stick().join(object(&files["loops/3.mp4"]));
    fs::rename(&gone, unit.path("kept")).unwrap();
    let answer = unit.updated(&["--scrub"]);
    assert_eq!((answer["missing"].as_u64(), answer["mended"].as_u64()), (Some(1), Some(0)));
    assert!(fs::read(&clip).unwrap() == damaged && damaged != files["loops/3.mp4"], "the player meets it as it is");
    fs::rename(unit.path("kept"), &gone).unwrap();
    let answer = unit.updated(&[]);
    assert_eq!((answer["missing"].as_u64(), answer["mended"].as_u64()), (Some(0), Some(1)));
    assert_eq!(answer["fetched_bytes"], 20_000);
    assert_eq!(unit.playing(), Some(files));
}

/// Changes bytes in the file, as a failing disk does: a file under fs-verity is replaced by a new one.
fn rot(path: &Path) {
    use std::os::unix::fs::FileExt;
    let open = fs::OpenOptions::new().write(true).open(path);
    open.unwrap().write_at(b"rot", 40).unwrap();
}

#[test]
fn every_refusal_of_the_updater_has_its_exit_code_and_names_what_it_refuses() {
    let unit = Unit::new();
    let config = unit.path("update.toml");
    fs::write(&config, "reserve_mib = 1\nbrightness = 3\n").unwrap();
    let no_key = unit.path("keys");
    fs::create_dir(&no_key).unwrap();
    fs::write(no_key.join("a.pub"), "no key").unwrap();
    let (config, no_key) = (config.to_str().unwrap(), no_key.to_str().unwrap());
    let cases: [(&[&str], i32, &[&str]); 6] = [
        (&["--no-such-option"], 2, &["--no-such-option"]),
        (&["--config", config], 2, &["update.toml", "line 2", "`brightness`"]),
        (&["--config", "no/such.toml"], 3, &["no/such.toml"]),
        (&["--keys", no_key], 2, &["a.pub"]),
        (&["--keys", "no/keys"], 3, &["no/keys"]),
        (&["--unit", "The Lobby"], 2, &["The Lobby"]),
    ];
    for (options, code, named) in cases {
        let mut command = Command::new(programs::updater());
        command.arg(unit.stick()).arg("--store").arg(unit.path("store"));
        if options[0] != "--keys" {
            command.arg("--keys").arg(unit.maker.keys());
        }
        let said = output(command.args(options));
        let error = String::from_utf8_lossy(&said.stderr);
        assert_eq!(said.status.code(), Some(code), "{options:?}: {error}");
        assert!(said.stdout.is_empty(), "{options:?}");
        for value in named {
            assert!(error.contains(value), "{options:?} names {value}: {error}");
        }
    }
    let said = output(
        Command::new(programs::updater())
            .arg("no/stick")
            .arg("--store")
            .arg(unit.path("store"))
            .arg("--keys")
            .arg(unit.maker.keys()),
    );
    assert_eq!(said.status.code(), Some(3), "a stick that is not there");
}
