//! Signed flocks, and the detection of changes to them.
//!
//! Owns the claims on `dreams keygen`, `pack` and `verify`: what is signed and by which key, what is refused, what is
//! reported. How a bundle gets to a unit is in `publish.rs`.
//!
//! Start at [`Artist`].

use claims::clips::{SETPARAMS, TAGS};
use claims::flocks::SMALL;
use claims::programs::{self, claims_folder, json, output};
use claims::wait;
use serde_json::Value;
use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// An artist's folder: keys, a flock, and bundles.
pub(crate) struct Artist {
    scratch: tempfile::TempDir,
}

impl Artist {
    /// One with the key `artist` and a copy of the flock [`SMALL`], whose clips do not match at joins.
    pub(crate) fn new() -> Self {
        let artist = Self { scratch: tempfile::tempdir_in(claims_folder()).unwrap() };
        fs::create_dir(artist.at("flock")).unwrap();
        let small = SMALL.flock().folder;
        for entry in fs::read_dir(&small).unwrap() {
            let name = entry.unwrap().file_name();
            fs::copy(small.join(&name), artist.at("flock").join(&name)).unwrap();
        }
        artist.secret("passphrase", "velvet\n");
        // A key of an old format, which opens in a tenth of a second.
        artist.secret("artist.key", include_str!("../../fixtures/keys/artist.key"));
        fs::write(artist.at("artist.pub"), include_str!("../../fixtures/keys/artist.pub")).unwrap();
        artist
    }

    pub(crate) fn at(&self, name: &str) -> PathBuf {
        self.scratch.path().join(name)
    }

    /// Writes a file that only its owner can read.
    pub(crate) fn secret(&self, name: &str, text: &str) {
        fs::write(self.at(name), text).unwrap();
        fs::set_permissions(self.at(name), fs::Permissions::from_mode(0o600)).unwrap();
    }

    /// `dreams WORDS...` in this folder.
    pub(crate) fn dreams(&self, words: &[&str]) -> Output {
        output(Command::new(programs::dreams()).args(words).current_dir(self.scratch.path()))
    }

    /// The same, which must end with `code`; returns its output on both streams.
    pub(crate) fn says(&self, code: i32, words: &[&str]) -> String {
        let said = self.dreams(words);
        let text = [said.stdout, said.stderr].map(|text| String::from_utf8(text).unwrap()).concat();
        assert_eq!(said.status.code(), Some(code), "{words:?}: {text}");
        text
    }

    /// The JSON answer of a command that must end with `code`.
    pub(crate) fn answers(&self, code: i32, words: &[&str]) -> Value {
        let said = self.dreams(&[words, &["--json"]].concat());
        assert_eq!(said.status.code(), Some(code), "{words:?}: {}", String::from_utf8_lossy(&said.stderr));
        json(&said)
    }

    /// Makes the key `name`.
    fn key(&self, name: &str, more: &[&str]) -> Value {
        let file = format!("{name}.key");
        self.answers(0, &[&["keygen", &file, "--passphrase-file", "passphrase"], more].concat())
    }

    /// Packs the flock into the folder `bundle`, signed by the key `artist`.
    pub(crate) fn pack(&self, more: &[&str]) -> Value {
        self.pack_by("artist", more)
    }

    fn pack_by(&self, key: &str, more: &[&str]) -> Value {
        let key = format!("{key}.key");
        let words = ["pack", "flock", "bundle", "--key", &key, "--passphrase-file", "passphrase", "--allow-jumps"];
        self.answers(0, &[&words, more].concat())
    }

    /// The answer of verifying the folder `bundle`, trusting `artist`.
    pub(crate) fn verify(&self, code: i32) -> Value {
        self.answers(code, &["verify", "bundle", "--trust", "artist.pub"])
    }

    /// The file in the bundle that has the content of the flock's file `name`.
    pub(crate) fn object(&self, name: &str) -> PathBuf {
        let id = blake3::hash(&fs::read(self.at("flock").join(name)).unwrap()).to_hex();
        self.at("bundle/objects").join(&id[..2]).join(&id[2..])
    }
}

/// Replaces the file `path` by `bytes`, without a change to other links of it.
pub(crate) fn replace(path: &Path, bytes: &[u8]) {
    fs::remove_file(path).unwrap();
    fs::write(path, bytes).unwrap();
}

/// A flock of one sheep, which is grey and does not move.
fn still(artist: &Artist) -> String {
    fs::create_dir(artist.at("still")).unwrap();
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args([
        "-v",
        "error",
        "-nostdin",
        "-f",
        "lavfi",
        "-i",
        "color=gray:64x64:r=30,format=yuv420p",
        "-frames:v",
        "12",
    ]);
    ffmpeg.args(["-c:v", "libx264", "-profile:v", "high", "-x264-params", "open-gop=0"]);
    ffmpeg.args(["-bsf:v", "dump_extra=freq=keyframe", "-movflags", "+faststart", "-vf", SETPARAMS]).args(TAGS);
    programs::succeed(ffmpeg.arg(artist.at("still/a.mp4")));
    let manifest = "format = 1\nname = \"still\"\nsize = [64, 64]\nfps = [30, 1]\n\
                    [[sheep]]\nid = \"a\"\nframes = 12\nclip = \"a.mp4\"\n\
                    [[transition]]\nfrom = \"a\"\nto = \"a\"\nframes = 12\nclip = \"a.mp4\"\n";
    fs::write(artist.at("still/flock.toml"), manifest).unwrap();
    "still".to_owned()
}

#[test]
fn a_flock_that_is_packed_is_taken_in_as_files_of_its_own() {
    let artist = Artist::new();
    let packed = artist.pack(&[]);
    assert_eq!((&packed["packed"], &packed["sequence"]), (&Value::Bool(true), &Value::from(1)));
    let files = packed["files"].as_u64().unwrap();
    assert_eq!(packed["copied"].as_u64().unwrap() + packed["cloned"].as_u64().unwrap(), files, "{packed}");
    assert_eq!(packed["linked"], 0);
    for name in ["s0.mp4", "flock.toml"] {
        assert_eq!(fs::metadata(artist.object(name)).unwrap().nlink(), 1, "{name}");
    }
    let verified = artist.verify(0);
    assert_eq!((&verified["ok"], &verified["faults"]), (&Value::Bool(true), &Value::Array(vec![])));
    let [bundle] = &verified["bundles"].as_array().unwrap()[..] else { panic!("{verified}") };
    assert_eq!((&bundle["flock"], &bundle["units"]), (&Value::from("small"), &Value::Array(vec![])));
    for key in ["sequence", "signer", "files", "bytes"] {
        assert_eq!(bundle[key], packed[key], "{key}");
    }
    // Other files than manifest, clips and genomes are not packed.
    assert!(!artist.object("shows").exists());
    // Another unit's bundle in the same folder shares the content and gets the next number.
    let another = artist.pack(&["--unit", "stairs", "--unit", "lobby"]);
    assert_eq!((&another["sequence"], &another["kept"]), (&Value::from(2), &packed["files"]));
    assert_eq!(artist.verify(0)["bundles"].as_array().unwrap().len(), 3, "all, lobby and stairs");
    let lobby = artist.answers(0, &["verify", "bundle", "--trust", "artist.pub", "--unit", "lobby"]);
    assert_eq!(lobby["bundles"][0]["units"], serde_json::json!(["lobby", "stairs"]));
    let attic = artist.answers(0, &["verify", "bundle", "--trust", "artist.pub", "--unit", "attic"]);
    assert_eq!(attic["bundles"][0]["seal"], "seals/all.seal");
}

#[test]
fn whatever_is_tampered_with_is_named() {
    let artist = Artist::new();
    artist.pack(&["--unit", "lobby"]);
    let clip = artist.object("s0.mp4");
    let (whole, manifest) = (fs::read(&clip).unwrap(), artist.object("flock.toml"));
    let middle = whole.len() / 2;
    let mut flipped = whole.clone();
    flipped[middle] ^= 1;
    let longer = [&whole[..], b"x"].concat();
    for (kind, bytes, told) in [
        ("damaged", Some(&flipped[..]), "is damaged (expected "),
        ("short", Some(&whole[..middle]), "ends after "),
        ("long", Some(&longer[..]), "is longer than its "),
        ("missing", None, "is missing"),
    ] {
        match bytes {
            Some(bytes) => replace(&clip, bytes),
            None => fs::remove_file(&clip).unwrap(),
        }
        let answer = artist.verify(1);
        let [fault] = &answer["faults"].as_array().unwrap()[..] else { panic!("{kind}: {answer}") };
        assert_eq!((&fault["kind"], &fault["path"]), (&Value::from(kind), &Value::from("s0.mp4")), "{fault}");
        assert!(artist.at("bundle").join(fault["object"].as_str().unwrap()) == clip, "{fault}");
        assert!(fault["message"].as_str().unwrap().contains(told), "{fault}");
    }
    // Everything that is wrong is named at once.
    replace(&manifest, b"format = 1\n");
    let answer = artist.verify(1);
    assert_eq!(answer["faults"].as_array().unwrap().len(), 2, "{answer}");
    fs::write(&clip, &whole).unwrap();
    fs::copy(artist.at("flock/flock.toml"), &manifest).unwrap();
    artist.verify(0);

    let seal = artist.at("bundle/seals/lobby.seal");
    let good = fs::read(&seal).unwrap();
    let text = String::from_utf8(good.clone()).unwrap();
    for (bad, told) in [
        (text.replace("sequence 1\n", "sequence 2\n"), "has an invalid signature of key"),
        (text.replace("units lobby", "units stairs"), "has an invalid signature of key"),
        (text.split_inclusive('\n').skip(4).collect(), "is not signed"),
        (String::new(), "is not signed"),
        ("x".repeat(20_000), "larger than 16384 bytes"),
    ] {
        replace(&seal, bad.as_bytes());
        let said = artist.says(1, &["verify", "bundle", "--trust", "artist.pub"]);
        assert!(said.contains("`seals/lobby.seal`: ") && said.contains(told), "{said}");
    }
    // A good seal in another unit's place.
    replace(&seal, &good);
    fs::copy(&seal, artist.at("bundle/seals/attic.seal")).unwrap();
    let said = artist.says(1, &["verify", "bundle", "--trust", "artist.pub"]);
    assert!(said.contains("the bundle is for `lobby`, this unit is `attic`"), "{said}");
    fs::remove_file(artist.at("bundle/seals/attic.seal")).unwrap();
    // Names that no unit can have are files of another system.
    fs::write(artist.at("bundle/seals/._lobby.seal"), "whatever").unwrap();
    artist.verify(0);
    let list = text.lines().last().unwrap().rsplit(' ').next().unwrap();
    let object = artist.at("bundle/objects").join(&list[..2]).join(&list[2..]);
    let mut other = fs::read(&object).unwrap();
    *other.last_mut().unwrap() ^= 1;
    for (bytes, told) in [
        (&other[..], format!("the list of files of the bundle is damaged: expected {list}")),
        (b"dreams contents 1\n", "the list of files of the bundle is shorter than its seal says: expected ".to_owned()),
    ] {
        replace(&object, bytes);
        let said = artist.says(1, &["verify", "bundle", "--trust", "artist.pub"]);
        assert!(said.contains(&told), "{said}");
    }
}

#[test]
fn what_is_not_there_is_said_in_one_line() {
    let artist = Artist::new();
    for (code, words, told) in [
        (3, &["verify", "nowhere", "--trust", "artist.pub"][..], "cannot read `nowhere`"),
        (3, &["verify", "flock", "--trust", "artist.pub"], "cannot read `flock/seals`"),
        (3, &["verify", "flock", "--trust", "nobody.pub"], "cannot read key `nobody.pub`"),
        (2, &["verify", "flock", "--trust", "passphrase"], "is not a minisign public key"),
        (2, &["verify", "flock", "--trust", "artist.pub", "--unit", "Lobby"], "1 to 64 of `a-z 0-9 . _ -`"),
        (2, &["pack", "flock", "bundle", "--key", "artist.key", "--sequence", "0"], "a whole number from 1"),
        (3, &["pack", "flock", "bundle", "--key", "nobody.key"], "cannot read key `nobody.key`"),
        (3, &["pack", "nowhere", "bundle", "--key", "artist.key"], "cannot read `nowhere/flock.toml`"),
        (
            2,
            &["pack", "flock", "bundle", "--key", "artist.key", "--statement", "artist.pub"],
            "is not a statement about keys",
        ),
        (2, &["keygen"], "Usage: "),
    ] {
        let said = artist.says(code, words);
        assert!(said.contains(told), "{words:?}: {said}");
    }
    artist.pack(&["--unit", "lobby"]);
    let said = artist.says(1, &["verify", "bundle", "--trust", "artist.pub", "--unit", "attic"]);
    assert!(said.contains("there is no bundle for unit `attic`"), "{said}");
}

#[test]
fn a_key_that_others_can_read_signs_nothing_nor_does_one_that_stays_locked() {
    let artist = Artist::new();
    let mode = |name: &str| fs::metadata(artist.at(name)).unwrap().mode() & 0o777;
    assert_eq!((mode("artist.key"), mode("artist.pub") & 0o400), (0o600, 0o400));
    let pack = ["pack", "flock", "bundle", "--key", "artist.key", "--passphrase-file"];
    let set = |name: &str, mode| fs::set_permissions(artist.at(name), fs::Permissions::from_mode(mode)).unwrap();
    set("artist.key", 0o644);
    let said = artist.says(1, &[&pack[..], &["passphrase"]].concat());
    assert!(said.contains("can be read by others (mode 0644, wanted 0600)") && said.contains("chmod 600"), "{said}");
    set("artist.key", 0o600);
    set("passphrase", 0o640);
    let said = artist.says(1, &[&pack[..], &["passphrase"]].concat());
    assert!(said.contains("the passphrase in `passphrase` can be read by others (mode 0640"), "{said}");
    artist.secret("other", "silk\n");
    let said = artist.says(1, &[&pack[..], &["other"]].concat());
    assert!(said.contains("wrong passphrase for the secret key `artist.key`"), "{said}");
    assert!(!artist.at("bundle").exists(), "nothing is written for a key that cannot sign");
    artist.secret("other", "\n");
    let said = artist.says(1, &["keygen", "new.key", "--passphrase-file", "other"]);
    assert!(said.contains("the passphrase of key `new.key` is empty") && !artist.at("new.key").exists(), "{said}");
    artist.secret("other", "silk\n");
    for taken in ["artist.key", "artist.pub"] {
        let said = artist.says(3, &["keygen", taken, "--passphrase-file", "other"]);
        assert!(said.contains("cannot write `artist."), "{said}");
    }
}

#[test]
fn a_passphrase_is_asked_for_on_the_terminal_and_not_shown() {
    let artist = Artist::new();
    let words = format!("'{}' keygen new.key", programs::dreams().display());
    let mut script = Command::new("script");
    script.args(["-qec", &words, "/dev/null"]).current_dir(artist.at(""));
    script.stdin(std::process::Stdio::piped()).stdout(std::process::Stdio::piped());
    let mut child = script.spawn().unwrap();
    std::io::Write::write_all(&mut child.stdin.take().unwrap(), b"velvet\nvelvet\n").unwrap();
    let said = String::from_utf8(wait::output("dreams keygen", 120, child).stdout).unwrap();
    assert!(said.contains("New passphrase of new.key: ") && said.contains("secret key"), "{said}");
    fs::rename(artist.at("new.pub"), artist.at("artist.pub")).unwrap();
    artist.pack_by("new", &[]);
    artist.verify(0);
}

#[test]
fn an_old_key_takes_in_a_new_one_and_calls_it_back() {
    let artist = Artist::new();
    let signer = ["--signed-by", "artist.key", "--signer-passphrase-file", "passphrase"];
    let made = artist.key("new", &signer);
    assert_eq!(made["statement"], "new.trusted");
    artist.pack_by("new", &[]);
    let said = artist.says(1, &["verify", "bundle", "--trust", "artist.pub"]);
    let id = made["id"].as_str().unwrap();
    assert!(said.contains(&format!("is signed by key {id}, which is not trusted (trusted: ")), "{said}");
    artist.pack_by("new", &["--statement", "new.trusted"]);
    assert_eq!(artist.verify(0)["bundles"][0]["signer"], made["id"]);
    // The key's own bundles need no statement, and a stranger's statement is ignored.
    artist.answers(0, &["verify", "bundle", "--trust", "new.pub"]);
    artist.key("stranger", &[]);
    artist.answers(1, &["verify", "bundle", "--trust", "stranger.pub"]);
    let called = artist.answers(0, &[&["keygen", "--revoke", "new.pub"], &signer[..]].concat());
    assert_eq!((&called["id"], &called["statement"]), (&made["id"], &Value::from("new.revoked")));
    artist.pack_by("new", &["--statement", "new.revoked"]);
    let said = artist.says(1, &["verify", "bundle", "--trust", "artist.pub"]);
    assert!(said.contains(&format!("is signed by key {id}, which was revoked")), "{said}");
    artist.pack(&[]);
    artist.verify(0);
    // If it was stolen: units of before obey the first statement, those of today both.
    fs::remove_file(artist.at("new.revoked")).unwrap();
    let words = ["keygen", "--revoke", "new.pub", "--stolen", "--keep", "stranger.pub"];
    artist.answers(0, &[&words, &signer[..]].concat());
    let said = fs::read_to_string(artist.at("new.revoked")).unwrap();
    let kept = fs::read_to_string(artist.at("stranger.pub")).unwrap().lines().nth(1).unwrap().to_owned();
    let said: Vec<&str> = said.lines().filter(|line| line.starts_with("revoke ")).collect();
    assert_eq!(said, [format!("revoke {id}"), format!("revoke {id} keep {kept}")]);
    for words in [&["keygen", "--keep", "stranger.pub", "--revoke", "new.pub"][..], &["keygen", "x.key", "--stolen"]] {
        artist.says(2, &[words, &signer[..]].concat());
    }
}

#[test]
fn numbers_only_go_up_whatever_is_lost() {
    let artist = Artist::new();
    let sequence = |more: &[&str]| artist.pack(more)["sequence"].as_u64().unwrap();
    assert_eq!((sequence(&[]), sequence(&["--sequence", "7"])), (1, 7));
    let words = ["pack", "flock", "bundle", "--key", "artist.key", "--passphrase-file", "passphrase", "--allow-jumps"];
    let said = artist.says(1, &[&words[..], &["--sequence", "7"]].concat());
    assert!(said.contains("sequence 7 is not above 7"), "{said}");
    fs::remove_dir_all(artist.at("bundle")).unwrap();
    assert_eq!(sequence(&[]), 8, "the number stands beside the key");
    fs::remove_file(artist.at("artist.sequence")).unwrap();
    assert_eq!(sequence(&[]), 9, "and in the bundle");
    fs::write(artist.at("artist.sequence"), "nine").unwrap();
    let said = artist.says(2, &words);
    assert!(said.contains("wanted the number of the key's last bundle, found `nine`"), "{said}");
}

#[test]
fn a_flock_that_would_not_play_is_not_packed() {
    let artist = Artist::new();
    let words = ["pack", "flock", "bundle", "--key", "artist.key", "--passphrase-file", "passphrase"];
    let answer = artist.answers(1, &words);
    assert_eq!(answer["packed"], false);
    assert!(answer["faults"].as_array().unwrap().iter().all(|fault| fault["kind"] == "jump"), "{answer}");
    let said = artist.says(1, &words);
    assert!(said.contains("--contact-sheet FILE` draws them; --allow-jumps packs the flock with them"), "{said}");
    fs::remove_file(artist.at("flock/s0.mp4")).unwrap();
    let answer = artist.answers(1, &[&words[..], &["--allow-jumps"]].concat());
    assert_eq!(answer["faults"][0]["kind"], "missing-clip", "{answer}");
    let said = artist.says(1, &words);
    assert!(said.contains("missing-clip: clip `s0.mp4` does not exist") && said.contains("is not packed"), "{said}");
    assert!(!artist.at("bundle").exists() && !artist.at("artist.sequence").exists());
    // A flock of one grey loop meets everywhere.
    let (still, bundle) = (still(&artist), ["bundle", "--key", "artist.key", "--passphrase-file", "passphrase"]);
    artist.answers(0, &[&["pack", &still], &bundle[..]].concat());
    artist.verify(0);
}

#[test]
fn a_pack_that_meets_a_full_disk_leaves_the_bundle_of_before() {
    let artist = Artist::new();
    artist.pack(&[]);
    // No file may grow: to a program that is the same as a full disk.
    let mut shell = Command::new("bash");
    shell.args(["-c", "trap '' XFSZ; ulimit -f 0; exec \"$@\"", "bash"]).arg(programs::dreams());
    shell.args(["pack", "flock", "bundle", "--key", "artist.key", "--passphrase-file", "passphrase", "--allow-jumps"]);
    let manifest = fs::read_to_string(artist.at("flock/flock.toml")).unwrap();
    fs::write(artist.at("flock/flock.toml"), manifest.replace("name = \"small\"", "name = \"other\"")).unwrap();
    let said = output(shell.current_dir(artist.at("")));
    let error = String::from_utf8(said.stderr).unwrap();
    assert_eq!(said.status.code(), Some(3), "{error}");
    assert!(error.contains("error: cannot write `bundle"), "{error}");
    assert_eq!(artist.verify(0)["bundles"][0]["flock"], "small");
    artist.pack(&[]);
    assert_eq!(artist.verify(0)["bundles"][0]["flock"], "other");
}
