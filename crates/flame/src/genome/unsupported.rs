//! What a genome asks for that is not drawn.
//!
//! Owns the list of all reasons for which a genome is refused, and of what is drawn without. `attributes.rs` has the
//! tables, `names.rs` distinguishes parameters from variations, and `mark.rs` leaves both out. Never draws.
//!
//! Start at [`Genome::unsupported`].

use std::fmt::{self, Display, Formatter};

use super::attributes::{Meaning, of_flame, of_xform};
use super::names::Names;
use super::parse::shown;
use super::{Element, Genome, MARK, Wave, Xform};
use variations::{Undrawn, Variation};

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
    /// Of an unknown parameter, the variation that has it, as the file calls that.
    pub variation: Option<String>,
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
    /// Motion along curves, of which one moment is drawn.
    Frame,
    /// An unknown variation that the artist has left out, or an unknown parameter with whose variation that was done.
    LeftOut,
    /// A variation at another place among those of its transform.
    Order,
    /// Cells at the places where the program's table of random numbers puts them.
    Places,
    /// An unknown parameter of a known variation.
    Parameter,
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
            Why::Frame => "frame",
            Why::LeftOut => "left-out",
            Why::Order => "order",
            Why::Parameter => "parameter",
            Why::Places => "places",
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
            Why::Frame => "the motion before and after",
            Why::LeftOut | Why::Variation => "the variation",
            Why::Order => "the priority",
            Why::Parameter => "the parameter",
            Why::Places => "the same places of cells for",
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
        for (at, (reason, places)) in groups.iter().take(MOST_NAMES).enumerate() {
            let before = if at > 0 { ", " } else { "" };
            let (place, expected) = (places[0], reason.expected());
            write!(f, "{before}{} (", reason.words())?;
            match places.len() - 1 {
                0 => write!(f, "`{}`, {place}{expected})", reason.value)?,
                others => write!(f, "{place} and {others} more{expected})")?,
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
                if let Some((parameter, value)) = variation.placed_otherwise() {
                    let name = variation.parameter_attribute(parameter);
                    found.without.0.push(Reason::new(&place, &name, &value.to_string(), Why::Places));
                }
            }
            for motion in &xform.motions {
                let added = &motion.added;
                // It is read and does nothing, in flam3 too.
                let extra = added.extra.iter().filter(|(name, _)| name != "symmetry").cloned().collect();
                let added = Xform { extra, children: added.children.clone(), ..Xform::default() };
                found.add_xform(&format!("a motion of {place}"), &added, xform, &marked);
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
            found.add_xform(&place, xform, xform, &marked);
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

    /// What of `extra` and `children` is part of the picture, or a reason to draw none.
    pub(crate) fn drawn_parts(&self) -> (Vec<(String, String)>, Vec<Element>) {
        let is_part = |(name, value): &&(String, String)| {
            name == MARK || matches!(of_flame(name, value, &self.camera), Meaning::Asks(_))
        };
        let extra = self.extra.iter().filter(is_part).cloned().collect();
        (extra, self.children.iter().filter(|child| child.tag == "layer").cloned().collect())
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
        Reason { place: place.to_owned(), name: name.to_owned(), value: shown(value.trim()), variation: None, why }
    }

    /// What is not drawn.
    fn words(&self) -> String {
        let name = shown(&self.name);
        let Some(variation) = &self.variation else { return format!("{} `{name}`", self.why.noun()) };
        let parameter = shown(self.name[variation.len()..].trim_start_matches('_'));
        if self.why == Why::LeftOut {
            format!("the variation `{variation}`, whose parameter `{parameter}` is unknown")
        } else {
            format!("the unknown parameter `{parameter}` of the variation `{variation}`")
        }
    }

    /// What would be drawn instead of a priority.
    fn expected(&self) -> &'static str {
        if self.why == Why::Order { "; expected a whole number" } else { "" }
    }
}

impl Unsupported {
    /// The value of the attribute [`MARK`] of a genome that is to be drawn without its unknown variations, and without the
    /// variations of its unknown parameters: the names of both, with blanks between them. `None` if it has none.
    pub fn mark(&self) -> Option<String> {
        let is_of_mark = |reason: &&Reason| matches!(reason.why, Why::LeftOut | Why::Parameter | Why::Variation);
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
        let is_of_mark = |reason: &Reason| matches!(reason.why, Why::Parameter | Why::Variation);
        let (left_out, refused) = refused.0.into_iter().partition(is_of_mark);
        let left_out: Vec<Reason> = left_out;
        without.0.extend(left_out.into_iter().map(|reason| Reason { why: Why::LeftOut, ..reason }));
        Unsupported { refused: Reasons(refused), without }
    }

    /// Adds what is not drawn: what the artist has left out is no reason to refuse a genome, nor is a motion of which one
    /// moment is drawn.
    fn add(&mut self, place: &str, name: &str, value: &str, why: Why) {
        let reasons = if matches!(why, Why::Frame | Why::LeftOut) { &mut self.without } else { &mut self.refused };
        reasons.0.push(Reason::new(place, name, value, why));
    }

    /// Adds what is not drawn of `xform`, which is `own` or a motion of it.
    fn add_xform(&mut self, place: &str, xform: &Xform, own: &Xform, marked: &[&str]) {
        let mut unknown = Vec::new();
        for (name, value) in &xform.extra {
            match of_xform(xform, name, value) {
                Meaning::Neutral => {}
                Meaning::Asks(why) => self.add(place, name, value, why),
                Meaning::Unknown => unknown.push((&**name, &**value)),
            }
        }
        if !unknown.is_empty() {
            let names = Names::of(&xform.extra, own);
            for (name, value) in unknown.into_iter().filter(|(name, _)| !names.is_of_unknown(name)) {
                let is_marked = marked.contains(&name);
                match names.parameter(name) {
                    Some(parameter) if own.uses(&parameter.variation) => {
                        self.add_parameter(Reason::new(place, name, value, Why::Parameter), parameter.of, is_marked);
                    }
                    Some(_) => {}
                    None if value.trim().parse::<f64>().is_err() => self.add(place, name, value, Why::Attribute),
                    None if is_marked => self.add(place, name, value, Why::LeftOut),
                    None => self.add(place, name, value, Why::Variation),
                }
            }
        }
        for Element { tag, text, .. } in &xform.children {
            self.add(place, tag, text, Why::Element);
        }
    }

    fn add_parameter(&mut self, reason: Reason, of: &str, is_marked: bool) {
        let reason = Reason { variation: Some(of.to_owned()), ..reason };
        if is_marked {
            self.without.0.push(Reason { why: Why::LeftOut, ..reason });
        } else {
            self.refused.0.push(reason);
        }
    }
}

impl Xform {
    /// Whether `variation`, which is one of its own, is drawn at some time, or would be if it were not left out.
    fn uses(&self, variation: &Variation) -> bool {
        let moves = |motion: &Wave| {
            let Xform { variations, left_out, .. } = &motion.added;
            variations.iter().chain(left_out).any(|it| it.kind == variation.kind && it.weight != 0.0)
        };
        variation.weight != 0.0 || self.motions.iter().any(moves)
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
