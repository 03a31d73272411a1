//! A bundle for one unit by name is not replaced by one for all units.
//!
//! Owns the claim for the unit and for `dreams verify --unit`, which must agree. How a store of an older format learns
//! for whom its flock was is in `old_formats.rs`.
//!
//! Start at [`Sender`].

use crate::tools::bundles::Artist;
use claims::bundle_maker::{BundleMaker, rubbish};
use claims::programs::{self, output};
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

/// An artist, a stick, and units that trust the artist.
struct Sender {
    artist: Artist,
}

impl Sender {
    fn new() -> Self {
        Self { artist: Artist::new() }
    }

    fn stick(&self) -> PathBuf {
        self.artist.at("stick")
    }

    /// Packs the next bundle for `units`, and writes it to an empty stick.
    fn sends(&self, units: &[&str]) {
        let to: Vec<&str> = units.iter().flat_map(|unit| ["--unit", unit]).collect();
        self.artist.pack(&to);
        fs::remove_dir_all(self.stick()).ok();
        fs::create_dir(self.stick()).unwrap();
        self.artist.says(0, &["publish", "bundle", "stick", "--trust", "artist.pub"]);
        let stem = units.first().unwrap_or(&"all");
        for seal in fs::read_dir(self.stick().join("seals")).unwrap() {
            let seal = seal.unwrap();
            if seal.file_name() != format!("{stem}.seal").as_str() {
                fs::remove_file(seal.path()).unwrap();
            }
        }
    }

    /// The unit's answer to the stick.
    fn update(&self, unit: &str, more: &[&str]) -> Output {
        let mut update = Command::new(programs::updater());
        update.arg(self.stick()).args(["--unit", unit]).args(more);
        update.arg("--store").arg(self.artist.at(&format!("store-{unit}")));
        output(update.arg("--keys").arg(self.artist.at("artist.pub")).arg("--notice").arg(self.artist.at("notice")))
    }

    /// Both the artist's tool and the unit accept the stick.
    fn is_taken(&self, unit: &str) {
        let said = self.artist.says(0, &verify(unit));
        assert!(said.contains("no faults"), "{said}");
        let said = self.update(unit, &[]);
        assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
        assert!(said.stdout.starts_with(b"installed"), "{}", String::from_utf8_lossy(&said.stdout));
    }

    /// Both refuse it, with the same words.
    fn is_refused(&self, unit: &str, words: &str) {
        let said = self.artist.says(1, &verify(unit));
        assert!(said.contains(words), "{said}");
        let said = self.update(unit, &[]);
        let error = String::from_utf8_lossy(&said.stderr);
        assert!(said.status.code() == Some(1) && error.contains(words), "{error}");
    }
}

fn verify(unit: &str) -> [&str; 8] {
    ["verify", "stick", "--trust", "artist.pub", "--unit", unit, "--fleet", "bundle/fleet.toml"]
}

#[test]
fn who_has_taken_its_own_takes_nothing_for_everybody_and_its_next_own_all_the_same() {
    let sender = Sender::new();
    sender.sends(&[]);
    sender.is_taken("lobby");
    sender.sends(&[]);
    sender.is_taken("lobby");
    sender.sends(&["lobby"]);
    sender.is_taken("lobby");
    sender.sends(&[]);
    sender.is_taken("stairs");
    sender.is_refused(
        "lobby",
        "the bundle is for every unit, but this unit takes only bundles for `lobby` since it was given one",
    );
    let notice = fs::read_to_string(sender.artist.at("notice")).unwrap();
    assert!(
        notice.contains("This stick is for every frame. This frame is lobby, and takes what is for it by name."),
        "{notice}"
    );
    // A bundle for all units in between does not keep it from its own.
    sender.sends(&["lobby"]);
    sender.is_taken("lobby");
    // A person on site may change that, by an option or by another name.
    sender.sends(&[]);
    let said = sender.update("lobby", &["--allow-older"]);
    assert!(said.stdout.starts_with(b"installed"), "{}", String::from_utf8_lossy(&said.stderr));
    fs::rename(sender.artist.at("store-stairs"), sender.artist.at("store-attic")).unwrap();
    sender.sends(&["attic"]);
    sender.is_taken("attic");
    sender.sends(&[]);
    sender.is_refused("attic", "for every unit");
    fs::rename(sender.artist.at("store-attic"), sender.artist.at("store-cellar")).unwrap();
    sender.is_taken("cellar");
}

#[test]
fn a_seal_for_others_under_the_name_for_everybody_is_refused_by_both() {
    let sender = Sender::new();
    sender.sends(&["stairs"]);
    let seals = sender.stick().join("seals");
    fs::rename(seals.join("stairs.seal"), seals.join("all.seal")).unwrap();
    sender.is_refused("lobby", "the bundle is for `stairs`, this unit is `lobby`");
}

#[test]
fn what_is_for_everybody_is_refused_also_where_the_own_seal_has_gone_from_the_stick() {
    let unit = claims::unit::Unit::new();
    let maker: &BundleMaker = &unit.maker;
    maker.bundle(&unit.stick(), &rubbish(2, 3_000, 0), &["lobby"], 1);
    unit.updated(&[]);
    maker.bundle(&unit.stick(), &rubbish(2, 3_000, 1), &[], 2);
    assert_eq!(unit.updated(&[])["outcome"], "no-news", "its own lies beside it");
    fs::remove_file(unit.stick().join("seals/lobby.seal")).unwrap();
    assert_eq!(unit.update(&[]).status.code(), Some(1));
    assert_eq!(unit.playing(), Some(rubbish(2, 3_000, 0)));
    maker.bundle(&unit.stick(), &rubbish(2, 3_000, 2), &["lobby"], 2);
    assert_eq!(unit.updated(&[])["outcome"], "installed");
}
