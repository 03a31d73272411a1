//! Rules for the studio's page.
//!
//! Owns that its code is what its types say, how much of it there may be, and that it can make no element of a text.

use claims::studio::page::MOST_BYTES;
use std::process::Command;

use super::{files, root};

/// The folder of the page.
const PAGE: &str = "flock-tools/studio/page/";
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
    let project = root().join("flock-tools/studio/tsconfig.json");
    let checked = Command::new("tsc").arg("--project").arg(project).output();
    let checked = checked.expect("`tsc` is there: `make check` installs node-typescript");
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stdout));
}

/// Its files are sent as they are written. How much code they hold is counted as of any library: minified, without what
/// is for readers only, such as the types in comments.
#[test]
fn the_page_is_small_without_what_is_for_readers_only() {
    let all = [".js", ".css"].into_iter().flat_map(files).filter(|(path, _)| path.starts_with(PAGE));
    let sizes: Vec<(usize, String)> = all.map(|(path, _)| (minified(&path), path)).collect();
    assert!(sizes.len() > 20, "the page was read");
    let bytes: usize = sizes.iter().map(|(bytes, _)| bytes).sum();
    assert!(bytes <= MOST_BYTES, "{bytes} bytes, of at most {MOST_BYTES}: {sizes:?}");
}

/// Bytes of a script or a style sheet, minified.
fn minified(path: &str) -> usize {
    let minified = Command::new("esbuild").args(["--minify", "--log-level=warning"]).arg(root().join(path)).output();
    let minified = minified.expect("`esbuild` is there: `make check` installs it");
    let said = String::from_utf8_lossy(&minified.stderr);
    assert!(minified.status.success() && said.is_empty(), "`{path}`: {said}");
    minified.stdout.len()
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
