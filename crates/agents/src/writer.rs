//! The text of a globe.
//!
//! Owns the order of what is written. Never judges it.
//!
//! Start at [`written`].

use std::fmt::Write as _;

use toml::Value;

use crate::colour::Colour;
use crate::globe::Globe;

/// The globe as TOML: what was not understood stands where it stood.
pub(crate) fn written(globe: &Globe) -> String {
    let mut text = globe.kept.before.clone();
    text.push_str("[agents]\nversion = 1\n");
    // Writing to a text never fails.
    if let Some(name) = &globe.name {
        let _ = writeln!(text, "name = {}", quoted(name));
    }
    let _ = writeln!(text, "background = {}", list(&globe.background));
    let _ = writeln!(text, "palette = {}", list(&globe.palette));
    let _ = writeln!(text, "drift = {}", globe.drift);
    let _ = writeln!(text, "glow = {:?}", globe.glow);
    let _ = writeln!(text, "dust = {}", globe.dust);
    text.push_str("flock = [\n");
    for agent in &globe.flock {
        let _ = writeln!(text, "  {},", quoted(agent));
    }
    text.push_str("]\n");
    text.push_str(&globe.kept.head);
    text.push_str(&globe.kept.after);
    text
}

fn quoted(text: &str) -> String {
    // A text in one line, whatever is in it, has one place in errors.
    if text.chars().all(|letter| !letter.is_control() && letter != '"' && letter != '\\') {
        return format!("\"{text}\"");
    }
    Value::String(text.to_owned()).to_string()
}

fn list(colours: &[Colour]) -> String {
    let colours: Vec<String> = colours.iter().map(|colour| format!("\"{colour}\"")).collect();
    format!("[{}]", colours.join(", "))
}
