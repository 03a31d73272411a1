//! Rules for the studio's page.
//!
//! Owns that its code is what its types say, and that it can make no element of a text.

use std::process::Command;

use super::{files, root};

/// The folder of the page.
const PAGE: &str = "crates/studio/page/";
/// Ways to make elements, code or styles of a text, and to ask somebody else than our own program.
const FORBIDDEN: [&str; 12] = [
    "innerHTML",
    "outerHTML",
    "insertAdjacentHTML",
    "document.write",
    "DOMParser",
    "eval(",
    "new Function",
    "cssText",
    "setAttribute('style'",
    " style=\"",
    "javascript:",
    "//www",
];

#[test]
fn the_page_is_what_its_types_say() {
    let project = root().join("crates/studio/tsconfig.json");
    let checked = Command::new("tsc").arg("--project").arg(project).output();
    let checked = checked.expect("`tsc` is there: `make check` installs node-typescript");
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stdout));
}

#[test]
fn the_page_makes_no_element_of_a_text_and_names_no_other_server() {
    let code = [".js", ".css", ".html"].into_iter().flat_map(files).filter(|(path, _)| path.starts_with(PAGE));
    let mut seen = 0;
    for (path, text) in code {
        seen += 1;
        // The name of SVG's namespace is not loaded.
        let text = text.replace("http://www.w3.org/2000/svg", "");
        for word in FORBIDDEN.into_iter().chain(["://"]) {
            assert!(!text.contains(word), "`{path}` has `{word}`");
        }
        for (_, from) in text.lines().filter_map(|line| line.split_once(" from '")) {
            assert!(from.starts_with("./"), "`{path}`: what is imported lies beside it: {from}");
        }
    }
    assert!(seen > 20, "the page was read");
}
