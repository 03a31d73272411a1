//! A flock is edited by commands.
//!
//! Owns the claims on `dreams new`, `add`, `link`, `unlink`, `drop`, `rename` and `want`: what they change, what they
//! leave as it is, what they refuse, what they say about the balance. Never renders: ffmpeg makes the clips.

use claims::flocks::SMALL;
use claims::programs::{self, json, output};
use claims::wait;
use serde_json::Value;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The folder of a flock.
pub(crate) struct FlockFolder {
    scratch: tempfile::TempDir,
}

impl FlockFolder {
    /// An empty flock, for clips like those of [`SMALL`].
    pub(crate) fn new() -> Self {
        let flock_folder = Self::bare();
        let size = format!("{}x{}", SMALL.size.0, SMALL.size.1);
        flock_folder.fine(&["new"], &["--size", &size, "--fps", "30"]);
        flock_folder
    }

    /// A flock with the manifest `text`, without clips.
    pub(crate) fn of(text: &str) -> Self {
        let flock_folder = Self::bare();
        fs::create_dir(flock_folder.folder()).unwrap();
        fs::write(flock_folder.folder().join("flock.toml"), text).unwrap();
        flock_folder
    }

    fn bare() -> Self {
        Self { scratch: tempfile::tempdir().unwrap() }
    }

    pub(crate) fn folder(&self) -> PathBuf {
        self.scratch.path().join("aurora")
    }

    pub(crate) fn manifest(&self) -> String {
        fs::read_to_string(self.folder().join("flock.toml")).unwrap()
    }

    /// `dreams COMMAND FOLDER WORDS...`.
    pub(crate) fn dreams(&self, command: &str, words: &[&str]) -> Output {
        output(Command::new(programs::dreams()).arg(command).arg(self.folder()).args(words))
    }

    /// The same, which must end with `code`; returns its output on both streams.
    pub(crate) fn says(&self, code: i32, command: &[&str], words: &[&str]) -> String {
        let said = self.dreams(command[0], &[&command[1..], words].concat());
        let text = [said.stdout, said.stderr].map(|text| String::from_utf8(text).unwrap()).concat();
        assert_eq!(said.status.code(), Some(code), "{command:?} {words:?}: {text}");
        text
    }

    pub(crate) fn fine(&self, command: &[&str], words: &[&str]) -> String {
        self.says(0, command, words)
    }

    /// The JSON answer of a command that must end with `code`.
    pub(crate) fn answers(&self, code: i32, command: &str, words: &[&str]) -> Value {
        let said = self.dreams(command, &[words, &["--json"]].concat());
        assert_eq!(said.status.code(), Some(code), "{command} {words:?}");
        json(&said)
    }
}

/// The path of a clip of [`SMALL`].
fn clip(name: &str) -> String {
    SMALL.flock().folder.join(name).to_str().unwrap().to_owned()
}

fn odd() -> String {
    fs::read_to_string(programs::repository().join("crates/flock/src/edit/tests/odd.toml")).unwrap()
}

#[test]
fn a_flock_grows_from_nothing_to_one_without_faults() {
    let flock_folder = FlockFolder::new();
    for folder in ["genomes", "loops", "transitions"] {
        assert!(flock_folder.folder().join(folder).is_dir(), "{folder}");
    }
    let said = flock_folder.says(2, &["check"], &[]);
    assert!(said.contains("`dreams add`"), "{said}");
    let first = flock_folder.fine(&["add", "ram"], &["--loop", &clip("s0.mp4")]);
    assert!(first.contains("none while a sheep is never shown"), "{first}");
    flock_folder.fine(&["add", "ewe"], &["--loop", &clip("s1.mp4"), "--want", "3", "--repeat", "2"]);
    let there = flock_folder.fine(&["link", "ram", "ewe"], &["--clip", &clip("s0=s1.mp4")]);
    assert!(there.contains("sheep `ewe` has no transition that leaves it"), "{there}");
    let back = flock_folder.fine(&["link", "ewe", "ram"], &["--clip", &clip("s1=s2.mp4"), "--weight", "2.5"]);
    assert!(back.contains("worst ratio of visits and want: 2.000, the first\n"), "{back}");
    assert_eq!(flock_folder.fine(&["check"], &[]).lines().last(), Some("no faults"));
    let bytes = |path: &str| fs::read(path).unwrap();
    assert_eq!(bytes(flock_folder.folder().join("loops/ram.mp4").to_str().unwrap()), bytes(&clip("s0.mp4")));
    let manifest = flock_folder.manifest();
    for line in ["want = 3.0", "repeat = 2", "clip = \"transitions/ram=ewe.mp4\"", "weight = 2.5"] {
        assert!(manifest.contains(line), "{line}: {manifest}");
    }
    assert_eq!(manifest.matches("hash = \"b3:").count(), 4, "every clip's hash is written down");
    let wanted = flock_folder.fine(&["want", "ewe", "1"], &[]);
    assert!(wanted.contains("worst ratio of visits and want: 1.000, was 2.000\n"), "{wanted}");
    flock_folder.fine(&["add", "kid"], &["--no-loop"]);
    assert!(
        flock_folder.manifest().contains("\n[[sheep]]\nid = \"kid\"\n\n[[transition]]\n"),
        "{}",
        flock_folder.manifest()
    );
}

#[test]
fn what_is_yet_to_be_rendered_is_named_and_its_place_told() {
    let flock_folder = FlockFolder::new();
    let genome = programs::repository().join("flock-tools/demo/genomes/orchid.flam3");
    let genome = genome.to_str().unwrap();
    let said = flock_folder.fine(&["add", "orchid"], &["--genome", genome, "--frames", "90"]);
    assert!(said.contains("note: `loops/orchid.mp4` is not there yet; `dreams render` makes it"), "{said}");
    let answer = flock_folder.answers(0, "link", &["orchid", "orchid"]);
    assert_eq!(answer["missing"], serde_json::json!(["transitions/orchid=orchid.mp4"]));
    let manifest = flock_folder.manifest();
    assert!(manifest.contains("frames = 90\nclip = \"loops/orchid.mp4\"\ngenome = \"genomes/orchid.flam3\""));
    assert!(manifest.contains("frames = 384\nclip = \"transitions/orchid=orchid.mp4\""));
    assert!(!manifest.contains("hash"), "there is nothing to hash");
    assert_eq!(fs::read(flock_folder.folder().join("genomes/orchid.flam3")).unwrap(), fs::read(genome).unwrap());
    let faults = flock_folder.answers(1, "check", &[]);
    let kinds: Vec<_> = faults["faults"].as_array().unwrap().iter().map(|fault| &fault["kind"]).collect();
    assert_eq!(kinds, ["missing-clip", "missing-clip"]);
}

#[test]
fn a_clip_that_lies_in_the_flock_is_taken_where_it_lies() {
    let flock_folder = FlockFolder::new();
    let place = flock_folder.folder().join("loops/ram.mp4");
    fs::copy(clip("s0.mp4"), &place).unwrap();
    flock_folder.fine(&["add", "ram"], &["--no-loop"]);
    flock_folder.fine(&["drop", "ram"], &["--force"]);
    // In its usual place it needs no name; in another one it is named and stays.
    let genome = programs::repository().join("flock-tools/demo/genomes/orchid.flam3");
    flock_folder.fine(&["add", "ram"], &["--genome", genome.to_str().unwrap()]);
    assert!(
        flock_folder.manifest().contains("frames = 6\nclip = \"loops/ram.mp4\"\nhash"),
        "{}",
        flock_folder.manifest()
    );
    let own = flock_folder.folder().join("mine.mp4");
    fs::rename(&place, &own).unwrap();
    flock_folder.fine(&["add", "ewe"], &["--loop", own.to_str().unwrap()]);
    assert!(flock_folder.manifest().contains("clip = \"mine.mp4\""));
    assert!(!flock_folder.folder().join("loops/ewe.mp4").exists());
}

#[test]
fn what_does_not_fit_is_refused_and_changes_nothing() {
    let flock_folder = FlockFolder::new();
    flock_folder.fine(&["add", "ram"], &["--loop", &clip("s0.mp4")]);
    let files = || {
        let list = |folder: &str| fs::read_dir(flock_folder.folder().join(folder)).unwrap().count();
        (flock_folder.manifest(), list("."), list("loops"), list("transitions"), list("genomes"))
    };
    let before = files();
    let other_form = programs::repository().join("flock-tools/demo/small/loops/selene.mp4");
    let other_form = other_form.to_str().unwrap();
    let said = flock_folder.says(1, &["add", "big"], &["--loop", other_form]);
    assert!(
        said.contains("size is `1280x720` (expected `320x240`)") && said.contains("hint: `dreams import`"),
        "{said}"
    );
    let said = flock_folder.says(2, &["want", "ram"], &["-3"]);
    assert!(said.contains("wanted a finite number above 0"), "{said}");
    for (code, command, words) in [
        (3, ["add", "x"], ["--loop", "no/such.mp4"]),
        (2, ["add", "x"], ["--genome", "/etc/passwd"]),
        (2, ["add", "x"], ["--want", "2"]),
        (2, ["add", "x y"], ["--genome", "a.flam3"]),
        (2, ["add", "ram"], ["--loop", &clip("s1.mp4")]),
        (2, ["link", "ram"], ["nobody", "--force"]),
        (2, ["unlink", "ram"], ["ram", "--force"]),
        (2, ["drop", "nobody"], ["--json", "--force"]),
        (2, ["rename", "ram"], ["ram", "--json"]),
        (2, ["want", "ram"], ["0", "--json"]),
        (2, ["wan", "ram"], ["1", "--json"]),
        (1, ["new", "--name"], ["x", "--json"]),
    ] {
        let said = flock_folder.says(code, &command, &words);
        assert!(said.contains("error: "), "{said}");
    }
    fs::write(flock_folder.folder().join("transitions/ram=ram.mp4"), "another film").unwrap();
    let said = flock_folder.says(1, &["link", "ram", "ram"], &["--clip", &clip("s0=s1.mp4")]);
    assert!(said.contains("--force replaces it"), "{said}");
    assert_eq!(fs::read_to_string(flock_folder.folder().join("transitions/ram=ram.mp4")).unwrap(), "another film");
    flock_folder.fine(&["link", "ram", "ram"], &["--clip", &clip("s0=s1.mp4"), "--force"]);
    flock_folder.fine(&["unlink", "ram", "ram"], &["--force", "--delete-files"]);
    assert_eq!(files(), before, "nothing else is left behind");
}

#[test]
fn an_edit_that_would_take_sheep_off_the_wall_is_refused_unless_forced() {
    let flock_folder =
        FlockFolder::of(&fs::read_to_string(programs::repository().join("tests/fixtures/seven/flock.toml")).unwrap());
    let before = flock_folder.manifest();
    let manifest: toml::Table = before.parse().unwrap();
    let refused: Vec<_> = manifest["transition"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|t| {
            flock_folder.dreams("unlink", &[t["from"].as_str().unwrap(), t["to"].as_str().unwrap()]).status.code()
                == Some(1)
        })
        .map(|t| (t["from"].as_str().unwrap().to_owned(), t["to"].as_str().unwrap().to_owned()))
        .collect();
    // Whatever could be taken out was; what is left is needed.
    let sparse = flock_folder.manifest();
    assert_ne!(sparse, before);
    let played = |flock_folder: &FlockFolder| flock_folder.answers(0, "share", &[])["sheep"].as_array().unwrap().len();
    assert_eq!(played(&flock_folder), 7, "all seven are still shown");
    let (from, to) = refused.last().expect("a flock of seven has a transition that it cannot lose");
    let answer = flock_folder.answers(1, "unlink", &[from, to]);
    assert_eq!((&answer["changed"], flock_folder.manifest()), (&Value::Bool(false), sparse));
    assert!(!answer["no_longer_shown"].as_array().unwrap().is_empty(), "{answer}");
    let forced = flock_folder.answers(0, "unlink", &[from, to, "--force"]);
    assert_eq!((&forced["changed"], &forced["no_longer_shown"]), (&Value::Bool(true), &answer["no_longer_shown"]));
    assert_eq!(forced["worst_ratio_after"], Value::Null);
    assert!(!forced["faults"].as_array().unwrap().is_empty());
    assert_eq!(flock_folder.dreams("check", &[]).status.code(), Some(1));
}

#[test]
fn a_manifest_in_any_hand_keeps_its_bytes_but_for_what_was_meant() {
    let flock_folder = FlockFolder::of(&odd());
    let answer = flock_folder.answers(0, "want", &["b", "3.5"]);
    assert_eq!(answer["changed"], true);
    assert_eq!(flock_folder.manifest(), odd().replace("want   = 0.5", "want   = 3.5"));
    flock_folder.fine(&["want", "b", "0.5"], &[]);
    assert_eq!(flock_folder.manifest(), odd());
    flock_folder.fine(&["link", "c", "c"], &[]);
    flock_folder.fine(&["unlink", "c", "c"], &["--force"]);
    assert_eq!(flock_folder.manifest(), odd());
    flock_folder.fine(&["rename", "b", "bee"], &[]);
    flock_folder.fine(&["rename", "bee", "b"], &[]);
    assert_eq!(flock_folder.manifest(), odd());
}

#[test]
fn a_renamed_sheep_brings_its_files_along() {
    let flock_folder = FlockFolder::new();
    flock_folder.fine(&["add", "ram"], &["--loop", &clip("s0.mp4")]);
    flock_folder.fine(&["add", "ewe"], &["--loop", &clip("s1.mp4")]);
    flock_folder.fine(&["link", "ram", "ewe"], &["--clip", &clip("s0=s1.mp4")]);
    flock_folder.fine(&["link", "ewe", "ram"], &["--clip", &clip("s1=s2.mp4")]);
    // What a power cut in the middle of a first try leaves: a file that bears both names.
    let at = |path: &str| flock_folder.folder().join(path);
    fs::hard_link(at("loops/ram.mp4"), at("loops/goat.mp4")).unwrap();
    let said = flock_folder.fine(&["rename", "ram", "goat"], &[]);
    assert!(said.starts_with("renamed `ram` to `goat`, and 3 files\n"), "{said}");
    assert_eq!(flock_folder.fine(&["check"], &[]).lines().last(), Some("no faults"));
    assert!(
        !flock_folder.manifest().contains("ram\"") && !flock_folder.manifest().contains("ram="),
        "{}",
        flock_folder.manifest()
    );
    for gone in ["loops/ram.mp4", "transitions/ram=ewe.mp4", "transitions/ewe=ram.mp4"] {
        assert!(!at(gone).exists(), "{gone}");
    }
    let answer = flock_folder.answers(0, "rename", &["goat", "ram"]);
    assert_eq!(answer["no_longer_shown"], serde_json::json!([]), "it is shown by another id");
    flock_folder.fine(&["rename", "ram", "goat"], &[]);
    fs::write(at("loops/lamb.mp4"), "another film").unwrap();
    let before = flock_folder.manifest();
    let said = flock_folder.says(1, &["rename", "goat", "lamb"], &[]);
    assert!(said.contains("loops/lamb.mp4`: another file has that name"), "{said}");
    assert_eq!(flock_folder.manifest(), before);
}

#[test]
fn a_renamed_sheep_shares_no_file_with_another() {
    let flock_folder = FlockFolder::new();
    let at = |path: &str| flock_folder.folder().join(path);
    flock_folder.fine(&["add", "ram"], &["--loop", &clip("s0.mp4")]);
    flock_folder.fine(&["add", "ewe"], &["--loop", at("loops/ram.mp4").to_str().unwrap()]);
    flock_folder.fine(&["rename", "ram", "goat"], &[]);
    for path in ["loops/ram.mp4", "loops/goat.mp4"] {
        assert_eq!(fs::metadata(at(path)).unwrap().nlink(), 1, "{path}");
    }
}

#[test]
fn files_stay_unless_told_otherwise_and_are_named() {
    let flock_folder = FlockFolder::new();
    for (id, file) in [("ram", "s0.mp4"), ("ewe", "s0.mp4"), ("kid", "s1.mp4")] {
        flock_folder.fine(&["add", id], &["--loop", &clip(file)]);
    }
    let answer = flock_folder.answers(0, "drop", &["ram"]);
    assert_eq!(answer["unreferenced"], serde_json::json!(["loops/ram.mp4"]));
    assert!(flock_folder.folder().join("loops/ram.mp4").exists());
    let answer = flock_folder.answers(0, "drop", &["kid", "--delete-files"]);
    assert_eq!(answer["unreferenced"], serde_json::json!([]));
    assert!(!flock_folder.folder().join("loops/kid.mp4").exists());
    assert!(flock_folder.folder().join("loops/ewe.mp4").exists());
}

#[test]
fn a_full_disk_loses_nothing() {
    // No file may grow: to a program that is the same as a full disk.
    let full = |flock_folder: &FlockFolder, command: &str, words: &[&str], cannot: [&str; 2]| {
        let mut shell = Command::new("bash");
        shell.args(["-c", "trap '' XFSZ; ulimit -f 0; exec \"$@\"", "bash"]).arg(programs::dreams()).arg(command);
        let said = output(shell.arg(flock_folder.folder()).args(words));
        let error = String::from_utf8(said.stderr).unwrap();
        assert_eq!(said.status.code(), Some(3), "{error}");
        assert!(cannot.iter().all(|words| error.contains(words)), "{error}");
    };
    let flock_folder = FlockFolder::of(&odd());
    full(&flock_folder, "want", &["b", "7"], ["cannot save `", "flock.toml`"]);
    assert_eq!(flock_folder.manifest(), odd());
    assert_eq!(fs::read_dir(flock_folder.folder()).unwrap().count(), 1, "no half file is left");
    let flock_folder = FlockFolder::new();
    flock_folder.fine(&["add", "ram"], &["--loop", &clip("s0.mp4")]);
    flock_folder.fine(&["link", "ram", "ram"], &["--clip", &clip("s0=s1.mp4")]);
    let before = flock_folder.manifest();
    full(&flock_folder, "rename", &["ram", "goat"], ["cannot rename `", "goat"]);
    assert_eq!(flock_folder.manifest(), before);
    assert_eq!(flock_folder.fine(&["check"], &[]).lines().last(), Some("no faults"));
    let said = flock_folder.fine(&["rename", "ram", "goat"], &[]);
    assert!(said.starts_with("renamed `ram` to `goat`, and 2 files\n"), "{said}");
    assert_eq!(fs::read_dir(flock_folder.folder().join("loops")).unwrap().count(), 1, "the old name is gone");
}

#[test]
fn commands_at_the_same_time_lose_no_edit() {
    let flock_folder = FlockFolder::new();
    let program = programs::dreams();
    let add = |number: usize| {
        let mut add = Command::new(&program);
        add.arg("add").arg(flock_folder.folder()).args([&format!("s{number}"), "--no-loop"]);
        add.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null()).spawn().unwrap()
    };
    let mut running: Vec<_> = (0..16).map(add).collect();
    assert!(running.iter_mut().all(|child| wait::ended("one of the additions", 120, child).success()));
    assert_eq!(flock_folder.manifest().matches("[[sheep]]").count(), 16);
}

#[test]
fn a_flock_is_only_started_where_nothing_is() {
    let scratch = tempfile::tempdir().unwrap();
    let new = |folder: &Path| output(Command::new(programs::dreams()).arg("new").arg(folder).arg("--json"));
    let folder = scratch.path().join("deep/it's \"so\"");
    let said = new(&folder);
    assert_eq!(json(&said)["name"], "it's \"so\"");
    let said = new(&folder);
    let error = String::from_utf8(said.stderr).unwrap();
    assert_eq!((said.status.code(), error.contains("is not empty")), (Some(1), true), "{error}");
    let add = output(Command::new(programs::dreams()).arg("add").arg(&folder).args(["ram", "--no-loop", "--json"]));
    assert_eq!(json(&add)["changed"], true);
}
