//! Every test is tried by `make check` or by `make check-all`, and says by its place by which.
//!
//! Owns the list of executables with tests and of the targets of the Makefile that run them, and the walk from each
//! executable along its modules. A test in a file that no executable reaches, or in an executable that no target runs, is
//! found. Never runs a test.
//!
//! Start at [`TIERS`].

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use cargo_metadata::{Metadata, TargetKind};

use super::tokens::{Token, positions, read};

/// The executables of tests, and the target of the Makefile that runs each.
const TIERS: &[(&str, &str)] = &[
    // The first tier.
    ("--lib", "tests"),
    ("--bins", "tests"),
    ("--doc", "tests"),
    ("--test it", "tests"),
    // The second tier.
    ("--test slow", "slow"),
    ("--test image", "slow"),
    // What takes hours, or a machine that few have.
    ("--test gpu", "gpu"),
    ("--bench image-whole", "crash"),
];
/// The targets that each tier's command runs.
const COMMANDS: &[(&str, &str)] = &[("check", "tests"), ("check-all", "check"), ("check-all", "slow")];

/// How cargo is told to run an executable. `None`: cargo builds it for something else than tests.
fn option(kind: &TargetKind, name: &str) -> Option<String> {
    let named = [(TargetKind::Test, format!("--test {name}")), (TargetKind::Bench, format!("--bench {name}"))];
    let all = [(TargetKind::Lib, "--lib".to_owned()), (TargetKind::Bin, "--bins".to_owned())];
    all.into_iter().chain(named).find(|(known, _)| known == kind).map(|(_, option)| option)
}

/// The lines of commands of a target of the Makefile, joined where they go on.
fn recipe(makefile: &str, target: &str) -> String {
    let makefile = makefile.replace("\\\n", " ");
    let heads = |line: &&str| !line.starts_with(&format!("{target}:")) || line.contains(":=");
    let lines = makefile.lines().skip_while(heads).skip(1);
    lines.take_while(|line| line.starts_with('\t')).collect::<Vec<_>>().join("\n")
}

/// The files of the modules that the file at `path` declares. `is_root`: its modules lie beside it, as those of `mod.rs` do.
fn declared(path: &Path, is_root: bool, tokens: &[Token]) -> Vec<PathBuf> {
    let folder = path.parent().expect("a file lies in a folder");
    let own = if is_root { folder.to_owned() } else { folder.join(path.file_stem().expect("a file has a name")) };
    // The inline modules that are open, each with the depth of its braces.
    let (mut open, mut found): (Vec<(usize, String)>, Vec<PathBuf>) = (Vec::new(), Vec::new());
    for (at, token) in tokens.iter().enumerate() {
        open.retain(|(depth, _)| !(token.text == "}" && token.depth == *depth));
        let (Some(name), Some(end)) = (tokens.get(at + 1), tokens.get(at + 2)) else { break };
        if token.text != "mod" {
            continue;
        }
        if end.text == "{" {
            open.push((end.depth, name.text.clone()));
        } else if end.text == ";" {
            let told = tokens[..at].iter().rev().take_while(|before| !matches!(&*before.text, ";" | "}"));
            let told = told.filter(|before| before.text.starts_with('"') && before.text.ends_with(".rs\"")).last();
            let inner = open.iter().fold(own.clone(), |folder, (_, name)| folder.join(name));
            match told {
                Some(told) => found.push(folder.join(told.text.trim_matches('"'))),
                None => found.extend([inner.join(format!("{}.rs", name.text)), inner.join(&name.text).join("mod.rs")]),
            }
        }
    }
    found
}

/// The path without `..`.
fn plain(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut plain, part| {
        if part.as_os_str() == ".." {
            plain.pop();
        } else {
            plain.push(part);
        }
        plain
    })
}

/// The files that the executable with this root is compiled of.
fn compiled(root: &Path, files: &BTreeMap<PathBuf, Vec<Token>>) -> BTreeSet<PathBuf> {
    let mut reached = BTreeSet::from([root.to_owned()]);
    let mut left = vec![(root.to_owned(), true)];
    while let Some((path, is_root)) = left.pop() {
        let Some(tokens) = files.get(&path) else { continue };
        for found in declared(&path, is_root || path.ends_with("mod.rs"), tokens) {
            let found = plain(&found);
            if files.contains_key(&found) && reached.insert(found.clone()) {
                left.push((found, false));
            }
        }
    }
    reached
}

/// The files with tests that no executable of `runs` reaches.
fn untried(metadata: &Metadata, files: &BTreeMap<PathBuf, Vec<Token>>, runs: &[(&str, &str)]) -> Vec<PathBuf> {
    let mut tried = BTreeSet::new();
    for target in metadata.packages.iter().flat_map(|package| &package.targets) {
        let options = target.kind.iter().filter_map(|kind| option(kind, &target.name));
        let is_run = |option: &String| runs.iter().any(|(known, _)| known == option);
        // Benches are never run as tests unless they are named.
        let has_tests = target.test || target.kind.contains(&TargetKind::Bench);
        if has_tests && options.into_iter().any(|option| is_run(&option)) {
            tried.extend(compiled(target.src_path.as_std_path(), files));
        }
    }
    let has_tests = |tokens: &Vec<Token>| positions(tokens, &["#", "[", "test", "]"]).next().is_some();
    files
        .iter()
        .filter(|(path, tokens)| has_tests(tokens) && !tried.contains(*path))
        .map(|(path, _)| path.clone())
        .collect()
}

fn all_files() -> BTreeMap<PathBuf, Vec<Token>> {
    let files = super::files(".rs").into_iter();
    files.map(|(path, text)| (super::root().join(&path), read(&path, &text))).collect()
}

#[test]
fn no_test_is_in_neither_tier() {
    let (metadata, files) = (super::metadata(false), all_files());
    assert_eq!(untried(&metadata, &files, TIERS), Vec::<PathBuf>::new(), "no target of the Makefile runs their tests");
    for (left_out, of) in [("--lib", "crates"), ("--test it", "tests/it"), ("--test slow", "tests/slow")] {
        let fewer: Vec<_> = TIERS.iter().copied().filter(|(option, _)| *option != left_out).collect();
        let missed = untried(&metadata, &files, &fewer);
        assert!(missed.iter().any(|path| path.starts_with(super::root().join(of))), "`{left_out}` is not missed");
    }
}

#[test]
fn the_makefile_runs_each_tier() {
    let makefile = super::read("Makefile");
    for (option, target) in TIERS {
        let runs = recipe(&makefile, target);
        let words: Vec<_> = runs.split_whitespace().collect();
        let wanted: Vec<_> = option.split(' ').collect();
        assert!(words.windows(wanted.len()).any(|words| words == wanted), "`make {target}` has no `{option}`: {runs}");
    }
    for (command, target) in COMMANDS {
        let runs = recipe(&makefile, command);
        let words: Vec<_> = runs.split_whitespace().collect();
        assert!(words.contains(target), "`make {command}` makes no `{target}`: {runs}");
    }
    assert!(
        super::read(".ci/run").lines().any(|line| line.trim() == "make check-all"),
        "the automatic check runs both tiers"
    );
    assert_eq!(recipe("a: b ## c\n\tone \\\n  two\n\tthree\n\nd:\n\tfour", "a"), "\tone    two\n\tthree");
}

#[test]
fn modules_are_followed_into_files_folders_and_other_places() {
    let declares = |path: &str, is_root, text: &str| declared(Path::new(path), is_root, &read(path, text));
    let paths = |paths: &[&str]| paths.iter().map(PathBuf::from).collect::<Vec<_>>();
    assert_eq!(declares("t/main.rs", true, "mod a; mod b { fn c() {} }"), paths(&["t/a.rs", "t/a/mod.rs"]));
    assert_eq!(
        declares("t/a.rs", false, "mod b { pub mod c; } mod d;"),
        paths(&["t/a/b/c.rs", "t/a/b/c/mod.rs", "t/a/d.rs", "t/a/d/mod.rs"])
    );
    assert_eq!(declares("t/mod.rs", true, "#[path = \"../x/y.rs\"]\nmod y;"), paths(&["t/../x/y.rs"]));
    assert_eq!(plain(Path::new("t/../x/y.rs")), PathBuf::from("x/y.rs"));
}
