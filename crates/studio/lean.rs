//! Takes from the page's code and style what no browser needs: comments, indentation, and spaces between signs.
//!
//! Owns the few rules by which texts, templates and regular expressions are told from code. Line ends stay where one may
//! end a statement. Never renames anything, and never looks into a text.
//!
//! Start at [`lean`].

/// A script without comments and without the spaces that mean nothing. Templates stay as they are.
pub(crate) fn lean(script: &str) -> String {
    let mut out = String::with_capacity(script.len());
    let mut rest = script;
    while let Some(first) = rest.chars().next() {
        let taken = match first {
            '/' if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
            '/' if rest.starts_with("/*") => rest.find("*/").map_or(rest.len(), |end| end + 2),
            ' ' | '\n' => {
                let long = rest.len() - rest.trim_start_matches([' ', '\n']).len();
                separate(&mut out, &rest[..long], rest[long..].chars().next());
                long
            }
            '\'' | '"' => copied(&mut out, rest, quoted(rest, first)),
            '`' => copied(&mut out, rest, template(rest)),
            '/' if begins_expression(&out) => copied(&mut out, rest, regular(rest)),
            _ => copied(&mut out, rest, first.len_utf8()),
        };
        rest = &rest[taken..];
    }
    out
}

fn copied(out: &mut String, rest: &str, long: usize) -> usize {
    out.push_str(&rest[..long]);
    long
}

/// Puts a line end, a space or nothing between what is there and what follows.
fn separate(out: &mut String, space: &str, next: Option<char>) {
    let last = out.chars().next_back();
    let is_word = |sign: Option<char>| sign.is_some_and(|sign| sign.is_alphanumeric() || "_$#".contains(sign));
    if space.contains('\n') {
        let is_open = last.is_none_or(|last| "\n{([,;".contains(last));
        if !is_open && !next.is_some_and(|next| ")]}".contains(next)) {
            out.push('\n');
        }
    } else if is_word(last) && is_word(next) || (last == next && matches!(last, Some('+' | '-'))) {
        out.push(' ');
    }
}

/// Bytes of a text in quotes.
fn quoted(rest: &str, quote: char) -> usize {
    let mut is_escaped = false;
    for (at, sign) in rest.char_indices().skip(1) {
        match sign {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            _ if sign == quote => return at + 1,
            _ => {}
        }
    }
    rest.len()
}

/// Bytes of a template, with all that is in its braces.
fn template(rest: &str) -> usize {
    let mut at = 1;
    while let Some(sign) = rest[at..].chars().next() {
        at += match sign {
            '\\' => 1 + rest[at + 1..].chars().next().map_or(0, char::len_utf8),
            '`' => return at + 1,
            '$' if rest[at + 1..].starts_with('{') => 2 + braced(&rest[at + 2..]),
            _ => sign.len_utf8(),
        };
    }
    rest.len()
}

/// Bytes of code up to the brace that closes it, that brace included.
fn braced(rest: &str) -> usize {
    let (mut at, mut depth) = (0, 1);
    while let Some(sign) = rest[at..].chars().next() {
        at += match sign {
            '\'' | '"' => quoted(&rest[at..], sign),
            '`' => template(&rest[at..]),
            _ => sign.len_utf8(),
        };
        depth += i32::from(sign == '{') - i32::from(sign == '}');
        if depth == 0 {
            return at;
        }
    }
    rest.len()
}

/// Whether a value, not an operator, comes after this.
fn begins_expression(out: &str) -> bool {
    out.trim_end().chars().next_back().is_none_or(|last| "(,=:[!&|?{};>".contains(last))
}

/// Bytes of a regular expression, without its flags.
fn regular(rest: &str) -> usize {
    let (mut is_escaped, mut is_class) = (false, false);
    for (at, sign) in rest.char_indices().skip(1) {
        match sign {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            '[' => is_class = true,
            ']' => is_class = false,
            '/' if !is_class => return at + 1,
            _ => {}
        }
    }
    rest.len()
}

/// A style sheet without comments and without the spaces that mean nothing.
pub(crate) fn lean_style(style: &str) -> String {
    let mut out = String::with_capacity(style.len());
    for (number, part) in style.split("/*").enumerate() {
        let part = if number == 0 { part } else { part.split_once("*/").map_or("", |(_, after)| after) };
        for line in part.lines().map(str::trim).filter(|line| !line.is_empty()) {
            let line = line
                .replace("; ", ";")
                .replace(" { ", "{")
                .replace(" {", "{")
                .replace(" }", "}")
                .replace(": ", ":")
                .replace(", ", ",");
            out.push_str(&line);
            out.push('\n');
        }
    }
    out
}
