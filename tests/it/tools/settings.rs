//! Settings that are signed for a stick.
//!
//! Owns the claims on `dreams settings`, and on what `dreams verify` says of signed settings. How a unit takes them is in
//! `unit/settings_stick.rs`.

use crate::tools::bundles::Artist;
use rustix::fs::{CWD, FileType, Mode, mknodat};
use std::fs;

/// The words before the name of the file, and after it.
fn words<'w>(file: &'w str, more: &[&'w str]) -> Vec<&'w str> {
    let words = ["settings", file, "--key", "artist.key", "--passphrase-file", "passphrase", "--out", "stick"];
    [&words, more].concat()
}

#[test]
fn an_owners_file_is_signed_as_it_is_with_the_next_number() {
    let artist = Artist::new();
    let text = "# Museum\r\nunit = \"lobby\"\nwifi = \"Hall\"\nwifi_password = \"satin above\"\n";
    fs::write(artist.at("lobby.toml"), [b"\xef\xbb\xbf", text.as_bytes()].concat()).unwrap();
    artist.pack(&[]);
    let answer = artist.answers(0, &words("lobby.toml", &["--unit", "lobby"]));
    assert_eq!(answer["written"], serde_json::json!(["settings/lobby.settings"]));
    assert_eq!((&answer["sequence"], &answer["units"]), (&2.into(), &serde_json::json!(["lobby"])), "a bundle has 1");
    let signed = fs::read_to_string(artist.at("stick/settings/lobby.settings")).unwrap();
    assert!(signed.ends_with(&format!("\n\n{text}")), "{signed}");
    let said = artist.says(0, &words("lobby.toml", &["--unit", "lobby"]));
    assert!(said.contains("settings for lobby: sequence 3, key 7F6F7B501F4A54A9"), "{said}");
    assert!(
        said.contains("warning: anybody who finds the signed file can read the password of the Wi-Fi `Hall` in it"),
        "{said}"
    );
    assert!(!said.contains("satin"), "{said}");
    // A folder with nothing else.
    let verify = ["verify", "stick", "--trust", "artist.pub"];
    let said = artist.says(0, &verify);
    assert!(said.contains("`settings/lobby.settings`: settings for lobby, sequence 3 of "), "{said}");
    fs::write(artist.at("stick/settings/lobby.settings"), signed.replace("Hall", "Hole")).unwrap();
    let answer = artist.answers(1, &verify);
    assert_eq!((&answer["ok"], &answer["faults"][0]["kind"]), (&false.into(), &"refused".into()));
    assert_eq!(answer["faults"][0]["seal"], "settings/lobby.settings");
}

#[test]
fn a_file_that_a_unit_would_refuse_is_not_signed() {
    let artist = Artist::new();
    fs::write(artist.at("lobby.toml"), "unit = \"lobby\"\n").unwrap();
    mknodat(CWD, artist.at("fifo"), FileType::Fifo, Mode::RUSR, 0).unwrap();
    fs::write(artist.at("long"), vec![b'#'; 65_537]).unwrap();
    for (name, text) in [
        ("value", &b"unit = \"lobby\"\nhours = 8\n"[..]),
        ("key", b"hour = \"08:00-23:00\"\n"),
        ("alone", b"wifi_password = \"satin above\"\n"),
        ("empty", b"\n"),
        ("utf-16", b"\xff\xfeu\0n\0i\0t\0"),
        ("windows", b"wifi = \"Caf\xe9\"\n"),
    ] {
        fs::write(artist.at(name), text).unwrap();
    }
    for (file, more, code, said) in [
        ("value", &[][..], 2, "`value` line 2, key `hours`"),
        ("key", &[], 2, "did you mean `hours`?"),
        ("alone", &[], 2, "line 1, key `wifi_password`: it needs `wifi`, which is not set"),
        ("empty", &[], 2, "`empty`: it is empty"),
        ("utf-16", &[], 2, "`utf-16`: it is saved as UTF-16"),
        ("windows", &[], 2, "`windows`: line 1 has characters that are not UTF-8"),
        ("long", &[], 3, "it is larger than 65536 bytes"),
        ("fifo", &[], 3, "it is not a plain file"),
        ("nowhere", &[], 3, "cannot read"),
        ("lobby.toml", &[], 2, "names one unit, `lobby`, and is to be signed for every unit"),
        ("lobby.toml", &["--unit", "lobby", "--unit", "stairs"], 2, "and is to be signed for 2 units"),
        ("lobby.toml", &["--unit", "The Lobby"], 2, "wanted 1 to 64 of"),
    ] {
        let error = artist.says(code, &words(file, more));
        assert!(error.contains(said) && !error.contains("satin"), "{file}: {error}");
    }
    assert!(!artist.at("stick").exists(), "nothing is written");
    let renamed = artist.says(0, &words("lobby.toml", &["--unit", "hall"]));
    assert!(
        renamed.contains("warning: the file calls the unit `lobby`: from then on, sign for that name"),
        "{renamed}"
    );
}
