//! Where files lie on a unit.
//!
//! Owns the claims about `systemd/layout`, the list of files, about `systemd/install`, which copies them, and about
//! `systemd/package`, which makes a Debian package of them. Unit files are in [`super::units`].
//!
//! Start at [`Row`].

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A line of the list.
#[derive(Debug)]
pub(super) struct Row {
    edition: String,
    mode: String,
    pub(super) from: String,
    pub(super) to: String,
}

/// The lines of the list.
pub(super) fn layout() -> Vec<Row> {
    let text = super::read("systemd/layout");
    let lines = text.lines().filter(|line| !line.starts_with('#') && !line.is_empty());
    let row = |line: &str| {
        let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        let [edition, mode, from, to] =
            <[String; 4]>::try_from(words).unwrap_or_else(|_| panic!("four words, found `{line}`"));
        Row { edition, mode, from, to }
    };
    lines.map(row).collect()
}

/// The result of `systemd/install` with `edition` under `root`, with placeholders for the programs: its standard error,
/// and every file and link.
fn installed(edition: &str, root: &Path) -> BTreeSet<String> {
    let built = tempfile::tempdir().unwrap();
    for program in layout().iter().filter_map(|row| row.from.strip_prefix("built:")) {
        fs::write(built.path().join(program), program).unwrap();
    }
    let mut install = Command::new(super::root().join("systemd/install"));
    install.arg(edition).arg(root).env("BUILT", built.path());
    let said = install.output().unwrap();
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    let mut found = BTreeSet::new();
    list(root, root, &mut found);
    found
}

fn list(folder: &Path, root: &Path, found: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && !path.is_symlink() {
            list(&path, root, found);
        } else {
            found.insert(format!("/{}", path.strip_prefix(root).unwrap().to_str().unwrap()));
        }
    }
}

fn places(edition: &str) -> BTreeSet<String> {
    let wanted = |row: &Row| row.edition == "all" || row.edition == edition;
    layout().into_iter().filter(wanted).map(|row| row.to).collect()
}

#[test]
fn whatever_is_made_for_a_unit_is_in_the_list_of_what_lies_on_it() {
    let rows = layout();
    for folder in ["systemd", "config"] {
        let (path, mut found) = (super::root().join(folder), BTreeSet::new());
        list(&path, &path, &mut found);
        for from in found.iter().map(|file| format!("{folder}{file}")) {
            let is_about_it =
                ["README.md", "layout", "install", "package"].iter().any(|name| from == format!("systemd/{name}"));
            let times = rows.iter().filter(|row| row.from == from).count();
            assert_eq!(times, usize::from(!is_about_it), "`{from}` in `systemd/layout`");
        }
    }
    let places: BTreeSet<_> = rows.iter().map(|row| &row.to).collect();
    assert_eq!(places.len(), rows.len(), "no two lie in the same place");
}

#[test]
fn a_machine_that_somebody_else_looks_after_gets_the_files_and_no_more() {
    let folder = tempfile::tempdir().unwrap();
    let found = installed("package", folder.path());
    assert_eq!(found, places("package"));
    let is_ours = |place: &String| place.contains("dreams");
    assert!(found.iter().all(is_ours), "nothing of that machine's own is replaced: {found:?}");
    let program = folder.path().join("usr/bin/dreams-player");
    assert_eq!(fs::read_to_string(program).unwrap(), "dreams-player");
}

#[test]
fn a_units_own_system_gets_its_user_its_services_and_a_silent_display_too() {
    let folder = tempfile::tempdir().unwrap();
    let timer = folder.path().join("usr/lib/systemd/system/fstrim.timer");
    fs::create_dir_all(timer.parent().unwrap()).unwrap();
    fs::write(timer, "[Timer]\nOnCalendar=weekly\n\n[Install]\nWantedBy=timers.target\n").unwrap();
    let found = installed("image", folder.path());
    assert!(found.is_superset(&places("image")));
    let read = |path: &str| fs::read_to_string(folder.path().join(path)).unwrap();
    let user = read("etc/passwd").lines().find(|line| line.starts_with("dreams:")).map(str::to_owned);
    assert_eq!(user.as_deref(), Some("dreams:x:880:880:Dreams in High Fidelity:/:/usr/sbin/nologin"));
    for wanted in [
        "sysinit.target.wants/dreams-player.service",
        "timers.target.wants/dreams-update.timer",
        "timers.target.wants/dreams-scrub.timer",
        "timers.target.wants/fstrim.timer",
    ] {
        assert!(found.contains(&format!("/etc/systemd/system/{wanted}")), "{wanted}: {found:?}");
    }
    let getty = folder.path().join("etc/systemd/system/getty@.service");
    assert_eq!(fs::read_link(getty).unwrap(), Path::new("/dev/null"));
}

#[test]
fn only_files_that_programs_read_or_run_are_laid_out() {
    for row in layout() {
        let (is_link, is_program) = (row.mode == "link", row.from.starts_with("built:"));
        let is_named = ["all", "image"].contains(&row.edition.as_str());
        let is_right = (is_link
            && ["/dev/null", "/run/dreams-owner/wired.conf", "/run/dreams-owner/wireless.conf"].contains(&&*row.from)
            && row.edition == "image")
            || (is_program && row.mode == "0755" && row.to.starts_with("/usr/bin/"))
            || (row.mode == "0755" && row.to.starts_with("/usr/lib/dreams/") && is_script(&row.from))
            || (!is_program && row.mode == "0644" && super::root().join(&row.from).is_file());
        assert!(is_named && is_right, "{row:?}");
    }
}

fn is_script(from: &str) -> bool {
    super::read(from).starts_with("#!/bin/sh\n")
}

/// The Debian package with `/bin/true` for the programs.
fn package(folder: &Path) -> PathBuf {
    let built = tempfile::tempdir().unwrap();
    for program in layout().iter().filter_map(|row| row.from.strip_prefix("built:")) {
        fs::copy("/bin/true", built.path().join(program)).unwrap();
    }
    let mut package = Command::new(super::root().join("systemd/package"));
    let said = package.arg(folder).env("BUILT", built.path()).env("SOURCE_DATE_EPOCH", "1754697600").output().unwrap();
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    fs::read_dir(folder).unwrap().next().unwrap().unwrap().path()
}

/// The output of `dpkg-deb` with `arguments` for `package`.
fn dpkg(arguments: &[&str], package: &Path) -> String {
    let said = Command::new("dpkg-deb").args(&arguments[..1]).arg(package).args(&arguments[1..]).output().unwrap();
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    String::from_utf8(said.stdout).unwrap()
}

#[test]
fn the_debian_package_holds_what_the_list_says_and_is_the_same_bytes_every_time() {
    let folders = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let [one, two] = folders.each_ref().map(|folder| package(folder.path()));
    assert_eq!(fs::read(&one).unwrap(), fs::read(two).unwrap());
    let listed = dpkg(&["--contents"], &one);
    let files = listed.lines().filter(|line| !line.starts_with('d'));
    let mut found = BTreeSet::new();
    for line in files {
        let words: Vec<&str> = line.split_whitespace().collect();
        let place = words[5].trim_start_matches('.');
        let row = layout().into_iter().find(|row| row.to == place).unwrap_or_else(|| panic!("{line}"));
        let mode = if row.mode == "0755" { "-rwxr-xr-x" } else { "-rw-r--r--" };
        assert_eq!((words[0], words[1]), (mode, "root/root"), "{line}");
        found.insert(place.to_owned());
    }
    assert_eq!(found, places("package"));

    let control = dpkg(&["--field"], &one);
    assert!(control.contains("Package: dreams\n") && control.contains("Depends: libc6"), "{control}");
    let settings: Vec<_> = found.iter().filter(|place| place.starts_with("/etc/")).map(String::as_str).collect();
    let info = |name: &str| dpkg(&["--info", name], &one);
    assert_eq!(info("conffiles").lines().collect::<Vec<_>>(), settings, "what an owner changed is kept");
    let preset = super::read("systemd/dreams.preset");
    let enabled: Vec<_> = preset.lines().filter_map(|line| line.strip_prefix("enable ")).collect();
    let postinst = info("postinst");
    assert!(
        postinst.contains(&format!("new=\"{}\"\n", enabled.join(" "))) && postinst.contains("systemctl preset $new\n")
    );
    for script in ["postinst", "prerm", "postrm"] {
        let said = Command::new("sh").args(["-n", "-c", &info(script)]).output().unwrap();
        assert!(said.status.success(), "{script}: {}", String::from_utf8_lossy(&said.stderr));
    }
}
