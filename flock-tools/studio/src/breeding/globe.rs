//! The snow globe, live: strings of agents, and the next generation of those that were touched.
//!
//! Owns how a generation is made: children of the chosen, some of them crossed with strangers, as in Langdon's Pfeiffer.
//! Never draws: the page does.
//!
//! Start at [`next`].

use agents::{Agents, Globe, MOST_AGENTS, crossover};
use species::{Breed, Rng};

/// The part of births that have a stranger as the second parent.
const STRANGERS: f64 = 0.25;
/// Candidates for each child; most crossings of strings draw nothing.
const TRIES: usize = 30;
/// What begins the list of strings in a genome, and what may stand above it.
const FLOCK: &str = "flock = [";
const PLAIN: &str = "[agents]\nversion = 1\nbackground = [\"#101020\", \"#202040\"]\npalette = [\"#ffffff\"]\ndrift = 1\n\
                     glow = 1.0\ndust = 20\n";

/// `count` strings by chance, each of which draws something.
pub(crate) fn strangers(count: usize, seed: u64) -> Vec<String> {
    let mut rng = Rng::stream(seed, 0);
    let mut found: Vec<String> = Vec::new();
    while found.len() < count.min(MOST_AGENTS) {
        let genome = Agents.random(&mut rng);
        let Some(globe) = genome.as_any().downcast_ref::<Globe>() else { break };
        for string in globe.flock() {
            if found.len() < count && !found.contains(string) {
                found.push(string.clone());
            }
        }
    }
    found
}

/// The generation after the strings `chosen`: `count` children of them, none twice. Without chosen ones all are strangers.
pub(crate) fn next(chosen: &[String], count: usize, seed: u64) -> Vec<String> {
    let chosen: Vec<&String> = chosen.iter().filter(|string| is_drawn(string)).collect();
    if chosen.is_empty() {
        return strangers(count, seed);
    }
    let mut rng = Rng::stream(seed, 1);
    let strangers = strangers(count, seed);
    let mut found: Vec<String> = Vec::new();
    let pick = |rng: &mut Rng, of: usize| ((rng.unit() * of as f64) as usize).min(of - 1);
    for stranger in &strangers {
        let child = (0..TRIES).find_map(|_| {
            let first = chosen[pick(&mut rng, chosen.len())];
            let second = if rng.unit() < STRANGERS { stranger } else { chosen[pick(&mut rng, chosen.len())] };
            let child = crossover(first, second, &mut rng);
            (!found.contains(&child) && is_drawn(&child)).then_some(child)
        });
        found.push(child.unwrap_or_else(|| stranger.clone()));
    }
    found
}

/// The text of a genome of these strings, with the looks of a globe by chance.
/// Errors: What is wrong with the strings.
pub(crate) fn genome(strings: &[String], seed: u64) -> Result<String, String> {
    let random = Agents.random(&mut Rng::stream(seed, 2)).text();
    of_strings(random.split(FLOCK).next().unwrap_or_default(), strings)
}

/// Whether an agent of this string is seen.
fn is_drawn(string: &str) -> bool {
    of_strings(PLAIN, &[string.to_owned()]).is_ok()
}

/// The text of a genome with these strings below `head`, if it is one.
fn of_strings(head: &str, strings: &[String]) -> Result<String, String> {
    let quoted = strings.iter().map(|string| format!("  {},\n", toml::Value::String(string.clone())));
    let text = format!("{head}{FLOCK}\n{}]\n", quoted.collect::<String>());
    Globe::parse(&text).map(|_| text).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_generation_is_of_strings_that_are_drawn_and_none_comes_twice() {
        let first = strangers(25, 4);
        let next = next(&first[..3], 25, 5);
        for generation in [&first, &next] {
            assert_eq!(generation.len(), 25);
            assert!(generation.iter().all(|string| is_drawn(string)), "{generation:?}");
            let mut distinct = generation.clone();
            distinct.sort();
            distinct.dedup();
            assert_eq!(distinct.len(), 25);
        }
        assert_ne!(first, next);
    }

    #[test]
    fn whatever_a_page_sends_the_next_generation_is_of_agents_that_are_drawn() {
        let sent = ["\"]\nflock = [".to_owned(), "v=60&str=".to_owned(), "x".repeat(100_000)];
        let next = next(&sent, 25, 6);
        assert!(next.len() == 25 && next.iter().all(|string| is_drawn(string)), "{next:?}");
        assert!(genome(&sent, 1).is_err());
        assert!(genome(&strangers(5, 1), 1).is_ok());
    }
}
