//! Texts that are damaged.
//!
//! Owns what is done to them: the same on every machine. Never reads them.

use species::Rng;

const SNIPPETS: [&str; 18] =
    ["(", ")", " ", "x", "#", "\"", "-", "1e9", "nan", "0", "=", "&", ";", "\\", "\n", "\0", "\u{e9}", "9999999999"];

/// `text` with up to three things done to it: a part is deleted, doubled, replaced, or exchanged for one of `other`.
pub(crate) fn damaged(text: &str, other: &str, seed: u64) -> String {
    let mut rng = Rng::stream(seed, 33);
    let mut below = |count: usize| ((rng.unit() * count as f64) as usize).min(count.saturating_sub(1));
    let other: Vec<char> = other.chars().collect();
    let mut chars: Vec<char> = text.chars().collect();
    for _ in 0..=below(3) {
        let from = below(chars.len());
        let to = (from + below(8)).min(chars.len());
        let part: Vec<char> = match below(4) {
            0 => Vec::new(),
            1 => chars[from..to].repeat(2),
            2 => other[from.min(other.len())..to.min(other.len())].to_vec(),
            _ => SNIPPETS[below(SNIPPETS.len())].chars().collect(),
        };
        chars.splice(from..to, part);
        if chars.is_empty() {
            chars.push('(');
        }
    }
    chars.into_iter().collect()
}
