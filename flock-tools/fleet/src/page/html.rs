//! Text as HTML.
//!
//! Owns the escapes. Never decides what is shown.

/// `text` for content and quoted attributes.
pub(super) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            c => escaped.push(c),
        }
    }
    escaped
}

/// The same, with what stands between backticks as code.
pub(super) fn coded(text: &str) -> String {
    let parts = text.split('`').map(escaped);
    let marked = parts.enumerate().map(|(at, part)| if at % 2 == 1 { format!("<code>{part}</code>") } else { part });
    marked.collect()
}

/// A time that is shown as `ago`, with its date.
pub(super) fn elapsed(date: &str, ago: &str) -> String {
    let date = escaped(date);
    format!("<time datetime=\"{date}\" title=\"{date}\">{}</time>", escaped(ago))
}

#[cfg(test)]
mod tests {
    use super::{coded, escaped};

    #[test]
    fn any_text_is_text_and_nothing_but_text() {
        assert_eq!(escaped("</b a='\"'>&"), "&lt;/b a=&#39;&quot;&#39;&gt;&amp;");
        assert_eq!(coded("set `a<` now"), "set <code>a&lt;</code> now");
    }
}
