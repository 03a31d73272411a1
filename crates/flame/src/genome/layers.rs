//! JWildfire's flames of layers.
//!
//! Owns which of them are read, and where their parts stand: a single layer that counts in full is a flame. Several are
//! mixed by their weights, which is not drawn. Never reads what is in a layer.
//!
//! Start at [`parts`].
//!
//! # Source
//! JWildfire's pictures of one layer, beside those of the same flame without layers: they are equal with a weight and a
//! density of 1, darker with less, and black where the layer is not visible.

use roxmltree::Node;

use super::GenomeError;
use super::parse::{list, place};
use super::split::LAYERED;

/// The tag of a layer.
const LAYER: &str = "layer";

/// Attributes of a layer that a flame has not; at 1, or missing, they change nothing.
const OWN: [&str; 3] = ["density", "visible", "weight"];

/// The elements that have the attributes and the elements of a flame: `node`, and its layer if it is one of layers.
/// Errors: [`GenomeError::Layers`] unless it has one layer, which counts in full.
pub(super) fn parts<'a, 'i>(node: Node<'a, 'i>) -> Result<Vec<Node<'a, 'i>>, GenomeError> {
    if !node.has_tag_name(LAYERED) {
        return Ok(vec![node]);
    }
    match layers(node)[..] {
        [layer] if OWN.iter().all(|name| layer.attribute(*name).is_none_or(is_1)) => Ok(vec![node, layer]),
        _ => Err(GenomeError::Layers { place: place(node) }),
    }
}

/// Whether the attribute `name` of `part` is of a layer only, or what the layer itself is called.
pub(super) fn is_of_layer(part: Node, name: &str) -> bool {
    part.has_tag_name(LAYER) && (name == "name" || OWN.contains(&name))
}

/// The elements in a flame that are not its layers.
pub(super) fn children<'a, 'i>(parts: &[Node<'a, 'i>]) -> impl Iterator<Item = Node<'a, 'i>> {
    let inside = parts.iter().flat_map(Node::children).filter(Node::is_element);
    inside.filter(|child| !parts.contains(child))
}

fn layers<'a, 'i>(node: Node<'a, 'i>) -> Vec<Node<'a, 'i>> {
    node.children().filter(|child| child.has_tag_name(LAYER)).collect()
}

fn is_1(value: &str) -> bool {
    list::<f64>(value).as_deref() == Some(&[1.0])
}

#[cfg(test)]
mod tests {
    use super::super::Genome;

    #[test]
    fn what_a_layer_says_is_of_its_flame_and_counts() {
        let xform = "<xform weight='1' linear='1'/>";
        let of = |own: &str, layer: &str| format!("<jwf-flame {own}><layer {layer}>{xform}</layer><edit/></jwf-flame>");
        let read = Genome::parse(&of("name='a' scale='9' wobble='1'", "weight='1.0' visible='1' name='b' wobble='2'"));
        let flat = Genome::parse(&format!("<flame name='a' scale='9' wobble='2'><edit/>{xform}</flame>"));
        assert_eq!(read, flat);
        let wrong = Genome::parse(&of("contrast='1' white_level='220'", "\ncontrast='x'")).unwrap_err();
        let expected = "line 2, column 1: attribute `contrast` of `layer` is `x`, expected ";
        assert!(wrong.to_string().starts_with(expected), "{wrong}");
    }
}
