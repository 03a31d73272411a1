//! Excerpts of untrusted text for errors and logs.
//!
//! Limits their length, and escapes control characters for terminals, journals and pages.

/// The maximum length in characters.
const MAX_CHARS: usize = 80;

/// The start of `text`, with control and bidirectional characters as their numbers.
pub fn excerpt(text: &str) -> String {
    let mut told: String = text
        .chars()
        .take(MAX_CHARS)
        .map(|c| if is_shown(c) { c.to_string() } else { c.escape_unicode().to_string() })
        .collect();
    if text.chars().nth(MAX_CHARS).is_some() {
        told += "...";
    }
    told
}

/// Whether `c` is a visible character without other effects.
fn is_shown(c: char) -> bool {
    let turns_around = matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    !c.is_control() && !turns_around
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_told_is_short_and_moves_nothing() {
        for (text, wanted) in [
            ("", ""),
            ("Grünspan, 200 %", "Grünspan, 200 %"),
            ("a\nb\r\u{1b}[2J\u{7f}\u{9b}", "a\\u{a}b\\u{d}\\u{1b}[2J\\u{7f}\\u{9b}"),
            ("a\u{202e}b\u{2028}", "a\\u{202e}b\\u{2028}"),
        ] {
            assert_eq!(excerpt(text), wanted);
        }
        let long = "ä".repeat(80);
        assert_eq!((excerpt(&long), excerpt(&format!("{long}x"))), (long.clone(), format!("{long}...")));
        assert!(excerpt(&"\n".repeat(1_000)).len() < 500);
    }
}
