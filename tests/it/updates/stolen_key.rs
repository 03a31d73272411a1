//! A stolen key is revoked, and all units are healthy again.
//!
//! Owns the claim on the procedure of `docs/sending.md`, on the real programs, whatever units have received from the
//! thief before, and whatever the thief has left out.
//!
//! Start at [`Fleet`].

use crate::tools::bundles::Artist;
use bundle::{LocalDisk, ObjectId, PublicKey, STATEMENTS, SecretKey, Statement, Store, Trust};
use claims::programs::{self, json, output, succeed};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::process::{Command, Output};

/// The number of keys that the thief has the stolen key trust: more than the quota.
const FLOOD: u32 = 150;

/// An artist with a spare key, units that trust both, and a thief with a key of their own.
struct Fleet {
    artist: Artist,
}

impl Fleet {
    fn new() -> Self {
        let artist = Artist::new();
        fs::create_dir(artist.at("trusted")).unwrap();
        fs::copy(artist.at("artist.pub"), artist.at("trusted/artist.pub")).unwrap();
        artist.secret("spare.key", include_str!("../../fixtures/format-1/keys/spare.key"));
        artist.secret("thief.key", include_str!("../../fixtures/format-1/keys/lost.key"));
        for path in ["spare.pub", "trusted/spare.pub"] {
            fs::write(artist.at(path), include_str!("../../fixtures/format-1/keys/spare.pub")).unwrap();
        }
        fs::write(artist.at("thief.pub"), include_str!("../../fixtures/format-1/keys/lost.pub")).unwrap();
        fs::write(artist.at("update.toml"), "owner = \"/nowhere\"\nreserve_mib = 0\n").unwrap();
        Self { artist }
    }

    fn key(&self, name: &str) -> SecretKey {
        SecretKey::read(&self.artist.at(&format!("{name}.key")), || Ok("velvet".to_owned())).unwrap()
    }

    fn id(&self, name: &str) -> String {
        PublicKey::read(&self.artist.at(&format!("{name}.pub"))).unwrap().id().to_string()
    }

    /// Packs the flock into `folder`, signed with the key `key`.
    fn pack(&self, key: &str, folder: &str, more: &[&str]) {
        let key = format!("{key}.key");
        let words = ["pack", "flock", folder, "--key", &key, "--passphrase-file", "passphrase", "--allow-jumps"];
        self.artist.says(0, &[&words, more].concat());
    }

    /// `unit` updates from the stick `stick`.
    fn look(&self, unit: &str, stick: &str) -> Output {
        let mut update = Command::new(programs::updater());
        update.args(["--json", "--unit", unit, "--keys", "trusted", "--config", "update.toml", "--notice", "notice"]);
        output(update.args(["--store", &format!("store-{unit}"), stick]).current_dir(self.artist.at("")))
    }

    /// The number of the flock that `unit` installs from the stick.
    fn takes(&self, unit: &str, stick: &str) -> Option<u64> {
        let said = self.look(unit, stick);
        assert_eq!(said.status.code(), Some(0), "{unit}: {}", String::from_utf8_lossy(&said.stderr));
        let answer: Value = json(&said);
        assert_eq!(answer["outcome"], "installed", "{unit}");
        answer["sequence"].as_u64()
    }

    /// The reason for which `unit` refuses the stick.
    fn refuses(&self, unit: &str, stick: &str) -> String {
        let said = self.look(unit, stick);
        let error = String::from_utf8(said.stderr).unwrap();
        assert_eq!(said.status.code(), Some(1), "{unit}: {error}");
        error
    }

    /// The keys that `unit` trusts.
    fn trusted(&self, unit: &str) -> BTreeSet<String> {
        let disk = LocalDisk::open(&self.artist.at(&format!("store-{unit}"))).unwrap();
        let store = Store::open(Box::new(disk), Trust::read(&self.artist.at("trusted")).unwrap()).unwrap();
        store.trust().keys().map(|key| key.id().to_string()).collect()
    }

    fn copy(&self, from: &str, to: &str) {
        succeed(Command::new("cp").arg("-r").arg(self.artist.at(from)).arg(self.artist.at(to)));
    }

    /// The thief's actions: the stolen key trusts a key of theirs and many more, and signs a flock for all units in
    /// `loot`; and a bundle in `bait` that makes the unit `stairs` learn these keys.
    fn is_robbed(&self) {
        let (artist, thief) = (self.key("artist"), self.key("thief").public());
        let line = thief.line();
        let other = |at: u32| PublicKey::parse(&format!("{}{at:04}{}", &line[..20], &line[24..])).unwrap();
        let taken_in = std::iter::once(thief.clone()).chain((1000..1000 + FLOOD).map(other));
        let flood: Vec<u8> = taken_in.flat_map(|key| Statement::Trust(key).sign(&artist).unwrap()).collect();
        fs::write(self.artist.at("flood"), &flood).unwrap();
        self.pack("thief", "loot", &["--sequence", "900", "--statement", "flood"]);
        let kept = Statement::Stolen(artist.public().id(), [thief].into()).sign(&artist).unwrap();
        fs::write(self.artist.at("pretence"), kept).unwrap();
        let words = ["--sequence", "901", "--unit", "lobby", "--statement", "flood", "--statement", "pretence"];
        self.pack("thief", "bait", &words);
        fs::rename(self.artist.at("bait/seals/lobby.seal"), self.artist.at("bait/seals/stairs.seal")).unwrap();
    }

    /// The procedure: the spare key trusts a new key and revokes the stolen one with every key that it trusts; the
    /// flock is signed again, and written to the stick that the thief had.
    fn drill(&self) {
        let signed = |words: &[&str]| {
            self.artist.says(0, &[&["keygen"], words, &["--signer-passphrase-file", "passphrase"]].concat())
        };
        signed(&["next.key", "--signed-by", "spare.key", "--passphrase-file", "passphrase"]);
        signed(&["--revoke", "artist.pub", "--stolen", "--signed-by", "artist.key"]);
        self.pack("next", "healthy", &["--statement", "next.trusted", "--statement", "artist.revoked"]);
        self.copy("loot", "stick");
        self.artist.says(0, &["publish", "healthy", "stick", "--trust", "spare.pub", "--prune"]);
        self.artist.says(0, &["verify", "stick", "--trust", "spare.pub"]);
    }
}

#[test]
fn a_fleet_is_healthy_again_after_a_key_was_stolen_whatever_its_units_met_of_the_thief() {
    let fleet = Fleet::new();
    fleet.pack("artist", "bundle", &[]);
    assert_eq!((fleet.takes("lobby", "bundle"), fleet.takes("stairs", "bundle")), (Some(1), Some(1)));
    fleet.is_robbed();
    assert_eq!(fleet.takes("lobby", "loot"), Some(900), "the thief's flock is on the glass");
    assert!(fleet.refuses("stairs", "bait").contains("the bundle is for `lobby`"));
    for unit in ["lobby", "stairs"] {
        assert!(fleet.trusted(unit).contains(&fleet.id("thief")), "{unit}");
    }

    fleet.drill();
    let healthy: BTreeSet<String> = ["spare", "next"].map(|key| fleet.id(key)).into();
    for unit in ["lobby", "stairs", "attic"] {
        assert_eq!((fleet.takes(unit, "stick"), fleet.trusted(unit)), (Some(1), healthy.clone()), "{unit}");
    }
    // The thief comes again, with either key, and with all that was said before.
    fleet.pack("thief", "loot", &["--sequence", "999"]);
    fleet.pack("artist", "forged", &["--sequence", "999", "--statement", "flood", "--statement", "pretence"]);
    for unit in ["lobby", "stairs", "attic"] {
        let said = fleet.refuses(unit, "loot");
        assert!(
            said.contains(&format!("is signed by key {}, which is not trusted (trusted: ", fleet.id("thief"))),
            "{unit}: {said}"
        );
        let said = fleet.refuses(unit, "forged");
        assert!(said.contains(&format!("key {}, which was revoked", fleet.id("artist"))), "{unit}: {said}");
        assert_eq!(fleet.trusted(unit), healthy, "{unit}");
    }
}

#[test]
fn a_bundle_whose_statements_were_left_out_is_refused() {
    let fleet = Fleet::new();
    fleet.is_robbed();
    fleet.drill();
    // Signed by a key that every unit trusts by itself, so that nothing but the seal asks for the revocation.
    fleet.pack("spare", "healthy", &[]);
    let statements = fs::read(fleet.artist.at("healthy").join(STATEMENTS)).unwrap();
    let object = ObjectId::of(&statements).path();
    fleet.copy("healthy", "stripped");
    for path in [STATEMENTS, &object] {
        fs::remove_file(fleet.artist.at("stripped").join(path)).unwrap();
    }
    let said = fleet.artist.says(1, &["verify", "stripped", "--trust", "spare.pub"]);
    assert!(said.contains("the statements about keys are missing"), "{said}");
    assert!(fleet.refuses("lobby", "stripped").contains("are missing or outdated: the seal expects"));
    assert!(fleet.trusted("lobby").contains(&fleet.id("artist")));
    // What the seal expects is enough.
    fs::write(fleet.artist.at("stripped").join(&object), &statements).unwrap();
    assert_eq!(fleet.takes("lobby", "stripped"), Some(2));
    assert_eq!(fleet.trusted("lobby"), ["spare", "next"].map(|key| fleet.id(key)).into());
    // A seal is invalid if the statements that it expects revoke its own key.
    fleet.pack("artist", "last", &["--statement", "artist.revoked"]);
    fs::remove_file(fleet.artist.at("last").join(STATEMENTS)).unwrap();
    let revoked = format!("is signed by key {}, which was revoked", fleet.id("artist"));
    assert!(fleet.artist.says(1, &["verify", "last", "--trust", "artist.pub"]).contains(&revoked));
    assert!(fleet.refuses("attic", "last").contains(&revoked));
}
