//! How much a text may hold that is read as XML.
//!
//! Owns the limits and the count that is held against them. The XML parser compares each attribute with all others of its
//! element and keeps about 100 bytes for each element and each attribute, so everything is counted before it starts. What
//! passes takes 255 MB of memory and 1 s of a processor at most, measured on texts that are as large as may be in one way
//! each: the most memory by kept elements of one attribute, the most time by elements of 399 attributes. Never judges
//! whether the text is XML: the parser does. Up to the first error both see the same elements.
//!
//! Start at [`check`].

use super::{GenomeError, Place};

/// Most bytes of a text. Real flames have 2,000 to 100,000, archives of many flames some millions.
pub(super) const TEXT: usize = 16 << 20;

/// Most elements. A text of real flames that is as long as it may be has 410,000: a `<color>` takes 41 bytes.
pub(super) const ELEMENTS: usize = 500_000;

/// Most attributes of all elements together.
pub(super) const ATTRIBUTES: usize = 1_000_000;

/// Most attributes of one element. A transform with every variation and every parameter has about 230.
pub(super) const ATTRIBUTES_EACH: usize = 400;

/// Most flames. The colours of each take 8 kB of memory, however short its text is.
pub(super) const FLAMES: usize = 10_000;

/// Most elements in one element, or beside each other where there is no root.
pub(super) const SIBLINGS: usize = 10_000;

/// How deep elements may lie in others: genealogies are a nested element for each generation.
pub(super) const DEPTH: usize = 1000;

/// Most declarations of XML namespaces. The parser copies them to every element, and flames need none.
pub(super) const NAMESPACES: usize = 16;

/// Refuses a text that holds more than may be read.
/// Errors: [`GenomeError::Limit`] names what is too much, and the place where the limit is passed first.
pub(super) fn check(text: &str) -> Result<(), GenomeError> {
    let mut count = Count::new();
    count.bytes.see(text.len(), TEXT);
    if count.bytes.passed.is_none() {
        count.read(text);
    }
    let passed = |meter: &Meter| meter.passed.map(|at| (at, meter.what, meter.found, meter.most));
    match count.meters().into_iter().filter_map(passed).min() {
        Some((at, what, found, most)) => Err(GenomeError::Limit { place: Place::of(text, at), what, found, most }),
        None => Ok(()),
    }
}

/// The largest number of something, and where it first was too large.
struct Meter {
    what: &'static str,
    most: usize,
    found: usize,
    passed: Option<usize>,
}

impl Meter {
    fn new(what: &'static str, most: usize) -> Meter {
        Meter { what, most, found: 0, passed: None }
    }

    /// There are `found` of it at byte `at`.
    fn see(&mut self, found: usize, at: usize) {
        self.found = self.found.max(found);
        if found > self.most {
            self.passed.get_or_insert(at);
        }
    }

    /// There is one more of it at byte `at`.
    fn add(&mut self, at: usize) {
        self.see(self.found + 1, at);
    }
}

/// What a text holds.
struct Count {
    bytes: Meter,
    elements: Meter,
    attributes: Meter,
    attributes_each: Meter,
    flames: Meter,
    siblings: Meter,
    depth: Meter,
    namespaces: Meter,
    /// For each open element, outermost first, how many elements were found in it; that of the text itself is the first.
    open: Vec<usize>,
}

impl Count {
    fn new() -> Count {
        Count {
            bytes: Meter::new("bytes of text", TEXT),
            elements: Meter::new("elements", ELEMENTS),
            attributes: Meter::new("attributes", ATTRIBUTES),
            attributes_each: Meter::new("attributes of one element", ATTRIBUTES_EACH),
            flames: Meter::new("flames", FLAMES),
            siblings: Meter::new("elements in one element", SIBLINGS),
            depth: Meter::new("elements nested in each other", DEPTH),
            namespaces: Meter::new("XML namespaces", NAMESPACES),
            open: vec![0],
        }
    }

    fn meters(&self) -> [&Meter; 8] {
        [
            &self.bytes,
            &self.elements,
            &self.attributes,
            &self.attributes_each,
            &self.flames,
            &self.siblings,
            &self.depth,
            &self.namespaces,
        ]
    }

    fn read(&mut self, text: &str) {
        let mut at = 0;
        while let Some(found) = text[at..].find('<') {
            at = self.markup(text, at + found);
        }
    }

    /// Reads what begins with `<` at byte `start` and returns the byte after it.
    fn markup(&mut self, text: &str, start: usize) -> usize {
        let past = |begin: usize, end: &str| {
            let begin = start + begin;
            text[begin..].find(end).map_or(text.len(), |found| begin + found + end.len())
        };
        let rest = &text[start..];
        for (begin, end) in [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>"), ("<!", ">")] {
            if rest.starts_with(begin) {
                return past(begin.len(), end);
            }
        }
        if rest.starts_with("</") {
            if self.open.len() > 1 {
                self.open.pop();
            }
            return past("</".len(), ">");
        }
        self.element(text, start)
    }

    /// Reads the start of an element.
    fn element(&mut self, text: &str, start: usize) -> usize {
        self.elements.add(start);
        let ends = |c: char| c.is_ascii_whitespace() || matches!(c, '>' | '/');
        let tag = text[start + 1..].split(ends).next().unwrap_or_default();
        if tag == "flame" {
            self.flames.add(start);
        }
        if let Some(siblings) = self.open.last_mut() {
            *siblings += 1;
            self.siblings.see(*siblings, start);
        }
        self.depth.see(self.open.len(), start);
        let (mut at, mut attributes) = (start + 1 + tag.len(), 0);
        while let Some(found) = text[at..].find(['"', '\'', '>', '<']) {
            let here = at + found;
            match text.as_bytes()[here] {
                b'>' => {
                    if !text[at..here].ends_with('/') {
                        self.open.push(0);
                    }
                    return here + 1;
                }
                b'<' => return here,
                quote => {
                    let name = text[at..here].trim_start();
                    attributes += 1;
                    self.attributes.add(here - name.len());
                    self.attributes_each.see(attributes, here - name.len());
                    if name.starts_with("xmlns") {
                        self.namespaces.add(here - name.len());
                    }
                    let value = here + 1;
                    let end = text[value..].find(char::from(quote));
                    at = end.map_or(text.len(), |end| value + end + 1);
                }
            }
        }
        text.len()
    }
}
