//! Where edits go in the text.
//!
//! Owns the bytes of each edit: those that a changed value replaces, those removed with an entry, and the position and
//! formatting of a new entry (that of the last one of its kind).
//!
//! Start at [`text`]. Existing entries are changed first, new ones are then inserted into the result.

use std::iter;
use std::ops::Range;

use super::layout::{Entries, Field, Form, Layout, comma, fields};
use super::render::Pair;
use super::splice::Splice;
use super::{Edit, Kind};

/// `text`, which is that of `edit`, with all edits made.
///
/// # Panics
/// If the parsers of manifest and layout find different entries, which is a bug.
pub(super) fn text(edit: &Edit, text: String) -> String {
    let layout = Layout::of(&text);
    let kinds = [Kind::Sheep, Kind::Transition];
    let mut splice = Splice::of(kinds.iter().map(|kind| edit.changes.count(*kind)).sum());
    let mut gone = Vec::new();
    for kind in kinds {
        let entries = layout.entries(kind);
        assert_eq!(entries.spans.len(), edit.changes.entry_count(kind), "entries");
        let mut stays = vec![false; entries.spans.len()];
        edit.origins(kind).iter().flatten().for_each(|at| stays[*at as usize] = true);
        change_entries(edit, &text, &layout, kind, &mut splice);
        if let Form::Inline(_) = entries.form {
            cut_in_array(&text, entries, &stays, &mut splice);
        } else {
            gone.extend(entries.spans.iter().zip(stays).filter(|(_, stays)| !stays).map(|(span, _)| span.clone()));
        }
    }
    cut_below(&text, gone, &mut splice);
    drop(layout);
    kinds.into_iter().fold(splice.join(text), |text, kind| {
        let added = edit.added(kind);
        if added.is_empty() { text } else { add_entries(text, kind, &added) }
    })
}

/// Changes the values of the entries of `kind` that stay.
fn change_entries(edit: &Edit, text: &str, layout: &Layout, kind: Kind, splice: &mut Splice) {
    let spans = &layout.entries(kind).spans;
    for (at, entry) in edit.origins(kind).iter().enumerate() {
        let Some(entry) = *entry else { continue };
        let keys = edit.changes.of(kind, entry);
        let changes: Vec<Change> =
            keys.map(|key| Change { key, value: edit.value(kind, at, kind.keys()[key]) }).collect();
        if !changes.is_empty() {
            change_entry(text, layout.newline, &spans[entry as usize], kind.keys(), &changes, splice);
        }
    }
}

/// A changed key of an entry.
struct Change {
    /// Its place in the order of writing.
    key: usize,
    /// What becomes of its value; `None` if it is removed.
    value: Option<String>,
}

/// Changes the values of the entry at `span`; `changes` are by the place of their key in `keys`.
fn change_entry(
    text: &str,
    newline: &str,
    span: &Range<usize>,
    keys: &[&str],
    changes: &[Change],
    splice: &mut Splice,
) {
    let headed = text[span.clone()].starts_with('[');
    let fields = fields(text, span);
    let place = |field: &Field| keys.iter().position(|key| *key == field.name).unwrap_or_default();
    let goes = |field: &Field| changes.iter().any(|change| change.value.is_none() && change.key == place(field));
    for Change { key, value } in changes {
        let stands = fields.iter().find(|field| place(field) == *key);
        match (stands, value) {
            (Some(field), Some(value)) => splice.put(field.value.clone(), value),
            (Some(field), None) if headed => splice.cut(whole_line(text, field.key.start..field.end)),
            (Some(field), None) => cut_field(text, field, splice),
            (None, None) => {}
            (None, Some(value)) => {
                // Behind the nearest key that is written before it.
                let before = |field: &&Field| place(field) < *key && !goes(field);
                let Some(anchor) = fields.iter().filter(before).max_by_key(|field| place(field)) else { continue };
                let key = keys[*key];
                let (at, lead) = if headed {
                    (line_end(text, anchor.end), format!("{newline}{}", indent(text, anchor.key.start)))
                } else {
                    (anchor.value.end, ", ".to_owned())
                };
                splice.put(at..at, &(lead + &Style::of(text, Some(anchor)).pair(key, value)));
            }
        }
    }
}

/// Cuts a key and its value from an entry in braces, with one comma.
fn cut_field(text: &str, field: &Field, splice: &mut Splice) {
    match &field.commas {
        (_, Some(behind)) => splice.cut(field.key.start..skip_blanks(text, behind.end)),
        (before, None) => {
            if let Some(before) = before {
                splice.cut(before.clone());
            }
            splice.cut(blanks_before(text, field.key.start)..field.value.end);
        }
    }
}

/// Cuts the entries with headers that stand at `spans`; neighbours go as one.
fn cut_below(text: &str, mut spans: Vec<Range<usize>>, splice: &mut Splice) {
    spans.sort_by_key(|span| span.start);
    let mut run: Option<Range<usize>> = None;
    for span in spans {
        match &mut run {
            Some(run) if text[run.end..span.start].trim().is_empty() => run.end = span.end,
            Some(run) => splice.cut(with_gap(text, std::mem::replace(run, span))),
            None => run = Some(span),
        }
    }
    if let Some(run) = run {
        splice.cut(with_gap(text, run));
    }
}

/// Cuts the entries of an array that do not stay.
fn cut_in_array(text: &str, entries: &Entries, stays: &[bool], splice: &mut Splice) {
    for (at, span) in entries.spans.iter().enumerate().filter(|(at, _)| !stays[*at]) {
        let end = comma(text, entries.gap(at)).map_or(span.end, |comma| comma.end);
        let start = blanks_before(text, span.start);
        // The last of a line takes the blanks before it, every other one those behind it.
        let ends_line = at + 1 == entries.spans.len() && !text[..start].ends_with('\n');
        let cut = if ends_line { start..end } else { span.start..skip_blanks(text, end) };
        splice.cut(line_if_alone(text, cut));
    }
    // An array that ended without a comma ends without one again.
    if let Some(last) = stays.iter().rposition(|stays| *stays)
        && last + 1 < stays.len()
        && comma(text, entries.gap(stays.len() - 1)).is_none()
        && let Some(comma) = comma(text, entries.gap(last))
    {
        let next = entries.spans[last + 1].start;
        let end = skip_blanks(text, comma.end);
        splice.cut(comma.start..if end == next { end } else { comma.end });
    }
}

/// The lines of an entry with a header, and one of two blank lines that parted it from its neighbours.
fn with_gap(text: &str, span: Range<usize>) -> Range<usize> {
    let mut lines = whole_line(text, span);
    let above = text[..lines.start].lines().next_back().map_or("", str::trim);
    let below = text[lines.end..].lines().next().map(str::trim);
    match below {
        Some("") if above.is_empty() => lines.end = next_line(text, lines.end),
        None if !text.ends_with('\n') => lines.start -= newline_before(text, lines.start),
        None if above.is_empty() => lines.start = line_start(text, lines.start.saturating_sub(1)),
        Some(_) | None => {}
    }
    lines
}

/// Adds entries of `kind` to `text`.
fn add_entries(text: String, kind: Kind, added: &[Vec<Pair>]) -> String {
    let layout = Layout::of(&text);
    let entries = layout.entries(kind);
    let mut splice = Splice::default();
    match &entries.form {
        Form::Inline(array) => add_in_array(&text, entries, array, layout.newline, added, &mut splice),
        Form::Absent | Form::Headed => add_below(&text, kind, &layout, added, &mut splice),
    }
    splice.join(text)
}

/// Adds entries under headers, below the last one of their kind or at the end.
fn add_below(text: &str, kind: Kind, layout: &Layout, added: &[Vec<Pair>], splice: &mut Splice) {
    let newline = layout.newline;
    let last = layout.entries(kind).spans.last();
    let (header_indent, hand, parted) = match last {
        Some(span) => {
            let above = text[..line_start(text, span.start)].lines().next_back();
            let parted = above.is_none_or(|line| line.trim().is_empty() || line.trim_start().starts_with('#'));
            (indent(text, span.start), Style::of(text, fields(text, span).first()), parted)
        }
        None => ("", Style::default(), true),
    };
    let gap = if parted { newline } else { "" };
    let block = |pairs: &Vec<Pair>| {
        let header = format!("{gap}{header_indent}[[{}]]", kind.name());
        let lines = pairs.iter().map(|(key, value)| format!("{}{}", hand.indent, hand.pair(key, value)));
        iter::once(header).chain(lines).collect::<Vec<_>>().join(newline)
    };
    let blocks = added.iter().map(block).collect::<Vec<_>>().join(newline);
    if let Some(span) = last {
        let at = end_of_notes(text, span.end);
        splice.put(at..at, &format!("{newline}{blocks}"));
    } else {
        let ended = if text.is_empty() || text.ends_with('\n') { "" } else { newline };
        splice.put(text.len()..text.len(), &format!("{ended}{blocks}{newline}"));
    }
}

/// Adds entries to an array of entries in braces.
fn add_in_array(
    text: &str,
    entries: &Entries,
    array: &Range<usize>,
    newline: &str,
    added: &[Vec<Pair>],
    splice: &mut Splice,
) {
    let last = entries.spans.last();
    let first_field = last.and_then(|span| fields(text, span).into_iter().next());
    let hand = first_field.as_ref().map_or_else(Style::default, |field| Style::of(text, Some(field)));
    let pad = match (last, &first_field) {
        (Some(span), Some(field)) if field.key.start == span.start + 1 => "",
        _ => " ",
    };
    let entry = |pairs: &Vec<Pair>| {
        let pairs: Vec<_> = pairs.iter().map(|(key, value)| hand.pair(key, value)).collect();
        format!("{{{pad}{}{pad}}}", pairs.join(", "))
    };
    let added: Vec<String> = added.iter().map(entry).collect();
    let Some(last) = last else {
        let at = array.start + 1;
        return splice.put(at..at, &added.join(", "));
    };
    let closing = comma(text, entries.gap(entries.spans.len() - 1));
    let ended = closing.as_ref().map_or(last.end, |comma| comma.end);
    if line_start(text, last.start) + indent(text, last.start).len() == last.start {
        // One to a line: below the last one, and below the comment beside it.
        let rest = &text[ended..array.end - 1];
        let line = rest.split('\n').next().unwrap_or_default();
        let at = if rest.contains('\n') { ended + line.trim_end().len() } else { ended };
        let lead = format!("{newline}{}", indent(text, last.start));
        let closing_comma = if closing.is_some() { "," } else { "" };
        if closing.is_none() {
            splice.put(last.end..last.end, ",");
        }
        splice.put(at..at, &format!("{lead}{}{closing_comma}", added.join(&format!(",{lead}"))));
    } else if closing.is_some() {
        splice.put(ended..ended, &format!(" {},", added.join(", ")));
    } else {
        splice.put(ended..ended, &format!(", {}", added.join(", ")));
    }
}

/// The formatting of keys: the text before them and around the `=`.
struct Style {
    indent: String,
    /// From the start of a key to its `=`.
    column: usize,
    /// Whether there is a blank before the `=`, and what is behind it.
    blank: bool,
    behind: String,
}

impl Default for Style {
    fn default() -> Self {
        Self { indent: String::new(), column: 0, blank: true, behind: " ".to_owned() }
    }
}

impl Style {
    /// The formatting of `field`.
    fn of(text: &str, field: Option<&Field>) -> Self {
        let Some(field) = field else { return Self::default() };
        let between = &text[field.key.end..field.value.start];
        let (before, behind) = between.split_once('=').unwrap_or((between, ""));
        // Beyond one blank the `=` was put into a column.
        let column = if before.len() > 1 { field.key.len() + before.len() } else { 0 };
        let indent = indent(text, field.key.start).to_owned();
        Self { indent, column, blank: !before.is_empty(), behind: behind.to_owned() }
    }

    fn pair(&self, key: &str, value: &str) -> String {
        let width = self.column.max(key.len() + usize::from(self.blank));
        format!("{key:width$}={}{value}", self.behind)
    }
}

/// Where the line of `at` starts.
fn line_start(text: &str, at: usize) -> usize {
    text[..at].rfind('\n').map_or(0, |end| end + 1)
}

/// Where the line of `at` ends, before its line end.
fn line_end(text: &str, at: usize) -> usize {
    let line = text[at..].split('\n').next().unwrap_or_default();
    at + line.strip_suffix('\r').unwrap_or(line).len()
}

/// Where the line after that of `at` starts, or the end.
fn next_line(text: &str, at: usize) -> usize {
    text[at..].find('\n').map_or(text.len(), |end| at + end + 1)
}

/// The blanks that the line of `at` starts with.
fn indent(text: &str, at: usize) -> &str {
    let line = &text[line_start(text, at)..at];
    &line[..line.len() - line.trim_start_matches([' ', '\t']).len()]
}

fn skip_blanks(text: &str, at: usize) -> usize {
    text.len() - text[at..].trim_start_matches([' ', '\t']).len()
}

fn blanks_before(text: &str, at: usize) -> usize {
    text[..at].trim_end_matches([' ', '\t']).len()
}

/// `span` with the rest of its lines. At the end of a text without a last line end, the line end before it goes.
fn whole_line(text: &str, span: Range<usize>) -> Range<usize> {
    let start = line_start(text, span.start);
    let end = next_line(text, span.end);
    if text[..end].ends_with('\n') || start == 0 {
        return start..end;
    }
    start - newline_before(text, start)..end
}

/// How many bytes the line end before `at` has, if there is one.
fn newline_before(text: &str, at: usize) -> usize {
    let before = &text[..at];
    usize::from(before.ends_with('\n')) + usize::from(before.ends_with("\r\n"))
}

/// `span`, or its whole line if there is nothing else on it.
fn line_if_alone(text: &str, span: Range<usize>) -> Range<usize> {
    let (start, end) = (line_start(text, span.start), next_line(text, span.end));
    let alone = text[start..span.start].trim().is_empty() && text[span.end..end].trim().is_empty();
    if alone && text[..end].ends_with('\n') { start..end } else { span }
}

/// Behind the comment lines that follow the line of `at`, unless they lead up to the next entry's header.
fn end_of_notes(text: &str, at: usize) -> usize {
    let entry = line_end(text, at);
    let mut end = entry;
    let mut next = next_line(text, at);
    while text[next..].trim_start_matches([' ', '\t']).starts_with('#') {
        end = line_end(text, next);
        next = next_line(text, next);
    }
    let blank = text[next..].lines().next().is_none_or(|line| line.trim().is_empty());
    if blank { end } else { entry }
}
