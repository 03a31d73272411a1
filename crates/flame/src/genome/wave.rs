//! `<motion>`: what a wave adds to a transform in the course of a loop.
//!
//! Owns the element's reading and writing. What it does to a transform is in `animate/waves.rs`.
//!
//! Start at [`Wave`].

use roxmltree::Node;

use super::parse::{Read, attributes, variation_attribute, wrong, xform_attribute};
use super::{Affine, Element, GenomeError, WaveShape, Xform};
use variations::{MAX_PARAMETERS, Part, Spelling, Variation};

/// The 2x2 part and the translation of nothing.
const NOTHING: Affine = Affine { a: 0.0, b: 0.0, c: 0.0, d: 0.0, e: 0.0, f: 0.0 };

/// A `<motion>` element of a transform.
#[derive(Clone, Debug, PartialEq)]
pub struct Wave {
    /// `motion_frequency`: waves in a loop.
    pub frequency: i32,
    /// `motion_function`.
    pub shape: WaveShape,
    /// What is added where the wave is 1. Its numbers are 0 where the element has none, those of affine parts and the
    /// parameters of variations too; it has no chaos and no motions. Unknown attributes are kept in its `extra`.
    pub added: Xform,
}

impl Default for Wave {
    fn default() -> Wave {
        let added =
            Xform { color_speed: 0.0, animate: 0.0, opacity: 0.0, affine: NOTHING, post: NOTHING, ..Xform::default() };
        Wave { frequency: 0, shape: WaveShape::Hill, added }
    }
}

impl Wave {
    /// Reads a `<motion>` element.
    pub(super) fn read(node: Node) -> Result<Wave, GenomeError> {
        let mut wave = Wave::default();
        for attribute in attributes(node) {
            let (name, value) = (attribute.name(), attribute.value());
            match wave.attribute(name, value) {
                Read::Taken => {}
                Read::Unknown => wave.added.extra.push((name.into(), value.into())),
                Read::Wrong(expected) => return Err(wrong(node, attribute, expected)),
            }
        }
        let adds = |variation: &Variation| variation.weight != 0.0 || variation.params != [0.0; MAX_PARAMETERS];
        wave.added.variations.retain(adds);
        wave.added.children = node.children().filter(Node::is_element).map(super::parse::element).collect();
        Ok(wave)
    }

    fn attribute(&mut self, name: &str, value: &str) -> Read {
        match name {
            "motion_frequency" => match value.trim().parse() {
                Ok(frequency) => {
                    self.frequency = frequency;
                    Read::Taken
                }
                Err(_) => Read::Wrong("a whole number"),
            },
            "motion_function" => match WaveShape::named(value) {
                Some(shape) => {
                    self.shape = shape;
                    Read::Taken
                }
                None => Read::Wrong("`sin`, `triangle` or `hill`"),
            },
            "chaos" => Read::Wrong("no `chaos` in a `motion`"),
            "weight" | "color" | "color_speed" | "animate" | "opacity" | "coefs" | "post" => {
                xform_attribute(&mut self.added, name, value)
            }
            _ => {
                let Some(Spelling { slot, part: Part::Weight | Part::Parameter(_) }) = Spelling::of(name) else {
                    return Read::Unknown;
                };
                if self.added.variations.iter().all(|variation| variation.slot() != slot) {
                    self.added.variations.push(Variation { params: [0.0; MAX_PARAMETERS], ..slot.absent() });
                }
                variation_attribute(&mut self.added, name, value)
            }
        }
    }

    /// The element that reads back as this wave.
    pub(super) fn element(&self) -> Element {
        let added = &self.added;
        let mut element = Element { tag: "motion".into(), children: added.children.clone(), ..Element::default() };
        element.set("motion_frequency", self.frequency);
        element.set("motion_function", self.shape.name());
        for (name, value) in [
            ("weight", added.weight),
            ("color_speed", added.color_speed),
            ("animate", added.animate),
            ("opacity", added.opacity),
        ] {
            element.set_unless_0(name, value);
        }
        if added.color != 0.0 || added.color2.is_some() {
            element.set_all("color", std::iter::once(added.color).chain(added.color2));
        }
        for (name, affine) in [("coefs", &added.affine), ("post", &added.post)] {
            if *affine != NOTHING {
                element.set_all(name, affine.columns());
            }
        }
        for variation in added.variations.iter().chain(&added.left_out) {
            element.set_unless_0(&variation.attribute(), variation.weight);
            for (parameter, value) in variation.kind.parameters().iter().zip(variation.params) {
                element.set_unless_0(&variation.parameter_attribute(parameter.name), value);
            }
        }
        element.attributes.extend(added.extra.iter().cloned());
        element
    }
}
