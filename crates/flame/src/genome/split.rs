//! The flames of a text.
//!
//! Owns how flames are found, whatever stands around them: under any root or none, in a text of which a part is no XML.
//! `parse.rs` reads each; `mend.rs` repairs what programs write that is no XML.
//!
//! Start at [`Genome::split`].

use std::borrow::Cow;

use roxmltree::Document;

use super::limits::check;
use super::mend::{blanks, mended};
use super::parse::{genome, not_xml, notes};
use super::{Genome, GenomeError, Place};

/// What is put before flames that have no root.
const ROOT: &str = "<flames>";

/// The tag of a flame.
const FLAME: &str = "flame";

/// The tag of `JWildfire`'s flames of several layers.
pub(super) const LAYERED: &str = "jwf-flame";

/// Most flames of a text that are named as unreadable beside those that are read: the place of each is searched from the
/// start of the text, of 16 MiB in 3 ms.
const MOST_WRONG: usize = 100;

/// A flame of a text.
#[derive(Debug, PartialEq)]
pub struct Part<'t> {
    /// Its genome, or why it has none, with the place in the whole text.
    pub genome: Result<Genome, GenomeError>,
    /// Its part of the text, byte for byte, but for what is no XML and could be mended: what a file of this one flame
    /// would hold.
    pub text: Cow<'t, str>,
    /// What was read otherwise than it is written, in words.
    pub notes: Vec<String>,
}

impl Genome {
    /// Reads every `<flame>` of a text, at any depth and under any root, in file order.
    ///
    /// # Errors
    /// [`GenomeError`] names place, attribute and value of the first that cannot be read. A text without flames is an
    /// empty list. A text of more than 16 MiB, 500,000 elements, 1,000,000 attributes or 10,000 flames is refused before
    /// it is parsed, and so are 400 attributes of one element, 10,000 elements in one and 1000 in each other.
    pub fn parse_all(text: &str) -> Result<Vec<Genome>, GenomeError> {
        Self::split(text)?.into_iter().map(|part| part.genome).collect()
    }

    /// Finds every `<flame>` as [`Genome::parse_all`] does, and reads each for itself. Several flames may stand one after
    /// the other without a root, as in Electric Sheep's files, each under an XML declaration of its own. In a text that is
    /// no XML, those flames are read that are XML by themselves; if all are, a last part says what is wrong.
    ///
    /// # Errors
    /// [`GenomeError`] if the text holds more than [`Genome::parse_all`] reads, or is no XML, or the
    /// error of the first unreadable flame after 100 others.
    pub fn split(text: &str) -> Result<Vec<Part<'_>>, GenomeError> {
        check(text)?;
        let error = match Document::parse(text) {
            Ok(document) => return flames(&document, |range| Cow::Borrowed(&text[range]), 0),
            Err(error) => not_xml(&error, Place::START),
        };
        match mended(text) {
            Cow::Borrowed(_) => loose(text, |range| Cow::Borrowed(&text[range]), error),
            Cow::Owned(mended) => {
                let part = |range: Range| Cow::Owned(mended[range].to_owned());
                match Document::parse(&mended) {
                    Ok(document) => flames(&document, part, 0),
                    Err(error) => loose(&mended, part, not_xml(&error, Place::START)),
                }
            }
        }
    }

    /// Reads the one flame of a text.
    ///
    /// # Errors
    /// As [`Genome::parse_all`]; [`GenomeError::Count`] where there is none or more than one.
    pub fn parse(text: &str) -> Result<Genome, GenomeError> {
        let mut flames = Genome::parse_all(text)?;
        match (flames.pop(), flames.len()) {
            (Some(only), 0) => Ok(only),
            (last, rest) => Err(GenomeError::Count { found: rest + usize::from(last.is_some()) }),
        }
    }
}

/// A part of the text by its bytes.
type Range = std::ops::Range<usize>;

/// The flames of `document`, which has so many bytes before those of the text that `part` cuts.
fn flames<'t>(
    document: &Document,
    part: impl Fn(Range) -> Cow<'t, str>,
    before: usize,
) -> Result<Vec<Part<'t>>, GenomeError> {
    let (mut parts, mut wrong) = (Vec::new(), 0);
    for node in document.descendants().filter(|node| [FLAME, LAYERED].iter().any(|tag| node.has_tag_name(*tag))) {
        let genome = counted(&mut wrong, genome(node).map_err(|error| error.moved(Place::START, before)))?;
        let text = part(node.range().start - before..node.range().end - before);
        parts.push(Part { genome, text, notes: notes(node) });
    }
    Ok(parts)
}

/// The flames of a `text` that is no XML for `error`: all of them if it only lacks a root, else those that are XML by
/// themselves, if there are any.
fn loose<'t>(
    text: &str,
    part: impl Fn(Range) -> Cow<'t, str>,
    error: GenomeError,
) -> Result<Vec<Part<'t>>, GenomeError> {
    if let Ok(document) = Document::parse(&rooted(text)) {
        let flames = flames(&document, part, ROOT.len())?;
        return if flames.is_empty() { Err(error) } else { Ok(flames) };
    }
    let (mut parts, mut wrong, mut place, mut seen) = (Vec::new(), 0, Place::START, 0);
    for range in pieces(text) {
        place = place.after(&text[seen..range.start]);
        seen = range.start;
        let piece = &text[range.clone()];
        let (genome, notes) = match Document::parse(piece) {
            Ok(document) => {
                let flame = document.root_element();
                (genome(flame).map_err(|error| error.moved(place, 0)), notes(flame))
            }
            Err(error) => (Err(not_xml(&error, place)), Vec::new()),
        };
        let genome = counted(&mut wrong, genome)?;
        parts.push(Part { genome, text: part(range), notes });
    }
    if wrong == parts.len() {
        return Err(error);
    }
    if wrong == 0 {
        parts.push(Part { genome: Err(error), text: Cow::Borrowed(""), notes: Vec::new() });
    }
    Ok(parts)
}

/// `genome`, counted if it is `wrong`.
/// Errors: What is wrong with it, if too many are.
fn counted(wrong: &mut usize, genome: Result<Genome, GenomeError>) -> Result<Result<Genome, GenomeError>, GenomeError> {
    *wrong += usize::from(genome.is_err());
    if *wrong > MOST_WRONG { genome.map(Ok) } else { Ok(genome) }
}

/// Where flames begin and end in a text that is no XML: each ends with its end tag, or else where the next one begins.
fn pieces(text: &str) -> Vec<Range> {
    let (mut pieces, mut next) = (Vec::new(), start(text, 0));
    while let Some((begin, tag)) = next {
        next = start(text, begin + 1);
        let last = next.map_or(text.len(), |(next, _)| next);
        let end = format!("</{tag}>");
        pieces.push(begin..text[begin..last].find(&end).map_or(last, |found| begin + found + end.len()));
    }
    pieces
}

/// Where the first flame from byte `at` on begins that no comment holds, and its tag.
fn start(text: &str, mut at: usize) -> Option<(usize, &'static str)> {
    loop {
        at += text[at..].find('<')?;
        let rest = &text[at..];
        let is_tag = |tag: &&str| rest[1..].strip_prefix(*tag).is_some_and(|rest| rest.starts_with(AFTER_TAG));
        if let Some(tag) = [FLAME, LAYERED].into_iter().find(is_tag) {
            return Some((at, tag));
        }
        at += if rest.starts_with("<!--") { rest.find("-->")? } else { 1 };
    }
}

/// What may stand behind a tag.
const AFTER_TAG: [char; 6] = [' ', '\t', '\r', '\n', '>', '/'];

/// `text` in a root, with blanks in place of its XML declarations: other bytes keep their lines and their order.
fn rooted(text: &str) -> String {
    let mut rooted = ROOT.to_owned();
    let mut rest = text;
    while let Some(((before, after), end)) =
        rest.split_once("<?xml").and_then(|parts| Some((parts, parts.1.find("?>")?)))
    {
        let (declaration, after) = after.split_at(end + "?>".len());
        rooted += before;
        rooted.extend("<?xml".chars().chain(declaration.chars()).flat_map(blanks));
        rest = after;
    }
    rooted + rest + "</flames>"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flame(name: &str) -> String {
        format!("<flame name=\"{name}\">\n<xform weight=\"1\" linear=\"1\"/></flame>")
    }

    #[test]
    fn flames_without_a_root_are_read_as_those_in_one_with_their_own_bytes_and_lines() {
        let (first, second) = (flame("a"), flame("b\u{e9}"));
        let declared = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
        for text in [
            format!("{first}\n{second}\n"),
            format!("{declared}{first}{declared}{second}"),
            format!("<get id=\"7\">{declared}{first}\n{second}</get>"),
            format!("<?xml\n version=\"1.0\"?>{first}<!-- between -->{second}"),
        ] {
            let found: Vec<_> = Genome::split(&text).unwrap().into_iter().map(|part| part.text).collect();
            assert_eq!(found, [first.as_str(), second.as_str()], "{text}");
        }
        let wrong = format!("{first}\n{}", second.replace("weight=\"1\"", "weight=\"x\""));
        assert!(matches!(
            Genome::parse_all(&wrong),
            Err(GenomeError::Attribute { place: Place { line: 4, column: 8 }, .. })
        ));
        let first_wrong = "<flame time=\"x\"/><flame/>";
        assert!(matches!(
            Genome::parse_all(first_wrong),
            Err(GenomeError::Attribute { place: Place { line: 1, column: 8 }, .. })
        ));
        for broken in ["", "no flame", "<a/><b/>", "<flame/><flame>", "<?xml", "<flame/><?xml"] {
            assert!(matches!(Genome::parse_all(broken), Err(GenomeError::Xml { .. })), "{broken}");
        }
    }

    #[test]
    fn a_bad_flame_is_named_and_those_beside_it_are_read() {
        let (first, last) = (flame("a"), flame("c"));
        for (bad, wanted) in [
            ("<flame size=\"x\"/>", "line 3, column 8: attribute `size` of `flame` is `x`, expected two whole numbers"),
            (
                "<jwf-flame>\n<layer/><layer/></jwf-flame>",
                "line 3, column 1: a `jwf-flame` has layers, which are not drawn, expected a `flame`, or one visible layer \
                 of weight 1 and density 1",
            ),
            ("<flame><xform></flame>", "not well-formed XML: expected 'xform' tag, not 'flame' at 3:15"),
            (" <flame a=\"1\" a=\"2\"/>", "not well-formed XML: attribute 'a' at 3:15 is already defined"),
        ] {
            for (before, after) in [("<?xml version=\"1.0\"?><f>", "</f>"), ("<f>", ""), ("", "")] {
                let text = format!("{before}{first}\n{bad}{last}{after}");
                let parts = Genome::split(&text).unwrap();
                let found: Vec<_> =
                    parts.iter().map(|part| part.genome.as_ref().ok().and_then(|it| it.name.as_deref())).collect();
                assert_eq!(found, [Some("a"), None, Some("c")], "{text}");
                assert_eq!(parts[1].genome.as_ref().unwrap_err().to_string(), wanted, "{text}");
                assert_eq!([&*parts[0].text, &*parts[2].text], [&*first, &*last], "{text}");
                assert_eq!(Genome::parse_all(&text).unwrap_err().to_string(), wanted, "{text}");
            }
        }
    }

    #[test]
    fn a_hundred_bad_flames_are_named_and_the_next_one_refuses_the_file() {
        let of = |bad: usize| format!("<f>{}{}</f>", flame("a"), "\n<flame size='x'/>".repeat(bad));
        let text = of(100);
        let parts = Genome::split(&text).unwrap();
        assert_eq!(parts.iter().filter(|part| part.genome.is_err()).count(), 100);
        let refused = Genome::split(&of(101)).unwrap_err().to_string();
        assert!(refused.starts_with("line 103, column 8: attribute `size`"), "{refused}");
    }

    #[test]
    fn damage_between_flames_is_named_after_them() {
        let text = format!("<f>{}</g>{}", flame("a"), flame("b"));
        let parts = Genome::split(&text).unwrap();
        let found: Vec<bool> = parts.iter().map(|part| part.genome.is_ok()).collect();
        assert_eq!(found, [true, true, false]);
        assert!(matches!(Genome::parse_all(&text), Err(GenomeError::Xml { .. })));
    }

    #[test]
    fn what_is_mended_is_read_and_keeps_its_places() {
        let text = "<!DOCTYPE flames>\n<flames><flame><xform weight=\"1\" bubble#1#_waltz=\"1\"/></flame>\n<flame x#1#='' time='x'/></flames>";
        let parts = Genome::split(text).unwrap();
        assert_eq!(parts[0].genome.as_ref().unwrap().xforms.len(), 1);
        assert_eq!(parts[0].text, "<flame><xform weight=\"1\" bubble.2_waltz =\"1\"/></flame>");
        assert!(matches!(parts[1].genome, Err(GenomeError::Attribute { place: Place { line: 3, column: 16 }, .. })));
    }
}
