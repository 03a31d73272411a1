//! What an error, a log or people are told of a text that others wrote.
//!
//! Owns how much of it that is, and that a terminal, a journal or a page shows it as it stands. Never judges it.

/// How many characters of it are told.
const TOLD: usize = 80;

/// The beginning of `text`, what moves a cursor or turns a line around by its number.
pub fn told(text: &str) -> String {
    let mut told: String = text
        .chars()
        .take(TOLD)
        .map(|c| if is_shown(c) { c.to_string() } else { c.escape_unicode().to_string() })
        .collect();
    if text.chars().nth(TOLD).is_some() {
        told += "...";
    }
    told
}

/// Whether `c` is no more than what it looks like.
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
            assert_eq!(told(text), wanted);
        }
        let long = "ä".repeat(80);
        assert_eq!((told(&long), told(&format!("{long}x"))), (long.clone(), format!("{long}...")));
        assert!(told(&"\n".repeat(1_000)).len() < 500);
    }
}
