//! Within a package, at every depth, no folder stands in a circle, and folders with a table keep its order.
//!
//! Owns both claims, for code and tests, and the limit for the player's dependencies. A folder with `lib.rs` or `main.rs` is
//! the root of a package. The nodes of a folder are its subfolders, its single files, and its own file: `lib.rs`, `main.rs`,
//! `mod.rs`, or `x.rs` beside the folder `x`, which is one node with it as seen from outside. What a file uses of another is
//! an arrow in the innermost folder that holds both. An own file that declares modules or gives names to others uses
//! nothing; one that works with what a module has does, and a module uses it by naming what is defined there. Nodes that
//! reach each other are a circle: files may, a folder may not. In a table, a row is a folder or a single file; a file
//! without a row belongs to the own file, which may use all and which none may use.
//!
//! Not held: methods, whose files no path names; programs of one file, as in `examples`, and what they share. Packages are
//! in [`super::layers`], the paths in [`super::uses`].
//!
//! Start at [`arrows`], [`in_circles`] and [`wrong_arrows`].

use std::collections::{BTreeMap, BTreeSet};

use super::tokens::{positions, read};
use super::uses::{Modules, Place, place};

/// The head of the table.
const HEAD: &str = "//! | folder | what is there |";
/// The root of the player's own program.
const PLAYER: &str = "player/dreams-player/main.rs";
/// The most folders of the player, and arrows between them.
const MOST_FOLDERS: usize = 15;
const MOST_ARROWS: usize = 36;

/// A node of a folder; an empty name is the folder's own file.
type Node = String;

/// The arrows of every folder, by its place: from one node to another, and where they are.
type Arrows = BTreeMap<Place, BTreeMap<(Node, Node), BTreeSet<String>>>;

/// What the nodes of each folder use of each other.
fn arrows(modules: &Modules) -> Arrows {
    let mut arrows = Arrows::new();
    for found in modules.uses() {
        let depth = found.from.iter().zip(&found.to).take_while(|(from, to)| from == to).count();
        let node = |place: &[String]| place.get(depth).cloned().unwrap_or_default();
        let (from, to) = (node(found.from), node(&found.to));
        if from.is_empty() && found.is_export || to.is_empty() && found.is_module {
            continue;
        }
        arrows.entry(found.from[..depth].to_vec()).or_default().entry((from, to)).or_default().insert(found.at);
    }
    arrows
}

/// The arrows of circles that hold a folder.
fn in_circles(modules: &Modules) -> Vec<String> {
    let mut wrong = Vec::new();
    for (folder, arrows) in arrows(modules) {
        let is_folder =
            |node: &Node| !node.is_empty() && modules.is_folder(&[&*folder, std::slice::from_ref(node)].concat());
        let meet = |one: &Node, other: &Node| reached(one, &arrows).contains(other);
        for ((from, to), at) in arrows.iter().filter(|((from, to), _)| meet(to, from)) {
            if reached(from, &arrows).into_iter().any(|node| is_folder(node) && meet(node, from)) {
                let (first, more) = (at.first().map_or("", |at| at), at.len() - 1);
                wrong.push(format!("{first} and {more} more: {} uses {} in a circle", named(from), named(to)));
            }
        }
    }
    wrong
}

/// What a node uses, by way of others too.
fn reached<'a>(from: &'a Node, arrows: &'a BTreeMap<(Node, Node), BTreeSet<String>>) -> BTreeSet<&'a Node> {
    let (mut reached, mut left) = (BTreeSet::new(), vec![from]);
    while let Some(node) = left.pop() {
        let next = arrows.keys().filter(|(from, _)| from == node).map(|(_, to)| to);
        left.extend(next.filter(|to| reached.insert(*to)));
    }
    reached
}

/// The arrows of the folder at `place` to nodes further down in its table, or to none of it.
fn wrong_arrows(table: &[&str], place: &[String], modules: &Modules) -> Vec<String> {
    let row = |node: &Node| table.iter().position(|other| other == node);
    let arrows = arrows(modules).remove(place).unwrap_or_default();
    let wrong =
        arrows.iter().filter(|((from, to), _)| row(from).is_some() && (row(to).is_none() || row(to) > row(from)));
    wrong.flat_map(|((_, to), at)| at.iter().map(|at| format!("{at} must not see {}", named(to)))).collect()
}

fn named(node: &Node) -> String {
    if node.is_empty() { "the folder's own file".to_owned() } else { format!("`{node}`") }
}

/// The folders and files in the table of a folder's own file, in order, without `.rs`.
fn listed(own: &str) -> Vec<&str> {
    let table = own.lines().skip_while(|line| *line != HEAD).skip(2).take_while(|line| line.starts_with("//! | "));
    table.map(|row| super::quoted(row)[0].trim_end_matches(".rs")).collect()
}

/// The folders of roots with their files, by the paths from there.
fn packages(files: &[(String, String)]) -> BTreeMap<&str, Vec<(&str, &str)>> {
    let is_root = |(_, name): &(&str, &str)| ["lib.rs", "main.rs"].contains(name);
    let folders = files.iter().filter_map(|(path, _)| path.rsplit_once('/').filter(is_root));
    let roots: BTreeSet<_> = folders.map(|(folder, _)| folder).collect();
    let mut packages: BTreeMap<&str, Vec<_>> = BTreeMap::new();
    for (path, text) in files {
        let inner = path.rmatch_indices('/').map(|(at, _)| path.split_at(at)).find(|(above, _)| roots.contains(above));
        if let Some((root, inside)) = inner {
            packages.entry(root).or_default().push((&inside[1..], &**text));
        }
    }
    packages
}

#[test]
fn no_folder_stands_in_a_circle() {
    let files = super::files(".rs");
    let packages = packages(&files);
    assert!(packages.len() > 20, "only these packages were found: {:?}", packages.keys());
    let mut wrong = Vec::new();
    for (root, files) in packages {
        wrong.extend(in_circles(&Modules::new(&files)).into_iter().map(|arrow| format!("{root}/{arrow}")));
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn every_folder_sees_only_those_that_its_package_lists_above_it() {
    let files = super::files(".rs");
    let has_table = |text: &str| text.lines().any(|line| line == HEAD);
    let mut seen = BTreeSet::new();
    for (root, files) in packages(&files) {
        let modules = Modules::new(&files);
        for (path, own) in files.iter().filter(|(_, text)| has_table(text)) {
            let (table, place) = (listed(own), place(path));
            let within: BTreeSet<_> = modules.within(&place).collect();
            let missing: Vec<_> = table.iter().filter(|row| !within.contains(*row)).collect();
            let is_unlisted =
                |node: &&str| !table.contains(node) && modules.is_folder(&[&*place, &[(*node).to_owned()]].concat());
            let unlisted: Vec<_> = within.iter().copied().filter(is_unlisted).collect();
            assert!(
                missing.is_empty() && unlisted.is_empty(),
                "`{root}/{path}` lists {missing:?} and not {unlisted:?}"
            );
            assert_eq!(wrong_arrows(&table, &place, &modules), [""; 0], "beside `{root}/{path}`");
            seen.insert(format!("{root}/{path}"));
        }
    }
    assert!(seen.contains(PLAYER), "the player lists no folders");
}

#[test]
fn the_player_has_few_folders_and_few_arrows_between_them() {
    let (files, own) = (super::files(".rs"), super::read(PLAYER));
    let listed = listed(&own);
    // The root declares all of its folders.
    let mut seen: BTreeSet<_> = listed.iter().map(|to| ("dreams-player", *to)).collect();
    let mut folders = BTreeSet::new();
    for (root, files) in packages(&files) {
        let Some(program) = root.strip_prefix("player/") else { continue };
        let is_inner = PLAYER.starts_with(root);
        let folder = |node: &str| listed.iter().find(|row| is_inner && **row == node).map_or(program, |row| *row);
        for (path, text) in &files {
            let from = folder(place(path).first().map_or("", |node| node));
            folders.insert(from);
            seen.extend(positions(&read(path, text), &["player", ":", ":"]).map(|_| (from, "src")));
        }
        let inner = arrows(&Modules::new(&files)).remove(&[][..]).unwrap_or_default();
        seen.extend(inner.keys().map(|(from, to)| (folder(from), folder(to))));
    }
    let (folders, arrows) = (folders.len(), seen.iter().filter(|(from, to)| from != to).count());
    println!("{folders} folders, {arrows} arrows");
    assert!(
        (10..=MOST_FOLDERS).contains(&folders) && (20..=MOST_ARROWS).contains(&arrows),
        "{folders} folders, {arrows} arrows"
    );
}

#[test]
fn an_arrow_to_a_folder_further_down_is_found() {
    let files = [
        ("lib.rs", "mod low; mod high; use high::A; pub use high::Known;"),
        (
            "low/mod.rs",
            "mod a; use crate::low::a::A;\nuse super::high::B;\n#[cfg(test)] mod b { use crate::high::B; use super::C; }",
        ),
        (
            "low/a.rs",
            "use super::A;\nfn a() { crate::high::b(\"crate::high\") } // crate::high\npub(in crate::low) fn b() {}",
        ),
        ("low/tests.rs", "use crate::{file::A, high::{B, low}};\nuse crate::Known;"),
        ("file.rs", "use crate::high::B;\nuse super::low::A;"),
        ("high/mod.rs", "use crate::low::A;\nuse crate::B;"),
        ("high/b.rs", "use super::super::low::A;\nuse super::super::elsewhere;"),
        ("elsewhere.rs", ""),
    ];
    assert_eq!(
        wrong_arrows(&["low", "file", "high"], &[], &Modules::new(&files)),
        [
            "file.rs:1 must not see `high`",
            "high/mod.rs:2 must not see the folder's own file",
            "high/b.rs:2 must not see `elsewhere`",
            "low/tests.rs:1 must not see `file`",
            "low/a.rs:2 must not see `high`",
            "low/mod.rs:2 must not see `high`",
            "low/mod.rs:3 must not see `high`",
            "low/tests.rs:1 must not see `high`",
            "low/tests.rs:2 must not see `high`",
        ]
    );
}

#[test]
fn a_circle_with_a_folder_is_found_at_any_depth_and_one_of_files_is_none() {
    let circles = |files: &[(&str, &str)]| in_circles(&Modules::new(files));
    // A folder and a file, three levels down; through a file between them.
    let deep = [
        ("lib.rs", "mod a; pub use a::A;"),
        ("a/mod.rs", "mod b; pub use b::A;"),
        ("a/b/mod.rs", "mod c; mod d; mod e; pub use c::A;"),
        ("a/b/c/mod.rs", "mod f;"),
        ("a/b/c/f.rs", "use crate::a::b::d::D;\nfn f(_: super::super::d::D) {}"),
        ("a/b/d.rs", "use super::e;\nfn d() { e::e() }"),
        ("a/b/e.rs", "#[cfg(test)] mod tests { use super::super::c; fn e() { c::c() } }"),
        ("a/b/g.rs", "use super::c;"),
    ];
    assert_eq!(
        circles(&deep),
        [
            "a/b/c/f.rs:1 and 1 more: `c` uses `d` in a circle",
            "a/b/d.rs:1 and 1 more: `d` uses `e` in a circle",
            "a/b/e.rs:1 and 0 more: `e` uses `c` in a circle",
        ]
    );
    // A folder and what is defined in the file around it, by whatever name it comes; `c.rs` and `c/` are one node.
    let knot =
        |own, inner| circles(&[("lib.rs", own), ("c.rs", "mod d;"), ("c/d.rs", inner), ("e.rs", "use crate::B;")]);
    let found = [
        "lib.rs:1 and 0 more: the folder's own file uses `c` in a circle",
        "c/d.rs:1 and 0 more: `c` uses the folder's own file in a circle",
    ];
    assert_eq!(knot("mod c; mod e; use c::A; struct B;", "use crate::B;"), found);
    assert_eq!(knot("mod c; mod e; fn a() { c::a() } struct B;", "fn d(_: super::super::B) {}"), found);
    // One that is not: names are only passed on, or come from elsewhere, or the folder is one that others use.
    let none = [""; 0];
    assert_eq!(knot("mod c; mod e; pub use c::A; pub(crate) use c::C; struct B;", "use crate::B;"), none);
    assert_eq!(knot("mod c; mod e; use c::A; use std::B;", "use crate::B;"), none);
    assert_eq!(knot("mod c; mod e; use e::A; struct B;", "use crate::{B, C};"), none);
    // Files may, and within one file nothing is used of others.
    let files = [
        ("main.rs", "mod a; mod b { mod c; } use a::A; struct D;"),
        ("a.rs", "use crate::{D, b::c::C}; mod tests { use super::A; }"),
        ("b/c.rs", "use super::super::b::c::C;"),
        ("b/d.rs", "use super::c::C;"),
    ];
    assert_eq!(circles(&files), none);
}
