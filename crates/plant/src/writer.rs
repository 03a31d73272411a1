//! From a genome to a text.
//!
//! Owns the order in which a file is written. Never reads one.
//!
//! Start at [`Plant::to_toml`].

use std::fmt::Write as _;

use toml::Value;

use crate::genes::GENES;
use crate::genome::Plant;
use crate::reader::VERSION;

impl Plant {
    /// The text that [`Plant::parse`] reads as this very genome.
    pub fn to_toml(&self) -> String {
        let [of_table, of_file] = &self.unknown;
        let mut text = format!("[plant]\nversion = {VERSION}\n");
        if let Some(name) = &self.name {
            line(&mut text, "name", &quoted(name));
        }
        text += &self.drawn_toml();
        for (key, value) in of_table {
            line(&mut text, &name_of(key), value);
        }
        // Values of the file would belong to the table above, so that they are all written as tables' keys, in front of it.
        let (tables, values): (Vec<_>, Vec<_>) = of_file.iter().partition(|(_, value)| value.starts_with('{'));
        for (key, value) in tables {
            table(&mut text, key, value);
        }
        let mut front = String::new();
        for (key, value) in values {
            line(&mut front, &name_of(key), value);
        }
        front + &text
    }

    /// The lines that pictures depend on.
    pub(crate) fn drawn_toml(&self) -> String {
        let mut text = format!("seed = {}\nturns = {}\n", self.seed, self.turns);
        for (name, colour) in ["sky", "horizon"].iter().zip(self.sky) {
            line(&mut text, name, &format!("{colour:?}"));
        }
        for (gene, number) in GENES.iter().zip(self.genes) {
            line(&mut text, gene.name, &format!("{number:?}"));
        }
        text
    }
}

fn line(text: &mut String, key: &str, value: &str) {
    writeln!(text, "{key} = {value}").expect("a text takes what is written");
}

/// A table of the file under its own head; it was written inline.
fn table(text: &mut String, key: &str, inline: &str) {
    writeln!(text, "\n[{}]", name_of(key)).expect("a text takes what is written");
    let read: Result<toml::Table, _> = toml::from_str(&format!("it = {inline}"));
    if let Ok(Some(Value::Table(entries))) = read.map(|mut table| table.remove("it")) {
        for (key, value) in &entries {
            line(text, &name_of(key), &value.to_string());
        }
    }
}

fn quoted(text: &str) -> String {
    Value::String(text.to_owned()).to_string()
}

/// A key, in quotes where it needs them.
fn name_of(key: &str) -> String {
    let is_bare = !key.is_empty() && key.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-_".contains(&byte));
    if is_bare { key.to_owned() } else { quoted_key(key) }
}

/// A key in quotes: on one line, whatever is in it.
fn quoted_key(key: &str) -> String {
    let mut text = String::from("\"");
    for letter in key.chars() {
        match letter {
            '"' => text.push_str("\\\""),
            '\\' => text.push_str("\\\\"),
            control if control.is_control() => {
                write!(text, "\\u{:04X}", u32::from(control)).expect("a text takes what is written");
            }
            other => text.push(other),
        }
    }
    text + "\""
}
