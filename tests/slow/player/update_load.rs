//! An update while the player plays, on the same disk.
//!
//! Owns the claim that no frame is late, and that the test would see it: a process with normal priority makes frames
//! late afterwards. The disk is slow, and time is virtual, so that only waits for the disk count. `make soak` installs
//! 5 GB.

use crate::guest::{script, succeed_in_virtual_time, word};
use claims::bundle_maker::{BundleMaker, Files};
use claims::flocks::SMALL;
use claims::player_run::PlayerRun;
use claims::programs::{player, repository, updater};
use claims::trace::{Flip, Trace};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Bytes of padding after each clip of the update, which MP4 readers skip.
const NOISE: usize = 5_000_000;
/// Vblanks from one frame to the next.
const PACE: u32 = 2;
/// What the disk reads and writes per second.
const SPEED: u64 = 10_000_000;

/// The flock in `folder` with its clips in the folder `edition`, each with this much padding.
fn edition(folder: &Path, edition: &str, noise: usize) -> Files {
    let mut files = Files::new();
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        let mut bytes = fs::read(entry.path()).unwrap();
        if entry.path().extension().is_some_and(|ending| ending == "mp4") {
            bytes.extend_from_slice(&(noise as u32 + 8).to_be_bytes());
            bytes.extend_from_slice(b"free");
            let mut tail = vec![0; noise];
            blake3::Hasher::new().update(name.as_bytes()).finalize_xof().fill(&mut tail);
            bytes.append(&mut tail);
            files.insert(format!("{edition}/{name}"), bytes);
        } else if name == "flock.toml" {
            let text = String::from_utf8(bytes).unwrap();
            let lines = text.lines().filter(|line| !line.starts_with("hash = ")).map(|line| line.to_owned() + "\n");
            let text = lines.collect::<String>().replace("clip = \"", &format!("clip = \"{edition}/"));
            files.insert(name, text.into_bytes());
        }
    }
    files
}

#[test]
fn an_update_on_the_same_slow_disk_makes_no_frame_late() {
    let (flock, maker) = (SMALL.flock(), BundleMaker::with_new_keys());
    let playing = PlayerRun::of(&flock.folder);
    let (before, update) = (playing.path("before"), playing.path("update"));
    maker.bundle(&before, &edition(&flock.folder, "one", 0), &[], 1);
    let new = edition(&flock.folder, "two", NOISE);
    maker.bundle(&update, &new, &[], 2);
    fs::create_dir(playing.path("guest")).unwrap();
    let keys = playing.path("keys");
    fs::rename(maker.keys(), &keys).unwrap();
    let programs = [player(), updater()].map(|program| program.parent().unwrap().to_owned());
    let words = [&playing.path("guest"), &programs[0], &keys, &before, &update].map(|path| word(path));
    let beside = repository().join("tests/soak/beside");
    let run = format!("{} {} 20 500 {SPEED}", word(&beside), words.join(" "));
    succeed_in_virtual_time(300, &script(&run));

    let trace = Trace::read(&playing.path("guest/trace"));
    let end = trace.end.as_ref().expect("the player ended by itself");
    assert_eq!((end.skipped, trace.faults.len()), (0, 0), "{:?}", trace.faults);
    let log = fs::read_to_string(playing.path("guest/log")).unwrap();
    let at =
        |word: &str| -> f64 { log.lines().find_map(|line| line.strip_prefix(word)).unwrap().trim().parse().unwrap() };
    // The same load with normal priority makes frames late.
    let (beside, rudely): (Vec<_>, Vec<_>) = trace.flips.iter().partition(|flip| (flip.t_ns as f64) < at("rude") * 1e9);
    let paces = |flips: &[&Flip]| -> BTreeSet<u32> {
        flips.windows(2).map(|pair| pair[1].vblank.wrapping_sub(pair[0].vblank)).collect()
    };
    assert_eq!(paces(&beside), BTreeSet::from([PACE]));
    assert!(paces(&rudely).len() > 1, "nothing was late beside a rude writer, so nothing is told by {beside:?}");
    let size: usize = new.values().map(Vec::len).sum();
    let seconds = at("ended") - at("began");
    assert!(seconds * SPEED as f64 > 0.9 * size as f64, "the disk was busy with {size} bytes, for only {seconds} s");
    let of = |edition: &str| trace.flips.iter().filter(|flip| flip.clip.starts_with(edition)).count();
    assert!(
        of("one/") as f64 > seconds * 30.0 && of("two/") > 60,
        "both were played: {} and {} frames",
        of("one/"),
        of("two/")
    );
}
