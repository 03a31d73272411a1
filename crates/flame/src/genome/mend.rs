//! Texts that are no XML, though programs write them so.
//!
//! Owns their repair before they are parsed: an empty document type, and names of attributes with a `#` or a blank. Each
//! repair keeps the number of bytes, so that every line and column stays. Never changes a text that is XML: the parser
//! comes first.
//!
//! Start at [`mended`].

use std::borrow::Cow;
use std::ops::Range;

/// The beginning of a document type.
const TYPE: &str = "<!DOCTYPE";

/// `text` with what can be mended:
///
/// - A document type without declarations is blanked.
/// - `#N#` in the name of an attribute, by which `JWildfire` numbers a variation that occurs again from 1, becomes a point
///   and N + 1: `bubble#1#_x` becomes `bubble.2_x`.
/// - Blanks in the name of an attribute become `_`.
pub(super) fn mended(text: &str) -> Cow<'_, str> {
    let mut changes: Vec<(Range<usize>, String)> = Vec::new();
    let mut at = 0;
    while let Some(found) = text[at..].find('<') {
        at = markup(text, at + found, &mut changes);
    }
    if changes.is_empty() {
        return Cow::Borrowed(text);
    }
    let (mut mended, mut done) = (String::with_capacity(text.len()), 0);
    for (place, new) in changes {
        mended += &text[done..place.start];
        mended += &new;
        done = place.end;
    }
    Cow::Owned(mended + &text[done..])
}

/// As many bytes as `c` has, without a meaning.
pub(super) fn blanks(c: char) -> impl Iterator<Item = char> {
    std::iter::repeat_n(if c == '\n' { c } else { ' ' }, c.len_utf8())
}

/// Notes what is to be changed in the markup that begins with `<` at byte `start`, and returns the byte after it.
fn markup(text: &str, start: usize, changes: &mut Vec<(Range<usize>, String)>) -> usize {
    let rest = &text[start..];
    let past = |end: &str| rest.find(end).map_or(text.len(), |found| start + found + end.len());
    for (begin, end) in [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>"), ("</", ">")] {
        if rest.starts_with(begin) {
            return past(end);
        }
    }
    if rest.starts_with(TYPE) {
        let Some(end) = empty_type(rest).map(|length| start + length) else { return past(">") };
        changes.push((start..end, text[start..end].chars().flat_map(blanks).collect()));
        return end;
    }
    element(text, start, changes)
}

/// The length of the document type with which `text` begins, if it declares nothing.
fn empty_type(text: &str) -> Option<usize> {
    let end = text.find(['[', '>'])?;
    if text[end..].starts_with('>') {
        return Some(end + 1);
    }
    let close = end + text[end..].find(']')?;
    let after = close + text[close..].find('>')?;
    let is_empty = [&text[end + 1..close], &text[close + 1..after]].iter().all(|part| part.trim().is_empty());
    is_empty.then_some(after + 1)
}

/// The same for the start of an element.
fn element(text: &str, start: usize, changes: &mut Vec<(Range<usize>, String)>) -> usize {
    let ends = |c: char| c.is_ascii_whitespace() || matches!(c, '>' | '/');
    let mut at = start + 1 + text[start + 1..].find(ends).unwrap_or(text.len() - start - 1);
    while let Some(found) = text[at..].find(['"', '\'', '>', '<']) {
        let here = at + found;
        let quote = match text.as_bytes()[here] {
            b'>' => return here + 1,
            b'<' => return here,
            quote => char::from(quote),
        };
        if let Some(before) = text[at..here].trim_end().strip_suffix('=') {
            let name = before.trim();
            let begin = at + (before.len() - before.trim_start().len());
            if let Some(new) = mended_name(name) {
                changes.push((begin..begin + name.len(), new));
            }
        }
        at = text[here + 1..].find(quote).map_or(text.len(), |end| here + 1 + end + 1);
    }
    text.len()
}

/// The name of an attribute that is XML, with blanks after it if it became shorter; `None` if it is XML already, or cannot
/// be mended.
fn mended_name(name: &str) -> Option<String> {
    if !name.contains(|c: char| c == '#' || c.is_ascii_whitespace()) {
        return None;
    }
    let mut new: String = name.chars().map(|c| if c.is_ascii_whitespace() { '_' } else { c }).collect();
    if let [before, number, after] = new.split('#').collect::<Vec<_>>()[..] {
        let number = number.parse::<u16>().ok()?;
        new = format!("{before}.{}{after}", u32::from(number) + 1);
    }
    new.extend(std::iter::repeat_n(' ', name.len().checked_sub(new.len())?));
    (new != name).then_some(new)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_mended_in_its_place_and_nothing_else_is_touched() {
        let text =
            "<a b='#1# c d' bubble#1#=\"2\" x\u{e9}y#99#_at = '3'>#1# =\"\"</a><!-- e#1#=\"\" --><f color mode='1'/>";
        let wanted =
            "<a b='#1# c d' bubble.2 =\"2\" x\u{e9}y.100_at = '3'>#1# =\"\"</a><!-- e#1#=\"\" --><f color_mode='1'/>";
        assert_eq!(mended(text), wanted);
        for whole in ["<a b='#1#' c=\"2 3\"/>", "#1#", "<", "<a", "<a b", "<a b=", "<a #=''/>", "<a b#x#='1'/>"] {
            let mended = mended(whole);
            assert_eq!(mended, whole);
            assert!(matches!(mended, Cow::Borrowed(_)), "{whole}");
        }
    }

    #[test]
    fn a_document_type_is_blanked_where_it_declares_nothing() {
        for (text, wanted) in [
            ("<!DOCTYPE flames>\n<a/>", "                 \n<a/>"),
            ("<!DOCTYPE f SYSTEM 'f.dtd'\n[ ] ><a/>", "                          \n     <a/>"),
        ] {
            assert_eq!(mended(text), wanted);
        }
        let declares = "<!DOCTYPE f [<!ENTITY x 'y'>]><a/>";
        assert_eq!(mended(declares), declares);
    }
}
