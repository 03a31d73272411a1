//! Excerpts of untrusted text for errors and logs.
//!
//! Limits their length. Control characters are escaped for terminals, journals and pages, as in every error.

use diagnostics::visible;

/// The maximum length in characters.
const MAX_CHARS: usize = 80;

/// The start of `text`, with control and bidirectional characters as their numbers.
pub fn excerpt(text: &str) -> String {
    let start = text.char_indices().nth(MAX_CHARS).map_or(text, |(end, _)| &text[..end]);
    let dots = if start.len() < text.len() { "..." } else { "" };
    format!("{}{dots}", visible(start))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_told_is_short_and_moves_nothing() {
        assert_eq!(excerpt("a\u{202e}b"), "a\\u{202e}b");
        let long = "ä".repeat(80);
        assert_eq!((excerpt(&long), excerpt(&format!("{long}x"))), (long.clone(), format!("{long}...")));
        assert!(excerpt(&"\n".repeat(1_000)).len() < 500);
    }
}
