//! The artist's guide to sending does what it shows.
//!
//! Owns the claim that its commands, in order, print what stands below them, and ask for the passphrases that it shows.
//! They run at a terminal of their own, where the passphrases are typed. Never judges the prose.

use crate::programs::{self, repository, succeed};
use crate::tutorial::{Step, is_shown, marked, printed, steps};
use std::collections::BTreeMap;
use std::fs;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// The guide, from the root of the repository, and the stick that it speaks of.
const GUIDE: &str = "docs/sending.md";
const STICK: &str = "/media/stick";
/// The flock of the guide: the demo's, without these.
const LEFT_OUT: [&str; 5] = ["caldera", "nocturne", "orchid", "rosette", "undertow"];
const PASSPHRASE: &str = "velvet underground";

/// Whether the terminal shows this while somebody is asked for a passphrase.
fn is_prompt(line: &str) -> bool {
    line.ends_with(": ") && line.to_lowercase().contains("passphrase of ")
}

/// The text with every key's number by the order in which it comes, and without times.
fn masked(text: &str) -> String {
    let mut keys: BTreeMap<String, usize> = BTreeMap::new();
    let mut mask = |word: &str| {
        let is_key = word.len() == 16 && word.chars().all(|c| c.is_ascii_digit() || ('A'..='F').contains(&c));
        let is_time = word.len() == 20 && word.ends_with('Z') && word.as_bytes()[10] == b'T';
        if is_key {
            let next = keys.len();
            format!("key-{}", keys.entry(word.to_owned()).or_insert(next))
        } else if is_time {
            "then".to_owned()
        } else {
            word.to_owned()
        }
    };
    text.split_inclusive([' ', ',', '\n'])
        .map(|word| {
            mask(word.trim_end_matches([' ', ',', '\n'])) + &word[word.trim_end_matches([' ', ',', '\n']).len()..]
        })
        .collect()
}

/// Answers every prompt on the terminal; returns what it showed.
fn typed(terminal: &mut Child) -> String {
    let (mut keyboard, mut glass) = (terminal.stdin.take().unwrap(), terminal.stdout.take().unwrap());
    let (mut shown, mut byte) = (String::new(), [0]);
    while glass.read(&mut byte).unwrap() > 0 {
        shown.push(char::from(byte[0]));
        if is_prompt(shown.lines().next_back().unwrap_or_default()) {
            writeln!(keyboard, "{PASSPHRASE}").unwrap();
            shown.push('\n');
        }
    }
    shown
}

#[test]
fn the_guides_commands_print_what_it_shows_and_ask_for_what_it_tells() {
    let flock = programs::flock();
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let demo = repository().join("flock-tools/demo/small");
    succeed(Command::new("cp").arg("--recursive").arg(demo).arg(at("aurora")));
    for sheep in LEFT_OUT {
        succeed(Command::new(&flock).arg("drop").arg(at("aurora")).args([sheep, "--force", "--delete-files"]));
    }
    let manifest = fs::read_to_string(at("aurora/flock.toml")).unwrap().replacen("\"demo\"", "\"aurora\"", 1);
    fs::write(at("aurora/flock.toml"), manifest).unwrap();
    fs::create_dir(at("stick")).unwrap();

    let guide = masked(&fs::read_to_string(repository().join(GUIDE)).unwrap());
    let mut steps = steps(&guide);
    assert!(steps.len() >= 8, "only {} steps were read", steps.len());
    let is_command = |line: &&String| !is_prompt(line);
    let prompts: Vec<String> =
        steps.iter().flat_map(|step| &step.shows).filter(|line| is_prompt(line)).cloned().collect();
    for step in &mut steps {
        step.shows = step.shows.iter().filter(is_command).cloned().collect();
    }
    let script = format!("exec > said 2>&1\n{}", steps.iter().map(marked).collect::<Vec<_>>().concat());
    fs::write(at("script"), script.replace(STICK, "stick")).unwrap();
    let path = format!("{}:{}", flock.parent().unwrap().display(), std::env::var("PATH").unwrap_or_default());
    let mut socat = Command::new("socat");
    socat.args(["-", "EXEC:bash script,pty,setsid,ctty,stderr,echo=0"]).current_dir(folder.path());
    socat.env("PATH", path).env("NO_COLOR", "1").stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut terminal = socat.spawn().unwrap();
    let shown = typed(&mut terminal);
    assert!(terminal.wait().unwrap().success());

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
    assert!(lies_on(&at("stick")), "what was published is a bundle");
}

/// Whether there is a bundle for the unit of the guide.
fn lies_on(stick: &Path) -> bool {
    stick.join(bundle::seal_path("lobby")).is_file()
}
