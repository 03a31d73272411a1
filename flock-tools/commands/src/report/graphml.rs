//! The graph for Gephi, yEd and everything else that reads `GraphML`.
//!
//! Owns the XML text: the data of sheep and transitions, by name and type.
//!
//! # Source
//! The `GraphML` primer, 2.4: attributes are declared as keys, and referred to by their ids.

use super::facts::Facts;
use super::html::escaped;

/// Ids of keys, the elements that have them, their names for people, their types.
const KEYS: [(&str, &str, &str, &str); 10] = [
    ("label", "node", "label", "string"),
    ("visits", "node", "visits", "double"),
    ("want", "node", "want", "double"),
    ("minutes", "node", "minutes a day", "double"),
    ("colour", "node", "colour", "string"),
    ("x", "node", "x", "double"),
    ("y", "node", "y", "double"),
    ("taken", "edge", "visits", "double"),
    ("weight", "edge", "weight", "double"),
    ("frames", "edge", "frames", "int"),
];

/// The lines of the XML text.
pub(super) fn lines(facts: &Facts<'_>) -> Vec<String> {
    let mut lines = vec![
        r#"<?xml version="1.0" encoding="UTF-8"?>"#.to_owned(),
        r#"<graphml xmlns="http://graphml.graphdrawing.org/xmlns">"#.to_owned(),
    ];
    lines.extend(
        KEYS.iter().map(|(id, of, name, kind)| {
            format!(r#"  <key id="{id}" for="{of}" attr.name="{name}" attr.type="{kind}"/>"#)
        }),
    );
    lines.push(r#"  <graph id="flock" edgedefault="directed">"#.into());
    lines.push(format!("    <desc>{}</desc>", escaped(facts.name)));
    for sheep in &facts.sheep {
        let id = escaped(sheep.id);
        let data = [
            ("label", id.clone()),
            ("visits", sheep.visits.to_string()),
            ("want", sheep.want.to_string()),
            ("minutes", sheep.minutes_a_day.to_string()),
            ("colour", sheep.colour.clone()),
            ("x", sheep.x.to_string()),
            ("y", sheep.y.to_string()),
        ];
        lines.push(format!(r#"    <node id="{id}">{}</node>"#, carried(&data)));
    }
    for &(from, to, visits, frames) in &facts.transitions {
        // Programs draw an edge as strong as its weight: how often the walk takes it.
        let data = [("taken", visits.to_string()), ("weight", visits.to_string()), ("frames", frames.to_string())];
        let (from, to) = (escaped(facts.sheep[from].id), escaped(facts.sheep[to].id));
        lines.push(format!(r#"    <edge source="{from}" target="{to}">{}</edge>"#, carried(&data)));
    }
    lines.extend(["  </graph>".into(), "</graphml>".into()]);
    lines
}

fn carried(data: &[(&str, String)]) -> String {
    let one = |(key, value): &(&str, String)| format!(r#"<data key="{key}">{value}</data>"#);
    data.iter().map(one).collect::<Vec<_>>().concat()
}
