//! The graph for Graphviz.
//!
//! Owns the DOT text. Sheep have the positions of the page: `neato -n` keeps them, every other program of Graphviz places
//! them itself.
//!
//! # Source
//! The DOT language, as Graphviz documents it.

use super::facts::Facts;

/// The size of the drawing, in points.
const WIDTH: f64 = 1200.0;
const HEIGHT: f64 = 800.0;
/// The width of a sheep with an average share, in inches for a flock of one.
const NODE: f64 = 4.0;
/// The width of a transition of average frequency.
const PEN: f64 = 1.2;

/// The lines of the DOT text.
pub(super) fn lines(facts: &Facts<'_>) -> Vec<String> {
    let mut lines = vec![
        format!("digraph {} {{", quoted(facts.name)),
        "  node [shape=circle style=filled fixedsize=true fontname=\"sans-serif\" fontsize=9]".into(),
        "  edge [color=\"#00000066\" arrowsize=0.5]".into(),
    ];
    let count = facts.sheep.len().max(1) as f64;
    for sheep in &facts.sheep {
        let (x, y) = (WIDTH / 2.0 * (1.0 + sheep.x), HEIGHT / 2.0 * (1.0 - sheep.y));
        let width = NODE / count.sqrt() * (sheep.visits * count).sqrt().clamp(0.2, 3.0);
        lines.push(format!(
            "  {} [pos=\"{x:.1},{y:.1}\" width={width:.3} fillcolor=\"{}\" tooltip=\"visits {:.4} %, want {:.4} %\"]",
            quoted(sheep.id),
            sheep.colour,
            100.0 * sheep.visits,
            100.0 * sheep.want
        ));
    }
    let mean = 1.0 / facts.transitions.len().max(1) as f64;
    for &(from, to, visits, frames) in &facts.transitions {
        let pen = PEN * (visits / mean).sqrt().clamp(0.15, 4.0);
        lines.push(format!(
            "  {} -> {} [penwidth={pen:.3} tooltip=\"visits {:.4} %, {frames} frames\"]",
            quoted(facts.sheep[from].id),
            quoted(facts.sheep[to].id),
            100.0 * visits
        ));
    }
    lines.push("}".into());
    lines
}

/// `text` as a string of DOT, where a backslash begins an escape.
fn quoted(text: &str) -> String {
    let mut quoted = String::from('"');
    for c in text.chars() {
        match c {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            c if c.is_control() => quoted.push(' '),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn a_name_ends_where_its_quotes_end() {
        assert_eq!(quoted("a\"];\nb\\"), "\"a\\\"]; b\\\\\"");
    }
}
