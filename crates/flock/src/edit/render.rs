//! How sheep and transitions are written.
//!
//! Owns the order of keys, the omission of defaults, and the form of values. `place.rs` chooses the position.
//!
//! Start at [`sheep`] and [`transition`].

use timing::Rate;

use crate::manifest::{Clip, Sheep, Transition};

/// A key and its value as written.
pub(super) type Pair = (&'static str, String);

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
    let mut pairs = vec![("id", quoted(sheep.id.as_str()))];
    pairs.extend(sheep.clip.iter().flat_map(clip));
    pairs.extend(sheep.genome.iter().map(|genome| ("genome", quoted(genome.as_str()))));
    pairs.extend((!is_one(sheep.want)).then(|| ("want", number(sheep.want))));
    pairs.extend((sheep.repeat != 1).then(|| ("repeat", sheep.repeat.to_string())));
    pairs
}

/// The keys of `transition` with their values; a weight of 1 is left out.
pub(super) fn transition(transition: &Transition) -> Vec<Pair> {
    let mut pairs = vec![("from", quoted(transition.from.as_str())), ("to", quoted(transition.to.as_str()))];
    pairs.extend(clip(&transition.clip));
    pairs.extend((!is_one(transition.weight)).then(|| ("weight", number(transition.weight))));
    pairs
}

/// The keys of a clip with their values.
pub(super) fn clip(clip: &Clip) -> Vec<Pair> {
    let mut pairs = vec![("frames", clip.frames.0.to_string()), ("clip", quoted(clip.path.as_str()))];
    pairs.extend(clip.hash.map(|hash| ("hash", quoted(&hash.to_string()))));
    pairs
}

/// A text in quotes.
pub(super) fn quoted(text: &str) -> String {
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
