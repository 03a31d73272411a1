//! The tutorial and the guides to sending and to maintaining work as printed.
//!
//! Owns the claim that their commands, in order, print what the guide shows, and ask for the passphrases that it shows.
//! They run on a terminal of their own, where the passphrases are typed. The guide to sending goes on where the tutorial
//! ends, and a unit plays what is then on the stick.

use crate::tools::tutorial::{self, Step, is_shown, marked, printed, steps};
use claims::bundle_maker::BundleMaker;
use claims::player_run::PlayerRun;
use claims::programs::{self, output, repository, succeed};
use claims::systems::make_halves;
use claims::wait;
use std::collections::BTreeMap;
use std::fs;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// The guides, from the root of the repository, and the mount point of the stick in them.
const SENDING: &str = "docs/sending.md";
const MAINTAINING: &str = "docs/maintaining.md";
const STICK: &str = "/media/stick";
/// The frames of each loop of the tutorial's flock, and of each transition.
const LOOP_FRAMES: u64 = 30;
const TRANSITION_FRAMES: u64 = 45;
/// What parts words.
const BETWEEN_WORDS: [char; 4] = [' ', ',', ';', '\n'];
/// The most seconds without output on the terminal.
const SILENCE_S: u32 = 600;
/// That of the keys in `tests/fixtures`, too.
const PASSPHRASE: &str = "velvet";

/// Whether this line of the terminal asks for a passphrase.
fn is_prompt(line: &str) -> bool {
    line.ends_with(": ") && line.to_lowercase().contains("passphrase of ")
}

/// The text with the ids of keys replaced by numbers, and without times and sizes: encoders differ.
fn masked(text: &str) -> String {
    let mut keys: BTreeMap<String, usize> = BTreeMap::new();
    let words: Vec<&str> = text.split_inclusive(BETWEEN_WORDS).collect();
    let bare = |at: usize| words.get(at).map_or("", |word| word.trim_end_matches(BETWEEN_WORDS));
    let is_size = |at: usize| bare(at).parse::<f64>().is_ok() && ["B", "kB", "MB"].contains(&bare(at + 1));
    let mut mask = |at: usize| {
        let word = bare(at);
        let is_key = word.len() == 16 && word.chars().all(|c| c.is_ascii_digit() || ('A'..='F').contains(&c));
        let is_time = word.len() == 20 && word.ends_with('Z') && word.as_bytes()[10] == b'T';
        if is_key {
            let next = keys.len();
            format!("key-{}", keys.entry(word.to_owned()).or_insert(next))
        } else if is_time {
            "then".to_owned()
        } else if is_size(at) || at > 0 && is_size(at - 1) {
            "some".to_owned()
        } else {
            word.to_owned()
        }
    };
    words.iter().enumerate().map(|(at, word)| mask(at) + &word[bare(at).len()..]).collect()
}

/// A `make` that makes an image as the Makefile says, but without the system: it writes the settings of the sender, and
/// two matching halves of a system. Its folder has such halves of each version, `made-VERSION`.
const MAKE: &str = r#"#!/bin/sh
set -eu
words=$("$REAL_MAKE" --dry-run --no-print-directory -C "$REPOSITORY" "$@" | sed -n 's/^image-build\/build //p')
eval "set -- $words"
folder=$1 version=0.1.0 more=
shift
while [ $# -gt 0 ]; do
    case $1 in --profile) ;; --version) version=$2 ;; *) more="$more $1 $2" ;; esac
    shift 2
done
mkdir -p "tree-$version/etc/dreams" "$folder"
cp "$REPOSITORY/config/update.toml" "tree-$version/etc/dreams/"
"$REPOSITORY/image-build/sender" "tree-$version" $more
cp -r "$(dirname "$0")/made-$version" "$folder/unit-$version"
cp -r "tree-$version/etc/dreams/keys" "$folder/unit-$version/"
echo made
"#;

/// The packages of such halves, which the guide to maintaining compares.
const OLD_PACKAGES: &str = "linux-image-6.12.48+deb13-amd64\t6.12.48-1\nffmpeg-source\t7:7.1.2-0+deb13u1\n";
const NEW_PACKAGES: &str = "linux-image-6.12.57+deb13-amd64\t6.12.57-1\nffmpeg-source\t7:7.1.3-0+deb13u1\n";

/// Answers every prompt on the terminal; returns everything that it showed.
fn typed(terminal: &mut Child) -> String {
    let (mut keyboard, mut glass) = (terminal.stdin.take().unwrap(), terminal.stdout.take().unwrap());
    let (mut shown, mut byte) = (String::new(), [0]);
    loop {
        assert!(wait::is_ready(&glass, SILENCE_S), "the terminal shows nothing more: {shown}");
        if glass.read(&mut byte).unwrap() == 0 {
            return shown;
        }

        shown.push(char::from(byte[0]));
        if is_prompt(shown.lines().next_back().unwrap_or_default()) {
            writeln!(keyboard, "{PASSPHRASE}").unwrap();
            shown.push('\n');
        }
    }
}

#[test]
fn the_tutorial_then_the_guide_to_sending_print_what_they_show_and_a_unit_plays_what_was_sent() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    tutorial::follow(folder.path());
    fs::create_dir(at("stick")).unwrap();
    follow(SENDING, folder.path());
    assert!(lies_on(&at("stick")), "what was published is a bundle");
    is_taken_by_a_unit(folder.path());
    is_played(folder.path());
}

/// Runs the commands of `guide` in `folder`, which has the files that it starts from.
fn follow(guide: &str, folder: &Path) {
    let at = |name: &str| folder.join(name);
    let text = masked(&fs::read_to_string(repository().join(guide)).unwrap());
    let mut steps = steps(&text);
    assert!(steps.len() >= 7, "only {} steps were read", steps.len());
    let is_command = |line: &&String| !is_prompt(line);
    let prompts: Vec<String> =
        steps.iter().flat_map(|step| &step.shows).filter(|line| is_prompt(line)).cloned().collect();
    for step in &mut steps {
        step.shows = step.shows.iter().filter(is_command).cloned().collect();
    }
    let script = format!("exec > said 2>&1\n{}", steps.iter().map(marked).collect::<Vec<_>>().concat());
    fs::write(at("script"), script.replace(STICK, "stick")).unwrap();
    lay_make(&at("tools"));
    let path = std::env::var("PATH").unwrap_or_default();
    let real_make = std::env::split_paths(&path).map(|folder| folder.join("make")).find(|make| make.is_file()).unwrap();
    let path = format!("{}:{}:{path}", at("tools").display(), programs::dreams().parent().unwrap().display());
    let mut socat = Command::new("socat");
    socat.args(["-", "EXEC:bash script,pty,setsid,ctty,stderr,echo=0"]).current_dir(folder);
    socat.env("REAL_MAKE", real_make).env("REPOSITORY", repository());
    socat.env("PATH", path).env("NO_COLOR", "1").stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut terminal = socat.spawn().unwrap();
    let shown = typed(&mut terminal);
    assert!(wait::ended("the terminal", 60, &mut terminal).success());

    let said = masked(&fs::read_to_string(at("said")).unwrap()).replace("stick", STICK);
    for (Step { command, shows }, (lines, status)) in steps.iter().zip(printed(&said, steps.len())) {
        assert!(
            is_shown(shows, &lines),
            "`{command}` is shown as\n{}\nand prints\n{}",
            shows.join("\n"),
            lines.join("\n")
        );
        assert_eq!(status, "0", "`{command}`");
    }
    let asked: Vec<&str> = shown.lines().map(|line| line.trim_matches('\r')).filter(|line| !line.is_empty()).collect();
    assert_eq!(asked, prompts, "the passphrases that are asked for");
}

/// Writes such a `make` and its halves to `folder`.
fn lay_make(folder: &Path) {
    for version in ["0.1.0", "0.1.1", "0.2.0"] {
        let made = folder.join(format!("made-{version}"));
        make_halves(&made, version);
        let kernel = if version == "0.1.0" { OLD_PACKAGES } else { NEW_PACKAGES };
        fs::write(made.join("packages"), format!("systemd\t257.9-1~deb13u1\n{kernel}")).unwrap();
    }
    programs::write_script(&folder.join("make"), MAKE);
}

/// A unit with the guide's image takes the flock from the guide's stick, and looks for updates where the guide says.
fn is_taken_by_a_unit(folder: &Path) {
    for version in ["0.1.0", "0.2.0"] {
        let settings = folder.join(format!("tree-{version}/etc/dreams"));
        let config = fs::read_to_string(settings.join("update.toml")).unwrap();
        assert!(config.contains("\nurl = \"https://example.org/flocks\"\n"), "{config}");
        let mut update = Command::new(programs::updater());
        update.arg("--config").arg(settings.join("update.toml")).arg("--keys").arg(settings.join("keys"));
        update.args(["--unit", "lobby"]).arg("--store").arg(folder.join(format!("store-{version}")));
        succeed(update.arg(folder.join("stick")));
    }
}

/// The unit's player shows every frame of what was installed, on the path that the artist's tools foretell.
fn is_played(folder: &Path) {
    let seed = ["--seed", "7"];
    let mut walk = Command::new(programs::dreams());
    let walked = succeed(walk.arg("walk").arg(folder.join("aurora")).args(seed).args(["--steps", "4"]));
    let walked = String::from_utf8(walked).unwrap();
    let clips = walked.lines().count();
    assert!(clips >= 9, "four steps are four transitions between five visits: {walked}");
    let count = clips.to_string();
    let options = ["--screen", "virtual", "--clock", "free", "--clips", &count];
    let run = PlayerRun::of(&folder.join("store-0.1.0/current")).with(&seed).with(&options);
    succeed(&mut run.command());
    let trace = run.trace();
    assert_eq!(trace.faults, []);
    let frames = |clip: &str| if clip.starts_with("loops/") { LOOP_FRAMES } else { TRANSITION_FRAMES };
    let due: Vec<(&str, u64)> =
        walked.lines().flat_map(|clip| (0..frames(clip)).map(move |frame| (clip, frame))).collect();
    let shown: Vec<(&str, u64)> = trace.flips.iter().map(|flip| (&*flip.clip, flip.frame)).collect();
    assert_eq!(shown, due);
}

#[test]
fn the_guide_to_maintaining_prints_what_it_shows_and_its_units_take_the_new_system() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("stick")).unwrap();
    // Keys of an old format, which open in a tenth of a second.
    for name in ["artist", "spare"] {
        for kind in ["key", "pub"] {
            let key = repository().join("tests/fixtures/format-1/keys").join(name).with_extension(kind);
            succeed(Command::new("install").args(["--mode", "600"]).arg(key).arg(folder.path()));
        }
    }
    make_halves(&at("target/image/unit-0.1.0"), "0.1.0");
    fs::write(at("target/image/unit-0.1.0/packages"), format!("systemd\t257.9-1~deb13u1\n{OLD_PACKAGES}")).unwrap();
    let guide = fs::read_to_string(repository().join(MAINTAINING)).unwrap();
    let written = guide.split_once("```toml\n").and_then(|(_, rest)| rest.split_once("```")).unwrap().0;
    fs::write(at("lobby.toml"), written).unwrap();
    follow(MAINTAINING, folder.path());

    let settings = at("tree-0.1.1/etc/dreams");
    fs::write(at("os-release"), "ID=dreams\nVERSION_ID=0.1.0\n").unwrap();
    let config = fs::read_to_string(settings.join("update.toml")).unwrap();
    let config = config.replace("/usr/lib/os-release", at("os-release").to_str().unwrap());
    fs::write(at("update.toml"), config).unwrap();
    for unit in ["lobby", "stairs"] {
        let mut update = Command::new(programs::updater());
        update.arg("--json").arg("--config").arg(at("update.toml")).arg("--keys").arg(settings.join("keys"));
        let said = output(update.args(["--unit", unit, "--store"]).arg(at(unit)).arg(at("stick")));
        let answer = String::from_utf8_lossy(&said.stdout);
        assert!(said.status.success() && answer.contains("\"staged\": \"0.1.1\""), "{unit}: {answer}");
    }
    // The unit `lobby` takes the settings that the guide writes.
    let config =
        format!("keys = '{}'\nstore = '{}'\nunit = 'lobby'\n", settings.join("keys").display(), at("lobby").display());
    fs::write(at("owner.toml"), config).unwrap();
    let mut owner = Command::new(programs::owner());
    owner.arg("from-stick").arg(at("stick")).arg("--config").arg(at("owner.toml")).arg("--keep").arg(at("kept"));
    succeed(owner.arg("--inbox").arg(folder.path()).arg("--notice").arg(at("notice")));
    let mut owner = Command::new(programs::owner());
    succeed(owner.arg("install").arg(at("stick")).arg("--inbox").arg(folder.path()).arg("--notice").arg(at("notice")));
    assert_eq!(fs::read_to_string(at("stick/dreams.toml")).unwrap(), written);
}

#[test]
fn wrong_keys_and_addresses_are_told_before_anything_is_changed() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("tree/etc/dreams")).unwrap();
    fs::copy(repository().join("config/update.toml"), at("tree/etc/dreams/update.toml")).unwrap();
    let maker = BundleMaker::with_new_keys();
    let key = maker.keys().join("artist.pub");
    fs::create_dir(at("other")).unwrap();
    fs::copy(&key, at("other/artist.pub")).unwrap();
    fs::write(at("letter.pub"), "Dear Sir,\nRWhat a key\n").unwrap();
    let told = |words: &[&str]| {
        let said = output(Command::new(repository().join("image-build/sender")).arg(at("tree")).args(words));
        (said.status.code(), String::from_utf8(said.stderr).unwrap())
    };
    let (key, other, letter) = (key.to_str().unwrap(), at("other/artist.pub"), at("letter.pub"));
    for (words, code, said) in [
        (vec!["--key", "/nowhere.pub"], 3, "cannot read the public key `/nowhere.pub`"),
        (vec!["--key", key, "--key", letter.to_str().unwrap()], 2, "letter.pub` is not a valid public key"),
        (vec!["--key", key, "--key", other.to_str().unwrap()], 2, "two keys are called `artist.pub`"),
        (vec!["--key", key, "--system-key", letter.to_str().unwrap()], 2, "letter.pub` is not a valid public key"),
        (vec!["--key", key, "--url", "example.org"], 2, "`example.org` is not a valid address"),
        (vec!["--key", key, "--url", "https://a\"b"], 2, "is not a valid address"),
        (vec!["--colour", "red"], 2, "`--colour` is not a valid option"),
    ] {
        let (found, text) = told(&words);
        assert!(found == Some(code) && text.contains(said), "{words:?}: {found:?} {text}");
        assert!(!at("tree/etc/dreams/keys").exists(), "{words:?}");
    }
    let address = "http://10.0.0.7/a&b/*";
    assert_eq!(
        told(&["--key", key, "--system-key", other.to_str().unwrap(), "--url", address]),
        (Some(0), String::new())
    );
    assert!(at("tree/etc/dreams/keys/artist.pub").is_file() && at("tree/etc/dreams/system-keys/artist.pub").is_file());
    let before = fs::read_to_string(repository().join("config/update.toml")).unwrap();
    let after = fs::read_to_string(at("tree/etc/dreams/update.toml")).unwrap();
    let line = |line: &str| if line.starts_with("# url = ") { format!("url = \"{address}\"") } else { line.to_owned() };
    assert_eq!(after.lines().collect::<Vec<_>>(), before.lines().map(line).collect::<Vec<_>>());
}

/// Whether there is a bundle for the unit of the guide.
fn lies_on(stick: &Path) -> bool {
    stick.join(bundle::seal_path("lobby")).is_file()
}
