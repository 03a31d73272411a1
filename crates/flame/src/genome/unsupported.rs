//! What a genome asks for that is not drawn.
//!
//! Owns the list of all reasons for which a genome is refused, and of what is drawn without; and the mark of a genome that
//! is to be drawn without its unknown variations. `attributes.rs` has the tables. Never draws.
//!
//! Start at [`Genome::unsupported`].

use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

use super::attributes::{Meaning, of_flame, of_xform};
use super::parse::shown;
use super::{Element, Genome, Xform};
use variations::Undrawn;

/// The attribute of `<flame>` that names the unknown variations without which it is drawn.
pub const MARK: &str = "drawn_without";

/// Where attributes of `<flame>` stand.
const FLAME: &str = "the flame";

/// So many different reasons are in a message; the others are counted.
const MOST_NAMES: usize = 100;

/// Elements in `<flame>` that change no picture.
const NEUTRAL_ELEMENTS: [&str; 2] = ["edit", "sheep"];

/// What a genome asks for and is not drawn.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Unsupported {
    /// For this it is refused.
    pub refused: Reasons,
    /// It is drawn without this.
    pub without: Reasons,
}

/// Reasons, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reasons(pub Vec<Reason>);

/// An attribute or an element that is not drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reason {
    /// Where it stands: `the flame`, `transform 0`, `the final transform`, `a motion of transform 0`.
    pub place: String,
    /// Its name, as the file has it.
    pub name: String,
    /// Its value or its text, 80 characters at most.
    pub value: String,
    /// What it asks for.
    pub why: Why,
}

/// What an attribute or an element asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Why {
    /// Something unknown.
    Attribute,
    /// A background of several colours.
    Background,
    /// Another way in which points get their colours.
    Colour,
    /// A value that changes with time along a curve.
    Curve,
    /// Another picture made of the picture: symmetry, blur, mixed channels.
    Effect,
    /// An element, which is unknown.
    Element,
    /// An unknown variation that the artist has left out.
    LeftOut,
    /// A variation at another place among those of its transform.
    Order,
    /// Solid surfaces with lights.
    Solid,
    /// Another way from density to light.
    Tone,
    /// A value of a variation's parameter that is not drawn.
    Value,
    /// An unknown variation.
    Variation,
    /// A field that changes weights from point to point.
    WeightField,
}

impl Why {
    /// One word for programs.
    pub fn word(self) -> &'static str {
        match self {
            Why::Attribute => "attribute",
            Why::Background => "background",
            Why::Colour => "colour",
            Why::Curve => "curve",
            Why::Effect => "effect",
            Why::Element => "element",
            Why::LeftOut => "left-out",
            Why::Order => "order",
            Why::Solid => "solid",
            Why::Tone => "tone",
            Why::Value => "value",
            Why::Variation => "variation",
            Why::WeightField => "weighting-field",
        }
    }

    /// What people call an attribute that asks for it.
    fn noun(self) -> &'static str {
        match self {
            Why::Attribute => "the attribute",
            Why::Background => "the background",
            Why::Colour => "the colouring",
            Why::Curve => "the curve over time",
            Why::Effect => "the effect",
            Why::Element => "the element",
            Why::LeftOut | Why::Variation => "the variation",
            Why::Order => "the order by",
            Why::Solid => "solid rendering by",
            Why::Tone => "the tone's",
            Why::Value => "this value of",
            Why::WeightField => "the weighting field",
        }
    }
}

impl Reasons {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Each name once, with its places; in words that follow *does not draw*.
impl Display for Reasons {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let mut groups: Vec<(&Reason, Vec<&str>)> = Vec::new();
        for reason in &self.0 {
            match groups.iter_mut().find(|(first, _)| (&first.name, first.why) == (&reason.name, reason.why)) {
                Some((_, places)) => places.push(&reason.place),
                None => groups.push((reason, vec![&reason.place])),
            }
        }
        for (at, (Reason { name, value, why, .. }, places)) in groups.iter().take(MOST_NAMES).enumerate() {
            let before = if at > 0 { ", " } else { "" };
            let place = places[0];
            write!(f, "{before}{} `{}` (", why.noun(), shown(name))?;
            match places.len() - 1 {
                0 => write!(f, "`{value}`, {place})")?,
                others => write!(f, "{place} and {others} more)")?,
            }
        }
        match groups.len().saturating_sub(MOST_NAMES) {
            0 => Ok(()),
            more => write!(f, ", and {more} more"),
        }
    }
}

impl Genome {
    /// What the genome asks for that is not drawn: all of it, in its transforms, their motions, and in the flame.
    pub fn unsupported(&self) -> Unsupported {
        let mut found = self.unsupported_at_once();
        let marked = self.marked();
        for (place, xform) in self.places() {
            for variation in &xform.variations {
                for Undrawn { parameter, value, .. } in variation.undrawn() {
                    found.add(&place, &variation.parameter_attribute(parameter), &value.to_string(), Why::Value);
                }
            }
            for motion in &xform.motions {
                let added = &motion.added;
                // It is read and does nothing, in flam3 too.
                let extra = added.extra.iter().filter(|(name, _)| name != "symmetry").cloned().collect();
                let added = Xform { extra, children: added.children.clone(), ..Xform::default() };
                found.add_xform(&format!("a motion of {place}"), &added, &marked);
            }
        }
        found
    }

    /// The same without motions and values: what matters to this moment. On the way between two values that are drawn, all
    /// are.
    pub(crate) fn unsupported_at_once(&self) -> Unsupported {
        let mut found = Unsupported::default();
        let marked = self.marked();
        for (place, xform) in self.places().filter(|(_, it)| !it.extra.is_empty() || !it.children.is_empty()) {
            found.add_xform(&place, xform, &marked);
        }
        for (name, value) in &self.extra {
            match of_flame(name, value, &self.camera) {
                Meaning::Neutral => {}
                Meaning::Asks(why) => found.add(FLAME, name, value, why),
                Meaning::Unknown => found.without.0.push(Reason::new(FLAME, name, value, Why::Attribute)),
            }
        }
        for Element { tag, text, .. } in self.children.iter().filter(|it| !NEUTRAL_ELEMENTS.contains(&&*it.tag)) {
            let reasons = if tag == "layer" { &mut found.refused } else { &mut found.without };
            reasons.0.push(Reason::new(FLAME, tag, text, Why::Element));
        }
        found
    }

    /// The same genome, to be drawn without its unknown variations: an attribute of its own names them.
    #[must_use]
    pub fn as_far_as_possible(&self) -> Genome {
        let names = self.unsupported().mark();
        let mut genome = self.clone().unmarked();
        genome.extra.extend(names.map(|names| (MARK.to_owned(), names)));
        genome
    }

    /// The genome without its mark.
    #[must_use]
    pub(super) fn unmarked(mut self) -> Genome {
        self.extra.retain(|(name, _)| name != MARK);
        self
    }

    /// A marked genome without its mark and the variations that it names, with their parameters: its picture is the same.
    pub(crate) fn without_left_out(mut self) -> Genome {
        let marked: Vec<String> = self.marked().into_iter().map(str::to_owned).collect();
        let is_of = |name: &str, variation: &String| {
            name.strip_prefix(&**variation).is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
        };
        let is_drawn = |(name, _): &(String, String)| !marked.iter().any(|variation| is_of(name, variation));
        if !marked.is_empty() {
            for xform in self.xforms.iter_mut().chain(&mut self.finals) {
                xform.extra.retain(is_drawn);
                xform.motions.iter_mut().for_each(|motion| motion.added.extra.retain(is_drawn));
            }
        }
        self.unmarked()
    }

    /// What of `extra` and `children` is part of the picture, or a reason to draw none.
    pub(crate) fn drawn_parts(&self) -> (Vec<(String, String)>, Vec<Element>) {
        let is_part = |(name, value): &&(String, String)| {
            name == MARK || matches!(of_flame(name, value, &self.camera), Meaning::Asks(_))
        };
        let extra = self.extra.iter().filter(is_part).cloned().collect();
        (extra, self.children.iter().filter(|child| child.tag == "layer").cloned().collect())
    }

    /// The variations that the mark names.
    fn marked(&self) -> Vec<&str> {
        self.extra.iter().filter(|(name, _)| name == MARK).flat_map(|(_, names)| names.split_whitespace()).collect()
    }

    /// The transforms, by the words for their places.
    fn places(&self) -> impl Iterator<Item = (String, &Xform)> {
        let finals = self.finals.iter().enumerate().map(|(i, xform)| match i {
            0 => ("the final transform".to_owned(), xform),
            _ => (format!("final transform {i}"), xform),
        });
        self.xforms.iter().enumerate().map(|(i, xform)| (format!("transform {i}"), xform)).chain(finals)
    }
}

impl Reason {
    fn new(place: &str, name: &str, value: &str, why: Why) -> Reason {
        Reason { place: place.to_owned(), name: name.to_owned(), value: shown(value.trim()), why }
    }
}

impl Unsupported {
    /// The value of the attribute [`MARK`] of a genome that is to be drawn without its unknown variations: their names, with
    /// blanks between them. `None` if it has none.
    pub fn mark(&self) -> Option<String> {
        let is_of_mark = |reason: &&Reason| matches!(reason.why, Why::LeftOut | Why::Variation);
        let mut names: Vec<&str> = Vec::new();
        for reason in self.without.0.iter().chain(&self.refused.0).filter(is_of_mark) {
            if !names.contains(&&*reason.name) {
                names.push(&reason.name);
            }
        }
        (!names.is_empty()).then(|| names.join(" "))
    }

    /// What is not drawn of the genome with that mark.
    #[must_use]
    pub fn as_far_as_possible(self) -> Unsupported {
        let Unsupported { refused, mut without } = self;
        let (left_out, refused) = refused.0.into_iter().partition(|reason| reason.why == Why::Variation);
        let left_out: Vec<Reason> = left_out;
        without.0.extend(left_out.into_iter().map(|reason| Reason { why: Why::LeftOut, ..reason }));
        Unsupported { refused: Reasons(refused), without }
    }

    /// Adds what is not drawn: what the artist has left out is no reason to refuse a genome.
    fn add(&mut self, place: &str, name: &str, value: &str, why: Why) {
        let reasons = if why == Why::LeftOut { &mut self.without } else { &mut self.refused };
        reasons.0.push(Reason::new(place, name, value, why));
    }

    fn add_xform(&mut self, place: &str, xform: &Xform, marked: &[&str]) {
        let mut unknown = Vec::new();
        for (name, value) in &xform.extra {
            match of_xform(xform, name, value) {
                Meaning::Neutral => {}
                Meaning::Asks(why) => self.add(place, name, value, why),
                Meaning::Unknown => unknown.push((&**name, &**value)),
            }
        }
        let names = Names::of(xform);
        for (name, value) in unknown.into_iter().filter(|(name, _)| !names.is_parameter(name)) {
            let is_number = value.trim().parse::<f64>().is_ok();
            let why = match is_number {
                true if marked.contains(&name) => Why::LeftOut,
                true => Why::Variation,
                false => Why::Attribute,
            };
            self.add(place, name, value, why);
        }
        for Element { tag, text, .. } in &xform.children {
            self.add(place, tag, text, Why::Element);
        }
    }
}

/// The names of a transform's unknown attributes whose values are numbers, each with whether one is not 0.
struct Names<'a>(BTreeMap<&'a str, bool>);

impl<'a> Names<'a> {
    fn of(xform: &'a Xform) -> Names<'a> {
        let mut names = BTreeMap::new();
        for (name, value) in &xform.extra {
            if let Ok(number) = value.trim().parse::<f64>() {
                *names.entry(&**name).or_default() |= number != 0.0;
            }
        }
        Names(names)
    }

    /// Whether `name` is of a parameter of another unknown variation: that one is named instead, or has a weight of 0. One
    /// that has parameters of its own is a variation.
    fn is_parameter(&self, name: &str) -> bool {
        let begins = |end: usize| self.0.get(&name[..end]).copied();
        let variations = name.match_indices('_').filter_map(|(end, _)| begins(end));
        let mut variations = variations.peekable();
        variations.peek().is_some() && (variations.any(|is_drawn| is_drawn) || !self.has_parameters(name))
    }

    fn has_parameters(&self, name: &str) -> bool {
        let start = format!("{name}_");
        self.0.range(&*start..).next().is_some_and(|(next, _)| next.starts_with(&start))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn genome(flame: &str, xforms: &[&str]) -> Genome {
        let xform = |xform: &&str| format!("<xform weight=\"1\" linear=\"1\" {xform}/>");
        Genome::parse(&format!("<flame {flame}>{}</flame>", xforms.iter().map(xform).collect::<String>())).unwrap()
    }

    fn names(reasons: &Reasons) -> Vec<(&str, &str, &str)> {
        reasons.0.iter().map(|reason| (&*reason.place, &*reason.name, reason.why.word())).collect()
    }

    #[test]
    fn every_reason_is_named_with_its_place_and_parameters_are_of_their_variation() {
        let found = genome(
            "post_symmetry_type=\"X_AXIS\" nick=\"ann\" wobble=\"7\"",
            &[
                "waltz=\"0.5\" waltz_beat=\"3\" waltz_fx_priority=\"0\" Polka=\"1\"",
                "reel=\"0\" reel_steps=\"4\" reel_wf=\"1\" reel_wf_n=\"2\" mode=\"fast\" waltz=\"1\"",
            ],
        );
        let found = found.unsupported();
        let expected = [
            ("transform 0", "waltz", "variation"),
            ("transform 0", "Polka", "variation"),
            ("transform 1", "reel_wf", "variation"),
            ("transform 1", "mode", "attribute"),
            ("transform 1", "waltz", "variation"),
            ("the flame", "post_symmetry_type", "effect"),
        ];
        assert_eq!(names(&found.refused), expected);
        assert_eq!(names(&found.without), [("the flame", "wobble", "attribute")]);
        assert_eq!(
            found.refused.to_string(),
            "the variation `waltz` (transform 0 and 1 more), the variation `Polka` (`1`, transform 0), the variation \
             `reel_wf` (`1`, transform 1), the attribute `mode` (`fast`, transform 1), the effect \
             `post_symmetry_type` (`X_AXIS`, the flame)"
        );
        assert_eq!(genome("", &["name=\"arm\""]).unsupported(), Unsupported::default());
    }

    #[test]
    fn many_reasons_are_cut_in_words_and_none_is_lost() {
        let attributes: String = (0..130).map(|number| format!(" waltz{number}x=\"1\"")).collect::<Vec<_>>().concat();
        let found = genome("", &[&attributes]).unsupported().refused;
        assert_eq!(found.0.len(), 130);
        assert!(found.to_string().ends_with("the variation `waltz99x` (`1`, transform 0), and 30 more"), "{found}");
    }

    #[test]
    fn a_marked_genome_is_refused_for_all_but_its_unknown_variations() {
        let plain = genome("contrast=\"2\"", &["waltz=\"0.5\" waltz_beat=\"3\"", "polka=\"1\" waltz=\"2\""]);
        let marked = plain.as_far_as_possible();
        assert_eq!(plain.unsupported().mark().as_deref(), Some("waltz polka"));
        assert_eq!(marked.extra[1], (MARK.to_owned(), "waltz polka".to_owned()));
        let mut hoped = plain.unsupported().as_far_as_possible();
        hoped.without.0.sort_by(|a, b| (&a.place, &a.name).cmp(&(&b.place, &b.name)));
        let read = Genome::parse(&marked.to_xml()).unwrap();
        assert_eq!((&read, read.as_far_as_possible()), (&marked, marked.clone()));
        let found = read.unsupported();
        assert_eq!(names(&found.refused), [("the flame", "contrast", "tone")]);
        assert_eq!(found, hoped);
        let left_out = [("transform 0", "waltz"), ("transform 1", "polka"), ("transform 1", "waltz")];
        assert_eq!(names(&found.without), left_out.map(|(place, name)| (place, name, "left-out")));
        assert_eq!(read.unmarked(), plain);
        let known = genome("", &[""]);
        assert_eq!(known.as_far_as_possible(), known);
    }

    #[test]
    fn what_a_motion_asks_for_is_named_too() {
        let motion = "<motion motion_frequency=\"1\" motion_function=\"sin\" waltz=\"1\"/>";
        let text = format!("<flame><xform weight=\"1\" linear=\"1\">{motion}</xform></flame>");
        let found = Genome::parse(&text).unwrap().unsupported().refused;
        assert_eq!(names(&found), [("a motion of transform 0", "waltz", "variation")]);
    }
}
