//! Mutation and mating.
//!
//! Owns what is done to strings and to globes. Children can be drawn and may be shown: what may not is tried again. Never
//! says which of them are good.
//!
//! Start at [`crossover`], [`mutated`] and [`crossed`].
//!
//! # Source
//! W. B. Langdon, *Global Distributed Evolution of L-Systems Fractals* (Pfeiffer, 2004), section 3.3, for the crossover of
//! strings. All else is ours.

use species::{Operator, Rng};

pub(crate) use crate::random::random;

use crate::colour::Colour;
use crate::globe::{Globe, MOST_COLOURS, MOST_DUST};
use crate::random::{AGENTS, fill, of_luma, shape, tenths};
use crate::strings::{Family, string};

/// Attempts at a child.
const ATTEMPTS: usize = 30;
/// How likely each agent is changed in a mutation of usual strength, and how likely everything else.
const CHANGES: f64 = 0.2;

/// A child of two strings: aligned at their starts, the part of the first between two cuts is replaced by the second's,
/// which half of the time is a character longer or shorter; a second that ends before gives less.
pub fn crossover(first: &str, second: &str, rng: &mut Rng) -> String {
    let [first, second] = [first, second].map(|text| text.chars().collect::<Vec<char>>());
    let (one, other) = (rng.below(first.len() + 1), rng.below(first.len() + 1));
    let (from, to) = (one.min(other), one.max(other));
    let end = match rng.below(4) {
        0 => to + 1,
        1 => to.saturating_sub(1),
        _ => to,
    };
    let end = end.min(second.len());
    let middle = second.get(from.min(end)..end).unwrap_or_default();
    first[..from].iter().chain(middle).chain(&first[to..]).collect()
}

const STRINGS: &str = "strings";
const LEAVE: &str = "leave";
const COME: &str = "come";
const COLOURS: &str = "colours";
const DRIFT: &str = "drift";
const GLOW: &str = "glow";
pub(crate) const CROSSED: &str = "crossover";

/// All operators.
pub(crate) const OPERATORS: &[Operator] = &[
    Operator::mutation(
        STRINGS,
        &[],
        "changes the strings of some agents: a parameter, letters of a rule, or everything",
    ),
    Operator::mutation(LEAVE, &[], "takes an agent out"),
    Operator::mutation(COME, &[], "takes in an agent at random"),
    Operator::mutation(COLOURS, &[], "gives a colour of the palette or the background another hue"),
    Operator::mutation(DRIFT, &[], "lets the agents take other paths"),
    Operator::mutation(GLOW, &[], "changes the glow and the number of motes"),
    Operator::crossing(CROSSED, &["mate"], "mates the agents of both, some of them by a crossover of their strings"),
];

/// A child of one globe, and the last thing that was done; none if nothing was.
pub(crate) fn mutated(parent: &Globe, strength: f64, rng: &mut Rng) -> Option<(Globe, &'static str)> {
    let rate = (CHANGES * strength).clamp(0.0, 1.0);
    let mut how = None;
    let mut child = Globe { name: None, ..parent.clone() };
    for name in [STRINGS, LEAVE, COME, COLOURS, DRIFT, GLOW] {
        // Each agent has its own luck; and something else moves where none of them has.
        let is_due = name == STRINGS || rng.unit() < rate || (name == DRIFT && how.is_none() && rate > 0.0);
        if is_due && change(name, &mut child, rate, rng) {
            how = Some(name);
        }
    }
    fill(&mut child, rng);
    how.map(|how| (child, how))
}

/// A child of one globe by the mutation `name`; none if there is none of this name, or nothing for it to do.
pub(crate) fn mutated_by(name: &str, parent: &Globe, strength: f64, rng: &mut Rng) -> Option<Globe> {
    let rate = (CHANGES * strength).clamp(0.0, 1.0);
    let attempt = |rng: &mut Rng| {
        let mut child = Globe { name: None, ..parent.clone() };
        let is_changed = change(name, &mut child, rate, rng);
        fill(&mut child, rng);
        is_changed.then_some(child)
    };
    if rate > 0.0 { (0..ATTEMPTS).find_map(|_| attempt(rng)) } else { None }
}

/// Does what `name` says to a globe, each agent's string at this rate, and tells whether that changed anything.
fn change(name: &str, child: &mut Globe, rate: f64, rng: &mut Rng) -> bool {
    match name {
        STRINGS => {
            let parent = child.clone();
            (child.flock, child.shapes) = (Vec::new(), Vec::new());
            let mut changed = false;
            for agent in &parent.flock {
                let is_taken = rng.unit() < rate && (0..ATTEMPTS).any(|_| child.take(changed_string(agent, rng)));
                changed |= is_taken;
                if !is_taken {
                    child.keep(&parent, agent);
                }
            }
            changed
        }
        LEAVE if child.flock.len() > AGENTS[0] => {
            let gone = rng.below(child.flock.len());
            child.flock.remove(gone);
            child.shapes.remove(gone);
            true
        }
        COME => (0..ATTEMPTS).any(|_| child.take(string(Family::random(rng), rng))),
        COLOURS => {
            recolour(child, rng);
            true
        }
        DRIFT => {
            child.drift = rng.bits() as u32;
            true
        }
        GLOW => {
            child.glow = tenths((child.glow + 0.3 * rng.signed()).clamp(0.5, 1.8));
            child.dust = (f64::from(child.dust) + 40.0 * rng.signed()).clamp(20.0, f64::from(MOST_DUST)) as u32;
            true
        }
        _ => false,
    }
}

/// A child of two globes.
pub(crate) fn crossed(a: &Globe, b: &Globe, rng: &mut Rng) -> Globe {
    let looks = if rng.unit() < 0.5 { a } else { b };
    let mut child = Globe { name: None, flock: Vec::new(), shapes: Vec::new(), ..looks.clone() };
    child.drift = if rng.unit() < 0.5 { a.drift } else { b.drift };
    child.palette = crossed_palette(&a.palette, &b.palette, rng);
    let [few, many] = [a.flock.len().min(b.flock.len()), a.flock.len().max(b.flock.len())];
    let agents = few + rng.below(many - few + 1);
    let mates = |number: usize, rng: &mut Rng| {
        let [one, other] = [a, b].map(|side| side.flock[number % side.flock.len()].as_str());
        if rng.unit() < 0.5 { [one, other] } else { [other, one] }
    };
    for number in 0..agents.clamp(AGENTS[0], AGENTS[1]) {
        let [first, second] = mates(number, rng);
        let is_child = rng.unit() < 0.4 && (0..ATTEMPTS).any(|_| child.take(crossover(first, second, rng)));
        if !is_child {
            let side = if a.flock.iter().any(|agent| agent == first) { a } else { b };
            child.keep(side, first);
        }
    }
    fill(&mut child, rng);
    child
}

impl Globe {
    /// Takes in an agent of a parent as it is, unless it is there already.
    fn keep(&mut self, parent: &Globe, agent: &str) {
        let Some(number) = parent.flock.iter().position(|other| other == agent) else { return };
        let shape = &parent.shapes[number];
        if self.shapes.iter().all(|other| other.hash != shape.hash) {
            self.flock.push(agent.to_owned());
            self.shapes.push(shape.clone());
        }
    }
}

/// A string with one thing changed: a parameter, a character of a rule or of the start, or everything.
fn changed_string(agent: &str, rng: &mut Rng) -> String {
    if rng.unit() < 0.12 {
        return string(Family::random(rng), rng);
    }
    let mut entries: Vec<(String, String)> = agent
        .split('&')
        .filter_map(|entry| entry.split_once('=').map(|(key, value)| (key.to_owned(), value.to_owned())))
        .collect();
    let key = ["v", "it", "sc", "sw", "rules", "rules", "rules", "str"][rng.below(8)];
    if entries.iter().all(|(other, _)| other != key) {
        entries.push((key.to_owned(), default(key).to_owned()));
    }
    let number = entries.iter().rposition(|(other, _)| other == key).unwrap_or_default();
    let value = &mut entries[number].1;
    let old: f64 = value.parse().unwrap_or(5.0);
    *value = match key {
        "v" => format!("{}", [360.0 / (3 + rng.below(14)) as f64, tenths(old + 6.0 * rng.signed())][rng.below(2)]),
        "it" => format!("{}", (old + [1.0, -1.0][rng.below(2)]).clamp(1.0, 12.0)),
        "sc" => format!("{:.1}", (old * (1.0 + 0.4 * rng.signed())).clamp(1.0, 12.0)),
        "sw" => format!("{:.1}", (old + 4.0 * rng.signed()).clamp(-12.0, 12.0)),
        _ => changed_letters(value, rng),
    };
    let entries: Vec<String> = entries.iter().map(|(key, value)| format!("{key}={value}")).collect();
    let text = entries.join("&");
    // A child that is not seen would be refused later anyhow.
    if shape(&text).is_some() { text } else { agent.to_owned() }
}

/// What is changed where a string does not say it.
fn default(key: &str) -> &'static str {
    match key {
        "v" => "60",
        "it" => "2",
        "sc" => "5",
        "str" => "F++F++F",
        "rules" => "('F','F-F++F-F')",
        _ => "0",
    }
}

/// Letters of the turtle's, one of them put in, taken out, replaced or doubled.
fn changed_letters(text: &str, rng: &mut Rng) -> String {
    let mut letters: Vec<char> = text.chars().collect();
    let is_ours = |letter: &char| "F+-XY".contains(*letter);
    for _ in 0..=rng.below(2) {
        let places: Vec<usize> = (0..letters.len()).filter(|place| is_ours(&letters[*place])).collect();
        // The name of a rule is a letter too: changing it is another rule.
        if places.is_empty() {
            break;
        }
        let place = places[rng.below(places.len())];
        let new = ['F', 'F', '+', '-', 'X', 'Y'][rng.below(6)];
        match rng.below(4) {
            0 => letters.insert(place, new),
            1 => drop(letters.remove(place)),
            2 => letters[place] = new,
            _ => letters.insert(place, letters[place]),
        }
    }
    letters.into_iter().collect()
}

/// Another hue for a colour of the palette, or for the background.
fn recolour(globe: &mut Globe, rng: &mut Rng) {
    if rng.unit() < 0.3 {
        let hue = rng.unit();
        globe.background = [0.10, 0.17].map(|luma| of_luma(hue + 0.05 * rng.signed(), 0.6, luma + 0.03 * rng.signed()));
        return;
    }
    let number = rng.below(globe.palette.len());
    globe.palette[number] = Colour::of_hue(rng.unit(), 0.15 + 0.5 * rng.unit(), 0.85 + 0.15 * rng.unit());
}

/// Colours from either side, as many as one of them has.
fn crossed_palette(a: &[Colour], b: &[Colour], rng: &mut Rng) -> Vec<Colour> {
    let many = if rng.unit() < 0.5 { a.len() } else { b.len() };
    let pick = |number: usize| if rng.unit() < 0.5 { a[number % a.len()] } else { b[number % b.len()] };
    (0..many.min(MOST_COLOURS)).map(pick).collect()
}
