//! The page as one file.
//!
//! Owns how the document, the style sheet and the code become one HTML page that loads nothing else and is safe for any name
//! of a flock. Never draws: the code in `sheet/` does, in the browser.
//!
//! Start at [`page`].

use super::facts::Facts;
use super::large_facts::LargeFacts;

/// What is around the sections of every page.
const FRAME: &str = include_str!("sheet/frame.html");
/// The sections of a page.
const MAIN: &str = include_str!("sheet/main.html");
/// Those of a large flock's.
const LARGE_MAIN: &str = include_str!("sheet/large_main.html");
const LOOK: &str = include_str!("sheet/look.css");
/// What the studio's page shares: elements, words for numbers, shares against wants, and the outlines of arrows. They are
/// modules there, which import no others but of these.
const SHARED: [&str; 4] = [
    include_str!("../../../studio/page/elements.js"),
    include_str!("../../../studio/page/words.js"),
    include_str!("../../../studio/page/ratio.js"),
    include_str!("../../../studio/page/arrow.js"),
];
/// In this order; a file uses what those before it define.
const CODE: [&str; 15] = [
    include_str!("sheet/facts.js"),
    include_str!("sheet/ground.js"),
    include_str!("sheet/columns.js"),
    include_str!("sheet/head.js"),
    include_str!("sheet/graph.js"),
    include_str!("sheet/credits.js"),
    include_str!("sheet/panel.js"),
    include_str!("sheet/shares.js"),
    include_str!("sheet/returns.js"),
    include_str!("sheet/day.js"),
    include_str!("sheet/joins.js"),
    include_str!("sheet/table.js"),
    include_str!("sheet/weighing.js"),
    include_str!("sheet/suggested.js"),
    include_str!("sheet/start.js"),
];
/// That of a large flock.
const LARGE_CODE: [&str; 11] = [
    include_str!("sheet/large_facts.js"),
    include_str!("sheet/ground.js"),
    include_str!("sheet/columns.js"),
    include_str!("sheet/head.js"),
    include_str!("sheet/joins.js"),
    include_str!("sheet/credits.js"),
    include_str!("sheet/weighing.js"),
    include_str!("sheet/suggested.js"),
    include_str!("sheet/histogram.js"),
    include_str!("sheet/search.js"),
    include_str!("sheet/large_start.js"),
];

/// The marks in the frame that are replaced, in their order.
const MARKS: [&str; 5] = ["{{title}}", "{{look}}", "{{main}}", "{{facts}}", "{{code}}"];

/// The page that shows `facts`.
/// Errors: What serde says: a number that JSON cannot hold, a bug of ours.
pub(super) fn page(facts: &Facts<'_>) -> serde_json::Result<String> {
    Ok(filled(MAIN, facts.name, &serde_json::to_string(facts)?, script(&CODE)))
}

/// The page that shows `facts` of a large flock.
/// Errors: As [`page`].
pub(super) fn large_page(facts: &LargeFacts<'_>) -> serde_json::Result<String> {
    Ok(filled(LARGE_MAIN, facts.name, &serde_json::to_string(facts)?, script(&LARGE_CODE)))
}

/// The script of a page: what is shared, no longer as modules, then `code`.
fn script(code: &[&str]) -> String {
    let lines = SHARED.iter().flat_map(|module| module.lines()).filter(|line| !line.starts_with("import "));
    let shared: String = lines.flat_map(|line| [line.strip_prefix("export ").unwrap_or(line), "\n"]).collect();
    shared + &code.concat()
}

/// The frame with all of its parts.
fn filled(main: &str, title: &str, document: &str, code: String) -> String {
    // Inside a script element `<` alone could end it; as an escape it is the same text to JSON.
    let parts = [escaped(title), LOOK.to_owned(), main.to_owned(), document.replace('<', "\\u003c"), code];
    let mut page = String::with_capacity(FRAME.len() + parts.iter().map(String::len).sum::<usize>());
    let mut rest = FRAME;
    for (mark, part) in MARKS.iter().zip(&parts) {
        let (before, after) = rest.split_once(mark).expect("the frame has every mark, in this order");
        page.push_str(before);
        page.push_str(part);
        rest = after;
    }
    page.push_str(rest);
    page
}

/// `text` escaped for HTML and XML. Characters that XML cannot hold become U+FFFD.
pub(super) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            '\t' | '\n' | '\r' => escaped.push(' '),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => escaped.push('\u{fffd}'),
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_on_the_page_comes_from_elsewhere() {
        for text in [FRAME, MAIN, LARGE_MAIN, LOOK].into_iter().chain(SHARED).chain(CODE).chain(LARGE_CODE) {
            for word in ["http:", "https:", "//www", "@import", "url(", "fetch(", "XMLHttpRequest"] {
                // The name of SVG's namespace is not loaded, and `url(#` is a place on the page itself.
                let text = text.replace("http://www.w3.org/2000/svg", "").replace("url(#", "");
                assert!(!text.contains(word), "`{word}`");
            }
        }
        assert!(FRAME.contains("default-src 'none'"), "and the browser is told to hold us to it");
    }

    #[test]
    fn the_code_cannot_end_its_own_element_and_builds_no_html_from_text() {
        for code in CODE.into_iter().chain(LARGE_CODE).chain(SHARED) {
            assert!(!code.contains("</script") && !code.contains("<!--"));
            assert!(!code.contains("innerHTML") && !code.contains("outerHTML") && !code.contains("insertAdjacentHTML"));
        }
    }

    #[test]
    fn any_name_is_text_and_nothing_but_text() {
        assert_eq!(escaped("</title><b a='\"'>&\u{1}\n"), "&lt;/title&gt;&lt;b a=&#39;&quot;&#39;&gt;&amp;\u{fffd} ");
    }
}
