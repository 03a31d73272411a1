//! The artist's tutorial, and its page on other species, do what they show.
//!
//! Owns the check that their commands, in order, on a fresh copy, print what stands below them; `guides.rs` makes that of the
//! tutorial, and goes on with what it leaves. Never judges the prose.
//!
//! A block of `console` is a line `$ command` and below it what that prints, on either stream; `...` stands for any
//! lines. A command that ends with another status than 0 is followed by `$ echo $?`.

use claims::programs::{self, repository};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The tutorial, and its page on other species, from the root of the repository.
const TUTORIAL: &str = "docs/tutorial.md";
const SPECIES: &str = "docs/species.md";
/// Printed between the commands; no command prints it.
const MARK: &str = "\u{1}";

/// A command of the tutorial, and the output that it shows.
#[derive(Debug, PartialEq)]
pub(crate) struct Step {
    pub(crate) command: String,
    pub(crate) shows: Vec<String>,
}

/// The steps of a document, in order.
pub(crate) fn steps(document: &str) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    let mut within = false;
    for line in document.lines() {
        if let Some(fence) = line.strip_prefix("```") {
            within = fence == "console";
        } else if let Some(command) = line.strip_prefix("$ ").filter(|_| within) {
            steps.push(Step { command: command.to_owned(), shows: Vec::new() });
        } else if within {
            steps.last_mut().expect("a block begins with a command").shows.push(line.to_owned());
        }
    }
    steps
}

/// Whether the lines are those that are shown; `...` stands for any.
pub(crate) fn is_shown(shown: &[String], lines: &[&str]) -> bool {
    match shown.split_first() {
        None => lines.is_empty(),
        Some((first, rest)) if first == "..." => (0..=lines.len()).any(|skipped| is_shown(rest, &lines[skipped..])),
        Some((first, rest)) => lines.first() == Some(&first.as_str()) && is_shown(rest, &lines[1..]),
    }
}

/// The step as a line of a script: a mark and its exit status follow its output.
pub(crate) fn marked(step: &Step) -> String {
    format!("{}\nstatus=$?; printf '{MARK}%d\\n' $status; (exit $status)\n", step.command)
}

/// The output of each of so many steps, and its exit status.
pub(crate) fn printed(said: &str, steps: usize) -> Vec<(Vec<&str>, &str)> {
    let mut parts = said.split(MARK);
    let mut before = parts.next().unwrap_or_default();
    let mut all = Vec::new();
    for part in parts {
        let (status, rest) = part.split_once('\n').unwrap();
        all.push((before.lines().collect(), status));
        before = rest;
    }
    assert_eq!(all.len(), steps, "not every step ended: {said}");
    all
}

/// Runs the commands of the tutorial in the empty folder `folder`.
pub(crate) fn follow(folder: &Path) {
    follow_page(TUTORIAL, folder);
}

/// Runs the commands of a page of the tutorial in the empty folder `folder`.
fn follow_page(page: &str, folder: &Path) {
    let steps = steps(&fs::read_to_string(repository().join(page)).unwrap());
    assert!(steps.len() >= 15, "only {} steps were read", steps.len());
    symlink(repository().join("flock-tools"), folder.join("flock-tools")).unwrap();
    follow_steps(&steps, folder);
}

/// Runs the commands of these steps in `folder`, and compares what they print with what is shown.
pub(crate) fn follow_steps(steps: &[Step], folder: &Path) {
    let dreams = programs::dreams();
    let script = steps.iter().map(marked).collect::<Vec<_>>().concat();
    let mut bash = Command::new("bash");
    let path = format!("{}:{}", dreams.parent().unwrap().display(), std::env::var("PATH").unwrap_or_default());
    bash.current_dir(folder).env("PATH", path).env("NO_COLOR", "1").args(["-c", &format!("exec 2>&1\n{script}")]);
    let said = String::from_utf8(programs::output(&mut bash).stdout).unwrap();
    let printed = printed(&said, steps.len());
    for (at, (Step { command, shows }, (lines, status))) in steps.iter().zip(printed).enumerate() {
        let (as_shown, as_printed) = (shows.join("\n"), lines.join("\n"));
        let (mut shows, mut lines) = (shows.clone(), lines);
        // Clips are told as they are ready, several are rendered at once, and slow ones with their progress.
        if command.starts_with("dreams render ") {
            lines.retain(|line| !line.ends_with(" to go"));
            shows.sort();
            lines.sort_unstable();
        }
        assert!(is_shown(&shows, &lines), "`{command}` is shown as\n{as_shown}\nand prints\n{as_printed}");
        let told = steps.get(at + 1).is_some_and(|next| next.command == "echo $?");
        assert!(status == "0" || told, "`{command}` ends with {status} and the tutorial does not tell");
    }
}

#[test]
fn the_page_on_other_species_prints_what_it_shows() {
    let folder = tempfile::tempdir().unwrap();
    follow_page(SPECIES, folder.path());
    for picture in ["malachite", "gilt", "almond"] {
        let [made, shown] = [folder.path().join(format!("{picture}.png")), shown(picture)].map(fs::read);
        assert!(made.unwrap() == shown.unwrap(), "the picture of `{picture}` on the page is another");
    }
}

/// The picture of a sheep on the pages.
fn shown(picture: &str) -> PathBuf {
    repository().join(format!("docs/tutorial/{picture}.png"))
}

#[test]
fn the_tutorials_pictures_are_small_and_there() {
    let pages = [TUTORIAL, SPECIES].map(|page| fs::read_to_string(repository().join(page)).unwrap());
    let document = pages.concat();
    let pictures: Vec<&str> = document.split("![").skip(1).filter_map(|rest| rest.split(['(', ')']).nth(1)).collect();
    assert!(pictures.len() >= 8, "only {pictures:?} were read");
    let bytes = |picture: &&str| fs::metadata(repository().join("docs").join(picture)).unwrap().len();
    let total: u64 = pictures.iter().map(bytes).sum();
    assert!(total < 1_500_000, "{total} bytes of pictures");
}

#[test]
fn a_step_that_prints_something_else_is_found() {
    let steps = steps("a\n```console\n$ one\nx\n...\n$ two\n```\n$ none\n```\n$ none\n```\n");
    let shows = |lines: &[&str]| lines.iter().map(|line| (*line).to_owned()).collect();
    assert_eq!(steps[0], Step { command: "one".into(), shows: shows(&["x", "..."]) });
    assert_eq!((steps.len(), steps[1].shows.len()), (2, 0));
    assert!(is_shown(&steps[0].shows, &["x"]) && is_shown(&steps[0].shows, &["x", "y", "z"]));
    assert!(!is_shown(&steps[0].shows, &["y"]) && !is_shown(&steps[1].shows, &["y"]));
}
