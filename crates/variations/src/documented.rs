//! The claim that the page on variations lists them all.
//!
//! Owns its table, made from the code's.

use super::Kind;

/// The table of `docs/variations.md`.
fn table() -> String {
    let row = |kind: Kind| {
        let parameters: Vec<String> =
            kind.parameters().iter().map(|one| format!("`{}` {}", one.name, one.default)).collect();
        let limits: Vec<String> = kind.limits().iter().map(|(name, limit)| format!("`{name}` {limit}")).collect();
        format!("| `{}` | {} | {} | {} |\n", kind.name(), parameters.join(", "), limits.join("; "), kind.program())
    };
    Kind::ALL.into_iter().map(row).collect()
}

#[test]
fn the_page_lists_every_variation() {
    let page = include_str!("../../../docs/variations.md");
    let (_, rows) = page.split_once("|---|---|---|---|\n").unwrap();
    let listed = rows.split_once("\n\n").map_or(rows, |(rows, _)| rows);
    for (listed, expected) in listed.lines().zip(table().lines()) {
        assert_eq!(listed, expected);
    }
    assert_eq!(listed.trim_end(), table().trim_end());
}
