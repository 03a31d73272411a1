//! Within a package, a folder depends only on folders above it in the table of the package's root file.
//!
//! Owns the claim for every package whose `lib.rs` or `main.rs` has such a table, for code and tests, and the limit for
//! the player's dependencies. A row is a folder or a single file; a file without a row belongs to the root, which may
//! use all and which none may use. Packages are in [`super::layers`].
//!
//! Start at [`wrong_arrows`].

use std::collections::BTreeSet;

use super::tokens::{Token, positions, read};

/// The head of the table.
const HEAD: &str = "//! | folder | what is there |";
/// The root of the player's own program.
const PLAYER: &str = "player/dreams-player/main.rs";
/// The most folders of the player, and arrows between them.
const MOST_FOLDERS: usize = 15;
const MOST_ARROWS: usize = 35;

/// The folders and files in the table of a root, in order, without `.rs`.
fn listed(root: &str) -> Vec<&str> {
    let table = root.lines().skip_while(|line| *line != HEAD).skip(2).take_while(|line| line.starts_with("//! | "));
    table.map(|row| super::quoted(row)[0].trim_end_matches(".rs")).collect()
}

/// The folder, or single file, that the file at `path` belongs to; `path` is relative to the root's folder.
fn folder(path: &str) -> &str {
    path.split('/').next().unwrap_or_default().trim_end_matches(".rs")
}

/// What the file at `path` uses of its package: the first part of each path, and its line.
fn seen<'t>(path: &str, tokens: &'t [Token]) -> Vec<(&'t str, usize)> {
    let depth = path.trim_end_matches("/mod.rs").split('/').count();
    let is = |at: usize, text: &str| tokens.get(at).is_some_and(|token| token.text == text);
    let leads_on = |at: usize| is(at + 1, ":") && is(at + 2, ":");
    let mut seen = Vec::new();
    // A test's `super` leads to its own file.
    let starts = |at: usize| is(at, "crate") || is(at, "super") && !tokens[at].in_tests;
    for at in (0..tokens.len()).filter(|at| starts(*at) && leads_on(*at) && (*at == 0 || !is(at - 1, ":"))) {
        let (mut at, mut climbed) = (at, if is(at, "crate") { depth } else { 1 });
        while is(at + 3, "super") && leads_on(at + 3) {
            (at, climbed) = (at + 3, climbed + 1);
        }
        if climbed == depth {
            let group = tokens[at + 4..].iter().take_while(|token| token.depth > tokens[at].depth);
            let many = group
                .zip(&tokens[at + 3..])
                .filter(|(name, before)| name.depth == tokens[at].depth + 1 && matches!(&*before.text, "{" | ","));
            let names = match &*tokens[at + 3].text {
                "{" => many.map(|(name, _)| name).collect(),
                _ => vec![&tokens[at + 3]],
            };
            seen.extend(names.into_iter().map(|name| (&*name.text, tokens[at].line)));
        }
    }
    seen
}

/// The dependencies on folders further down in the table, or on none of it; `files` are by their paths from the root's
/// folder.
fn wrong_arrows(folders: &[&str], files: &[(&str, &str)]) -> Vec<String> {
    let place = |folder: &str| folders.iter().position(|other| *other == folder);
    let mut wrong = Vec::new();
    for (path, text) in files.iter().filter(|(path, _)| place(folder(path)).is_some()) {
        for (to, line) in seen(path, &read(path, text)).into_iter().filter(|(to, _)| *to != folder(path)) {
            if place(to).is_none() || place(to) > place(folder(path)) {
                wrong.push(format!("{path}:{line} must not see `{to}`"));
            }
        }
    }
    wrong
}

/// The files in the folder of the root at `path`, by their paths from there.
fn beside<'t>(path: &str, files: &'t [(String, String)]) -> Vec<(&'t str, &'t str)> {
    let (root, _) = path.rsplit_once('/').unwrap();
    let inside = |path: &'t str| path.strip_prefix(root)?.strip_prefix('/');
    files.iter().filter_map(|(path, text)| Some((inside(path)?, &**text))).collect()
}

#[test]
fn every_folder_sees_only_those_that_its_package_lists_above_it() {
    let files = super::files(".rs");
    let has_table = |(path, text): &&(String, String)| {
        (path.ends_with("/lib.rs") || path.ends_with("/main.rs")) && text.lines().any(|line| line == HEAD)
    };
    let roots: Vec<_> = files.iter().filter(has_table).collect();
    assert!(roots.iter().any(|(path, _)| path == PLAYER), "the player lists no folders");
    for (path, root) in roots {
        let (folders, files) = (listed(root), beside(path, &files));
        let is_there = |name: &str| files.iter().any(|(path, _)| folder(path) == name);
        let missing: Vec<_> = folders.iter().filter(|name| !is_there(name)).collect();
        let unlisted: Vec<_> =
            files.iter().filter(|(path, _)| path.contains('/') && !folders.contains(&folder(path))).collect();
        assert!(missing.is_empty() && unlisted.is_empty(), "`{path}` lists {missing:?} and not {unlisted:?}");
        assert_eq!(wrong_arrows(&folders, &files), [""; 0], "beside `{path}`");
    }
}

#[test]
fn the_player_has_few_folders_and_few_arrows_between_them() {
    let files = super::files(".rs");
    let root = super::read(PLAYER);
    let listed = listed(&root);
    // The root declares all of its folders.
    let mut arrows: BTreeSet<_> = listed.iter().map(|to| ("dreams-player", *to)).collect();
    let mut folders = BTreeSet::new();
    for (path, text) in beside("player/build.rs", &files) {
        let Some((program, inside)) = path.split_once('/') else { continue };
        let tokens = read(path, text);
        let is_inner = program == "dreams-player";
        let from = if is_inner && listed.contains(&folder(inside)) { folder(inside) } else { program };
        folders.insert(from);
        let shared = positions(&tokens, &["player", ":", ":"]).map(|_| "src");
        let inner = seen(inside, &tokens).into_iter().map(|(to, _)| to).filter(|to| is_inner && listed.contains(to));
        for to in shared.chain(inner).filter(|to| *to != from) {
            let known = listed.iter().find(|name| **name == to).map_or("src", |name| *name);
            arrows.insert((from, known));
        }
    }
    let (folders, arrows) = (folders.len(), arrows.len());
    println!("{folders} folders, {arrows} arrows");
    assert!(
        (10..=MOST_FOLDERS).contains(&folders) && (20..=MOST_ARROWS).contains(&arrows),
        "{folders} folders, {arrows} arrows"
    );
}

#[test]
fn an_arrow_to_a_folder_further_down_is_found() {
    let files = [
        ("lib.rs", "mod low; mod high; use high::A;"),
        (
            "low/mod.rs",
            "mod a; use crate::low::a::A;\nuse super::high::B;\n#[cfg(test)] mod b { use crate::high::B; use super::C; }",
        ),
        (
            "low/a.rs",
            "use super::A;\nfn a() { crate::high::b(\"crate::high\") } // crate::high\npub(in crate::low) fn b() {}",
        ),
        ("low/tests.rs", "use crate::{file::A, high::{B, low}};"),
        ("file.rs", "use crate::high::B;\nuse super::low::A;"),
        ("high/mod.rs", "use crate::low::A;\nuse crate::B;"),
        ("high/b.rs", "use super::super::low::A;\nuse super::super::elsewhere::A;"),
    ];
    assert_eq!(
        wrong_arrows(&["low", "file", "high"], &files),
        [
            "low/mod.rs:2 must not see `high`",
            "low/mod.rs:3 must not see `high`",
            "low/a.rs:2 must not see `high`",
            "low/tests.rs:1 must not see `file`",
            "low/tests.rs:1 must not see `high`",
            "file.rs:1 must not see `high`",
            "high/mod.rs:2 must not see `B`",
            "high/b.rs:2 must not see `elsewhere`",
        ]
    );
}
