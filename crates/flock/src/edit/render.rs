//! How sheep and transitions are written.
//!
//! Owns the order of keys, the omission of defaults, and the form of values. `place.rs` chooses the position.
//!
//! Start at [`sheep`] and [`transition`].

use timing::Rate;

use crate::manifest::{Clip, Sheep, Transition};

/// A key and its value as written.
pub(super) type Pair = (&'static str, String);

/// The keys of a clip.
pub(super) const CLIP_KEYS: &[&str] = &["frames", "clip", "hash"];
/// The keys of a sheep, in the order in which they are written.
pub(super) const SHEEP_KEYS: &[&str] = &["id", "frames", "clip", "hash", "genome", "want", "repeat"];
/// The keys of a transition, in the order in which they are written.
pub(super) const TRANSITION_KEYS: &[&str] = &["from", "to", "frames", "clip", "hash", "weight"];

/// The head of a manifest.
pub(super) fn head(name: &str, (width, height): (u32, u32), fps: Rate) -> String {
    let (name, num, den) = (quoted(name), fps.num(), fps.den());
    format!("format = 1\nname = {name}\nsize = [{width}, {height}]\nfps = [{num}, {den}]\n")
}

/// The keys of `sheep` with their values, without defaults.
pub(super) fn sheep(sheep: &Sheep) -> Vec<Pair> {
    let is_default = |key: &str| (key == "want" && is_one(sheep.want)) || (key == "repeat" && sheep.repeat == 1);
    let keys = SHEEP_KEYS.iter().filter(|key| !is_default(key));
    keys.filter_map(|key| Some((*key, sheep_value(sheep, key)?))).collect()
}

/// The keys of `transition` with their values; a weight of 1 is left out.
pub(super) fn transition(transition: &Transition) -> Vec<Pair> {
    let keys = TRANSITION_KEYS.iter().filter(|key| **key != "weight" || !is_one(transition.weight));
    keys.filter_map(|key| Some((*key, transition_value(transition, key)?))).collect()
}

/// The value of `key` in `sheep`, if it has one.
pub(super) fn sheep_value(sheep: &Sheep, key: &str) -> Option<String> {
    match key {
        "id" => Some(quoted(sheep.id.as_str())),
        "genome" => sheep.genome.as_ref().map(|genome| quoted(genome.as_str())),
        "want" => Some(number(sheep.want)),
        "repeat" => Some(sheep.repeat.to_string()),
        key => clip_value(sheep.clip.as_ref()?, key),
    }
}

/// The value of `key` in `transition`, if it has one.
pub(super) fn transition_value(transition: &Transition, key: &str) -> Option<String> {
    match key {
        "from" => Some(quoted(transition.from.as_str())),
        "to" => Some(quoted(transition.to.as_str())),
        "weight" => Some(number(transition.weight)),
        key => clip_value(&transition.clip, key),
    }
}

/// The value of `key` in a clip, if it has one.
pub(super) fn clip_value(clip: &Clip, key: &str) -> Option<String> {
    match key {
        "frames" => Some(clip.frames.0.to_string()),
        "clip" => Some(quoted(clip.path.as_str())),
        "hash" => clip.hash.map(|hash| quoted(&hash.to_string())),
        _ => None,
    }
}

/// A text in quotes.
fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

/// The shortest number that reads back as `value`.
pub(super) fn number(value: f64) -> String {
    format!("{value:?}")
}

/// Whether a want or weight is the default.
fn is_one(value: f64) -> bool {
    value.to_bits() == 1.0_f64.to_bits()
}
