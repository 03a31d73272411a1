//! The kinds of files that git tracks in each folder.
//!
//! Owns the table, and the claim that it is exact, so that a note, a log or a scratch file that was added by mistake is
//! found.

use super::root;
use std::collections::BTreeSet;
use std::fs;
use std::process::Command;

/// A script: it begins with `#!`, whatever its name.
const SCRIPT: &str = "#!";

/// Folders, and the names that files in them or below them may have; the longest matching folder counts. `*` stands for
/// any letters. Where a note could pass for one of our files, each name is listed.
const KINDS: &[(&str, &[&str])] = &[
    (
        "",
        &[
            "ARCHITECTURE.md",
            "CHANGELOG.md",
            "CONTRIBUTING.md",
            "README.md",
            "STYLE.md",
            "*.toml",
            "Cargo.lock",
            "LICENSE-*",
            "Makefile",
            ".gitignore",
        ],
    ),
    (".cargo", &["config.toml", SCRIPT]),
    (".ci", &[SCRIPT]),
    (".ci/packages", &["*.txt"]),
    ("config", &["*.toml", "sticks.conf"]),
    ("crates", &["Cargo.toml", "*.rs"]),
    ("crates/agents/fuzz", &["Cargo.toml", "Cargo.lock", "*.rs"]),
    ("crates/agents/fuzz/corpus", &["*"]),
    ("crates/expression/fuzz", &["Cargo.toml", "Cargo.lock", "*.rs"]),
    ("crates/expression/fuzz/corpus", &["*"]),
    ("crates/flame/src/render/gpu", &["*.rs", "*.wgsl"]),
    ("crates/flame/fuzz", &["Cargo.toml", "Cargo.lock", "*.rs"]),
    ("crates/flame/fuzz/corpus", &["*"]),
    ("crates/flame/tests/genomes", &["*.flam3"]),
    ("crates/plant/fuzz", &["Cargo.toml", "Cargo.lock", "*.rs"]),
    ("crates/plant/fuzz/corpus", &["*"]),
    ("crates/flock/proptest-regressions", &["*.txt"]),
    ("crates/flock/src/edit/tests", &["*.rs", "*.toml"]),
    ("crates/flock/src/walk/itinerary", &["*.rs", "place"]),
    (
        "docs",
        &[
            "breeding.md",
            "credits.md",
            "farm.md",
            "fleet.md",
            "genomes.md",
            "hardware.md",
            "invariants.md",
            "maintaining.md",
            "security.md",
            "sending.md",
            "species.md",
            "studio.md",
            "tutorial.md",
            "variations.md",
            "votes.md",
            "*.png",
            "*.webp",
        ],
    ),
    ("flock-tools", &["Cargo.toml", "*.rs"]),
    (
        "flock-tools/demo",
        &["README.md", "flock.toml", "*.flam3", "*.expr", "*.agents", "*.plant", "*.mp4", "picture.jpg", "play"],
    ),
    ("flock-tools/commands/src/report/sheet", &["*.css", "*.html", "*.js"]),
    ("flock-tools/studio", &["Cargo.toml", "*.rs", "tsconfig.json"]),
    ("flock-tools/fleet/src/page", &["*.css", "*.js", "*.rs"]),
    ("flock-tools/studio/page", &["*.css", "*.html", "*.js", "*.d.ts"]),
    ("fuzz", &["Cargo.toml", "Cargo.lock", "*.rs"]),
    ("fuzz/corpus", &["*"]),
    (
        "image-build",
        &[
            "README.md",
            "build-root.txt",
            "config.txt",
            "extracts.txt",
            "initramfs.txt",
            "masked.txt",
            "packages.txt",
            "services.txt",
            "unneeded.txt",
            "*.c",
            "*.s",
            "*.sfdisk",
            "architecture",
            "cache",
            SCRIPT,
        ],
    ),
    ("image-build/modules", &["*.txt"]),
    ("image-build/owner", &["README.txt"]),
    ("image-build/ffmpeg", &[SCRIPT]),
    ("image-build/system", &["*.conf", "*.network", "*.path", "*.service", "*.target", "*.timer", "disk", SCRIPT]),
    ("player", &["Cargo.toml", "*.rs", "*.html"]),
    (
        "systemd",
        &[
            "README.md",
            "layout",
            "*.conf",
            "*.path",
            "*.preset",
            "*.rules",
            "*.service",
            "*.slice",
            "*.sysusers",
            "*.timer",
            "*.tmpfiles",
            SCRIPT,
        ],
    ),
    ("tests", &["Cargo.toml", "*.rs", "*.py", SCRIPT]),
    ("tests/bench/studio", &["*.rs", "*.js"]),
    ("tests/fixtures", &["flock.toml"]),
    ("tests/fixtures/certificates", &["*.pem", "server.key"]),
    ("tests/fixtures/failures", &["*.agents", "*.expr", "*.flam3", "*.plant"]),
    ("tests/fixtures/format-1", &["*"]),
    ("tests/fixtures/keys", &["artist.key", "artist.pub"]),
    ("tests/fixtures/sentences", &["*.txt"]),
    ("tests/image", &["*.rs", "light-flock", "writable.txt"]),
    ("tests/slow/studio", &["*.rs", "*.js"]),
    ("tests/package", &["inside", SCRIPT]),
    ("tests/vkms", &["*.config", SCRIPT]),
];

/// Whether a file's `name` matches `pattern`, in which one `*` stands for any letters.
fn is_named(name: &str, pattern: &str) -> bool {
    match pattern.split_once('*') {
        Some((begin, end)) => name.len() >= begin.len() + end.len() && name.starts_with(begin) && name.ends_with(end),
        None => name == pattern,
    }
}

/// The row of the table for `path`, and the pattern in it that allows it.
fn allowed(path: &str, is_script: bool) -> (usize, Option<usize>) {
    let (folder, name) = path.rsplit_once('/').unwrap_or(("", path));
    let is_in = |row: &str| folder == row || !row.is_empty() && folder.starts_with(&format!("{row}/"));
    let rows = KINDS.iter().enumerate().filter(|(_, (row, _))| is_in(row));
    let (row, (_, patterns)) = rows.max_by_key(|(_, (row, _))| row.len()).unwrap_or((0, &KINDS[0]));
    let fits = |pattern: &&str| if *pattern == SCRIPT { is_script } else { is_named(name, pattern) };
    (row, patterns.iter().position(fits))
}

/// Every tracked file, by its path from the root.
pub(super) fn tracked() -> Vec<String> {
    let mut git = Command::new("git");
    let said = git.args(["-c", "safe.directory=*", "ls-files", "-z"]).current_dir(root()).output().expect("git starts");
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    String::from_utf8(said.stdout).unwrap().split_terminator('\0').map(str::to_owned).collect()
}

#[test]
fn only_files_of_the_kinds_that_belong_to_a_folder_are_tracked_in_it() {
    let mut used = BTreeSet::new();
    let mut strangers = Vec::new();
    for path in tracked() {
        let Ok(bytes) = fs::read(root().join(&path)) else { continue };
        let (row, pattern) = allowed(&path, bytes.starts_with(SCRIPT.as_bytes()));
        match pattern {
            Some(pattern) => drop(used.insert((row, pattern))),
            None => strangers.push(path),
        }
    }
    assert!(strangers.is_empty(), "files of kinds that the table does not have there: {strangers:?}");
    let all = KINDS.iter().enumerate().flat_map(|(row, (_, patterns))| (0..patterns.len()).map(move |at| (row, at)));
    let unused: Vec<_> =
        all.filter(|pair| !used.contains(pair)).map(|(row, at)| (KINDS[row].0, KINDS[row].1[at])).collect();
    assert!(unused.is_empty(), "the table has kinds that no file is of: {unused:?}");
}

#[test]
fn a_stray_note_is_found_wherever_it_lies() {
    for path in [
        "crates/flame/LEAD-NOTE.txt",
        "notes.txt",
        "NOTES.md",
        "docs/notes.md",
        ".ci/notes.txt",
        "tests/it/out.log",
        "image-build/notes.txt",
        "image-build/scratch",
        "config/old.toml~",
    ] {
        assert_eq!(allowed(path, false).1, None, "{path}");
    }
}
