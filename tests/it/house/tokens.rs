//! A Rust file as tokens with line numbers.
//!
//! Owns the parsing, so that comments and strings are no code, and macro bodies are. [`super::sources`] has the rules.
//!
//! Start at [`Token`].

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// One token of a file. A group becomes its opening token, its contents and its closing token.
#[derive(Debug)]
pub(super) struct Token {
    pub(super) text: String,
    /// From 1.
    pub(super) line: usize,
    /// The number of groups around it; an opening and its closing token have the depth outside of their group.
    pub(super) depth: usize,
    /// Whether it is in an item under `#[cfg(test)]`.
    pub(super) in_tests: bool,
}

/// A function with a body: its name, its first line, and its lines from `fn` to the closing brace.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Function {
    pub(super) name: String,
    pub(super) line: usize,
    pub(super) lines: usize,
    /// The number of groups around it: 0 at the top of its file.
    pub(super) depth: usize,
}

/// The tokens of `text`, in order. `path` is named if it is not Rust.
pub(super) fn read(path: &str, text: &str) -> Vec<Token> {
    let stream: TokenStream = text.parse().unwrap_or_else(|error| panic!("`{path}` is not Rust: {error}"));
    let mut tokens = Vec::new();
    flatten(stream, 0, false, &mut tokens);
    tokens
}

fn flatten(stream: TokenStream, depth: usize, in_tests: bool, tokens: &mut Vec<Token>) {
    // From `#[cfg(test)]` to the end of the item that it stands on.
    let mut on_tests = false;
    for tree in stream {
        match &tree {
            TokenTree::Group(group) => {
                let (open, close) = match group.delimiter() {
                    Delimiter::Brace => ("{", "}"),
                    Delimiter::Bracket => ("[", "]"),
                    Delimiter::Parenthesis => ("(", ")"),
                    Delimiter::None => ("", ""),
                };
                on_tests |= open == "[" && group.stream().to_string().replace(' ', "") == "cfg(test)";
                let in_tests = in_tests || on_tests;
                let token = |text: &str, line| Token { text: text.to_owned(), line, depth, in_tests };
                tokens.push(token(open, group.span_open().start().line));
                flatten(group.stream(), depth + 1, in_tests, tokens);
                tokens.push(token(close, group.span_close().start().line));
                on_tests &= open != "{";
            }
            TokenTree::Ident(_) | TokenTree::Literal(_) | TokenTree::Punct(_) => {
                let (text, line) = (tree.to_string(), tree.span().start().line);
                let ends = text == ";";
                tokens.push(Token { text, line, depth, in_tests: in_tests || on_tests });
                on_tests &= !ends;
            }
        }
    }
}

/// Where the tokens read `words` one after the other.
pub(super) fn positions<'a>(tokens: &'a [Token], words: &'a [&str]) -> impl Iterator<Item = &'a Token> {
    let reads = move |window: &&[Token]| window.iter().zip(words).all(|(token, word)| token.text == *word);
    tokens.windows(words.len()).filter(reads).map(|window| &window[0])
}

/// Every function with a body, nested ones and those in macros too.
pub(super) fn functions(tokens: &[Token]) -> Vec<Function> {
    let is_name = |token: &Token| token.text.starts_with(|c: char| c.is_alphabetic() || c == '_');
    let named = tokens.windows(2).enumerate().filter(|(_, pair)| pair[0].text == "fn" && is_name(&pair[1]));
    named.filter_map(|(at, pair)| body(&pair[0], &pair[1], &tokens[at..])).collect()
}

fn body(start: &Token, name: &Token, rest: &[Token]) -> Option<Function> {
    let beside = |token: &&Token| token.depth == start.depth;
    let opened = rest.iter().filter(beside).find(|token| token.text == "{" || token.text == ";")?;
    let closed = rest.iter().filter(beside).find(|token| token.text == "}")?;
    let lines = closed.line - start.line + 1;
    (opened.text == "{").then(|| Function { name: name.text.clone(), line: start.line, lines, depth: start.depth })
}

#[test]
fn a_function_is_measured_from_its_first_line_to_its_last() {
    let text =
        "impl A {\n  fn a(\n    f: fn() -> u8,\n  ) {\n    \"}\";\n  }\n}\ntrait T { fn none(); }\nm! { fn b() {} }";
    let seen = functions(&read("a.rs", text));
    let function = |name: &str, line, lines| Function { name: name.to_owned(), line, lines, depth: 1 };
    assert_eq!(seen, [function("a", 2, 5), function("b", 9, 1)]);
}

#[test]
fn tests_are_told_from_the_code_that_they_test() {
    let tokens =
        read("a.rs", "use a::b; #[cfg(test)] mod tests { fn inside() {} } #[cfg(test)] use c; fn outside() {}");
    let in_tests = |word: &str| tokens.iter().find(|token| token.text == word).unwrap().in_tests;
    assert!(in_tests("inside") && in_tests("c"));
    assert!(!in_tests("b") && !in_tests("outside"));
}
