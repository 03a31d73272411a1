//! Every program of a unit reads what it is given within half of the unit's memory.
//!
//! Owns the claim for every file that others make: each at its limit, in the form that takes the most memory; and that
//! the artist's tools report what is over a limit. The limits are in `crates/bundle`.
//!
//! Start at [`says`].

use crate::metering::{Meter, PEAK_KIB};
use crate::tools::bundles::Artist;
use bundle::{Addressees, Contents, FileEntry, FilePath, Folder, ObjectId, SealBody, Sequence, limits};
use claims::bundle_maker::rubbish;
use claims::flocks::SMALL;
use claims::programs::{self, json};
use claims::unit::Unit;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The most bytes of a table of units.
const FLEET: u64 = 4 << 20;
/// The most bytes of settings.
const SETTINGS: usize = 64 << 10;
const HEAD: &str = "format = 1\nname = \"large\"\nsize = [320, 240]\nfps = [30, 1]\n";

/// Has `command` read the file `name`: it ends with `code`, prints `words`, and keeps to the limit of memory.
fn says(name: &str, command: &Command, code: i64, words: &str) {
    let told = [command.get_program()].into_iter().chain(command.get_args()).map(|word| word.to_str().unwrap());
    let said = Meter::new().run(&told.collect::<Vec<_>>());
    assert!(said.peak_kib <= PEAK_KIB, "{name}: {said:?}");
    assert!(said.code == code && said.stderr.contains(words), "{name}: {said:?}");
}

/// `text`, then `table` for every number from 0 on, up to `bytes` bytes.
fn filled(text: &str, bytes: u64, table: impl Fn(usize) -> String) -> String {
    let mut text = text.to_owned();
    for table in (0..).map(table) {
        if text.len() + table.len() > bytes as usize {
            break;
        }
        text += &table;
    }
    text
}

/// The valid manifests that take the most memory: with the most sheep, and with the most transitions.
fn plain() -> [(&'static str, String); 2] {
    let sheep = |at| format!("[[sheep]]\nid=\"{at:x}\"\n");
    let transition = |at: usize| {
        let (from, to) = (at / 200, at % 200);
        format!("[[transition]]\nfrom=\"{from:x}\"\nto=\"{to:x}\"\nframes={}\nclip=\"s0.mp4\"\n", SMALL.frames)
    };
    let some: String = (0..250).map(sheep).collect();
    let begun = fs::read_to_string(SMALL.flock().folder.join("flock.toml")).unwrap();
    [
        ("sheep", filled(&begun, limits::FLOCK_TOML, sheep)),
        ("transitions", filled(&format!("{begun}{some}"), limits::FLOCK_TOML, transition)),
    ]
}

/// A TOML document of `bytes` bytes in the form that takes the most memory: dotted keys of many parts.
fn dotted(text: &str, bytes: u64) -> String {
    let deep = vec!["a"; 78].join(".");
    let document = filled(text, bytes, |at| format!("k{at}.{deep}=0\n"));
    let rest = bytes as usize - document.len();
    document + &"\n".repeat(rest)
}

/// Writes a bundle for all units to `folder`: with the manifest `toml`, and a list of as many other files as possible,
/// which are not there.
fn lay_with_longest_list(unit: &Unit, folder: &Path, toml: &str) {
    let entry = |path: String, bytes: &[u8], size| FileEntry {
        path: FilePath::new(&path).unwrap(),
        id: ObjectId::of(bytes),
        size,
    };
    let manifest = fs::read_to_string(SMALL.flock().folder.join("flock.toml")).unwrap();
    let clips = manifest.lines().filter_map(|line| line.strip_prefix("clip = \"")?.strip_suffix('"'));
    let mut files: Vec<FileEntry> = clips.map(|clip| entry(clip.to_owned(), clip.as_bytes(), 1)).collect();
    files.push(entry("flock.toml".to_owned(), toml.as_bytes(), toml.len() as u64));
    // A line is a digest, a size of one digit and a path.
    let length = limits::CONTENTS as usize / limits::FILES - 64 - 4;
    let more = limits::FILES - files.len();
    files.extend((0..more).map(|at| entry(format!("{at:0length$}"), &at.to_le_bytes(), 1)));
    let list = Contents::new(files).unwrap().to_text();
    assert!((limits::CONTENTS * 98 / 100..=limits::CONTENTS).contains(&(list.len() as u64)), "{}", list.len());
    let to = Folder::create(folder).unwrap();
    for bytes in [toml.as_bytes(), list.as_bytes()] {
        to.put(&ObjectId::of(bytes), bytes.len() as u64, &mut &bytes[..], folder, &mut |_| ()).unwrap();
    }
    let letter = SealBody {
        flock: "large".to_owned(),
        addressees: Addressees::Anyone,
        sequence: Sequence(1),
        created: "2026-03-01T12:00:00Z".to_owned(),
        contents: ObjectId::of(list.as_bytes()),
        contents_size: list.len() as u64,
        statements: None,
    };
    to.put_seal(&letter.addressees, &unit.maker.sign(&letter)).unwrap();
    fs::write(folder.join(bundle::STATEMENTS), "untrusted comment: \n".repeat(limits::STATEMENTS as usize / 20))
        .unwrap();
}

#[test]
fn an_updater_reads_whatever_keeps_to_the_limits_within_half_of_a_units_memory() {
    for (form, toml) in plain() {
        let unit = Unit::new();
        lay_with_longest_list(&unit, &unit.stick(), &toml);
        let name = format!("updater, a bundle with as many {form} and files as can be");
        // All that is to be read is read before the first clip, which is not there.
        says(&name, &unit.update_from(Some(&unit.stick())), 3, "cannot read `");
    }
    let unit = Unit::new();
    let toml = dotted(HEAD, limits::FLOCK_DOCUMENT);
    unit.maker.bundle(&unit.stick(), &[("flock.toml".to_owned(), toml.into_bytes())].into(), &[], 1);
    says("updater, a manifest of dotted keys", &unit.update_from(Some(&unit.stick())), 1, "unknown key `k0`");
    let file = unit.path("update.toml");
    for (bytes, code, words) in
        [(SETTINGS, 2, "unknown field `k0`"), (SETTINGS + 1, 3, "it is larger than 65536 bytes")]
    {
        fs::write(&file, dotted("", bytes as u64)).unwrap();
        let mut command = unit.update_from(Some(&unit.stick()));
        command.arg("--config").arg(&file);
        says("updater, settings of dotted keys", &command, code, words);
    }
}

/// `text` with one key more, whose value is an array of as many numbers as `bytes` bytes hold in all.
fn array(text: &str, bytes: u64) -> String {
    let numbers = bytes as usize - text.len() - "k0=[]\n".len();
    format!("{text}k0=[{}{}]\n", "0,".repeat(numbers / 2), " ".repeat(numbers % 2))
}

#[test]
fn the_artists_check_of_a_stick_reads_whatever_keeps_to_the_limits_within_the_same_memory() {
    let verify = |unit: &Unit| {
        let mut verify = Command::new(programs::dreams());
        verify.arg("verify").arg(unit.stick()).arg("--trust").arg(unit.maker.keys()).args(["--unit", "lobby"]);
        verify
    };
    for (form, toml) in plain() {
        let unit = Unit::new();
        lay_with_longest_list(&unit, &unit.stick(), &toml);
        says(&format!("verify, a bundle with as many {form} and files as can be"), &verify(&unit), 1, "faults");
    }
    for (form, toml) in [("dotted keys", dotted as fn(&str, u64) -> String), ("one long array", array)] {
        let unit = Unit::new();
        let manifest = toml(HEAD, limits::FLOCK_DOCUMENT).into_bytes();
        unit.maker.bundle(&unit.stick(), &[("flock.toml".to_owned(), manifest)].into(), &[], 1);
        says(&format!("verify, a manifest of {form}"), &verify(&unit), 1, "1 fault");
        fs::write(unit.stick().join("fleet.toml"), toml("", limits::FLOCK_DOCUMENT)).unwrap();
        says(&format!("verify, a table of units of {form}"), &verify(&unit), 2, "unknown field `k0`");
        fs::write(unit.stick().join("fleet.toml"), toml("", FLEET)).unwrap();
        says(&format!("verify, a large table of units of {form}"), &verify(&unit), 2, "a row has at most 131072 bytes");
        fs::write(unit.stick().join("fleet.toml"), toml("", FLEET + 1)).unwrap();
        says(&format!("verify, a larger table of units of {form}"), &verify(&unit), 3, "larger than 4194304 bytes");
    }
    let unit = Unit::new();
    unit.maker.bundle(&unit.stick(), &rubbish(1, 9, 1), &[], 1);
    let rows = filled("", FLEET, |_| {
        "[[unit]]\nid=\"\"\nflock=\"\"\nsequence=0\nkey=\"\"\nto=\"\"\npublished=\"\"\n".to_owned()
    });
    fs::write(unit.stick().join("fleet.toml"), rows).unwrap();
    says("verify, a table of as many units as can be", &verify(&unit), 0, "");
}

#[test]
fn a_player_reads_whatever_keeps_to_the_limits_within_half_of_a_units_memory() {
    let scratch = tempfile::tempdir_in(programs::claims_folder()).unwrap();
    let small = SMALL.flock().folder;
    for entry in fs::read_dir(&small).unwrap() {
        let name = entry.unwrap().file_name();
        fs::copy(small.join(&name), scratch.path().join(&name)).unwrap();
    }
    let player = |words: &[&str]| {
        let mut player = Command::new(programs::player());
        player.args(["--screen", "virtual", "--clock", "free", "--status", "off", "--clips", "20"]).args(words);
        player.arg("--flock").arg(scratch.path()).arg("--state").arg(scratch.path().join("state"));
        player
    };
    for (form, toml) in plain() {
        fs::write(scratch.path().join("flock.toml"), toml).unwrap();
        says(&format!("player, as many {form} as can be"), &player(&[]), 0, "");
    }
    fs::write(scratch.path().join("flock.toml"), dotted(HEAD, limits::FLOCK_DOCUMENT)).unwrap();
    says("player, a manifest of dotted keys", &player(&[]), 2, "unknown key `k0`");
    fs::write(scratch.path().join("flock.toml"), dotted(HEAD, limits::FLOCK_DOCUMENT + 1)).unwrap();
    says("player, a longer one", &player(&[]), 2, "not in the plain form");
    let file = scratch.path().join("player.toml");
    fs::write(&file, dotted("", SETTINGS as u64)).unwrap();
    says("player, settings of dotted keys", &player(&["--config", file.to_str().unwrap()]), 2, "unknown field `k0`");

    let partition = scratch.path().join("partition");
    fs::create_dir(&partition).unwrap();
    fs::write(partition.join("dreams.toml"), dotted("", SETTINGS as u64)).unwrap();
    let mut owner = Command::new(programs::owner());
    owner.arg("take-in").arg(&partition).arg("--keep").arg(scratch.path().join("kept"));
    owner.arg("--network").arg(scratch.path()).arg("--name").arg(scratch.path().join("name"));
    owner.arg("--wifi").arg(scratch.path().join("wifi.conf")).arg("--notice").arg(scratch.path().join("notice"));
    says("owner, settings of dotted keys", &owner, 2, "unknown field `k0`");
}

#[test]
fn a_flock_that_no_unit_reads_is_named_by_check_and_not_packed_and_all_else_goes_on_with_it() {
    let artist = Artist::new();
    let manifest = fs::read_to_string(artist.at("flock/flock.toml")).unwrap();
    let comment = format!("# {}\n", "a".repeat(97));
    let long = manifest.clone() + &comment.repeat(limits::FLOCK_TOML as usize / 100);
    let odd = manifest.replace("id = \"s0\"", "id = 's0'") + &comment.repeat(limits::FLOCK_DOCUMENT as usize / 100);
    let mut many = manifest;
    for at in 0..limits::FILES {
        write!(many, "[[sheep]]\nid=\"x{at}\"\nframes=1\nclip=\"{at}\"\n").unwrap();
    }
    for (text, words) in [
        (long, format!("bytes, a unit reads {} at most", limits::FLOCK_TOML)),
        (odd, format!("not in the plain form that `dreams` writes, so {} bytes at most", limits::FLOCK_DOCUMENT)),
        (many, format!("the list of files of the bundle has more than {} files", limits::FILES)),
    ] {
        fs::write(artist.at("flock/flock.toml"), text).unwrap();
        let said = artist.dreams(&["check", "flock", "--json"]);
        let large = &json(&said)["faults"][0];
        let message = large["message"].as_str().unwrap();
        assert!(large["kind"] == "large" && message.contains(&words), "{message}");
        let pack = ["pack", "flock", "bundle", "--key", "artist.key", "--passphrase-file", "passphrase"];
        let said = artist.says(1, &[&pack, &["--allow-jumps"][..]].concat());
        assert!(said.contains(&words), "{said}");
        assert!(!artist.at("bundle").exists(), "nothing was written");
        artist.says(0, &["walk", "flock", "--seed", "1", "--steps", "20"]);
        artist.says(0, &["want", "flock", "s1", "2"]);
    }
}
