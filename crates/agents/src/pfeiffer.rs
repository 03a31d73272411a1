//! Pfeiffer's string: what an agent is made from.
//!
//! Owns its parameters, their defaults and their limits. Any text is read: what is missing or illegal takes the default.
//! Never walks it: `turtle.rs` does.
//!
//! Start at [`Pfeiffer::read`].
//!
//! # Source
//! W. B. Langdon, *Global Distributed Evolution of L-Systems Fractals* (Pfeiffer, 2004), section 3.1. Rules that evolve,
//! more than one of them, brackets, `w`, `c` and `sw` are ours.

/// Most segments of a string that uses nothing of ours, as published.
pub const MOST_PUBLISHED: usize = 2000;
/// Most segments of any string.
pub const MOST_SEGMENTS: usize = 20_000;
/// Most rounds of expansion.
pub const MOST_ROUNDS: u32 = 64;
/// Pfeiffer's own agent, Koch's snowflake.
pub const DEFAULT: &str = "v=60&str=F++F++F&it=2&sc=5&rules=('F','F-F++F-F')";

/// The parameters of a string.
pub const PARAMETERS: [&str; 8] = ["v", "str", "it", "sc", "rules", "w", "c", "sw"];

/// What a character does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Act {
    /// `F`: one step is drawn.
    Draw,
    /// `+`: turns clockwise.
    Clockwise,
    /// `-`: turns the other way.
    Back,
    /// `[`: remembers where it is.
    Open,
    /// `]`: returns there.
    Close,
    /// Any other character.
    Nothing,
}

/// A character, and the number of the list that replaces it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Letter {
    pub(crate) act: Act,
    pub(crate) becomes: Option<usize>,
}

/// An agent's parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Pfeiffer {
    /// `v`: degrees of a turn, -3600 to 3600.
    pub v: f64,
    /// `it`: rounds of expansion, up to [`MOST_ROUNDS`].
    pub it: u32,
    /// `sc`: a step in fifths of a pixel, above 0 up to 1000.
    pub sc: f64,
    /// `w`: how wide lines are, 0.2 to 5; 1 is usual.
    pub w: f64,
    /// `c`: which colour of the palette, 0 to 255; the agent's own number if there is none.
    pub c: Option<u32>,
    /// `sw`: degrees that a turn sways, -90 to 90.
    pub sw: f64,
    /// The most segments that are drawn.
    pub most: usize,
    /// What is walked: `str`, then what each rule puts in.
    pub(crate) lists: Vec<Vec<Letter>>,
}

impl Pfeiffer {
    /// Reads a string. Later entries win over earlier ones.
    pub fn read(text: &str) -> Pfeiffer {
        let text: String = text.chars().filter(|letter| !letter.is_whitespace()).collect();
        let (mut start, mut rules) = ("F++F++F", vec![('F', "F-F++F-F")]);
        let (mut v, mut it, mut sc, mut w, mut c, mut sw) = (60.0, 2, 5.0, None, None, None);
        for (key, value) in text.split('&').filter_map(|entry| entry.split_once('=')) {
            match key {
                "v" => v = number(value, -3600.0, 3600.0).unwrap_or(60.0),
                "str" => start = if value.is_empty() { "F++F++F" } else { value },
                "it" => it = value.parse().ok().filter(|it| *it <= MOST_ROUNDS).unwrap_or(2),
                "sc" => sc = number(value, 1e-3, 1000.0).unwrap_or(5.0),
                "rules" => rules = pairs(value).unwrap_or_else(|| vec![('F', "F-F++F-F")]),
                "w" => w = number(value, 0.2, 5.0),
                "c" => c = value.parse().ok().filter(|c| *c < 256),
                "sw" => sw = number(value, -90.0, 90.0),
                _ => {}
            }
        }
        let has_brackets = start.contains(['[', ']']);
        let extends = has_brackets || w.is_some() || c.is_some() || sw.is_some() || rules != [('F', "F-F++F-F")];
        let letters = |text: &str| text.chars().map(|letter| self::letter(letter, &rules)).collect();
        let lists = std::iter::once(start).chain(rules.iter().map(|(_, text)| *text)).map(letters).collect();
        let most = if extends { MOST_SEGMENTS } else { MOST_PUBLISHED };
        Pfeiffer { v, it, sc, w: w.unwrap_or(1.0), c, sw: sw.unwrap_or(0.0), most, lists }
    }
}

fn number(text: &str, least: f64, most: f64) -> Option<f64> {
    text.parse().ok().filter(|number| (least..=most).contains(number))
}

/// `('F','F-F'),('X','FX')`: characters, and what replaces them.
fn pairs(text: &str) -> Option<Vec<(char, &str)>> {
    let mut pairs = Vec::new();
    for part in text.strip_prefix("('")?.strip_suffix("')")?.split("'),('") {
        let (from, to) = part.split_once("','")?;
        let mut letters = from.chars();
        let (Some(from), None) = (letters.next(), letters.next()) else { return None };
        pairs.push((from, to));
    }
    Some(pairs)
}

fn letter(letter: char, rules: &[(char, &str)]) -> Letter {
    let act = match letter {
        'F' => Act::Draw,
        '+' => Act::Clockwise,
        '-' => Act::Back,
        '[' => Act::Open,
        ']' => Act::Close,
        _ => Act::Nothing,
    };
    // The first list is `str`; of two rules for a character the later one counts.
    Letter { act, becomes: rules.iter().rposition(|(from, _)| *from == letter).map(|number| number + 1) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_or_illegal_takes_the_default_and_later_entries_win() {
        let default = Pfeiffer::read(DEFAULT);
        let same = [
            "",
            "&&=&x=1&=5",
            "v=&str=&it=-1&sc=0&rules=",
            "v=nan&it=2.5&sc=inf&rules=('F')",
            "v=12&v=60&it=9&it=2&rules=('F','FF')&rules=('FX','F')",
            " v = 6 0 \n& s t r = F + + F ++F",
        ];
        for text in same {
            assert_eq!(Pfeiffer::read(text), default, "{text}");
        }
        let own = Pfeiffer::read("v=-90.5&it=0&sc=2.5&w=2&c=3&sw=-4&rules=('X','F'),('X','FX')");
        assert_eq!((own.v, own.it, own.sc, own.w, own.c, own.sw), (-90.5, 0, 2.5, 2.0, Some(3), -4.0));
        assert_eq!((own.lists.len(), own.lists[2].len(), own.most, default.most), (3, 2, 20_000, 2000));
    }

    #[test]
    fn every_parameter_of_the_list_is_read() {
        let values = ["12", "FX", "3", "7", "('F','FF')", "2", "4", "9"];
        for (parameter, value) in PARAMETERS.iter().zip(values) {
            assert_ne!(Pfeiffer::read(&format!("{parameter}={value}")), Pfeiffer::read(DEFAULT), "{parameter}");
        }
    }
}
