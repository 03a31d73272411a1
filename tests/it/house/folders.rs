//! Within a package, a folder sees only the folders that stand above it in the table of the package's root.
//!
//! Owns the claim, for every package whose `lib.rs` or `main.rs` has such a table. Tests may see everything. Never looks
//! at arrows between packages: [`super::layers`] does.
//!
//! Start at [`wrong_arrows`].

use std::collections::BTreeSet;

use super::tokens::{Token, read};

/// What the table is headed.
const HEAD: &str = "//! | folder | what is there |";

/// The folders that the root of a package lists in its header, in this order.
fn listed(root: &str) -> Vec<&str> {
    let table = root.lines().skip_while(|line| *line != HEAD).skip(2).take_while(|line| line.starts_with("//! | "));
    table.map(|row| super::quoted(row)[0]).collect()
}

/// What the file at `path`, seen from the package's `src`, sees of the package outside its tests: the first part of each
/// path, and its line.
fn seen(path: &str, text: &str) -> Vec<(String, usize)> {
    let depth = path.trim_end_matches("/mod.rs").split('/').count();
    let tokens: Vec<Token> = read(path, text).into_iter().filter(|token| !token.in_tests).collect();
    let is = |at: usize, text: &str| tokens.get(at).is_some_and(|token| token.text == text);
    let leads_on = |at: usize| is(at + 1, ":") && is(at + 2, ":");
    let starts = |at: &usize| {
        (is(*at, "crate") || is(*at, "super"))
            && leads_on(*at)
            && !at.checked_sub(1).is_some_and(|before| is(before, ":"))
    };
    let top = |at: usize| {
        let (mut at, mut climbed) = (at, if is(at, "crate") { depth } else { 1 });
        while is(at + 3, "super") && leads_on(at + 3) {
            (at, climbed) = (at + 3, climbed + 1);
        }
        (climbed == depth).then(|| (tokens[at + 3].text.clone(), tokens[at].line))
    };
    (0..tokens.len()).filter(starts).filter_map(top).collect()
}

/// The arrows that lead to a folder further down in the table, or to none; `files` are by their paths from `src`.
fn wrong_arrows(folders: &[&str], files: &[(&str, &str)]) -> Vec<String> {
    let place = |folder: &str| folders.iter().position(|other| *other == folder);
    let mut wrong = Vec::new();
    for (path, text) in files.iter().filter(|(path, _)| path.contains('/') && !path.contains("tests")) {
        let from = path.split('/').next().unwrap_or_default();
        for (to, line) in seen(path, text).into_iter().filter(|(to, _)| to != from) {
            if place(&to).is_none() || place(&to) > place(from) {
                wrong.push(format!("{path}:{line} must not see `{to}`"));
            }
        }
    }
    wrong
}

#[test]
fn every_folder_sees_only_those_that_its_package_lists_above_it() {
    let files = super::files(".rs");
    let mut packages = 0;
    for (path, root) in files.iter().filter(|(_, text)| text.lines().any(|line| line == HEAD)) {
        let Some((src, _)) = path.rsplit_once("lib.rs").or(path.rsplit_once("main.rs")) else { continue };
        let inside = |(path, text)| Some((str::strip_prefix(path, src)?, text));
        let files: Vec<(&str, &str)> = files.iter().map(|(path, text)| (&**path, &**text)).filter_map(inside).collect();
        let there: BTreeSet<&str> = files.iter().filter_map(|(path, _)| Some(path.split_once('/')?.0)).collect();
        let folders = listed(root);
        assert_eq!(folders.iter().copied().collect::<BTreeSet<_>>(), there, "the folders in `{src}`");
        assert_eq!(wrong_arrows(&folders, &files), [""; 0], "in `{src}`");
        packages += 1;
    }
    assert!(packages > 0, "no package lists its folders");
}

#[test]
fn an_arrow_to_a_folder_further_down_is_found() {
    let files = [
        ("lib.rs", "mod low; mod high;"),
        ("low/mod.rs", "mod a; use crate::low::a::A;\nuse super::high::B;\n#[cfg(test)] mod b { use crate::high::B; }"),
        ("low/a.rs", "use super::A;\nfn a() { crate::high::b() }\npub(in crate::low) fn b() {}"),
        ("low/tests.rs", "use crate::high::B;"),
        ("high/mod.rs", "use crate::low::A;\nuse crate::B;"),
        ("high/b.rs", "use super::super::low::A;\nuse super::super::elsewhere::A;"),
    ];
    assert_eq!(
        wrong_arrows(&["low", "high"], &files),
        [
            "low/mod.rs:2 must not see `high`",
            "low/a.rs:2 must not see `high`",
            "high/mod.rs:2 must not see `B`",
            "high/b.rs:2 must not see `elsewhere`",
        ]
    );
}
