//! Facts that are written twice agree.
//!
//! Owns the claims about documents, manifests and scripts: what they name exists, lists give reasons, and two mentions
//! of a fact are equal. Rust code is searched for names only: [`super::sources`] judges it.
//!
//! Start at the tests: each is one pair of places.

use std::collections::BTreeSet;
use std::process::Command;

use super::tracked::tracked;
use super::{files, metadata, quoted, read, root, section};

/// The documents that a reader meets first.
const DOCUMENTS: &[&str] = &[
    "README.md",
    "ARCHITECTURE.md",
    "STYLE.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "docs/credits.md",
    "docs/farm.md",
    "docs/fleet.md",
    "docs/genomes.md",
    "docs/hardware.md",
    "docs/invariants.md",
    "docs/maintaining.md",
    "docs/security.md",
    "docs/sending.md",
    "docs/tutorial.md",
    "docs/variations.md",
    "image-build/README.md",
    "systemd/README.md",
];

/// The entries, `key = value`, of the TOML `text` that have no comment on the line above.
fn unexplained(text: &str) -> Vec<&str> {
    let entry = |line: &str| {
        let key = line.split(" = ").next().unwrap_or_default();
        line.contains(" = ") && key.chars().all(|c| c.is_alphanumeric() || "_-".contains(c))
    };
    let lines: Vec<&str> = text.lines().collect();
    let above = |at: usize| at.checked_sub(1).map_or("", |above| lines[above]);
    (0..lines.len()).filter(|at| entry(lines[*at]) && !above(*at).starts_with('#')).map(|at| lines[at]).collect()
}

/// The targets of the Makefile that have a description.
fn make_targets() -> Vec<String> {
    let explained = |line: &str| Some(line.split_once(": ## ")?.0.to_owned());
    read("Makefile").lines().filter_map(explained).collect()
}

/// The words after `make ` in code of the document.
fn make_commands(document: &str) -> Vec<&str> {
    let spans =
        document.lines().flat_map(|line| if line.starts_with("    ") { vec![line.trim()] } else { quoted(line) });
    spans.filter_map(|code| code.strip_prefix("make ")?.split_whitespace().next()).collect()
}

/// The targets of the document's links, within the repository.
fn links(document: &str) -> Vec<&str> {
    let targets = document.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
    targets.filter(|target| !target.is_empty() && !target.contains("://")).collect()
}

/// The number after `mark` in `text`.
pub(super) fn number_after(text: &str, mark: &str) -> usize {
    let rest = text.split_once(mark).unwrap_or_else(|| panic!("no `{mark}`")).1;
    rest.chars().take_while(char::is_ascii_digit).collect::<String>().parse().unwrap()
}

#[test]
fn every_dependency_says_what_it_saves_us() {
    let manifest = read("Cargo.toml");
    let (_, dependencies) = manifest.split_once("[workspace.dependencies]\n").unwrap();
    let (dependencies, _) = dependencies.split_once("\n[").unwrap();
    let silent: Vec<_> = unexplained(dependencies).into_iter().filter(|line| !line.contains("path = ")).collect();
    assert_eq!(silent, [""; 0]);
    assert_eq!(unexplained("# Why.\na = 1\nb-c = 2\n\nd = 3\n"), ["b-c = 2", "d = 3"]);
}

#[test]
fn every_dependency_of_a_package_is_the_one_that_the_workspace_explains() {
    for package in metadata(false).packages {
        let manifest: toml::Table = std::fs::read_to_string(&package.manifest_path).unwrap().parse().unwrap();
        for kind in ["dependencies", "dev-dependencies", "build-dependencies"] {
            for (name, asked) in manifest.get(kind).and_then(toml::Value::as_table).into_iter().flatten() {
                let inherited = asked.get("workspace").and_then(toml::Value::as_bool);
                assert_eq!(inherited, Some(true), "`{name}` of {} does not come from the workspace", package.name);
            }
        }
    }
}

#[test]
fn every_key_of_every_config_is_explained() {
    let configs: Vec<_> = files(".toml").into_iter().filter(|(path, _)| path.starts_with("config/")).collect();
    assert!(!configs.is_empty(), "no config was read");
    for (path, text) in configs {
        assert_eq!(unexplained(&text), [""; 0], "`{path}`");
    }
}

#[test]
fn every_package_that_is_installed_has_its_reason() {
    for (path, text) in files(".txt").iter().filter(|(path, _)| path.starts_with(".ci/packages/")) {
        let silent: Vec<_> = text.lines().filter(|line| !line.contains("# ")).collect();
        assert_eq!(silent, [""; 0], "`{path}`");
    }
}

#[test]
fn the_documents_name_only_make_targets_that_exist() {
    let targets = make_targets();
    assert_eq!(targets, ["help", "play", "check", "check-all", "gpu", "bench", "soak", "crash", "image", "boot"]);
    for path in DOCUMENTS {
        for named in make_commands(&read(path)) {
            let known = targets.iter().any(|target| target == named);
            assert!(known, "`{path}` names `make {named}`, which the Makefile does not know");
        }
    }
    assert_eq!(make_commands("text\n\n    make one\nSee `make two X`, or make three."), ["one", "two"]);
}

#[test]
fn the_scripts_that_the_makefile_runs_are_there() {
    let makefile = read("Makefile");
    let programs = makefile.lines().filter_map(|line| line.strip_prefix('\t')?.split_whitespace().next());
    let scripts: Vec<_> =
        programs.filter(|program| program.starts_with(".ci/") || program.starts_with("tests/")).collect();
    assert!(scripts.len() >= 4, "only {scripts:?} were read");
    for script in scripts {
        assert!(root().join(script).exists(), "the Makefile runs `{script}`, which is not there");
    }
}

#[test]
fn help_names_the_parts_that_bench_and_soak_can_run_alone() {
    let makefile = read("Makefile");
    let names = |list: &str| -> Vec<String> {
        let words = list.split([' ', ',']).filter(|word| !word.is_empty() && *word != "or");
        words.map(str::to_owned).collect()
    };
    for target in ["bench", "soak"] {
        let help = makefile.lines().find(|line| line.starts_with(&format!("{target}: ##"))).unwrap();
        let (_, list) = help.split_once("what=").unwrap();
        let told = names(list.strip_suffix(" for one part").unwrap());
        let refused = Command::new(root().join("tests").join(target).join("run")).arg("nothing").output().unwrap();
        let message = String::from_utf8(refused.stderr).unwrap();
        let (_, list) = message.trim_end().split_once("`nothing`: ").unwrap();
        assert_eq!(refused.status.code(), Some(2), "{message}");
        assert_eq!(told, names(list), "parts of `make {target}`");
        assert!(told.len() > 8, "{told:?}");
    }
}

#[test]
fn the_documents_link_only_to_what_is_there() {
    for path in DOCUMENTS {
        let folder = root().join(path).parent().unwrap().to_owned();
        for link in links(&read(path)) {
            assert!(folder.join(link).exists(), "`{path}` links to `{link}`, which is not there");
        }
    }
    assert_eq!(links("[a](b.md#c), ![d](e/f.jpg), [g](https://h), [i](#j)"), ["b.md", "e/f.jpg"]);
}

#[test]
fn clippy_counts_to_the_longest_function_that_the_style_allows() {
    let threshold = number_after(&read("clippy.toml"), "too-many-lines-threshold = ");
    assert_eq!(threshold, number_after(&read("STYLE.md"), " lines, functions "));
}

/// The folders that are two levels deep, and those above that have none.
fn deep_folders(paths: &[String]) -> BTreeSet<&str> {
    let above = |path: &'_ str, level: usize| path.match_indices('/').nth(level).map(|(end, _)| end);
    let deep: BTreeSet<&str> = paths.iter().filter_map(|path| Some(&path[..above(path, 1)?])).collect();
    let has_deep = |folder: &str| deep.iter().any(|path| path.starts_with(&format!("{folder}/")));
    let flat = paths.iter().filter_map(|path| Some(&path[..above(path, 0)?])).filter(|folder| !has_deep(folder));
    flat.chain(deep.iter().copied()).collect()
}

#[test]
fn the_list_of_folders_names_every_folder_and_only_starts_that_are_there() {
    let (architecture, tracked, code) = (read("ARCHITECTURE.md"), tracked(), files(".rs"));
    let has = |krate: &str, item: &str| {
        let kinds = ["struct", "enum", "trait", "fn"].map(|kind| format!("pub {kind} {item}"));
        let of_crate = |path: &str| path.starts_with(&format!("crates/{krate}/src/"));
        code.iter().any(|(path, text)| of_crate(path) && kinds.iter().any(|kind| text.contains(kind)))
    };
    let (mut listed, mut starts) = (BTreeSet::new(), 0);
    for row in section(&architecture, "## Folders").into_iter().filter(|line| line.starts_with("| `")) {
        let (folders, told) = row.trim_start_matches("| ").split_once(" | ").unwrap();
        let folders = quoted(folders);
        for start in told.rsplit_once(": ").map(|(_, starts)| quoted(starts)).unwrap_or_default() {
            let is_there = match start.split_once("::") {
                Some((krate, item)) => has(krate, item),
                None => folders.iter().any(|folder| tracked.contains(&format!("{folder}/{start}"))),
            };
            assert!(is_there, "`{start}` is not there: {row}");
            starts += 1;
        }
        listed.extend(folders);
    }
    assert!(starts >= 20, "only {starts} places to start were read");
    let missing: Vec<_> = deep_folders(&tracked).difference(&listed).copied().collect();
    assert_eq!(missing, [""; 0], "not in the list");
    assert!(listed.iter().all(|folder| root().join(folder).is_dir()), "a folder that is not there is in the list");
    let paths = ["a/b/c/d", "a/e", "f/g"].map(str::to_owned);
    assert_eq!(deep_folders(&paths), BTreeSet::from(["a/b", "f"]));
}

#[test]
fn a_restart_is_refused_exactly_where_the_same_words_would_be_read_again() {
    let refused = number_after(&read("systemd/dreams-player.service"), "\nRestartPreventExitStatus=");
    let help = read("player/dreams-player/settings/options.rs");
    let malformed = help.lines().find(|line| line.ends_with("is wrong")).expect("the help explains a malformed file");
    assert_eq!(malformed.trim().split_once(' ').unwrap().0, refused.to_string());
    assert!(read("ARCHITECTURE.md").contains(&format!(" {refused} (malformed input)")));
}

#[test]
fn the_screen_and_the_clips_weigh_colours_alike() {
    let weights = |path: &str, number: &str| -> String {
        let (code, mark) = (read(path), format!("const WEIGHTS: [{number}; 3] = "));
        let (_, rest) = code.split_once(&mark).unwrap_or_else(|| panic!("no `{mark}` in `{path}`"));
        rest.split_once(';').unwrap().0.to_owned()
    };
    assert_eq!(weights("crates/screen/src/convert.rs", "f64"), weights("crates/video/src/yuv.rs", "f32"));
}
