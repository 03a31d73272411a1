//! Rules for every Rust file.
//!
//! Owns the rules, one by one, and the list of files with `unsafe`. Each rule has an example that breaks it, so that
//! the rule itself is tested. Never repeats a lint of clippy's: the workspace's `Cargo.toml` and `clippy.toml` have those on
//! long functions, globs, clocks and reasons for `unsafe`. Documents and manifests are in [`super::facts`].
//!
//! Start at [`rules`].

use std::fmt::Write as _;

use cargo_metadata::Target;

use super::tokens::{Token, functions, positions, read};

/// The most lines of a file.
const LONGEST_FILE: usize = 500;
/// The most lines of a `main`.
const LONGEST_MAIN: usize = 15;
/// The packages that may have `unsafe`, each with the one file for it.
const FENCES: &[(&str, &str)] = &[("crates/screen/", "src/raw.rs"), ("crates/video/", "src/raw.rs")];
/// File names that say nothing.
const EMPTY_NAMES: &[&str] = &["common", "helper", "helpers", "manager", "misc", "util", "utils"];

/// A Rust file with its tokens.
struct Source {
    path: String,
    text: String,
    tokens: Vec<Token>,
}

/// A rule.
struct Rule {
    claim: &'static str,
    /// The lines that break it.
    broken: fn(&Source) -> Vec<usize>,
    /// The path and the text of a file that breaks it.
    example: (&'static str, String),
}

impl Source {
    fn new(path: &str, text: &str) -> Self {
        Self { path: path.to_owned(), text: text.to_owned(), tokens: read(path, text) }
    }

    /// The lines where the tokens are one of `phrases`.
    fn lines_of(&self, phrases: &[&[&str]]) -> Vec<usize> {
        phrases.iter().flat_map(|words| positions(&self.tokens, words).map(|token| token.line)).collect()
    }

    fn is_test(&self) -> bool {
        self.path.starts_with("tests/") || self.path.contains("/tests/")
    }
}

/// The rules, each with an example that breaks it.
fn rules() -> Vec<Rule> {
    let long = |lines: usize| "    //\n".repeat(lines - 2);
    let rule = |claim, broken, path, text: &str| Rule { claim, broken, example: (path, text.to_owned()) };
    vec![
        rule("opens with a `//!` header that says enough", without_header, "src/a.rs", "//! A.\nfn a() {}"),
        rule("has at most 500 lines", too_long, "src/a.rs", &"\n".repeat(LONGEST_FILE + 1)),
        rule(
            "has a `main` of at most 15 lines",
            long_main,
            "src/main.rs",
            &format!("fn main() {{\n{}}}", long(LONGEST_MAIN + 1)),
        ),
        rule(
            "leaves no work behind: an issue, or nothing",
            unfinished,
            "src/a.rs",
            &format!("// {}: rest", marks()[0]),
        ),
        rule("skips no test", skipped_tests, "src/a.rs", "#[test]\n#[ignore = \"slow\"]\nfn a() {}"),
        rule("is named for the noun it owns", nameless, "src/utils.rs", ""),
        rule(
            "holds `unsafe` only as its package's fence",
            unfenced,
            "crates/flame/src/a.rs",
            "unsafe impl Send for A {}",
        ),
    ]
}

/// A module says what it owns and what it leaves to others, which takes two lines; a file of tests may do with one.
fn without_header(source: &Source) -> Vec<usize> {
    let header = source.text.lines().take_while(|line| line.starts_with("//!")).count();
    let enough = if source.is_test() { 1 } else { 2 };
    if header < enough { vec![1] } else { vec![] }
}

fn too_long(source: &Source) -> Vec<usize> {
    if source.text.lines().count() > LONGEST_FILE { vec![LONGEST_FILE + 1] } else { vec![] }
}

fn long_main(source: &Source) -> Vec<usize> {
    let mains = functions(&source.tokens).into_iter().filter(|function| function.name == "main" && function.depth == 0);
    mains.filter(|main| main.lines > LONGEST_MAIN).map(|main| main.line).collect()
}

/// The marks of unfinished work, written so that this file has none.
fn marks() -> [String; 3] {
    [["TO", "DO"].concat(), ["FIX", "ME"].concat(), ["X"; 3].concat()]
}

fn unfinished(source: &Source) -> Vec<usize> {
    let marks = marks();
    let marked =
        |line: &str| line.split(|c: char| !c.is_alphanumeric()).any(|word| marks.iter().any(|mark| mark == word));
    source.text.lines().enumerate().filter(|(_, line)| marked(line)).map(|(above, _)| above + 1).collect()
}

fn skipped_tests(source: &Source) -> Vec<usize> {
    source.lines_of(&[&["#", "[", "ignore"]])
}

fn nameless(source: &Source) -> Vec<usize> {
    let empty = source.path.split('/').any(|part| EMPTY_NAMES.contains(&part.trim_end_matches(".rs")));
    if empty { vec![1] } else { vec![] }
}

fn unfenced(source: &Source) -> Vec<usize> {
    let is_fence = FENCES.iter().any(|(package, file)| source.path == format!("{package}{file}"));
    if is_fence { vec![] } else { source.lines_of(&[&["unsafe"]]) }
}

fn sources() -> Vec<Source> {
    super::files(".rs").iter().map(|(path, text)| Source::new(path, text)).collect()
}

#[test]
fn every_file_keeps_every_rule() {
    let mut faults = String::new();
    let (sources, rules) = (sources(), rules());
    for source in &sources {
        for rule in &rules {
            for line in (rule.broken)(source) {
                writeln!(faults, "{}:{line}: not a file that {}", source.path, rule.claim).unwrap();
            }
        }
    }
    assert!(sources.len() > 20, "only {} files were read", sources.len());
    assert!(faults.is_empty(), "\n{faults}");
}

#[test]
fn every_rule_finds_the_file_that_breaks_it() {
    for rule in rules() {
        let (path, text) = &rule.example;
        let source = Source::new(path, text);
        assert!(!(rule.broken)(&source).is_empty(), "nothing breaks: {}", rule.claim);
    }
}

#[test]
fn a_good_file_breaks_no_rule() {
    let fence = format!("{}{}", FENCES[0].0, FENCES[0].1);
    let text = "//! What it owns.\n//! Where to go next.\n#![allow(unsafe_code)]\n\
                fn a() {\n    // SAFETY: `b` was checked above.\n    unsafe { b(\"Instant::now\") }\n}\n\
                #[cfg(test)]\nmod tests {\n    use super::*;\n}\n";
    let source = Source::new(&fence, text);
    for rule in rules() {
        assert_eq!((rule.broken)(&source), [0; 0], "{}", rule.claim);
    }
}

#[test]
fn unsafe_code_is_forbidden_by_the_compiler_outside_the_fences() {
    let packages = super::metadata(false).packages;
    let shipped = |target: &&Target| target.is_lib() || target.is_bin();
    for target in packages.iter().flat_map(|package| &package.targets).filter(shipped) {
        let path = target.src_path.strip_prefix(super::root()).unwrap().as_str();
        let is_fence = FENCES.iter().any(|(package, _)| path == format!("{package}src/lib.rs"));
        let level = if is_fence { "deny" } else { "forbid" };
        let source = Source::new(path, &super::read(path));
        let said = source.lines_of(&[&["#", "!", "[", level, "(", "unsafe_code"]]);
        assert!(!said.is_empty(), "`{path}` does not open with `#![{level}(unsafe_code)]`");
    }
}

#[test]
fn each_fence_has_one_file_that_says_it_is_the_fence() {
    for (package, file) in FENCES {
        let source = Source::new(file, &super::read(&format!("{package}{file}")));
        let said = source.lines_of(&[&["#", "!", "[", "allow", "(", "unsafe_code"]]);
        assert!(!said.is_empty(), "`{package}{file}` does not open with `#![allow(unsafe_code)]`");
    }
}
