//! Palettes by number: colours that a genome names and a library has.
//!
//! Owns the reading of a library in the form of flam3's `flam3-palettes.xml`, and the choice from it. Never opens a file
//! and has no palettes itself: the library is whatever the user has installed.
//!
//! Start at [`Library::parse`], then [`Genome::with_library`].

use std::collections::BTreeMap;

use roxmltree::{Document, Node};

use super::limits::check;
use super::palette::{from_hsv, to_hsv};
use super::palette_xml::{hex, index};
use super::parse::{not_xml, place, shown};
use super::{Element, Genome, GenomeError, Palette, Place};

/// The digits of a colour in a library, of which the first two mean nothing.
const DIGITS: usize = 8;

/// Palettes by their number.
#[derive(Clone, Debug, PartialEq)]
pub struct Library {
    palettes: BTreeMap<i32, Palette>,
}

/// `<palette index0 index1 hue0 hue1 blend>`: a blend of two palettes of a library.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaletteBlend {
    /// `index0` and `index1`: the numbers of the two.
    pub numbers: [i32; 2],
    /// `hue0` and `hue1`: how far the hue of each is turned, in whole turns.
    pub hues: [f64; 2],
    /// `blend`: how much of the second is in it, `0.0..=1.0`.
    pub blend: f64,
}

impl Library {
    /// Reads every `<palette number data>` of a text.
    ///
    /// # Errors
    /// [`GenomeError`] names place and value of what is no palette.
    pub fn parse(text: &str) -> Result<Library, GenomeError> {
        check(text)?;
        let document = Document::parse(text).map_err(|error| not_xml(&error, Place::START))?;
        let mut palettes = BTreeMap::new();
        for node in document.descendants().filter(|node| node.has_tag_name("palette")) {
            let entries = hex(node, node.attribute("data").unwrap_or_default(), DIGITS, 2)?;
            palettes.insert(index(node, "number")?, Palette::resampled(&entries));
        }
        Ok(Library { palettes })
    }

    fn palette(&self, number: i32, hue: f64) -> Result<Palette, GenomeError> {
        let missing = GenomeError::NoSuchPalette { number, found: self.palettes.len() };
        let palette = self.palettes.get(&number).ok_or(missing)?;
        let turned = |[red, green, blue, alpha]: [f64; 4]| {
            let [h, s, v] = to_hsv([red, green, blue]);
            let [red, green, blue] = from_hsv([h + 6.0 * hue, s, v]);
            [red, green, blue, alpha]
        };
        Ok(Palette::from_fn(|i| turned(palette.entries[i])))
    }
}

impl Genome {
    /// Whether its colours are in a library only.
    pub fn needs_library(&self) -> bool {
        let is_named = self.palette_number.is_some_and(|number| number >= 0);
        self.palette.is_none() && (is_named || self.palette_blend.is_some())
    }

    /// The same genome with the colours that it names in `library`, their hue turned as it says. One that has colours of
    /// its own keeps them, so that its picture does not depend on what is installed.
    ///
    /// # Errors
    /// [`GenomeError::NoSuchPalette`] if the library does not have the number.
    pub fn with_library(&self, library: &Library) -> Result<Genome, GenomeError> {
        let mut genome = self.clone();
        if !self.needs_library() {
            return Ok(genome);
        }
        genome.palette = match (self.palette_number.filter(|number| *number >= 0), self.palette_blend) {
            (Some(number), _) => Some(library.palette(number, self.hue)?),
            (None, Some(PaletteBlend { numbers: [first, second], hues, blend })) => {
                let [first, second] = [library.palette(first, hues[0])?, library.palette(second, hues[1])?];
                Some(Palette::from_fn(|i| blended(first.entries[i], second.entries[i], blend)))
            }
            (None, None) => None,
        };
        Ok(genome)
    }
}

impl PaletteBlend {
    /// Whether the element names palettes of a library.
    pub(super) fn is_in(node: Node) -> bool {
        node.has_attribute("index0") || node.has_attribute("index1")
    }

    /// Reads the element; a number that is missing is the other one.
    pub(super) fn read(node: Node) -> Result<PaletteBlend, GenomeError> {
        let first = if node.has_attribute("index0") { "index0" } else { "index1" };
        let second = if node.has_attribute("index1") { "index1" } else { "index0" };
        let number = |name: &str| {
            let value = node.attribute(name).unwrap_or("0");
            let found = value.trim().parse().ok().filter(|number: &f64| number.is_finite());
            found.ok_or_else(|| GenomeError::Attribute {
                place: place(node),
                element: "palette".into(),
                attribute: name.into(),
                value: shown(value),
                expected: "a finite number",
            })
        };
        Ok(PaletteBlend {
            numbers: [index(node, first)?, index(node, second)?],
            hues: [number("hue0")?, number("hue1")?],
            blend: number("blend")?,
        })
    }

    /// The element that reads back as this blend.
    pub(super) fn element(&self) -> Element {
        let mut element = Element { tag: "palette".into(), ..Element::default() };
        element.set("index0", self.numbers[0]);
        element.set("index1", self.numbers[1]);
        element.set("hue0", self.hues[0]);
        element.set("hue1", self.hues[1]);
        element.set("blend", self.blend);
        element
    }
}

/// From one colour to the other by hue, saturation and value, the hue taking the shorter way round.
fn blended(a: [f64; 4], b: [f64; 4], part: f64) -> [f64; 4] {
    let [from, to] = [a, b].map(|[red, green, blue, _]| to_hsv([red, green, blue]));
    let way = (to[0] - from[0] + 3.0).rem_euclid(6.0) - 3.0;
    let mixed = |i: usize| from[i] * (1.0 - part) + to[i] * part;
    let [red, green, blue] = from_hsv([from[0] + way * part, mixed(1), mixed(2)]);
    [red, green, blue, 255.0]
}
