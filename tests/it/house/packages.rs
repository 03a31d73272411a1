//! How much of a package the compiler has to do at once.
//!
//! Owns the size of packages, and that a library's tests are linked once. Which package sees which is in [`super::layers`].
//!
//! Start at [`lines`].

use std::collections::BTreeMap;

use cargo_metadata::Package;

use super::tokens::{Token, read};

/// The most lines of a package without its tests: two of them compile side by side on two cores.
const MOST_LINES: usize = 14_000;

/// The lines of a file that are in no item under `#[cfg(test)]`.
fn outside_tests(text: &str, tokens: &[Token]) -> usize {
    let runs = tokens.chunk_by(|one, next| one.in_tests == next.in_tests).filter(|run| run[0].in_tests);
    text.lines().count() - runs.map(|run| run[run.len() - 1].line - run[0].line + 1).sum::<usize>()
}

/// The modules that the file at `path` declares under `#[cfg(test)]`, by the paths of their files without `.rs`.
fn modules_of_tests(path: &str, tokens: &[Token]) -> Vec<String> {
    let (folder, name) = path.rsplit_once('/').unwrap_or(("", path));
    let own = match name {
        "lib.rs" | "main.rs" | "mod.rs" => folder.to_owned(),
        _ => path.trim_end_matches(".rs").to_owned(),
    };
    let declared =
        tokens.windows(3).filter(|three| three[0].in_tests && three[0].text == "mod" && three[2].text == ";");
    declared.map(|three| format!("{own}/{}", three[1].text)).collect()
}

/// How many lines of Rust a package has without its tests; `files` are its own, by their paths from its folder.
fn lines(files: &[(&str, &str)]) -> usize {
    let aside = ["tests/", "benches/", "examples/", "fuzz/"];
    let shipped = files.iter().filter(|(path, _)| !aside.iter().any(|folder| path.starts_with(folder)));
    let files: Vec<_> = shipped.map(|(path, text)| (*path, *text, read(path, text))).collect();
    let apart: Vec<String> = files.iter().flat_map(|(path, _, tokens)| modules_of_tests(path, tokens)).collect();
    let is_test = |path: &str| apart.iter().any(|at| path == format!("{at}.rs") || path.starts_with(&format!("{at}/")));
    files.iter().filter(|(path, ..)| !is_test(path)).map(|(_, text, tokens)| outside_tests(text, tokens)).sum()
}

/// Every package of ours but the claims, which are tests, by its folder, with its lines.
fn sizes() -> BTreeMap<String, usize> {
    let files = super::files(".rs");
    let packages = super::metadata(false).packages;
    let folders: Vec<String> = packages.iter().map(folder).filter(|at| at != "tests").collect();
    let owner = |path: &str| folders.iter().filter(|at| path.starts_with(&format!("{at}/"))).max_by_key(|at| at.len());
    let of = |package: &String| -> Vec<(&str, &str)> {
        let own = files.iter().filter(|(path, _)| owner(path) == Some(package));
        own.map(|(path, text)| (&path[package.len() + 1..], &**text)).collect()
    };
    folders.iter().map(|package| (package.clone(), lines(&of(package)))).collect()
}

/// The folder of a package, from the root of the repository.
fn folder(package: &Package) -> String {
    let folder = package.manifest_path.parent().expect("a manifest lies in a folder");
    folder.strip_prefix(super::root()).expect("our packages lie in the repository").to_string()
}

#[test]
fn no_package_is_more_than_a_compiler_should_have_at_once() {
    let sizes = sizes();
    println!("{sizes:#?}");
    assert!(sizes.len() > 10 && sizes["crates/flame"] > 2000, "{sizes:?}");
    let large: Vec<_> = sizes.iter().filter(|(_, lines)| **lines > MOST_LINES).collect();
    assert!(large.is_empty(), "more than {MOST_LINES} lines without tests: {large:?}");
}

#[test]
fn the_style_names_the_most_lines_of_a_package() {
    let style = super::read("STYLE.md").replace(',', "");
    assert_eq!(super::facts::number_after(&style, "A package has at most "), MOST_LINES);
}

#[test]
fn tests_do_not_count_as_lines_of_their_package() {
    let files = [
        ("src/lib.rs", "mod a;\n#[cfg(test)]\nmod proofs;\nfn a() {}\n#[cfg(test)]\nmod tests {\n    fn b() {}\n}\n"),
        ("src/proofs.rs", "fn c() {}\n"),
        ("src/proofs/more.rs", "fn c() {}\n"),
        ("src/a.rs", "// One.\n#[cfg(test)]\nmod tests;\n"),
        ("src/a/tests.rs", "fn d() {}\n"),
        ("tests/it/main.rs", "fn e() {}\n"),
    ];
    assert_eq!(lines(&files[..1]), 2);
    assert_eq!(lines(&files), 3);
}

/// The executables of tests that are not named `it`, each with its package.
fn apart(packages: &[Package]) -> Vec<String> {
    let targets = packages.iter().flat_map(|package| package.targets.iter().map(move |target| (&package.name, target)));
    let apart = targets.filter(|(_, target)| target.is_test() && target.name != "it");
    apart.map(|(package, target)| format!("{package}: {}", target.name)).collect()
}

#[test]
fn the_tests_of_a_library_are_linked_once() {
    let mut packages = super::metadata(false).packages;
    packages.retain(|package| package.manifest_path.starts_with(super::root().join("crates")));
    assert!(packages.len() > 10, "only {} libraries were read", packages.len());
    assert_eq!(apart(&packages), [""; 0], "each executable costs a link: make it a module of `tests/it/main.rs`");
}
