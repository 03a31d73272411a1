//! Bundles on a stick or a server are whole, whatever interrupts the copying.
//!
//! Owns the claims on `dreams diff` and `dreams publish`: what they write, and what a kill, a full disk and a damaged
//! stick leave behind. The content of a bundle is in `bundles.rs`.

use crate::tools::bundles::{Artist, replace};
use claims::programs::{self, output};
use serde_json::Value;
use std::fs::{self, File};
use std::io::Write;
use std::os::unix::fs::{FileExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// `dreams publish bundle STICK --trust artist.pub`.
const PUBLISH: [&str; 5] = ["publish", "bundle", "stick", "--trust", "artist.pub"];
const VERIFY: [&str; 4] = ["verify", "stick", "--trust", "artist.pub"];

/// An artist with an empty folder `stick`.
fn artist() -> Artist {
    let artist = Artist::new();
    fs::create_dir(artist.at("stick")).unwrap();
    artist
}

/// Appends so many bytes of this `edition` to the flock's clip `name`: another clip with the same frames.
fn change(artist: &Artist, name: &str, edition: u8, bytes: usize) {
    let path = artist.at("flock").join(name);
    let before = blake3::hash(&fs::read(&path).unwrap());
    let mut clip = fs::read(&path).unwrap();
    // A box that MP4 readers pass over.
    clip.extend(u32::try_from(bytes + 8).unwrap().to_be_bytes());
    clip.extend(b"free");
    clip.extend((0..bytes).map(|at| (at * 131) as u8 ^ edition));
    replace(&path, &clip);
    let manifest = fs::read_to_string(artist.at("flock/flock.toml")).unwrap();
    let told = manifest.replace(&before.to_string(), &blake3::hash(&clip).to_string());
    assert_ne!(told, manifest, "the manifest tells the clip's hash");
    replace(&artist.at("flock/flock.toml"), told.as_bytes());
}

fn clips(artist: &Artist) -> Vec<String> {
    let names =
        fs::read_dir(artist.at("flock")).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut clips: Vec<String> = names.filter(|name| name.strip_suffix(".mp4").is_some()).collect();
    clips.sort();
    clips
}

/// Every file in `folder`, with its inode and modification time.
fn files(folder: &Path) -> Vec<(PathBuf, u64, i64)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let status = fs::symlink_metadata(&path).unwrap();
            if status.is_dir() { folders.push(path) } else { found.push((path, status.ino(), status.mtime_nsec())) }
        }
    }
    found.sort();
    found
}

fn number(answer: &Value, key: &str) -> u64 {
    answer[key].as_u64().unwrap_or_else(|| panic!("no number `{key}` in {answer}"))
}

#[test]
fn only_what_is_new_is_written_and_what_hangs_where_is_taken_down() {
    let artist = artist();
    let packed = artist.pack(&["--unit", "lobby"]);
    let first = artist.answers(0, &PUBLISH);
    assert_eq!(number(&first, "new_objects"), number(&packed, "files") + 1, "every file, and the list");
    assert_eq!(artist.answers(0, &VERIFY)["bundles"][0]["sequence"], 1);
    let table = artist.at("bundle/fleet.toml");
    let fleet = fs::read_to_string(&table).unwrap();
    fs::write(&table, format!("{fleet}place = \"by the stairs\"\n")).unwrap();
    let before = files(&artist.at("stick"));
    let again = artist.answers(0, &PUBLISH);
    assert_eq!((number(&again, "new_objects"), number(&again, "new_bytes")), (0, 0));

    change(&artist, "s0.mp4", 1, 5000);
    artist.pack(&["--unit", "lobby"]);
    let second = artist.answers(0, &PUBLISH);
    assert_eq!(number(&second, "new_objects"), 3, "the clip, the manifest, the list: {second}");
    let sizes = ["s0.mp4", "flock.toml"].map(|name| fs::metadata(artist.object(name)).unwrap().len());
    let most = (sizes.iter().sum::<u64>() + 5000) as f64;
    assert!(number(&second, "new_bytes") as f64 <= most, "{second}");
    assert_eq!(artist.answers(0, &VERIFY)["bundles"][0]["sequence"], 2);
    let kept: Vec<_> = files(&artist.at("stick")).into_iter().filter(|file| before.contains(file)).collect();
    assert_eq!(kept.len(), before.len() - 1, "all but the seal is as it was");
    let fleet: toml::Table = fs::read_to_string(&table).unwrap().parse().unwrap();
    let row = &fleet["unit"][0];
    let told = ["id", "flock", "place"].map(|key| row[key].as_str().unwrap());
    assert_eq!((told, row["sequence"].as_integer()), (["lobby", "small", "by the stairs"], Some(2)));
    let to = fs::canonicalize(artist.at("stick")).unwrap();
    assert_eq!(row["to"].as_str(), to.to_str());
}

#[test]
fn units_share_what_they_have_in_common_and_each_gets_its_own() {
    let artist = artist();
    let files = number(&artist.pack(&["--unit", "lobby"]), "files");
    change(&artist, "s0.mp4", 1, 100);
    artist.pack(&["--unit", "stairs", "--unit", "attic"]);
    let all = artist.answers(0, &PUBLISH);
    assert_eq!(number(&all, "new_objects"), files + 1 + 3);
    let ids: Vec<_> = all["units"].as_array().unwrap().iter().map(|row| row["id"].as_str().unwrap()).collect();
    assert_eq!(ids, ["attic", "lobby", "stairs"]);
    assert_eq!(artist.answers(0, &VERIFY)["bundles"].as_array().unwrap().len(), 3);
    fs::create_dir(artist.at("other")).unwrap();
    let words = ["publish", "bundle", "other", "--trust", "artist.pub", "--unit", "stairs"];
    assert_eq!(number(&artist.answers(0, &words), "new_objects"), files + 1);
    let seals: Vec<_> = fs::read_dir(artist.at("other/seals")).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(seals, ["stairs.seal"]);
}

#[test]
fn nothing_older_replaces_what_lies_there() {
    let artist = artist();
    artist.pack(&["--unit", "lobby"]);
    output(Command::new("cp").arg("-r").arg(artist.at("bundle")).arg(artist.at("old")));
    artist.pack(&["--unit", "lobby"]);
    artist.answers(0, &PUBLISH);
    let before = files(&artist.at("stick"));
    let said = artist.says(1, &["publish", "old", "stick", "--trust", "artist.pub"]);
    assert!(said.contains("`stick` has sequence 2 of the same key for unit `lobby`, this is 1"), "{said}");
    assert_eq!(files(&artist.at("stick")), before);
    for (code, words, told) in [
        (3, ["publish", "bundle", "nowhere", "--trust", "artist.pub"], "cannot read `nowhere`"),
        (1, ["publish", "bundle", "stick", "--trust", "stranger.pub"], "`seals/lobby.seal` in `bundle` is refused: "),
        (3, ["publish", "stick/seals", "stick", "--trust", "artist.pub"], "cannot read `stick/seals/seals`"),
    ] {
        if words[4] == "stranger.pub" {
            artist.answers(0, &["keygen", "stranger.key", "--passphrase-file", "passphrase"]);
        }
        let said = artist.says(code, &words);
        assert!(said.contains(told), "{said}");
    }
    fs::write(artist.at("bundle/fleet.toml"), "unit = 7\n").unwrap();
    let said = artist.says(2, &PUBLISH);
    assert!(said.contains("`bundle/fleet.toml` is not a table of units"), "{said}");
}

#[test]
fn what_is_damaged_is_not_published_and_what_is_damaged_there_is_replaced() {
    let artist = artist();
    artist.pack(&["--unit", "lobby"]);
    artist.answers(0, &PUBLISH);
    change(&artist, "s0.mp4", 1, 700);
    artist.pack(&["--unit", "lobby"]);
    let clip = artist.object("s0.mp4");
    let good = fs::read(&clip).unwrap();
    let mut bad = good.clone();
    bad[good.len() / 2] ^= 1;
    replace(&clip, &bad);
    let said = artist.says(1, &PUBLISH);
    assert!(said.contains("has changed (expected digest "), "{said}");
    assert_eq!(artist.answers(0, &VERIFY)["bundles"][0]["sequence"], 1, "the stick has its bundle of before");
    replace(&clip, &good);
    artist.answers(0, &PUBLISH);

    // A stick that forgets.
    let path = clip.strip_prefix(artist.at("bundle")).unwrap();
    replace(&artist.at("stick").join(path), &bad);
    artist.answers(1, &VERIFY);
    assert_eq!(number(&artist.answers(0, &PUBLISH), "new_objects"), 0);
    let answer = artist.answers(0, &[&PUBLISH[..], &["--check"]].concat());
    assert_eq!((number(&answer, "new_objects"), number(&answer, "replaced_objects")), (1, 1));
    artist.answers(0, &VERIFY);
}

/// Inverts every byte of every file below `folder`, where they lie.
fn overwrite(folder: &Path) {
    for (path, ..) in files(folder) {
        let inverted: Vec<u8> = fs::read(&path).unwrap().iter().map(|byte| !byte).collect();
        File::options().write(true).open(&path).unwrap().write_all(&inverted).unwrap();
    }
}

#[test]
fn overwriting_what_was_packed_or_published_leaves_the_flock_clean_and_the_other_way_round() {
    let artist = artist();
    let check = |code| artist.answers(code, &["check", "flock"]);
    let verify = |code, folder| artist.answers(code, &["verify", folder, "--trust", "artist.pub"]);
    artist.pack(&["--unit", "lobby"]);
    artist.answers(0, &PUBLISH);
    overwrite(&artist.at("stick"));
    verify(1, "stick");
    verify(0, "bundle");
    overwrite(&artist.at("bundle"));
    verify(1, "bundle");
    check(0);

    for folder in ["stick", "bundle"] {
        fs::remove_dir_all(artist.at(folder)).unwrap();
    }
    fs::create_dir(artist.at("stick")).unwrap();
    artist.pack(&["--unit", "lobby"]);
    artist.answers(0, &PUBLISH);
    for clip in clips(&artist) {
        let file = File::options().write(true).open(artist.at("flock").join(clip)).unwrap();
        file.write_all_at(b"another!", 64).unwrap();
    }
    check(1);
    verify(0, "bundle");
    verify(0, "stick");
}

#[test]
fn what_no_bundle_needs_any_more_goes_when_asked() {
    let artist = artist();
    artist.pack(&["--unit", "lobby"]);
    let old = artist.object("s0.mp4");
    let old = artist.at("stick").join(old.strip_prefix(artist.at("bundle")).unwrap());
    artist.answers(0, &PUBLISH);
    fs::write(artist.at("stick/holiday.jpg"), "not ours").unwrap();
    // What a writer that was killed leaves.
    fs::write(old.with_extension("new"), "half").unwrap();
    change(&artist, "s0.mp4", 1, 700);
    artist.pack(&["--unit", "lobby"]);
    assert_eq!(number(&artist.answers(0, &PUBLISH), "pruned_files"), 0);
    assert!(old.exists() && !old.with_extension("new").exists(), "halves go, what is whole stays until it is told");
    let answer = artist.answers(0, &[&PUBLISH[..], &["--prune"]].concat());
    assert_eq!(number(&answer, "pruned_files"), 3, "the clip, the manifest and the list of before");
    assert!(!old.exists() && artist.at("stick/holiday.jpg").exists());
    artist.answers(0, &VERIFY);
    // What cannot be read might need anything.
    fs::write(artist.at("stick/seals/attic.seal"), "whose is this?").unwrap();
    let said = artist.says(1, &[&PUBLISH[..], &["--prune"]].concat());
    assert!(said.contains("cannot tell what `seals/attic.seal` in `stick` needs"), "{said}");
}

/// An artist with a bundle in `old`, and the next one in `bundle`, with other clips.
fn two_editions() -> Artist {
    let artist = artist();
    artist.pack(&["--unit", "lobby"]);
    output(Command::new("cp").arg("-r").arg(artist.at("bundle")).arg(artist.at("old")));
    for (at, clip) in clips(&artist).iter().enumerate() {
        change(&artist, clip, 2, 20_000 * (at + 1));
    }
    artist.pack(&["--unit", "lobby"]);
    artist
}

/// Runs `script` with a new file system mounted with the options `mount` at the artist's folder `stick`.
fn on_a_small_disk(artist: &Artist, mount: &str, script: &str) -> Output {
    let prepared = format!("mount -t tmpfs -o {mount} none stick || exit 77; ulimit -c 0; {script}");
    let mut unshare = Command::new("unshare");
    if !rustix::process::geteuid().is_root() {
        unshare.args(["--user", "--map-root-user"]);
    }
    unshare.args(["--mount", "bash", "-c", &prepared]).current_dir(artist.at("")).env("DREAMS", programs::dreams());
    let said = output(&mut unshare);
    let refused = said.status.code() == Some(77) || String::from_utf8_lossy(&said.stderr).starts_with("unshare:");
    assert!(!refused, "not tried, no disk was full: this machine lets nobody mount a file system: {}", lines(&said));
    said
}

/// The output of a script on both streams, line by line.
fn lines(said: &Output) -> String {
    [&said.stdout, &said.stderr].map(|text| String::from_utf8_lossy(text).into_owned()).concat()
}

#[test]
fn a_publish_killed_at_any_file_leaves_the_bundle_of_before_and_goes_on_where_it_was() {
    let artist = two_editions();
    // A file that grows beyond a limit is the end of who writes it: SIGXFSZ, at one file after another.
    let script = "
        \"$DREAMS\" publish old stick --trust artist.pub > /dev/null || exit 1
        for limit in 1 40 60 80 100 120 140 160 180 200 220 240 260 280; do
            ( ulimit -f $limit; \"$DREAMS\" publish bundle stick --trust artist.pub --json ) > said 2>&1
            echo \"ended $?\"
            \"$DREAMS\" verify stick --trust artist.pub | sed 's/.*, sequence \\([0-9]*\\) .*/holds \\1/'
        done
        \"$DREAMS\" publish bundle stick --trust artist.pub --json > said || exit 1
        \"$DREAMS\" verify stick --trust artist.pub | sed 's/.*, sequence \\([0-9]*\\) .*/holds \\1/'
        find stick -name '*.new'";
    let said = on_a_small_disk(&artist, "size=64m", script);
    let text = String::from_utf8(said.stdout.clone()).unwrap();
    assert_eq!(said.status.code(), Some(0), "{}", lines(&said));
    let killed = text.matches("ended 153\n").count();
    assert!(killed >= 10, "killed {killed} times: {text}");
    let held: Vec<&str> = text.lines().filter(|line| line.starts_with("holds")).collect();
    assert_eq!(held.len(), 15, "{text}");
    assert!(held[..killed].iter().all(|held| *held == "holds 1") && held[14] == "holds 2", "{text}");
    assert!(!text.contains(".new"), "{text}");
    let mut last = String::new();
    std::io::Read::read_to_string(&mut File::open(artist.at("said")).unwrap(), &mut last).unwrap();
    let last: Value = serde_json::from_str(&last).unwrap();
    let all = clips(&artist).len() as u64 + 2;
    assert_eq!(number(&last, "new_objects") + number(&last, "kept_objects"), all);
    assert!(number(&last, "kept_objects") > 0, "what was written before the kills is not written again: {last}");
}

#[test]
fn a_disk_without_room_is_told_before_anything_is_written_and_one_that_fills_up_loses_nothing() {
    let artist = two_editions();
    let script = "
        \"$DREAMS\" publish old stick --trust artist.pub > /dev/null || exit 1
        find stick -type f | wc -l
        \"$DREAMS\" publish bundle stick --trust artist.pub; echo \"ended $?\"
        find stick -type f | wc -l
        \"$DREAMS\" verify stick --trust artist.pub | sed 's/.*, sequence \\([0-9]*\\) .*/holds \\1/'";
    let said = on_a_small_disk(&artist, "size=1m", script);
    let text = lines(&said);
    let out = String::from_utf8(said.stdout.clone()).unwrap();
    let told: Vec<&str> = out.lines().collect();
    assert_eq!((told[1], told[3]), ("ended 3", "holds 1"), "{text}");
    assert_eq!(told[0], told[2], "nothing was written: {text}");
    assert!(text.contains("error: `stick` has no room: ") && text.contains("hint: --prune"), "{text}");
    // Bytes enough, and then no more files.
    let said = on_a_small_disk(&artist, "size=64m,nr_inodes=60", script);
    let text = lines(&said);
    let out = String::from_utf8(said.stdout.clone()).unwrap();
    let told: Vec<&str> = out.lines().collect();
    assert_eq!((told[1], told[3]), ("ended 3", "holds 1"), "{text}");
    assert!(text.contains("error: cannot write `stick/objects/") && text.contains("No space left on device"), "{text}");
}

#[test]
fn what_nobody_needs_makes_room_for_what_comes_and_what_a_unit_may_need_stays() {
    let artist = two_editions();
    let script = "
        \"$DREAMS\" publish old stick --trust artist.pub > /dev/null || exit 1
        mkdir -p stick/objects/ab
        head -c \"$1\" /dev/zero > stick/objects/ab/$(printf 'c%.0s' $(seq 62))
        \"$DREAMS\" publish bundle stick --trust artist.pub; echo \"ended $?\"
        \"$DREAMS\" publish bundle stick --trust artist.pub --prune; echo \"ended $?\"
        \"$DREAMS\" verify stick --trust artist.pub | sed 's/.*, sequence \\([0-9]*\\) .*/holds \\1/'";
    for (size, left, ended, holds, told) in [
        ("5m", "3m", "ended 0", "holds 2", "hint: --prune removes"),
        ("2m", "1m", "ended 3", "holds 1", "hint: the bundles there stay until the new ones are"),
    ] {
        let said = on_a_small_disk(&artist, &format!("size={size}"), &script.replace("\"$1\"", left));
        let (out, text) = (String::from_utf8(said.stdout.clone()).unwrap(), lines(&said));
        let states: Vec<&str> =
            out.lines().filter(|line| line.starts_with("ended") || line.starts_with("holds")).collect();
        assert_eq!(states, ["ended 3", ended, holds], "{text}");
        assert!(text.contains(told), "{text}");
    }
}

#[test]
fn a_unit_fetches_what_differs_and_nothing_else() {
    let artist = artist();
    artist.pack(&["--unit", "lobby"]);
    let trust = ["--trust", "artist.pub", "--unit", "lobby"];
    let same = artist.answers(0, &[&["diff", "bundle", "flock"], &trust[..]].concat());
    assert_eq!((number(&same, "fetch_objects"), number(&same, "fetch_bytes")), (0, 0));
    output(Command::new("cp").arg("-r").arg(artist.at("flock")).arg(artist.at("before")));
    change(&artist, "s0.mp4", 1, 700);
    // A clip under another name is the same clip.
    fs::rename(artist.at("flock/s1.mp4"), artist.at("flock/one.mp4")).unwrap();
    let manifest = fs::read_to_string(artist.at("flock/flock.toml")).unwrap();
    replace(&artist.at("flock/flock.toml"), manifest.replace("\"s1.mp4\"", "\"one.mp4\"").as_bytes());
    let sizes = ["s0.mp4", "flock.toml"].map(|name| fs::metadata(artist.at("flock").join(name)).unwrap().len());
    for old in ["before", "bundle"] {
        let answer = artist.answers(0, &[&["diff", old, "flock"], &trust[..]].concat());
        assert_eq!(answer["added"], serde_json::json!(["one.mp4"]));
        assert_eq!(answer["changed"], serde_json::json!(["flock.toml", "s0.mp4"]));
        assert_eq!(answer["removed"], serde_json::json!(["s1.mp4"]));
        assert_eq!((number(&answer, "fetch_objects"), number(&answer, "fetch_bytes")), (2, sizes.iter().sum()));
    }
    let said = artist.says(0, &["diff", "before", "flock"]);
    assert!(said.starts_with("+ one.mp4\n~ flock.toml\n~ s0.mp4\n- s1.mp4\na unit would fetch 2 objects, "), "{said}");
    artist.pack(&["--unit", "stairs"]);
    for (words, told) in [
        (&["diff", "bundle", "flock"][..], "cannot be read without a key to trust"),
        (&["diff", "bundle", "flock", "--trust", "artist.pub"], "there are 2 bundles in `bundle`"),
    ] {
        let said = artist.says(2, words);
        assert!(said.contains(told), "{said}");
    }
}
