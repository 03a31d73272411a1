//! Reading flam3 XML.
//!
//! Owns the attribute names for reading; `write.rs` has them for writing, and a property test compares the two. Whether
//! a flame can be rendered is checked later: unknown attributes are kept.
//!
//! Start at [`genome`]; `split.rs` finds the flames of a text.

use std::str::FromStr;

use roxmltree::Node;

use super::carry::Carrier;
use super::layers;
use super::value::{all_finite, integer};
use super::{
    Affine, Element, FilterShape, Genome, GenomeError, HuePath, Interpolation, PaletteBlend, PaletteMode, Place,
    Program, Space, TemporalShape, Wave, Xform,
};
use variations::{Kind, Part, Slot, Spelling, Stage, Variation};

/// How many characters of a wrong value are told.
const SHOWN: usize = 80;

/// What an attribute's value turned out to be.
pub(super) enum Read {
    /// It was understood.
    Taken,
    /// The name is unknown here.
    Unknown,
    /// The value is wrong; this was expected.
    Wrong(&'static str),
}

/// Reads a `<flame>`.
pub(super) fn genome(node: Node) -> Result<Genome, GenomeError> {
    let parts = layers::parts(node)?;
    let mut genome = Genome::default();
    // The number of the only transform that is seen; below 0 all are.
    let mut alone: i64 = -1;
    let own = parts.iter().flat_map(|part| attributes(*part).map(|attribute| (*part, attribute)));
    for (part, attribute) in own.filter(|(part, attribute)| !layers::is_of_layer(*part, attribute.name())) {
        if attribute.name() == "soloxform" && is_said(attribute.value()) {
            let found = integer(attribute.value());
            alone = found.ok_or_else(|| wrong(part, attribute, "a transform's number"))?;
            continue;
        }
        match flame_attribute(&mut genome, attribute.name(), attribute.value()) {
            Read::Unknown => {
                if part != node {
                    // What the layer says counts.
                    genome.extra.retain(|(name, _)| name != attribute.name());
                }
                genome.extra.push((attribute.name().into(), attribute.value().into()));
            }
            Read::Wrong(expected) if is_said(attribute.value()) => return Err(wrong(part, attribute, expected)),
            // A value that is empty says nothing.
            Read::Taken | Read::Wrong(_) => {}
        }
    }
    let carrier = Carrier::of(&genome);
    for child in layers::children(&parts) {
        match child.tag_name().name() {
            "xform" => genome.xforms.push(xform(child, carrier, &genome)?),
            "finalxform" => {
                let mut last = xform(child, carrier, &genome)?;
                if genome.program() == Some(Program::JWildfire) && !says_how_it_colours(child) {
                    last.color_speed = 0.0;
                }
                genome.finals.push(last);
            }
            "symmetry" => genome.symmetries.push(symmetry_kind(child)?),
            "color" | "colors" | "palette" if super::palette_xml::has_colours(child) => {
                super::palette_xml::read(child, &mut genome)?;
            }
            "palette" if genome.palette_blend.is_none() && PaletteBlend::is_in(child) => {
                genome.palette_blend = Some(PaletteBlend::read(child)?);
            }
            _ => genome.children.push(element(child)),
        }
    }
    if genome.program() == Some(Program::Fractorium) {
        genome.xforms.iter_mut().chain(&mut genome.finals).for_each(pass_on);
    }
    super::palette_xml::fill(&mut genome);
    super::finish_xml::settle(&mut genome, &parts)?;
    for (number, xform) in genome.xforms.iter_mut().enumerate() {
        if alone >= 0 && usize::try_from(alone) != Ok(number) {
            xform.opacity = 0.0;
        }
    }
    genome.leave_out();
    Ok(genome)
}

/// What of a `<flame>` is read otherwise than it is written, in words.
pub(super) fn notes(node: Node) -> Vec<String> {
    let center = node.attribute("center").unwrap_or_default();
    let read = all_finite(center);
    let moved = (read != center).then(|| format!("its center is `{}`, read as `{}`", shown(center), shown(&read)));
    // Of a flame that cannot be read nothing is noted.
    let parts = layers::parts(node).unwrap_or_default();
    moved.into_iter().chain(layers::children(&parts).find_map(super::palette_xml::note)).collect()
}

/// Whether a `<finalxform>` says whether it colours: in JWildfire, one that does not say so leaves colours as they are.
fn says_how_it_colours(node: Node) -> bool {
    ["color_type", "color_speed"].iter().any(|name| node.has_attribute(*name))
}

fn is_said(value: &str) -> bool {
    !value.trim().is_empty()
}

fn flame_attribute(genome: &mut Genome, name: &str, value: &str) -> Read {
    let Genome { camera, sampling, tone, .. } = genome;
    if let Some(slot) = camera.pose.number(name) {
        return number(slot, value);
    }
    match name {
        "cam_yaw_turns" => match value.trim().parse() {
            Ok(turns) => {
                camera.pose.yaw_turns = turns;
                Read::Taken
            }
            Err(_) => Read::Wrong("a whole number"),
        },
        "name" => {
            genome.name = Some(value.into());
            Read::Taken
        }
        "time" => number(&mut genome.time, value),
        "size" => match value.split_whitespace().map(integer).collect::<Option<Vec<u32>>>().as_deref() {
            Some(&[width, height]) => {
                camera.size = [width, height];
                Read::Taken
            }
            _ => Read::Wrong("two whole numbers"),
        },
        "center" => numbers(&mut camera.center, &all_finite(value), "two numbers"),
        "scale" => number(&mut camera.scale, value),
        "zoom" => number(&mut camera.zoom, value),
        "rotate" => number(&mut camera.rotate, value),
        "quality" => number(&mut sampling.quality, value),
        "supersample" | "oversample" => whole(&mut sampling.supersample, value),
        "filter" => number(&mut sampling.filter_radius, value),
        "filter_shape" => choice(&mut sampling.filter_shape, FilterShape::named(value), "a filter's name"),
        "temporal_samples" => whole(&mut sampling.temporal_samples, value),
        "temporal_filter_type" => {
            choice(&mut sampling.temporal_shape, TemporalShape::named(value), "`box`, `gaussian` or `exp`")
        }
        "temporal_filter_width" => number(&mut sampling.temporal_width, value),
        "temporal_filter_exp" => number(&mut sampling.temporal_exponent, value),
        "passes" | "batches" => whole(&mut sampling.passes, value),
        "estimator_radius" => number(&mut sampling.estimator_radius, value),
        "estimator_minimum" => number(&mut sampling.estimator_minimum, value),
        "estimator_curve" => number(&mut sampling.estimator_curve, value),
        "background" => numbers(&mut tone.background, value, "three numbers"),
        "brightness" => number(&mut tone.brightness, value),
        "gamma" => number(&mut tone.gamma, value),
        "gamma_threshold" => number(&mut tone.gamma_threshold, value),
        "vibrancy" => number(&mut tone.vibrancy, value),
        "highlight_power" => number(&mut tone.highlight_power, value),
        "palette" => choice(&mut genome.palette_number, integer(value).map(Some), "a whole number"),
        "hue" => number(&mut genome.hue, value),
        "palette_mode" => choice(&mut genome.palette_mode, PaletteMode::named(value), "`step` or `linear`"),
        "palette_interpolation" => {
            choice(&mut genome.hue_path, HuePath::read(value), "`rgb`, `hsv`, `hsv_circular` or `sweep`")
        }
        "hsv_rgb_palette_blend" => number(&mut genome.hue_path_rgb, value),
        "interpolation" => choice(&mut genome.interpolation, Interpolation::named(value), "`linear` or `smooth`"),
        "interpolation_type" | "interpolation_space" => {
            choice(&mut genome.space, Space::named(value), "`log`, `linear`, `old` or `older`")
        }
        _ => Read::Unknown,
    }
}

fn xform(node: Node, carrier: Carrier, genome: &Genome) -> Result<Xform, GenomeError> {
    let mut xform = Xform::default();
    for attribute in attributes(node) {
        let (name, value) = (attribute.name(), attribute.value());
        let read = match (name.get(..2), name.get(2..)) {
            (Some(plane @ ("yz" | "zx")), Some("Coefs")) => xform.tilt.read(plane, value),
            (Some(plane @ ("yz" | "zx")), Some("Post")) => xform.post_tilt.read(plane, value),
            _ => match xform_attribute(&mut xform, name, value) {
                Read::Unknown => variation_attribute(&mut xform, name, value),
                read @ (Read::Taken | Read::Wrong(_)) => read,
            },
        };
        match read {
            Read::Taken => {}
            Read::Unknown => xform.extra.push((name.into(), value.into())),
            Read::Wrong(expected) => return Err(wrong(node, attribute, expected)),
        }
    }
    // Before any variation moves to another stage: the attribute has its name of the file.
    super::carry::settle(&mut xform, carrier);
    let is_own = genome.program() == Some(Program::JWildfire);
    super::jwildfire::settle(&mut xform, is_own, node);
    if is_own {
        super::motion_curve::settle(&mut xform, super::origin::attribute(&genome.extra, "frame"));
    }
    for child in node.children().filter(Node::is_element) {
        match child.tag_name().name() {
            "motion" => xform.motions.push(Wave::read(child)?),
            _ => xform.children.push(element(child)),
        }
    }
    Ok(xform)
}

pub(super) fn xform_attribute(xform: &mut Xform, name: &str, value: &str) -> Read {
    match name {
        "weight" => number(&mut xform.weight, value),
        "color" => match list::<f64>(value).as_deref() {
            Some(&[color]) => {
                xform.color = color;
                Read::Taken
            }
            Some(&[color, second]) => {
                (xform.color, xform.color2) = (color, Some(second));
                Read::Taken
            }
            _ => Read::Wrong("one or two numbers"),
        },
        "color_speed" => number(&mut xform.color_speed, value),
        "animate" => number(&mut xform.animate, value),
        "symmetry" => {
            let mut symmetry = 0.0;
            let read = number(&mut symmetry, value);
            xform.color_speed = (1.0 - symmetry) / 2.0;
            xform.animate = if symmetry > 0.0 { 0.0 } else { 1.0 };
            read
        }
        "opacity" => number(&mut xform.opacity, value),
        "plotmode" => {
            xform.opacity = if value == "off" { 0.0 } else { xform.opacity };
            Read::Taken
        }
        "chaos" => match list(value) {
            Some(chaos) => {
                xform.chaos = chaos;
                Read::Taken
            }
            None => Read::Wrong("numbers"),
        },
        "coefs" => affine(&mut xform.affine, value),
        "post" => affine(&mut xform.post, value),
        _ => Read::Unknown,
    }
}

pub(super) fn variation_attribute(xform: &mut Xform, name: &str, value: &str) -> Read {
    if let Some(Spelling { slot, part }) = Spelling::of(name) {
        return match part {
            Part::Weight => number(&mut entry(xform, slot).weight, value),
            Part::Parameter(index) => number(&mut entry(xform, slot).params[index], value),
            Part::Presence => number(&mut entry(xform, slot).presence, value),
            // Only when the variation is known: `apply_priorities` reads it, and `carry.rs`.
            Part::Priority | Part::Carry => Read::Unknown,
        };
    }
    match name {
        // Both say all weights of a transform: those that other attributes gave before are gone.
        "var" => match list::<f64>(value) {
            Some(weights) if weights.iter().skip(Kind::FLAM3.len()).all(|weight| *weight == 0.0) => {
                forget_weights(xform);
                for (kind, weight) in Kind::FLAM3.into_iter().zip(weights).filter(|(_, weight)| *weight != 0.0) {
                    entry(xform, Variation::new(kind, 0.0).slot()).weight = weight;
                }
                Read::Taken
            }
            _ => Read::Wrong("weights of variations in the order of their numbers"),
        },
        "var1" => match value.trim().parse::<usize>().ok().and_then(|number| Kind::FLAM3.get(number)) {
            Some(kind) => {
                forget_weights(xform);
                entry(xform, Variation::new(*kind, 0.0).slot()).weight = 1.0;
                Read::Taken
            }
            None => Read::Wrong("a variation's number"),
        },
        _ => Read::Unknown,
    }
}

/// Has a transform that has variations before the sum and none in it pass the point on, as Fractorium does: its sum gets
/// `linear`. (Without either, the point goes to 0 there, too.)
fn pass_on(xform: &mut Xform) {
    let used = || xform.variations.iter().filter(|variation| !variation.is_absent());
    let is_before = |variation: &Variation| {
        variation.kind == Kind::PreBlur || matches!(variation.stage, Stage::Before | Stage::AddedBefore)
    };
    if used().any(is_before) && used().all(|variation| is_before(variation) || variation.stage != Stage::Sum) {
        let linear = entry(xform, Variation::new(Kind::Linear, 0.0).slot());
        (linear.weight, linear.carry) = (1.0, 1.0);
    }
}

fn forget_weights(xform: &mut Xform) {
    for variation in &mut xform.variations {
        variation.weight = 0.0;
    }
}

/// The variation in this place of `xform`, added with weight 0 and default parameters where it is missing.
fn entry(xform: &mut Xform, slot: Slot) -> &mut Variation {
    let found = xform.variations.iter().position(|variation| variation.slot() == slot);
    let index = found.unwrap_or_else(|| {
        xform.variations.push(Variation { stage: slot.stage, number: slot.number, ..Variation::new(slot.kind, 0.0) });
        xform.variations.len() - 1
    });
    &mut xform.variations[index]
}

fn symmetry_kind(node: Node) -> Result<i32, GenomeError> {
    let value = node.attribute("kind").unwrap_or_default();
    integer(value).ok_or_else(|| GenomeError::Attribute {
        place: place(node),
        element: "symmetry".into(),
        attribute: "kind".into(),
        value: shown(value),
        expected: "a whole number",
    })
}

pub(super) fn element(node: Node) -> Element {
    Element {
        tag: node.tag_name().name().into(),
        attributes: attributes(node).map(|a| (a.name().into(), a.value().into())).collect(),
        text: node.text().unwrap_or_default().trim().into(),
        children: node.children().filter(Node::is_element).map(element).collect(),
    }
}

pub(super) fn affine(slot: &mut Affine, value: &str) -> Read {
    match list(value).as_deref() {
        Some(&[a, d, b, e, c, f]) => {
            *slot = Affine { a, b, c, d, e, f };
            Read::Taken
        }
        _ => Read::Wrong("six numbers"),
    }
}

fn number(slot: &mut f64, value: &str) -> Read {
    match value.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => {
            *slot = number;
            Read::Taken
        }
        _ => Read::Wrong("a finite number"),
    }
}

fn whole(slot: &mut u32, value: &str) -> Read {
    choice(slot, integer(value).filter(|number| *number > 0), "a whole number above 0")
}

fn choice<T>(slot: &mut T, found: Option<T>, expected: &'static str) -> Read {
    match found {
        Some(found) => {
            *slot = found;
            Read::Taken
        }
        None => Read::Wrong(expected),
    }
}

fn numbers<T: FromStr + Copy + Finite, const N: usize>(slot: &mut [T; N], value: &str, expected: &'static str) -> Read {
    match list(value).and_then(|list| <[T; N]>::try_from(list).ok()) {
        Some(values) => {
            *slot = values;
            Read::Taken
        }
        None => Read::Wrong(expected),
    }
}

/// The finite numbers of a value, separated by white space.
pub(super) fn list<T: FromStr + Finite>(value: &str) -> Option<Vec<T>> {
    value.split_whitespace().map(|word| word.parse().ok().filter(T::finite)).collect()
}

/// Numbers that may be infinite or not a number, and must not be here.
pub(super) trait Finite {
    /// Whether it is an ordinary number.
    fn finite(&self) -> bool;
}

impl Finite for f64 {
    fn finite(&self) -> bool {
        self.is_finite()
    }
}

pub(super) fn wrong(node: Node, attribute: roxmltree::Attribute, expected: &'static str) -> GenomeError {
    GenomeError::Attribute {
        place: Place::of(node.document().input_text(), attribute.range().start),
        element: node.tag_name().name().into(),
        attribute: shown(attribute.name()),
        value: shown(attribute.value()),
        expected,
    }
}

/// The attributes of an element. Those in an XML namespace are no flame's and are left out.
pub(super) fn attributes<'a, 'i>(node: Node<'a, 'i>) -> impl Iterator<Item = roxmltree::Attribute<'a, 'i>> {
    node.attributes().filter(|attribute| attribute.namespace().is_none())
}

/// The place where an element begins.
pub(super) fn place(node: Node) -> Place {
    Place::of(node.document().input_text(), node.range().start)
}

/// The parser's error on a text that begins at `start` of a larger one: its beginning, and its end, which has line and
/// column.
pub(super) fn not_xml(error: &roxmltree::Error, start: Place) -> GenomeError {
    let mut reason = error.to_string();
    let inner = error.pos();
    if let Some((before, after)) = reason.rsplit_once(&format!(" at {inner}")) {
        let Place { line, column } = start.of_inner(Place { line: inner.row, column: inner.col });
        reason = format!("{before} at {line}:{column}{after}");
    }
    let end = reason.char_indices().rev().nth(SHOWN - 1).map_or("", |(start, _)| &reason[start..]);
    let is_long = reason.chars().count() > 2 * SHOWN;
    GenomeError::Xml { reason: if is_long { shown(&reason) + end } else { reason } }
}

/// As much of a wrong value as fits into a message.
pub(super) fn shown(value: &str) -> String {
    match value.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &value[..end]),
        None => value.to_owned(),
    }
}
