//! The installation of what the repository needs from the distribution.
//!
//! Owns the claims on `.ci/install`, tried with an `apt-get` and a `dpkg-query` that only record their arguments.
//! `tests/soak/fresh` tries the real ones.

use claims::programs::{self, output, repository};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// An `apt-get` that installs everything, unless the file `stubborn` says otherwise: `held`: only if it may downgrade;
/// `never`: nothing, and it reports success; `busy`: only after the third wait for another one, be it for the update or for
/// the installation; `locked`: never, for the same reason.
const APT: &str = r#"#!/bin/sh
# The options before the command are the same for all.
while [ "${1#-}" != "$1" ]; do case $1 in --option) shift 2 ;; *) shift ;; esac; done
case $(cat "$MACHINE/stubborn") in
  busy) [ $(wc -l < "$MACHINE/waits") -ge 3 ] && [ "$1" = update ] || [ $(wc -l < "$MACHINE/waits") -ge 6 ] || {
    echo "E: Could not get lock /var/lib/apt/lists/lock. It is held by process 1 (apt-get)" >&2; exit 100; } ;;
  locked) echo "E: Could not get lock /var/lib/apt/lists/lock. It is held by process 1 (apt-get)" >&2; exit 100 ;;
esac
echo "$*" >> "$MACHINE/asked"
case $1 in update) exit 0 ;; esac
case $(cat "$MACHINE/stubborn") in
  held) case $* in *--allow-downgrades*) ;; *) echo "E: held broken packages" >&2; exit 100 ;; esac ;;
  never) exit 0 ;;
esac
for word in "$@"; do
  case $word in -* | install | Dir::*) ;; *) echo "$word" >> "$MACHINE/installed" ;; esac
done
"#;

/// The user counts as root: with `sudo`, the real programs would be found.
const ID: &str = "#!/bin/sh\necho 0\n";

/// Waits that take no time, and are counted.
const SLEEP: &str = "#!/bin/sh\necho \"$*\" >> \"$MACHINE/waits\"\n";

const DPKG_QUERY: &str = r#"#!/bin/sh
for package in "$@"; do :; done
grep -qx -- "$package" "$MACHINE/installed" && printf installed
"#;

/// Runs `.ci/install image` on a machine with the packages `installed` and an apt that is `stubborn`; returns its
/// output and the arguments of apt.
fn install(machine: &Path, installed: &str, stubborn: &str) -> (Output, Vec<String>) {
    for (name, program) in [("apt-get", APT), ("dpkg-query", DPKG_QUERY), ("id", ID), ("sleep", SLEEP)] {
        programs::write_script(&machine.join(name), program);
    }
    for (name, text) in [("installed", installed), ("stubborn", stubborn), ("asked", ""), ("waits", "")] {
        fs::write(machine.join(name), text).unwrap();
    }
    let path = format!("{}:{}", machine.display(), std::env::var("PATH").unwrap());
    let mut command = Command::new(repository().join(".ci/install"));
    let said = output(command.arg("image").env("PATH", path).env("MACHINE", machine));
    let asked = fs::read_to_string(machine.join("asked")).unwrap();
    (said, asked.lines().filter(|line| line.starts_with("install")).map(str::to_owned).collect())
}

fn list() -> Vec<String> {
    let text = fs::read_to_string(repository().join(".ci/packages/image.txt")).unwrap();
    text.lines().filter_map(|line| line.split('#').next()?.split_whitespace().next()).map(str::to_owned).collect()
}

#[test]
fn the_whole_list_is_named_to_apt_which_may_remove_nothing() {
    let machine = tempfile::tempdir().unwrap();
    for stubborn in ["", "held"] {
        let (said, asked) = install(machine.path(), "qemu-utils\n", stubborn);
        assert!(said.status.success(), "{said:?}");
        assert_eq!(asked.len(), if stubborn.is_empty() { 1 } else { 2 }, "{asked:?}");
        for call in &asked {
            let words: Vec<_> = call.split(' ').collect();
            assert!(words.contains(&"--no-remove"), "{call}");
            assert!(list().iter().all(|package| words.contains(&package.as_str())), "{call}");
        }
    }
}

#[test]
fn a_package_that_apt_leaves_out_is_named_and_is_a_failure() {
    let machine = tempfile::tempdir().unwrap();
    let all_but =
        |left_out: &str| list().into_iter().filter(|package| package != left_out).collect::<Vec<_>>().join("\n");
    let (said, _) = install(machine.path(), &all_but("ovmf"), "never");
    assert_eq!(said.status.code(), Some(1));
    let words = String::from_utf8(said.stderr).unwrap();
    assert!(words.ends_with("install: apt could not install: ovmf\n"), "{words}");
}

#[test]
fn nothing_is_asked_of_apt_where_nothing_is_missing() {
    let machine = tempfile::tempdir().unwrap();
    let (said, asked) = install(machine.path(), &list().join("\n"), "never");
    assert!(said.status.success() && asked.is_empty(), "{said:?} {asked:?}");
}

#[test]
fn another_apt_is_waited_for_at_each_step_and_one_that_never_ends_is_named() {
    let machine = tempfile::tempdir().unwrap();
    let waits = || fs::read_to_string(machine.path().join("waits")).unwrap().lines().count();
    let (said, asked) = install(machine.path(), "qemu-utils\n", "busy");
    assert!(said.status.success() && asked.len() == 1, "{said:?} {asked:?}");
    assert_eq!(waits(), 6, "three for the update and three for the installation");

    let (said, asked) = install(machine.path(), "qemu-utils\n", "locked");
    let words = String::from_utf8(said.stderr).unwrap();
    assert!(!said.status.success() && asked.is_empty(), "{words}");
    assert!(words.contains("Could not get lock") && words.contains("held by process 1"), "{words}");
    assert_eq!(waits(), 120, "ten minutes");
}
