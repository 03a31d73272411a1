//! The positions of a manifest's entries in its text.
//!
//! Reads the text as tokens with positions, to find the bytes of each sheep and transition and of their keys and
//! values. The text must be a valid manifest. This is a separate reader, because those of `manifest/mod.rs` do not
//! return the positions of line ends, commas and comments; for a million transitions it keeps only the positions of the
//! entries, 16 MiB.
//!
//! Start at [`Layout::of`]; one entry is read closer by [`fields`].

use std::ops::Range;

use toml_parser::Source;
use toml_parser::lexer::{Token, TokenKind};

use super::Kind;

/// The positions that an edit may need.
#[derive(Debug)]
pub(super) struct Layout {
    sheep: Entries,
    transitions: Entries,
    /// The line end of the file: that of its first line.
    pub(super) newline: &'static str,
}

/// The entries of a kind, in the order of the text.
#[derive(Debug)]
pub(super) struct Entries {
    pub(super) form: Form,
    /// From an entry's `[[` to the end of its last key's line, or from its `{` to its `}`.
    pub(super) spans: Vec<Range<usize>>,
}

/// How the entries of a kind are written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// Not at all.
    Absent,
    /// Each below its own `[[header]]`.
    Headed,
    /// In one array, from its `[` to its `]`.
    Inline(Range<usize>),
}

/// A key and its value, as they stand in an entry.
#[derive(Debug)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) key: Range<usize>,
    pub(super) value: Range<usize>,
    /// The end of the value, or of the comment behind it on the line of an entry with a header.
    pub(super) end: usize,
    /// The comma before the key and the one behind the value, in an entry without a header.
    pub(super) commas: (Option<Range<usize>>, Option<Range<usize>>),
}

impl Layout {
    /// Reads `text`, which is a manifest.
    pub(super) fn of(text: &str) -> Self {
        let entries = || Entries { form: Form::Absent, spans: Vec::new() };
        let first_line_end = text.find('\n').unwrap_or_default();
        let newline = if text[..first_line_end].ends_with('\r') { "\r\n" } else { "\n" };
        let layout = Self { sheep: entries(), transitions: entries(), newline };
        let mut scan = Scan { text, layout, block: None, statement: Statement::Between, depth: 0 };
        Source::new(text).lex().for_each(|token| scan.take(token));
        scan.layout
    }

    /// The entries of `kind`.
    pub(super) fn entries(&self, kind: Kind) -> &Entries {
        match kind {
            Kind::Sheep => &self.sheep,
            Kind::Transition => &self.transitions,
        }
    }

    fn entries_mut(&mut self, kind: Kind) -> &mut Entries {
        match kind {
            Kind::Sheep => &mut self.sheep,
            Kind::Transition => &mut self.transitions,
        }
    }
}

impl Entries {
    /// What stands between the entry at `at` and the next one or the array's end, of entries in an array.
    pub(super) fn gap(&self, at: usize) -> Range<usize> {
        let end = match (&self.form, self.spans.get(at + 1)) {
            (_, Some(next)) => next.start,
            (Form::Inline(array), None) => array.end - 1,
            (Form::Absent | Form::Headed, None) => self.spans[at].end,
        };
        self.spans[at].end..end
    }
}

/// What the scan stands in.
enum Statement {
    /// Nothing: blank lines and comments.
    Between,
    /// `[[...]]`, whose first bracket stands there.
    Header(usize),
    /// `key = value`; the kind if the value is the array of its entries.
    Pair(Option<Kind>),
}

/// A walk over the tokens, in constant memory beside what it finds.
struct Scan<'t> {
    text: &'t str,
    layout: Layout,
    /// Whose header came last.
    block: Option<Kind>,
    statement: Statement,
    /// How many brackets are open.
    depth: usize,
}

impl Scan<'_> {
    fn take(&mut self, token: Token) {
        let (kind, at) = (token.kind(), token.span().start()..token.span().end());
        let opens = matches!(kind, TokenKind::LeftSquareBracket | TokenKind::LeftCurlyBracket);
        let closes = matches!(kind, TokenKind::RightSquareBracket | TokenKind::RightCurlyBracket);
        if matches!(kind, TokenKind::Newline | TokenKind::Eof) && self.depth == 0 {
            self.statement = Statement::Between;
        }
        if matches!(kind, TokenKind::Whitespace | TokenKind::Newline | TokenKind::Eof) {
            return;
        }
        if kind != TokenKind::Comment && matches!(self.statement, Statement::Between) {
            self.begin(token, &at);
        }
        self.depth += usize::from(opens);
        match self.statement {
            Statement::Between => {}
            Statement::Header(start) => self.header(token, start..at.end),
            Statement::Pair(None) => self.extend(at.end),
            Statement::Pair(Some(kind)) => self.array(kind, token, &at),
        }
        self.depth -= usize::from(closes);
    }

    fn begin(&mut self, token: Token, at: &Range<usize>) {
        self.statement = match (token.kind(), self.block) {
            (TokenKind::LeftSquareBracket, _) => {
                self.block = None;
                Statement::Header(at.start)
            }
            (_, Some(_)) => Statement::Pair(None),
            (_, None) => Statement::Pair(Kind::named(&name(self.text, token))),
        };
    }

    /// In a header: its name begins an entry.
    fn header(&mut self, token: Token, so_far: Range<usize>) {
        if let TokenKind::Atom | TokenKind::BasicString | TokenKind::LiteralString = token.kind() {
            self.block = Kind::named(&name(self.text, token));
            if let Some(kind) = self.block {
                let entries = self.layout.entries_mut(kind);
                entries.form = Form::Headed;
                entries.spans.push(so_far);
            }
        } else {
            self.extend(so_far.end);
        }
    }

    /// The entry whose header came last goes on to `end`.
    fn extend(&mut self, end: usize) {
        if let Some(entry) = self.block.and_then(|kind| self.layout.entries_mut(kind).spans.last_mut()) {
            entry.end = end;
        }
    }

    /// In the array of a kind's entries.
    fn array(&mut self, kind: Kind, token: Token, at: &Range<usize>) {
        let entries = self.layout.entries_mut(kind);
        match (token.kind(), self.depth, &mut entries.form) {
            (TokenKind::LeftSquareBracket, 1, form) => *form = Form::Inline(at.clone()),
            (TokenKind::RightSquareBracket, 1, Form::Inline(array)) => array.end = at.end,
            (TokenKind::LeftCurlyBracket, 2, _) => entries.spans.push(at.clone()),
            (TokenKind::RightCurlyBracket, 2, _) => {
                if let Some(entry) = entries.spans.last_mut() {
                    entry.end = at.end;
                }
            }
            _ => {}
        }
    }
}

/// The keys of the entry that stands at `span`, in the order of the text.
pub(super) fn fields(text: &str, span: &Range<usize>) -> Vec<Field> {
    let entry = &text[span.clone()];
    let headed = entry.starts_with('[');
    let mut fields: Vec<Field> = Vec::new();
    let mut comma: Option<Range<usize>> = None;
    // Whether the next word is a key; a header's name is none.
    let mut at_key = !headed;
    for token in Source::new(entry).lex() {
        let at = span.start + token.span().start()..span.start + token.span().end();
        let kind = token.kind();
        if kind == TokenKind::Newline {
            at_key |= headed;
        } else if kind == TokenKind::Comma {
            if let Some(field) = fields.last_mut() {
                field.commas.1 = Some(at.clone());
            }
            (comma, at_key) = (Some(at), true);
        } else if kind == TokenKind::Comment {
            if let Some(field) = fields.last_mut().filter(|_| headed && !at_key) {
                field.end = at.end;
            }
        } else if is_word(kind) && at_key {
            let (name, value, end) = (name(entry, token), at.end..at.end, at.end);
            fields.push(Field { name, key: at, value, end, commas: (comma.take(), None) });
            at_key = false;
        } else if let Some(field) = fields.last_mut().filter(|_| is_word(kind)) {
            let start = if field.value.is_empty() { at.start } else { field.value.start };
            (field.value, field.end) = (start..at.end, at.end);
        }
    }
    fields
}

/// Whether tokens of `kind` make up keys and values; those of a sheep or a transition have no brackets.
fn is_word(kind: TokenKind) -> bool {
    matches!(
        kind,
        TokenKind::Atom
            | TokenKind::Dot
            | TokenKind::BasicString
            | TokenKind::LiteralString
            | TokenKind::MlBasicString
            | TokenKind::MlLiteralString
    )
}

/// The first comma in `gap`, outside comments.
pub(super) fn comma(text: &str, gap: Range<usize>) -> Option<Range<usize>> {
    let mut tokens = Source::new(&text[gap.clone()]).lex();
    let comma = tokens.find(|token| token.kind() == TokenKind::Comma)?;
    Some(gap.start + comma.span().start()..gap.start + comma.span().end())
}

/// What the key in `token` says, without its quotes.
fn name(text: &str, token: Token) -> String {
    let mut name = std::borrow::Cow::Borrowed("");
    if let Some(raw) = Source::new(text).get(token) {
        raw.decode_key(&mut name, &mut ());
    }
    name.into_owned()
}
