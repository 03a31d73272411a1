//! What every program says when it fails, and how it ends.
//!
//! Owns the exit statuses, the form of an error on one line and on standard error, and which known words are similar to
//! one that is not known. Each program owns its errors, and which status each has.
#![forbid(unsafe_code)]

use std::borrow::Cow;
use std::cmp::Reverse;
use std::error::Error;
use std::io::{self, Write};
use std::process::ExitCode;

/// The most words that are proposed for one that is not known.
const MOST_SIMILAR: usize = 3;

/// The exit statuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Fine.
    Fine = 0,
    /// The answer is no: faults found, a balance unreachable, a bundle refused.
    No = 1,
    /// Bad usage, or a malformed file.
    Malformed = 2,
    /// A file, a device or the network could not be opened, read or written.
    Unreadable = 3,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Writes `error: ...` with its causes to standard error, and what to do about it below a blank line, both as
/// [`visible`] text.
pub fn print_error(error: &dyn Error, hint: Option<&str>) {
    let hint = hint.map(|hint| format!("\n\nhint: {}", visible(hint))).unwrap_or_default();
    // If standard error is closed there is no other place for it.
    let _ = writeln!(io::stderr(), "error: {}{hint}", visible(&chain(error)));
}

/// `text` with every control and bidirectional character as its number, `\u{1b}`: on a terminal, in a log and on a page
/// it has no effect, and it stays on its line.
pub fn visible(text: &str) -> Cow<'_, str> {
    if text.chars().all(is_visible) {
        return Cow::Borrowed(text);
    }
    text.chars().map(|c| if is_visible(c) { c.to_string() } else { c.escape_unicode().to_string() }).collect()
}

/// The question whether one of the `known` words was meant by `found`, which is none of them.
///
/// Those are proposed that the fewest edits make of it, three at most: a letter more, less or another one, or two that
/// change places; large and small letters are alike. `None` if more than a third of it would have to be edited, unless it
/// is the beginning of a word.
///
/// # Source
/// The optimal string alignment distance, by the crate that `clap` does the same with.
pub fn did_you_mean<'k>(found: &str, known: impl IntoIterator<Item = &'k str>) -> Option<String> {
    let lower = found.to_lowercase();
    let length = lower.chars().count();
    let most = (length / 3).max(1);
    let edits = |word: &str| {
        let word = word.to_lowercase();
        let near = word.chars().count().abs_diff(length) <= most;
        let edits = if near { strsim::osa_distance(&lower, &word) } else { usize::MAX };
        let begins = length > 1 && word.starts_with(&lower);
        (edits <= most || begins).then(|| edits.min(most))
    };
    let mut similar: Vec<(usize, &str)> =
        known.into_iter().filter_map(|word| edits(word).map(|edits| (edits, word))).collect();
    // Of equally many edits those come first that begin alike: beginnings are seldom mistyped.
    let alike = |word: &str| word.chars().zip(found.chars()).take_while(|(a, b)| a == b).count();
    similar.sort_by_key(|&(edits, word)| (edits, Reverse(alike(word)), word));
    similar.dedup();
    let fewest = similar.first()?.0;
    let best: Vec<String> = (similar.iter().take_while(|(edits, _)| *edits == fewest).take(MOST_SIMILAR))
        .map(|(_, word)| format!("`{word}`"))
        .collect();
    let (last, others) = best.split_last()?;
    let others = if others.is_empty() { String::new() } else { format!("{} or ", others.join(", ")) };
    Some(format!("did you mean {others}{last}?"))
}

/// Whether `c` is a visible character without other effects.
pub fn is_visible(c: char) -> bool {
    let turns_around = matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    !c.is_control() && !turns_around
}

/// The error and everything that caused it, on one line.
pub fn chain(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{Exit, chain, did_you_mean, visible};
    use std::io;

    #[test]
    fn an_error_comes_before_its_causes() {
        #[derive(Debug)]
        struct Outer(io::Error);
        impl std::fmt::Display for Outer {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("cannot read `a`")
            }
        }
        impl std::error::Error for Outer {
            fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
                Some(&self.0)
            }
        }
        assert_eq!(chain(&Outer(io::Error::other("no disk"))), "cannot read `a`: no disk");
    }

    #[test]
    fn what_is_visible_moves_nothing() {
        for (text, wanted) in [
            ("", ""),
            ("Grünspan, 200 %", "Grünspan, 200 %"),
            ("a\nb\r\u{1b}[2J\u{7f}\u{9b}", "a\\u{a}b\\u{d}\\u{1b}[2J\\u{7f}\\u{9b}"),
            ("a\u{202e}b\u{2028}", "a\\u{202e}b\\u{2028}"),
        ] {
            assert_eq!(visible(text), wanted);
        }
    }

    #[test]
    fn the_nearest_of_the_known_words_are_proposed() {
        let known = ["frames", "clip", "hash", "hours", "191.21054", "191.21064", "198.19616", "Orchid"];
        for (found, wanted) in [
            ("hour", Some("did you mean `hours`?")),
            ("farmes", Some("did you mean `frames`?")),
            ("CLIP", Some("did you mean `clip`?")),
            ("orchids", Some("did you mean `Orchid`?")),
            ("191.21055", Some("did you mean `191.21054`?")),
            ("191.21074", Some("did you mean `191.21054` or `191.21064`?")),
            ("198", Some("did you mean `198.19616`?")),
            ("colour", None),
            ("", None),
        ] {
            assert_eq!(did_you_mean(found, known).as_deref(), wanted, "{found}");
        }
        let many = ["ab", "ac", "ad", "ae", "ae"];
        assert_eq!(did_you_mean("ax", many).as_deref(), Some("did you mean `ab`, `ac` or `ad`?"));
    }

    #[test]
    fn the_statuses_are_those_of_the_contract() {
        assert_eq!([Exit::Fine, Exit::No, Exit::Malformed, Exit::Unreadable].map(|exit| exit as u8), [0, 1, 2, 3]);
    }
}
